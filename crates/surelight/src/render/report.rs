//! What a finished render says of itself: in the EXR for later, in the summary for now.

use serde_json::{Map, Value, json};
use surelight_film::{Metadata, Precision, Reach};
use surelight_render::Outcome;

use crate::method::word;
use crate::progress::mega_rate;
use crate::stopping::Bound;
use crate::summary::{Adapter, Intervals, RelativeError, Stop, Summary};

use super::Finished;

impl Finished<'_> {
    /// What goes into the EXR.
    pub(super) fn metadata(&self) -> Metadata {
        Metadata {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene_hash: self.loaded.scene_hash.clone(),
            settings: self.settings(),
            seed: self.args.seed.into(),
            sample_range: [0, self.spp()],
            crop: None,
            batches: self.film.degrees_of_freedom(0).round() as u32 + 1,
            device: self.device.info.name.clone(),
            driver: self.device.info.driver.clone(),
            biased: self.biased(),
            dropped_samples: self.counts.dropped,
        }
    }

    /// What goes to the user.
    pub(super) fn summary(self) -> Summary {
        let info = &self.device.info;
        let mut warnings = self.loaded.warnings.clone();
        if self.counts.truncated > 0 {
            warnings.push(format!(
                "{} rays met so many boxes of the BVH that they were given up; what they would have found is missing",
                self.counts.truncated
            ));
        }
        Summary {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.args.scene.display().to_string(),
            outputs: self.outputs.iter().map(|output| output.path.display().to_string()).collect(),
            width: self.film.width(),
            height: self.film.height(),
            adapter: Adapter {
                name: info.name.clone(),
                driver: info.driver.clone(),
                backend: info.backend.clone(),
                software: info.is_cpu,
            },
            spp: self.spp(),
            target_spp: self.goal.spp,
            paths: self.counts.paths,
            rays: self.counts.rays,
            seed: self.args.seed,
            stopped: match self.outcome {
                Outcome::Done => Stop::Done,
                Outcome::TimeUp => Stop::Time,
                Outcome::SamplesUp => Stop::Samples,
                Outcome::Interrupted => Stop::Interrupt,
            },
            seconds: self.seconds,
            mrays_per_second: mega_rate(self.counts.rays, self.seconds.trace),
            mpaths_per_second: mega_rate(self.counts.paths, self.seconds.trace),
            tried: self.tried.clone(),
            relative_error: self.film.error_summary().map(RelativeError::from),
            intervals: self.intervals(),
            dropped_samples: self.counts.dropped,
            truncated_rays: self.counts.truncated,
            biased: self.biased(),
            peak_device_bytes: self.device_bytes,
            warnings,
        }
    }

    /// What the error bars promise.
    fn intervals(&self) -> Intervals {
        let stop = &self.args.stop;
        let precision =
            Precision { error: stop.error.unwrap_or(0.0), confidence: stop.confidence(), bound: stop.bound() };
        let Reach { half_width, certified } = precision.reach(&self.film, &self.film.certify());
        Intervals {
            certified,
            confidence: precision.confidence,
            bound: word(stop.bound.unwrap_or(Bound::Clt)),
            half_width: (half_width < f64::INFINITY).then_some(half_width),
            target: stop.error,
        }
    }

    /// Samples a pixel in the film.
    fn spp(&self) -> u64 {
        self.film.samples(0)
    }

    /// Options in force that make the expected image another than the true one.
    fn biased(&self) -> Vec<String> {
        let integrator = self.method.bias(&self.loaded.scene);
        let bounces = self.args.max_bounces.0.map(|n| format!("max-bounces {n}"));
        let clamp = self.args.max_radiance.map(|x| format!("max-radiance {x}"));
        integrator.into_iter().chain(bounces).chain(clamp).collect()
    }

    /// What shapes the picture, by the names of the options.
    fn settings(&self) -> Map<String, Value> {
        let (args, view) = (self.args, &self.loaded.view);
        let camera = json!({
            "name": view.camera.name,
            "to_world": view.camera.to_world.to_cols_array(),
            "projection": format!("{:?}", view.camera.projection),
        });
        let all = [
            ("scene", json!(args.scene.display().to_string())),
            ("width", json!(self.film.width())),
            ("height", json!(self.film.height())),
            ("max-bounces", args.max_bounces.0.map_or(json!("unlimited"), |n| json!(n))),
            ("camera", camera),
            ("aperture", json!(view.lens.map(|lens| lens.aperture))),
            ("focus", json!(view.lens.map(|lens| lens.focus))),
            ("env", json!(args.light.env.as_ref().map(|env| env.display().to_string()))),
            ("env-rotate", json!(args.light.env_rotate)),
            ("env-scale", json!(args.light.env_scale)),
            ("sky", json!(self.loaded.sky())),
            ("max-radiance", json!(args.max_radiance)),
            ("integrator", json!(word(self.method.integrator))),
            ("directions", json!(self.method.directions_in_force().map(word))),
            ("sampler", json!(word(self.method.sampler))),
            ("error", json!(args.stop.error)),
            ("confidence", json!(args.stop.error.map(|_| args.stop.confidence()))),
            ("bound", json!(args.stop.bound.map(word))),
        ];
        all.into_iter().filter(|(_, value)| !value.is_null()).map(|(name, value)| (name.to_owned(), value)).collect()
    }
}
