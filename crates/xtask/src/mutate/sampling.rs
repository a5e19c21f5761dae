//! Mutations for the group `sampling`.

use super::Mutation;

const BINARY: &str = "torture_sampling";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 20,
        mistake: "a pdf of GGX that is 2 % too large",
        file: "shaders/bsdf/ggx.wesl",
        from: "return 0.5 * d / (bound * cos_o + stretch_o);",
        to: "return 0.51 * d / (bound * cos_o + stretch_o);",
        binary: BINARY,
        test: "chi2::chi2_all",
    },
    Mutation {
        case: 21,
        mistake: "MIS weights that add up to 1.02",
        file: "shaders/core/math.wesl",
        from: "return 1.0 / (1.0 + r * r);",
        to: "return 1.02 / (1.0 + r * r);",
        binary: BINARY,
        test: "forms::hemisphere_area_mis",
    },
    Mutation {
        case: 21,
        mistake: "what a path's second vertex emits left out where paths are shared",
        file: "shaders/kernel/blocks.wesl",
        from: "b.own = path.radiance;",
        to: "b.own = vec3f(0.0);",
        binary: BINARY,
        test: "shared_paths::neighbours_agree_about_gloss",
    },
    Mutation {
        case: 21,
        mistake: "weights of shared paths that do not add up to 1",
        file: "shaders/kernel/blocks.wesl",
        from: "b.share0.on *= sees.x / max(on, 1e-37);",
        to: "b.share0.on *= 1.3 * sees.x / max(on, 1e-37);",
        binary: BINARY,
        test: "shared_paths::neighbours_agree_about_gloss",
    },
    Mutation {
        case: 22,
        mistake: "roulette without the division by the chance to go on",
        file: "shaders/estimator/vertex.wesl",
        from: "(*path).throughput = throughput / max(survival, 1e-30);",
        to: "(*path).throughput = throughput;",
        binary: BINARY,
        test: "roulette::rr_on_off",
    },
    Mutation {
        case: 23,
        mistake: "a bounce more than the limit",
        file: "shaders/estimator/vertex.wesl",
        from: "if (bounce >= view.max_bounces) { return false; }",
        to: "if (bounce > view.max_bounces) { return false; }",
        binary: BINARY,
        test: "depth::depth_series",
    },
    Mutation {
        case: 24,
        mistake: "intervals by the normal distribution where Student's is due",
        file: "crates/film/src/precision.rs",
        from: "student_t_quantile(0.5 + 0.5 * confidence, dof.max(1.0))",
        to: "student_t_quantile(0.5 + 0.5 * confidence, dof.max(1e9))",
        binary: BINARY,
        test: "stopping::optional_stop",
    },
    Mutation {
        case: 25,
        mistake: "pairs of batches that share their random numbers",
        file: "shaders/core/sampler.wesl",
        from: "let key = hash_combine(hash_combine(hash_u32(pixel), replicate), seed);",
        to: "let key = hash_combine(hash_combine(hash_u32(pixel), replicate >> 1u), seed);",
        binary: BINARY,
        test: "coverage::replicates",
    },
    Mutation {
        case: 26,
        mistake: "Sobol points in an order that keeps no blocks together",
        file: "shaders/core/sobol.wesl",
        from: "let index = owen_shuffle(point, seed);",
        to: "let index = hash_u32(point ^ seed);",
        binary: BINARY,
        test: "slope::slope",
    },
];
