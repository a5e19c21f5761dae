//! Primitives: modes, indices, normals, tangents, coordinate sets.

use glam::{Vec2, Vec3, Vec4};
use serde_json::json;
use surelight_scene::Mesh;

use crate::build::{FLOAT, Gltf, SQUARE, USHORT, floats, shorts, warned};

#[test]
fn strips_and_fans_make_triangles_that_face_one_way() {
    // Five corners of a strip, zigzag; the third coordinate of every cross product must be
    // positive.
    let strip = [0., 0., 0., 1., 0., 0., 0., 1., 0., 1., 1., 0., 0., 2., 0.];
    let fan = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0., -1., 1., 0.];
    for (points, mode) in [(strip, 5), (fan, 6)] {
        for indexed in [false, true] {
            let mut gltf = Gltf::triangle();
            let positions = gltf.accessor(&floats(&points), FLOAT, "VEC3", 5);
            *gltf.primitive() = json!({"attributes": {"POSITION": positions}, "mode": mode});
            if indexed {
                let indices = gltf.accessor(&shorts(&[0, 1, 2, 3, 4]), USHORT, "SCALAR", 5);
                gltf.primitive()["indices"] = json!(indices);
            }
            let mesh = gltf.load().meshes.remove(0);
            assert_eq!(mesh.triangles.len(), 3);
            for triangle in &mesh.triangles {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
                assert!((b - a).cross(c - a).z > 0.0, "mode {mode}: {triangle:?}");
            }
        }
    }
}

#[test]
fn stitches_of_strips_are_dropped() {
    let mut gltf = Gltf::square();
    let indices = gltf.accessor(&shorts(&[0, 1, 2, 2, 0, 3]), USHORT, "SCALAR", 6);
    gltf.primitive()["indices"] = json!(indices);
    gltf.primitive()["mode"] = json!(5);
    assert_eq!(gltf.load().meshes[0].triangles, [[0, 1, 2], [2, 3, 0]]);
}

#[test]
fn points_and_lines_are_one_warning() {
    let mut gltf = Gltf::triangle();
    let primitive = gltf.primitive().clone();
    for mode in 0..4 {
        let mut thin = primitive.clone();
        thin["mode"] = json!(mode);
        gltf.json["meshes"][0]["primitives"].as_array_mut().expect("array").push(thin);
    }
    let scene = gltf.load();
    assert_eq!(scene.triangle_count(), 1);
    warned(&scene, "Points and lines");
    gltf.primitive()["mode"] = json!(7);
    gltf.refused(&["mesh 0, primitive 0", "mode 7"]);
}

#[test]
fn left_over_corners_are_reported() {
    let mut gltf = Gltf::square();
    gltf.primitive().as_object_mut().expect("object").remove("indices");
    let scene = gltf.load();
    assert_eq!(scene.triangle_count(), 1);
    warned(&scene, "1 corner at the end of mesh 0, primitive 0");
}

#[test]
fn indices_out_of_range_are_refused() {
    let mut gltf = Gltf::square();
    let indices = gltf.accessor(&shorts(&[0, 1, 2, 0, 2, 65535]), USHORT, "SCALAR", 6);
    gltf.primitive()["indices"] = json!(indices);
    gltf.refused(&["mesh 0, primitive 0", "index 65535 at place 5", "its vertices are 4"]);
}

#[test]
fn a_shared_vertex_array_is_cut_to_what_a_primitive_uses() {
    let mut gltf = Gltf::triangle();
    let points: Vec<f32> = (0..3000).map(|i| i as f32).collect();
    let positions = gltf.accessor(&floats(&points), FLOAT, "VEC3", 1000);
    let normals =
        gltf.accessor(&floats(&points[1..].iter().chain([&0.0]).copied().collect::<Vec<_>>()), FLOAT, "VEC3", 1000);
    let indices = gltf.accessor(&shorts(&[900, 7, 500, 7, 900, 999]), USHORT, "SCALAR", 6);
    *gltf.primitive() = json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices});
    let mesh = gltf.load().meshes.remove(0);
    assert_eq!(mesh.triangles, [[2, 0, 1], [0, 2, 3]]);
    assert_eq!(mesh.positions.iter().map(|p| p.x).collect::<Vec<_>>(), [21., 1500., 2700., 2997.]);
    let normal = mesh.normals.expect("normals")[1];
    assert!((normal - Vec3::new(1501., 1502., 1503.).normalize()).length() < 1e-6);
}

