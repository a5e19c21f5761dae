//! Bounds and the camera that frames a scene.

use glam::DVec3;
use serde_json::json;
use surelight_scene::{Projection, Scene};

use crate::build::{FLOAT, Gltf, floats};

#[test]
fn bounds_hold_placed_finite_corners() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["scale"] = json!([2, 3, 1]);
    gltf.json["nodes"][0]["translation"] = json!([10, 0, 0]);
    assert_eq!(gltf.load().bounds(), Some((DVec3::new(10., 0., 0.), DVec3::new(12., 3., 0.))));
    assert_eq!(Scene::default().bounds(), None);

    let mut gltf = Gltf::triangle();
    let positions = gltf.accessor(&floats(&[f32::NAN, 0., 0., 1., 2., 3., f32::INFINITY, 0., 0.]), FLOAT, "VEC3", 3);
    gltf.primitive()["attributes"]["POSITION"] = json!(positions);
    assert_eq!(gltf.load().bounds(), Some((DVec3::new(1., 2., 3.), DVec3::new(1., 2., 3.))));
}

#[test]
fn vertices_without_a_triangle_do_not_count() {
    let mut gltf = Gltf::square();
    let far = [0., 0., 0., 1., 0., 0., 1., 1., 0., 1e6, 0., 0.];
    let positions = gltf.accessor(&floats(&far), FLOAT, "VEC3", 4);
    let indices = gltf.accessor(&[0, 1, 2, 0, 1, 2], 5121, "SCALAR", 6);
    gltf.primitive()["attributes"] = json!({"POSITION": positions});
    gltf.primitive()["indices"] = json!(indices);
    assert_eq!(gltf.load().bounds().expect("bounds").1, DVec3::new(1.0, 1.0, 0.0));
}

#[test]
fn the_frame_shows_every_corner_and_is_not_wasteful() {
    for (scale, at) in
        [([1., 1., 1.], [0., 0., 0.]), ([1e-3, 4e-3, 1e-3], [1e5, 0., 0.]), ([100., 1., 30.], [0., -7., 2.])]
    {
        for aspect in [0.5, 1.0, 2.0] {
            let mut gltf = Gltf::square();
            gltf.json["nodes"][0]["scale"] = json!(scale);
            gltf.json["nodes"][0]["translation"] = json!(at);
            let scene = gltf.load();
            let camera = scene.frame_camera(aspect);
            let Projection::Perspective { yfov, .. } = camera.projection else { panic!() };
            let inverse = camera.to_world.inverse();
            let (low, high) = scene.bounds().expect("bounds");
            let mut widest = 0.0_f64;
            for x in [low.x, high.x] {
                for y in [low.y, high.y] {
                    let p = inverse.transform_point3(DVec3::new(x, y, low.z));
                    assert!(p.z < 0.0);
                    let slope = (yfov * 0.5).tan();
                    widest = widest.max(p.x.abs() / -p.z / (slope * aspect)).max(p.y.abs() / -p.z / slope);
                }
            }
            assert!(widest < 1.0 && widest > 0.8, "{widest}");
            // From the front, a little from above.
            assert!(camera.to_world.matrix3.z_axis.z > 0.7 && camera.to_world.matrix3.z_axis.y > 0.1);
        }
    }
}

#[test]
fn empty_and_endless_scenes_get_a_finite_camera() {
    assert!(Scene::default().frame_camera(1.0).to_world.is_finite());
    assert!(Gltf::triangle().load().frame_camera(f64::NAN).to_world.is_finite());
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["scale"] = json!([1e308, 1e308, 1]);
    assert!(gltf.load().frame_camera(1.0).to_world.is_finite());
}
