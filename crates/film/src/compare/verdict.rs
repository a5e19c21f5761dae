//! Do two pictures differ by more than their own errors explain?
//!
//! Welch's t test on the pooled mean, which finds a faint bias of the whole, and on each tile, which finds a strong one in one
//! place (Jung, Hanika, Dachsbacher, "Detecting bias in Monte Carlo renderers using Welch's t-test", JCGT 9(2) (2020)); each
//! channel on its own, since the covariance of channels is not stored. Šidák's correction keeps the probability of any false alarm at α: half of it
//! goes to the pooled tests and half to the tiles.
//!
//! Where light comes by rare, bright samples, variances are not to be believed. Pictures that know
//! their tails bound what such pixels can say (`evidence.rs`): the p-value is that of Welch's test
//! where no sample matters much, and far larger where a few samples are all the light that came.

use surelight_estimate::{Estimate, WelchTest, sidak_level};

use super::evidence::Evidence;
use super::{CompareOptions, Picture};

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

/// What the tests say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// No test found a difference, though some could have.
    Same,
    /// A test found a difference.
    Differ,
    /// No test found a difference, and none would have found, nine times in ten, that one of the
    /// pictures is black: there is too much noise, or a few samples are all the light that came.
    CannotTell,
}

/// Outcome of the tests.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// What they say together.
    pub outcome: Outcome,
    /// Probability of [`Outcome::Differ`] for equal pictures.
    pub alpha: f64,
    /// Tests of the mean over all pixels, in radiance: red, green, blue. Where tails are known, `p`
    /// allows for samples that have not come yet.
    pub pooled: [WelchTest; 3],
    /// Level of each pooled test.
    pub pooled_level: f64,
    /// Whether a pooled test found a difference.
    pub pooled_differs: bool,
    /// Smallest bias of the whole picture, relative to the reference, that the pooled tests would
    /// find nine times in ten, in the least sharp channel that is lit; 0 where none is.
    pub detectable: f64,
    /// Tiles tested.
    pub tiles: usize,
    /// Level of each test of a tile and channel.
    pub tile_level: f64,
    /// The same for a single tile: the median over lit tiles.
    pub detectable_in_tile: f64,
    /// Tiles that differ, smallest p first.
    pub different: Vec<Tile>,
    /// Of the mean over all pixels.
    evidence: [Evidence; 3],
}

impl Verdict {
    /// Whether any test found a difference.
    pub fn differs(&self) -> bool {
        self.outcome == Outcome::Differ
    }

    /// How many times the samples that both pictures have would make a bias of the whole picture
    /// of `bias`, relative to the reference, detectable. `None` where no number of samples would,
    /// as where the reference is black.
    pub fn times_samples(&self, bias: f64) -> Option<f64> {
        let enough = |times: f64| self.detectable_with(times) <= bias;
        if self.evidence.iter().all(|evidence| evidence.detectable(self.pooled_level).is_none()) {
            return None;
        }
        let mut range = [1.0 / MAX_TIMES, MAX_TIMES];
        if enough(range[0]) {
            return Some(range[0]);
        }
        if !enough(range[1]) {
            return None;
        }
        // Geometric, as wide a range is.
        for _ in 0..60 {
            let middle = (range[0] * range[1]).sqrt();
            range[usize::from(enough(middle))] = middle;
        }
        Some(range[1])
    }

    /// `detectable` of the same pictures with `times` as many samples.
    fn detectable_with(&self, times: f64) -> f64 {
        let channels = self.evidence.iter().map(|evidence| evidence.with_samples(times));
        channels.filter_map(|evidence| evidence.detectable(self.pooled_level)).fold(0.0, f64::max)
    }
}

/// Beyond so many times the samples nothing is planned.
const MAX_TIMES: f64 = 1e12;

/// Whether there is a test that can tell.
#[derive(Default)]
struct Judged {
    lit: bool,
    able: bool,
}

impl Judged {
    fn add(&mut self, channels: &[Evidence; 3], level: f64) {
        self.lit |= channels.iter().any(Evidence::is_lit);
        self.able |= channels.iter().any(|evidence| evidence.is_lit() && evidence.can_tell(level));
    }

    /// Two black pictures are the same without any test.
    fn is_any(&self) -> bool {
        self.able || !self.lit
    }
}

/// Sum of one channel over squares of pixels, or over pixels, that are independent of one another.
#[derive(Default)]
struct Pool {
    mean: [f64; 2],
    variance: [f64; 2],
    /// Σ v² of each picture: with equal degrees of freedom ν the sum has ν (Σv)²/Σv² of them.
    square: [f64; 2],
    /// Largest change of the sum that one sample of either picture may make.
    jump: f64,
    pixels: usize,
}

impl Pool {
    fn add(&mut self, mean: [f64; 2], variance: [f64; 2], jump: f64, pixels: usize) {
        for side in 0..2 {
            self.mean[side] += mean[side];
            self.variance[side] += variance[side];
            self.square[side] += variance[side] * variance[side];
        }
        self.jump = self.jump.max(jump);
        self.pixels += pixels;
    }

    /// What the pool says where one sample may change its sum by `jump`.
    fn evidence(&self, dof: [f64; 2], jump: f64) -> Evidence {
        let n = self.pixels as f64;
        let means = std::array::from_fn(|side| {
            let (variance, square) = (self.variance[side], self.square[side]);
            let dof = if square > 0.0 { dof[side] * variance / square * variance } else { f64::INFINITY };
            Estimate { mean: self.mean[side] / n, variance: variance / (n * n), dof }
        });
        Evidence { means, jump: jump / n }
    }
}

