//! Do two pictures differ by more than their own errors explain?
//!
//! Welch's t test on the pooled mean, which finds a faint bias of the whole, and on each tile, which finds a strong one in one
//! place (Jung, Hanika, Dachsbacher, "Detecting bias in Monte Carlo renderers using Welch's t-test", JCGT 9(2) (2020)); each
//! channel on its own, since the covariance of channels is not stored. Šidák's correction keeps the probability of any false alarm at α: half of it
//! goes to the pooled tests and half to the tiles.
//!
//! The verdict is as good as the variances. Pixels whose rare bright samples have not come yet believe in too small a variance, and tiles of
//! caustics may differ between two true renders.

use surelight_estimate::{
    Estimate, WelchTest, detectable_bias, satterthwaite, sidak_level, student_t_quantile, welch_test,
};

use super::{CompareOptions, Picture, beyond_rounding};

/// A tile that differs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tile {
    /// First column.
    pub x: usize,
    /// First row.
    pub y: usize,
    /// 0 red, 1 green, 2 blue: the channel with the smallest p.
    pub channel: usize,
    /// Difference of the means relative to the reference; infinite where that is black.
    pub relative: f64,
    /// p-value of that channel, for itself alone.
    pub p: f64,
}

/// Outcome of the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Whether any test found a difference.
    pub differ: bool,
    /// Probability of that for equal pictures.
    pub alpha: f64,
    /// Tests of the mean over all pixels, in radiance: red, green, blue.
    pub pooled: [WelchTest; 3],
    /// Level of each pooled test.
    pub pooled_level: f64,
    /// Whether a pooled test found a difference.
    pub pooled_differs: bool,
    /// Smallest bias of the whole picture, relative to the reference, that the pooled tests would find nine times in ten; of the least
    /// sharp channel that is lit.
    pub detectable: f64,
    /// Tiles tested.
    pub tiles: usize,
    /// Level of each test of a tile and channel.
    pub tile_level: f64,
    /// The same for a single tile: the median over lit tiles.
    pub detectable_in_tile: f64,
    /// Tiles that differ, smallest p first.
    pub different: Vec<Tile>,
}

/// Sum of one channel over squares of pixels, or over pixels, that are independent of one another.
#[derive(Default)]
struct Pool {
    mean: [f64; 2],
    variance: [f64; 2],
    /// Σ v² of each picture: with equal degrees of freedom ν the sum has ν (Σv)²/Σv² of them.
    square: [f64; 2],
    pixels: usize,
}

impl Pool {
    fn add(&mut self, mean: [f64; 2], variance: [f64; 2], pixels: usize) {
        for side in 0..2 {
            self.mean[side] += mean[side];
            self.variance[side] += variance[side];
            self.square[side] += variance[side] * variance[side];
        }
        self.pixels += pixels;
    }

    fn estimates(&self, dof: [f64; 2]) -> [Estimate; 2] {
        std::array::from_fn(|side| {
            let n = self.pixels as f64;
            let (variance, square) = (self.variance[side], self.square[side]);
            let dof = if square > 0.0 { dof[side] * variance / square * variance } else { f64::INFINITY };
            Estimate { mean: self.mean[side] / n, variance: variance / (n * n), dof }
        })
    }
}

/// The usable pixels in groups that are independent of one another: each by itself, or 2×2 squares where either picture shares paths.
fn groups(a: &Picture, b: &Picture, usable: &[bool]) -> Vec<Vec<usize>> {
    let pixels = (0..usable.len()).filter(|&i| usable[i]);
    let Some([left, top]) = a.squares.or(b.squares) else {
        return pixels.map(|i| vec![i]).collect();
    };
    let across = (a.width + left).div_ceil(2);
    let mut squares = vec![Vec::new(); across * (a.height + top).div_ceil(2)];
    pixels.for_each(|i| squares[(i / a.width + top) / 2 * across + (i % a.width + left) / 2].push(i));
    squares.retain(|pixels| !pixels.is_empty());
    squares
}

/// Variance of a group's sum: at most the square of its pixels' summed standard errors, however their errors depend on one another.
fn variance_of_sum(plane: &[f32], group: &[usize], dependent: bool) -> f64 {
    let variances = group.iter().map(|&i| f64::from(plane[i]));
    if dependent { variances.map(f64::sqrt).sum::<f64>().powi(2) } else { variances.sum() }
}

/// Welch's test of what is left of the difference after rounding.
fn test([a, b]: [Estimate; 2]) -> WelchTest {
    let shifted = Estimate { mean: beyond_rounding(a.mean, b.mean), ..a };
    let test = welch_test(&shifted, &Estimate { mean: 0.0, ..b });
    WelchTest { difference: a.mean - b.mean, ..test }
}

