//! Mutations for the group `bsdf`.

use super::Mutation;

const BINARY: &str = "torture_bsdf";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 27,
        mistake: "masking by the stretch of one direction for both",
        file: "shaders/bsdf/ggx.wesl",
        from: "max(cos_i * stretch_o + cos_o * stretch_i, 1e-30)",
        to: "max(cos_i * stretch_o + cos_o * stretch_o, 1e-30)",
        binary: BINARY,
        test: "formula::reciprocity",
    },
    Mutation {
        case: 28,
        mistake: "facets that mask 1 % too little",
        file: "shaders/bsdf/ggx.wesl",
        from: "return 0.5 * cos_i / max(",
        to: "return 0.505 * cos_i / max(",
        binary: BINARY,
        test: "energy::furnace_ggx",
    },
    Mutation {
        case: 29,
        mistake: "a smooth interface that forgets that radiance changes by η²",
        file: "shaders/bsdf/base.wesl",
        from: "let eta2 = select(b.eta * b.eta, 1.0, b.thin == 1u);",
        to: "let eta2 = 1.0;",
        binary: BINARY,
        test: "energy::ggx_mirror",
    },
    Mutation {
        case: 30,
        mistake: "a tenth of what smooth glass reflects is lost",
        file: "shaders/bsdf/base.wesl",
        from: "let share = select(shares.reflected, shares.transmitted / eta2, beyond);",
        to: "let share = select(0.9 * shares.reflected, shares.transmitted / eta2, beyond);",
        binary: BINARY,
        test: "glass::glass_sphere_furnace",
    },
    Mutation {
        case: 31,
        mistake: "one of Fresnel's two polarisations a tenth too strong",
        file: "shaders/bsdf/fresnel.wgsl",
        from: "return 0.5 * (s * s + p * p);",
        to: "return 0.5 * (s * s + 1.1 * p * p);",
        binary: BINARY,
        test: "glass::slab",
    },
    Mutation {
        case: 32,
        mistake: "Snell's law with η where η² is due",
        file: "shaders/bsdf/fresnel.wgsl",
        from: "return sqrt(max(eta * eta - 1.0 + cosine * cosine, 0.0));",
        to: "return sqrt(max(eta - 1.0 + cosine * cosine, 0.0));",
        binary: BINARY,
        test: "cone::tir_cone",
    },
    Mutation {
        case: 33,
        mistake: "one random number for the cover of all sheets",
        file: "shaders/scene/coverage.wesl",
        from: "unit_from_bits(hash_combine(seed, prim))",
        to: "unit_from_bits(seed)",
        binary: BINARY,
        test: "alpha::alpha_64",
    },
    Mutation {
        case: 33,
        mistake: "a volume with alpha that decides anew where a path leaves it",
        file: "shaders/scene/coverage.wesl",
        from: "return select(entered, kept && !entered, front);",
        to: "return kept;",
        binary: BINARY,
        test: "volumes::alpha_volumes_in_a_furnace",
    },
];
