//! Skins, morph targets and animations: a posed mesh equals the baked one.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use serde_json::{Value, json};
use surelight_scene::{LoadError, LoadOptions, Moment, Scene, load_bytes};

use crate::build::{FLOAT, Gltf, SHORT, UBYTE, USHORT, floats, shorts, warned};

pub(crate) fn at(gltf: &Gltf, animation: &str, seconds: f64) -> Result<Scene, LoadError> {
    let animation = Some(Moment { animation: animation.into(), seconds });
    load_bytes(&gltf.glb(), "made.glb".as_ref(), &LoadOptions { animation, ..LoadOptions::default() })
}

/// World positions of the first instance.
fn world(scene: &Scene) -> Vec<DVec3> {
    let instance = &scene.instances[0];
    scene.meshes[instance.mesh].positions.iter().map(|p| instance.to_world.transform_point3(p.as_dvec3())).collect()
}

fn close(a: &[DVec3], b: &[DVec3]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (*a - *b).length() < 1e-5 * (1.0 + b.length()))
}

/// Adds an animation of one channel.
fn animate(gltf: &mut Gltf, target: Value, interpolation: &str, times: &[f32], values: &[f32], kind: &str) {
    let width = match kind {
        "SCALAR" => 1,
        "VEC3" => 3,
        _ => 4,
    };
    let input = gltf.accessor(&floats(times), FLOAT, "SCALAR", times.len());
    let output = gltf.accessor(&floats(values), FLOAT, kind, values.len() / width);
    gltf.push(
        "animations",
        json!({
            "name": "move",
            "channels": [{"sampler": 0, "target": target}],
            "samplers": [{"input": input, "output": output, "interpolation": interpolation}],
        }),
    );
}

#[test]
fn morph_targets_are_added_by_their_weights() {
    let mut gltf = Gltf::square();
    let p = gltf.accessor(&floats(&[1., 0., 0., 0., 2., 0., 0., 0., 4., 0., 0., 0.]), FLOAT, "VEC3", 4);
    let n = gltf.accessor(&floats(&[2., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.]), FLOAT, "VEC3", 4);
    let q = gltf.accessor(&floats(&[0., 0., 1.].repeat(4)), FLOAT, "VEC3", 4);
    gltf.primitive()["targets"] = json!([{"POSITION": p, "NORMAL": n}, {"POSITION": q}]);
    // At rest without weights: the base shape.
    let base = gltf.load();
    gltf.json["meshes"][0]["weights"] = json!([0.5, -2.0]);
    let posed = gltf.load();
    assert!(posed.warnings.is_empty());
    let moved = [[0.5, 0., -2.], [0., 1., -2.], [0., 0., 0.], [0., 0., -2.]].map(Vec3::from);
    for (i, moved) in moved.into_iter().enumerate() {
        assert_eq!(posed.meshes[0].positions[i], base.meshes[0].positions[i] + moved);
    }
    let normals = posed.meshes[0].normals.as_ref().expect("normals");
    assert!((normals[0] - Vec3::new(1., 0., 1.).normalize()).length() < 1e-6 && normals[1] == Vec3::Z);
    // A node's weights take precedence over its mesh's; the weights differ, so the mesh is there
    // twice.
    gltf.json["nodes"] = json!([{"mesh": 0, "weights": [0, 0]}, {"mesh": 0}, {"mesh": 0}]);
    gltf.json["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    let both = gltf.load();
    assert_eq!((both.meshes.len(), both.instances.len()), (2, 3));
    assert_eq!(both.meshes[both.instances[0].mesh].positions, base.meshes[0].positions);
    assert_eq!(both.instances[1].mesh, both.instances[2].mesh);
}

/// Two joints along x; the far half of the square hangs on the second.
pub(crate) fn skinned() -> Gltf {
    let mut gltf = Gltf::square();
    let joints = gltf.accessor(&[0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0], UBYTE, "VEC4", 4);
    let weights = gltf.accessor(
        &floats(&[1., 0., 0., 0., 1., 0., 0., 0., 0.5, 0.5, 0., 0., 0.25, 0.75, 0., 0.]),
        FLOAT,
        "VEC4",
        4,
    );
    gltf.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    gltf.primitive()["attributes"]["WEIGHTS_0"] = json!(weights);
    let mut inverse = Vec::new();
    for x in [0.0, 1.0_f32] {
        inverse.extend([1., 0., 0., 0., 0., 1., 0., 0., 0., 0., 1., 0., -x, 0., 0., 1.]);
    }
    let inverse = gltf.accessor(&floats(&inverse), FLOAT, "MAT4", 2);
    gltf.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": inverse}]);
    gltf.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [7, 7, 7]},
        {"children": [2]},
        {"translation": [1, 0, 0]},
    ]);
    gltf.json["scenes"] = json!([{"nodes": [0, 1]}]);
    gltf
}

