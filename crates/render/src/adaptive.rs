//! Adaptive sampling: the distribution of samples over blocks of pixels, by the noise of a pilot of
//! a few samples per pixel.
//!
//! For a relative squared error ε² = mean(σ²/(n w)) with Σ n given, the optimal n is proportional
//! to σ/√w. The pilot's samples are discarded: an image whose samples decide their own number is
//! biased.

use surelight_film::{Film, MIN_CERTIFIED_SAMPLES, Window};
use surelight_prepare::{KernelKey, Part, luminance};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Resource, Resources},
    noise,
    upload::Uploader,
};

pub(crate) use surelight_prepare::shared::ADAPTIVE_BLOCK as BLOCK;
use surelight_prepare::shared::MIN_ADAPTIVE_BATCH as MIN_BATCH;

/// A share of 1: quarters of a sample per requested sample.
const WHOLE: u32 = 4;

/// The maximum share. In simulations on bigscene, 16 samples per requested one gain no more than 8.
const MAX_SHARE: u32 = 8 * WHOLE;

/// The reduction of the squared error, at an equal number of samples, that the pilot must predict.
const MIN_GAIN: f64 = 1.25;

/// Batches of the pilot, and samples per pixel in each: two, so that differences that cancel
/// between two samples are not taken for noise.
pub(crate) const PILOT: [u32; 2] = [2, 2];

/// The pilot's seed is the image's seed XOR this.
pub(crate) const PILOT_SEED: u32 = 0x5bd1_e995;

/// Each block's share of the samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Shares {
    /// In quarters: 1 to 3, or a multiple of 4.
    pub(crate) quarters: Vec<u32>,
    /// Blocks per row.
    across: u32,
}

impl Shares {
    /// Equal shares.
    pub(crate) fn even([width, height]: [u32; 2]) -> Self {
        let across = width.div_ceil(BLOCK);
        Self { quarters: vec![WHOLE; (across * height.div_ceil(BLOCK)) as usize], across }
    }

    /// Shares proportional to the noise of a film of the whole image, from `min` quarters to 8; a
    /// block of mean noise gets 1. Equal shares where these would not reduce the squared error by
    /// [`MIN_GAIN`] at an equal number of samples.
    pub(crate) fn by_noise(film: &Film, min: u32) -> Self {
        let even = Self::even([film.width(), film.height()]);
        let halves = even.noise(film);
        let blocks = even.quarters.len();
        let sum = |of: &dyn Fn(usize) -> f64| (0..blocks).map(of).sum::<f64>();
        let quarters = |noise: &dyn Fn(usize) -> f64| -> Vec<u32> {
            let usual = (sum(noise) / blocks as f64).max(f64::MIN_POSITIVE);
            (0..blocks).map(|k| in_quarters(noise(k) / usual).clamp(min, MAX_SHARE)).collect()
        };
        // Blocks that appear noisy by chance must not be counted as a gain: shares from one half of
        // a block's pixels are evaluated on the other half.
        let [mut before, mut after] = [0.0; 2];
        for (judged, by) in [(0, 1), (1, 0)] {
            let shares: Vec<f64> = quarters(&|k| halves[k][by]).into_iter().map(f64::from).collect();
            let variance = |k: usize| halves[k][judged].powi(2);
            before += blocks as f64 * sum(&variance);
            after += sum(&|k| shares[k]) * sum(&|k| variance(k) / shares[k]);
        }
        if before <= MIN_GAIN * after {
            return even;
        }
        Self { quarters: quarters(&|k| halves[k][0].hypot(halves[k][1])), ..even }
    }

    /// For each block the root mean square of its pixels' relative noise: over every other pixel,
    /// and over the remaining ones.
    fn noise(&self, film: &Film) -> Vec<[f64; 2]> {
        let means: Vec<f64> = (0..film.pixels().len()).map(|p| luminance(film.mean(p).map(|c| c as f32))).collect();
        let mut blocks = vec![[(0.0, 0u32); 2]; self.quarters.len()];
        for (p, weight) in noise::weights(&means).into_iter().enumerate() {
            let (x, y) = (p as u32 % film.width(), p as u32 / film.width());
            let half = &mut blocks[self.block(x, y)][((x + y) % 2) as usize];
            *half = (half.0 + noise::variance(film, p) * weight, half.1 + 1);
        }
        let root = |(sum, pixels): (f64, u32)| (sum / f64::from(pixels.max(1))).sqrt();
        blocks.into_iter().map(|halves| halves.map(root)).collect()
    }

    fn block(&self, x: u32, y: u32) -> usize {
        (y / BLOCK * self.across + x / BLOCK) as usize
    }

    /// Samples of a pixel of the whole image in a batch of `samples`, at least 1, as in
    /// `samples_of` of `lanes.wesl`.
    pub(crate) fn samples(&self, [x, y]: [u32; 2], samples: u32) -> u32 {
        let share = self.quarters[self.block(x, y)];
        if samples >= MIN_BATCH { samples * share / WHOLE } else { samples * (share / WHOLE).max(1) }
    }

    /// The mean share over a window's pixels.
    pub(crate) fn mean(&self, window: &Window) -> f64 {
        let [x0, y0, x1, y1] = window.edges();
        let row = |y: u32| (x0..x1).map(|x| u64::from(self.quarters[self.block(x, y)])).sum::<u64>();
        (y0..y1).map(row).sum::<u64>() as f64 / (f64::from(WHOLE) * window.area() as f64)
    }
}

