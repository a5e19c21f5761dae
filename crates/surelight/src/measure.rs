//! `surelight measure`: one number with its error bar.

mod args;
mod report;
mod tally;
mod view;

use std::time::{Duration, Instant};

use surelight_estimate::{Estimate, student_t_half_width, student_t_quantile};
use surelight_film::Film;
use surelight_render::{Device, Prepared, Renderer};

pub(crate) use self::args::MeasureArgs;
use self::report::{Report, Value};
use self::tally::Tally;
use self::view::Setup;
use crate::error::Error;
use crate::{camera, console, light, method, render};

/// Samples of the point, and of each pixel of a region, when nothing says when to stop.
const DEFAULT_SAMPLES: u32 = 1 << 20;
const DEFAULT_SPP: u32 = 256;

/// `--error` gives up after this long when there is no `--time`.
const PATIENCE: Duration = Duration::from_secs(600);

/// Samples of a pixel in a batch: sums on the device are f32.
const MAX_SAMPLES: u32 = 1024;

/// Minimum number of batches where pixels differ: each pixel's variance comes from its own batches.
const MIN_BATCHES: u32 = 16;

/// The pilot's samples per pixel, and its batches.
const PILOT_SAMPLES: u32 = 16;
const PILOT_BATCHES: u32 = 4;

/// A margin over the pilot's estimate, which is noisy.
const MARGIN: f64 = 1.05;

/// Shortest time between two lines of progress, seconds.
const LOG_INTERVAL_SECONDS: f64 = 10.0;

/// Replicates of the pilot are numbered from here, so that its random numbers are not reused.
const PILOT_FIRST: u32 = 1 << 31;

/// Measures and prints the result; returns whether the target was reached.
pub(crate) fn run(args: &MeasureArgs) -> Result<bool, Error> {
    let start = Instant::now();
    let options = args.file.load_options();
    let mut scene = args.scene.load(&options)?;
    let light_note = light::set(&mut scene, &args.light)?;
    let mut warnings = std::mem::take(&mut scene.warnings);
    warnings.extend(light_note);
    warnings.extend(args.method.warning(&scene));
    let device = Device::new(&render::adapter_choice(args.adapter.as_ref()))?;
    let setup = view::setup(args, &scene, device.info.is_cpu)?;
    let prepared = Prepared::new(&scene, &setup.camera, &setup.settings)?;
    warnings.extend(camera::clipping_warning(&setup.camera, prepared.cut));
    let mut measurement = Measurement { renderer: Renderer::new(&device, &prepared)?, setup, batch: 0 };
    let unreachable = prepared.unreachable.clone();
    drop(prepared);
    let plan = measurement.plan(args, start)?;
    let (mut tally, stopped) = measurement.carry_out(&plan)?;

    let Measurement { renderer, setup, .. } = measurement;
    let mut biased: Vec<String> = args.method.bias(&scene).into_iter().collect();
    biased.extend(unreachable.iter().filter(|light| light.is_bias()).map(ToString::to_string));
    warnings.extend(unreachable.iter().filter(|light| !light.is_bias()).map(ToString::to_string));
    if let Some(bounces) = args.max_bounces.0 {
        biased.push(format!("max-bounces {bounces}"));
    }
    let estimates = tally.estimates(setup.factor);
    let values = estimates.map(|e| value(&e, args.confidence));
    let luminance = values[3];
    let relative_error = luminance.half_width.filter(|_| luminance.value != 0.0).map(|h| h / luminance.value.abs());
    let tail = tally.tail();
    let mut report = Report {
        scene: args.scene.name().display().to_string(),
        quantity: if setup.settings.receiver {
            "irradiance"
        } else if setup.same_quantity {
            "radiance"
        } else {
            "mean radiance"
        },
        place: place(args),
        rgb: [values[0], values[1], values[2]],
        luminance,
        unit: if setup.settings.receiver { "lx" } else { "nit" },
        confidence: args.confidence,
        relative_error,
        target_error: args.error,
        stopped,
        samples: plan.pixels * u64::from(plan.samples) * u64::from(tally.batches()),
        replicates: tally.replicates(),
        pilot_samples: plan.pilot_samples,
        tail: tail.map(|t| [t.k, t.limit]),
        certified: true,
        integrator: method::word(args.method.with(setup.settings.integrator).integrator),
        seed: args.seed,
        adapter: device.info.name.clone(),
        rays: renderer.counts.rays,
        seconds: 0.0,
        dropped_samples: renderer.counts.dropped,
        truncated_rays: renderer.counts.truncated,
        biased,
        warnings,
        notes: setup.notes,
    };
    judge(&mut report);
    report.seconds = start.elapsed().as_secs_f64();
    let text = if args.json {
        serde_json::to_string(&report).map_err(|e| Error::Print(e.into()))? + "\n"
    } else {
        report.to_string()
    };
    console::result(&text)?;
    Ok(report.stopped == "done")
}

