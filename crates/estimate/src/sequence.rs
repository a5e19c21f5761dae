//! Confidence sequences: intervals that hold at *all* times at once, so that one may evaluate them
//! at any time and stop at will. A fixed-time interval that is evaluated repeatedly misses far more
//! often than its level.

/// Asymptotic confidence sequence for the mean of samples with finite variance: Waudby-Smith,
/// Arbour, Sinha, Kennedy, Ramdas, "Time-uniform central limit theory and asymptotic confidence
/// sequences", arXiv 2103.06476, theorem 2.2.
///
/// The guarantee is asymptotic in the time of the first evaluation: discard intervals before a
/// burn-in (256 samples or more), and distrust it for heavy tails, where the sample variance lags
/// behind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsymptoticSequence {
    alpha: f64,
    rho_squared: f64,
}

impl AsymptoticSequence {
    /// At error probability `alpha`, narrowest about sample number `tightest_at` (section B.2 of
    /// the paper: ρ² = (−2 ln α + ln(−2 ln α) + 1)/t).
    pub fn new(alpha: f64, tightest_at: f64) -> Self {
        let l = -2.0 * alpha.ln();
        Self { alpha, rho_squared: (l + l.ln() + 1.0) / tightest_at }
    }

    /// Half-width after `count` samples of standard deviation `deviation`:
    /// σ √(2(tρ²+1)/(t²ρ²) · ln(√(tρ²+1)/α)).
    pub fn half_width(&self, count: f64, deviation: f64) -> f64 {
        let tr = count * self.rho_squared;
        let spread = 2.0 * (tr + 1.0) / (count * tr) * (0.5 * (tr + 1.0).ln() - self.alpha.ln());
        deviation * spread.sqrt()
    }
}

/// Confidence sequence for the mean of *bounded* samples, valid at every sample number without any
/// limit argument: the predictable plug-in empirical-Bernstein sequence of Waudby-Smith & Ramdas,
/// "Estimating means of bounded random variables by betting", JRSS B 86 (2024), theorem 2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EmpiricalBernstein {
    alpha: f64,
    low: f64,
    range: f64,
    count: f64,
    sum: f64,
    deviation_sum: f64,
    weight_sum: f64,
    weighted_sum: f64,
    cost_sum: f64,
}

impl EmpiricalBernstein {
    /// At error probability `alpha`, for samples within `[low, high]`.
    pub fn new(alpha: f64, low: f64, high: f64) -> Self {
        Self {
            alpha,
            low,
            range: high - low,
            count: 0.0,
            sum: 0.0,
            deviation_sum: 0.0,
            weight_sum: 0.0,
            weighted_sum: 0.0,
            cost_sum: 0.0,
        }
    }

    /// Adds a sample; one outside the bounds voids the guarantee.
    pub fn push(&mut self, sample: f64) {
        let x = (sample - self.low) / self.range;
        let mean_before = (0.5 + self.sum) / (self.count + 1.0);
        let variance_before = (0.25 + self.deviation_sum) / (self.count + 1.0);
        let t = self.count + 1.0;
        let bet = (2.0 * (2.0 / self.alpha).ln() / (variance_before * t * (t + 1.0).ln())).sqrt().min(0.5);
        self.weight_sum += bet;
        self.weighted_sum += bet * x;
        // v·ψ_E(λ) with v = 4(x − μ̂)² and ψ_E(λ) = (−ln(1−λ) − λ)/4.
        self.cost_sum += (x - mean_before).powi(2) * (-(-bet).ln_1p() - bet);
        self.sum += x;
        self.count = t;
        self.deviation_sum += (x - (0.5 + self.sum) / (t + 1.0)).powi(2);
    }

