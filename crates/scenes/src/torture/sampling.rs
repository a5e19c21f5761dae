//! Estimators and their error bars with rare, deep or many paths: cases 20 to 26.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use surelight_scene::Scene;

use super::Case;
use crate::builder::{Builder, emitter, lambert};
use crate::shapes::Shape;
use crate::{Entry, cornell_box, furnace, polygon_irradiance};

/// The group's cases. The χ² tests (20) are of sampling routines and have no scene; the Cornell box
/// of 21, 25 and 26 is `assets/cornell-box.glb`.
pub const CASES: &[Case] = &[
    Case::generated(21, cornell("hemisphere-area-mis", "Every unbiased estimator has one mean.")),
    Case::new(
        22,
        Entry {
            name: "rr-on-off",
            shows: "A closed room of reflectance 0.99: light that stays for a hundred bounces.",
            known: "Every pixel is Le/(1 − ρ) = 1, with roulette and without.",
            build: || room(0.99),
        },
    ),
    Case::new(
        23,
        Entry {
            name: "depth-series",
            shows: "A closed room of reflectance 7/8 that emits 1/8.",
            known: "After D bounces every pixel is 1 − (7/8)^(D + 1).",
            build: || room(0.875),
        },
    ),
    Case::new(
        24,
        Entry {
            name: "optional-stop",
            shows: "A floor under a small lamp that one of 64 uniform directions hits.",
            known: "Lambert's polygon formula; by uniform directions a sample is 0 or about 64 times the mean.",
            build: || spot(1.0 / 64.0).0,
        },
    ),
    Case::generated(25, cornell("replicates", "95 % intervals hold the truth in 95 ± 2 % of renders.")),
    Case::generated(26, cornell("slope", "Independent samples err as N^−0.5, Sobol points by less.")),
];

const fn cornell(name: &'static str, known: &'static str) -> Entry {
    Entry { name, shows: "The Cornell box.", known, build: cornell_box::cornell_box }
}

/// The empty furnace with this reflectance everywhere, which emits so that every pixel is 1.
pub fn room(reflectance: f32) -> Scene {
    let mut scene = furnace::bare_room();
    for material in &mut scene.materials {
        material.base_color = [reflectance, reflectance, reflectance, 1.0];
        material.emissive = [1.0 - reflectance; 3];
    }
    scene
}

/// Radiance of the lamp of [`spot`].
const RADIANCE: f32 = 10.0;
/// Reflectance of its floor.
const REFLECTANCE: f32 = 0.5;

/// A floor under a square lamp at height 1 that a share `p` of uniform directions hits, and the
/// radiance of all pixels: the picture is of a spot so small that they are equal.
pub fn spot(p: f64) -> (Scene, f64) {
    let half = 0.5 * (TAU * p).sqrt();
    let mut b = Builder::new(&format!("a lamp met by {p:.4} of directions"));
    let floor = b.material(lambert("floor", [REFLECTANCE; 3]));
    let lamp = b.material(emitter("lamp", [RADIANCE; 3]));
    b.add("floor", Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), floor);
    b.add("lamp", Shape::parallelogram(DVec3::Y, DVec3::X * half, DVec3::Z * half), lamp);
    b.camera(DVec3::new(1.0, 0.5, 1.0), DVec3::ZERO, 1e-3, 1.0);
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, z)| DVec3::new(x, 1.0, z));
    let irradiance = polygon_irradiance(DVec3::ZERO, DVec3::Y, &corners) * f64::from(RADIANCE);
    (b.finish(), irradiance * f64::from(REFLECTANCE) / PI)
}