/// Notes reasons to doubt the error bar, and whether the target is reached.
fn judge(report: &mut Report) {
    let mut doubts = Vec::new();
    if let Some([k, limit]) = report.tail.filter(|[k, limit]| k > limit) {
        doubts.push(format!(
            "the estimates have a heavy tail (Pareto k = {k:.2}, above {limit:.2}): rare bright paths may be missing, \
             and the error bar cannot be trusted"
        ));
    }
    if report.luminance.value == 0.0 {
        doubts.push(
            "every sample was black: either there is no light here, or its paths are too rare to be found".to_owned(),
        );
    }
    if report.dropped_samples > 0 {
        doubts.push(format!("{} samples were not finite and were left out", report.dropped_samples));
    }
    if report.truncated_rays > 0 {
        doubts.push(format!("{} rays were cut short, their samples are incomplete", report.truncated_rays));
    }
    if report.luminance.half_width.is_none() {
        doubts.push("one estimate alone has no error bar".to_owned());
    }
    report.certified = doubts.is_empty();
    report.notes.extend(doubts);
    if !report.biased.is_empty() {
        report.notes.push("the error bar holds for the biased quantity, not for the true one".to_owned());
    }
    if let Some(target) = report.target_error
        && report.stopped == "done"
        && !(report.certified && report.relative_error.is_some_and(|e| e <= target))
    {
        report.stopped = if report.certified { "missed" } else { "unreachable" };
    }
    report.notes.push("± is the error of sampling; f32 rounding may add about 1e-6 of the value".to_owned());
}

/// How much to trace.
#[derive(Clone, Copy, Debug)]
struct Plan {
    /// Pixels, all of which are sampled.
    pixels: u64,
    /// Samples of a pixel in a batch.
    samples: u32,
    /// Batches; `u32::MAX` where time alone decides.
    batches: u32,
    deadline: Option<Instant>,
    pilot_samples: u64,
    /// The reason recorded when the batches are done.
    end: &'static str,
}

impl Plan {
    /// A line of a log: samples done, time left.
    fn log_progress(&self, batches: u32, seconds: f64) {
        let samples = |batches: u32| self.pixels as f64 * f64::from(self.samples) * f64::from(batches) / 1e6;
        let by_number = seconds / f64::from(batches) * f64::from(self.batches - batches);
        let by_time = self.deadline.map_or(f64::MAX, |d| d.saturating_duration_since(Instant::now()).as_secs_f64());
        let of = if self.batches == u32::MAX { String::new() } else { format!(" of {:.1}", samples(self.batches)) };
        console::note(&format!("{:.1}{of} million samples, {:.0} s left", samples(batches), by_number.min(by_time)));
    }
}

/// A measurement under way.
struct Measurement<'a> {
    renderer: Renderer<'a>,
    setup: Setup,
    /// Number of the next batch.
    batch: u32,
}

