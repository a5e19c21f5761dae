//! Cameras and KHR_lights_punctual.

use glam::{DMat3, DVec3};
use serde_json::{Value, json};
use surelight_scene::{Camera, ClipRange, Light, LightKind, Projection, Scene};

use crate::build::{Gltf, warned};

fn with_camera(camera: Value, node: Value) -> Scene {
    let mut gltf = Gltf::triangle();
    gltf.push("cameras", camera);
    let node = gltf.push("nodes", node);
    gltf.json["scenes"][0]["nodes"] = json!([0, node]);
    gltf.load()
}

fn camera(camera: Value, node: Value) -> (Camera, Vec<String>) {
    let mut scene = with_camera(camera, node);
    (scene.cameras.remove(0), scene.warnings)
}

const PERSPECTIVE: fn() -> Value = || json!({"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}});

#[test]
fn perspective_cameras() {
    let json =
        json!({"name": "c", "type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1}});
    let (camera, warnings) = camera(json, json!({"camera": 0, "translation": [1, 2, 3]}));
    assert_eq!(camera.projection, Projection::Perspective { yfov: 0.5, aspect: Some(1.5) });
    assert_eq!((camera.aspect(), camera.name.as_str()), (Some(1.5), "c"));
    assert_eq!(camera.to_world.translation, DVec3::new(1.0, 2.0, 3.0));
    assert!(warnings.is_empty());
}

#[test]
fn orthographic_cameras() {
    let json = json!({"type": "orthographic", "orthographic": {"xmag": 3, "ymag": -2, "znear": 0, "zfar": 1}});
    let (camera, warnings) = camera(json, json!({"camera": 0, "name": "node"}));
    assert_eq!(camera.projection, Projection::Orthographic { xmag: 3.0, ymag: 2.0 });
    assert_eq!(camera.name, "node");
    assert!(warnings.is_empty());
}

#[test]
fn clip_ranges() {
    let clip = |kind: &str, near: Value, far: Value| {
        let mut projection = json!({"yfov": 1, "xmag": 1, "ymag": 1});
        for (name, value) in [("znear", near), ("zfar", far)].into_iter().filter(|(_, value)| !value.is_null()) {
            projection[name] = value;
        }
        let (camera, warnings) = camera(json!({"type": kind, kind: projection}), json!({"camera": 0}));
        (camera.clip, warnings)
    };
    for kind in ["perspective", "orthographic"] {
        let range = |near, far| (ClipRange { near, far }, Vec::new());
        assert_eq!(clip(kind, json!(0.1), json!(100)), range(0.1, 100.0));
        assert_eq!(clip(kind, json!(0.1), Value::Null), range(0.1, f64::INFINITY));
        assert_eq!(clip(kind, Value::Null, Value::Null), range(0.0, f64::INFINITY));
        for (near, far) in
            [(json!(-1), json!(1)), (json!(2), json!(2)), (json!(3), json!(2)), (json!(1e300), json!(1e301))]
        {
            let (found, warnings) = clip(kind, near, far);
            assert_eq!(found, ClipRange::NONE);
            assert_eq!(warnings.len(), 1, "{warnings:?}");
            assert!(warnings[0].contains("camera 0") && warnings[0].contains("znear"), "{warnings:?}");
        }
    }
}

#[test]
fn scale_is_taken_out_of_cameras() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for scale in [[2.0, 3.0, 4.0], [-1.0, 1.0, 1.0], [1e-3, 1e3, 1.0]] {
        let (camera, _) = camera(PERSPECTIVE(), json!({"camera": 0, "rotation": [0, half, 0, half], "scale": scale}));
        let m = camera.to_world.matrix3;
        // Turned by 90° about y, it faces −x.
        assert!((m.z_axis - DVec3::X).length() < 1e-12 && (m.y_axis - DVec3::Y).length() < 1e-12, "{m}");
        assert!((m.transpose() * m).abs_diff_eq(DMat3::IDENTITY, 1e-12) && m.determinant() > 0.0);
    }
}

#[test]
fn odd_cameras_are_mended_or_left_out() {
    let json = json!({"type": "perspective", "perspective": {"yfov": 0, "aspectRatio": 0, "znear": 0}});
    let (bad, warnings) = camera(json, json!({"camera": 0}));
    assert_eq!(bad.projection, Projection::Perspective { yfov: std::f64::consts::FRAC_PI_4, aspect: None });
    assert_eq!(warnings.len(), 2);
    let json = json!({"type": "orthographic", "orthographic": {"xmag": 0, "ymag": 1}});
    assert_eq!(camera(json, json!({"camera": 0})).0.projection, Projection::Orthographic { xmag: 1.0, ymag: 1.0 });
    let singular = with_camera(PERSPECTIVE(), json!({"camera": 0, "scale": [1, 1, 0]}));
    assert!(singular.cameras.is_empty());
    warned(&singular, "singular");
    let unknown = with_camera(json!({"type": "fisheye"}), json!({"camera": 0}));
    assert!(unknown.cameras.is_empty());
    warned(&unknown, "neither perspective nor orthographic");
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["camera"] = json!(2);
    gltf.refused(&["node 0", "camera 2"]);
}

fn with_light(light: Value, node: Value) -> Scene {
    let mut gltf = Gltf::triangle();
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    let mut node = node;
    node["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let node = gltf.push("nodes", node);
    gltf.json["scenes"][0]["nodes"] = json!([0, node]);
    gltf.load()
}

fn light(json: Value, node: Value) -> Light {
    let mut scene = with_light(json, node);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene.lights.remove(0)
}

#[test]
fn lights_of_all_kinds() {
    let point = light(
        json!({"name": "p", "type": "point", "color": [1, 0.5, 0], "intensity": 10}),
        json!({"translation": [1, 2, 3], "scale": [5, 5, 5]}),
    );
    assert_eq!(point.kind, LightKind::Point { position: DVec3::new(1.0, 2.0, 3.0) });
    assert_eq!((point.intensity, point.name.as_str()), ([10.0, 5.0, 0.0], "p"));

    let half = std::f64::consts::FRAC_1_SQRT_2;
    // Turned by −90° about x, −z goes to −y: the light shines down, whatever the scale.
    let sun = light(json!({"type": "directional"}), json!({"rotation": [-half, 0, 0, half], "scale": [2, 2, 7]}));
    let LightKind::Directional { direction } = sun.kind else { panic!("{sun:?}") };
    assert!((direction - DVec3::NEG_Y).length() < 1e-15);
    assert_eq!(sun.intensity, [1.0; 3]);

    let spot = light(json!({"type": "spot", "spot": {}}), json!({}));
    let LightKind::Spot { direction, inner, outer, .. } = spot.kind else { panic!("{spot:?}") };
    assert_eq!((direction, inner, outer), (DVec3::NEG_Z, 0.0, std::f32::consts::FRAC_PI_4));
}

#[test]
fn odd_cones_are_mended() {
    for (inner, outer) in [(0.5, 0.5), (1.0, 0.5), (-1.0, 9.0), (0.0, 0.0)] {
        let scene =
            with_light(json!({"type": "spot", "spot": {"innerConeAngle": inner, "outerConeAngle": outer}}), json!({}));
        let LightKind::Spot { inner, outer, .. } = scene.lights[0].kind else { panic!() };
        assert!(inner >= 0.0 && inner < outer && outer <= std::f32::consts::FRAC_PI_2);
    }
}

#[test]
fn odd_lights_are_left_out() {
    for (json, part) in [(json!({"type": "area"}), "area"), (json!({}), "light 0"), (json!({"type": 3}), "light 0")] {
        let scene = with_light(json, json!({}));
        assert!(scene.lights.is_empty());
        warned(&scene, part);
    }
    let scene = with_light(json!({"type": "point", "intensity": -3}), json!({}));
    assert_eq!(scene.lights[0].intensity, [0.0; 3]);
    warned(&scene, "intensity of light 0");
    warned(&with_light(json!({"type": "point", "range": 3}), json!({})), "range");
    warned(&with_light(json!({"type": "directional"}), json!({"scale": [1, 1, 0]})), "singular");

    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 4}});
    warned(&gltf.load(), "light 4");
    gltf.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": 3});
    warned(&gltf.load(), "names no light");
}
