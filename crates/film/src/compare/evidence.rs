//! One test of two pictures' means over the same pixels, bounded by the effect of rare samples.
//!
//! Where light arrives in rare, bright samples, a picture with fewer of them than expected is too
//! dark *and* its variance estimate is too small. Welch's t is then far too large: of real files
//! under a studio map one in seven raised a false alarm at α = 0.01. The variance alone does not
//! show this; the size of the largest samples does.
//!
//! Let the mean over a pool of pixels jump by m with one more such sample. If they caused all of
//! the variance V, their number would be a Poisson count: the darker picture has k = V/m² of the
//! λ = k + |D|/m that the difference D implies. The root of that count's deviance, √(2(λ − k − k
//! ln(λ/k))), is nearly normal (McCullagh, Nelder, *Generalized Linear Models*, 1989, section 2.4)
//! and takes the place of |D|/√V, which it tends to as m → 0. Half a sample is added to the count,
//! as is usual: with none, the p-value is about e^(−λ). It is the empirical form of Bennett's
//! inequality (Maurer, Pontil, "Empirical Bernstein Bounds and Sample Variance Penalization",
//! COLT 2009) with the constants of a test instead of a bound.
//!
//! Jumps are the largest of both pictures, anywhere in them, and the rule is the same whichever is
//! darker: a picture or tile without bright samples is judged by those of other tiles, and no pixel
//! is left out.

use surelight_estimate::{
    Estimate, WelchTest, normal_quantile, satterthwaite, student_t_quantile, student_t_survival, welch_test,
};

use super::beyond_rounding;

/// Of a standard error: smaller jumps change no verdict.
const MIN_JUMP: f64 = 1e-6;

/// How often a detectable bias is found.
const POWER: f64 = 0.9;

/// Two pictures' means over the same pixels, in one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Evidence {
    /// Means of the two, the reference second.
    pub(super) means: [Estimate; 2],
    /// By how much one sample may change either mean; 0 where nothing is known of samples.
    pub(super) jump: f64,
}

impl Evidence {
    /// Tests the remainder of the difference after rounding; `p` is bounded by the jump.
    pub(super) fn test(&self) -> WelchTest {
        let [a, b] = self.means;
        let shifted = Estimate { mean: beyond_rounding(a.mean, b.mean), ..a };
        let welch = welch_test(&shifted, &Estimate { mean: 0.0, ..b });
        let p = if self.has_jump() {
            let root = root(welch.difference.abs(), self.variance(), self.jump);
            2.0 * student_t_survival(root, welch.dof)
        } else {
            welch.p
        };
        WelchTest { difference: a.mean - b.mean, p: p.min(1.0), ..welch }
    }

    /// The smallest difference that a test at `level` finds nine times in ten.
    pub(super) fn detectable_difference(&self, level: f64) -> f64 {
        let [a, b] = self.means;
        let dof = satterthwaite(&[(a.variance, a.dof), (b.variance, b.dof)]);
        let quantile = student_t_quantile(1.0 - 0.5 * level, dof);
        let variance = self.variance();
        if self.has_jump() {
            let noise = (variance + 0.5 * self.jump * self.jump).sqrt();
            threshold(quantile, variance, self.jump) + normal_quantile(POWER) * noise
        } else if variance > 0.0 {
            (quantile + normal_quantile(POWER)) * variance.sqrt()
        } else {
            0.0
        }
    }

    /// That difference relative to the reference; `None` where the reference is black.
    pub(super) fn detectable(&self, level: f64) -> Option<f64> {
        let reference = self.means[1].mean;
        (reference > 0.0).then(|| self.detectable_difference(level) / reference)
    }

    /// Whether there is light in either picture.
    pub(super) fn is_lit(&self) -> bool {
        self.brighter() > 0.0
    }

    /// Whether a test at `level` would find, nine times in ten, that one picture is black.
    pub(super) fn can_tell(&self, level: f64) -> bool {
        self.detectable_difference(level) < self.brighter()
    }

    fn brighter(&self) -> f64 {
        self.means[0].mean.abs().max(self.means[1].mean.abs())
    }

    /// Of the difference.
    fn variance(&self) -> f64 {
        self.means[0].variance + self.means[1].variance
    }

    fn has_jump(&self) -> bool {
        self.jump > MIN_JUMP * self.variance().sqrt()
    }
}

