//! Statistics of the rows: curves over repeats, slopes, times to an error, efficiency, bias.
//!
//! Repeats have independent samples, so intervals come from their spread: of logarithms where the
//! figure is a ratio, by Student's t. Checkpoints of one repeat share their samples, so none is
//! treated as independent of another.

mod interval;

use surelight_estimate::student_t_quantile;

pub use self::interval::Interval;
pub(crate) use self::interval::ratio;
use crate::data::{Row, SceneData};

/// Confidence of every interval in a report.
pub const CONFIDENCE: f64 = 0.95;

/// The stages of a method's time; the kernel is a single one.
pub const STAGES: [&str; 5] = [
    "BVH, lights, textures",
    "compiling, upload",
    "reading back, film",
    "submitting, waiting",
    "tracing on the device",
];

/// A checkpoint over all repeats that reached it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Samples per pixel.
    pub spp: u32,
    /// Mean seconds.
    pub seconds: f64,
    /// √ of the mean relative mean square error.
    pub error: f64,
    /// Minimum and maximum relative error of a repeat.
    pub band: [f64; 2],
}

impl SceneData {
    /// Relative mean square error below which a checkpoint is not distinguished from the
    /// reference's own noise.
    pub fn floor(&self) -> f64 {
        self.reference.rel_mse.unwrap_or(0.0)
    }

    fn readable(&self, row: &Row) -> bool {
        row.rel_mse > self.floor() && row.rel_mse > 0.0
    }

    /// A method's checkpoints over repeats, except those below the reference's noise.
    pub fn curve(&self, method: usize) -> Vec<Point> {
        let mut points = Vec::new();
        for &spp in &self.methods[method].checkpoints {
            let rows: Vec<&Row> = self.rows_of(method).filter(|r| r.spp == spp).collect();
            let n = rows.len() as f64;
            let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(|r| f(r)).sum::<f64>() / n;
            let square = mean(&|r| r.rel_mse);
            if rows.is_empty() || square <= self.floor() || square <= 0.0 {
                continue;
            }
            let errors = rows.iter().map(|r| r.rel_mse.max(self.floor().max(square * 1e-3)).sqrt());
            let (low, high) = errors.fold((f64::MAX, 0.0f64), |(l, h), e| (l.min(e), h.max(e)));
            points.push(Point {
                spp,
                seconds: mean(&|r| r.seconds(self.clock)),
                error: square.sqrt(),
                band: [low, high],
            });
        }
        points
    }

    /// A repeat's checkpoints as samples, seconds and relative error.
    fn path(&self, method: usize, repeat: u32) -> Vec<[f64; 3]> {
        let rows = self.rows_of(method).filter(|r| r.repeat == repeat && self.readable(r));
        rows.map(|r| [f64::from(r.spp), r.seconds(self.clock), r.rel_mse.sqrt()]).collect()
    }

    /// Exponent of the error as a power of the samples: −0.5 for independent samples. Fitted to
    /// each repeat by least squares of logarithms, from 4 samples per pixel where three checkpoints
    /// remain.
    pub fn slope(&self, method: usize) -> Option<Interval> {
        let slopes: Vec<f64> = (0..self.repeats)
            .filter_map(|repeat| {
                let all = self.path(method, repeat);
                let late: Vec<_> = all.iter().copied().filter(|p| p[0] >= 4.0).collect();
                slope(if late.len() >= 3 { &late } else { &all })
            })
            .collect();
        Interval::of(&slopes)
    }

    /// Seconds that each repeat took to a relative error; `None` where one did not reach it.
    pub fn times_to(&self, method: usize, error: f64) -> Option<Vec<f64>> {
        let repeats = (0..self.repeats).filter(|&repeat| self.rows_of(method).any(|r| r.repeat == repeat));
        let times: Option<Vec<f64>> = repeats.map(|repeat| time_to(&self.path(method, repeat), error)).collect();
        times.filter(|times| !times.is_empty())
    }

    /// The mean over repeats, with its interval.
    pub fn time_to(&self, method: usize, error: f64) -> Option<Interval> {
        Interval::of_ratio(&self.times_to(method, error)?)
    }

    /// 1/(relative mean square error · seconds) of each repeat at its last readable checkpoint:
    /// the efficiency per second.
    pub fn efficiencies(&self, method: usize) -> Vec<f64> {
        let last = |repeat| self.path(method, repeat).last().map(|p| 1.0 / (p[2] * p[2] * p[1].max(1e-9)));
        (0..self.repeats).filter_map(last).collect()
    }

