//! A glass ball, a lens and a tinted slab on a diffuse floor under a small lamp: caustics.
//!
//! The caustics are light that reaches a diffuse floor through smooth glass: light sampling cannot
//! connect them, BSDF sampling finds the small lamp by chance.
//!
//! **Known in closed form.** n = [`IOR`]. The ball focuses paraxial light n·R/(2(n − 1)) behind its
//! middle ([`ball_focus`]: R/2 behind its surface); the lens has R/(2(n − 1)) as its focal length,
//! but for its thickness. At normal incidence each face reflects r = ((n − 1)/(n + 1))² = 0.04, and
//! the slab with one-way absorption τ transmits (1 − r)²τ/(1 − r²τ²): the sum over internal
//! reflections (Born and Wolf, Principles of Optics, 1.6).

use glam::{DAffine3, DQuat, DVec3};
use surelight_scene::{Scene, Volume};

use crate::builder::{Builder, emitter, glass as clear_glass, lambert};
use crate::shapes::Shape;

/// Refractive index of everything made of glass here.
pub const IOR: f32 = 1.5;

/// Radius of the ball, metres.
pub const BALL_RADIUS: f64 = 0.5;

/// Distance of the paraxial focus from the middle of the ball, metres.
pub fn ball_focus() -> f64 {
    let n = f64::from(IOR);
    n * BALL_RADIUS / (2.0 * (n - 1.0))
}

/// The scene.
pub fn glass() -> Scene {
    let mut b = Builder::new("glass");
    let floor = b.material(lambert("floor", [0.74, 0.71, 0.66]));
    let clear = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let tinted = Volume { attenuation_distance: 0.3, attenuation_color: [0.12, 0.62, 0.58] };
    let ball = b.material(clear_glass("clear glass", IOR, clear));
    let slab = b.material(clear_glass("tinted glass", IOR, tinted));
    let key = b.material(emitter("lamp", [80.0, 72.0, 61.0]));
    let fill = b.material(emitter("panel", [1.7, 2.0, 2.5]));

    b.add("floor", Shape::cyclorama(6.0, 4.0, 2.4, 1.2, 5.0), floor);
    // The glass is slightly above the floor: coincident surfaces would be a matter of chance.
    let gap = 1e-3;
    let at = DVec3::new(-0.68, BALL_RADIUS + gap, 0.0);
    b.add("ball", Shape::icosphere(4).placed(BALL_RADIUS, at), ball);

    let turn = DQuat::from_rotation_y(-0.35);
    let plate = Shape::cuboid(DVec3::new(-0.42, 0.0, -0.06), DVec3::new(0.42, 0.9, 0.06));
    let at = DVec3::new(0.78, gap, -0.25);
    b.add("slab", plate.transformed(&DAffine3::from_rotation_translation(turn, at)), slab);

    // The lens leans with its axis towards the lamp.
    let lamp = DVec3::new(-1.5, 2.9, -2.0);
    let lens_at = DVec3::new(0.34, 0.26, 0.70);
    let axis = DQuat::from_rotation_arc(DVec3::Y, (lamp - lens_at).normalize());
    let lens = Shape::lens(0.55, 0.3, 10, 64);
    b.add("lens", lens.transformed(&DAffine3::from_rotation_translation(axis, lens_at)), ball);

    b.add("lamp", Shape::panel(lamp, DVec3::new(0.0, 0.2, 0.1), 0.28, 0.28), key);
    b.add("panel", Shape::panel(DVec3::new(3.4, 2.6, 2.4), DVec3::new(0.0, 0.5, 0.0), 1.0, 1.2), fill);

    // An object behind the glass.
    let bars: [(f64, f64, [f32; 3]); 6] = [
        (-1.5, 0.62, [0.62, 0.12, 0.08]),
        (-1.05, 0.95, [0.75, 0.42, 0.08]),
        (-0.6, 0.78, [0.10, 0.30, 0.42]),
        (0.35, 0.70, [0.68, 0.62, 0.52]),
        (0.8, 1.05, [0.60, 0.16, 0.14]),
        (1.25, 0.55, [0.78, 0.55, 0.14]),
    ];
    for (index, (x, height, color)) in bars.into_iter().enumerate() {
        let material = b.material(lambert(&format!("bar {index}"), color));
        let lo = DVec3::new(x - 0.13, 0.0, -1.40);
        b.add(&format!("bar {index}"), Shape::cuboid(lo, lo + DVec3::new(0.26, height, 0.16)), material);
    }

    b.camera(DVec3::new(0.25, 1.45, 3.9), DVec3::new(0.05, 0.36, 0.0), 28.0, 1.5);
    b.finish()
}
