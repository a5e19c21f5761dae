//! Mutations for the group `accumulation`.

use super::{
    Mutation,
    Operation::{Replace, Return, Set},
    Place::Shader,
};

const BINARY: &str = "torture_accumulation";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 40,
        mistake: "a batch in one f32 sum",
        place: Shader { module: "kernel/samples", declaration: "SUBTOTAL", operation: Set("SUBTOTAL", "1073741824u") },
        binary: BINARY,
        test: "stagnation::stagnation",
    },
    Mutation {
        case: 41,
        mistake: "pixels numbered within their tile",
        place: Shader {
            module: "kernel/lanes",
            declaration: "pixel_number",
            operation: Return("(pixel.y - pass_info.corner.y) * view.size.x + pixel.x"),
        },
        binary: BINARY,
        test: "split_whole::split_whole_by_tiles",
    },
    Mutation {
        case: 42,
        mistake: "batch numbers of 12 bits",
        place: Shader {
            module: "core/sampler",
            declaration: "sampler_new",
            operation: Replace("replicate", "replicate & 0xfffu"),
        },
        binary: BINARY,
        test: "numbers::index_wrap",
    },
    Mutation {
        case: 43,
        mistake: "a seed that two pixels share",
        place: Shader {
            module: "core/sampler",
            declaration: "sampler_new",
            operation: Replace("hash_u32(pixel)", "hash_u32(pixel >> 1u)"),
        },
        binary: BINARY,
        test: "numbers::correlation",
    },
    Mutation {
        case: 44,
        mistake: "roulette without division",
        place: Shader {
            module: "estimator/vertex",
            declaration: "sample_continuation",
            operation: Set("(*path).throughput", "throughput"),
        },
        binary: BINARY,
        test: "backends::backend_welch",
    },
];