#[test]
fn normals_are_made_unit_vectors() {
    let mut gltf = Gltf::square();
    let long = [0., 0., 2., 3e-30, 0., 0., 0., 3e30, 0., 0., 0.6, 0.8];
    let normals = gltf.accessor(&floats(&long), FLOAT, "VEC3", 4);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    let scene = gltf.load();
    assert_eq!(scene.meshes[0].normals, Some(vec![Vec3::Z, Vec3::X, Vec3::Y, Vec3::new(0.0, 0.6, 0.8)]));
    assert!(scene.warnings.is_empty());
}

#[test]
fn unusable_normals_come_from_the_triangles_around() {
    let mut gltf = Gltf::square();
    let some = [1., 0., 0., 0., 0., 0., f32::NAN, 0., 0., 1., 0., f32::INFINITY];
    let normals = gltf.accessor(&floats(&some), FLOAT, "VEC3", 4);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    let scene = gltf.load();
    assert_eq!(scene.meshes[0].normals, Some(vec![Vec3::X, Vec3::Z, Vec3::Z, Vec3::Z]));
    warned(&scene, "3 normals of mesh 0, primitive 0");

    let normals = gltf.accessor(&floats(&[0.0; 12]), FLOAT, "VEC3", 4);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    let scene = gltf.load();
    assert_eq!(scene.meshes[0].normals, None);
    warned(&scene, "shaded flat");
}

#[test]
fn without_normals_a_mesh_is_flat() {
    assert_eq!(Gltf::triangle().load().meshes[0].normals, None);
}

/// The square with a normal map, after `edit`.
fn with_normal_map(edit: impl Fn(&mut Gltf)) -> (Mesh, Vec<String>) {
    let mut gltf = Gltf::square();
    let texture = gltf.texture();
    let mut gltf = gltf.material(json!({"normalTexture": {"index": texture, "scale": 0.5}}));
    edit(&mut gltf);
    let mut scene = gltf.load();
    (scene.meshes.remove(0), scene.warnings)
}

