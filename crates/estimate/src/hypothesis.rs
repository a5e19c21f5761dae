//! Tests of means, with the differences that they can and cannot detect.

use crate::{normal_quantile, normal_survival, student_t_survival};

/// A mean with the variance of that mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Variance of the mean (not of one sample); 0 for a known value.
    pub variance: f64,
    /// Degrees of freedom of the variance; infinite where it is known.
    pub dof: f64,
}

impl Estimate {
    /// A value known without error.
    pub fn exact(mean: f64) -> Self {
        Self { mean, variance: 0.0, dof: f64::INFINITY }
    }
}

/// Degrees of freedom of a sum of independent variances, given as pairs of variance and its degrees
/// of freedom: (Σv)² / Σ(v²/ν) (Satterthwaite, "An approximate distribution of estimates of
/// variance components", Biometrics 2 (1946)). Infinite where all variances are 0.
pub fn satterthwaite(terms: &[(f64, f64)]) -> f64 {
    let sum: f64 = terms.iter().map(|&(variance, _)| variance).sum();
    // Normalised first: variances of dim pixels squared would underflow.
    let spread: f64 = terms.iter().filter(|term| term.0 > 0.0).map(|&(v, dof)| (v / sum).powi(2) / dof).sum();
    // An empty sum is −0, whose reciprocal would be −∞.
    if spread > 0.0 { 1.0 / spread } else { f64::INFINITY }
}

/// Result of [`welch_test`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WelchTest {
    /// Mean of the first less mean of the second.
    pub difference: f64,
    /// Standard error of the difference.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub dof: f64,
    /// Probability of at least this difference, either way, between equal means.
    pub p: f64,
}

/// Welch's test that two means are equal where their variances need not be (Welch, Biometrika 34
/// (1947); as a judge of renderers: Jung, Hanika, Dachsbacher, "Detecting bias in Monte Carlo
/// renderers using Welch's t-test", JCGT 9(2) (2020)). Where neither has variance, p is 1 for equal
/// and 0 for different means.
pub fn welch_test(a: &Estimate, b: &Estimate) -> WelchTest {
    let difference = a.mean - b.mean;
    let standard_error = (a.variance + b.variance).sqrt();
    let dof = satterthwaite(&[(a.variance, a.dof), (b.variance, b.dof)]);
    let p = if standard_error == 0.0 {
        if difference == 0.0 { 1.0 } else { 0.0 }
    } else {
        2.0 * student_t_survival((difference / standard_error).abs(), dof)
    };
    WelchTest { difference, standard_error, dof, p }
}

/// Result of [`z_test`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZTest {
    /// Difference from the truth in standard errors.
    pub z: f64,
    /// Probability of at least this |z| where the truth holds.
    pub p: f64,
    /// The difference from the truth that a test at the requested level would miss once in ten.
    pub detectable: f64,
}

/// Tests a mean with a well-known standard error against a truth; `alpha` is the level that
/// `detectable` is stated for.
pub fn z_test(mean: f64, standard_error: f64, truth: f64, alpha: f64) -> ZTest {
    let difference = mean - truth;
    let z = if difference == 0.0 { 0.0 } else { difference / standard_error };
    ZTest { z, p: 2.0 * normal_survival(z.abs()), detectable: detectable_bias(standard_error, alpha, 0.9) }
}

/// The smallest bias that a two-sided test at level `alpha` finds with probability `power`:
/// (z₁₋α/₂ + z_power) standard errors; 3.857 of them at α = 0.01 and power 0.9.
pub fn detectable_bias(standard_error: f64, alpha: f64, power: f64) -> f64 {
    (normal_quantile(1.0 - 0.5 * alpha) + normal_quantile(power)) * standard_error
}

/// Samples that a two-sided test at level `alpha` needs to find a relative bias with probability
/// `power`, where one sample has the coefficient of variation `cv` (σ/mean): 14.9·(cv/bias)² at α =
/// 0.01 and power 0.9.
pub fn samples_to_detect(cv: f64, bias: f64, alpha: f64, power: f64) -> f64 {
    (detectable_bias(cv, alpha, power) / bias).powi(2)
}

/// Level of each of `tests` independent tests for which any false alarm has probability `alpha`: 1
/// − (1−α)^(1/m) (Šidák, "Rectangular confidence regions for the means of multivariate normal
/// distributions", JASA 62 (1967)). On the safe side for positively dependent tests of normal
/// means.
pub fn sidak_level(alpha: f64, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-alpha) / tests as f64)
}

