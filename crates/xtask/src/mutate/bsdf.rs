//! Mutations for the group `bsdf`.

use super::{
    Mutation,
    Operation::{Replace, Set},
    Place::Shader,
};

const BINARY: &str = "torture_bsdf";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 27,
        mistake: "masking by the stretch of one direction for both",
        place: Shader {
            module: "bsdf/ggx",
            declaration: "ggx_v_cos",
            operation: Replace("cos_o * stretch_i", "cos_o * stretch_o"),
        },
        binary: BINARY,
        test: "formula::reciprocity",
    },
    Mutation {
        case: 28,
        mistake: "facets that mask 1 % too little",
        place: Shader {
            module: "bsdf/ggx",
            declaration: "ggx_v_cos",
            operation: Replace("0.5 * cos_i", "0.505 * cos_i"),
        },
        binary: BINARY,
        test: "energy::furnace_ggx",
    },
    Mutation {
        case: 29,
        mistake: "a smooth interface that forgets that radiance changes by η²",
        place: Shader { module: "bsdf/base", declaration: "base_sample", operation: Set("eta2", "1.0") },
        binary: BINARY,
        test: "energy::ggx_mirror",
    },
    Mutation {
        case: 30,
        mistake: "a tenth of the reflection of smooth glass is lost",
        place: Shader {
            module: "bsdf/base",
            declaration: "base_sample",
            operation: Replace("shares.reflected", "0.9 * shares.reflected"),
        },
        binary: BINARY,
        test: "glass::glass_sphere_furnace",
    },
    Mutation {
        case: 31,
        mistake: "one of Fresnel's two polarisations a tenth too strong",
        place: Shader {
            module: "bsdf/fresnel",
            declaration: "fresnel_dielectric",
            operation: Replace("p * p", "1.1 * p * p"),
        },
        binary: BINARY,
        test: "glass::slab",
    },
    Mutation {
        case: 32,
        mistake: "Snell's law with η where η² is due",
        place: Shader { module: "bsdf/fresnel", declaration: "fresnel_g", operation: Replace("eta * eta", "eta") },
        binary: BINARY,
        test: "cone::tir_cone",
    },
    Mutation {
        case: 33,
        mistake: "one random number for the cover of all sheets",
        place: Shader {
            module: "scene/coverage",
            declaration: "is_covered",
            operation: Replace("hash_combine(seed, p.prim)", "seed"),
        },
        binary: BINARY,
        test: "alpha::alpha_64",
    },
    Mutation {
        case: 33,
        mistake: "a volume with alpha that decides anew where a path leaves it",
        place: Shader {
            module: "scene/coverage",
            declaration: "is_covered",
            operation: Replace("select(entered, kept && !entered, front)", "kept"),
        },
        binary: BINARY,
        test: "volumes::alpha_volumes_in_a_furnace",
    },
];
