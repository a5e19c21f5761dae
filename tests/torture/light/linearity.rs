//! Light adds up: many lights are the sum of each alone.

use surelight_estimate::{Estimate, sidak_level, welch_test, z_test};
use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_scenes::torture::light as scenes;
use surelight_scenes::torture::light::{linearity_radiance, many_lamps, many_lamps_radiance};
use surelight_tests::render::{ALPHA, all, pooled, render};

const SIDE: u32 = 16;
/// Comparisons in this file.
const COMPARISONS: usize = 7;

/// Points of the floor over the picture, evenly.
fn grid(n: u32) -> Vec<[f64; 2]> {
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
    (0..n * n).map(|k| [at(k % n), at(k / n)]).collect()
}

/// Holds the mean of a picture against that of the closed form on grids of `n` and `2n` points per
/// side.
fn check(name: &str, film: &Film, n: u32, radiance: impl Fn(&[[f64; 2]]) -> Vec<f64>) {
    let mean_of = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let (coarse, exact) = (mean_of(radiance(&grid(n))), mean_of(radiance(&grid(2 * n))));
    let mean = pooled(film, 1, all(film));
    // The midpoint rule errs by a quarter of its change at most.
    let error = mean.variance.sqrt().hypot(0.5 * (exact - coarse)).hypot(1e-6 * exact);
    let level = sidak_level(ALPHA, COMPARISONS);
    let test = z_test(mean.mean, error, exact, level);
    let seen = 100.0 * test.detectable / exact;
    println!(
        "{name}: {:+.3} % from the sum, z {:+.2}; a bias of {seen:.2} % would be detected",
        100.0 * (mean.mean / exact - 1.0),
        test.z
    );
    assert!(test.p > level, "{name}: {} instead of {exact}, z = {:.2}", mean.mean, test.z);
    assert!(seen < 2.0, "{name}: only {seen} % would be detected");
}

fn settings(seed: u32) -> Settings {
    Settings { seed, ..Settings::new(SIDE, SIDE) }
}

/// One to 100,000 point lights against the sum of their formulas, up to 10,000 lamps against
/// Lambert's, and eight lamps against the sum of eight pictures with one of them lit.
#[test]
fn linearity() {
    for (n, seed) in [(1, 1), (16, 2), (1000, 3), (100_000, 4)] {
        let film = render(&scenes::linearity(n), &settings(seed), 16, 64);
        check(&format!("{n} point lights"), &film, if n > 1000 { 8 } else { 64 }, |points| {
            linearity_radiance(n, points)
        });
    }
    for (n, seed) in [(100, 5), (10_000, 6)] {
        let film = render(&many_lamps(n, None), &settings(seed), 16, 64);
        check(&format!("{n} lamps"), &film, if n > 1000 { 8 } else { 32 }, |points| many_lamps_radiance(n, points));
    }
    let together = render(&many_lamps(8, None), &settings(7), 16, 64);
    let mut sum = Estimate { mean: 0.0, variance: 0.0, dof: 0.0 };
    for k in 0..8 {
        let film = render(&many_lamps(8, Some(k)), &settings(8 + k), 16, 16);
        let one = pooled(&film, 1, all(&film));
        sum = Estimate { mean: sum.mean + one.mean, variance: sum.variance + one.variance, dof: sum.dof + one.dof };
    }
    let test = welch_test(&pooled(&together, 1, all(&together)), &sum);
    println!(
        "8 lamps together: {:+.3} % ± {:.3} % from their sum",
        100.0 * test.difference / sum.mean,
        100.0 * test.standard_error / sum.mean
    );
    assert!(test.p > sidak_level(ALPHA, COMPARISONS), "{test:?}");
    assert!(4.6 * test.standard_error < 0.02 * sum.mean, "no power: {test:?}");
}
