//! A valley with a lake at night under 2,000 small glowing triangles: hundreds of paper lanterns, a
//! dozen of which dominate.
//!
//! **Known in closed form.** Each lantern is convex and of uniform radiance, so its power is π·L·A;
//! [`powers`] lists them. Light adds: a picture of all lanterns is the sum of the pictures with one
//! of them lit (`linearity` in `docs/testing.md`). The picture itself has no closed form.

use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3};
use surelight_scene::{Material, Scene};

use crate::builder::{Builder, emitter, lambert};
use crate::random::{SplitMix, fractal_noise};
use crate::shapes::Shape;

/// Small lanterns: octahedra, 8 triangles each.
pub const SMALL: usize = 220;

/// Dominating lanterns: icosahedra, 20 triangles each.
pub const LARGE: usize = 12;

/// Colours of the small lanterns, radiance before [`SMALL_STRENGTH`].
const PALETTE: [[f32; 3]; 8] = [
    [1.0, 0.45, 0.12],
    [1.0, 0.62, 0.22],
    [1.0, 0.30, 0.10],
    [1.0, 0.78, 0.42],
    [1.0, 0.25, 0.32],
    [0.95, 0.35, 0.70],
    [0.30, 0.75, 0.85],
    [0.45, 0.50, 1.0],
];

const SMALL_STRENGTH: f32 = 2.75;
const LARGE_RADIANCE: [f32; 3] = [38.0, 21.0, 8.5];
const HALF_WIDTH: f64 = 14.0;
const WATER: f64 = 0.0;

/// The scene: a terrain of 64 × 64 cells, a lake, the lanterns.
pub fn many_lights() -> Scene {
    let mut b = Builder::new("many-lights");
    let ground = b.material(lambert("snow", [0.86, 0.88, 0.92]));
    let terrain = Shape::height_field(64, true, |x, z| height(x * HALF_WIDTH, z * HALF_WIDTH) / HALF_WIDTH);
    b.add("terrain", terrain.placed(HALF_WIDTH, DVec3::ZERO), ground);
    let water = b.material(Material {
        name: "water".to_owned(),
        base_color: [0.006, 0.012, 0.016, 1.0],
        metallic: 0.0,
        roughness: 0.12,
        ior: 1.333,
        double_sided: true,
        ..Material::default()
    });
    let lake = Shape::parallelogram(DVec3::Y * WATER, DVec3::X * HALF_WIDTH, DVec3::NEG_Z * HALF_WIDTH);
    b.add("lake", lake, water);

    for (index, shape) in small_lanterns().into_iter().enumerate() {
        let light = b.material(emitter(&format!("lantern {index}"), PALETTE[index].map(|c| c * SMALL_STRENGTH)));
        b.add(&format!("lanterns {index}"), shape, light);
    }
    let light = b.material(emitter("large lantern", LARGE_RADIANCE));
    let mut large = Shape::default();
    for lantern in large_lanterns() {
        large.append(lantern);
    }
    b.add("large lanterns", large, light);
    b.camera(DVec3::new(0.4, 1.5, 12.2), DVec3::new(0.0, 1.15, 0.0), 34.0, 16.0 / 9.0);
    b.finish()
}

/// Power of each group of lanterns per channel: the eight colours of small ones, then each large
/// one.
pub fn powers() -> Vec<[f64; 3]> {
    let power = |radiance: [f32; 3], area: f64| radiance.map(|l| PI * f64::from(l) * area);
    let small = small_lanterns();
    let mut all: Vec<_> =
        (0..PALETTE.len()).map(|i| power(PALETTE[i].map(|c| c * SMALL_STRENGTH), small[i].area())).collect();
    all.extend(large_lanterns().iter().map(|s| power(LARGE_RADIANCE, s.area())));
    all
}

/// Height of the ground over (x, z), metres: a valley along z, hills towards its sides, a ridge at
/// its end.
fn height(x: f64, z: f64) -> f64 {
    let winding = x - 1.6 * (z * 0.22).sin();
    let sides = 0.055 * winding * winding;
    let end = 0.9 * ((-z - 6.0) / 4.0).max(0.0);
    let rough = 0.75 * fractal_noise(DVec3::new(x * 0.33, 0.0, z * 0.33), 5);
    -0.75 + sides + end + rough * (0.35 + 0.16 * winding.abs())
}

/// The small lanterns by colour.
fn small_lanterns() -> Vec<Shape> {
    let mut random = SplitMix::new(2);
    let mut groups = vec![Shape::default(); PALETTE.len()];
    for i in 0..SMALL {
        let (x, z) = (random.range(-9.0, 9.0), random.range(-11.0, 9.0));
        let y = height(x, z).max(WATER) + random.range(0.12, 1.0) + 2.2 * random.unit().powi(4);
        let size = random.range(0.05, 0.11);
        groups[i % PALETTE.len()].append(lantern(DVec3::new(x, y, z), size, random.range(0.0, PI)));
    }
    groups
}

/// The large lanterns, in two rows along the water.
fn large_lanterns() -> Vec<Shape> {
    let mut random = SplitMix::new(7);
    (0..LARGE)
        .map(|i| {
            let side = if i % 2 == 0 { -1.0 } else { 1.0 };
            let z = 5.0 - 2.6 * (i / 2) as f64 + random.range(-0.7, 0.7);
            let x = 1.6 * (z * 0.22).sin() + side * random.range(2.0, 3.4);
            let y = height(x, z).max(WATER) + random.range(0.5, 1.0);
            Shape::icosphere(0).faceted().placed(random.range(0.15, 0.22), DVec3::new(x, y, z))
        })
        .collect()
}

/// An octahedron, taller than wide.
fn lantern(at: DVec3, size: f64, turn: f64) -> Shape {
    let mut shape = Shape::default();
    for k in 0..4 {
        let (sin, cos) = (f64::from(k) * PI / 2.0).sin_cos();
        shape.positions.push(DVec3::new(cos, 0.0, -sin));
    }
    shape.positions.extend([DVec3::Y * 1.4, DVec3::Y * -1.4]);
    for k in 0..4u32 {
        let next = (k + 1) % 4;
        shape.triangles.extend([[k, next, 4], [next, k, 5]]);
    }
    let turn = DQuat::from_rotation_y(turn);
    shape.transformed(&DAffine3::from_scale_rotation_translation(DVec3::splat(size), turn, at))
}