impl Measurement<'_> {
    /// A separate batch.
    fn trace(&mut self, samples: u32, tally: &mut Tally, deadline: Option<Instant>) -> Result<bool, Error> {
        let mut film = Film::new(self.setup.settings.width, self.setup.settings.height);
        let mut on_time = |_: &surelight_render::Counts| deadline.is_none_or(|d| Instant::now() < d);
        if !self.renderer.trace(&mut film, self.batch, 1, samples, &mut on_time)? {
            return Ok(false);
        }
        self.batch += 1;
        tally.add(&film);
        Ok(true)
    }

    fn tally(&self) -> Tally {
        let settings = &self.setup.settings;
        Tally::new(settings.width as usize * settings.height as usize, self.setup.same_quantity)
    }

    /// Fixes the number of samples, by a pilot where `--error` or `--time` says when to stop.
    fn plan(&mut self, args: &MeasureArgs, start: Instant) -> Result<Plan, Error> {
        let settings = &self.setup.settings;
        let pixels = u64::from(settings.width) * u64::from(settings.height);
        let patience = args.time.or(args.error.map(|_| PATIENCE));
        let deadline = patience.map(|time| start + time);
        let limited = args.error.is_some() || args.time.is_some();
        let default = (!limited).then_some(if self.setup.same_quantity { DEFAULT_SAMPLES } else { DEFAULT_SPP });
        // Samples of each pixel here.
        let share = if self.setup.same_quantity { pixels } else { u64::from(self.setup.parts) };
        let samples_requested = args.spp.or(default).map(|spp| u64::from(spp).div_ceil(share).max(1));
        let least = if self.setup.same_quantity { 1 } else { MIN_BATCHES };
        let mut plan = Plan { pixels, samples: 1, batches: u32::MAX, deadline, pilot_samples: 0, end: "done" };
        if !limited {
            let each = samples_requested.unwrap_or(1);
            plan.samples = power_of_two(each / u64::from(MIN_BATCHES)).min(MAX_SAMPLES);
            plan.batches = each.div_ceil(plan.samples.into()).clamp(least.into(), u32::MAX.into()) as u32;
            return Ok(plan);
        }
        let pilot_each = if self.setup.same_quantity { PILOT_SAMPLES } else { (PILOT_SAMPLES / 4).max(1) };
        let mut pilot = self.tally();
        self.batch = PILOT_FIRST;
        let paths_before = self.renderer.counts.paths;
        let began = Instant::now();
        for _ in 0..PILOT_BATCHES {
            self.trace(pilot_each, &mut pilot, None)?;
        }
        self.batch = 0;
        plan.pilot_samples = self.renderer.counts.paths - paths_before;
        let seconds_per_batch = began.elapsed().as_secs_f64() / f64::from(PILOT_BATCHES);
        plan.samples = pilot_each;
        let mut wanted = u64::from(u32::MAX); // batches
        if let Some(error) = args.error {
            let found = &pilot.estimates(self.setup.factor)[3];
            wanted = batches_for(&pilot, found, self.setup.factor, error, args.confidence);
        } else {
            // As many batches as there is time for keep the clock; few of more samples are better
            // stratified.
            let left = deadline.map_or(0.0, |d| (d - Instant::now().min(d)).as_secs_f64());
            let fits = (left / 32.0 / seconds_per_batch.max(1e-6)) as u64;
            plan.samples = power_of_two(fits).saturating_mul(pilot_each).min(MAX_SAMPLES);
        }
        if args.error.is_some() {
            while wanted >= 128 && plan.samples < MAX_SAMPLES {
                plan.samples *= 2;
                wanted = wanted.div_ceil(2);
            }
        }
        if let Some(samples_requested) = samples_requested {
            let most = samples_requested.div_ceil(plan.samples.into());
            if most < wanted {
                plan.end = if args.error.is_some() { "samples" } else { "done" };
                wanted = most;
            }
        }
        plan.batches = wanted.clamp(least.into(), u32::MAX.into()) as u32;
        Ok(plan)
    }

    /// Traces until the plan is done or the time is up; one batch at least (where pixels differ,
    /// two).
    fn carry_out(&mut self, plan: &Plan) -> Result<(Tally, &'static str), Error> {
        let mut tally = self.tally();
        let least = if self.setup.same_quantity { 1 } else { 2 };
        let began = Instant::now();
        let mut next = LOG_INTERVAL_SECONDS;
        while tally.batches() < plan.batches {
            let seconds = began.elapsed().as_secs_f64();
            if tally.batches() > 0 && seconds >= next {
                next = seconds + (seconds / 2.0).max(LOG_INTERVAL_SECONDS);
                plan.log_progress(tally.batches(), seconds);
            }
            let deadline = plan.deadline.filter(|_| tally.batches() >= least);
            if !self.trace(plan.samples, &mut tally, deadline)? || deadline.is_some_and(|d| Instant::now() >= d) {
                break;
            }
        }
        let stopped = match tally.batches() == plan.batches {
            true => plan.end,
            // With time alone, time is the target.
            false if plan.batches == u32::MAX && plan.end == "done" => "done",
            false => "time",
        };
        Ok((tally, stopped))
    }
}

/// Batches like the pilot's after which the interval is as narrow as requested, conservatively.
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

fn value(estimate: &Estimate, confidence: f64) -> Value {
    let known = estimate.dof >= 1.0 && estimate.variance.is_finite();
    // Without spread the degrees of freedom do not matter.
    let dof = if estimate.dof.is_finite() { estimate.dof } else { 1e9 };
    let half_width = known.then(|| student_t_half_width(confidence, estimate.variance.sqrt(), dof));
    Value { value: estimate.mean, half_width }
}

fn place(args: &MeasureArgs) -> String {
    let point = |p: [f64; 3]| format!("{},{},{}", p[0], p[1], p[2]);
    match (args.point, args.direction, args.irradiance, args.normal, args.region) {
        (Some(p), Some(d), ..) => format!("at {} from the direction {}", point(p), point(d)),
        (_, _, Some(p), Some(n), _) => format!("at {} on a surface facing {}", point(p), point(n)),
        (.., Some([x0, y0, x1, y1])) => format!("of the pixels {x0},{y0} to {x1},{y1} (the latter outside)"),
        _ => String::new(),
    }
}
