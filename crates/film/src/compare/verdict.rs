//! Do two pictures differ by more than their own errors explain?
//!
//! Welch's t test on the pooled mean, which finds a faint bias of the whole, and on each tile,
//! which finds a strong one in one place (Jung, Hanika, Dachsbacher, "Detecting bias in Monte Carlo
//! renderers using Welch's t-test", JCGT 9(2) (2020)); each channel on its own, since the
//! covariance of channels is not stored. Šidák's correction keeps the probability of any false
//! alarm at α: half of it goes to the pooled tests and half to the tiles.
//!
//! Where light arrives in rare, bright samples, variances are unreliable. Pictures with known tails
//! bound the evidence of such pixels (`evidence.rs`): the p-value is that of Welch's test where no
//! sample dominates, and far larger where a few samples are all the light.

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

/// Outcome of the tests.
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
    /// Their joint outcome.
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
}

impl Verdict {
    /// Whether any test found a difference.
    pub fn differs(&self) -> bool {
        self.outcome == Outcome::Differ
    }

    /// How many times the samples that both pictures have would make a bias of the whole picture of
    /// `bias`, relative to the reference, detectable; `None` where there is no noise or no light.
    ///
    /// By the square of the precision, for jumps, too: of more samples the largest is larger, in
    /// the heaviest tails that have a variance by the square root.
    pub fn times_samples(&self, bias: f64) -> Option<f64> {
        (self.detectable > 0.0).then(|| (self.detectable / bias).powi(2))
    }
}

/// Whether any test has enough power.
#[derive(Default)]
struct Testability {
    lit: bool,
    able: bool,
}

impl Testability {
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

    /// By how much a future sample may change a sum: as the largest so far, or up to twice that
    /// where that one makes a quarter of the variance, so that larger ones are likely.
    ///
    /// Of Pareto samples with index 1.5 the largest so far alone raises false alarms one time in
    /// fifty; where all samples are small, this changes nothing.
    fn next_jump(&self) -> f64 {
        let variance = self.variance[0] + self.variance[1];
        let square = self.jump * self.jump;
        if square > 0.0 { self.jump * (1.0 + (4.0 * square / variance).min(1.0)) } else { 0.0 }
    }