/// The largest jumps of a tile and of those beside it, in each channel: a picture that has met no
/// bright sample in the tile itself may yet have met one next to it.
fn jumps_about(pools: &[[Pool; 3]], [columns, rows]: [usize; 2], tile: usize) -> [f64; 3] {
    let (x, y) = (tile % columns, tile / columns);
    let mut jumps = [0.0; 3];
    for v in y.saturating_sub(1)..(y + 2).min(rows) {
        for u in x.saturating_sub(1)..(x + 2).min(columns) {
            for (jump, pool) in jumps.iter_mut().zip(&pools[v * columns + u]) {
                *jump = f64::max(*jump, pool.jump);
            }
        }
    }
    jumps
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

/// `None` where a picture has no variance.
pub(super) fn judge(a: &Picture, b: &Picture, usable: &[bool], options: &CompareOptions) -> Option<Verdict> {
    let variances = [a.variance?, b.variance?];
    let pictures = [a, b];
    let side = options.tile.max(1);
    let grid = [a.width.div_ceil(side), a.height.div_ceil(side)];
    let mut pools: Vec<[Pool; 3]> = Vec::new();
    pools.resize_with(grid[0] * grid[1], Default::default);
    let mut whole: [Pool; 3] = Default::default();
    for group in groups(a, b, usable) {
        let tile = group[0] / a.width / side * grid[0] + group[0] % a.width / side;
        for channel in 0..3 {
            let mean = pictures.map(|picture| group.iter().map(|&i| f64::from(picture.rgb[channel][i])).sum());
            let variance = std::array::from_fn(|side| {
                variance_of_sum(variances[side][channel], &group, pictures[side].squares.is_some())
            });
            let jump = pictures.map(|picture| picture.jump_of_sum(channel, &group));
            let jump = jump[0].max(jump[1]);
            whole[channel].add(mean, variance, jump, group.len());
            pools[tile][channel].add(mean, variance, jump, group.len());
        }
    }
    let tiles = pools.iter().filter(|pool| pool[0].pixels > 0).count();
    if tiles == 0 {
        return None;
    }
    let half = sidak_level(options.alpha, 2);
    let (pooled_level, tile_level) = (sidak_level(half, 3), sidak_level(half, 3 * tiles));
    let dof = [a.dof, b.dof];

    let evidence = whole.each_ref().map(|pool| pool.evidence(dof, pool.jump));
    let pooled = evidence.map(|evidence| evidence.test());
    let pooled_differs = pooled.iter().any(|test| test.p < pooled_level);
    let mut judged = Judged::default();
    judged.add(&evidence, pooled_level);

    let mut different = Vec::new();
    let mut in_tiles = Vec::new();
    for (index, pool) in pools.iter().enumerate().filter(|(_, pool)| pool[0].pixels > 0) {
        let jumps = jumps_about(&pools, grid, index);
        let evidence: [Evidence; 3] = std::array::from_fn(|c| pool[c].evidence(dof, jumps[c]));
        judged.add(&evidence, tile_level);
        in_tiles.extend(evidence.iter().filter_map(|evidence| evidence.detectable(tile_level)));
        let tests = evidence.map(|evidence| evidence.test());
        let channel = (0..3).min_by(|&i, &j| tests[i].p.total_cmp(&tests[j].p)).unwrap_or(0);
        let found = &tests[channel];
        if found.p < tile_level {
            let relative = found.difference / evidence[channel].means[1].mean.abs();
            let [x, y] = [index % grid[0] * side, index / grid[0] * side];
            different.push(Tile { x, y, channel, relative, p: found.p });
        }
    }
    different.sort_by(|a, b| a.p.total_cmp(&b.p).then(b.relative.abs().total_cmp(&a.relative.abs())));
    in_tiles.sort_by(f64::total_cmp);
    let outcome = if pooled_differs || !different.is_empty() {
        Outcome::Differ
    } else if judged.is_any() {
        Outcome::Same
    } else {
        Outcome::CannotTell
    };
    let mut verdict = Verdict {
        outcome,
        alpha: options.alpha,
        pooled,
        pooled_level,
        pooled_differs,
        detectable: 0.0,
        tiles,
        tile_level,
        detectable_in_tile: in_tiles.get(in_tiles.len() / 2).copied().unwrap_or(0.0),
        different,
        evidence,
    };
    verdict.detectable = verdict.detectable_with(1.0);
    Some(verdict)
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
        let alarms = (0..500).filter(|&seed| pair(seed).differs()).count();
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
        Planes { width: 24, rgb: spread(&small.rgb), variance, tail: None, squares: told.then_some([0, 0]) }
    }

    #[test]
    fn pixels_that_share_paths_raise_no_false_alarms() {
        let alarms = |told: bool| {
            (0..500).filter(|&s| verdict(&in_squares(2 * s, told), &in_squares(2 * s + 1, told)).differs()).count()
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
        assert!(verdict.differs() && !verdict.pooled_differs);
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
        assert!(!verdict(&one, &flat(1.0)).differs());
        assert!(!verdict(&one, &flat(1.0 + 3.0 * f32::EPSILON)).differs());
        let far = verdict(&one, &flat(1.0 + 6.0 * f32::EPSILON));
        assert!(far.pooled_differs && far.different.len() == 4);
        assert_eq!(verdict(&one, &one).detectable, 0.0);
    }
}
