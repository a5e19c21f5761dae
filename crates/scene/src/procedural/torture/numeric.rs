//! Numbers at the ends of f32: cases 1 to 8.

use super::super::{Entry, probes};
use super::Case;
use crate::{Environment, Scene};

/// The group's cases.
pub const CASES: &[Case] = &[Case::new(
    1,
    Entry {
        name: "zero-variance-furnace",
        shows: "A convex diffuse ball under a uniform sky (`--sky 1,2,0.3`).",
        known: "Light is reflected once at most: each sample that meets the ball is ρ·L = (0.8, 0.9, 0.108), each other \
                one L, within 4 ULP and without variance.",
        build: zero_variance_furnace,
    },
)];

/// Reflectance of the ball of [`zero_variance_furnace`].
pub const FURNACE_REFLECTANCE: [f32; 3] = [0.8, 0.45, 0.36];

/// Radiance of the sky of [`zero_variance_furnace`].
pub const FURNACE_SKY: [f32; 3] = [1.0, 2.0, 0.3];

/// A faceted ball of reflectance ρ under a sky L: ρ·L in each sample that meets it, since a convex body reflects light once and
/// the weight of a direction sampled by the cosine is ρ itself.
pub fn zero_variance_furnace() -> Scene {
    let mut scene = probes::convex_furnace(FURNACE_REFLECTANCE, 3);
    scene.name = "zero-variance-furnace".to_owned();
    scene.environment = Some(Environment::Uniform(FURNACE_SKY));
    scene
}
