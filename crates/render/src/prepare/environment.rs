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
}

impl EnvironmentTable {
    /// `None` when the map is black.
    pub(crate) fn new(map: &EnvironmentMap) -> Option<Self> {
        let (width, height) = (map.width as usize, map.height as usize);
        let luminance: Vec<f64> = map.texels.iter().map(|t| super::luminance(*t)).collect();
        let solid_angle = |row: usize| {
            let edge = |r: usize| (PI * r as f64 / height as f64).cos();
            2.0 * PI / width as f64 * (edge(row) - edge(row + 1))
        };
        // Radiance is bilinear between texel centres; a cell's weight is its mean over the cell, which is nowhere 0 where
        // the radiance is not.
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
        let texels = map
            .texels
            .iter()
            .enumerate()
            .map(|(i, t)| [t[0], t[1], t[2], (weights[i] / total / solid_angle(i / width)) as f32])
            .collect();
        Some(Self { texels, alias: alias_table(&weights), total })
    }
}
