//! How many samples a measurement takes, and taking them.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use surelight_estimate::{Estimate, student_t_quantile};
use surelight_film::Film;
use surelight_render::{
    BatchSizes, Counts, End, FinishedPass, NextPass, PassVisitor, Position, Renderer, Schedule, sample,
};

use super::args::MeasureArgs;
use super::tally::Tally;
use super::view::Setup;
use crate::console;
use crate::error::Error;

/// Samples of the point, and of each pixel of a region, when nothing says when to stop.
const DEFAULT_SAMPLES: u32 = 1 << 20;
const DEFAULT_SPP: u32 = 256;

/// `--error` gives up after this long when there is no `--time`.
const PATIENCE: Duration = Duration::from_secs(600);

/// Samples of a pixel in a batch: sums on the device are f32.
const MAX_SAMPLES: u32 = 1024;

/// Batches at least where pixels differ: each pixel's variance comes from its own.
const MIN_BATCHES: u32 = 16;

/// The pilot's samples per pixel, in so many batches.
const PILOT_SAMPLES: u32 = 16;
const PILOT_BATCHES: u32 = 4;

/// A factor on the number that the pilot finds: its own estimate is noisy.
const MARGIN: f64 = 1.05;

/// Shortest time between two lines of progress, seconds.
const LOG_EVERY: f64 = 10.0;

/// Batches of the pilot are numbered from here, so that none of it is used again.
const PILOT_FIRST: u32 = 1 << 31;

/// How much to trace.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    /// Pixels, all of which are sampled.
    pub(super) pixels: u64,
    /// Samples of a pixel in a batch.
    pub(super) samples: u32,
    /// Batches; `u32::MAX` where time alone decides.
    batches: u32,
    deadline: Option<Instant>,
    pub(super) pilot_samples: u64,
    /// The reason recorded when all batches are traced.
    end: &'static str,
}

impl Plan {
    /// Prints a line of progress: samples done, and seconds left.
    fn log(&self, batches: u32, seconds: f64) {
        let samples = |batches: u32| self.pixels as f64 * f64::from(self.samples) * f64::from(batches) / 1e6;
        let by_number = seconds / f64::from(batches) * f64::from(self.batches - batches);
        let by_time = self.deadline.map_or(f64::MAX, |d| d.saturating_duration_since(Instant::now()).as_secs_f64());
        let of = if self.batches == u32::MAX { String::new() } else { format!(" of {:.1}", samples(self.batches)) };
        console::note(&format!("{:.1}{of} million samples, {:.0} s left", samples(batches), by_number.min(by_time)));
    }
}

/// A measurement under way.
pub(super) struct Measurement<'a> {
    pub(super) renderer: Renderer<'a>,
    pub(super) setup: Setup,
}

/// Tallies batches, each in a film of its own, until time is up.
struct Tallying<'t> {
    tally: &'t mut Tally,
    deadline: Option<Instant>,
    /// Batches that are traced whatever the time.
    min_batches: u32,
    /// What to log of, and when it began.
    log: Option<(&'t Plan, Instant)>,
    next_log_seconds: f64,
}

