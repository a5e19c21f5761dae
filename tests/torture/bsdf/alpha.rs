//! Sixty-four sheets that let most of the light through.

use std::f64::consts::PI;

use surelight_prepare::Settings;
use surelight_scenes::torture::bsdf as scenes;
use surelight_tests::render::{Judge, render};

/// (1 − α)⁶⁴ for the view through the sheets, and for the light through them onto a floor.
#[test]
fn alpha_64() {
    let alphas = [0.002f32, 0.02, 0.06];
    for (alpha, seed) in alphas.into_iter().zip(0..) {
        // As 8 bits of a file's base colour would not: factors are floats.
        let transmittance = (1.0 - f64::from(alpha)).powi(64);
        let settings = |seed| Settings { seed, ..Settings::new(32, 32) };
        let judge = Judge::of(2 * alphas.len(), 0.05);
        let seen = render(&scenes::alpha_64(alpha), &settings(2 * seed), 16, 32);
        judge.mean(&format!("view through α {alpha}"), &seen, [transmittance; 3]);
        let lit = render(&scenes::alpha_64_shadow(alpha), &settings(2 * seed + 1), 16, 32);
        judge.mean(&format!("lit through α {alpha}"), &lit, [0.5 / PI * transmittance; 3]);
    }
}
