//! Mutations for the group `geometry`.

use super::{
    Mutation,
    Operation::{Remove, Replace, Return, Set},
    Place::{Shader, Source},
};

const BINARY: &str = "torture_geometry";

pub(super) const ROWS: &[Mutation] = &[
    Mutation {
        case: 9,
        mistake: "edges that are a millionth short",
        place: Shader {
            module: "geometry/triangle_pair",
            declaration: "agree",
            operation: Replace("a >= 0.0 && b >= 0.0 && c >= 0.0", "a >= 1e-7 && b >= 1e-7 && c >= 1e-7"),
        },
        binary: BINARY,
        test: "closed::watertight_inside",
    },
    Mutation {
        case: 10,
        mistake: "rays along an edge hit neither triangle",
        place: Shader {
            module: "geometry/triangle_pair",
            declaration: "agree",
            operation: Return("(a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0)"),
        },
        binary: BINARY,
        test: "traversal::vertex_edge_aim",
    },
    Mutation {
        case: 11,
        mistake: "distances by weighted corners instead of the plane",
        place: Shader {
            module: "geometry/triangle_pair",
            declaration: "intersect_triangle",
            operation: Set(
                "result.t",
                "dot((w.x * v0 + w.y * v1 + w.z * v2) / sum - ray.origin, ray.direction) / dot(ray.direction, ray.direction)",
            ),
        },
        binary: BINARY,
        test: "respawn::respawn",
    },
    Mutation {
        case: 12,
        mistake: "rays offset by a tenth of a millimetre",
        place: Shader { module: "geometry/ray", declaration: "offset_origin", operation: Set("distance", "1e-4") },
        binary: BINARY,
        test: "closed::concentric_4e_5",
    },
    Mutation {
        case: 13,
        mistake: "triangles of less than a square millimetre are missed",
        place: Shader {
            module: "geometry/triangle_pair",
            declaration: "intersect_triangle",
            operation: Replace("result.sum != 0.0", "abs(result.sum) > 1e-6"),
        },
        binary: BINARY,
        test: "traversal::needle",
    },
    Mutation {
        case: 14,
        mistake: "triangles without area are kept",
        place: Source {
            file: "crates/accel/src/triangle.rs",
            from: "if e1.as_dvec3().cross(e2.as_dvec3()) == glam::DVec3::ZERO {",
            to: "if e1.x.is_nan() && e2.x.is_nan() {",
        },
        binary: BINARY,
        test: "defects::degenerate",
    },
    Mutation {
        case: 15,
        mistake: "an eighth of the stack that there should be",
        place: Source {
            file: "crates/prepare/src/blueprint.rs",
            from: "value: self.stack }",
            to: "value: self.stack / 8 }",
        },
        binary: BINARY,
        test: "traversal::same_centroid_1e6",
    },
    Mutation {
        case: 16,
        mistake: "reciprocals of zero",
        place: Shader { module: "geometry/ray", declaration: "reciprocal", operation: Set("safe", "d") },
        binary: BINARY,
        test: "traversal::axis_aligned_rays",
    },
    Mutation {
        case: 17,
        mistake: "shading normals by the matrix itself, not its transposed inverse",
        place: Shader {
            module: "scene/geometry_at",
            declaration: "place",
            operation: Set("(*g).shading_normal", "to_world(to, (*g).shading_normal)"),
        },
        binary: BINARY,
        test: "instances::instance_vs_baked",
    },
    Mutation {
        case: 18,
        mistake: "the triangle hit last wins, not the nearest",
        place: Shader {
            module: "geometry/triangle_pair",
            declaration: "intersect_triangle",
            operation: Replace("t_bits < t_max_bits", "true"),
        },
        binary: BINARY,
        test: "defects::coplanar_twins",
    },
    Mutation {
        case: 19,
        mistake: "shading normals that face away stay so",
        place: Shader {
            module: "scene/surface",
            declaration: "set_frame",
            operation: Replace("facing(normal, (*s).ng, direction)", "normal"),
        },
        binary: BINARY,
        test: "normals::shading_normal_flip",
    },
    Mutation {
        case: 19,
        mistake: "a near plane that is a sphere around the camera",
        place: Shader {
            module: "scene/camera",
            declaration: "near_distance",
            operation: Return("bitcast<f32>(CLIP_NEAR)"),
        },
        binary: BINARY,
        test: "clip::near_plane_perspective",
    },
    Mutation {
        case: 19,
        mistake: "all rays of a path end at the far plane's distance",
        place: Shader { module: "estimator/vertex", declaration: "shade_emission", operation: Remove("(*path).t_max") },
        binary: BINARY,
        test: "clip::cut_surfaces_keep_light_off",
    },
];
