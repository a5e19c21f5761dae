//! The depth series: after D bounces a closed room shows the first D + 1 terms of Le·Σ ρᵏ.

use surelight_prepare::{Directions, Integrator, Settings};
use surelight_scenes::torture;
use surelight_tests::render::{all, prepare, trace, ulps};

/// Without light sampling the room's series is summed along each path: every single sample is Le·Σ
/// ρᵏ, exact but for rounding, as long as roulette keeps the path (throughput above ⅓).
#[test]
fn depth_series() {
    let (rho, emission) = (0.875f32, 0.125f32);
    let scene = torture::scene("depth-series");
    for bounces in [0, 1, 4, 8] {
        let integrator = Integrator::Hemisphere(Directions::Bsdf);
        let settings = Settings { max_bounces: Some(bounces), integrator, ..Settings::new(32, 32) };
        let prepared = prepare(&scene, &settings);
        let film = trace(&prepared, [32, 32], 1, 1);
        let truth: f64 = (0..=bounces).map(|k| f64::from(emission) * f64::from(rho).powi(k as i32)).sum();
        let worst = all(&film).map(|i| ulps(film.mean(i)[0] as f32, truth as f32)).max();
        println!("after {bounces} bounces {truth}, within {worst:?} ULP");
        // One rounding for each product and sum.
        assert!(worst <= Some(2 + 2 * bounces), "{worst:?} ULP from {truth}");
    }
}