/// The smallest of `tests` independent p-values, corrected for the choice among them: 1 − (1−p)^m.
pub fn sidak_adjusted(smallest_p: f64, tests: usize) -> f64 {
    -f64::exp_m1(f64::ln_1p(-smallest_p) * tests as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;
    use crate::{Moments, uniformity_test};

    #[test]
    fn power_matches_the_published_figure() {
        assert!((samples_to_detect(1.0, 1.0, 0.01, 0.9) - 14.879).abs() < 0.001);
        assert!((samples_to_detect(2.0, 0.01, 0.01, 0.9) / 4e4 - 14.879).abs() < 0.001);
        assert!((detectable_bias(2.0, 0.05, 0.8) - 2.0 * (1.959964 + 0.841621)).abs() < 1e-5);
    }

    #[test]
    fn power_is_what_it_says() {
        // A bias of the detectable size is found in 90 % of 4,000 trials: 5 standard errors are 2.4
        // %.
        let mut random = Random::new(11);
        let bias = detectable_bias(1.0, 0.01, 0.9);
        let found = (0..4000).filter(|_| z_test(bias + random.normal(), 1.0, 0.0, 0.01).p < 0.01).count();
        assert!((found as f64 / 4000.0 - 0.9).abs() < 0.024, "{found}");
    }

    #[test]
    fn welch_worked_example() {
        // Two samples by hand: means 3 and 5, s² = 2.5 (n 5) and 6 (n 4): v = 0.5 and 1.5, t =
        // −2/√2, ν = 4 / (0.25/4 + 2.25/3) = 4.923077.
        let a: Moments = [1.0, 2.0, 3.0, 4.0, 5.0].into_iter().collect();
        let b: Moments = [2.0, 4.0, 6.0, 8.0].into_iter().collect();
        let of = |m: &Moments, variance: f64| Estimate { mean: m.mean(), variance, dof: m.count() as f64 - 1.0 };
        assert!((b.variance() - 20.0 / 3.0).abs() < 1e-12);
        let test = welch_test(&of(&a, a.variance_of_mean()), &of(&b, 1.5));
        assert!((test.dof - 4.0 / (0.0625 + 0.75)).abs() < 1e-12);
        assert!((test.difference / test.standard_error + 2f64.sqrt()).abs() < 1e-12);
        assert!((test.p - 2.0 * student_t_survival(2f64.sqrt(), 4.0 / 0.8125)).abs() < 1e-12);
    }

    #[test]
    fn welch_p_values_are_uniform_for_equal_means_and_not_otherwise() {
        let run = |shift: f64, seed: u64| {
            let mut random = Random::new(seed);
            let p: Vec<f64> = (0..2000)
                .map(|_| {
                    let mut sample = |count: usize, scale: f64, shift: f64| {
                        let m: Moments = (0..count).map(|_| shift + scale * random.normal()).collect();
                        Estimate { mean: m.mean(), variance: m.variance_of_mean(), dof: count as f64 - 1.0 }
                    };
                    welch_test(&sample(16, 1.0, 0.0), &sample(9, 4.0, shift)).p
                })
                .collect();
            uniformity_test(&p).p
        };
        assert!(run(0.0, 3) > 0.01, "{}", run(0.0, 3));
        assert!(run(2.0, 3) < 1e-3);
    }

    #[test]
    fn exact_values_compare_exactly() {
        let one = Estimate::exact(1.0);
        assert_eq!(welch_test(&one, &one).p, 1.0);
        assert_eq!(welch_test(&one, &Estimate::exact(1.5)).p, 0.0);
        // Against a known value Welch's test is Student's, with the degrees of freedom of the
        // other.
        let measured = Estimate { mean: 2.0, variance: 0.25, dof: 15.0 };
        assert!((welch_test(&measured, &one).dof - 15.0).abs() < 1e-12);
        // Dim pixels: the squares of these variances are not representable.
        assert!((satterthwaite(&[(1e-200, 15.0), (1e-200, 15.0)]) - 30.0).abs() < 1e-9);
        assert_eq!(satterthwaite(&[(0.0, 15.0), (0.0, 15.0)]), f64::INFINITY);
    }

    #[test]
    fn sidak_inverts_itself() {
        assert!((sidak_level(0.01, 1) - 0.01).abs() < 1e-17);
        assert!((sidak_level(0.05, 2) - (1.0 - 0.95f64.sqrt())).abs() < 1e-15);
        for tests in [1, 7, 65_536, 10_000_000] {
            assert!((sidak_adjusted(sidak_level(0.01, tests), tests) / 0.01 - 1.0).abs() < 1e-12);
        }
    }
}
