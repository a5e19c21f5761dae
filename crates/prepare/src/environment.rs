//! An environment map made ready for lookup and for sampling.

use std::f64::consts::PI;

use surelight_scene::EnvironmentMap;

use super::alias::{Slot, alias_table};

/// Texels with their sampling density, and the alias table over them.
pub(crate) struct EnvironmentTable {
    /// Radiance, and the pdf (1/sr) of directions in the texel when the map is sampled.
    pub(crate) texels: Vec<[f32; 4]>,
    pub(crate) alias: Vec<Slot>,
    /// ∫ luminance dω over all directions, before the factor on the map.
    pub(crate) total: f64,
    /// Where the pdf is at least this, radiance is twice the mean or more, and sampled about in
    /// proportion: a source of light for which tracing may pay. Infinite where the map has none.
    pub(crate) source_pdf: f32,
}

/// Least share of the light that compensated sampling must be left with.
const MIN_REMAINDER: f64 = 0.01;

impl EnvironmentTable {
    /// `None` when the map is black.
    ///
    /// `compensated`: directions from BSDFs are sampled, too, and find dim texels well enough. Then
    /// only the excess over the mean is sampled, in proportion to it (Karlík, Šik, Vévoda, Skřivan
    /// & Křivánek 2019, "MIS compensation: optimizing sampling techniques in multiple importance
    /// sampling", section 5).
    pub(crate) fn new(map: &EnvironmentMap, compensated: bool) -> Option<Self> {
        let (width, height) = (map.width as usize, map.height as usize);
        let luminance: Vec<f64> = map.texels.iter().map(|t| crate::luminance::luminance(*t)).collect();
        let solid_angle = |row: usize| {
            let edge = |r: usize| (PI * r as f64 / height as f64).cos();
            2.0 * PI / width as f64 * (edge(row) - edge(row + 1))
        };
        // Radiance is bilinear between texel centres; a cell's weight is its mean over the cell,
        // which before compensation is nowhere 0 where the radiance is not.
        let mut weights = Vec::with_capacity(luminance.len());
        for y in 0..height {
            let rows = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
            for x in 0..width {
                let columns = [(x + width - 1) % width, x, (x + 1) % width];
                let mut mean = 0.0;
                for (row, wy) in rows.iter().zip([0.125, 0.75, 0.125]) {
                    for (column, wx) in columns.iter().zip([0.125, 0.75, 0.125]) {
                        mean += wx * wy * luminance[row * width + column];
                    }
                }
                weights.push(mean * solid_angle(y));
            }
        }
        let total: f64 = weights.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let weights = if compensated { compensate(weights, total, |i| solid_angle(i / width)) } else { weights };
        let sum: f64 = weights.iter().sum();
        let source_pdf = if sum < total { (total / (4.0 * PI) / sum) as f32 } else { f32::INFINITY };
        let texels = map
            .texels
            .iter()
            .enumerate()
            .map(|(i, t)| [t[0], t[1], t[2], (weights[i] / sum / solid_angle(i / width)) as f32])
            .collect();
        Some(Self { texels, alias: alias_table(&weights), total, source_pdf })
    }
}

/// Takes the mean radiance off all weights; leaves them alone where next to nothing would be left,
/// as of a uniform map.
fn compensate(weights: Vec<f64>, total: f64, solid_angle: impl Fn(usize) -> f64) -> Vec<f64> {
    let mean = total / (4.0 * PI);
    let left: Vec<f64> = weights.iter().enumerate().map(|(i, w)| (w - mean * solid_angle(i)).max(0.0)).collect();
    if left.iter().sum::<f64>() < MIN_REMAINDER * total { weights } else { left }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(texel: impl Fn(u32, u32) -> f32, compensated: bool) -> EnvironmentTable {
        let texels = (0..32).map(|i| [texel(i % 8, i / 8); 3]).collect();
        let map = EnvironmentMap { width: 8, height: 4, texels };
        EnvironmentTable::new(&map, compensated).expect("the map shines")
    }

    #[test]
    fn compensation_leaves_dim_texels_to_directions() {
        let texel = |x, y| if (x, y) == (3, 1) { 100.0 } else { 1.0 };
        let (plain, compensated) = (table(texel, false), table(texel, true));
        assert!(plain.texels.iter().all(|t| t[3] > 0.0));
        assert_eq!(compensated.texels[31][3], 0.0);
        assert!(compensated.texels[8 + 3][3] > plain.texels[8 + 3][3]);
        // The weight of the environment among other lights is unchanged.
        assert_eq!(plain.total, compensated.total);
    }

    #[test]
    fn a_uniform_map_is_sampled_evenly() {
        for t in table(|_, _| 0.3, true).texels {
            assert!((f64::from(t[3]) * 4.0 * PI - 1.0).abs() < 1e-6, "{t:?}");
        }
    }
}
