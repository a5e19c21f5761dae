//! Relative noise of an image.

use surelight_film::Film;

use surelight_prepare::luminance;

/// Added to a pixel's squared mean, as a fraction of the image's squared mean, so that dark pixels
/// do not dominate.
const FLOOR: f64 = 0.01;

/// For each pixel 1/(mean² + floor), from the luminances of all pixels of an image.
pub(crate) fn weights(means: &[f64]) -> Vec<f64> {
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    means.iter().map(|m| 1.0 / (m * m + FLOOR * mean * mean).max(f64::MIN_POSITIVE)).collect()
}

/// Variance of a pixel's mean luminance: (Σ w_c σ_c)², as if channels were fully correlated. 0
/// where it is unknown.
pub(crate) fn variance(film: &Film, pixel: usize) -> f64 {
    let variance = film.variance_of_mean(pixel).unwrap_or_default();
    luminance(variance.map(|v| v.sqrt() as f32)).powi(2)
}
