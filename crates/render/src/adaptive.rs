//! Which pixels get more samples than others: by how noisy a few samples of each block of the picture are.
//!
//! For a picture of relative squared error ε² = mean(σ²/(n w)) with Σ n given, n in proportion to σ/√w is best. It is found from samples of
//! their own, which are thrown away: a picture whose samples decided how many of them there are would be biased.

use surelight_film::{Film, LEAST_SAMPLES, Window};

use crate::{noise, prepare::luminance};

/// Pixels along a side of a block. Twin of `quarters` in `shaders/kernel/lanes.wesl`.
pub(crate) const BLOCK: u32 = 8;

/// Samples of the shortest batch in which some pixels have fewer than others. Twin of `LEAST_BATCH` there.
const LEAST_BATCH: u32 = 4;

/// A whole share, in quarters of a sample for each one that is asked for.
const WHOLE: u32 = 4;

/// The greatest share. Simulated on bigscene, 16 samples for one are no better than 8.
const MOST: u32 = 8 * WHOLE;

/// By how much the look must promise to lessen the error, at as many samples: below it costs more than it brings.
const WORTH: f64 = 1.25;

/// Of fewer samples the look takes too much.
const LEAST_PLAN: u32 = 64;

/// Batches to judge by, and samples of a batch.
pub(crate) const LOOK: [u32; 2] = [2, 2];

/// What the picture's seed is changed by while it is looked at.
pub(crate) const LOOK_SEED: u32 = 0x5bd1_e995;

/// For each block of a picture its share of the samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shares {
    /// In quarters: 1 to 3, or a multiple of 4.
    pub(crate) quarters: Vec<u32>,
    /// Blocks a row.
    across: u32,
}

impl Shares {
    /// The same for all.
    pub(crate) fn even([width, height]: [u32; 2]) -> Self {
        let across = width.div_ceil(BLOCK);
        Self { quarters: vec![WHOLE; (across * height.div_ceil(BLOCK)) as usize], across }
    }

    /// In proportion to the noise of a film of the whole picture, from `least` quarters to 8 wholes; a block of mean noise gets one. Where
    /// noise is much the same everywhere, the same for all.
    pub(crate) fn by_noise(film: &Film, least: u32) -> Self {
        let [width, height] = [film.width(), film.height()];
        let even = Self::even([width, height]);
        let means: Vec<f64> = (0..film.pixels().len()).map(|p| luminance(film.mean(p).map(|c| c as f32))).collect();
        let mut blocks = vec![(0.0, 0u32); even.quarters.len()];
        for (p, weight) in noise::weights(&means).into_iter().enumerate() {
            let relative = noise::variance(film, p) * weight;
            let (x, y) = (p as u32 % width, p as u32 / width);
            let block = &mut blocks[even.block(x, y)];
            *block = (block.0 + relative, block.1 + 1);
        }
        let variances: Vec<f64> = blocks.iter().map(|&(sum, pixels)| sum / f64::from(pixels)).collect();
        let mean = |of: &dyn Fn(f64) -> f64| variances.iter().map(|&v| of(v)).sum::<f64>() / variances.len() as f64;
        let usual = mean(&f64::sqrt).max(f64::MIN_POSITIVE);
        // Errors are as the mean of variances where samples are even, and as the squared mean of their roots where they are as these.
        if mean(&|v| v) < WORTH * usual * usual {
            return even;
        }
        let quarters = variances.iter().map(|v| in_quarters(v.sqrt() / usual).clamp(least, MOST)).collect();
        Self { quarters, ..even }
    }

    fn block(&self, x: u32, y: u32) -> usize {
        (y / BLOCK * self.across + x / BLOCK) as usize
    }

    /// Samples of a pixel of the whole picture in a batch of `samples`, 1 at least. Twin of `samples_of` in `lanes.wesl`.
    pub(crate) fn samples(&self, [x, y]: [u32; 2], samples: u32) -> u32 {
        let share = self.quarters[self.block(x, y)];
        if samples >= LEAST_BATCH { samples * share / WHOLE } else { samples * (share / WHOLE).max(1) }
    }

    /// The mean over a window's pixels.
    pub(crate) fn mean(&self, window: &Window) -> f64 {
        let [x0, y0, x1, y1] = window.edges();
        let row = |y: u32| (x0..x1).map(|x| u64::from(self.quarters[self.block(x, y)])).sum::<u64>();
        (y0..y1).map(row).sum::<u64>() as f64 / (f64::from(WHOLE) * window.area() as f64)
    }
}

/// A share of noise as quarters of a sample, rounded; in wholes from one on, since batches of any length can be multiplied.
fn in_quarters(share: f64) -> u32 {
    let [quarters, wholes] = [4.0, 1.0].map(|parts| (share * parts).round() as u32);
    if quarters < WHOLE { quarters } else { WHOLE * wholes.max(1) }
}

/// Whether what adaptive samples can bring is worth their look, when so many samples a pixel are planned.
pub fn is_worth_a_look(planned: u32) -> bool {
    planned >= LEAST_PLAN && least_share(Some(planned)) <= WHOLE / 2
}