#[test]
fn tangents_are_made_where_a_normal_map_needs_them() {
    assert_eq!(Gltf::square().load().meshes[0].tangents, None);
    // u along +x, v down along −y: the tangent is +x, and the bitangent cross(n, t) · w must be up,
    // +y.
    let (mesh, warnings) = with_normal_map(|_| {});
    assert_eq!(mesh.tangents, Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(warnings.is_empty());
}

#[test]
fn mirrored_coordinates_turn_the_sign() {
    let (mesh, _) = with_normal_map(|gltf| {
        let uvs = gltf.accessor(&floats(&[1., 1., 0., 1., 0., 0., 1., 0.]), FLOAT, "VEC2", 4);
        gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    });
    assert_eq!(mesh.tangents, Some(vec![Vec4::new(-1.0, 0.0, 0.0, -1.0); 4]));
}

#[test]
fn a_turned_texture_turns_the_tangents() {
    // uv′ = (−v, u): u′ grows upwards and v′ grows to the right, so the tangent is +y and "up" in
    // the map is −x.
    let (mesh, _) = with_normal_map(|gltf| {
        let transform = json!({"KHR_texture_transform": {"rotation": -std::f64::consts::FRAC_PI_2}});
        gltf.json["materials"][0]["normalTexture"]["extensions"] = transform;
    });
    for tangent in mesh.tangents.expect("tangents") {
        let bitangent = Vec3::Z.cross(tangent.truncate()) * tangent.w;
        assert!((tangent.truncate() - Vec3::Y).length() < 1e-6 && (bitangent + Vec3::X).length() < 1e-6, "{tangent}");
    }
}

#[test]
fn vertices_split_where_tangents_differ() {
    // The right half mirrors the left: the shared edge needs two tangents per vertex.
    let mut gltf = Gltf::triangle();
    let points = [-1., 0., 0., 0., 0., 0., 0., 1., 0., -1., 1., 0., 1., 0., 0., 1., 1., 0.];
    let positions = gltf.accessor(&floats(&points), FLOAT, "VEC3", 6);
    let normals = gltf.accessor(&floats(&[0., 0., 1.].repeat(6)), FLOAT, "VEC3", 6);
    let uvs = gltf.accessor(&floats(&[0., 1., 1., 1., 1., 0., 0., 0., 0., 1., 0., 0.]), FLOAT, "VEC2", 6);
    let indices = gltf.accessor(&shorts(&[0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2]), USHORT, "SCALAR", 12);
    *gltf.primitive() = json!({
        "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs}, "indices": indices,
    });
    let texture = gltf.texture();
    let mesh = gltf.material(json!({"normalTexture": {"index": texture}})).load().meshes.remove(0);
    assert_eq!(mesh.positions.len(), 8);
    let tangents = mesh.tangents.as_ref().expect("tangents");
    for triangle in &mesh.triangles {
        let left = triangle.iter().any(|&i| mesh.positions[i as usize].x < 0.0);
        for &i in triangle {
            assert_eq!(
                tangents[i as usize],
                if left { Vec4::new(1., 0., 0., 1.) } else { Vec4::new(-1., 0., 0., -1.) }
            );
            // Split vertices are otherwise the same.
            assert_eq!(mesh.uvs[0][i as usize].x, 1.0 - mesh.positions[i as usize].x.abs());
        }
    }
    assert_eq!(mesh.normals.as_ref().map(Vec::len), Some(8));
}

#[test]
fn the_tangents_of_the_file_are_kept() {
    let (mesh, warnings) = with_normal_map(|gltf| {
        let tangents = gltf.accessor(&floats(&[0., 2., 0., -1.].repeat(4)), FLOAT, "VEC4", 4);
        gltf.primitive()["attributes"]["TANGENT"] = json!(tangents);
    });
    assert_eq!(mesh.tangents, Some(vec![Vec4::new(0.0, 1.0, 0.0, -1.0); 4]));
    assert!(warnings.is_empty());
}

#[test]
fn unusable_tangents_are_made_anew() {
    for bad in [[0., 0., 0., 1.], [1., 0., 0., 0.], [f32::NAN, 0., 0., 1.], [1., 0., 0., f32::NAN]] {
        let (mesh, warnings) = with_normal_map(|gltf| {
            let tangents = gltf.accessor(&floats(&bad.repeat(4)), FLOAT, "VEC4", 4);
            gltf.primitive()["attributes"]["TANGENT"] = json!(tangents);
        });
        assert_eq!(mesh.tangents, Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]));
        assert!(warnings[0].contains("MikkTSpace"), "{warnings:?}");
    }
}

#[test]
fn without_normals_the_tangents_of_the_file_are_ignored() {
    let (mesh, _) = with_normal_map(|gltf| {
        let tangents = gltf.accessor(&floats(&[0., 1., 0., 1.].repeat(4)), FLOAT, "VEC4", 4);
        gltf.primitive()["attributes"]["TANGENT"] = json!(tangents);
        gltf.primitive()["attributes"].as_object_mut().expect("object").remove("NORMAL");
    });
    assert_eq!(mesh.normals, None);
    assert!(mesh.tangents.expect("tangents").iter().all(|t| *t == Vec4::new(1.0, 0.0, 0.0, 1.0)));
}

#[test]
fn tangents_survive_broken_geometry() {
    for points in [
        [f32::NAN; 12],
        [f32::INFINITY; 12],
        [0.0; 12],
        [1e38, -1e38, 1e38, 0., 0., 0., 1e-38, 0., 0., 3e38, 3e38, 0.],
        SQUARE.map(|p| if p == 1.0 { f32::NAN } else { p }),
    ] {
        for flat in [false, true] {
            let (mesh, _) = with_normal_map(|gltf| {
                let positions = gltf.accessor(&floats(&points), FLOAT, "VEC3", 4);
                gltf.primitive()["attributes"]["POSITION"] = json!(positions);
                if flat {
                    gltf.primitive()["attributes"].as_object_mut().expect("object").remove("NORMAL");
                }
            });
            let tangents = mesh.tangents.expect("tangents");
            assert!(tangents.iter().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0), "{tangents:?}");
            assert_eq!(tangents.len(), mesh.positions.len());
        }
    }
}

