//! Renderers of the methods, made on demand and kept while memory allows; and progressive renders
//! of a given length.

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::time::Instant;

use surelight_film::Film;
use surelight_prepare::{Batches, Prepared, Settings};
use surelight_render::{
    BatchSizes, Counts, Device, End, FinishedPass, NextPass, PassVisitor, Position, RenderError, Renderer, Schedule,
    sample,
};
use surelight_scene::{Camera, Scene};

use crate::{
    conditions::{cpu_seconds, threads},
    data::Clock,
    method::Method,
};

/// A scene with its view, ready for a race.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Short name.
    pub name: String,
    /// The path of the file, as given.
    pub file: String,
    /// Hash of everything that affects the picture.
    pub hash: String,
    /// The scene.
    pub scene: Scene,
    /// The camera.
    pub camera: Camera,
    /// Size, lens and seed; each method sets the rest.
    pub settings: Settings,
    /// Seconds of loading.
    pub load_seconds: f64,
    /// Warnings of the import.
    pub warnings: Vec<String>,
}

/// The cost of a method's setup.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Setup {
    pub(crate) prepare_seconds: f64,
    pub(crate) compile_seconds: f64,
    pub(crate) device_bytes: u64,
    pub(crate) triangles: u64,
    /// Whether the method reuses paths.
    pub(crate) reuses_paths: bool,
}

/// Maximum bytes on the device of renderers that are kept.
const KEPT_BYTES: u64 = 3 << 30;

/// The renderers of one scene.
pub(crate) struct Tracers<'a> {
    device: &'a Device,
    subject: &'a Subject,
    kept: Vec<(Method, Renderer<'a>)>,
}

impl<'a> Tracers<'a> {
    pub(crate) fn new(device: &'a Device, subject: &'a Subject) -> Self {
        Self { device, subject, kept: Vec::new() }
    }

    /// Makes the renderer of a method, and returns the cost.
    pub(crate) fn set_up(&mut self, method: &Method) -> Result<Setup, RenderError> {
        let started = Instant::now();
        let Subject { scene, camera, settings, .. } = self.subject;
        let prepared = Prepared::new(scene, camera, &method.settings(settings))?;
        let prepare_seconds = started.elapsed().as_secs_f64();
        let triangles = prepared.accel.triangles.len() as u64;
        let biggest = self.kept.iter().map(|(_, r)| r.device_bytes).max().unwrap_or(0);
        if self.kept.iter().map(|(_, r)| r.device_bytes).sum::<u64>() + biggest > KEPT_BYTES {
            self.kept.clear();
        }
        let renderer = Renderer::new(self.device, &prepared)?;
        let setup = Setup {
            prepare_seconds,
            compile_seconds: renderer.compile_seconds,
            device_bytes: renderer.device_bytes,
            triangles,
            reuses_paths: renderer.key().reuses_paths(),
        };
        self.kept.push((*method, renderer));
        Ok(setup)
    }

    /// The renderer of a method.
    pub(crate) fn of(&mut self, method: &Method) -> Result<&mut Renderer<'a>, RenderError> {
        let found = self.kept.iter().position(|(kept, _)| kept == method);
        let index = match found {
            Some(index) => index,
            None => {
                self.set_up(method)?;
                self.kept.len() - 1
            }
        };
        Ok(&mut self.kept[index].1)
    }
}

/// A progressive render.
pub(crate) struct Run {
    pub(crate) film: Film,
    first: Position,
    /// The next batch.
    position: Position,
    /// With one sequence per pixel: the seed that makes this stream's samples independent.
    seed: Option<u32>,
    /// Whether the method reuses paths.
    pub(crate) reuses_paths: bool,
    begun: Counts,
    /// Work done so far.
    pub(crate) counts: Counts,
    clock: RunClock,
}

/// Batch numbers per repeat, which make its samples independent: a run has some hundreds.
const BATCHES_PER_REPEAT: u32 = 1 << 16;

/// The distance between the seeds of streams: an odd number near 2³²/φ, so that no two coincide.
const SEED_STEP: u32 = 0x9e37_79b1;

/// Approximate seconds of a pass: Ctrl-C takes effect in between.
const PASS_SECONDS: f64 = 1.0;

