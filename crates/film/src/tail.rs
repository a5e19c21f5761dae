//! The pixels whose error bars are reliable.
//!
//! A t interval holds when no single sample dominates. Where light arrives in rare, bright samples
//! (a caustic hit by chance) a pixel either has one, and it dominates, or has none, and its small
//! variance is then misleading.
//!
//! The *tail* of a pixel is the share of its squared deviations that its largest sample alone
//! makes, (M − m)² / Σ (x − m)²: the ratio of maximum to sum (Embrechts, Klüppelberg, Mikosch,
//! *Modelling Extremal Events*, 1997, section 6.2.6), in luminance. It goes to zero with the number
//! of samples exactly when the variance exists; it is 1/k for k equal rare events, and 1 for a
//! single one. Neighbours of a heavy tail are tested as well: by the share that the largest sample
//! there would make of *their* squared deviations. So a pixel without such a sample so far is not
//! certified either.
//!
//! A pixel is *certified* when it has samples and batches enough, and a tail below [`HEAVY`]. The
//! numbers were chosen by the coverage of intervals of certified pixels, in rooms with and without
//! glass, at 256 and 1024 samples; `tests/torture/sampling/coverage.rs` checks them.

use rayon::prelude::*;

use crate::{Film, PixelMoments, luminance};

/// Tails from here on are not certified: the largest sample makes this share of the squared
/// deviations.
pub const HEAVY: f32 = 0.5;

/// From this tail on, a pixel's largest sample is tested against its neighbours.
const SUSPECT: f32 = 0.2;

/// Samples that a certificate needs: light with a probability of one in a hundred must have been
/// sampled.
pub const MIN_CERTIFIED_SAMPLES: u64 = 256;

/// Samples that a provisional verdict needs.
pub const MIN_PROVISIONAL_SAMPLES: u64 = 64;

/// Tails from here on fail a provisional verdict. Of few samples the largest always makes a large
/// share of the squares, so the limit is higher than [`HEAVY`]. At 64 samples, 95 % intervals of
/// the pixels below it cover in 95 % to 98 % of renders, by scene
/// (`tests/torture/sampling/coverage.rs`).
const PROVISIONAL_HEAVY: f32 = 0.9;

/// Degrees of freedom that an error bar needs: 16 equal batches have 15; short ones at the
/// beginning contribute less.
const MIN_DEGREES_OF_FREEDOM: f64 = 14.0;

/// Maximum distance of tested neighbours, in pixels.
const REACH: usize = 3;

/// Whether each pixel's error bar is reliable, row by row from the top left.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Certificate {
    /// Share of the squared deviations that one sample makes or, next to heavy tails, would make: 0
    /// to 1.
    pub tail: Vec<f32>,
    /// Whether the intervals from mean and variance cover at their stated confidence.
    pub certified: Vec<bool>,
    /// Whether the tail is light so far, at [`MIN_PROVISIONAL_SAMPLES`] or more: the only statement
    /// that fewer samples than a certificate needs allow. Light in rarer samples is undetected.
    pub provisional: Vec<bool>,
    /// Whether light can reach the pixel: [`Film::reachable`].
    pub reachable: Vec<bool>,
}

impl Certificate {
    /// The certified share of the reachable pixels (of all, where none is reachable), 0 to 1.
    pub fn share(&self) -> f64 {
        self.share_of(&self.certified)
    }

    /// The share of the same pixels with a light tail so far.
    pub fn provisional_share(&self) -> f64 {
        self.share_of(&self.provisional)
    }

    fn share_of(&self, chosen: &[bool]) -> f64 {
        let count = |of: &dyn Fn(usize) -> bool| (0..chosen.len()).filter(|&i| of(i)).count();
        match count(&|i| self.reachable[i]) {
            0 => count(&|i| chosen[i]) as f64 / chosen.len().max(1) as f64,
            reachable => count(&|i| chosen[i] && self.reachable[i]) as f64 / reachable as f64,
        }
    }
}

/// The share of a sample of luminance `sample` in a pixel's squared deviations; when it is `new`,
/// it is not among them yet.
fn share(pixel: &PixelMoments, mean: f64, sample: f64, new: bool) -> f32 {
    let own = (sample - mean).max(0.0).powi(2);
    // Squares are kept to some 3 %. Where the mean is most of them, the deviations follow from the
    // spread of batches: if anything smaller, since stratified samples of a batch compensate each
    // other.
    let n = pixel.samples() as f64;
    let by_samples = pixel.squares() - n * mean * mean;
    let deviations = if by_samples > pixel.squares() / 8.0 {
        by_samples
    } else {
        (n * luminance(pixel.variance_of_mean().unwrap_or_default().map(f64::sqrt))).powi(2)
    };
    let all = if new { deviations + own } else { deviations.max(own) };
    // A sample so near the mean is no tail, however little the others vary: alone it moves the mean
    // by 1/64 of 1/n.
    if sample <= mean * (1.0 + 1.0 / 64.0) {
        0.0
    } else if all.is_finite() {
        (own / all) as f32
    } else {
        1.0
    }
}

impl Film {
    /// Whether light can reach each pixel: its first hits ([`Film::features`]) are on a surface, or
    /// a sample received light. All pixels without features. Pixels of a black environment are
    /// black for certain, and would inflate every share.
    pub fn reachable(&self) -> Vec<bool> {
        let pixels = self.pixels();
        let Some(features) = self.features() else { return vec![true; pixels.len()] };
        let has_surface =
            |i: usize| features.depth[i] > 0.0 || features.normal[i] != [0.0; 3] || features.albedo[i] != [0.0; 3];
        (0..pixels.len()).map(|i| has_surface(i) || pixels[i].largest() > 0.0).collect()
    }