#[test]
fn only_the_coordinate_sets_of_the_material_are_kept() {
    let mut gltf = Gltf::square();
    assert!(gltf.load().meshes[0].uvs.is_empty());
    let uv1 = gltf.accessor(&floats(&[0.25; 8]), FLOAT, "VEC2", 4);
    let uv2 = gltf.accessor(&floats(&[0.5; 8]), FLOAT, "VEC2", 4);
    gltf.primitive()["attributes"]["TEXCOORD_1"] = json!(uv1);
    gltf.primitive()["attributes"]["TEXCOORD_2"] = json!(uv2);
    let texture = gltf.texture();
    let gltf = gltf.material(json!({"emissiveTexture": {"index": texture, "texCoord": 1}}));
    let scene = gltf.load();
    assert_eq!(scene.meshes[0].uvs.len(), 2);
    assert_eq!(scene.meshes[0].uvs[1], vec![Vec2::splat(0.25); 4]);
    assert_eq!(scene.materials[0].emissive_texture.as_ref().map(|t| t.uv_set), Some(1));
}

#[test]
fn a_missing_coordinate_set_is_zero_with_a_warning() {
    let mut gltf = Gltf::square();
    let texture = gltf.texture();
    let gltf = gltf.material(json!({"emissiveTexture": {"index": texture, "texCoord": 3}}));
    let scene = gltf.load();
    assert_eq!(scene.meshes[0].uvs[3], vec![Vec2::ZERO; 4]);
    warned(&scene, "TEXCOORD_3");
}

#[test]
fn coordinates_that_are_not_finite_become_zero() {
    let mut gltf = Gltf::square();
    let uvs = gltf.accessor(&floats(&[f32::NAN, 0., f32::INFINITY, 1., 1e30, 0., 0.5, 0.5]), FLOAT, "VEC2", 4);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    let texture = gltf.texture();
    let scene = gltf.material(json!({"emissiveTexture": {"index": texture}})).load();
    assert_eq!(scene.meshes[0].uvs[0], [Vec2::ZERO, Vec2::ZERO, Vec2::ZERO, Vec2::splat(0.5)]);
    warned(&scene, "3 elements of TEXCOORD_0");
}

#[test]
fn positions_that_are_not_finite_pass() {
    let mut gltf = Gltf::triangle();
    let positions = gltf.accessor(&floats(&[f32::NAN, 0., 0., 1., 0., 0., 0., f32::INFINITY, 0.]), FLOAT, "VEC3", 3);
    gltf.primitive()["attributes"]["POSITION"] = json!(positions);
    assert!(gltf.load().meshes[0].positions[0].x.is_nan());
}

#[test]
fn a_primitive_without_positions_or_triangles_shows_nothing() {
    let mut gltf = Gltf::triangle();
    gltf.primitive()["attributes"] = json!({});
    assert!(gltf.load().warnings[0].contains("without POSITION"));
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0]["count"] = json!(0);
    let scene = gltf.load();
    assert!(scene.meshes.is_empty() && scene.instances.is_empty());
    warned(&scene, "no triangles");
}

#[test]
fn the_same_primitive_is_stored_once() {
    let mut gltf = Gltf::square();
    let copy = gltf.json["meshes"][0].clone();
    let mesh = gltf.push("meshes", copy);
    let node = gltf.push("nodes", json!({"mesh": mesh, "translation": [2, 0, 0]}));
    gltf.json["scenes"][0]["nodes"] = json!([0, node]);
    let scene = gltf.load();
    assert_eq!((scene.meshes.len(), scene.instances.len(), scene.triangle_count()), (1, 2, 4));
}