impl Run {
    /// An empty render; each `stream` has independent samples.
    pub(crate) fn new(settings: &Settings, stream: u32, renderer: &Renderer<'_>) -> Self {
        let key = renderer.key();
        let first = Position { sample: 0, batch: stream * BATCHES_PER_REPEAT };
        Self {
            film: Film::new(settings.width, settings.height),
            first,
            position: first,
            seed: key.is_one_sequence().then(|| settings.seed.wrapping_add(stream.wrapping_mul(SEED_STEP))),
            reuses_paths: key.reuses_paths(),
            begun: renderer.counts,
            counts: Counts::default(),
            clock: RunClock { wall_seconds: 0.0, cpu_seconds: Some(0.0) },
        }
    }

    /// Samples per pixel so far.
    pub(crate) fn spp(&self) -> u32 {
        self.position.sample
    }

    /// Batches so far.
    pub(crate) fn batches(&self) -> u32 {
        self.position.batch - self.first.batch
    }

    /// CPU seconds so far, divided by the number of cores.
    pub(crate) fn cpu_seconds(&self) -> Option<f64> {
        self.clock.cpu_seconds
    }

    /// Wall-clock seconds so far.
    pub(crate) fn wall_seconds(&self) -> f64 {
        self.clock.wall_seconds
    }

    /// Seconds so far by a clock.
    pub(crate) fn seconds(&self, clock: Clock) -> f64 {
        match clock {
            Clock::Wall => self.clock.wall_seconds,
            Clock::Device => self.counts.device_seconds,
            Clock::Cpu => self.clock.cpu_seconds.unwrap_or(self.clock.wall_seconds),
        }
    }

    /// Continues to `spp` samples per pixel, in batches that grow or of the length given. Returns
    /// false when `go_on` stopped it: the film then has fewer.
    pub(crate) fn grow_to(
        &mut self,
        renderer: &mut Renderer<'_>,
        spp: u32,
        length: Option<u32>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<bool, RenderError> {
        if let Some(seed) = self.seed {
            renderer.set_seed(seed);
        }
        let growing = BatchSizes::Planned(Batches { planned: None });
        let schedule = Schedule { sizes: length.map_or(growing, BatchSizes::Equal), end: Some(spp) };
        let mut timed = TimedPasses { clock: &mut self.clock, cpu_before: None, go_on };
        match sample(renderer, &mut self.film, schedule, &mut self.position, &mut timed)? {
            End::Complete => {
                self.counts = renderer.counts.since(&self.begun);
                Ok(true)
            }
            End::Stopped(never) => match never {},
            End::Interrupted => Ok(false),
        }
    }
}

/// The time that finished passes took.
struct RunClock {
    wall_seconds: f64,
    cpu_seconds: Option<f64>,
}

/// Measures the time of passes, and keeps them short.
struct TimedPasses<'p> {
    clock: &'p mut RunClock,
    cpu_before: Option<f64>,
    go_on: &'p mut dyn FnMut() -> bool,
}

impl PassVisitor for TimedPasses<'_> {
    type Stop = Infallible;

    fn before_pass(&mut self, next: &NextPass, _: &Counts) -> ControlFlow<Infallible, u32> {
        self.cpu_before = cpu_seconds();
        let done = next.position.sample;
        let cost = if done > 0 { self.clock.wall_seconds / f64::from(done) } else { f64::INFINITY };
        ControlFlow::Continue((PASS_SECONDS / (cost * f64::from(next.samples))) as u32)
    }

    fn after_dispatch(&mut self, _: &Counts) -> bool {
        (self.go_on)()
    }

    fn after_pass(&mut self, _: &mut Film, pass: &FinishedPass, _: &Counts) -> ControlFlow<Infallible> {
        self.clock.wall_seconds += pass.seconds;
        self.clock.cpu_seconds = match (self.clock.cpu_seconds, self.cpu_before, cpu_seconds()) {
            (Some(sum), Some(before), Some(after)) => Some(sum + (after - before).max(0.0) / threads() as f64),
            _ => None,
        };
        ControlFlow::Continue(())
    }
}
