//! Four glossy plates under four spherical lights: neither light sampling nor BSDF sampling alone
//! renders it well.
//!
//! After Veach and Guibas, "Optimally Combining Sampling Techniques for Monte Carlo Rendering",
//! SIGGRAPH 1995, figure 2: the plates grow rougher towards the viewer, the lights grow from a
//! point to a ball, all of equal power. Dimensions are this project's: each plate is turned so that
//! the row of lights is mirrored in its middle.
//!
//! **Known in closed form.** Each light is a convex polyhedron of uniform radiance L and area A, so
//! its power is Φ = π·L·A; L is chosen so that its luminance is [`POWER`]. A sphere of power Φ,
//! wholly above the horizon at distance d, gives the irradiance Φ·cosθ/(4π·d²) whatever its radius;
//! a convex polyhedron does so in the mean over directions (Cauchy: its mean projection is A/4),
//! and these to within 1 % in each.

use std::f64::consts::PI;

use glam::DVec3;
use surelight_scene::Scene;

use crate::builder::{Builder, emitter, lambert, metal};
use crate::shapes::Shape;

/// GGX α of the plates, from the back to the front.
pub const ALPHAS: [f64; 4] = [0.005, 0.02, 0.05, 0.1];

/// Luminous power of each light (Rec. 709 luminance of π·L·A).
pub const POWER: f64 = 36.0;

/// Radius, place and tint of the lights.
const LIGHTS: [(f64, f64, [f64; 3]); 4] = [
    (0.03, -3.5, [1.0, 0.42, 0.30]),
    (0.1, -1.4, [1.0, 0.80, 0.35]),
    (0.3, 0.75, [0.45, 1.0, 0.62]),
    (0.9, 3.3, [0.38, 0.62, 1.0]),
];

/// Height and depth of the row of lights.
const ROW: DVec3 = DVec3::new(0.0, 2.7, -0.6);

/// Middles of the plates.
const PLATES: [DVec3; 4] = [
    DVec3::new(0.0, 0.78, -1.05),
    DVec3::new(0.0, 0.12, 0.15),
    DVec3::new(0.0, -0.36, 1.45),
    DVec3::new(0.0, -0.68, 2.80),
];

const EYE: DVec3 = DVec3::new(0.0, 2.6, 13.0);

/// The scene.
pub fn veach_mis() -> Scene {
    let mut b = Builder::new("veach-mis");
    let room = b.material(lambert("room", [0.36, 0.37, 0.40]));
    b.add("room", Shape::cyclorama(9.0, 6.0, 2.6, 1.2, 9.0).placed(1.0, DVec3::NEG_Y), room);
    for (alpha, middle) in ALPHAS.into_iter().zip(PLATES) {
        let material = b.material(metal(&format!("alpha {alpha}"), [0.92, 0.92, 0.94], alpha));
        let normal = ((EYE - middle).normalize() + (ROW - middle).normalize()).normalize();
        let plate = Shape::parallelogram(middle, DVec3::X * 4.0, normal.cross(DVec3::X) * 0.48);
        b.add(&format!("plate {alpha}"), plate, material);
    }
    for (radius, x, tint) in LIGHTS {
        let subdivisions = if radius < 0.2 { 2 } else { 3 };
        let ball = Shape::icosphere(subdivisions).placed(radius, ROW + DVec3::X * x).faceted();
        let luminance = 0.2126 * tint[0] + 0.7152 * tint[1] + 0.0722 * tint[2];
        let radiance = tint.map(|c| (c / luminance * POWER / (PI * ball.area())) as f32);
        let light = b.material(emitter(&format!("light {radius}"), radiance));
        b.add(&format!("light {radius}"), ball, light);
    }
    b.camera(EYE, DVec3::new(0.0, 1.22, 0.0), 28.0, 4.0 / 3.0);
    b.finish()
}
