//! The Cornell box with its two blocks, by the published measurements.
//!
//! Geometry and camera: Cornell University Program of Computer Graphics, "Cornell Box Data"
//! (<https://www.graphics.cornell.edu/online/box/data.html>), in millimetres there; here in metres,
//! turned half a turn about +Y so that the view direction is −Z, with x = 0 at the camera and z = 0
//! at the open front. Goral, Torrance, Greenberg, Battaile, "Modeling the Interaction of Light
//! Between Diffuse Surfaces", SIGGRAPH 1984, began the series. The measured spectra are replaced by
//! the RGB values in common use; the light is black and one-sided.
//!
//! **Known in closed form.** The light's power, π·L·A per channel. Direct light on a floor point
//! from which the whole lamp is visible: Lambert's polygon formula (see
//! [`polygon_irradiance`](crate::polygon_irradiance)), at [`PROBE`] for one. The picture as a whole
//! has no closed form.

use glam::DVec3;
use surelight_scene::Scene;

use crate::builder::{Builder, emitter, lambert};
use crate::shapes::Shape;

/// Radiance of the lamp, linear Rec. 709.
pub const RADIANCE: [f32; 3] = [17.0, 12.0, 4.0];

/// A point on the floor from which the whole lamp is visible past both blocks.
pub const PROBE: DVec3 = DVec3::new(-0.172, 0.0, -0.100);

/// The lamp's corners, metres, counter-clockwise from below.
pub fn lamp() -> [DVec3; 4] {
    [point(213.0, 548.8, 227.0), point(343.0, 548.8, 227.0), point(343.0, 548.8, 332.0), point(213.0, 548.8, 332.0)]
}

/// A published point, millimetres, in the scene's coordinates.
fn point(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(278.0 - x, y, -z) * 1e-3
}

/// The scene: 38 triangles, four materials.
pub fn cornell_box() -> Scene {
    let mut b = Builder::new("cornell-box");
    let white = b.material(lambert("white", [0.725, 0.71, 0.68]));
    let red = b.material(lambert("red", [0.63, 0.065, 0.05]));
    let green = b.material(lambert("green", [0.14, 0.45, 0.091]));
    let light = b.material(emitter("light", RADIANCE));

    let quad = |c: [(f64, f64, f64); 4]| Shape::quad(c.map(|(x, y, z)| point(x, y, z)));
    let floor = [(552.8, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 559.2), (549.6, 0.0, 559.2)];
    let back = [(549.6, 0.0, 559.2), (0.0, 0.0, 559.2), (0.0, 548.8, 559.2), (556.0, 548.8, 559.2)];
    let right = [(0.0, 0.0, 559.2), (0.0, 0.0, 0.0), (0.0, 548.8, 0.0), (0.0, 548.8, 559.2)];
    let left = [(552.8, 0.0, 0.0), (549.6, 0.0, 559.2), (556.0, 548.8, 559.2), (556.0, 548.8, 0.0)];
    b.add("floor", quad(floor), white);
    b.add("ceiling", ceiling(), white);
    b.add("back wall", quad(back), white);
    b.add("right wall", quad(right), green);
    b.add("left wall", quad(left), red);
    let short = [(130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0)];
    let tall = [(423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0)];
    b.add("short block", block(short, 165.0), white);
    b.add("tall block", block(tall, 330.0), white);
    b.add("light", Shape::quad(lamp()), light);

    // The published camera: focal length 0.035, film 0.025 × 0.025.
    let yfov = 2.0 * (0.0125f64 / 0.035).atan();
    b.camera(point(278.0, 273.0, -800.0), point(278.0, 273.0, 0.0), yfov.to_degrees(), 1.0);
    b.finish()
}

/// The ceiling with a hole that the lamp fills: in the published data both lie in one plane, and a
/// lamp inside an uncut ceiling would be hit or missed by chance.
fn ceiling() -> Shape {
    let outer = [(0.0, 0.0), (556.0, 0.0), (556.0, 559.2), (0.0, 559.2)].map(|(x, z)| point(x, 548.8, z));
    let inner = lamp();
    let mut shape = Shape::default();
    for i in 0..4 {
        let j = (i + 1) % 4;
        shape.append(Shape::quad([outer[i], outer[j], inner[j], inner[i]]));
    }
    shape
}

/// A block without its bottom, which lies on the floor.
fn block(top: [(f64, f64); 4], height: f64) -> Shape {
    let at = |i: usize, y: f64| point(top[i % 4].0, y, top[i % 4].1);
    let mut shape = Shape::quad([0, 1, 2, 3].map(|i| at(i, height)));
    for i in 0..4 {
        shape.append(Shape::quad([at(i, 0.0), at(i + 1, 0.0), at(i + 1, height), at(i, height)]));
    }
    shape
}
