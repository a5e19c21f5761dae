//! A square lamp over a floor: direct light with a closed form in every pixel.
//!
//! **Known in closed form.** The lamp is black and the floor flat, so that nothing is reflected
//! twice: a floor point before the lamp shows ρ/π · E with Lambert's polygon formula for E
//! ([`radiance`]; Lambert, Photometria, 1760), at any depth ≥ 1.

use std::f64::consts::PI;

use glam::DVec3;
use surelight_scene::Scene;

use crate::builder::{Builder, emitter, lambert};
use crate::polygon_irradiance;
use crate::shapes::Shape;

/// Radiance of the lamp in each channel.
pub const LAMP_RADIANCE: [f32; 3] = [6.0, 5.0, 4.0];

/// Reflectance of the floor.
pub const FLOOR_REFLECTANCE: [f32; 3] = [0.35, 0.5, 0.7];

/// The lamp's corners, counter-clockwise from its front. It leans over the floor.
pub fn lamp() -> [DVec3; 4] {
    [(-0.8, 0.1, -0.7), (0.8, 0.1, -0.7), (0.8, 0.9, -0.1), (-0.8, 0.9, -0.1)].map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A floor of 8 m and a lamp of 1.6 m × 1 m.
pub fn quad_light() -> Scene {
    let mut b = Builder::new("quad-light");
    let floor = b.material(lambert("floor", FLOOR_REFLECTANCE));
    let light = b.material(emitter("light", LAMP_RADIANCE));
    b.add("floor", Shape::parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), floor);
    b.add("light", Shape::quad(lamp()), light);
    b.camera(DVec3::new(1.3, 1.7, 3.2), DVec3::new(0.0, 0.12, 0.1), 40.0, 1.5);
    b.finish()
}

/// Radiance of the floor at (x, 0, z), exact; 0 outside the floor and behind the lamp.
pub fn radiance(x: f64, z: f64) -> [f64; 3] {
    let (lamp, point) = (lamp(), DVec3::new(x, 0.0, z));
    let front = (lamp[1] - lamp[0]).cross(lamp[3] - lamp[0]);
    if x.abs() > 4.0 || z.abs() > 4.0 || front.dot(point - lamp[0]) <= 0.0 {
        return [0.0; 3];
    }
    let irradiance = polygon_irradiance(point, DVec3::Y, &lamp);
    [0, 1, 2].map(|c| f64::from(FLOOR_REFLECTANCE[c]) / PI * f64::from(LAMP_RADIANCE[c]) * irradiance)
}
