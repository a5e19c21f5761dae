//! A render under way: batch after batch, in passes that lose little when they are interrupted.

use std::time::{Duration, Instant};

use surelight_film::Film;

use surelight_prepare::Batches;

use crate::{counts::Counts, error::RenderError, renderer::Renderer, resume::ResumeState};

/// A pass of about this long loses little when it is interrupted; what is left below it is done in one.
const SHORT: f64 = 2.0;

/// Of the time, what saving the film may take.
const SAVING: f64 = 0.05;

/// Of the time so far, what an interrupted pass may lose.
const LOSS: f64 = 0.125;

/// How a render stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Samples a pixel in the film.
    pub spp: u32,
    /// Samples a pixel that are planned; `None` where time alone decides, and during a pilot.
    pub target: Option<u32>,
    /// Of all samples planned, those finished; `None` without a plan.
    pub share: Option<f64>,
    /// Whether these samples only find out how many will be needed, and are thrown away.
    pub pilot: bool,
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
    /// The goal is met: its samples are in the film, its precision is reached, or its time is up with nothing else asked for.
    Done,
    /// Time was up before the samples or the precision asked for.
    TimeUp,
    /// The most samples that may be taken did not bring the precision asked for.
    SamplesUp,
    /// The observer said stop.
    Interrupted,
}

/// Asked between dispatches, whether to go on.
pub type Watch<'a> = dyn FnMut(&Progress) -> bool + 'a;

/// Saves the film while it grows.
pub struct CheckpointSink<'a> {
    /// How often: a batch that takes longer is finished first, and it may take 5 % of the time, so a large film is saved less often.
    pub every: Duration,
    /// Is given the film, where the render stands, and the counts.
    pub keep: &'a mut dyn FnMut(&Film, &ResumeState, &Counts),
}

/// A render under way.
pub(crate) struct Progression<'a, 'd, 'k> {
    pub(crate) renderer: &'a mut Renderer<'d>,
    /// Sizes of batches.
    pub(crate) plan: Batches,
    /// Number of the next batch.
    pub(crate) batch: u32,
    /// The next sample: all from the first up to it are done.
    pub(crate) spp: u32,
    /// What the pilot found.
    pub(crate) found: Option<[u32; 2]>,
    first: u32,
    keeper: Option<CheckpointSink<'k>>,
    kept: Instant,
    /// Samples a pixel that were done when this run began.
    begun: u32,
    pub(crate) started: Instant,
    pub(crate) pilot: bool,
    time: Option<Duration>,
    seconds_a_sample: Option<f64>,
}

impl<'a, 'd, 'k> Progression<'a, 'd, 'k> {
    pub(crate) fn new(
        renderer: &'a mut Renderer<'d>,
        time: Option<Duration>,
        standing: ResumeState,
        keeper: Option<CheckpointSink<'k>>,
    ) -> Self {
        let ResumeState { first, next, batch, pilot: found } = standing;
        let started = Instant::now();
        Self {
            renderer,
            plan: Batches { planned: None },
            batch,
            spp: next,
            found,
            first,
            keeper,
            kept: started,
            begun: next,
            started,
            pilot: false,
            time,
            seconds_a_sample: None,
        }
    }

    /// Where the render stands.
    pub(crate) fn standing(&self) -> ResumeState {
        ResumeState { first: self.first, next: self.spp, batch: self.batch, pilot: self.found }
    }

    /// Lets the film be saved, if it is time to.
    fn keep(&mut self, film: &Film) {
        let standing = self.standing();
        if let Some(keeper) = &mut self.keeper
            && !self.pilot
            && self.kept.elapsed() >= keeper.every
        {
            let began = Instant::now();
            (keeper.keep)(film, &standing, &self.renderer.counts);
            self.kept = Instant::now();
            keeper.every = keeper.every.max(began.elapsed().div_f64(SAVING));
        }
    }

    /// Seconds until the time is up.
    pub(crate) fn seconds_left(&self) -> Option<f64> {
        self.time.map(|t| t.as_secs_f64() - self.started.elapsed().as_secs_f64())
    }

    /// Samples a pixel that the time left allows; `None` where there is no limit or no experience.
    pub(crate) fn affordable_spp(&self) -> Option<u32> {
        Some((self.seconds_left()?.max(0.0) / self.seconds_a_sample?) as u32)
    }

