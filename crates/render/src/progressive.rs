//! The progressive loop: which batches come next, and when to stop.

use std::time::{Duration, Instant};

use surelight_film::Film;

use crate::{
    error::RenderError,
    renderer::{Counts, Renderer},
};

/// When a render is done; whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Samples a pixel.
    pub spp: Option<u32>,
    /// Tracing time.
    pub time: Option<Duration>,
}

/// Batches that an error bar needs: each is an independent scramble of the sequence.
const BATCHES: u32 = 16;

/// Sums on the device are f32: batches stay short.
const MOST_SAMPLES: u32 = 4096;

/// A pass of about this long loses little when it is interrupted; what is left below it is done in one.
const SHORT: f64 = 2.0;

/// Of the time so far, what an interrupted pass may lose.
const LOSS: f64 = 0.125;

/// The largest power of two up to `n`, 1 for 0.
fn power_of_two(n: u32) -> u32 {
    if n == 0 { 1 } else { 1 << n.ilog2() }
}

impl Goal {
    /// Samples of a full batch: 1/16 of a known number, rounded down to a power of two. Without a number they grow with
    /// what is done, so that there are never fewer than 16 that count.
    fn full_batch(&self, done: u32) -> u32 {
        power_of_two(self.spp.unwrap_or(done) / BATCHES).min(MOST_SAMPLES)
    }

    /// Samples in the next batch, when `done` samples a pixel are done; 0 when there is nothing left.
    ///
    /// The first full batch comes in pieces of 1, 1, 2, 4, … samples: there is soon an image to save when the render is
    /// interrupted, however many samples it was to have. What is left over at the end makes a shorter batch.
    fn next_batch(&self, done: u32) -> u32 {
        let left = self.spp.map_or(u32::MAX, |spp| spp.saturating_sub(done));
        self.full_batch(done).min(power_of_two(done)).min(left)
    }
}

/// How a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Samples a pixel in the film.
    pub spp: u32,
    /// Of all samples asked for, those finished; `None` without a number.
    pub share: Option<f64>,
    /// Seconds since the loop began.
    pub seconds: f64,
    /// Seconds left, estimated; `None` before there is anything to judge by.
    pub seconds_left: Option<f64>,
    /// Device counts.
    pub counts: Counts,
}

/// Why the loop ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The goal's samples are in the film, or its time is up with no number of samples asked for.
    Done,
    /// Time was up before the samples asked for.
    TimeUp,
    /// The observer said stop.
    Interrupted,
}

/// Traces until the goal is met, passing by `observer` between dispatches; it returns whether to go on.
pub fn render(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    goal: &Goal,
    observer: &mut dyn FnMut(&Progress) -> bool,
) -> Result<Outcome, RenderError> {
    let started = Instant::now();
    let pixels = f64::from(film.width()) * f64::from(film.height());
    let (mut spp, mut batch) = (0, 0);
    let mut seconds_a_sample: Option<f64> = None;
    loop {
        let samples = goal.next_batch(spp);
        if samples == 0 {
            return Ok(Outcome::Done);
        }
        let elapsed = started.elapsed().as_secs_f64();
        let left = goal.time.map(|t| t.as_secs_f64() - elapsed);
        let up = if goal.spp.is_some() { Outcome::TimeUp } else { Outcome::Done };
        // At least one batch, whatever the time; afterwards only what fits.
        let cost = seconds_a_sample.map(|s| s * f64::from(samples));
        if let (Some(left), Some(cost)) = (left, cost)
            && left < cost
        {
            return Ok(up);
        }
        let pass_seconds = (LOSS * elapsed).max(SHORT);
        let mut batches = match (goal.spp, cost) {
            (_, None) => 1,
            _ if samples < goal.full_batch(spp) => 1,
            (Some(n), Some(cost)) => {
                let rest = (n - spp) / samples;
                let fits = (pass_seconds / cost).max(1.0) as u32;
                if f64::from(rest) * cost < 2.0 * SHORT { rest } else { fits.min(rest) }
            }
            // Until the next size of batch is due.
            (None, Some(cost)) => {
                let rest = if spp < 2 * BATCHES { 1.max((2 * BATCHES).saturating_sub(spp)) } else { BATCHES };
                ((pass_seconds / cost).max(1.0) as u32).min(rest)
            }
        };
        if let (Some(left), Some(cost)) = (left, cost) {
            batches = batches.min((left / cost) as u32);
        }
        batches = batches.clamp(1, renderer.most_batches());

        let before = renderer.counts;
        let pass_started = Instant::now();
        let mut watch = |counts: &Counts| {
            let paths = counts.paths as f64;
            let seconds = started.elapsed().as_secs_f64();
            let share = goal.spp.map(|n| paths / (pixels * f64::from(n)));
            let by_share = share.filter(|&s| s > 0.0).map(|s| seconds * (1.0 - s).max(0.0) / s);
            let by_time = goal.time.map(|t| (t.as_secs_f64() - seconds).max(0.0));
            let seconds_left = match (by_share, by_time) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            observer(&Progress { spp, share, seconds, seconds_left, counts: *counts })
        };
        if !renderer.trace(film, batch, batches, samples, &mut watch)? {
            renderer.counts.paths = before.paths; // thrown away with the pass
            return Ok(Outcome::Interrupted);
        }
        seconds_a_sample = Some(pass_started.elapsed().as_secs_f64() / f64::from(batches * samples));
        batch += batches;
        spp += batches * samples;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batches(spp: u32) -> Vec<u32> {
        let goal = Goal { spp: Some(spp), time: None };
        let (mut done, mut all) = (0, Vec::new());
        while goal.next_batch(done) > 0 {
            all.push(goal.next_batch(done));
            done += goal.next_batch(done);
        }
        assert_eq!(done, spp);
        all
    }

    #[test]
    fn all_samples_are_done_in_enough_batches_that_begin_small() {
        assert_eq!(batches(1), [1]);
        assert_eq!(batches(20), [1; 20]);
        assert_eq!(batches(64)[..5], [1, 1, 2, 4, 4]);
        for spp in [16, 64, 100, 1000, 4096, 100_000_000] {
            let all = batches(spp);
            let full = Goal { spp: Some(spp), time: None }.full_batch(0);
            assert!(all.iter().filter(|&&n| n == full).count() >= 15, "{spp}: {all:?}");
            assert_eq!(all[0], 1);
        }
    }

    #[test]
    fn without_a_number_batches_grow() {
        let goal = Goal::default();
        assert_eq!([0, 15, 31, 32, 1 << 20].map(|done| goal.next_batch(done)), [1, 1, 1, 2, 4096]);
    }
}
