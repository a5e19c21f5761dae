//! Intervals for a mean at one fixed number of samples.

use crate::student_t_quantile;

/// Half-width √(1/δ)·σ of Chebyshev's inequality: the mean is off by this much or more with
/// probability at most δ, whatever the distribution, given the *true* standard error σ of the mean.
/// With an estimated σ it is no longer a guarantee.
pub fn chebyshev_half_width(delta: f64, standard_error: f64) -> f64 {
    standard_error / delta.sqrt()
}

/// Samples after which Chebyshev's half-width at probability δ is `half_width`, for samples of
/// variance `variance`.
pub fn chebyshev_samples(delta: f64, variance: f64, half_width: f64) -> f64 {
    variance / (delta * half_width * half_width)
}

/// Half-width of the two-sided Student-t interval at `confidence` (0.95, say) for a standard error
/// of `dof` degrees of freedom. Exact for normal samples; otherwise by the central limit theorem,
/// for means of enough samples without heavy tails.
pub fn student_t_half_width(confidence: f64, standard_error: f64, dof: f64) -> f64 {
    student_t_quantile(0.5 + 0.5 * confidence, dof) * standard_error
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Moments;
    use crate::testing::Random;

    #[test]
    fn chebyshev_is_tight_for_its_extremal_case() {
        // ±1 with probability 1/(2k²) each, 0 otherwise: P(|X| ≥ kσ) = 1/k² exactly, with σ = 1/k.
        let k = 4.0;
        let half_width = chebyshev_half_width(1.0 / (k * k), 1.0 / k);
        assert!((half_width - 1.0).abs() < 1e-15);
        assert!((chebyshev_samples(0.05, 16.0 / 9.0, 0.1) - 16.0 / 9.0 / (0.05 * 0.01)).abs() < 1e-9);
    }

    #[test]
    fn t_interval_covers_and_a_normal_one_would_not() {
        // 95 % intervals from 5 samples, 20,000 trials: 4 standard errors of coverage are 0.6 %.
        let mut random = Random::new(21);
        let (mut by_t, mut by_z) = (0, 0);
        for _ in 0..20_000 {
            let sample: Moments = (0..5).map(|_| random.normal()).collect();
            let error = sample.variance_of_mean().sqrt();
            by_t += usize::from(sample.mean().abs() <= student_t_half_width(0.95, error, 4.0));
            by_z += usize::from(sample.mean().abs() <= student_t_half_width(0.95, error, f64::INFINITY));
        }
        assert!((by_t as f64 / 20_000.0 - 0.95).abs() < 0.006, "{by_t}");
        assert!(by_z < 17_800, "{by_z}");
    }
}