/// A share in quarters of a sample, rounded; from 1 on an integer share, since batches of any
/// length can be multiplied.
fn in_quarters(share: f64) -> u32 {
    let [quarters, wholes] = [4.0, 1.0].map(|parts| (share * parts).round() as u32);
    if quarters < WHOLE { quarters } else { WHOLE * wholes.max(1) }
}

/// The minimum share, in quarters, at a planned number of samples per pixel: a pixel that would
/// have enough samples to be certified with equal shares keeps enough.
pub(crate) fn min_share(planned: Option<u32>) -> u32 {
    let planned = planned.map_or(MIN_CERTIFIED_SAMPLES, u64::from);
    if planned < MIN_CERTIFIED_SAMPLES {
        1
    } else {
        (u64::from(WHOLE) * MIN_CERTIFIED_SAMPLES).div_ceil(planned) as u32
    }
}

/// The shares, and the buffer that the kernel reads them from.
pub(crate) struct SharesOnDevice {
    pub(crate) shares: Shares,
    buffer: wgpu::Buffer,
}

impl SharesOnDevice {
    /// Equal shares, added to the resources; `None` where the kernel is not adaptive.
    pub(crate) fn new(
        up: &mut Uploader<'_>,
        resources: &mut Resources,
        key: &KernelKey,
        size: [u32; 2],
    ) -> Result<Option<Self>, RenderError> {
        use wgpu::BufferUsages as U;
        if !key.has(Part::Adaptive) {
            return Ok(None);
        }
        let shares = Shares::even(size);
        let buffer = up.buffer("shares of the samples", &shares.quarters, U::STORAGE | U::COPY_DST)?;
        resources.insert("quarters".into(), Resource::Buffer(buffer.clone()));
        Ok(Some(Self { shares, buffer }))
    }

    /// Changes the shares for later dispatches.
    pub(crate) fn set(&mut self, device: &Device, shares: Shares) {
        device.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&shares.quarters));
        self.shares = shares;
    }
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
        // 3 : 2 : 2 : 2, with a possible gain of 1.04.
        assert_eq!(quarters(&film([16, 16], 1.0, |x, y| if x < 8 && y < 8 { 0.003 } else { 0.002 })), [4; 4]);
    }

    #[test]
    fn samples_are_in_proportion_to_noise() {
        // 7 : 1 : 1 : 1, whose mean is 2.5; images need not be whole blocks.
        let of = |x, y| if x >= 8 && y < 8 { 0.007 } else { 0.001 };
        let shares = Shares::by_noise(&film([13, 11], 7.0, of), 1);
        assert_eq!(shares.quarters, [2, 12, 2, 2], "2.8 is rounded to 3, 0.4 to 0.5");
        let pixels = f64::from(13 * 11);
        assert_eq!(shares.mean(&Window::all(13, 11)), (0.5 * pixels + 2.5 * f64::from(5 * 8)) / pixels);
        assert_eq!(shares.mean(&Window::crop([13, 11], [7, 6, 9, 9]).unwrap()), (4.0 * 0.5 + 2.0 * 3.0) / 6.0);
        // Not below the minimum.
        assert_eq!(Shares::by_noise(&film([13, 11], 7.0, of), 3).quarters, [3, 12, 3, 3]);
        // One noisy block of 36, some without noise: the maximum and the minimum.
        let one = |x, y| if x < 8 && y >= 40 { 0.1 } else { 0.001 * (x / 8) as f32 };
        let one = quarters(&film([48, 48], 1.0, one));
        assert_eq!((one[30], one[0]), (MAX_SHARE, 1));
    }

    /// Noise in one pixel of a block and not in its neighbours is no evidence about the block.
    #[test]
    fn chance_is_no_gain() {
        let specks = |x: u32, y: u32| if x % 5 == 1 && y % 7 == 2 { 0.1 } else { 0.001 };
        assert_eq!(quarters(&film([40, 40], 1.0, specks)), [4; 25]);
        let areas = |x: u32, y: u32| if x < 8 && y < 16 { 0.1 } else { 0.001 };
        assert_eq!(quarters(&film([40, 40], 1.0, areas)).iter().filter(|&&q| q > 4).count(), 2);
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
        assert_eq!([Some(16), Some(255)].map(min_share), [1, 1]);
        for planned in 256..3000 {
            let min = min_share(Some(planned));
            assert!(planned * min / WHOLE >= 256, "{planned}");
            assert!(min == 1 || planned * (min - 1) / WHOLE < 256, "{planned}");
        }
        assert_eq!(min_share(None), WHOLE);
    }

    #[test]
    fn the_dark_does_not_decide() {
        // The left half has a thousandth of the right half's radiance and the same relative noise:
        // a negligible part of the image.
        let mut film = Film::new(16, 8);
        let all: Vec<u32> = (0..128).collect();
        for k in [1.0, 1.5] {
            let of = |p: &u32| BatchSum::constant(1, [if p % 16 < 8 { 0.001 * k } else { k }; 3]);
            film.add_batch(1, &all, &all.iter().map(of).collect::<Vec<_>>()).unwrap();
        }
        assert_eq!(quarters(&film), [1, 8]);
    }
}