    /// Traces until `until` samples a pixel are done (`None`), or tells why it stopped before. At least one batch is traced,
    /// whatever the time.
    pub(crate) fn advance(
        &mut self,
        film: &mut Film,
        until: Option<u32>,
        observer: &mut Watch<'_>,
    ) -> Result<Option<Outcome>, RenderError> {
        loop {
            let samples = self.plan.next(self.spp, until);
            if samples == 0 {
                return Ok(None);
            }
            let cost = self.seconds_a_sample.map(|s| s * f64::from(samples));
            let left = self.seconds_left();
            if let (Some(left), Some(cost)) = (left, cost)
                && left < cost
                && self.spp > self.first
            {
                return Ok(Some(Outcome::TimeUp));
            }
            let batches = self.batches_of_pass(until, cost, left);
            let before = self.renderer.counts;
            let pass_started = Instant::now();
            let (batch, spp) = (self.batch, self.spp);
            if !self.trace(film, until, batches, samples, observer)? {
                // Thrown away with the pass; the time is spent.
                let spent = self.renderer.counts;
                self.renderer.counts = Counts {
                    trace_seconds: spent.trace_seconds,
                    device_seconds: spent.device_seconds,
                    read_seconds: spent.read_seconds,
                    film_seconds: spent.film_seconds,
                    dispatches: spent.dispatches,
                    ..before
                };
                return Ok(Some(Outcome::Interrupted));
            }
            self.seconds_a_sample = Some(pass_started.elapsed().as_secs_f64() / f64::from(batches * samples));
            self.batch = batch + batches;
            self.spp = spp + batches * samples;
            self.keep(film);
        }
    }

    /// How many batches to trace at once, each costing `cost` seconds.
    fn batches_of_pass(&self, until: Option<u32>, cost: Option<f64>, left: Option<f64>) -> u32 {
        let Some(cost) = cost else { return 1 };
        let mut pass_seconds = (LOSS * self.started.elapsed().as_secs_f64()).max(SHORT);
        if let Some(keeper) = self.keeper.as_ref().filter(|_| !self.pilot) {
            let due = keeper.every.saturating_sub(self.kept.elapsed()).as_secs_f64();
            pass_seconds = pass_seconds.min(due);
        }
        let run = self.plan.run(self.spp, until);
        let fits = (pass_seconds / cost).max(1.0) as u32;
        let mut batches =
            if until.is_some() && f64::from(run) * cost < 2.0 * pass_seconds.min(SHORT) { run } else { fits.min(run) };
        if let Some(left) = left {
            batches = batches.min((left / cost) as u32);
        }
        batches.clamp(1, self.renderer.max_batches())
    }

    fn trace(
        &mut self,
        film: &mut Film,
        until: Option<u32>,
        batches: u32,
        samples: u32,
        observer: &mut Watch<'_>,
    ) -> Result<bool, RenderError> {
        let pixels = f64::from(film.width()) * f64::from(film.height());
        let (spp, pilot, started, time) = (self.spp, self.pilot, self.started, self.time);
        let first = if pilot { 0 } else { self.first };
        let begun = if pilot { 0.0 } else { f64::from(self.begun - first) };
        let (paths_before, of_pass) = (self.renderer.counts.paths, f64::from(batches) * f64::from(samples));
        let a_sample = pixels * self.renderer.mean_share(&film.window());
        let until = until.map(|until| until - first);
        let mut watch = |counts: &Counts| {
            let seconds = started.elapsed().as_secs_f64();
            let in_pass = ((counts.paths - paths_before) as f64 / a_sample).min(of_pass);
            let share = until.map(|n| (f64::from(spp - first) + in_pass) / f64::from(n));
            let by_share = share.zip(until).and_then(|(share, n)| {
                let here = share - begun / f64::from(n);
                (here > 0.0).then(|| seconds * (1.0 - share).max(0.0) / here)
            });
            let by_time = time.map(|t| (t.as_secs_f64() - seconds).max(0.0));
            let seconds_left = match (by_share, by_time) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            let target = until.filter(|_| !pilot);
            observer(&Progress { spp: spp - first, target, share, pilot, seconds, seconds_left, counts: *counts })
        };
        let number = if self.renderer.key().is_one_sequence() { self.spp } else { self.batch };
        self.renderer.trace(film, number, batches, samples, &mut watch)
    }
}