    /// Judges every pixel's tail.
    pub fn certify(&self) -> Certificate {
        let (width, pixels) = (self.width() as usize, self.pixels());
        let height = self.height() as usize;
        let means: Vec<f64> = pixels.par_iter().map(|p| luminance(p.mean())).collect();
        let own: Vec<f32> = (0..pixels.len())
            .into_par_iter()
            .map(|i| share(&pixels[i], means[i], pixels[i].largest(), false))
            .collect();
        let with_neighbours = |i: usize| {
            let (x, y) = (i % width, i / width);
            let mut tail = own[i];
            for v in y.saturating_sub(REACH)..=(y + REACH).min(height - 1) {
                for u in x.saturating_sub(REACH)..=(x + REACH).min(width - 1) {
                    let j = v * width + u;
                    if own[j] >= SUSPECT {
                        tail = tail.max(share(&pixels[i], means[i], pixels[j].largest(), true));
                    }
                }
            }
            tail
        };
        let tail: Vec<f32> = (0..pixels.len()).into_par_iter().map(with_neighbours).collect();
        let light = |min_samples: u64, heavy: f32| {
            let judge = |(p, &t): (&PixelMoments, &f32)| {
                p.samples() >= min_samples && p.degrees_of_freedom() >= MIN_DEGREES_OF_FREEDOM && t < heavy
            };
            pixels.par_iter().zip(&tail).map(judge).collect()
        };
        let certified = light(MIN_CERTIFIED_SAMPLES, HEAVY);
        let provisional = light(MIN_PROVISIONAL_SAMPLES, PROVISIONAL_HEAVY);
        Certificate { tail, certified, provisional, reachable: self.reachable() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BatchSum;

    /// A film of 16 batches of 64 samples of luminance 1, where pixel `i` has `hits[i]` samples of
    /// `1 + bright` among them.
    fn film(width: u32, hits: &[u32], bright: f32) -> Film {
        let mut film = Film::new(width, hits.len() as u32 / width);
        let lanes: Vec<u32> = (0..hits.len() as u32).collect();
        for b in 0..16 {
            let sums: Vec<BatchSum> = hits
                .iter()
                .map(|&hits| {
                    let here = (b * hits / 16..(b + 1) * hits / 16).len() as f32;
                    // Noise of a tenth.
                    let sum = 64.0 + if b % 2 == 0 { 0.8 } else { -0.8 } + here * bright;
                    let squares = 64.64 + here * ((1.0 + bright).powi(2) - 1.0);
                    BatchSum::new([sum; 3], if here > 0.0 { 1.0 + bright } else { 1.2 }, squares)
                })
                .collect();
            film.add_batch(64, &lanes, &sums).unwrap();
        }
        film
    }

    #[test]
    fn one_bright_sample_is_all_of_the_tail_and_many_are_none() {
        let certificate = film(3, &[1, 0, 0], 1000.0).certify();
        assert!(certificate.tail[0] > 0.95, "{certificate:?}");
        assert_eq!(certificate.certified, [false, false, false], "neighbours may get the same");
        let certificate = film(1, &[64], 1000.0).certify();
        assert!((certificate.tail[0] - 1.0 / 64.0).abs() < 0.003, "{certificate:?}");
        assert!(certificate.certified[0]);
    }

    #[test]
    fn neighbours_beyond_reach_are_left_alone() {
        let certificate = film(6, &[1, 0, 0, 0, 0, 0], 1000.0).certify();
        assert_eq!(certificate.certified, [false, false, false, false, true, true]);
        assert!((certificate.share() - 1.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn unlit_pixels_are_not_counted() {
        let mut film = Film::new(4, 1);
        for _ in 0..16 {
            let sums = [0.5, 0.0, 0.0, 0.25].map(|grey| BatchSum::constant(16, [grey; 3]));
            film.add_batch(16, &[0, 1, 2, 3], &sums).unwrap();
        }
        assert_eq!(film.reachable(), [true; 4]);
        // The second pixel shows a surface in the dark, the third nothing, the fourth an
        // environment.
        let normal = vec![[0.0, 1.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]];
        let depth = vec![1.0, 2.0, 0.0, 0.0];
        film.set_features(crate::Features { albedo: vec![[0.0; 3]; 4], normal, depth }).unwrap();
        let mut certificate = film.certify();
        assert_eq!(certificate.reachable, [true, true, false, true]);
        assert_eq!((certificate.certified.clone(), certificate.share()), (vec![true; 4], 1.0));
        certificate.certified[0] = false;
        assert_eq!(certificate.share(), 2.0 / 3.0);
        assert_eq!(Certificate { reachable: vec![false; 4], ..certificate }.share(), 0.75);
    }

    #[test]
    fn constant_pixels_are_certified_once_there_are_batches_enough() {
        let mut film = Film::new(2, 1);
        for batch in 1..=16 {
            film.add_batch(32, &[0, 1], &[0.1, 0.0].map(|grey| BatchSum::constant(32, [grey; 3]))).unwrap();
            assert_eq!(film.certify().certified, [batch >= 15; 2], "{batch}");
        }
        assert!(film.certify().tail.iter().all(|&t| t < 0.01));
    }
}
