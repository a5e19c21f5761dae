//! Renderers of the methods, made when they are needed and kept while memory allows; and progressive renders of a given length.

use std::time::Instant;

use surelight_film::Film;
use surelight_render::{Counts, Device, Prepared, RenderError, Renderer, Settings};
use surelight_scene::{Camera, Scene};

use crate::{
    conditions::{cpu_seconds, threads},
    data::Clock,
    method::Method,
};

/// A scene with its view, ready to be raced on.
#[derive(Clone, Debug)]
pub struct Subject {
    /// Short name.
    pub name: String,
    /// The file as it was given.
    pub file: String,
    /// Hash of everything that shows.
    pub hash: String,
    /// The scene.
    pub scene: Scene,
    /// The camera.
    pub camera: Camera,
    /// Size, lens and seed; the method's parts are set for each method.
    pub settings: Settings,
    /// Seconds it took to read.
    pub load_seconds: f64,
    /// What was told when it was read.
    pub warnings: Vec<String>,
}

/// What setting up a method took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Setup {
    pub(crate) prepare_seconds: f64,
    pub(crate) compile_seconds: f64,
    pub(crate) device_bytes: u64,
    pub(crate) triangles: u64,
    /// Whether pixels use one another's paths.
    pub(crate) shares_paths: bool,
}

/// Bytes on the device up to which renderers are kept.
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

    /// Makes the renderer of a method, and tells what that took.
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
            shares_paths: renderer.key().reuses_paths(),
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

/// A render that grows.
pub(crate) struct Run {
    pub(crate) film: Film,
    pub(crate) spp: u32,
    pub(crate) batches: u32,
    first_batch: u32,
    /// Where all points of a pixel are of one sequence: the seed that makes this stream's its own.
    seed: Option<u32>,
    /// Whether pixels use one another's paths.
    pub(crate) shares_paths: bool,
    begun: Counts,
    /// What has been done so far.
    pub(crate) counts: Counts,
    pub(crate) wall_seconds: f64,
    pub(crate) cpu_seconds: Option<f64>,
}

/// Batch numbers of a repeat, which make its samples its own: a run has some hundreds.
const BATCHES_A_REPEAT: u32 = 1 << 16;

/// Seeds of streams stand so far apart (an odd number near 2³²/φ, so that none meet).
const SEEDS_APART: u32 = 0x9e37_79b1;

/// Batches that an error bar needs.
const BATCHES: u32 = 16;

/// Sums on the device are f32: batches stay short.
const MOST_SAMPLES: u32 = 4096;

/// Seconds that one call of the renderer should take, about: Ctrl-C is heard in between.
const CALL_SECONDS: f64 = 1.0;

/// Samples of the next batch after `done` samples a pixel, as in a render whose length is not known before: 1/16 of what is done, so that there
/// are never fewer than 16 that count.
fn batch_samples(done: u32) -> u32 {
    let share = done / BATCHES;
    if share == 0 { 1 } else { (1 << share.ilog2()).min(MOST_SAMPLES) }
}

impl Run {
    /// An empty render; each `stream` has samples of its own.
    pub(crate) fn new(settings: &Settings, stream: u32, renderer: &Renderer<'_>) -> Self {
        Self {
            film: Film::new(settings.width, settings.height),
            spp: 0,
            batches: 0,
            first_batch: stream * BATCHES_A_REPEAT,
            seed: renderer
                .key()
                .is_one_sequence()
                .then(|| settings.seed.wrapping_add(stream.wrapping_mul(SEEDS_APART))),
            shares_paths: renderer.key().reuses_paths(),
            begun: renderer.counts,
            counts: Counts::default(),
            wall_seconds: 0.0,
            cpu_seconds: Some(0.0),
        }
    }

    /// Seconds so far by a clock.
    pub(crate) fn seconds(&self, clock: Clock) -> f64 {
        match clock {
            Clock::Wall => self.wall_seconds,
            Clock::Device => self.counts.device_seconds,
            Clock::Cpu => self.cpu_seconds.unwrap_or(self.wall_seconds),
        }
    }

    /// Goes on to `spp` samples a pixel, in batches that grow or of the length given. Returns false when `go_on` stopped it: the film is then
    /// somewhere before.
    pub(crate) fn grow_to(
        &mut self,
        renderer: &mut Renderer<'_>,
        spp: u32,
        length: Option<u32>,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<bool, RenderError> {
        while self.spp < spp {
            let samples = length.unwrap_or_else(|| batch_samples(self.spp)).min(spp - self.spp);
            // Batches of this length until they grow, or the end.
            let until = match length {
                Some(_) => spp,
                None => (2 * BATCHES * samples).max(self.spp + samples).min(spp),
            };
            let cost = if self.spp > 0 { self.wall_seconds / f64::from(self.spp) } else { f64::INFINITY };
            let fits =
                (CALL_SECONDS / (cost * f64::from(samples))).clamp(1.0, f64::from(renderer.max_batches())) as u32;
            let batches = ((until - self.spp) / samples).clamp(1, fits);
            let (wall, cpu) = (Instant::now(), cpu_seconds());
            // Batches of one sequence are known by their first sample.
            let first = if self.seed.is_some() { self.spp } else { self.first_batch + self.batches };
            if let Some(seed) = self.seed {
                renderer.set_seed(seed);
            }
            let done = renderer.trace(&mut self.film, first, batches, samples, &mut |_| go_on())?;
            if !done {
                return Ok(false);
            }
            self.wall_seconds += wall.elapsed().as_secs_f64();
            self.cpu_seconds = match (self.cpu_seconds, cpu, cpu_seconds()) {
                (Some(sum), Some(before), Some(after)) => Some(sum + (after - before).max(0.0) / threads() as f64),
                _ => None,
            };
            self.batches += batches;
            self.spp += batches * samples;
        }
        let (now, then) = (renderer.counts, self.begun);
        self.counts = Counts {
            rays: now.rays - then.rays,
            particles: now.particles - then.particles,
            paths: now.paths - then.paths,
            dropped: now.dropped - then.dropped,
            truncated: now.truncated - then.truncated,
            trace_seconds: now.trace_seconds - then.trace_seconds,
            device_seconds: now.device_seconds - then.device_seconds,
            read_seconds: now.read_seconds - then.read_seconds,
            film_seconds: now.film_seconds - then.film_seconds,
            dispatches: now.dispatches - then.dispatches,
        };
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_grow_with_what_is_done() {
        assert_eq!([0, 15, 31, 32, 63, 64, 1 << 20].map(batch_samples), [1, 1, 1, 2, 2, 4, 4096]);
    }

    #[test]
    fn every_checkpoint_can_be_reached_in_whole_batches() {
        for target in [1u32, 2, 4, 8, 16, 32, 64, 100, 128, 1000, 1 << 14] {
            let (mut done, mut batches) = (0, 0);
            while done < target {
                let samples = batch_samples(done).min(target - done);
                done += samples;
                batches += 1;
            }
            assert_eq!(done, target);
            assert!(batches <= target && (target < 16 || batches >= 16) && batches < 600, "{target}: {batches}");
        }
    }
}
