//! Mutations for the group `sampling`.

use super::{
    Mutation,
    Operation::{Replace, Return, Set},
    Place::{Shader, Source},
};

const BINARY: &str = "torture_sampling";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 20,
        mistake: "a pdf of GGX that is 2 % too large",
        place: Shader {
            module: "bsdf/ggx",
            declaration: "ggx_pdf_solid_angle",
            operation: Return("0.51 * d / (bound * cos_o + stretch_o)"),
        },
        binary: BINARY,
        test: "chi2::chi2_all",
    },
    Mutation {
        case: 21,
        mistake: "MIS weights that add up to 1.02",
        place: Shader { module: "core/math", declaration: "mis_weight", operation: Return("1.02 / (1.0 + r * r)") },
        binary: BINARY,
        test: "forms::hemisphere_area_mis",
    },
    Mutation {
        case: 21,
        mistake: "emission of second vertices is dropped with path reuse",
        place: Shader {
            module: "kernel/path_reuse",
            declaration: "trace_paths",
            operation: Set("reuse.own", "vec3f(0.0)"),
        },
        binary: BINARY,
        test: "path_reuse::neighbours_agree_about_gloss",
    },
    Mutation {
        case: 21,
        mistake: "weights of path reuse that do not add up to 1",
        place: Shader {
            module: "kernel/path_reuse",
            declaration: "weigh_reuses",
            operation: Replace(
                "visible / max(onward, 1e-37)",
                "vec4f(1.3, 1.0, 1.0, 1.0) * visible / max(onward, 1e-37)",
            ),
        },
        binary: BINARY,
        test: "path_reuse::neighbours_agree_about_gloss",
    },
    Mutation {
        case: 21,
        mistake: "adaptive pixels' sums are taken for those of as many samples as all have",
        place: Source {
            file: "crates/render/src/accumulator.rs",
            from: "map_or(samples, |shares| shares.samples([x, y], samples));",
            to: "map_or(samples, |_| samples);",
        },
        binary: BINARY,
        test: "adaptive::blocks_are_pictures_of_their_own_samples",
    },
    Mutation {
        case: 22,
        mistake: "Russian roulette without the division by the probability of survival",
        place: Shader {
            module: "estimator/vertex",
            declaration: "sample_continuation",
            operation: Set("(*path).throughput", "throughput"),
        },
        binary: BINARY,
        test: "roulette::rr_on_off",
    },
    Mutation {
        case: 23,
        mistake: "a bounce more than the limit",
        place: Shader {
            module: "estimator/vertex",
            declaration: "sample_continuation",
            operation: Set("may_scatter", "bounce <= view.max_bounces"),
        },
        binary: BINARY,
        test: "depth::depth_series",
    },
    Mutation {
        case: 24,
        mistake: "intervals by the normal distribution where Student's is due",
        place: Source {
            file: "crates/film/src/precision.rs",
            from: "student_t_quantile(0.5 + 0.5 * confidence, dof.max(1.0))",
            to: "student_t_quantile(0.5 + 0.5 * confidence, dof.max(1e9))",
        },
        binary: BINARY,
        test: "stopping::optional_stop",
    },
    Mutation {
        case: 25,
        mistake: "pairs of batches that share their random numbers",
        place: Shader {
            module: "core/sampler",
            declaration: "sampler_new",
            operation: Replace("replicate", "replicate >> 1u"),
        },
        binary: BINARY,
        test: "coverage::replicates",
    },
    Mutation {
        case: 26,
        mistake: "Sobol points in an order that keeps no blocks together",
        place: Shader {
            module: "core/sobol",
            declaration: "sobol_2d_bits",
            operation: Set("index", "hash_u32(point ^ seed)"),
        },
        binary: BINARY,
        test: "slope::slope",
    },
];
