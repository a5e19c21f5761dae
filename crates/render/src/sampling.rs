//! The sampling loop: passes of whole batches, until a schedule ends or a visitor stops it.
//!
//! Everything that traces more than a pass runs [`sample`]. It alone knows how batches are numbered
//! and how many fit a pass. How long passes are, when to stop, and the reports and files in
//! between are the visitor's.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::time::Instant;

use surelight_film::Film;
use surelight_prepare::Batches;

use crate::{counts::Counts, error::RenderError, renderer::Renderer};

/// Sizes of batches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BatchSizes {
    /// By the planned or finished number of samples.
    Planned(Batches),
    /// Equal batches of this many samples per pixel; the last may be shorter.
    Equal(u32),
}

impl BatchSizes {
    /// Samples in the next batch after `done` samples per pixel; 0 at the end.
    fn next(self, done: u32, end: Option<u32>) -> u32 {
        match self {
            Self::Planned(batches) => batches.next(done, end),
            Self::Equal(samples) => samples.min(end.map_or(u32::MAX, |end| end.saturating_sub(done))),
        }
    }

    /// The number of successive batches that have the size of the next one.
    fn run(self, done: u32, end: Option<u32>) -> u32 {
        match self {
            Self::Planned(batches) => batches.run(done, end),
            Self::Equal(samples) => (end.map_or(u32::MAX, |end| end.saturating_sub(done)) / samples.max(1)).max(1),
        }
    }
}

/// The samples to trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Sizes of batches.
    pub sizes: BatchSizes,
    /// The sample per pixel before which it ends; `None`: the visitor decides.
    pub end: Option<u32>,
}

/// The next batch of a render: by the number of its first sample, and its own number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Position {
    /// Number of the next sample of each pixel.
    pub sample: u32,
    /// Number of the next batch.
    pub batch: u32,
}

impl Position {
    /// The batch numbered `first`; with one sequence, the batch whose first sample has this number.
    pub fn numbered(first: u32) -> Self {
        Self { sample: first, batch: first }
    }
}

/// A pass that is about to be traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NextPass {
    /// Its first batch.
    pub position: Position,
    /// Samples per pixel in each batch.
    pub samples: u32,
    /// The number of successive batches of this size.
    pub run: u32,
    /// Maximum number of batches in a pass.
    pub max_batches: u32,
}

/// A pass whose batches are in the film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinishedPass {
    /// The batch after it.
    pub position: Position,
    /// Batches.
    pub batches: u32,
    /// Samples per pixel in each.
    pub samples: u32,
    /// Its duration in seconds.
    pub seconds: f64,
}

/// Decides what happens between passes.
pub trait PassVisitor {
    /// The reason for which it stops the loop.
    type Stop;

    /// Before a pass: its number of batches, or the reason to stop. At least one is traced, at most
    /// as many as have the same size and fit.
    fn before_pass(&mut self, _next: &NextPass, _counts: &Counts) -> ControlFlow<Self::Stop, u32> {
        ControlFlow::Continue(u32::MAX)
    }

    /// Between dispatches: whether to continue. If not, the pass is discarded.
    fn after_dispatch(&mut self, _counts: &Counts) -> bool {
        true
    }

    /// After a pass: whether to continue.
    fn after_pass(&mut self, _film: &mut Film, _pass: &FinishedPass, _counts: &Counts) -> ControlFlow<Self::Stop> {
        ControlFlow::Continue(())
    }
}

/// Lets the schedule decide alone.
impl PassVisitor for () {
    type Stop = Infallible;
}

/// Why the loop ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End<S> {
    /// The schedule is done.
    Complete,
    /// The visitor stopped it between passes.
    Stopped(S),
    /// The visitor interrupted a pass, which is discarded.
    Interrupted,
}

/// Traces the schedule's batches from `position` on and adds them to the film. `position` is
/// updated, also on errors: it always describes the film.
pub fn sample<V: PassVisitor>(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    schedule: Schedule,
    position: &mut Position,
    visitor: &mut V,
) -> Result<End<V::Stop>, RenderError> {
    let Schedule { sizes, end } = schedule;
    loop {
        let samples = sizes.next(position.sample, end);
        if samples == 0 {
            return Ok(End::Complete);
        }
        let run = sizes.run(position.sample, end);
        let next = NextPass { position: *position, samples, run, max_batches: renderer.max_batches() };
        let batches = match visitor.before_pass(&next, &renderer.counts) {
            ControlFlow::Continue(batches) => batches.min(run).clamp(1, next.max_batches),
            ControlFlow::Break(stop) => return Ok(End::Stopped(stop)),
        };
        let (started, before) = (Instant::now(), renderer.counts);
        let number = if renderer.key().is_one_sequence() { position.sample } else { position.batch };
        if !renderer.trace(film, number, batches, samples, &mut |counts| visitor.after_dispatch(counts))? {
            renderer.counts = renderer.counts.without_unfinished(&before);
            return Ok(End::Interrupted);
        }
        position.sample = position.sample.saturating_add(batches * samples);
        position.batch = position.batch.wrapping_add(batches);
        let seconds = started.elapsed().as_secs_f64();
        let pass = FinishedPass { position: *position, batches, samples, seconds };
        if let ControlFlow::Break(stop) = visitor.after_pass(film, &pass, &renderer.counts) {
            return Ok(End::Stopped(stop));
        }
    }
}

/// Traces `count` batches of `samples` samples per pixel from a position on.
pub fn sample_batches(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    from: Position,
    count: u32,
    samples: u32,
) -> Result<(), RenderError> {
    let schedule = Schedule { sizes: BatchSizes::Equal(samples), end: Some(from.sample + count * samples) };
    let mut position = from;
    sample(renderer, film, schedule, &mut position, &mut ())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_batches_end_where_the_schedule_does() {
        let sizes = BatchSizes::Equal(8);
        assert_eq!([0, 8, 16, 19, 30].map(|done| sizes.next(done, Some(19))), [8, 8, 3, 0, 0]);
        assert_eq!([0, 8, 16].map(|done| sizes.run(done, Some(19))), [2, 1, 1]);
        assert_eq!((sizes.next(1 << 20, None), sizes.run(0, None)), (8, u32::MAX / 8));
    }
}
