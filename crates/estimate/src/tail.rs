//! How heavy is the tail? Where the variance is (nearly) infinite no error bar is reliable.

/// A generalised Pareto distribution fitted to the largest samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParetoFit {
    /// Shape k̂: moments of order below 1/k̂ exist. Negative for bounded tails, 0 for exponential
    /// ones.
    pub k: f64,
    /// Scale of the exceedances over the threshold.
    pub scale: f64,
    /// Samples in the tail that was fitted.
    pub tail: usize,
    /// k̂ beyond which the mean and its error bar are unreliable at this number of samples: min(1 −
    /// 1/log₁₀ S, 0.7).
    pub limit: f64,
}

impl ParetoFit {
    /// Whether mean and error bar are reliable.
    pub fn reliable(&self) -> bool {
        self.k <= self.limit
    }
}

/// Pareto k̂ of the upper tail of non-negative samples (sorted in place): Vehtari, Simpson, Gelman,
/// Yao, Gabry, "Pareto smoothed importance sampling", JMLR 25 (2024), section 3, where the tail is
/// the largest min(S/5, 3√S) of S samples and k̂ is drawn towards ½ as if by ten more samples.
///
/// `None` where fewer than five samples make the tail, or where it has no spread (all equal:
/// nothing to fit). Samples that are not numbers make it `None` too.
pub fn pareto_k(samples: &mut [f64]) -> Option<ParetoFit> {
    let count = samples.len() as f64;
    let tail = (0.2 * count).min(3.0 * count.sqrt()).ceil() as usize;
    if tail < 5 || tail >= samples.len() || samples.iter().any(|x| !x.is_finite()) {
        return None;
    }
    samples.sort_by(f64::total_cmp);
    let (body, largest) = samples.split_at(samples.len() - tail);
    let threshold = *body.last()?;
    let exceedances: Vec<f64> = largest.iter().map(|x| x - threshold).collect();
    let (k, scale) = fit(&exceedances)?;
    let m = tail as f64;
    Some(ParetoFit { k: (k * m + 0.5 * 10.0) / (m + 10.0), scale, tail, limit: (1.0 - 1.0 / count.log10()).min(0.7) })
}

/// Shape and scale of a generalised Pareto distribution from sorted exceedances: the quasi-Bayesian
/// profile-likelihood mean of Zhang & Stephens, "A new and efficient estimation method for the
/// generalized Pareto distribution", Technometrics 51(3) (2009), sections 2–3 (with the sign of k
/// as is usual today: positive for heavy tails).
fn fit(x: &[f64]) -> Option<(f64, f64)> {
    let n = x.len();
    let quartile = x[((n as f64 / 4.0 + 0.5).floor() as usize).clamp(1, n) - 1];
    let largest = x[n - 1];
    // A quarter of the tail at the threshold itself leaves the grid of the method without a scale.
    if largest <= 0.0 || quartile <= 0.0 {
        return None;
    }
    let grid = 30 + (n as f64).sqrt().floor() as usize;
    let shape = |theta: f64| x.iter().map(|x| (-theta * x).ln_1p()).sum::<f64>() / n as f64;
    let candidates: Vec<(f64, f64)> = (1..=grid)
        .map(|j| {
            let theta = 1.0 / largest + (1.0 - (grid as f64 / (j as f64 - 0.5)).sqrt()) / (3.0 * quartile);
            let k = shape(theta);
            (theta, n as f64 * ((-theta / k).ln() - k - 1.0))
        })
        .filter(|(theta, likelihood)| theta.is_finite() && likelihood.is_finite())
        .collect();
    let best = candidates.iter().map(|c| c.1).fold(f64::NEG_INFINITY, f64::max);
    let (mut weight, mut sum) = (0.0, 0.0);
    for (theta, likelihood) in candidates {
        let w = (likelihood - best).exp();
        weight += w;
        sum += w * theta;
    }
    let theta = sum / weight;
    let k = shape(theta);
    let scale = -k / theta;
    (k.is_finite() && scale.is_finite()).then_some((k, scale))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Quantile function of a generalised Pareto distribution with scale 1.
    fn pareto(k: f64, p: f64) -> f64 {
        if k == 0.0 { -(-p).ln_1p() } else { (((1.0 - p).powf(-k)) - 1.0) / k }
    }

    #[test]
    fn fit_finds_shape_and_scale() {
        // Evenly spaced quantiles have no noise: only the method's own small-sample bias is left.
        for k in [-0.3, 0.0, 0.3, 0.7, 1.2] {
            let x: Vec<f64> = (0..1000).map(|i| 2.5 * pareto(k, (f64::from(i) + 0.5) / 1000.0)).collect();
            let (found, scale) = fit(&x).unwrap();
            assert!((found - k).abs() < 0.02, "{k}: {found}");
            assert!((scale / 2.5 - 1.0).abs() < 0.03, "{k}: {scale}");
        }
    }

    #[test]
    fn tails_are_distinguished() {
        // 20 draws of 4096 samples each. The standard deviation of k̂ from a tail of 192 is about
        // (1 + k)/√192 = 0.11.
        let mut random = Random::new(31);
        for (k, reliable) in [(0.2, 20), (1.2, 0)] {
            let mut mean = 0.0;
            let mut passed = 0;
            for _ in 0..20 {
                let mut samples: Vec<f64> = (0..4096).map(|_| pareto(k, random.uniform())).collect();
                let fit = pareto_k(&mut samples).unwrap();
                assert_eq!((fit.tail, fit.limit), (192, 0.7));
                mean += fit.k / 20.0;
                passed += usize::from(fit.reliable());
            }
            // The pull towards ½ is 10/202 of the distance.
            let expected = k + (0.5 - k) * 10.0 / 202.0;
            assert!((mean - expected).abs() < 4.0 * (1.0 + k) / (192.0f64 * 20.0).sqrt(), "{k}: {mean}");
            assert_eq!(passed, reliable, "{k}");
        }
    }

    #[test]
    fn no_tail_no_fit() {
        assert_eq!(pareto_k(&mut [1.0; 100]), None);
        assert_eq!(pareto_k(&mut [1.0, 2.0, 3.0]), None);
        let mut bad: Vec<f64> = (0..100).map(f64::from).collect();
        bad[3] = f64::NAN;
        assert_eq!(pareto_k(&mut bad), None);
    }
}
