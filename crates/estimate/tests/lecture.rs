//! The worked examples of the lecture that the project starts from: Bala, "Monte Carlo Rendering",
//! CS 6620.

use surelight_estimate::{Moments, Rule, chebyshev_half_width, integrate, sobol};

#[test]
fn average_die() {
    // The lecture's example has the faces 2, 3, 3, 4, 4, 5: E = 3.5, σ² = E[x²] − E[x]² = 79/6 −
    // 49/4 = 11/12. Each face once is the whole population.
    let die: Moments = [2.0, 3.0, 3.0, 4.0, 4.0, 5.0].into_iter().collect();
    assert!((die.mean() - 3.5).abs() < 1e-15);
    assert!((die.population_variance() - 11.0 / 12.0).abs() < 1e-15);
}

#[test]
fn ordinary_die() {
    // The same mean with more spread: σ² = 91/6 − 49/4 = 35/12.
    let die: Moments = (1..=6).map(f64::from).collect();
    assert!((die.mean() - 3.5).abs() < 1e-15);
    assert!((die.population_variance() - 35.0 / 12.0).abs() < 1e-14);
}

#[test]
fn primary_estimators_of_5x4() {
    // I = ∫₀¹ 5x⁴ dx = 1 with uniform samples: f(x)/p(x) = 5x⁴.
    let samples = [0.86, 0.41, 0.02, 0.38];
    let primary = samples.map(|x: f64| 5.0 * x.powi(4));
    let expected = [2.735_040_8, 0.141_288_05, 8e-7, 0.104_256_8];
    for (found, expected) in primary.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found}");
    }
    // The lecture states the running mean, the secondary estimator: 2.74, 1.44, 0.96, 0.75.
    let mut moments = Moments::default();
    for (x, expected) in primary.into_iter().zip([2.74, 1.44, 0.96, 0.75]) {
        moments.push(x);
        assert!((moments.mean() - expected).abs() <= 0.005, "{}", moments.mean());
    }
}

#[test]
fn variance_of_5x4_is_16_ninths() {
    // "variance: what is it?" ∫(5x⁴)² − 1 = 25/9 − 1.
    let second = integrate(Rule::GaussLegendre, 5, [0.0, 1.0], |x| (5.0 * x.powi(4)).powi(2)).unwrap();
    assert!((second - 1.0 - 16.0 / 9.0).abs() < 1e-13);
    assert!((integrate(Rule::GaussLegendre, 3, [0.0, 1.0], |x| 5.0 * x.powi(4)).unwrap() - 1.0).abs() < 1e-13);

    // And as estimated: for 2²⁰ samples the standard error of s² is √((μ₄ − σ⁴)/N), with μ₄ by
    // quadrature; 4 of them.
    let fourth = integrate(Rule::GaussLegendre, 9, [0.0, 1.0], |x| (5.0 * x.powi(4) - 1.0).powi(4)).unwrap();
    let n = 1u32 << 20;
    let samples: Moments =
        (0..n).map(|i| 5.0 * f64::from(sobol::unit_from_bits(sobol::hash_combine(i, 1))).powi(4)).collect();
    let error = ((fourth - (16.0f64 / 9.0).powi(2)) / f64::from(n)).sqrt();
    assert!((samples.variance() - 16.0 / 9.0).abs() < 4.0 * error, "{}", samples.variance());
    assert!((samples.mean() - 1.0).abs() < 4.0 * (16.0 / 9.0 / f64::from(n)).sqrt());
    // Chebyshev at δ = 1 %: off by more than 10 standard errors at most once in a hundred.
    assert!(
        (chebyshev_half_width(0.01, samples.variance_of_mean().sqrt()) / 10.0 - samples.variance_of_mean().sqrt())
            .abs()
            < 1e-12
    );
}

#[test]
fn error_falls_as_one_over_root_n() {
    // RMS error over 2,000 runs at 16 and at 1024 independent samples. The relative standard error
    // of an RMS is 1/√(2·2000), and the slope over log₂ 64 = 6 doublings has 0.0054: ±0.02 is 3.7
    // of them.
    let rms = |n: u32| {
        let squares: Moments = (0..2000)
            .map(|run| {
                let key = sobol::hash_combine(run, n);
                let sum: f64 =
                    (0..n).map(|i| 5.0 * f64::from(sobol::unit_from_bits(sobol::hash_combine(key, i))).powi(4)).sum();
                (sum / f64::from(n) - 1.0).powi(2)
            })
            .collect();
        squares.mean().sqrt()
    };
    let slope = (rms(1024) / rms(16)).log2() / 6.0;
    assert!((slope + 0.5).abs() < 0.02, "{slope}");
}
