//! The numbers behind a measurement: batches of pixels, each an independent estimate.

use surelight_estimate::{Estimate, Moments, ParetoFit, pareto_k, satterthwaite};
use surelight_film::Film;

/// Red, green, blue, and the Rec. 709 luminance of the three.
pub(super) const QUANTITIES: usize = 4;
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// Estimates that are kept for judging the tail.
const MAX_KEPT: usize = 1 << 20;

/// Batches added up.
pub(super) struct Tally {
    /// One group where all pixels estimate the same number, else one per pixel.
    groups: Vec<[Moments; QUANTITIES]>,
    kept: Vec<f64>,
    batches: u32,
}

impl Tally {
    /// Of so many pixels; `same_quantity`: all estimate the same number.
    pub(super) fn new(pixels: usize, same_quantity: bool) -> Self {
        let groups = vec![[Moments::default(); QUANTITIES]; if same_quantity { 1 } else { pixels }];
        Self { groups, kept: Vec::new(), batches: 0 }
    }

    /// Adds one batch: a film that holds nothing else.
    pub(super) fn add(&mut self, film: &Film) {
        self.batches += 1;
        for i in (0..film.pixels().len()).filter(|&i| film.samples(i) > 0) {
            let [r, g, b] = film.mean(i);
            let y = LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b;
            let group = if self.groups.len() == 1 { 0 } else { i };
            // Beside its pixel's mean so far: pixels differ without being noisy.
            if self.kept.len() < MAX_KEPT && (self.groups_are_one() || self.batches > 1) {
                let level = if self.groups_are_one() { 0.0 } else { self.groups[group][3].mean() };
                self.kept.push(y - level);
            }
            for (moments, value) in self.groups[group].iter_mut().zip([r, g, b, y]) {
                moments.push(value);
            }
        }
    }

    fn groups_are_one(&self) -> bool {
        self.groups.len() == 1
    }

    /// Mean, variance of the mean and degrees of freedom of each quantity, times a factor.
    pub(super) fn estimates(&self, factor: f64) -> [Estimate; QUANTITIES] {
        std::array::from_fn(|q| {
            let count = self.groups.len() as f64;
            let mean = self.groups.iter().map(|g| g[q].mean()).sum::<f64>() / count;
            let terms: Vec<(f64, f64)> = self
                .groups
                .iter()
                .map(|g| (g[q].variance_of_mean() / (count * count), g[q].count() as f64 - 1.0))
                .collect();
            let variance = terms.iter().map(|t| t.0).sum::<f64>();
            let dof = if variance > 0.0 { satterthwaite(&terms) } else { terms.iter().map(|t| t.1).sum() };
            Estimate { mean: mean * factor, variance: variance * factor * factor, dof }
        })
    }

    /// An upper bound, at about two standard errors, of the luminance's variance of the mean.
    pub(super) fn cautious_variance(&self, factor: f64) -> f64 {
        let count = (self.groups.len() as f64).powi(2);
        let own = |g: &[Moments; QUANTITIES]| {
            let variance = g[3].variance_of_mean() / count;
            g[3].variance_of_variance() * variance * variance
        };
        let spread = self.groups.iter().map(own).filter(|v| v.is_finite()).sum::<f64>().sqrt();
        self.estimates(factor)[3].variance + 2.0 * spread * factor * factor
    }

    /// Batches added.
    pub(super) fn batches(&self) -> u32 {
        self.batches
    }

    /// Estimates behind it: pixels × batches.
    pub(super) fn replicates(&self) -> u64 {
        self.groups.iter().map(|g| g[3].count()).sum()
    }

    /// The tail of the estimates' luminance; `None` where there is none to judge.
    pub(super) fn tail(&mut self) -> Option<ParetoFit> {
        pareto_k(&mut self.kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use surelight_film::BatchSum;

    fn film(values: &[f32]) -> Film {
        let mut film = Film::new(values.len() as u32, 1);
        let lanes: Vec<u32> = (0..values.len() as u32).collect();
        let sums: Vec<_> = values.iter().map(|&v| BatchSum::constant(1, [v, 2.0 * v, 0.0])).collect();
        film.add_batch(1, &lanes, &sums).unwrap();
        film
    }

    #[test]
    fn equal_pixels_are_one_sample_and_others_are_strata() {
        let batches = [film(&[1.0, 3.0]), film(&[2.0, 6.0]), film(&[3.0, 3.0])];
        let (mut one, mut many) = (Tally::new(2, true), Tally::new(2, false));
        for batch in &batches {
            one.add(batch);
            many.add(batch);
        }
        let all: Moments = [1.0, 3.0, 2.0, 6.0, 3.0, 3.0].into_iter().collect();
        let found = one.estimates(2.0);
        assert!((found[0].mean - 6.0).abs() < 1e-12 && (found[1].mean - 12.0).abs() < 1e-12);
        assert!((found[0].variance - 4.0 * all.variance_of_mean()).abs() < 1e-12);
        assert_eq!((found[0].dof, one.replicates()), (5.0, 6));
        assert!((found[3].mean - 6.0 * (0.2126 + 2.0 * 0.7152)).abs() < 1e-9);
        // Of the strata: variances 1 and 3 of three values each.
        let found = many.estimates(1.0);
        assert!((found[0].mean - 3.0).abs() < 1e-12);
        assert!((found[0].variance - (1.0 + 3.0) / 3.0 / 4.0).abs() < 1e-12);
        assert!((found[0].dof - 16.0 / (1.0 / 2.0 + 9.0 / 2.0)).abs() < 1e-9);
    }
}
