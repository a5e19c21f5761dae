//! Total internal reflection: the cone in which the sky is visible from under water.

use surelight_prepare::Settings;
use surelight_scenes::torture::bsdf::{self as scenes, TIR_HALF_VIEW};
use surelight_tests::bsdf_oracle::fresnel_exact;
use surelight_tests::render::render;

const SIDE: u32 = 64;

/// Within asin(1/n) of the vertical a pixel is n²·(1 − F), beyond it exactly 0; the edge is within
/// a pixel of its place.
///
/// Below one pixel from the edge, the value is tested in the inner three quarters of the cone's
/// radius, where F changes little over a pixel: 64 samples estimate a mean over them to some 0.1 %,
/// and the pixels' own formula to 2·10⁻³.
#[test]
fn tir_cone() {
    for ior in [1.333f32, 1.5, 2.4] {
        let film = render(&scenes::tir_cone(ior), &Settings::new(SIDE, SIDE), 16, 4);
        let n = f64::from(ior);
        let tangent = TIR_HALF_VIEW.to_radians().tan();
        // Pixels for one of tan θ.
        let scale = 0.5 * f64::from(SIDE) / tangent;
        let edge = (1.0 / (n * n - 1.0)).sqrt() * scale;
        let (mut sum, mut exact, mut dark, mut worst) = (0.0, 0.0, 0, 0.0_f64);
        for i in 0..SIDE * SIDE {
            let [x, y] = [i % SIDE, i / SIDE].map(|k| f64::from(k) + 0.5 - 0.5 * f64::from(SIDE));
            let (radius, value) = (x.hypot(y), film.mean(i as usize)[1]);
            // Half a pixel's diagonal, and a tolerance of one pixel.
            if radius > edge + 1.0 + std::f64::consts::FRAC_1_SQRT_2 {
                assert_eq!(value, 0.0, "n = {ior}: light beyond the cone, {:.2} pixels from its edge", radius - edge);
                dark += 1;
            } else if radius < edge - 1.0 - std::f64::consts::FRAC_1_SQRT_2 {
                assert!(value > 0.0, "n = {ior}: dark within the cone, {:.2} pixels from its edge", edge - radius);
            }
            if radius < 0.75 * edge {
                let cosine = 1.0 / (1.0 + (radius / scale).powi(2)).sqrt();
                sum += value;
                exact += n * n * (1.0 - fresnel_exact(cosine, 1.0 / n));
                worst = worst.max((value / (n * n) - 1.0).abs());
            }
        }
        println!(
            "n = {ior}: edge at {edge:.2} pixels, {dark} dark; within it {:+.3} % from n²·(1 − F)",
            100.0 * (sum / exact - 1.0)
        );
        assert!(dark > 100 && (sum / exact - 1.0).abs() < 0.01, "n = {ior}: {sum} instead of {exact}");
    }
}
