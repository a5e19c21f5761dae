//! KHR_animation_pointer: supported properties move, others are reported and stay.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use surelight_scene::{AlphaMode, LightKind, Projection, Scene};

use crate::build::{FLOAT, Gltf, UBYTE, USHORT, floats, shorts, warned};
use crate::posing::at;

/// Adds a channel to animation "move".
fn channel(gltf: &mut Gltf, target: Value, sampler: Value) {
    if gltf.json["animations"].is_null() {
        gltf.json["animations"] = json!([{"name": "move", "channels": [], "samplers": []}]);
    }
    let animation = &mut gltf.json["animations"][0];
    let samplers = animation["samplers"].as_array_mut().expect("array");
    samplers.push(sampler);
    let sampler = samplers.len() - 1;
    animation["channels"].as_array_mut().expect("array").push(json!({"sampler": sampler, "target": target}));
}

fn to(pointer: &str) -> Value {
    json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": pointer}}})
}

/// Moves a property linearly between values at 0 and 1 second.
fn animate(gltf: &mut Gltf, pointer: &str, from: &[f32], until: &[f32]) {
    let input = gltf.accessor(&floats(&[0., 1.]), FLOAT, "SCALAR", 2);
    let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][from.len() - 1];
    let output = gltf.accessor(&floats(&[from, until].concat()), FLOAT, kind, 2);
    channel(gltf, to(pointer), json!({"input": input, "output": output}));
}

/// Switches a flag: off at 0, on at 1 second.
fn switch(gltf: &mut Gltf, pointer: &str) {
    let input = gltf.accessor(&floats(&[0., 1.]), FLOAT, "SCALAR", 2);
    let output = gltf.accessor(&[0, 1], UBYTE, "SCALAR", 2);
    channel(gltf, to(pointer), json!({"input": input, "output": output, "interpolation": "STEP"}));
}

#[track_caller]
fn load(gltf: &Gltf, seconds: f64) -> Scene {
    at(gltf, "move", seconds).unwrap_or_else(|e| panic!("{e}"))
}

/// A camera, a spot light, a textured glass square with two morph targets, and channels for them.
pub(crate) fn moving() -> Gltf {
    let mut gltf = Gltf::square();
    let texture = gltf.texture();
    let info = json!({"index": texture, "extensions": {"KHR_texture_transform": {}}});
    let mut gltf = gltf.material(json!({
        "alphaMode": "MASK", "normalTexture": info, "pbrMetallicRoughness": {"baseColorTexture": info},
        "extensions": {"KHR_materials_ior": {}, "KHR_materials_transmission": {"transmissionTexture": info}},
    }));
    let far = gltf.accessor(&floats(&[0., 0., 8.].repeat(4)), FLOAT, "VEC3", 4);
    let wide = gltf.accessor(&floats(&[4., 0., 0.].repeat(4)), FLOAT, "VEC3", 4);
    gltf.primitive()["targets"] = json!([{"POSITION": far}, {"POSITION": wide}]);
    gltf.json["cameras"] = json!([
        {"type": "perspective", "perspective": {"yfov": 1, "znear": 1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 1}},
    ]);
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "spot"}]}});
    gltf.json["nodes"] = json!([
        {"mesh": 0, "extensions": {"KHR_node_visibility": {}}},
        {"camera": 0},
        {"camera": 1},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]},
    ]);
    gltf.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    for (pointer, from, until) in [
        ("/cameras/0/perspective/yfov", &[0.5][..], &[1.5][..]),
        ("/cameras/1/orthographic/xmag", &[2.], &[4.]),
        ("/extensions/KHR_lights_punctual/lights/0/color", &[0., 0., 0.], &[1., 0.5, 0.25]),
        ("/extensions/KHR_lights_punctual/lights/0/spot/outerConeAngle", &[0.5], &[1.]),
        ("/materials/0/alphaCutoff", &[0.], &[1.]),
        ("/materials/0/emissiveFactor", &[0., 0., 1.], &[0., 1., 1.]),
        ("/materials/0/normalTexture/scale", &[1.], &[3.]),
        ("/materials/0/pbrMetallicRoughness/baseColorFactor", &[1., 0., 0., 1.], &[0., 1., 0., 0.]),
        ("/materials/0/extensions/KHR_materials_ior/ior", &[1.], &[2.]),
        ("/materials/0/extensions/KHR_materials_transmission/transmissionFactor", &[0.], &[1.]),
        ("/materials/0/normalTexture/extensions/KHR_texture_transform/offset", &[0., 0.], &[1., 2.]),
        (
            "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale",
            &[1., 1.],
            &[3., 5.],
        ),
        (
            "/materials/0/extensions/KHR_materials_transmission/transmissionTexture/extensions/KHR_texture_transform/rotation",
            &[0.],
            &[2.],
        ),
        ("/meshes/0/weights/1", &[0.], &[1.]),
        ("/nodes/3/translation", &[0., 0., 0.], &[4., 0., 0.]),
    ] {
        animate(&mut gltf, pointer, from, until);
    }
    switch(&mut gltf, "/nodes/0/extensions/KHR_node_visibility/visible");
    gltf
}

