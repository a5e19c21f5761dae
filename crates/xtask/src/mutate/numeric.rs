//! Mutations for the group `numeric`.

use super::{
    Mutation,
    Operation::{Replace, Return, Set},
    Place::{Shader, Source},
};

const BINARY: &str = "torture_numeric";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 1,
        mistake: "an albedo that is a millionth too large",
        place: Shader {
            module: "bsdf/bsdf",
            declaration: "bsdf_sample",
            operation: Replace(
                "BsdfSample(wi, b.base_color, lambert_pdf_solid_angle(wi), false, true)",
                "BsdfSample(wi, 1.000001 * b.base_color, lambert_pdf_solid_angle(wi), false, true)",
            ),
        },
        binary: BINARY,
        test: "furnace::zero_variance_furnace",
    },
    Mutation {
        case: 2,
        mistake: "samples clamped at 10",
        place: Shader {
            module: "kernel/samples",
            declaration: "add_sample",
            operation: Replace("radiance", "min(radiance, vec3f(10.0))"),
        },
        binary: BINARY,
        test: "scales::scale_emission",
    },
    Mutation {
        case: 3,
        mistake: "shadow rays that end a tenth of a millimetre short",
        place: Shader {
            module: "estimator/next_event",
            declaration: "connect_light",
            operation: Replace("distance * SHORT_OF_TARGET", "distance - 1e-4"),
        },
        binary: BINARY,
        test: "scales::scale_geometry",
    },
    Mutation {
        case: 4,
        mistake: "the scene's origin instead of the camera's",
        place: Source {
            file: "crates/prepare/src/prepared.rs",
            from: "Accel::build(scene, camera.to_world.translation, &settings.build)",
            to: "Accel::build(scene, camera.to_world.translation * 0.0, &settings.build)",
        },
        binary: BINARY,
        test: "far_origin::far_origin",
    },
    Mutation {
        case: 5,
        mistake: "lights nearer than a micrometre taken for as far",
        place: Shader {
            module: "light/light",
            declaration: "sample_area_light",
            operation: Set("distance_squared", "max(dot(to_light, to_light), 1e-12)"),
        },
        binary: BINARY,
        test: "scales::tiny_scene",
    },
    Mutation {
        case: 6,
        mistake: "random numbers that may be 1",
        place: Shader {
            module: "core/hash",
            declaration: "unit_from_bits",
            operation: Return("f32(bits) * 2.3283064365386963e-10"),
        },
        binary: BINARY,
        test: "endpoints::u_endpoints",
    },
    Mutation {
        case: 7,
        mistake: "Schlick's fifth power by `pow`, which knows no negative base",
        place: Shader {
            module: "bsdf/fresnel",
            declaration: "fresnel_schlick_weight",
            operation: Return("pow(1.0 - cosine, 5.0)"),
        },
        binary: BINARY,
        test: "endpoints::dot_above_one",
    },
    Mutation {
        case: 8,
        mistake: "samples that are not finite are kept",
        place: Shader {
            module: "kernel/samples",
            declaration: "add_sample",
            operation: Replace("select(vec3f(0.0), sample, good)", "sample"),
        },
        binary: BINARY,
        test: "quarantine::nan_quarantine",
    },
];
