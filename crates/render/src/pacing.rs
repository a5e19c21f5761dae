//! A render under way: how long its passes are, when its time is up, and which results are reported
//! and saved in between.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use surelight_film::Film;
use surelight_prepare::Batches;

use crate::{
    counts::Counts,
    error::RenderError,
    renderer::Renderer,
    resume::ResumeState,
    sampling::{BatchSizes, End, FinishedPass, NextPass, PassVisitor, Position, Schedule, sample},
};

/// Target duration of a pass, so that an interruption loses little; a shorter remainder is done in
/// one pass.
const SHORT_SECONDS: f64 = 2.0;

/// The maximum fraction of the time spent on saving the film.
const SAVING_SHARE: f64 = 0.05;

/// The maximum fraction of the time so far that an interrupted pass may lose.
const LOSS_SHARE: f64 = 0.125;

/// Progress of a render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Samples per pixel in the film.
    pub spp: u32,
    /// Planned samples per pixel; `None` where time alone decides, and during a pilot.
    pub target: Option<u32>,
    /// The finished fraction of the planned samples; `None` without a plan.
    pub share: Option<f64>,
    /// Whether these samples are a pilot's: they estimate the number needed, and are discarded.
    pub pilot: bool,
    /// Seconds since the render began.
    pub seconds: f64,
    /// Estimated remaining seconds; `None` before there is anything to estimate from.
    pub seconds_left: Option<f64>,
    /// Counts of the device.
    pub counts: Counts,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The goal is reached: its samples are in the film, its precision is reached, or its time has
    /// passed and it has no other limit.
    Done,
    /// The time limit came before the requested samples or precision.
    TimeUp,
    /// The maximum number of samples did not suffice for the requested precision.
    SamplesUp,
    /// The observer stopped it.
    Interrupted,
}

/// Called between dispatches; returns whether to continue.
pub type Watch<'a> = dyn FnMut(&Progress) -> bool + 'a;

/// Saves the film in the course of a render.
pub struct CheckpointSink<'a> {
    /// The interval between checkpoints. A longer batch is finished first; and saving takes at most
    /// 5 % of the time, so a large film is saved less often.
    pub every: Duration,
    /// Receives the film, the state to resume from, and the counts.
    pub save: &'a mut dyn FnMut(&Film, &ResumeState, &Counts),
}

/// A render in progress.
pub(crate) struct Progression<'a, 'd, 'k> {
    renderer: &'a mut Renderer<'d>,
    /// Sizes of batches.
    pub(crate) plan: Batches,
    /// The next batch; all samples before it are done.
    pub(crate) position: Position,
    pub(crate) pacing: Pacing<'k>,
}

/// The state that decides about passes; it persists over the parts of a render.
pub(crate) struct Pacing<'k> {
    /// The first sample of this part of the render.
    first: u32,
    /// Samples per pixel that were done when this run began.
    begun: u32,
    /// The result of the pilot.
    pub(crate) found: Option<[u32; 2]>,
    /// Whether the samples are a pilot's.
    pub(crate) is_pilot: bool,
    pub(crate) started: Instant,
    time: Option<Duration>,
    seconds_per_sample: Option<f64>,
    sink: Option<CheckpointSink<'k>>,
    saved: Instant,
}

impl<'a, 'd, 'k> Progression<'a, 'd, 'k> {
    pub(crate) fn new(
        renderer: &'a mut Renderer<'d>,
        time: Option<Duration>,
        state: ResumeState,
        sink: Option<CheckpointSink<'k>>,
    ) -> Self {
        let ResumeState { first, next, batch, pilot: found } = state;
        let started = Instant::now();
        let pacing = Pacing {
            first,
            begun: next,
            found,
            is_pilot: false,
            started,
            time,
            seconds_per_sample: None,
            sink,
            saved: started,
        };
        Self { renderer, plan: Batches { planned: None }, position: Position { sample: next, batch }, pacing }
    }

    /// The state from which another run can continue.
    pub(crate) fn resume_state(&self) -> ResumeState {
        self.pacing.resume_state(self.position)
    }

    /// Traces until `end` samples per pixel are done (`None`), or returns why it stopped before. At
    /// least one batch is traced, regardless of the time limit.
    pub(crate) fn advance(
        &mut self,
        film: &mut Film,
        end: Option<u32>,
        observer: &mut Watch<'_>,
    ) -> Result<Option<Outcome>, RenderError> {
        let pixels = f64::from(film.width()) * f64::from(film.height());
        let mut control = Control {
            pacing: &mut self.pacing,
            observer,
            end,
            paths_per_sample: pixels * self.renderer.mean_share(&film.window()),
            paths_before: 0,
            sample: 0,
            samples_of_pass: 0.0,
        };
        let schedule = Schedule { sizes: BatchSizes::Planned(self.plan), end };
        Ok(match sample(self.renderer, film, schedule, &mut self.position, &mut control)? {
            End::Complete => None,
            End::Stopped(outcome) => Some(outcome),
            End::Interrupted => Some(Outcome::Interrupted),
        })
    }
}