#[test]
fn whatever_is_read_moves() {
    let mut gltf = moving();
    // Hidden until the end.
    assert_eq!(load(&gltf, 0.5).instances.len(), 0);
    let channels = gltf.json["animations"][0]["channels"].as_array_mut().expect("array");
    channels.pop();
    let scene = load(&gltf, 0.5);
    assert_eq!(scene.warnings, Vec::<String>::new());
    assert_eq!(scene.cameras[0].projection, Projection::Perspective { yfov: 1.0, aspect: None });
    assert_eq!(scene.cameras[1].projection, Projection::Orthographic { xmag: 3.0, ymag: 1.0 });
    let light = &scene.lights[0];
    assert_eq!(light.intensity, [0.5, 0.25, 0.125]);
    // A node that has a matrix is where its translation moves it.
    let LightKind::Spot { position, outer, .. } = light.kind else { panic!("{light:?}") };
    assert_eq!((position, outer), (DVec3::X * 2.0, 0.75));
    let m = &scene.materials[0];
    assert_eq!((m.alpha_mode, m.emissive, m.base_color), (AlphaMode::Mask(0.5), [0., 0.5, 1.], [0.5, 0.5, 0., 0.5]));
    assert_eq!((m.ior, m.transmission), (1.5, 0.5));
    let normal = m.normal_texture.as_ref().expect("normal map");
    assert_eq!((normal.scale, normal.texture.transform.expect("moved").translation), (2.0, Vec2::new(0.5, 1.0)));
    let color = m.base_color_texture.as_ref().expect("texture").transform.expect("scaled");
    assert_eq!(color.transform_vector2(Vec2::ONE), Vec2::new(2.0, 3.0));
    let turned = m.transmission_texture.as_ref().expect("texture").transform.expect("turned");
    assert!((turned.matrix2.x_axis - Vec2::from_angle(-1.0)).length() < 1e-6);
    assert_eq!(scene.meshes[0].positions[0], Vec3::X * 2.0);
    // At rest nothing moves.
    let rest = gltf.load();
    assert_eq!((rest.materials[0].ior, rest.meshes[0].positions[0]), (1.5, Vec3::ZERO));
    assert!(rest.warnings.is_empty());
}

#[test]
fn flags_switch() {
    let gltf = moving();
    for (seconds, shown) in [(0.0, 0), (0.9, 0), (1.0, 1)] {
        assert_eq!(load(&gltf, seconds).instances.len(), shown, "{seconds}");
    }
}