/// The smallest bias relative to the reference that a test at `level` finds nine times in ten; `None` where the reference is black.
fn detectable([a, b]: &[Estimate; 2], level: f64) -> Option<f64> {
    if b.mean <= 0.0 {
        return None;
    }
    let error = (a.variance + b.variance).sqrt();
    let dof = satterthwaite(&[(a.variance, a.dof), (b.variance, b.dof)]);
    // As for a normal error, but with the wider quantile of t at the level of the test.
    let normal = detectable_bias(error, level, 0.9);
    let wider = student_t_quantile(1.0 - 0.5 * level, dof) - student_t_quantile(1.0 - 0.5 * level, f64::INFINITY);
    let wider = if error > 0.0 { wider * error } else { 0.0 };
    Some((normal + wider) / b.mean)
}

/// `None` where a picture has no variance.
pub(super) fn judge(a: &Picture, b: &Picture, usable: &[bool], options: &CompareOptions) -> Option<Verdict> {
    let (va, vb) = (a.variance?, b.variance?);
    let dof = [a.dof, b.dof];
    let side = options.tile.max(1);
    let columns = a.width.div_ceil(side);
    let mut pools: Vec<[Pool; 3]> = Vec::new();
    pools.resize_with(columns * a.height.div_ceil(side), Default::default);
    let mut whole: [Pool; 3] = Default::default();
    for group in groups(a, b, usable) {
        let tile = group[0] / a.width / side * columns + group[0] % a.width / side;
        for channel in 0..3 {
            let mean = [a, b].map(|picture| group.iter().map(|&i| f64::from(picture.rgb[channel][i])).sum());
            let variance =
                [(va, a), (vb, b)].map(|(v, picture)| variance_of_sum(v[channel], &group, picture.squares.is_some()));
            whole[channel].add(mean, variance, group.len());
            pools[tile][channel].add(mean, variance, group.len());
        }
    }
    let tiles = pools.iter().filter(|pool| pool[0].pixels > 0).count();
    if tiles == 0 {
        return None;
    }
    let half = sidak_level(options.alpha, 2);
    let (pooled_level, tile_level) = (sidak_level(half, 3), sidak_level(half, 3 * tiles));

    let estimates = whole.each_ref().map(|pool| pool.estimates(dof));
    let pooled = estimates.map(test);
    let pooled_differs = pooled.iter().any(|test| test.p < pooled_level);
    let sharpest = estimates.iter().filter_map(|pair| detectable(pair, pooled_level)).fold(0.0, f64::max);

    let mut different = Vec::new();
    let mut in_tiles = Vec::new();
    for (index, pool) in pools.iter().enumerate().filter(|(_, pool)| pool[0].pixels > 0) {
        let estimates = pool.each_ref().map(|pool| pool.estimates(dof));
        in_tiles.extend(estimates.iter().filter_map(|pair| detectable(pair, tile_level)));
        let tests = estimates.map(test);
        let channel = (0..3).min_by(|&i, &j| tests[i].p.total_cmp(&tests[j].p)).unwrap_or(0);
        let found = &tests[channel];
        if found.p < tile_level {
            let relative = found.difference / estimates[channel][1].mean.abs();
            different.push(Tile {
                x: index % columns * side,
                y: index / columns * side,
                channel,
                relative,
                p: found.p,
            });
        }
    }
    different.sort_by(|a, b| a.p.total_cmp(&b.p).then(b.relative.abs().total_cmp(&a.relative.abs())));
    in_tiles.sort_by(f64::total_cmp);
    Some(Verdict {
        differ: pooled_differs || !different.is_empty(),
        alpha: options.alpha,
        pooled,
        pooled_level,
        pooled_differs,
        detectable: sharpest,
        tiles,
        tile_level,
        detectable_in_tile: in_tiles.get(in_tiles.len() / 2).copied().unwrap_or(0.0),
        different,
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Planes, render};
    use super::*;

    fn verdict(a: &Planes, b: &Planes) -> Verdict {
        let usable = vec![true; a.rgb[0].len()];
        judge(&a.picture(), &b.picture(), &usable, &CompareOptions::default()).unwrap()
    }

    /// A picture of some contrast.
    fn scene(x: usize, y: usize) -> f64 {
        0.05 + (x * y) as f64 / 500.0
    }

    #[test]
    fn false_alarms_are_as_rare_as_promised() {
        // 500 pairs at α = 0.01: 5 expected, 4 standard errors are 8.9. Without any correction for 15 tests at once about
        // 10 % would alarm, as the second count shows at a level that can be counted.
        let pair = |seed: u64| verdict(&render(24, 2 * seed, 0.2, scene), &render(24, 2 * seed + 1, 0.2, scene));
        let alarms = (0..500).filter(|&seed| pair(seed).differ).count();
        assert!(alarms <= 13, "{alarms}");
        let uncorrected = (0..200).filter(|&seed| pair(seed).pooled.iter().any(|test| test.p < 0.05)).count();
        // Three tests at 5 %: 14.3 % of 200, or 28.5; 4 standard errors are 20.
        assert!((9..=48).contains(&uncorrected), "{uncorrected}");
    }

    /// Noise that is the same within 2×2 squares, told or not.
    fn in_squares(seed: u64, told: bool) -> Planes {
        let small = render(12, seed, 0.2, |_, _| 1.0);
        let spread = |planes: &[Vec<f32>; 3]| -> [Vec<f32>; 3] {
            std::array::from_fn(|c| (0..24 * 24).map(|i| planes[c][i / 24 / 2 * 12 + i % 24 / 2]).collect())
        };
        let variance = small.variance.as_ref().map(spread);
        Planes { width: 24, rgb: spread(&small.rgb), variance, squares: told.then_some([0, 0]) }
    }

    #[test]
    fn pixels_that_share_paths_raise_no_false_alarms() {
        let alarms = |told: bool| {
            (0..500).filter(|&s| verdict(&in_squares(2 * s, told), &in_squares(2 * s + 1, told)).differ).count()
        };
        let (told, untold) = (alarms(true), alarms(false));
        assert!(told <= 13, "{told}");
        assert!(untold > 50, "the test cannot fail: {untold}");
    }

    #[test]
    fn the_detectable_bias_is_detected_nine_times_in_ten() {
        let truth = verdict(&render(32, 1, 0.2, scene), &render(32, 2, 0.2, scene));
        let bias = truth.detectable;
        assert!(bias > 0.01 && bias < 0.1, "{bias}");
        let found = (0..200)
            .filter(|&seed| {
                let a = render(32, 1000 + seed, 0.2, |x, y| scene(x, y) * (1.0 + bias));
                verdict(&a, &render(32, 5000 + seed, 0.2, scene)).pooled_differs
            })
            .count();
        // Three channels, each found nine times in ten: more than 90 % of 200 less 4 standard errors; and far fewer at a third of it.
        assert!(found > 163, "{found}");
        let fainter = (0..200)
            .filter(|&seed| {
                let a = render(32, 1000 + seed, 0.2, |x, y| scene(x, y) * (1.0 + bias / 3.0));
                verdict(&a, &render(32, 5000 + seed, 0.2, scene)).pooled_differs
            })
            .count();
        assert!(fainter < 60, "{fainter}");
    }

    #[test]
    fn a_change_in_one_place_is_found_there() {
        let (x0, y0) = (16, 0);
        let a = render(128, 9, 0.03, |x, y| if (20..24).contains(&x) && (4..8).contains(&y) { 0.6 } else { 1.0 });
        let b = render(128, 10, 0.03, |_, _| 1.0);
        let verdict = verdict(&a, &b);
        assert!(verdict.differ && !verdict.pooled_differs);
        assert_eq!(verdict.tiles, 64);
        let tile = verdict.different[0];
        assert_eq!((tile.x, tile.y, verdict.different.len()), (x0, y0, 1));
        // 16 of 256 pixels are 40 % darker: nine standard errors of the tile, and one of the picture.
        assert!((tile.relative + 0.025).abs() < 0.02 && tile.p < verdict.tile_level);
        assert!(verdict.detectable_in_tile < 0.1);
    }

    #[test]
    fn pictures_without_noise_may_differ_by_rounding_only() {
        let flat = |value: f32| {
            let mut planes = Planes::new(20, 20, |_, _| [value, 0.0, value]);
            planes.variance = Some([(); 3].map(|()| vec![0.0; 400]));
            planes
        };
        let one = flat(1.0);
        assert!(!verdict(&one, &flat(1.0)).differ);
        assert!(!verdict(&one, &flat(1.0 + 3.0 * f32::EPSILON)).differ);
        let far = verdict(&one, &flat(1.0 + 6.0 * f32::EPSILON));
        assert!(far.pooled_differs && far.different.len() == 4);
        assert_eq!(verdict(&one, &one).detectable, 0.0);
    }
}