    /// The evidence of the pool where one sample may change its sum by `jump`.
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

/// The usable pixels in groups that are independent of one another: each by itself, or 2×2 squares
/// where either picture shares paths.
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

/// Variance of a group's sum: at most the square of its pixels' summed standard errors, however
/// their errors depend on one another.
fn variance_of_sum(plane: &[f32], group: &[usize], dependent: bool) -> f64 {
    let variances = group.iter().map(|&i| f64::from(plane[i]));
    if dependent { variances.map(f64::sqrt).sum::<f64>().powi(2) } else { variances.sum() }
}

/// `None` where a picture has no variance.
pub(super) fn judge(a: &Picture, b: &Picture, usable: &[bool], options: &CompareOptions) -> Option<Verdict> {
    let variances = [a.variance?, b.variance?];
    let pictures = [a, b];
    let side = options.tile.max(1);
    let columns = a.width.div_ceil(side);
    let mut pools: Vec<[Pool; 3]> = Vec::new();
    pools.resize_with(columns * a.height.div_ceil(side), Default::default);
    let mut whole: [Pool; 3] = Default::default();
    for group in groups(a, b, usable) {
        let tile = group[0] / a.width / side * columns + group[0] % a.width / side;
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

    // Those of the whole picture for each tile, too: where there is less than one bright sample per
    // tile, most tiles have none, nor have their neighbours.
    let jumps = whole.each_ref().map(Pool::next_jump);
    let evidence: [Evidence; 3] = std::array::from_fn(|c| whole[c].evidence(dof, jumps[c]));
    let pooled = evidence.map(|evidence| evidence.test());
    let pooled_differs = pooled.iter().any(|test| test.p < pooled_level);
    let in_channels = evidence.iter().filter_map(|evidence| evidence.detectable(pooled_level));
    let detectable = in_channels.fold(0.0, f64::max);
    let mut judged = Testability::default();
    judged.add(&evidence, pooled_level);

    let mut different = Vec::new();
    let mut in_tiles = Vec::new();
    for (index, pool) in pools.iter().enumerate().filter(|(_, pool)| pool[0].pixels > 0) {
        let evidence: [Evidence; 3] = std::array::from_fn(|c| pool[c].evidence(dof, jumps[c]));
        judged.add(&evidence, tile_level);
        in_tiles.extend(evidence.iter().filter_map(|evidence| evidence.detectable(tile_level)));
        let tests = evidence.map(|evidence| evidence.test());
        let channel = (0..3).min_by(|&i, &j| tests[i].p.total_cmp(&tests[j].p)).unwrap_or(0);
        let found = &tests[channel];
        if found.p < tile_level {
            let relative = found.difference / evidence[channel].means[1].mean.abs();
            let [x, y] = [index % columns * side, index / columns * side];
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
    Some(Verdict {
        outcome,
        alpha: options.alpha,
        pooled,
        pooled_level,
        pooled_differs,
        detectable,
        tiles,
        tile_level,
        detectable_in_tile: in_tiles.get(in_tiles.len() / 2).copied().unwrap_or(0.0),
        different,
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Events, Planes, rare, render};
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
        // 500 pairs at α = 0.01: 5 expected, 4 standard errors are 8.9. Without any correction for
        // 15 tests at once about 10 % would alarm, as the second count shows at a level that is
        // measurable.
        let pair = |seed: u64| verdict(&render(24, 2 * seed, 0.2, scene), &render(24, 2 * seed + 1, 0.2, scene));
        let alarms = (0..500).filter(|&seed| pair(seed).differs()).count();
        assert!(alarms <= 13, "{alarms}");
        let uncorrected = (0..200).filter(|&seed| pair(seed).pooled.iter().any(|test| test.p < 0.05)).count();
        // Three tests at 5 %: 14.3 % of 200, or 28.5; 4 standard errors are 20.
        assert!((9..=48).contains(&uncorrected), "{uncorrected}");
    }

    /// Noise that is the same within 2×2 squares, with or without a record of the squares.
    fn in_squares(seed: u64, with_squares: bool) -> Planes {
        let small = render(12, seed, 0.2, |_, _| 1.0);
        let spread = |planes: &[Vec<f32>; 3]| -> [Vec<f32>; 3] {
            std::array::from_fn(|c| (0..24 * 24).map(|i| planes[c][i / 24 / 2 * 12 + i % 24 / 2]).collect())
        };
        let variance = small.variance.as_ref().map(spread);
        Planes { width: 24, rgb: spread(&small.rgb), variance, tail: None, squares: with_squares.then_some([0, 0]) }
    }

    #[test]
    fn path_reuse_raises_no_false_alarms() {
        let alarms = |with_squares: bool| {
            (0..500)
                .filter(|&s| verdict(&in_squares(2 * s, with_squares), &in_squares(2 * s + 1, with_squares)).differs())
                .count()
        };
        let (with_squares, untold) = (alarms(true), alarms(false));
        assert!(with_squares <= 13, "{with_squares}");
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
        // Three channels, each found nine times in ten: more than 90 % of 200 less 4 standard
        // errors; and far fewer at a third of it.
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
        // 16 of 256 pixels are 40 % darker: nine standard errors of the tile, and one of the
        // picture.
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

    /// False alarms of 200 pairs of an even render and one by rare events, with tails and without.
    fn alarms(size: usize, a_tile: f64, events: Events) -> [usize; 2] {
        let mut found = [0; 2];
        for seed in 0..200 {
            let a = rare(size, 2 * seed, 0.0, 0.0, events);
            let mut b = rare(size, 2 * seed + 1, 0.5, a_tile, events);
            found[0] += usize::from(verdict(&a, &b).differs());
            b.tail = None;
            found[1] += usize::from(verdict(&a, &b).differs());
        }
        found
    }

    /// 200 pairs at α = 0.01 for each kind: 2 expected, and more than 8 one time in 4,000.
    #[test]
    fn rare_bright_samples_raise_no_false_alarms() {
        for (a_tile, events) in [
            (3.0, Events::Equal),
            (10.0, Events::Equal),
            (100.0, Events::Equal),
            (3.0, Events::Pareto(1.5)),
            (100.0, Events::Pareto(1.5)),
            (10.0, Events::Pareto(2.0)),
        ] {
            let [with, without] = alarms(32, a_tile, events);
            println!("{a_tile} events a tile: {with} alarms, {without} without tails");
            assert!(with <= 8, "{a_tile}: {with} of 200");
            let fails = a_tile < 100.0 || matches!(events, Events::Pareto(_));
            assert!(!fails || without > 2, "{a_tile}: the test cannot fail: {without} without tails");
        }
    }

    /// Where most tiles and their neighbours have no event, others have.
    #[test]
    fn events_elsewhere_count_for_tiles_without_any() {
        let found = |seed: u64| {
            let a = rare(96, 2 * seed, 0.0, 0.0, Events::Equal);
            let mut b = rare(96, 2 * seed + 1, 0.5, 0.3, Events::Equal);
            let with = verdict(&a, &b).differs();
            b.tail = None;
            (with, verdict(&a, &b).differs())
        };
        let found: Vec<_> = (0..20).map(found).collect();
        assert_eq!(found.iter().filter(|found| found.0).count(), 0);
        assert_eq!(found.iter().filter(|found| found.1).count(), 20, "the test cannot fail");
    }

    /// Power where tails are known and light: their cost, and the differences found.
    #[test]
    fn even_pictures_are_judged_as_sharply_as_without_tails() {
        let render = |seed| rare(48, seed, 0.0, 0.0, Events::Equal);
        let sharp = verdict(&render(1), &render(2));
        let [mut a, mut b] = [render(1), render(2)];
        (a.tail, b.tail) = (None, None);
        let welch = verdict(&a, &b);
        for (sharp, welch) in
            [(sharp.detectable, welch.detectable), (sharp.detectable_in_tile, welch.detectable_in_tile)]
        {
            assert!(sharp < 1.05 * welch, "{sharp} instead of {welch}");
        }
    }

    /// A black picture differs from one that is lit by few events, at 16 per tile and more.
    #[test]
    fn black_differs_from_what_rare_samples_light() {
        let mut black = Planes::new(48, 48, |_, _| [0.0; 3]);
        black.variance = Some([(); 3].map(|()| vec![0.0; 48 * 48]));
        black.tail = Some(vec![0.0; 48 * 48]);
        for seed in 0..20 {
            let lit = rare(48, seed, 1.0, 16.0, Events::Equal);
            assert_eq!(verdict(&black, &lit).outcome, Outcome::Differ, "{seed}");
            assert_eq!(verdict(&lit, &black).outcome, Outcome::Differ, "{seed}");
        }
        assert_eq!(verdict(&black, &black).outcome, Outcome::Same);
    }

    /// A handful of events is no light to judge by.
    #[test]
    fn a_few_samples_tell_nothing() {
        for seed in 0..20 {
            let [a, b] = [2 * seed, 2 * seed + 1].map(|seed| rare(32, seed, 1.0, 1.0, Events::Equal));
            assert_eq!(verdict(&a, &b).outcome, Outcome::CannotTell, "{seed}");
        }
    }

    #[test]
    fn plans_hold() {
        let render = |seed, samples: f64| render(32, seed, 0.2 / samples.sqrt(), scene);
        let now = verdict(&render(1, 1.0), &render(2, 1.0));
        let times = now.times_samples(0.25 * now.detectable).unwrap();
        assert!((times / 16.0 - 1.0).abs() < 0.01, "{times}");
        let then = verdict(&render(3, times), &render(4, times));
        assert!((then.detectable / now.detectable - 0.25).abs() < 0.02);
        assert_eq!(
            verdict(
                &render(1, 1.0),
                &Planes { variance: render(2, 1.0).variance, ..Planes::new(32, 32, |_, _| [0.0; 3]) }
            )
            .times_samples(0.1),
            None
        );
    }
}