    /// Mean signed relative error at the last checkpoint, over repeats, with the reference's own
    /// uncertainty.
    pub fn bias(&self, method: usize) -> Option<Interval> {
        let last = *self.methods[method].checkpoints.last()?;
        let rows: Vec<&Row> = self.rows_of(method).filter(|r| r.spp == last).collect();
        let n = rows.len() as f64;
        let own: f64 = rows.iter().map(|r| r.mean_se.map(|se| se * se)).sum::<Option<f64>>()? / (n * n);
        let value = rows.iter().map(|r| r.mean_error).sum::<f64>() / n;
        let reference = self.reference.mean_se.unwrap_or(0.0);
        let scale = self.reference.mean.abs();
        if rows.is_empty() || scale == 0.0 {
            return None;
        }
        let half =
            student_t_quantile(0.5 + 0.5 * CONFIDENCE, f64::INFINITY) * (own + reference * reference).sqrt() / scale;
        Some(Interval { value, low: value - half, high: value + half })
    }

    /// Mean over repeats of a figure at the last checkpoint.
    pub fn at_end(&self, method: usize, figure: impl Fn(&Row) -> Option<f64>) -> Option<f64> {
        let last = *self.methods[method].checkpoints.last()?;
        let figures: Option<Vec<f64>> = self.rows_of(method).filter(|r| r.spp == last).map(figure).collect();
        let figures = figures.filter(|f| !f.is_empty())?;
        Some(figures.iter().sum::<f64>() / figures.len() as f64)
    }

    /// Error levels 1, 2, 5 × 10ᵏ that some method reached, from coarse to fine; at most the eight
    /// finest.
    pub fn levels(&self) -> Vec<f64> {
        let all = (-60..=3).rev().map(|k: i32| {
            let digit = [1.0, 2.0, 5.0][k.rem_euclid(3) as usize];
            digit * 10f64.powi(k.div_euclid(3))
        });
        let reached = |&e: &f64| e <= 1.0 && (0..self.methods.len()).any(|m| self.times_to(m, e).is_some());
        let levels: Vec<f64> = all.filter(reached).collect();
        levels[levels.len().saturating_sub(8)..].to_vec()
    }

    /// The Pareto front of the methods without bias: checkpoints that no other precedes in both
    /// time and error, from coarse to fine, with their methods.
    pub fn front(&self) -> Vec<(usize, Point)> {
        let honest = (0..self.methods.len()).filter(|&m| self.methods[m].biased.is_none());
        let mut all: Vec<(usize, Point)> =
            honest.flat_map(|m| self.curve(m).into_iter().map(move |p| (m, p))).collect();
        all.sort_by(|a, b| a.1.seconds.total_cmp(&b.1.seconds).then(a.1.error.total_cmp(&b.1.error)));
        let mut best = f64::INFINITY;
        all.retain(|(_, p)| {
            let before = p.error < best;
            best = best.min(p.error);
            before
        });
        all
    }

    /// Predicted and real relative error, over repeats, at each checkpoint that has enough batches
    /// for an error bar.
    pub fn calibration(&self, method: usize) -> Vec<(f64, f64)> {
        let mut points = Vec::new();
        for &spp in &self.methods[method].checkpoints {
            let rows: Vec<&Row> = self.rows_of(method).filter(|r| r.spp == spp && r.batches >= 16).collect();
            let n = rows.len() as f64;
            let real = rows.iter().map(|r| r.rel_mse).sum::<f64>() / n;
            let predicted: Option<f64> = rows.iter().map(|r| r.predicted_rel_mse).sum();
            if let Some(predicted) = predicted.map(|p| p / n).filter(|&p| p > 0.0 && real > self.floor() && real > 0.0)
            {
                points.push((predicted.sqrt(), real.sqrt()));
            }
        }
        points
    }

    /// Wall-clock seconds of a method, all repeats together, in the order of [`STAGES`].
    pub fn stages(&self, method: usize) -> [f64; STAGES.len()] {
        let data = &self.methods[method];
        let last = data.checkpoints.last();
        let ends = || self.rows_of(method).filter(|r| Some(&r.spp) == last);
        let sum = |of: &dyn Fn(&Row) -> f64| ends().map(of).sum::<f64>();
        let device = sum(&|r| r.device_seconds);
        let waiting = sum(&|r| r.dispatch_seconds.map_or(0.0, |all| (all - r.device_seconds).max(0.0)));
        // Older reports have only the sum of the host's stages.
        let host = sum(&|r| match (r.read_seconds, r.film_seconds) {
            (Some(read), Some(film)) => read + film,
            _ => (r.wall_seconds - r.device_seconds).max(0.0),
        });
        [data.prepare_seconds, data.compile_seconds, host, waiting, device]
    }

    /// The methods by their mean time to an error, fastest first.
    pub fn ranking(&self, error: f64, biased_too: bool) -> Vec<(usize, Interval)> {
        let mut ranking: Vec<_> = (0..self.methods.len())
            .filter(|&m| biased_too || self.methods[m].biased.is_none())
            .filter_map(|m| Some((m, self.time_to(m, error)?)))
            .collect();
        ranking.sort_by(|a, b| a.1.value.total_cmp(&b.1.value));
        ranking
    }
}

