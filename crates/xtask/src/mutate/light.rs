//! Mutations for the group `light`.

use super::Mutation;

const BINARY: &str = "torture_light";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 34,
        mistake: "the pdf of a point on a light without the cosine at the light",
        file: "shaders/light/light.wesl",
        from: "result.pdf = s.weight * view.light_density * distance_squared / max(abs(cosine), 1e-12);",
        to: "result.pdf = s.weight * view.light_density * distance_squared;",
        binary: BINARY,
        test: "polygon::polygon_irradiance",
    },
    Mutation {
        case: 35,
        mistake: "heavy tails that are certified",
        file: "crates/film/src/tail.rs",
        from: "pub const HEAVY: f32 = 0.5;",
        to: "pub const HEAVY: f32 = 1.5;",
        binary: BINARY,
        test: "contact::contact_light",
    },
    Mutation {
        case: 36,
        mistake: "a map that is turned the wrong way when it is sampled",
        file: "shaders/light/environment.wesl",
        from: "- 0.5 - view.environment_rotation;",
        to: "- 0.5 + view.environment_rotation;",
        binary: BINARY,
        test: "environment::one_hot_texel",
    },
    Mutation {
        case: 37,
        mistake: "the last light of the table is never drawn",
        file: "shaders/light/light.wesl",
        from: "let slot = mul_high(choice, view.light_count);",
        to: "let slot = mul_high(choice, max(view.light_count, 2u) - 1u);",
        binary: BINARY,
        test: "linearity::linearity",
    },
    Mutation {
        case: 38,
        mistake: "light that goes through glass counted as light that is scattered",
        file: "crates/render/src/prepare/unreachable.rs",
        from: "specular += weight * share;",
        to: "specular += 0.0 * weight * share;",
        binary: BINARY,
        test: "unreachable::sds",
    },
    Mutation {
        case: 39,
        mistake: "Schlick's weight to the fourth power",
        file: "shaders/bsdf/fresnel.wgsl",
        from: "return x2 * x2 * x;",
        to: "return x2 * x2;",
        binary: BINARY,
        test: "corridor::mirror_corridor",
    },
];