impl Pacing<'_> {
    fn resume_state(&self, position: Position) -> ResumeState {
        ResumeState { first: self.first, next: position.sample, batch: position.batch, pilot: self.found }
    }

    /// Seconds until the time limit.
    pub(crate) fn seconds_left(&self) -> Option<f64> {
        self.time.map(|t| t.as_secs_f64() - self.started.elapsed().as_secs_f64())
    }

    /// Samples per pixel that the remaining time allows; `None` where there is no limit or no
    /// measured speed.
    pub(crate) fn affordable_spp(&self) -> Option<u32> {
        Some((self.seconds_left()?.max(0.0) / self.seconds_per_sample?) as u32)
    }

    /// The number of batches in the next pass, at `cost` seconds per batch.
    fn batches_of_pass(&self, next: &NextPass, is_last: bool, cost: Option<f64>, seconds_left: Option<f64>) -> u32 {
        let Some(cost) = cost else { return 1 };
        let mut pass_seconds = (LOSS_SHARE * self.started.elapsed().as_secs_f64()).max(SHORT_SECONDS);
        if let Some(sink) = self.sink.as_ref().filter(|_| !self.is_pilot) {
            let due = sink.every.saturating_sub(self.saved.elapsed()).as_secs_f64();
            pass_seconds = pass_seconds.min(due);
        }
        let fits = (pass_seconds / cost).max(1.0) as u32;
        let is_short = f64::from(next.run) * cost < 2.0 * pass_seconds.min(SHORT_SECONDS);
        let mut batches = if is_last && is_short { next.run } else { fits.min(next.run) };
        if let Some(left) = seconds_left {
            batches = batches.min((left / cost) as u32);
        }
        batches.clamp(1, next.max_batches)
    }

    /// Saves the film if a checkpoint is due.
    fn save(&mut self, film: &Film, position: Position, counts: &Counts) {
        let state = self.resume_state(position);
        if let Some(sink) = &mut self.sink
            && !self.is_pilot
            && self.saved.elapsed() >= sink.every
        {
            let began = Instant::now();
            (sink.save)(film, &state, counts);
            self.saved = Instant::now();
            sink.every = sink.every.max(began.elapsed().div_f64(SAVING_SHARE));
        }
    }
}

/// The visitor of one call of [`Progression::advance`].
struct Control<'c, 'k, 'w> {
    pacing: &'c mut Pacing<'k>,
    observer: &'c mut Watch<'w>,
    end: Option<u32>,
    paths_per_sample: f64,
    /// Paths before the pass.
    paths_before: u64,
    /// The first sample of the pass.
    sample: u32,
    /// Samples per pixel in the pass.
    samples_of_pass: f64,
}

impl PassVisitor for Control<'_, '_, '_> {
    type Stop = Outcome;

    fn before_pass(&mut self, next: &NextPass, counts: &Counts) -> ControlFlow<Outcome, u32> {
        let pacing = &*self.pacing;
        let cost = pacing.seconds_per_sample.map(|seconds| seconds * f64::from(next.samples));
        let left = pacing.seconds_left();
        if let (Some(left), Some(cost)) = (left, cost)
            && left < cost
            && next.position.sample > pacing.first
        {
            return ControlFlow::Break(Outcome::TimeUp);
        }
        let batches = pacing.batches_of_pass(next, self.end.is_some(), cost, left);
        self.paths_before = counts.paths;
        self.sample = next.position.sample;
        self.samples_of_pass = f64::from(batches) * f64::from(next.samples);
        ControlFlow::Continue(batches)
    }

    fn after_dispatch(&mut self, counts: &Counts) -> bool {
        let Pacing { first, begun, is_pilot: pilot, started, time, .. } = *self.pacing;
        let first = if pilot { 0 } else { first };
        let begun = if pilot { 0.0 } else { f64::from(begun - first) };
        let spp = self.sample - first;
        let target = self.end.map(|end| end - first);
        let seconds = started.elapsed().as_secs_f64();
        let in_pass = ((counts.paths - self.paths_before) as f64 / self.paths_per_sample).min(self.samples_of_pass);
        let share = target.map(|n| (f64::from(spp) + in_pass) / f64::from(n));
        let by_share = share.zip(target).and_then(|(share, n)| {
            let here = share - begun / f64::from(n);
            (here > 0.0).then(|| seconds * (1.0 - share).max(0.0) / here)
        });
        let by_time = time.map(|t| (t.as_secs_f64() - seconds).max(0.0));
        let seconds_left = match (by_share, by_time) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let target = target.filter(|_| !pilot);
        (self.observer)(&Progress { spp, target, share, pilot, seconds, seconds_left, counts: *counts })
    }

    fn after_pass(&mut self, film: &mut Film, pass: &FinishedPass, counts: &Counts) -> ControlFlow<Outcome> {
        self.pacing.seconds_per_sample = Some(pass.seconds / f64::from(pass.batches * pass.samples));
        self.pacing.save(film, pass.position, counts);
        ControlFlow::Continue(())
    }
}