#[test]
fn nodes_move_as_by_channels_of_their_own() {
    let mut gltf = Gltf::triangle();
    let turn = DQuat::from_rotation_z(2.0);
    animate(&mut gltf, "/nodes/0/rotation", &[0., 0., 0., 1.], &turn.to_array().map(|c| -c as f32));
    animate(&mut gltf, "/nodes/0/scale", &[1., 1., 1.], &[3., 3., 3.]);
    let world = load(&gltf, 0.25).instances[0].to_world;
    let half = DQuat::from_rotation_z(0.5);
    let expected = DAffine3::from_scale_rotation_translation(DVec3::splat(1.5), half, DVec3::ZERO);
    assert!(world.abs_diff_eq(expected, 1e-6), "{world:?}");
}

#[test]
fn weights_move_all_or_one_by_one() {
    let mut gltf = moving();
    gltf.json["animations"] = Value::Null;
    gltf.json["meshes"][0]["weights"] = json!([0.5, 0.25]);
    let first = |gltf: &Gltf| load(gltf, 0.5).meshes[0].positions[0];
    let mut one = gltf.clone();
    animate(&mut one, "/nodes/0/weights/0", &[0.], &[2.]);
    assert_eq!(first(&one), Vec3::new(1., 0., 8.));
    let mut one = gltf.clone();
    animate(&mut one, "/meshes/0/weights/0", &[0.], &[2.]);
    animate(&mut one, "/meshes/0/weights/1", &[0.], &[1.]);
    assert_eq!(first(&one), Vec3::new(2., 0., 8.));
    for pointer in ["/nodes/0/weights", "/meshes/0/weights"] {
        let mut all = gltf.clone();
        let input = all.accessor(&floats(&[0., 1.]), FLOAT, "SCALAR", 2);
        let output = all.accessor(&floats(&[0., 1., 1., 0.]), FLOAT, "SCALAR", 4);
        channel(&mut all, to(pointer), json!({"input": input, "output": output}));
        assert_eq!(first(&all), Vec3::new(2., 0., 4.), "{pointer}");
    }
    let mut none = gltf;
    animate(&mut none, "/meshes/0/weights/2", &[0.], &[2.]);
    warned(&load(&none, 0.5), "is no weight of the mesh's 2 morph targets");
}

#[test]
fn fractions_and_splines_are_followed() {
    let mut gltf = Gltf::triangle().material(json!({}));
    let input = gltf.accessor(&floats(&[0., 2.]), FLOAT, "SCALAR", 2);
    let output = gltf.accessor(&shorts(&[0, 65535]), USHORT, "SCALAR", 2);
    gltf.json["accessors"][output]["normalized"] = json!(true);
    // An object that is not there has its defaults.
    let roughness = to("/materials/0/pbrMetallicRoughness/roughnessFactor");
    channel(&mut gltf, roughness, json!({"input": input, "output": output}));
    // t²/4 through its own tangents: in-tangent, value, out-tangent.
    let output = gltf.accessor(&floats(&[0., 0., 0., 1., 1., 1.]), FLOAT, "SCALAR", 6);
    let spline = json!({"input": input, "output": output, "interpolation": "CUBICSPLINE"});
    channel(&mut gltf, to("/materials/0/pbrMetallicRoughness/metallicFactor"), spline);
    let material = &load(&gltf, 0.5).materials[0];
    assert_eq!((material.roughness, material.metallic), (0.25, 0.0625));
}