impl Tallying<'_> {
    /// Whether time is up for what began after so many batches.
    fn is_late(&self, batches: u32) -> bool {
        batches >= self.min_batches && self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

impl PassVisitor for Tallying<'_> {
    type Stop = ();

    fn before_pass(&mut self, _: &NextPass, _: &Counts) -> ControlFlow<(), u32> {
        if let Some((plan, began)) = self.log {
            let seconds = began.elapsed().as_secs_f64();
            if self.tally.batches() > 0 && seconds >= self.next_log_seconds {
                self.next_log_seconds = seconds + (seconds / 2.0).max(LOG_EVERY);
                plan.log(self.tally.batches(), seconds);
            }
        }
        ControlFlow::Continue(1)
    }

    fn after_dispatch(&mut self, _: &Counts) -> bool {
        !self.is_late(self.tally.batches())
    }

    fn after_pass(&mut self, film: &mut Film, _: &FinishedPass, _: &Counts) -> ControlFlow<()> {
        let before = self.tally.batches();
        self.tally.add(film);
        *film = Film::of_window(film.window());
        if self.is_late(before) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Measurement<'_> {
    /// Traces `batches` batches of `samples` samples per pixel from number `first` on, or as many
    /// as there is time for.
    fn trace(&mut self, first: u32, batches: u32, samples: u32, tallying: &mut Tallying<'_>) -> Result<(), Error> {
        let settings = &self.setup.settings;
        let mut film = Film::new(settings.width, settings.height);
        let schedule = Schedule { sizes: BatchSizes::Equal(samples), end: batches.checked_mul(samples) };
        let mut position = Position { sample: 0, batch: first };
        let (End::Complete | End::Stopped(()) | End::Interrupted) =
            sample(&mut self.renderer, &mut film, schedule, &mut position, tallying)?;
        Ok(())
    }

    fn tally(&self) -> Tally {
        let settings = &self.setup.settings;
        Tally::new(settings.width as usize * settings.height as usize, self.setup.same_quantity)
    }

    /// Fixes the number of samples, by a pilot where `--error` or `--time` says when to stop.
    pub(super) fn plan(&mut self, args: &MeasureArgs, start: Instant) -> Result<Plan, Error> {
        let settings = &self.setup.settings;
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let patience = args.time.or(args.error.map(|_| PATIENCE));
        let deadline = patience.map(|time| start + time);
        let limited = args.error.is_some() || args.time.is_some();
        let default = (!limited).then_some(if self.setup.same_quantity { DEFAULT_SAMPLES } else { DEFAULT_SPP });
        // Samples of each pixel here.
        let share = if self.setup.same_quantity { pixels } else { u64::from(self.setup.parts) };
        let requested = args.spp.or(default).map(|spp| u64::from(spp).div_ceil(share).max(1));
        let min_batches = if self.setup.same_quantity { 1 } else { MIN_BATCHES };
        let mut plan = Plan { pixels, samples: 1, batches: u32::MAX, deadline, pilot_samples: 0, end: "done" };
        if !limited {
            let each = requested.unwrap_or(1);
            plan.samples = power_of_two(each / u64::from(MIN_BATCHES)).min(MAX_SAMPLES);
            plan.batches = each.div_ceil(plan.samples.into()).clamp(min_batches.into(), u32::MAX.into()) as u32;
            return Ok(plan);
        }
        let pilot_each = if self.setup.same_quantity { PILOT_SAMPLES } else { (PILOT_SAMPLES / 4).max(1) };
        let mut pilot = self.tally();
        let paths_before = self.renderer.counts.paths;
        let began = Instant::now();
        let mut tallying =
            Tallying { tally: &mut pilot, deadline: None, min_batches: 0, log: None, next_log_seconds: 0.0 };
        self.trace(PILOT_FIRST, PILOT_BATCHES, pilot_each, &mut tallying)?;
        plan.pilot_samples = self.renderer.counts.paths - paths_before;
        let seconds_per_batch = began.elapsed().as_secs_f64() / f64::from(PILOT_BATCHES);
        plan.samples = pilot_each;
        let mut needed = u64::from(u32::MAX); // batches
        if let Some(error) = args.error {
            let found = &pilot.estimates(self.setup.factor)[3];
            needed = batches_for(&pilot, found, self.setup.factor, error, args.confidence);
        } else {
            // As many batches as there is time for keep the clock; few of more samples are better
            // stratified.
            let left = deadline.map_or(0.0, |d| (d - Instant::now().min(d)).as_secs_f64());
            let fits = (left / 32.0 / seconds_per_batch.max(1e-6)) as u64;
            plan.samples = power_of_two(fits).saturating_mul(pilot_each).min(MAX_SAMPLES);
        }
        if args.error.is_some() {
            while needed >= 128 && plan.samples < MAX_SAMPLES {
                plan.samples *= 2;
                needed = needed.div_ceil(2);
            }
        }
        if let Some(requested) = requested {
            let max = requested.div_ceil(plan.samples.into());
            if max < needed {
                plan.end = if args.error.is_some() { "samples" } else { "done" };
                needed = max;
            }
        }
        plan.batches = needed.clamp(min_batches.into(), u32::MAX.into()) as u32;
        Ok(plan)
    }

    /// Traces until the plan is done or the time is up; one batch at least (where pixels differ,
    /// two).
    pub(super) fn carry_out(&mut self, plan: &Plan) -> Result<(Tally, &'static str), Error> {
        let mut tally = self.tally();
        let mut tallying = Tallying {
            tally: &mut tally,
            deadline: plan.deadline,
            min_batches: if self.setup.same_quantity { 1 } else { 2 },
            log: Some((plan, Instant::now())),
            next_log_seconds: LOG_EVERY,
        };
        self.trace(0, plan.batches, plan.samples, &mut tallying)?;
        let stopped = match tally.batches() == plan.batches {
            true => plan.end,
            // With time alone, time is the target.
            false if plan.batches == u32::MAX && plan.end == "done" => "done",
            false => "time",
        };
        Ok((tally, stopped))
    }
}

/// Batches like the pilot's after which the interval is as narrow as requested, with caution.
fn batches_for(pilot: &Tally, found: &Estimate, factor: f64, error: f64, confidence: f64) -> u64 {
    let quantile = student_t_quantile(0.5 + 0.5 * confidence, found.dof.max(1.0));
    let caution = pilot.cautious_variance(factor);
    let mean = (found.mean.abs() - quantile * found.variance.sqrt()).max(0.5 * found.mean.abs());
    if mean == 0.0 || !caution.is_finite() {
        return u64::from(MIN_BATCHES);
    }
    let needed = MARGIN * f64::from(PILOT_BATCHES) * caution * (quantile / (error * mean)).powi(2);
    (needed.ceil() as u64).max(1)
}

fn power_of_two(n: u64) -> u32 {
    if n == 0 { 1 } else { 1 << n.ilog2().min(31) }
}