#[test]
fn a_skin_at_rest_is_where_its_joints_are() {
    let scene = skinned().load();
    assert!(scene.warnings.is_empty());
    // The node's own transform means nothing.
    let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
    assert!(close(&world(&scene), &square), "{:?}", world(&scene));
    assert_eq!(scene.meshes[0].normals, Some(vec![Vec3::Z; 4]));
}

#[test]
fn a_posed_skin_equals_the_baked_mesh() {
    let mut gltf = skinned();
    let turn = DQuat::from_rotation_y(1.0);
    gltf.json["nodes"][2]["rotation"] = json!(turn.to_array());
    gltf.json["nodes"][1]["translation"] = json!([1e6, 2, 3]);
    let scene = gltf.load();
    let root = DAffine3::from_translation(DVec3::new(1e6, 2., 3.));
    let second = root * DAffine3::from_rotation_translation(turn, DVec3::X) * DAffine3::from_translation(DVec3::NEG_X);
    let square = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]].map(DVec3::from);
    // Shares of the second joint: by JOINTS and WEIGHTS above.
    let baked: Vec<DVec3> = square
        .iter()
        .zip([0.0, 1.0, 0.5, 0.75])
        .map(|(&p, share)| root.transform_point3(p) * (1.0 - share) + second.transform_point3(p) * share)
        .collect();
    // A million metres out, each vertex is still where it belongs to a millionth.
    for (a, b) in world(&scene).iter().zip(&baked) {
        assert!((*a - *b).length() < 1e-6, "{a} {b}");
    }
    let normal = scene.meshes[0].normals.as_ref().expect("normals")[1];
    assert!((normal.as_dvec3() - turn * DVec3::Z).length() < 1e-6);
}

#[test]
fn broken_skins_are_refused() {
    let edit = |change: &dyn Fn(&mut Gltf), parts: &[&str]| {
        let mut gltf = skinned();
        change(&mut gltf);
        gltf.refused(parts);
    };
    edit(&|g| g.json["nodes"][0]["skin"] = json!(4), &["node 0", "skin 4"]);
    edit(&|g| g.json["skins"][0]["joints"] = json!([1, 9]), &["skin 0", "node 9"]);
    edit(&|g| g.json["skins"][0]["joints"] = json!([]), &["skin 0", "no joints"]);
    edit(&|g| g.json["skins"][0]["joints"] = json!([1]), &["mesh 0, primitive 0", "joint 1"]);
    edit(&|g| g.json["skins"][0]["joints"] = json!([1, 2, 1]), &["skin 0", "3 MAT4"]);
    edit(&|g| g.json["skins"][0]["inverseBindMatrices"] = json!(0), &["skin 0", "MAT4"]);
    edit(&|g| g.primitive()["attributes"]["JOINTS_0"] = json!(0), &["JOINTS_0"]);
    let mut gltf = skinned();
    let zeros = gltf.accessor(&floats(&[0.0; 16]), FLOAT, "VEC4", 4);
    gltf.primitive()["attributes"]["WEIGHTS_0"] = json!(zeros);
    warned(&gltf.load(), "4 vertices of mesh 0, primitive 0 held by no joint");
}