/// The root of the deviance: a difference in standard errors.
fn root(difference: f64, variance: f64, jump: f64) -> f64 {
    let events = variance / (jump * jump) + 0.5;
    let missing = (difference / jump - 0.5).max(0.0);
    let share = missing / events;
    (2.0 * events * (share - share.ln_1p())).max(0.0).sqrt()
}

/// The difference whose [`root`] is `quantile`.
fn threshold(quantile: f64, variance: f64, jump: f64) -> f64 {
    let events = variance / (jump * jump) + 0.5;
    let square = quantile * quantile;
    // By u − ln(1 + u) ≥ u²/(2(1 + u)) the root is reached at this share at the latest.
    let mut range = [0.0, (square + (square * square + 4.0 * events * square).sqrt()) / (2.0 * events)];
    for _ in 0..60 {
        let middle = 0.5 * (range[0] + range[1]);
        let reached = 2.0 * events * (middle - middle.ln_1p()) >= square;
        range[usize::from(reached)] = middle;
    }
    (range[1] * events + 0.5) * jump
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evidence(difference: f64, variance: f64, jump: f64) -> Evidence {
        let estimate = |mean| Estimate { mean, variance: 0.5 * variance, dof: f64::INFINITY };
        Evidence { means: [estimate(1.0 + difference), estimate(1.0)], jump }
    }

    #[test]
    fn small_jumps_leave_welchs_test() {
        let welch = evidence(0.4, 0.01, 0.0);
        assert!((welch.test().p - 6.334e-5).abs() < 1e-8, "4 standard errors: {}", welch.test().p);
        for (jump, factor) in [(1e-7, 1e-12), (1e-4, 0.03), (1e-3, 0.3)] {
            let p = evidence(0.4, 0.01, jump).test().p;
            assert!((p / welch.test().p - 1.0).abs() < factor, "{jump}: {p}");
        }
    }

    /// No event of λ expected ones has probability e^(−λ), which no variance shows.
    #[test]
    fn a_tile_without_events_may_have_missed_some() {
        for events in [2.0f64, 5.0, 10.0, 20.0] {
            let missed = (-events).exp();
            let p = evidence(0.01 * events, 1e-12, 0.01).test().p;
            assert!((0.5..4.0).contains(&(p / missed)), "{events}: {p} for {missed}");
        }
        assert_eq!(evidence(0.004, 1e-12, 0.01).test().p, 1.0, "less than half an event");
    }

    /// Poisson counts against a known mean: tests at level 0.01 find at most 1 % of them too low.
    #[test]
    fn counts_that_are_too_low_are_as_rare_as_the_level() {
        for lambda in [1.0, 3.0, 10.0, 30.0, 100.0f64] {
            let (mut chance, mut low) = ((-lambda).exp(), 0.0);
            for count in 0..lambda as u32 {
                let events = f64::from(count);
                let estimate = |mean, variance| Estimate { mean, variance, dof: f64::INFINITY };
                let means = [estimate(events, events), estimate(lambda, 0.0)];
                if (Evidence { means, jump: 1.0 }).test().p < 0.01 {
                    low += chance;
                }
                chance *= lambda / (events + 1.0);
            }
            assert!(low < 0.01, "{lambda}: {low}");
        }
    }

    #[test]
    fn thresholds_are_where_the_test_turns() {
        for (variance, jump) in [(0.01, 1e-3), (0.01, 0.1), (1e-8, 0.1), (0.0, 0.5)] {
            let quantile = normal_quantile(1.0 - 0.5 * 1e-3);
            let at = threshold(quantile, variance, jump);
            assert!(evidence(at * 1.0001, variance, jump).test().p < 1e-3, "{variance}, {jump}");
            assert!(evidence(at * 0.999, variance, jump).test().p > 1e-3, "{variance}, {jump}");
        }
    }

    #[test]
    fn numbers_out_of_range_are_harmless() {
        for (difference, variance, jump) in
            [(0.0, 0.0, 1e-30), (1e30, 1e-30, 1e-12), (1.0, 1e-300, 1e-160), (1e-20, 1e30, 1e15)]
        {
            let evidence = evidence(difference, variance, jump);
            let test = evidence.test();
            assert!((0.0..=1.0).contains(&test.p), "{test:?}");
            assert!(evidence.detectable_difference(1e-6) >= 0.0);
        }
    }
}
