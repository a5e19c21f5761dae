//! The directional albedo of the sheen layer, as a lookup table of the kernel.
//!
//! KHR_materials_sheen's "Charlie" model (Conty Estevez & Kulla 2017) has no closed form for it, so
//! it is integrated here: once a process, in f64.

use std::f64::consts::PI;
use std::sync::OnceLock;

use surelight_estimate::gauss_legendre;

use crate::shared::{SHEEN_COLUMNS, SHEEN_ROWS};

const COLUMNS: usize = SHEEN_COLUMNS as usize;
const ROWS: usize = SHEEN_ROWS as usize;

/// Cosines are clamped to at least this.
const MIN_COSINE: f64 = 1e-3;

/// The table, row after row.
pub fn sheen_albedos() -> &'static [f32] {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    TABLE.get_or_init(|| {
        let at = |i: usize, n: usize| i as f64 / (n - 1) as f64;
        let entries = (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column)));
        entries
            .map(|(row, column)| albedo(at(column, COLUMNS).powi(2), (0.1 + 0.9 * at(row, ROWS)).powi(2)) as f32)
            .collect()
    })
}

/// ∫ D·V·cosθi dωi of white fibres viewed at this cosine.
fn albedo(cos_o: f64, alpha: f64) -> f64 {
    integral(cos_o.max(MIN_COSINE), alpha, 32)
}

/// Gauss–Legendre in φ, where the integrand is even, and in sqrt(cosθi), since masking is steep at
/// the horizon.
fn integral(cos_o: f64, alpha: f64, points: usize) -> f64 {
    let nodes = gauss_legendre(points);
    let sin_o = (1.0 - cos_o * cos_o).sqrt();
    let lambda_o = lambda(cos_o, alpha);
    let cosines: Vec<f64> = nodes.iter().map(|&(x, _)| (PI * (0.5 + 0.5 * x)).cos()).collect();
    let mut sum = 0.0;
    for &(x, weight) in &nodes {
        let t = 0.5 + 0.5 * x;
        let cos_i = t * t;
        let sin_i = (1.0 - cos_i * cos_i).max(0.0).sqrt();
        let z = cos_o + cos_i;
        // D over the azimuth.
        let d: f64 = cosines
            .iter()
            .zip(&nodes)
            .map(|(&cos_phi, &(_, weight))| {
                let xy = sin_o * sin_o + sin_i * sin_i + 2.0 * sin_o * sin_i * cos_phi;
                weight * (xy.max(0.0) / (xy + z * z)).powf(0.5 / alpha)
            })
            .sum();
        // Both halves of the azimuth, each π long; dcosθi = 2t dt; nodes and weights are those of
        // [−1, 1].
        sum += weight * t * d * PI / (4.0 * cos_o * (1.0 + lambda_o + lambda(cos_i.max(MIN_COSINE), alpha)));
    }
    sum * (2.0 + 1.0 / alpha) / (2.0 * PI)
}

/// Smith's Λ as fitted by Conty Estevez & Kulla 2017, section 2.
fn lambda(cosine: f64, alpha: f64) -> f64 {
    let fit = |x: f64| {
        let t = (1.0 - alpha).powi(2);
        let mix = |rough: f64, smooth: f64| rough + (smooth - rough) * t;
        let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
        a / (1.0 + b * x.powf(c)) + mix(-1.97760, -1.27393) * x + mix(-4.32054, -4.85967)
    };
    if cosine < 0.5 { fit(cosine).exp() } else { (2.0 * fit(0.5) - fit(1.0 - cosine)).exp() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quadrature_has_converged() {
        for alpha in [0.01, 0.03, 0.1, 0.3, 1.0] {
            for cosine in [1e-3, 0.01, 0.1, 0.3, 0.7, 1.0] {
                let (coarse, fine) = (integral(cosine, alpha, 32), integral(cosine, alpha, 128));
                assert!((coarse - fine).abs() < 5e-4 * fine.max(0.1), "α {alpha}, cosine {cosine}: {coarse} or {fine}");
            }
        }
    }

    /// Between its nodes the table must not be smaller than the truth by more than a little, or
    /// light would be gained.
    #[test]
    fn the_table_is_fine_enough() {
        let table = sheen_albedos();
        for row in 0..ROWS - 1 {
            for column in 1..COLUMNS - 1 {
                let at = row * COLUMNS + column;
                let corners = [table[at], table[at + 1], table[at + COLUMNS], table[at + COLUMNS + 1]];
                let mean = corners.iter().map(|&e| f64::from(e)).sum::<f64>() / 4.0;
                let cosine = ((column as f64 + 0.5) / (COLUMNS - 1) as f64).powi(2);
                let alpha = (0.1 + 0.9 * (row as f64 + 0.5) / (ROWS - 1) as f64).powi(2);
                let exact = albedo(cosine, alpha);
                let error = (mean - exact) / exact.max(0.5);
                // Within two degrees of the horizon sharp fibres turn from one to the next.
                let (least, most) = if cosine < 0.03 { (-5e-3, 2e-2) } else { (-2e-3, 5e-3) };
                assert!((least..most).contains(&error), "{cosine}, {alpha}: {mean}, not {exact}");
            }
        }
    }
}