/// Least-squares slope of ln error over ln samples.
fn slope(path: &[[f64; 3]]) -> Option<f64> {
    if path.len() < 2 {
        return None;
    }
    let logs: Vec<[f64; 2]> = path.iter().map(|p| [p[0].ln(), p[2].ln()]).collect();
    let n = logs.len() as f64;
    let [mx, my] = [0, 1].map(|i| logs.iter().map(|p| p[i]).sum::<f64>() / n);
    let spread: f64 = logs.iter().map(|p| (p[0] - mx).powi(2)).sum();
    let joint: f64 = logs.iter().map(|p| (p[0] - mx) * (p[1] - my)).sum();
    (spread > 0.0).then(|| joint / spread)
}

/// Seconds from which on a curve stays at an error or below, interpolated between checkpoints in
/// log–log scale. A curve that was there by chance, until it found something bright, has not
/// converged.
fn time_to(path: &[[f64; 3]], error: f64) -> Option<f64> {
    let at = path.iter().rposition(|p| p[2] > error).map_or(0, |last_above| last_above + 1);
    let after = path.get(at)?;
    let Some(before) = at.checked_sub(1).map(|i| path[i]) else {
        return Some(after[1]); // there before the first checkpoint
    };
    let share = (before[2] / error).ln() / (before[2] / after[2]).ln();
    let (t0, t1) = (before[1].max(1e-9), after[1].max(1e-9));
    Some((t0.ln() + share * (t1 / t0).ln()).exp())
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::testing::{normals, synthetic};

    #[test]
    fn times_are_found_between_checkpoints() {
        let path = [[1.0, 1.0, 0.8], [2.0, 2.0, 0.4], [4.0, 4.0, 0.2]];
        assert!((time_to(&path, 0.4).unwrap() - 2.0).abs() < 1e-12);
        assert!((time_to(&path, 0.4 / 2f64.sqrt()).unwrap() - 2.0 * 2f64.sqrt()).abs() < 1e-9);
        assert_eq!(time_to(&path, 1.0), Some(1.0));
        assert_eq!(time_to(&path, 0.1), None);
        assert_eq!(time_to(&[], 0.1), None);
        let lucky = [[1.0, 1.0, 0.8], [2.0, 2.0, 0.2], [4.0, 4.0, 0.6], [8.0, 8.0, 0.3]];
        assert!((time_to(&lucky, 0.3).unwrap() - 8.0).abs() < 1e-9);
        assert!(time_to(&lucky, 0.7).unwrap() < 2.0 && time_to(&lucky, 0.25).is_none());
    }

    #[test]
    fn slopes_of_known_paths() {
        let path: Vec<_> = (0..8).map(|k| [f64::from(1 << k), 1.0, 0.3 * 2f64.powf(-0.75 * f64::from(k))]).collect();
        assert!((slope(&path).unwrap() + 0.75).abs() < 1e-12);
        assert_eq!(slope(&path[..1]), None);
    }

    #[test]
    fn intervals_cover_as_often_as_they_say() {
        // 2,000 intervals at 95 %: a standard error of 0.5 %.
        let held = (0..2000)
            .filter(|&seed| {
                let mut normal = normals(seed);
                Interval::of(&[normal(), normal(), normal(), normal()]).unwrap().holds(0.0)
            })
            .count();
        assert!((1860..=1940).contains(&held), "{held}");
    }

    #[test]
    fn the_faster_method_is_found_with_its_factor() {
        let scene = synthetic(1, &[1.0, 4.0], 0.02, 0.0);
        let levels = scene.levels();
        let finest = levels[levels.len() - 2];
        let ranking = scene.ranking(finest, false);
        assert_eq!(ranking.iter().map(|r| r.0).collect::<Vec<_>>(), [0, 1]);
        let [fast, slow] = [0, 1].map(|m| scene.times_to(m, finest).unwrap());
        let (factor, p) = ratio(&slow, &fast).unwrap();
        assert!(factor.holds(4.0) && factor.low > 3.0 && factor.high < 5.5 && p < 1e-3, "{factor:?}");
        let slope = scene.slope(0).unwrap();
        assert!(slope.holds(-0.5) && slope.high - slope.low < 0.1, "{slope:?}");
    }

    #[test]
    fn checkpoints_below_the_reference_are_left_out() {
        let mut scene = synthetic(1, &[1.0], 0.02, 0.0);
        let all = scene.curve(0).len();
        scene.reference.rel_mse = Some(scene.rows[4].rel_mse * 1.01);
        assert!(scene.curve(0).len() < all);
    }
}
