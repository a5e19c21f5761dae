//! Mutations for the group `light`.

use super::{
    Mutation,
    Operation::{Remove, Replace, Return, Set},
    Place::{Shader, Source},
};

const BINARY: &str = "torture_light";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 34,
        mistake: "the pdf of a point on a light without the cosine at the light",
        place: Shader {
            module: "light/light",
            declaration: "sample_area_light",
            operation: Set("s.pdf", "choice.light.weight * view.light_density * distance_squared"),
        },
        binary: BINARY,
        test: "polygon::polygon_irradiance",
    },
    Mutation {
        case: 34,
        mistake: "emitters that light sampling takes as opaque where alpha is below 1",
        place: Shader {
            module: "light/area",
            declaration: "area_radiance",
            operation: Replace(
                "coverage_at(TrianglePoint(light.prim, b.x, b.y))",
                "max(coverage_at(TrianglePoint(light.prim, b.x, b.y)), 1.0)",
            ),
        },
        binary: BINARY,
        test: "emitters::emitters_count_by_coverage",
    },
    Mutation {
        case: 34,
        mistake: "mirrored instances of textured emitters that are sampled as if they were not mirrored",
        place: Shader {
            module: "light/area",
            declaration: "area_barycentrics",
            operation: Replace("weights.yx", "weights"),
        },
        binary: BINARY,
        test: "emitters::estimators_agree_about_emitters_with_alpha",
    },
    Mutation {
        case: 35,
        mistake: "heavy tails that are certified",
        place: Source {
            file: "crates/film/src/tail.rs",
            from: "pub const HEAVY: f32 = 0.5;",
            to: "pub const HEAVY: f32 = 1.5;",
        },
        binary: BINARY,
        test: "contact::contact_light",
    },
    Mutation {
        case: 36,
        mistake: "a map that is turned the wrong way when it is sampled",
        place: Shader {
            module: "light/environment",
            declaration: "environment_sample",
            operation: Set(
                "turn",
                "(f32(column) + u.x) / f32(view.environment_size.x) - 0.5 + view.environment_rotation",
            ),
        },
        binary: BINARY,
        test: "environment::one_hot_texel",
    },
    Mutation {
        case: 36,
        mistake: "panes that absorb none of the backdrop",
        place: Shader {
            module: "estimator/vertex",
            declaration: "uncovered_share",
            operation: Replace("luminance(path.throughput)", "1.0"),
        },
        binary: BINARY,
        test: "transparent::over_its_sky_it_is_the_whole_picture",
    },
    Mutation {
        case: 36,
        mistake: "coverage of a subtotal that is added again with the next",
        place: Shader { module: "kernel/samples", declaration: "add_subtotal", operation: Remove("(*total).covered") },
        binary: BINARY,
        test: "transparent::coverage_is_the_area_of_a_pixel",
    },
    Mutation {
        case: 36,
        mistake: "a primary ray that leaves the scene uncovers all four pixels of a square",
        place: Shader {
            module: "kernel/path_reuse",
            declaration: "end_path",
            operation: Replace("select(vec4f(0.0), vec4f((*path).uncovered), owner)", "vec4f((*path).uncovered)"),
        },
        binary: BINARY,
        test: "transparent::coverage_is_the_area_of_a_pixel",
    },
    Mutation {
        case: 37,
        mistake: "the last light of the table is never drawn",
        place: Shader {
            module: "light/light",
            declaration: "light_sample",
            operation: Set("slot", "mul_high(choice, max(view.light_count, 2u) - 1u)"),
        },
        binary: BINARY,
        test: "linearity::linearity",
    },
    Mutation {
        case: 38,
        mistake: "a path that has passed a pane forgets the pdf of its last scattering",
        place: Shader {
            module: "estimator/vertex",
            declaration: "sample_continuation",
            operation: Set("(*path).pdf", "select(next.pdf, 0.0, next.delta)"),
        },
        binary: BINARY,
        test: "panes::estimators_agree_through_panes",
    },
    Mutation {
        case: 38,
        mistake: "shadow rays that lose no light to panes",
        place: Shader {
            module: "bsdf/bsdf",
            declaration: "bsdf_straight",
            operation: Replace("base_shares(b, wo.z).transmitted", "vec3f(1.0)"),
        },
        binary: BINARY,
        test: "panes::transmittance",
    },
    Mutation {
        case: 38,
        mistake: "light that goes through glass counted as light that is scattered",
        place: Source {
            file: "crates/prepare/src/light_flow/follow.rs",
            from: "if aimed == (events > 0) { scattered }",
            to: "if !aimed { scattered }",
        },
        binary: BINARY,
        test: "unreachable::sds",
    },
    Mutation {
        case: 38,
        mistake: "paths keep the light that particles carry",
        place: Shader {
            module: "estimator/mis",
            declaration: "emission_weight",
            operation: Replace("emits_particles(s)", "!emits_particles(s)"),
        },
        binary: BINARY,
        test: "caustics::as_by_chance",
    },
    Mutation {
        case: 38,
        mistake: "particles' flux by the geometric normal where the shading normal bends them",
        place: Shader {
            module: "kernel/light_tracing",
            declaration: "scatter_particle",
            operation: Replace(
                "next.weight * abs(a.z * cos_v / max(abs(next.wi.z * dot(s.ng, l)), 1e-12))",
                "next.weight",
            ),
        },
        binary: BINARY,
        test: "caustics::as_by_chance",
    },
    Mutation {
        case: 38,
        mistake: "a particle's pdf by the one caster that it was sent to",
        place: Shader {
            module: "light/emission",
            declaration: "aim_sample",
            operation: Replace("(member && h_other > 0.0) || k == chosen", "k == chosen"),
        },
        binary: BINARY,
        test: "caustics::as_by_chance",
    },
    Mutation {
        case: 38,
        mistake: "flux divided by η² like radiance",
        place: Shader {
            module: "kernel/light_tracing",
            declaration: "flux_per_radiance",
            operation: Replace("s.bsdf.eta * s.bsdf.eta", "1.0"),
        },
        binary: BINARY,
        test: "caustics::closed_forms",
    },
    Mutation {
        case: 39,
        mistake: "Schlick's weight to the fourth power",
        place: Shader { module: "bsdf/fresnel", declaration: "fresnel_schlick_weight", operation: Return("x2 * x2") },
        binary: BINARY,
        test: "corridor::mirror_corridor",
    },
];