/// x of the triangle's node, animated.
fn x(gltf: &Gltf, seconds: f64) -> f64 {
    at(gltf, "move", seconds).expect("loads").instances[0].to_world.translation.x
}

#[test]
fn translations_follow_their_interpolation() {
    let target = json!({"node": 0, "path": "translation"});
    let values = [0., 0., 0., 10., 0., 0., 20., 0., 0.];
    for (interpolation, between) in [("LINEAR", 12.5), ("STEP", 10.0)] {
        let mut gltf = Gltf::triangle();
        animate(&mut gltf, target.clone(), interpolation, &[1., 2., 4.], &values, "VEC3");
        assert_eq!(gltf.load().instances[0].to_world, DAffine3::IDENTITY, "at rest");
        for (seconds, expected) in [(-1.0, 0.0), (1.0, 0.0), (2.0, 10.0), (2.5, between), (4.0, 20.0), (99.0, 20.0)] {
            assert!((x(&gltf, seconds) - expected).abs() < 1e-6, "{interpolation} {seconds}: {}", x(&gltf, seconds));
        }
    }
    // A cubic through its own tangents: x = t³ − t + 2, over keyframes at 0 and 2.
    let mut gltf = Gltf::triangle();
    let f = |t: f32| t * t * t - t + 2.0;
    let slope = |t: f32| 3.0 * t * t - 1.0;
    let key = |t: f32| [[slope(t), 0., 0.], [f(t), 0., 0.], [slope(t), 0., 0.]].concat();
    animate(&mut gltf, target, "CUBICSPLINE", &[0., 2.], &[key(0.), key(2.)].concat(), "VEC3");
    for t in [0.0, 0.25, 0.9, 1.7, 2.0_f32] {
        assert!((x(&gltf, f64::from(t)) - f64::from(f(t))).abs() < 1e-6, "{t}");
    }
}

#[test]
fn rotations_go_the_shorter_way_at_even_speed() {
    let mut gltf = Gltf::triangle();
    let to = DQuat::from_rotation_z(2.0);
    // The negative quaternion turns the same.
    let values: Vec<f32> = [DQuat::IDENTITY, -to].iter().flat_map(|q| q.to_array().map(|c| c as f32)).collect();
    animate(&mut gltf, json!({"node": 0, "path": "rotation"}), "LINEAR", &[0., 1.], &values, "VEC4");
    for t in [0.0, 0.25, 0.5, 1.0] {
        let scene = at(&gltf, "0", t).expect("loads");
        let turned = scene.instances[0].to_world.matrix3.x_axis;
        assert!((turned - DQuat::from_rotation_z(2.0 * t) * DVec3::X).length() < 1e-6, "{t}: {turned}");
    }
}

#[test]
fn normalised_outputs_and_scales_are_read() {
    let mut gltf = Gltf::triangle();
    animate(&mut gltf, json!({"node": 0, "path": "scale"}), "STEP", &[0.], &[2., 3., 4.], "VEC3");
    let input = gltf.accessor(&floats(&[0.]), FLOAT, "SCALAR", 1);
    let output = gltf.accessor(&shorts(&[0, 0, 32767, 0]), SHORT, "VEC4", 1);
    gltf.json["accessors"][output]["normalized"] = json!(true);
    let animation = &mut gltf.json["animations"][0];
    animation["samplers"].as_array_mut().expect("array").push(json!({"input": input, "output": output}));
    let channels = animation["channels"].as_array_mut().expect("array");
    channels.push(json!({"sampler": 1, "target": {"node": 0, "path": "rotation"}}));
    let world = at(&gltf, "move", 0.5).expect("loads").instances[0].to_world;
    let expected = DAffine3::from_scale_rotation_translation(
        DVec3::new(2., 3., 4.),
        DQuat::from_xyzw(0., 0., 1., 0.),
        DVec3::ZERO,
    );
    assert!(world.abs_diff_eq(expected, 1e-12));
}