/// The least share in quarters when so many samples a pixel are planned: those that a certificate takes are left to every pixel that would
/// have them otherwise.
pub(crate) fn least_share(planned: Option<u32>) -> u32 {
    let planned = planned.map_or(LEAST_SAMPLES, u64::from);
    if planned < LEAST_SAMPLES { 1 } else { (u64::from(WHOLE) * LEAST_SAMPLES).div_ceil(planned) as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use surelight_film::BatchSum;

    /// Two batches of one sample, the second brighter by `spread` of the pixel.
    fn film([width, height]: [u32; 2], brightness: f32, spread: impl Fn(u32, u32) -> f32) -> Film {
        let mut film = Film::new(width, height);
        let all: Vec<u32> = (0..width * height).collect();
        for k in [0.0, 1.0] {
            let of = |p: &u32| BatchSum::constant(1, [brightness * (1.0 + k * spread(p % width, p / width)); 3]);
            film.add_batch(1, &all, &all.iter().map(of).collect::<Vec<_>>()).unwrap();
        }
        film
    }

    fn quarters(film: &Film) -> Vec<u32> {
        Shares::by_noise(film, 1).quarters
    }

    #[test]
    fn even_noise_and_none_are_shared_evenly() {
        assert_eq!(quarters(&film([16, 16], 1.0, |_, _| 0.5)), [4; 4]);
        assert_eq!(quarters(&film([16, 16], 1.0, |_, _| 0.0)), [4; 4]);
        assert_eq!(quarters(&film([16, 16], 0.0, |_, _| 0.0)), [4; 4]);
        // 3 : 2 : 2 : 2, from which 1.04 could be gained.
        assert_eq!(quarters(&film([16, 16], 1.0, |x, y| if x < 8 && y < 8 { 0.003 } else { 0.002 })), [4; 4]);
    }

    #[test]
    fn samples_are_in_proportion_to_noise() {
        // 5 : 1 : 1 : 1, whose mean is 2; pictures need not be whole blocks.
        let of = |x, y| if x >= 8 && y < 8 { 0.005 } else { 0.001 };
        let shares = Shares::by_noise(&film([13, 11], 7.0, of), 1);
        assert_eq!(shares.quarters, [2, 12, 2, 2], "2.5 is rounded to 3");
        let pixels = f64::from(13 * 11);
        assert_eq!(shares.mean(&Window::all(13, 11)), (0.5 * pixels + 2.5 * f64::from(5 * 8)) / pixels);
        assert_eq!(shares.mean(&Window::crop([13, 11], [7, 6, 9, 9]).unwrap()), (4.0 * 0.5 + 2.0 * 3.0) / 6.0);
        // No less than asked for.
        assert_eq!(Shares::by_noise(&film([13, 11], 7.0, of), 3).quarters, [3, 12, 3, 3]);
        // One of 36, and some without noise: as many as may be, and as few.
        let one = |x, y| if x < 8 && y >= 40 { 0.1 } else { 0.001 * (x / 8) as f32 };
        let one = quarters(&film([48, 48], 1.0, one));
        assert_eq!((one[30], one[0]), (MOST, 1));
    }

    #[test]
    fn batches_have_a_sample_at_least() {
        let shares = Shares { quarters: vec![1, 2, 3, 4, 8], across: 5 };
        let of = |samples| [0, 1, 2, 3, 4].map(|block| shares.samples([8 * block + 3, 7], samples));
        assert_eq!(of(1), [1, 1, 1, 1, 2]);
        assert_eq!(of(3), [3, 3, 3, 3, 6]);
        assert_eq!(of(4), [1, 2, 3, 4, 8]);
        assert_eq!(of(7), [1, 3, 5, 7, 14]);
        assert_eq!(of(4096), [1024, 2048, 3072, 4096, 8192]);
    }

    #[test]
    fn what_could_be_certified_still_can() {
        assert_eq!([Some(16), Some(255)].map(least_share), [1, 1]);
        for planned in 256..3000 {
            let least = least_share(Some(planned));
            assert!(planned * least / WHOLE >= 256, "{planned}");
            assert!(least == 1 || planned * (least - 1) / WHOLE < 256, "{planned}");
        }
        assert_eq!(least_share(None), WHOLE);
        assert_eq!([16, 63, 64, 255, 256, 511, 512].map(is_worth_a_look), [false, false, true, true, false, false, true]);
    }

    #[test]
    fn the_dark_does_not_decide() {
        // Left a thousandth as bright as right, and as noisy in relation: next to nothing of what is seen.
        let mut film = Film::new(16, 8);
        let all: Vec<u32> = (0..128).collect();
        for k in [1.0, 1.5] {
            let of = |p: &u32| BatchSum::constant(1, [if p % 16 < 8 { 0.001 * k } else { k }; 3]);
            film.add_batch(1, &all, &all.iter().map(of).collect::<Vec<_>>()).unwrap();
        }
        assert_eq!(quarters(&film), [1, 8]);
    }
}
