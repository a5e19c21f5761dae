//! The metadata of a render in its files: of a checkpoint, a part and the finished image.

use surelight_film::settings::{Camera, Environment, Lens, Projection};
use surelight_film::{Film, Metadata, RenderPart, RenderSettings, Window};
use surelight_render::{Counts, Device, ResumeState};
use surelight_scene as scene;

use crate::fingerprint;
use crate::method::{Directions, MethodArgs};
use crate::options::{Clip, LightArgs, RenderArgs};

use super::prepare::Loaded;

/// The record of a render before its first sample, and that of its earlier runs.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// Its metadata, but for samples.
    base: Metadata,
    /// What earlier runs of it did.
    pub(super) before: RenderPart,
    dropped_before: u64,
    /// Whether points of a pixel are of one sequence, those of an earlier run at least: batches
    /// then compensate one another, and the estimated variance is an upper bound.
    pub(super) one_sequence: bool,
}

impl Record {
    pub(super) fn new(
        args: &RenderArgs,
        method: &MethodArgs,
        loaded: &Loaded,
        device: &Device,
        kernel: &str,
        shared_paths: bool,
        window: Window,
    ) -> Self {
        let part = RenderPart {
            size: window.whole,
            planned_samples: args.planned().map(u64::from),
            asked_samples: args.parts.samples.map(|samples| samples.map(u64::from)),
            kernel: fingerprint::of_text(kernel),
            ..RenderPart::default()
        };
        let base = Metadata {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene_hash: loaded.scene_hash.clone(),
            settings: Some(settings(args, method, loaded, shared_paths)),
            seed: args.seed.into(),
            crop: (!window.is_all()).then(|| window.edges()),
            device: device.info.name.clone(),
            driver: device.info.driver.clone(),
            biased: biased(args, method, loaded),
            part: Some(part),
            ..Metadata::default()
        };
        Self { base, before: RenderPart::default(), dropped_before: 0, one_sequence: args.is_one_sequence() }
    }

    /// As a render that has just begun says it.
    pub(super) fn beginning(&self) -> &Metadata {
        &self.base
    }

    /// Continues the record of earlier runs, `paths` in all; `extends`: with more samples than they
    /// planned.
    pub(super) fn after(&mut self, earlier: &Metadata, paths: u64, extends: bool) {
        self.one_sequence |= earlier.has_one_sequence();
        self.base.extended_from.clone_from(&earlier.extended_from);
        if extends {
            self.base.extended_from.push(earlier.sample_range[1]);
        }
        self.before = earlier.part.clone().unwrap_or_else(|| RenderPart { paths, ..RenderPart::default() });
        self.dropped_before = earlier.dropped_samples;
    }

    /// Samples that were left out, in all runs.
    pub(super) fn dropped(&self, counts: &Counts) -> u64 {
        self.dropped_before + counts.dropped
    }

    /// Whether pixels use one another's paths.
    pub(super) fn reuses_paths(&self) -> bool {
        self.base.reuses_paths()
    }

    /// Options in force that make the expected image another than the true one.
    pub(super) fn biased(&self) -> &[String] {
        &self.base.biased
    }

    /// The metadata of a file; `part`: whether a render can continue from it, or it can be merged
    /// with others.
    pub(super) fn metadata(&self, film: &Film, state: &ResumeState, counts: &Counts, part: bool) -> Metadata {
        let part = self.base.part.as_ref().filter(|_| part).map(|base| RenderPart {
            next_batch: state.batch,
            pilot: state.pilot,
            paths: self.before.paths + counts.paths,
            rays: self.before.rays + counts.rays,
            truncated: self.before.truncated + counts.truncated,
            seconds: self.before.seconds + counts.trace_seconds,
            ..base.clone()
        });
        Metadata {
            sample_range: [state.first.into(), state.next.into()],
            batches: film.degrees_of_freedom(0).round() as u32 + 1,
            dropped_samples: self.dropped(counts),
            part,
            ..self.base.clone()
        }
    }
}

fn biased(args: &RenderArgs, method: &MethodArgs, loaded: &Loaded) -> Vec<String> {
    let integrator = method.bias(&loaded.scene);
    let bounces = args.max_bounces.0.map(|n| format!("max-bounces {n}"));
    let clamp = args.max_radiance.map(|x| format!("max-radiance {x}"));
    integrator.into_iter().chain(bounces).chain(clamp).chain(loaded.missing.iter().cloned()).collect()
}

/// The settings that decide the image.
fn settings(args: &RenderArgs, method: &MethodArgs, loaded: &Loaded, path_reuse: bool) -> RenderSettings {
    let view = &loaded.view;
    RenderSettings {
        version: RenderSettings::VERSION,
        scene: args.scene.name().display().to_string(),
        size: [view.size.width, view.size.height],
        camera: camera(&view.camera),
        unclipped: args.camera.clip == Clip::Off,
        lens: view.lens.map(|lens| Lens { aperture: lens.aperture, focus: lens.focus }),
        environment: environment(&args.light, loaded),
        max_bounces: args.max_bounces.0,
        integrator: method.integrator.recorded(),
        directions: method.directions_in_force().map(Directions::recorded),
        sampler: method.sampler.recorded(),
        one_sequence: args.is_one_sequence(),
        path_reuse,
        adaptive: args.adaptive,
        transparent: args.transparent,
        multiple_scattering: args.multiple_scattering,
        max_radiance: args.max_radiance,
        precision: args.stop.precision(),
    }
}

fn camera(camera: &scene::Camera) -> Camera {
    Camera {
        name: camera.name.clone(),
        to_world: camera.to_world.to_cols_array(),
        projection: match camera.projection {
            scene::Projection::Perspective { yfov, aspect } => Projection::Perspective { yfov, aspect },
            scene::Projection::Orthographic { xmag, ymag } => Projection::Orthographic { xmag, ymag },
        },
    }
}

fn environment(args: &LightArgs, loaded: &Loaded) -> Environment {
    match (&args.env, loaded.sky()) {
        (Some(file), _) => Environment::Map {
            file: file.display().to_string(),
            rotation: args.env_rotation(),
            scale: args.env_scale(),
        },
        (None, Some(radiance)) => Environment::Uniform { radiance },
        (None, None) => Environment::Scene,
    }
}
