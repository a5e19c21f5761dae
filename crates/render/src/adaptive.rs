//! Where a sample is worth several paths: by how noisy a few samples of each block of the picture are.
//!
//! For a picture of relative squared error ε² = mean(σ²/(n w)) with Σ n given, n in proportion to σ/√w is best. It is found from samples of
//! their own, which are thrown away: a picture whose samples decided how many of them there are would be biased.

use surelight_film::{Film, Window};

use crate::{noise, prepare::luminance};

/// Pixels along a side of a block. Twin of `multiplicities` in `shaders/kernel/lanes.wesl`.
pub(crate) const BLOCK: u32 = 8;

/// Most paths of a sample. Simulated on bigscene, 16 are no better than 8.
pub(crate) const MOST: u32 = 8;

/// Batches to judge by, and samples of a batch.
pub(crate) const LOOK: [u32; 2] = [4, 2];

/// What the picture's seed is changed by while it is looked at.
pub(crate) const LOOK_SEED: u32 = 0x5bd1_e995;

/// For each block of the film's whole picture, row after row: a block of mean noise gets one path a sample, others in proportion to their
/// noise, rounded, at least 1 and at most [`MOST`].
pub(crate) fn multiplicities(film: &Film) -> Vec<u32> {
    let [width, height] = [film.width(), film.height()];
    let across = width.div_ceil(BLOCK);
    let count = film.pixels().len();
    let means: Vec<f64> = (0..count).map(|p| luminance(film.mean(p).map(|c| c as f32))).collect();
    let mut blocks = vec![(0.0, 0u32); (across * height.div_ceil(BLOCK)) as usize];
    for (p, weight) in noise::weights(&means).into_iter().enumerate() {
        let relative = noise::variance(film, p) * weight;
        let (x, y) = (p as u32 % width, p as u32 / width);
        let block = &mut blocks[(y / BLOCK * across + x / BLOCK) as usize];
        *block = (block.0 + relative, block.1 + 1);
    }
    let noises: Vec<f64> = blocks.iter().map(|&(sum, pixels)| (sum / f64::from(pixels)).sqrt()).collect();
    let usual = (noises.iter().sum::<f64>() / noises.len() as f64).max(f64::MIN_POSITIVE);
    noises.iter().map(|n| (n / usual).round().clamp(1.0, MOST.into()) as u32).collect()
}

/// The mean over a window's pixels of a number given by blocks.
pub(crate) fn mean(of_blocks: &[u32], window: &Window) -> f64 {
    let across = window.whole[0].div_ceil(BLOCK);
    let [x0, y0, x1, y1] = window.edges();
    let of = |x: u32, y: u32| u64::from(of_blocks[(y / BLOCK * across + x / BLOCK) as usize]);
    let sum: u64 = (y0..y1).map(|y| (x0..x1).map(|x| of(x, y)).sum::<u64>()).sum();
    sum as f64 / window.area() as f64
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

    #[test]
    fn even_noise_and_none_get_one_path() {
        assert_eq!(multiplicities(&film([16, 16], 1.0, |_, _| 0.5)), [1; 4]);
        assert_eq!(multiplicities(&film([16, 16], 1.0, |_, _| 0.0)), [1; 4]);
        assert_eq!(multiplicities(&film([16, 16], 0.0, |_, _| 0.0)), [1; 4]);
    }

    #[test]
    fn paths_are_in_proportion_to_noise() {
        // 3 : 1 : 1 : 1, whose mean is 1.5; pictures need not be whole blocks.
        let of = |x, y| if x >= 8 && y < 8 { 0.003 } else { 0.001 };
        assert_eq!(multiplicities(&film([13, 11], 7.0, of)), [1, 2, 1, 1]);
        assert_eq!(mean(&[1, 2, 1, 1], &Window::all(13, 11)), f64::from(13 * 11 + 5 * 8) / f64::from(13 * 11));
        let crop = Window::crop([13, 11], [7, 6, 9, 9]).unwrap();
        assert_eq!(mean(&[1, 2, 3, 4], &crop), 13.0 / 6.0);
        // One of 36: as many as may be.
        let one = multiplicities(&film([48, 48], 1.0, |x, y| if x < 8 && y >= 40 { 0.1 } else { 0.001 }));
        assert_eq!(one.iter().sum::<u32>(), 35 + MOST);
        assert_eq!(one[30], MOST);
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
        assert_eq!(multiplicities(&film), [1, 2]);
    }
}
