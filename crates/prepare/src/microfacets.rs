//! The directional albedo of white GGX microfacets that scatter once, as a lookup table of the
//! kernel.
//!
//! It has no closed form, so it is integrated here: once per process, in f64, and only with
//! `--multiple-scattering`.

use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::shared::FACET_STEPS;

const STEPS: usize = FACET_STEPS as usize;

/// Cosines and α below these are taken for them: the sampling is not defined at 0.
const MIN_COSINE: f64 = 1e-3;
const MIN_ALPHA: f64 = 1e-4;

/// Points along each axis of the quadrature.
const POINTS: usize = 48;

/// The table, row after row.
pub(crate) fn facet_albedos() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let at = |i: usize| (i as f64 / (STEPS - 1) as f64).powi(2);
        let entries = (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column)));
        entries.map(|(row, column)| albedo(at(column), at(row), POINTS) as f32).collect()
    })
}

/// ∫ D·G2/(4 cosθo) dωi of facets that reflect everything, viewed at this cosine: the mean of G2/G1
/// over visible normals, which are the directions of a spherical cap in stretched space (Dupuy &
/// Benyoub 2023, "Sampling visible GGX normals with spherical caps").
fn albedo(cosine: f64, alpha: f64, points: usize) -> f64 {
    let (cosine, alpha) = (cosine.max(MIN_COSINE), alpha.max(MIN_ALPHA));
    let sine = (1.0 - cosine * cosine).sqrt();
    let stretch = |c: f64| (alpha * alpha + (1.0 - alpha * alpha) * c * c).sqrt();
    let length = (alpha * sine).hypot(cosine);
    let (x, z) = (alpha * sine / length, cosine / length);
    let middle = |i: usize| (i as f64 + 0.5) / points as f64;
    let mut sum = 0.0;
    for i in 0..points {
        // Light is lost at the rim of the cap, where normals are flat: most points are there. Its
        // two halves are symmetric.
        let rim = middle(i).powi(3);
        let cap = rim * (1.0 + z) - z;
        let weight = 3.0 * middle(i).powi(2);
        let radius = (1.0 - cap * cap).max(0.0).sqrt();
        for j in 0..points {
            let (sin, cos) = (PI * middle(j)).sin_cos();
            let h = [alpha * (radius * cos + x), alpha * radius * sin, cap + z];
            let scale = 1.0 / h.iter().map(|c| c * c).sum::<f64>().sqrt();
            let towards = (h[0] * sine + h[2] * cosine) * scale;
            let below = 2.0 * towards * h[2] * scale - cosine;
            if below > 0.0 {
                // G2/G1 = 2 cosθo cosθi / (cosθi·so + cosθo·si) · (cosθo + so) / (2 cosθo), s being
                // lengths in stretched space.
                let (so, si) = (stretch(cosine), stretch(below));
                sum += weight * below * (cosine + so) / (below * so + cosine * si);
            }
        }
    }
    sum / (points * points) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_has_converged() {
        for alpha in [0.01, 0.1, 0.3, 1.0] {
            for cosine in [1e-3, 0.01, 0.1, 0.5, 1.0] {
                let (coarse, fine) = (albedo(cosine, alpha, POINTS), albedo(cosine, alpha, 400));
                assert!((coarse - fine).abs() < 2e-3, "α {alpha}, cosine {cosine}: {coarse} or {fine}");
            }
        }
        // D = 1/π and G2 = 2c/(1 + c) from above.
        assert!((albedo(1.0, 1.0, POINTS) - (1.0 - std::f64::consts::LN_2)).abs() < 1e-3);
    }

    #[test]
    fn the_table_is_fine_enough() {
        let table = facet_albedos();
        for row in 0..STEPS - 1 {
            for column in 0..STEPS - 1 {
                let at = row * STEPS + column;
                let corners = [table[at], table[at + 1], table[at + STEPS], table[at + STEPS + 1]];
                let mean = corners.iter().map(|&e| f64::from(e)).sum::<f64>() / 4.0;
                let middle = |i: usize| ((i as f64 + 0.5) / (STEPS - 1) as f64).powi(2);
                let exact = albedo(middle(column), middle(row), 100);
                // Within three degrees of the horizon narrow lobes turn from all to half of the
                // light.
                let most = if middle(column) < 0.06 { 0.04 } else { 0.004 };
                assert!((mean - exact).abs() < most, "{}, {}: {mean}, not {exact}", middle(column), middle(row));
            }
        }
    }
}