    /// Centre and half-width of the interval so far; before any sample, the whole range.
    pub fn interval(&self) -> (f64, f64) {
        if self.count == 0.0 {
            return (self.low + 0.5 * self.range, 0.5 * self.range);
        }
        let centre = self.weighted_sum / self.weight_sum;
        let half_width = ((2.0 / self.alpha).ln() + self.cost_sum) / self.weight_sum;
        (self.low + self.range * centre, self.range * half_width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Moments;
    use crate::testing::Random;

    /// Share of 1,000 runs in which an interval, evaluated every 16 samples from `burn_in` to 4096,
    /// ever misses.
    fn ever_misses(burn_in: u64, half_width: impl Fn(f64, f64) -> f64) -> f64 {
        let mut random = Random::new(77);
        let misses = (0..1000)
            .filter(|_| {
                let mut moments = Moments::default();
                let mut missed = false;
                for i in 1..=4096u64 {
                    // Exponential samples, mean 1: skewed, but with all moments.
                    moments.push(-random.uniform().ln());
                    if i >= burn_in && i % 16 == 0 {
                        let width = half_width(i as f64, moments.variance().sqrt());
                        missed |= (moments.mean() - 1.0).abs() > width;
                    }
                }
                missed
            })
            .count();
        misses as f64 / 1000.0
    }

    #[test]
    fn asymptotic_sequence_holds_at_all_times_and_a_fixed_interval_does_not() {
        let sequence = AsymptoticSequence::new(0.05, 1024.0);
        let share = ever_misses(256, |n, s| sequence.half_width(n, s));
        // 0.05 plus three standard errors of 1,000 runs.
        assert!(share < 0.05 + 0.021, "{share}");
        let peeking = ever_misses(256, |n, s| 1.959964 * s / n.sqrt());
        assert!(peeking > 0.2, "{peeking}");
    }

    #[test]
    fn asymptotic_sequence_is_tightest_where_requested() {
        // Against the fixed-time interval of the same n, the excess is least near the chosen time,
        // and only logarithmic.
        let ratio = |n: f64| AsymptoticSequence::new(0.05, 1000.0).half_width(n, 1.0) * n.sqrt();
        let other = |n: f64, t: f64| AsymptoticSequence::new(0.05, t).half_width(n, 1.0);
        assert!(other(1000.0, 1000.0) < other(1000.0, 100.0) && other(1000.0, 1000.0) < other(1000.0, 10_000.0));
        assert!(ratio(1000.0) > 1.96 && ratio(1000.0) < 3.2, "{}", ratio(1000.0));
        // By hand for ρ² = 1, t = 1, σ = 1, α = e⁻¹: √(4·(½ ln 2 + 1)).
        let unit = AsymptoticSequence { alpha: (-1f64).exp(), rho_squared: 1.0 };
        assert!((unit.half_width(1.0, 1.0) - (4.0 * (0.5 * 2f64.ln() + 1.0)).sqrt()).abs() < 1e-14);
    }

    #[test]
    fn empirical_bernstein_holds_from_the_first_sample() {
        // A firefly: 64 with probability 1/64, mean 1. 1,000 runs of 4096 samples, evaluated at
        // every sample.
        let mut random = Random::new(5);
        let (mut misses, mut width) = (0, 0.0);
        for _ in 0..1000 {
            let mut sequence = EmpiricalBernstein::new(0.05, 0.0, 64.0);
            let mut missed = false;
            for _ in 0..4096 {
                sequence.push(if random.uniform() < 1.0 / 64.0 { 64.0 } else { 0.0 });
                let (centre, half_width) = sequence.interval();
                missed |= (centre - 1.0).abs() > half_width;
            }
            misses += usize::from(missed);
            width += sequence.interval().1 / 1000.0;
        }
        assert!(misses < 71, "{misses}");
        // σ/√n = 0.124; the sequence pays a factor of a few, not of a hundred.
        assert!(width < 0.124 * 5.0, "{width}");
    }

    #[test]
    fn empirical_bernstein_by_hand() {
        // First sample x = 1 of [0, 1], α = 0.05: λ = ½ (the cap), cost (1 − ½)²·(ln 2 − ½).
        let mut sequence = EmpiricalBernstein::new(0.05, 0.0, 1.0);
        assert_eq!(sequence.interval(), (0.5, 0.5));
        sequence.push(1.0);
        let (centre, half_width) = sequence.interval();
        assert_eq!(centre, 1.0);
        assert!((half_width - (40f64.ln() + 0.25 * (2f64.ln() - 0.5)) / 0.5).abs() < 1e-14);
    }
}
