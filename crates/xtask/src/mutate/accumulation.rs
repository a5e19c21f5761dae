//! Mutations for the group `accumulation`.

use super::Mutation;

const BINARY: &str = "torture_accumulation";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 40,
        mistake: "a batch in one f32 sum",
        file: "shaders/kernel/samples.wesl",
        from: "const SUBTOTAL: u32 = 64u;",
        to: "const SUBTOTAL: u32 = 1073741824u;",
        binary: BINARY,
        test: "stagnation::stagnation",
    },
    Mutation {
        case: 41,
        mistake: "pixels numbered within their tile",
        file: "shaders/kernel/lanes.wesl",
        from: "return pixel.y * view.size.x + pixel.x;",
        to: "return (pixel.y - pass_info.corner.y) * view.size.x + pixel.x;",
        binary: BINARY,
        test: "split_whole::split_whole_by_tiles",
    },
    Mutation {
        case: 42,
        mistake: "batch numbers of 12 bits",
        file: "shaders/core/sampler.wesl",
        from: "hash_combine(hash_u32(pixel), replicate)",
        to: "hash_combine(hash_u32(pixel), replicate & 0xfffu)",
        binary: BINARY,
        test: "numbers::index_wrap",
    },
    Mutation {
        case: 43,
        mistake: "a seed that two pixels share",
        file: "shaders/core/sampler.wesl",
        from: "hash_combine(hash_u32(pixel), replicate)",
        to: "hash_combine(hash_u32(pixel >> 1u), replicate)",
        binary: BINARY,
        test: "numbers::correlation",
    },
    Mutation {
        case: 44,
        mistake: "roulette without division",
        file: "shaders/estimator/vertex.wesl",
        from: "(*path).throughput = throughput / max(survival, 1e-30);",
        to: "(*path).throughput = throughput;",
        binary: BINARY,
        test: "backends::backend_welch",
    },
];
