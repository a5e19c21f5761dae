//! Light by way of mirrors alone.

use surelight_prepare::Settings;
use surelight_scenes::probes;
use surelight_tests::render::{all, render};

/// Light between two mirrors: Fᵏ after k reflections, without variance while roulette keeps the
/// path.
#[test]
fn mirror_corridor() {
    let f0 = [0.95f32, 0.9, 0.8];
    for bounces in [0, 1, 2, 5, 12] {
        let film = render(&probes::mirror_corridor(bounces, f0), &Settings::new(16, 16), 4, 4);
        let truth = probes::mirror_corridor_radiance(bounces, f0.map(f64::from));
        for i in all(&film) {
            for (value, truth) in film.mean(i).into_iter().zip(truth) {
                assert!((value / truth - 1.0).abs() < 1e-5, "{bounces} mirrors: {value} instead of {truth}");
            }
        }
    }
}
