//! How narrow the intervals of an image are, and when that is narrow enough.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use surelight_estimate::{chebyshev_half_width, student_t_quantile};

use crate::{Certificate, Film, luminance};

/// Of the certified pixels, this share must be as precise as requested.
pub const PRECISE_SHARE: f64 = 0.9;

/// Of the reachable pixels, this share must be certified.
pub const CERTIFIED_SHARE: f64 = 0.5;

/// Pixels darker than this share of the mean luminance (of reachable pixels) are judged by that
/// instead of their own.
pub const LUMINANCE_FLOOR: f64 = 0.1;

/// The bound that makes an interval of a standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bound {
    /// Student's t: the mean of many samples is about normal (central limit theorem).
    #[default]
    Clt,
    /// Chebyshev's inequality, which holds for every distribution of known variance; more than
    /// twice as wide at 95 %.
    Chebyshev,
}

impl Bound {
    /// Half-width of the interval at `confidence` (0 to 1) in standard errors, whose square is
    /// known to `dof` degrees of freedom.
    pub fn factor(self, confidence: f64, dof: f64) -> f64 {
        match self {
            Self::Clt => student_t_quantile(0.5 + 0.5 * confidence, dof.max(1.0)),
            Self::Chebyshev => chebyshev_half_width(1.0 - confidence, 1.0),
        }
    }
}

/// A precision to stop at: nine tenths of the certified pixels have an interval at `confidence`
/// whose half-width is at most `error` times their luminance (or a tenth of the picture's mean, if
/// that is more), and at least half of all pixels are certified.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Precision {
    /// Relative half-width: 0.02 is 2 %.
    pub error: f64,
    /// Of each pixel's interval, 0 to 1.
    pub confidence: f64,
    /// The bound of the interval.
    pub bound: Bound,
}

/// The precision that a picture has reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Relative half-width that nine tenths of the certified pixels stay within; infinite where
    /// none is certified.
    pub half_width: f64,
    /// Share of the reachable pixels that are certified, 0 to 1.
    pub certified: f64,
}

impl Precision {
    /// How precise the film is at this confidence and bound.
    pub fn reach(&self, film: &Film, certificate: &Certificate) -> Convergence {
        let Certificate { certified, reachable, .. } = certificate;
        let chosen: Vec<bool> = certified.iter().zip(reachable).map(|(&c, &r)| c && r).collect();
        Convergence { half_width: self.half_width(film, &chosen, reachable), certified: certificate.share() }
    }

    /// Whether that is enough.
    pub fn is_reached(&self, reach: &Convergence) -> bool {
        reach.certified >= CERTIFIED_SHARE && reach.half_width <= self.error
    }

    /// Relative half-width that nine tenths of the pixels chosen stay within; infinite where none
    /// is.
    ///
    /// The standard error of luminance is taken as Σ w_c σ_c: see [`crate::ErrorSummary`].
    pub fn half_width(&self, film: &Film, chosen: &[bool], reachable: &[bool]) -> f64 {
        let pixels = film.pixels();
        let means: Vec<f64> = pixels.par_iter().map(|p| luminance(p.mean())).collect();
        let reachable = reachable.iter().filter(|&&r| r).count();
        let floor = LUMINANCE_FLOOR * means.iter().sum::<f64>() / reachable.max(1) as f64;
        // Nearly always the same for all pixels.
        let dof = film.degrees_of_freedom(0);
        let usual = self.bound.factor(self.confidence, dof);
        let half_width = |i: usize| {
            let factor = match pixels[i].degrees_of_freedom() {
                d if d == dof => usual,
                d => self.bound.factor(self.confidence, d),
            };
            match pixels[i].variance_of_mean() {
                Some(variance) => {
                    factor * luminance(variance.map(f64::sqrt)) / means[i].max(floor).max(f64::MIN_POSITIVE)
                }
                None => f64::INFINITY,
            }
        };
        let mut all: Vec<f64> = (0..pixels.len()).into_par_iter().filter(|&i| chosen[i]).map(half_width).collect();
        if all.is_empty() {
            return f64::INFINITY;
        }
        let rank = ((all.len() as f64 * PRECISE_SHARE).ceil() as usize).max(1) - 1;
        *all.select_nth_unstable_by(rank, f64::total_cmp).1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BatchSum;

    #[test]
    fn nine_tenths_of_the_certified_pixels_decide() {
        // Pixel i alternates between 1 ± 0.01 (i + 1); the last is a firefly. 16 batches: 15
        // degrees of freedom.
        let mut film = Film::new(11, 1);
        let lanes: Vec<u32> = (0..11).collect();
        for batch in 0..16 {
            let mut sums: Vec<BatchSum> = (0..10)
                .map(|i| if batch % 2 == 0 { 0.01 } else { -0.01 } * (i + 1) as f32)
                .map(|d| BatchSum::constant(64, [1.0 + d; 3]))
                .collect();
            let hit = batch == 3;
            sums.push(if hit { BatchSum::new([64.0; 3], 64.0, 4096.0) } else { BatchSum::constant(64, [0.0; 3]) });
            film.add_batch(64, &lanes, &sums).unwrap();
        }
        let certificate = film.certify();
        assert!(!certificate.certified[10]);
        // The firefly's own neighbours are left out here: this is about the rank.
        let chosen: Vec<bool> = (0..11).map(|i| i < 10).collect();
        let precision = Precision { error: 0.05, confidence: 0.95, bound: Bound::Clt };
        // The ninth of ten: s² = 0.09²·16/15, over 16.
        let expected = 2.131_449_5 * (0.09f64.powi(2) / 15.0).sqrt();
        let found = precision.half_width(&film, &chosen, &certificate.reachable);
        assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
        assert_eq!(precision.half_width(&film, &[false; 11], &[true; 11]), f64::INFINITY);
    }

    #[test]
    fn both_conditions_are_needed() {
        let precision = Precision { error: 0.05, confidence: 0.95, bound: Bound::Clt };
        for (half_width, certified, reached) in [(0.04, 0.9, true), (0.06, 0.9, false), (0.04, 0.4, false)] {
            assert_eq!(precision.is_reached(&Convergence { half_width, certified }), reached);
        }
    }

    #[test]
    fn chebyshev_is_wider() {
        assert!((Bound::Clt.factor(0.95, 15.0) - 2.131_45).abs() < 1e-4);
        assert!((Bound::Chebyshev.factor(0.95, 15.0) - 20f64.sqrt()).abs() < 1e-12);
    }
}
