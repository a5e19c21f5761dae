//! Moments of a stream of samples, to the fourth order.

/// Count, mean and central sums Σ(x−m)², Σ(x−m)³, Σ(x−m)⁴ of the samples.
///
/// One pass, without the cancellation of raw power sums: Welford 1962 for the second order; Pébay,
/// "Formulas for robust, one-pass parallel computation of covariances and arbitrary-order
/// statistical moments", SAND2008-6212 (2008), equations 2.1 and 3.1 for adding samples and for
/// merging.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    m2: f64,
    m3: f64,
    m4: f64,
}

impl Moments {
    /// Adds one sample.
    pub fn push(&mut self, x: f64) {
        self.merge(&Self { count: 1, mean: x, ..Self::default() });
    }

    /// Adds all samples of another.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let n = a + b;
        let delta = other.mean - self.mean;
        let step = delta / n;
        let cross = delta * step * a * b;
        self.m4 += other.m4
            + cross * step * step * (a * a - a * b + b * b)
            + 6.0 * step * step * (a * a * other.m2 + b * b * self.m2)
            + 4.0 * step * (a * other.m3 - b * self.m3);
        self.m3 += other.m3 + cross * step * (a - b) + 3.0 * step * (a * other.m2 - b * self.m2);
        self.m2 += other.m2 + cross;
        self.mean += step * b;
        self.count += other.count;
    }

    /// Number of samples.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Mean; 0 before the first sample.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance of one sample, Σ(x−m)²/(n−1); NaN below two samples.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { f64::NAN } else { self.m2 / (self.count - 1) as f64 }
    }

    /// Variance of the samples as a whole population, Σ(x−m)²/n, which is the mean of x² less the
    /// square of the mean; NaN without samples.
    pub fn population_variance(&self) -> f64 {
        self.m2 / self.count as f64
    }

    /// Variance of the mean (the secondary estimator), variance/n; NaN below two samples.
    pub fn variance_of_mean(&self) -> f64 {
        self.variance() / self.count as f64
    }

    /// Skewness √n·Σ(x−m)³/(Σ(x−m)²)^1.5 of the population; NaN without spread.
    pub fn skewness(&self) -> f64 {
        (self.count as f64).sqrt() * self.m3 / self.m2.powf(1.5)
    }

    /// Kurtosis n·Σ(x−m)⁴/(Σ(x−m)²)² − 3 of the population, 0 for a normal one; NaN without spread.
    pub fn excess_kurtosis(&self) -> f64 {
        self.count as f64 * self.m4 / (self.m2 * self.m2) - 3.0
    }

    /// Relative variance of the variance, Σ(x−m)⁴/(Σ(x−m)²)² − 1/n; NaN without spread.
    ///
    /// MCNP's test of an error bar requires less than 0.1, falling as 1/n (Pederson, Forster,
    /// Booth, "Confidence interval procedures for Monte Carlo transport simulations", Nuclear
    /// Science and Engineering 127 (1997)).
    pub fn variance_of_variance(&self) -> f64 {
        self.m4 / (self.m2 * self.m2) - 1.0 / self.count as f64
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<T: IntoIterator<Item = f64>>(samples: T) -> Self {
        let mut moments = Self::default();
        for x in samples {
            moments.push(x);
        }
        moments
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    fn by_definition(samples: &[f64]) -> [f64; 4] {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let central = |power| samples.iter().map(|x| (x - mean).powi(power)).sum::<f64>();
        [mean, central(2), central(3), central(4)]
    }

    fn assert_close(moments: &Moments, samples: &[f64]) {
        let expected = by_definition(samples);
        for (found, expected) in [moments.mean, moments.m2, moments.m3, moments.m4].into_iter().zip(expected) {
            assert!((found - expected).abs() <= 1e-10 * expected.abs(), "{found} {expected}");
        }
    }

    #[test]
    fn pushes_and_merges_match_the_definition() {
        let mut random = Random::new(1);
        let samples: Vec<f64> = (0..1000).map(|_| random.uniform().powi(5) + 3.0).collect();
        assert_close(&samples.iter().copied().collect(), &samples);
        let mut merged = Moments::default();
        for part in samples.chunks(77) {
            merged.merge(&part.iter().copied().collect());
        }
        merged.merge(&Moments::default());
        assert_eq!(merged.count(), 1000);
        assert_close(&merged, &samples);
    }

    #[test]
    fn a_large_offset_costs_nothing() {
        // 1e9 + {4, 7, 13, 16}: variance 30; the raw-sum formula in f64 gives 29.33 or worse.
        let moments: Moments = [4.0, 7.0, 13.0, 16.0].map(|x| x + 1e9).into_iter().collect();
        assert_eq!(moments.variance(), 30.0);
    }

    #[test]
    fn shapes_of_known_populations() {
        // Two points: skewness 0, kurtosis 1. One in four: skewness (1−2p)/√(pq) = 2/√3, excess
        // 1/(pq) − 6 = −2/3.
        let coin: Moments = [0.0, 1.0].into_iter().collect();
        assert_eq!((coin.skewness(), coin.excess_kurtosis()), (0.0, -2.0));
        let quarter: Moments = [0.0, 0.0, 0.0, 1.0].into_iter().collect();
        assert!((quarter.skewness() - 2.0 / 3f64.sqrt()).abs() < 1e-14);
        assert!((quarter.excess_kurtosis() + 2.0 / 3.0).abs() < 1e-14);
        // (κ + 3 − 1)/n = (7/3 − 1)/4.
        assert!((quarter.variance_of_variance() - 1.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn too_few_samples_have_no_variance() {
        let one: Moments = [2.0].into_iter().collect();
        assert!(one.variance().is_nan() && one.variance_of_mean().is_nan());
        assert!(Moments::default().population_variance().is_nan());
    }
}
