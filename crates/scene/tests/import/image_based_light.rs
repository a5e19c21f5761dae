//! EXT_lights_image_based.

use serde_json::{Value, json};
use surelight_scene::{Environment, EnvironmentMap, Scene};

use crate::build::{Gltf, png, warned};

/// A pixel that decodes to 0 or 1 in each channel.
const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 255];
const BLUE: [u8; 4] = [0, 0, 255, 255];
const BLACK: [u8; 4] = [0, 0, 0, 255];

/// A triangle under a cube of faces of 2×2 pixels (row by row from the top left).
fn lit(faces: [[[u8; 4]; 4]; 6], more: Value) -> Gltf {
    let mut gltf = Gltf::triangle();
    let images = faces.map(|face| {
        let view = gltf.view(&png(2, 2, &face.concat()));
        gltf.push("images", json!({"bufferView": view, "mimeType": "image/png"}))
    });
    let mut light = json!({"specularImages": [images], "specularImageSize": 2, "irradianceCoefficients": []});
    for (key, value) in more.as_object().expect("an object") {
        light[key] = value.clone();
    }
    gltf.json["extensionsUsed"] = json!(["EXT_lights_image_based"]);
    gltf.json["extensions"] = json!({"EXT_lights_image_based": {"lights": [light]}});
    gltf.json["scenes"][0]["extensions"] = json!({"EXT_lights_image_based": {"light": 0}});
    gltf
}

fn map(scene: &Scene) -> (&EnvironmentMap, f32) {
    match &scene.environment {
        Some(Environment::Map { map, scale, .. }) => (map, *scale),
        other => panic!("{other:?}"),
    }
}

/// The nearest texel, as the documentation of [`EnvironmentMap`] says.
fn radiance(scene: &Scene, [x, y, z]: [f64; 3]) -> [f32; 3] {
    let (map, scale) = map(scene);
    let u = 0.5 + z.atan2(x) / std::f64::consts::TAU;
    let v = 0.5 - (y / (x * x + y * y + z * z).sqrt()).asin() / std::f64::consts::PI;
    let column = ((u * f64::from(map.width)) as u32).min(map.width - 1);
    let row = ((v * f64::from(map.height)) as u32).min(map.height - 1);
    map.texels[(row * map.width + column) as usize].map(|c| c * scale)
}

fn brightest(radiance: [f32; 3]) -> usize {
    (0..3).max_by(|&a, &b| radiance[a].total_cmp(&radiance[b])).expect("three")
}

#[test]
fn faces_are_where_a_camera_at_the_origin_sees_them() {
    // Left column red, right column green; a blue top row for the upright faces.
    let upright = [BLUE, BLUE, RED, GREEN];
    let scene = lit([upright; 6], json!({})).load();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    assert_eq!((map(&scene).0.width, map(&scene).0.height), (8, 4));
    // The view along each axis, a little down: the colour on the right.
    for (down_left, down_right) in [
        ([1.0, -0.4, -0.4], [1.0, -0.4, 0.4]),
        ([-1.0, -0.4, 0.4], [-1.0, -0.4, -0.4]),
        ([0.4, -0.4, 1.0], [-0.4, -0.4, 1.0]),
        ([-0.4, -0.4, -1.0], [0.4, -0.4, -1.0]),
        // Looking up, +Z is below and −X to the right; looking down, −Z is below.
        ([0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]),
        ([0.5, -1.0, -0.5], [-0.5, -1.0, -0.5]),
    ] {
        assert_eq!(brightest(radiance(&scene, down_left)), 0, "{down_left:?}");
        assert_eq!(brightest(radiance(&scene, down_right)), 1, "{down_right:?}");
    }
    assert_eq!(brightest(radiance(&scene, [1.0, 0.5, 0.3])), 2);
}

#[test]
fn a_uniform_cube_is_a_uniform_map_times_the_intensity() {
    // sRGB 188 is 0.503 linear.
    let scene = lit([[[188, 188, 188, 255]; 4]; 6], json!({"intensity": 3.0})).load();
    for c in map(&scene).0.texels.iter().flatten().map(|c| c * 3.0) {
        assert!((c - 3.0 * 0.502_886_5).abs() < 1e-5, "{c}");
    }
    assert_eq!(map(&scene).1, 3.0);
}

#[test]
fn alpha_divides() {
    let scene = lit([[[255, 188, 0, 51]; 4]; 6], json!({})).load();
    for [r, g, b] in &map(&scene).0.texels {
        assert!((r - 5.0).abs() < 1e-5 && (g - 5.0 * 0.502_886_5).abs() < 1e-4 && *b == 0.0);
    }
}

#[test]
fn the_rotation_turns_the_light() {
    // Red towards +X alone; a quarter turn about +Y turns it towards −Z.
    let faces = [[RED; 4], [BLACK; 4], [BLACK; 4], [BLACK; 4], [BLACK; 4], [BLACK; 4]];
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let scene = lit(faces, json!({"rotation": [0.0, half, 0.0, half]})).load();
    assert!(radiance(&scene, [0.1, 0.1, -1.0])[0] > 0.99);
    assert_eq!(radiance(&scene, [1.0, 0.1, 0.1]), [0.0; 3]);
}

#[test]
fn broken_lights_are_left_out_with_a_warning() {
    let good = || lit([[GREEN; 4]; 6], json!({}));
    let light = |gltf: &mut Gltf, change: fn(&mut Value)| {
        change(&mut gltf.json["extensions"]["EXT_lights_image_based"]["lights"][0]);
    };
    for (part, change) in [
        ("no specularImages", (|l| l["specularImages"] = json!([])) as fn(&mut Value)),
        ("invalid length 5", |l| l["specularImages"] = json!([[0, 1, 2, 3, 4]])),
        ("no quaternion", |l| l["rotation"] = json!([0, 0, 0, 0])),
    ] {
        let mut gltf = good();
        light(&mut gltf, change);
        let scene = gltf.load();
        warned(&scene, part);
        assert!(scene.environment.is_none());
    }
    let mut gltf = good();
    light(&mut gltf, |l| l["specularImages"] = json!([[0, 1, 2, 3, 4, 99]]));
    let scene = gltf.load();
    assert!(
        scene.environment.is_none() && scene.warnings.iter().any(|w| w.contains("image 99")),
        "{:?}",
        scene.warnings
    );
    let mut gltf = good();
    gltf.json["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = json!(7);
    warned(&gltf.load(), "light 7");
}