#[test]
fn unsupported_animations_are_reported_once_and_ignored() {
    let rest = moving().load();
    let stays = |pointer: &str, part: &str| {
        let mut gltf = moving();
        gltf.json["animations"] = Value::Null;
        animate(&mut gltf, pointer, &[0.], &[1.]);
        let scene = load(&gltf, 0.5);
        warned(&scene, part);
        assert!(scene.warnings[0].contains("KHR_animation_pointer"), "{:?}", scene.warnings);
        assert_eq!((scene.materials, scene.meshes), (rest.materials.clone(), rest.meshes.clone()), "{pointer}");
    };
    for pointer in [
        "",
        "/",
        "materials/0/alphaCutoff",
        "/asset",
        "/asset/version",
        "/nodes/0/mesh",
        "/nodes/00/translation",
        "/nodes/-1/translation",
        "/nodes/99999999999999999999999/translation",
        "/materials/0/alphaMode",
        "/materials/0/alphaCutoff/0",
        "/materials/0/alpha~2Cutoff",
        "/materials/0/doubleSided",
        "/materials/0/extensions/KHR_materials_ior",
        "/materials/0/extensions/KHR_materials_volume_scatter/multiscatterColor",
        "/accessors/0/count",
    ] {
        stays(pointer, "is no property that animation 0 can move; it does not move");
    }
    stays("/materials/7/alphaCutoff", "is not animated: the last one is 0");
    stays("/materials/18446744073709551615/alphaCutoff", "is not animated: the last one is 0");
    stays("/materials/0/extensions/KHR_materials_sheen/sheenRoughnessFactor", "there is no KHR_materials_sheen");
    stays("/materials/0/occlusionTexture/strength", "there is no occlusionTexture");
    stays("/cameras/1/perspective/yfov", "there is no perspective");
    stays("/extensions/KHR_lights_punctual/lights/1/intensity", "there is no 1");
    stays("/extensions/EXT_lights_image_based/lights/0/intensity", "there is no EXT_lights_image_based");

    let mut gltf = Gltf::triangle();
    animate(&mut gltf, "/materials/0/alphaCutoff", &[0.], &[1.]);
    warned(&load(&gltf, 0.5), "the file has no materials");
    let mut gltf = moving();
    animate(&mut gltf, "/materials/0/alphaCutoff", &[5.], &[5.]);
    let scene = load(&gltf, 1.0);
    warned(&scene, "animation 0 moves \"/materials/0/alphaCutoff\" by two channels; the first one is used");
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Mask(1.0));
    let mut gltf = moving();
    gltf.json["animations"] = Value::Null;
    animate(&mut gltf, "/materials/0/emissiveFactor", &[f32::NAN, 0., 0.], &[0., 0., 0.]);
    warned(&load(&gltf, 0.0), "would not be finite");
}

#[test]
fn a_channel_of_a_node_comes_before_a_pointer_to_the_same() {
    let mut gltf = Gltf::triangle();
    let input = gltf.accessor(&floats(&[0.]), FLOAT, "SCALAR", 1);
    let output = gltf.accessor(&floats(&[1., 2., 3.]), FLOAT, "VEC3", 1);
    channel(&mut gltf, json!({"node": 0, "path": "translation"}), json!({"input": input, "output": output}));
    animate(&mut gltf, "/nodes/0/translation", &[9., 9., 9.], &[9., 9., 9.]);
    let scene = load(&gltf, 0.5);
    warned(&scene, "by two channels");
    assert_eq!(scene.instances[0].to_world.translation, DVec3::new(1., 2., 3.));
}

#[test]
fn outputs_of_the_wrong_type_are_refused() {
    let refused = |pointer: &str, from: &[f32], part: &str| {
        let mut gltf = moving();
        gltf.json["animations"] = Value::Null;
        animate(&mut gltf, pointer, from, from);
        let message = at(&gltf, "move", 0.5).expect_err("refused").to_string();
        assert!(message.contains(part) && message.ends_with('.'), "{message}");
    };
    refused("/materials/0/alphaCutoff", &[0., 0.], "animation 0 has a sampler whose output is not SCALAR");
    refused("/materials/0/emissiveFactor", &[0.], "not VEC3");
    refused("/materials/0/pbrMetallicRoughness/baseColorFactor", &[0., 0., 0.], "not VEC4");
    refused("/nodes/0/extensions/KHR_node_visibility/visible", &[0.], "by other than unsigned bytes and STEP");
    refused("/nodes/9/translation", &[0., 0., 0.], "node 9");
    refused("/meshes/9/weights", &[0.], "mesh 9");
}
