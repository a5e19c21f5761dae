//! One number for the error of a whole image.

use rayon::prelude::*;

use crate::Film;

/// Weights of Rec. 709 luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Rec. 709 luminance of linear RGB.
pub(crate) fn luminance(rgb: [f64; 3]) -> f64 {
    rgb.iter().zip(LUMINANCE).map(|(x, w)| x * w).sum()
}

/// Relative standard errors of the pixels of a film, in luminance.
///
/// The channels of a pixel come from the same paths, so their errors are not independent and their
/// correlation is not stored. The standard error of luminance is taken as Σ w_c σ_c, which it
/// reaches when channels vary together and never exceeds. Black pixels (mean 0) and pixels below
/// two batches have no relative error and are left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorSummary {
    /// Mean of the relative standard errors (0.01 is one percent).
    pub mean: f64,
    /// The relative standard error that 95 % of the pixels stay below.
    pub percentile_95: f64,
    /// Pixels counted.
    pub pixels: usize,
}

impl Film {
    /// The error of the image so far; `None` while no pixel has two batches and some light.
    pub fn error_summary(&self) -> Option<ErrorSummary> {
        let mut errors: Vec<f64> = self
            .pixels()
            .par_iter()
            .filter_map(|pixel| {
                let error = luminance(pixel.variance_of_mean()?.map(f64::sqrt));
                let mean = luminance(pixel.mean());
                (mean > 0.0).then(|| error / mean)
            })
            .collect();
        let pixels = errors.len();
        if pixels == 0 {
            return None;
        }
        // Summed in order, so that the figure does not depend on the number of threads.
        let mean = errors.iter().sum::<f64>() / pixels as f64;
        let rank = (pixels * 95).div_ceil(100).max(1) - 1;
        let (_, &mut percentile_95, _) = errors.select_nth_unstable_by(rank, f64::total_cmp);
        Some(ErrorSummary { mean, percentile_95, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BatchSum;

    #[test]
    fn summary_of_known_errors() {
        let mut film = Film::new(3, 1);
        assert_eq!(film.error_summary(), None);
        // Grey pixels with batch means 1 ± a: variance of the mean of two is a².
        for sign in [1.0, -1.0] {
            let sums = [1.0 + sign * 0.25, 1.0 + sign * 0.5, 0.0].map(|grey| BatchSum::constant(1, [grey; 3]));
            film.add_batch(1, &[0, 1, 2], &sums).unwrap();
        }
        let summary = film.error_summary().unwrap();
        assert_eq!(summary.pixels, 2);
        assert!((summary.mean - 0.375).abs() < 1e-12);
        assert!((summary.percentile_95 - 0.5).abs() < 1e-12);
    }
}
