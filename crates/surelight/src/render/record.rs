//! What a render says of itself in its files: the same in a checkpoint, a part and the finished picture, as far as they go.

use serde_json::{Map, Value, json};
use surelight_film::{Film, Metadata, Part, SHARED_PATHS, TRANSPARENT, Window};
use surelight_render::{Counts, Device, Standing};

use crate::fingerprint;
use crate::method::{MethodArgs, word};
use crate::options::{Clip, RenderArgs};

use super::prepare::Loaded;

/// What is known of a render before its first sample; and what earlier runs of it did.
#[derive(Clone, Debug)]
pub(super) struct Record {
    /// Its metadata, but for samples.
    base: Metadata,
    /// What earlier runs of it did.
    pub(super) before: Part,
    dropped_before: u64,
    /// Whether points of a pixel are of one sequence, those of an earlier run at least: batches then
    /// compensate one another, and the estimated variance is an upper bound.
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
        let part = Part {
            size: window.whole,
            planned_samples: args.planned().map(u64::from),
            asked_samples: args.parts.samples.map(|samples| samples.map(u64::from)),
            kernel: fingerprint::of_text(kernel),
            ..Part::default()
        };
        let base = Metadata {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene_hash: loaded.scene_hash.clone(),
            settings: settings(args, method, loaded, shared_paths),
            seed: args.seed.into(),
            crop: (!window.is_all()).then(|| window.edges()),
            device: device.info.name.clone(),
            driver: device.info.driver.clone(),
            biased: biased(args, method, loaded),
            part: Some(part),
            ..Metadata::default()
        };
        Self { base, before: Part::default(), dropped_before: 0, one_sequence: args.is_one_sequence() }
    }

    /// As a render that has just begun says it.
    pub(super) fn beginning(&self) -> &Metadata {
        &self.base
    }

    /// Goes on with what earlier runs did, `paths` in all; `extends`: with more samples than they planned.
    pub(super) fn after(&mut self, earlier: &Metadata, paths: u64, extends: bool) {
        self.one_sequence |= earlier.settings.contains_key("scrambles");
        self.base.extended_from.clone_from(&earlier.extended_from);
        if extends {
            self.base.extended_from.push(earlier.sample_range[1]);
        }
        self.before = earlier.part.clone().unwrap_or_else(|| Part { paths, ..Part::default() });
        self.dropped_before = earlier.dropped_samples;
    }

    /// Samples that were left out, in all runs.
    pub(super) fn dropped(&self, counts: &Counts) -> u64 {
        self.dropped_before + counts.dropped
    }

    /// Whether pixels use one another's paths.
    pub(super) fn shares_paths(&self) -> bool {
        self.base.settings.contains_key(SHARED_PATHS)
    }

    /// Options in force that make the expected image another than the true one.
    pub(super) fn biased(&self) -> &[String] {
        &self.base.biased
    }

    /// What goes into a file; `part`: whether the render can go on from it, or it can be merged with others.
    pub(super) fn metadata(&self, film: &Film, standing: &Standing, counts: &Counts, part: bool) -> Metadata {
        let part = self.base.part.as_ref().filter(|_| part).map(|base| Part {
            next_batch: standing.batch,
            pilot: standing.pilot,
            paths: self.before.paths + counts.paths,
            rays: self.before.rays + counts.rays,
            truncated: self.before.truncated + counts.truncated,
            seconds: self.before.seconds + counts.trace_seconds,
            ..base.clone()
        });
        Metadata {
            sample_range: [standing.first.into(), standing.next.into()],
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

/// What shapes the picture, by the names of the options.
fn settings(args: &RenderArgs, method: &MethodArgs, loaded: &Loaded, shared_paths: bool) -> Map<String, Value> {
    let view = &loaded.view;
    let camera = json!({
        "name": view.camera.name,
        "to_world": view.camera.to_world.to_cols_array(),
        "projection": format!("{:?}", view.camera.projection),
    });
    let all = [
        ("scene", json!(args.scene.name().display().to_string())),
        ("width", json!(view.size.width)),
        ("height", json!(view.size.height)),
        ("max-bounces", args.max_bounces.0.map_or(json!("unlimited"), |n| json!(n))),
        ("camera", camera),
        ("aperture", json!(view.lens.map(|lens| lens.aperture))),
        ("focus", json!(view.lens.map(|lens| lens.focus))),
        ("clip", json!((args.camera.clip == Clip::Off).then(|| word(Clip::Off)))),
        ("env", json!(args.light.env.as_ref().map(|env| env.display().to_string()))),
        ("env-rotate", json!(args.light.env_rotate)),
        ("env-scale", json!(args.light.env_scale)),
        ("sky", json!(loaded.sky())),
        ("max-radiance", json!(args.max_radiance)),
        ("multiple-scattering", json!(args.multiple_scattering.then_some(true))),
        ("integrator", json!(word(method.integrator))),
        ("directions", json!(method.directions_in_force().map(word))),
        ("sampler", json!(word(method.sampler))),
        ("scrambles", json!(args.is_one_sequence().then_some(1))),
        (SHARED_PATHS, json!(shared_paths.then_some(true))),
        ("adaptive", json!(args.adaptive.then_some(true))),
        (TRANSPARENT, json!(args.transparent.then_some(true))),
        ("error", json!(args.stop.error)),
        ("confidence", json!(args.stop.error.map(|_| args.stop.confidence()))),
        ("bound", json!(args.stop.bound.map(word))),
    ];
    all.into_iter().filter(|(_, value)| !value.is_null()).map(|(name, value)| (name.to_owned(), value)).collect()
}
