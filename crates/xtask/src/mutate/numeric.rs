//! Mutations for the group `numeric`.

use super::Mutation;

const BINARY: &str = "torture_numeric";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 1,
        mistake: "an albedo that is a millionth too large",
        file: "shaders/bsdf/bsdf.wesl",
        from: "return BsdfSample(wi, b.base_color, lambert_pdf_solid_angle(wi), false, true);",
        to: "return BsdfSample(wi, 1.000001 * b.base_color, lambert_pdf_solid_angle(wi), false, true);",
        binary: BINARY,
        test: "furnace::zero_variance_furnace",
    },
    Mutation {
        case: 2,
        mistake: "samples clamped at 10",
        file: "shaders/kernel/samples.wesl",
        from: "let good = all_finite(sample);",
        to: "sample = min(sample, vec3f(10.0)); let good = all_finite(sample);",
        binary: BINARY,
        test: "scales::scale_emission",
    },
    Mutation {
        case: 3,
        mistake: "shadow rays that end a tenth of a millimetre short",
        file: "shaders/estimator/vertex.wesl",
        from: "select(FAR, distance * SHORT_OF_TARGET, near)",
        to: "select(FAR, distance - 1e-4, near)",
        binary: BINARY,
        test: "scales::scale_geometry",
    },
    Mutation {
        case: 4,
        mistake: "the scene's origin instead of the camera's",
        file: "crates/prepare/src/prepared.rs",
        from: "Accel::build(scene, camera.to_world.translation, &settings.build)",
        to: "Accel::build(scene, camera.to_world.translation * 0.0, &settings.build)",
        binary: BINARY,
        test: "far_origin::far_origin",
    },
    Mutation {
        case: 5,
        mistake: "lights nearer than a micrometre taken for as far",
        file: "shaders/light/light.wesl",
        from: "let distance_squared = max(dot(to_light, to_light), 1e-30);",
        to: "let distance_squared = max(dot(to_light, to_light), 1e-12);",
        binary: BINARY,
        test: "scales::tiny_scene",
    },
    Mutation {
        case: 6,
        mistake: "random numbers that may be 1",
        file: "shaders/core/hash.wgsl",
        from: "return f32(bits >> 8u) * 5.9604644775390625e-8;",
        to: "return f32(bits) * 2.3283064365386963e-10;",
        binary: BINARY,
        test: "endpoints::u_endpoints",
    },
    Mutation {
        case: 7,
        mistake: "Schlick's fifth power by `pow`, which knows no negative base",
        file: "shaders/bsdf/fresnel.wgsl",
        from: "let x = clamp(1.0 - cosine, 0.0, 1.0);\n    let x2 = x * x;\n    return x2 * x2 * x;",
        to: "return pow(1.0 - cosine, 5.0);",
        binary: BINARY,
        test: "endpoints::dot_above_one",
    },
    Mutation {
        case: 8,
        mistake: "samples that are not finite are kept",
        file: "shaders/kernel/samples.wesl",
        from: "sample = select(vec3f(0.0), sample, good);",
        to: "sample = select(sample, sample, good);",
        binary: BINARY,
        test: "quarantine::nan_quarantine",
    },
];