#[test]
fn weights_are_animated() {
    let mut gltf = Gltf::triangle();
    let far = gltf.accessor(&floats(&[0., 0., 8.].repeat(3)), FLOAT, "VEC3", 3);
    let wide = gltf.accessor(&floats(&[4., 0., 0.].repeat(3)), FLOAT, "VEC3", 3);
    gltf.primitive()["targets"] = json!([{"POSITION": far}, {"POSITION": wide}]);
    animate(&mut gltf, json!({"node": 0, "path": "weights"}), "LINEAR", &[0., 1.], &[0., 1., 1., 0.], "SCALAR");
    let first = |t| at(&gltf, "move", t).expect("loads").meshes[0].positions[0];
    assert_eq!((first(0.0), first(0.25), first(1.0)), (Vec3::X * 4.0, Vec3::new(3., 0., 2.), Vec3::Z * 8.0));
    assert_eq!(gltf.load().meshes[0].positions[0], Vec3::ZERO);
}

#[test]
fn broken_animations_are_reported() {
    let mut gltf = Gltf::triangle();
    animate(&mut gltf, json!({"node": 0, "path": "translation"}), "LINEAR", &[0., 1.], &[0.; 6], "VEC3");
    let refused = |gltf: &Gltf, name: &str, part: &str| {
        let message = at(gltf, name, 0.5).expect_err("refused").to_string();
        assert!(message.contains(part) && message.ends_with('.'), "{message}");
    };
    refused(&gltf, "walk", "the choice of an animation is \"walk\", but the file has \"move\"");
    refused(&Gltf::triangle(), "walk", "has none");
    let edit = |change: &dyn Fn(&mut Gltf), part: &str| {
        let mut gltf = gltf.clone();
        change(&mut gltf);
        refused(&gltf, "move", part);
    };
    edit(&|g| g.json["animations"][0]["channels"][0]["target"]["node"] = json!(5), "node 5");
    edit(&|g| g.json["animations"][0]["channels"][0]["sampler"] = json!(5), "sampler 5");
    edit(&|g| g.json["animations"][0]["samplers"][0]["interpolation"] = json!("SPLINE"), "unknown interpolation");
    edit(&|g| g.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"), "6 are needed");
    edit(&|g| g.json["animations"][0]["samplers"][0]["output"] = json!(1), "VEC3");
    let mut pointer = gltf.clone();
    pointer.json["animations"][0]["channels"][0]["target"] = json!({
        "path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/x"}}
    });
    let scene = at(&pointer, "move", 0.5).expect("loads");
    assert!(scene.warnings[0].contains("KHR_animation_pointer"), "{:?}", scene.warnings);
}

#[test]
fn integers_as_indices_of_joints_are_read() {
    let mut gltf = skinned();
    let joints = gltf.accessor(&shorts(&[0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0]), USHORT, "VEC4", 4);
    let byte = skinned().load();
    gltf.primitive()["attributes"]["JOINTS_0"] = json!(joints);
    assert_eq!(gltf.load().meshes, byte.meshes);
}

#[test]
fn keyframes_without_bytes_take_no_memory() {
    let mut gltf = Gltf::triangle();
    animate(&mut gltf, json!({"node": 0, "path": "translation"}), "LINEAR", &[0., 1.], &[0.; 6], "VEC3");
    for array in ["input", "output"] {
        let mut gltf = gltf.clone();
        let zeros = gltf.push(
            "accessors",
            json!({"componentType": FLOAT, "type": if array == "input" { "SCALAR" } else { "VEC3" }, "count": u32::MAX}),
        );
        gltf.json["animations"][0]["samplers"][0][array] = json!(zeros);
        let message = at(&gltf, "move", 0.5).expect_err("refused").to_string();
        assert!(message.contains("4294967295 elements"), "{message}");
    }
}
