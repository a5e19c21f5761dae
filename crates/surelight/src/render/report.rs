//! The summary of a render that has ended.

use surelight_film::{Convergence, Precision};
use surelight_render::Outcome;

use crate::method::word;
use crate::parse::{Format, OutputPath};
use crate::progress::mega_rate;
use crate::stopping::Bound;
use crate::summary::{Adapter, Intervals, Provisional, RelativeError, Stop, Summary};

use super::Finished;

impl Finished<'_> {
    /// What goes to the user.
    pub(super) fn summary(self) -> Summary {
        let info = &self.device.info;
        let mut warnings = self.loaded.warnings.clone();
        let before = &self.record.before;
        let truncated = before.truncated + self.counts.truncated;
        if truncated > 0 {
            warnings.push(format!(
                "{} rays hit so many boxes of the BVH that they were cut short; their light is missing",
                truncated
            ));
        }
        Summary {
            version: env!("CARGO_PKG_VERSION"),
            scene: self.args.scene.name().display().to_string(),
            outputs: self.outputs.iter().map(OutputPath::name).collect(),
            extendable: self.outputs.iter().any(|output| output.format == Format::Exr && !output.is_stdout()),
            width: self.film.width(),
            height: self.film.height(),
            adapter: Adapter {
                name: info.name.clone(),
                driver: info.driver.clone(),
                backend: info.backend.clone(),
                software: info.is_cpu,
            },
            spp: self.spp(),
            resumed_spp: self.resumed_spp,
            resumed_from: self.resumed_from.clone(),
            target_spp: self.target_spp(),
            crop: self.record.beginning().crop,
            sample_range: [self.state.first, self.state.next],
            checkpoint: self.checkpoint.as_ref().map(|path| path.display().to_string()),
            pixel_samples: self.pixel_samples(),
            paths: before.paths + self.counts.paths,
            rays: before.rays + self.counts.rays,
            shared_paths: self.record.reuses_paths(),
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
            integrator: word(self.method.integrator),
            choice: self.choice.clone(),
            relative_error: self.film.error_summary().map(|e| RelativeError::new(e, self.record.one_sequence)),
            intervals: self.intervals(),
            dropped_samples: self.record.dropped(&self.counts),
            truncated_rays: truncated,
            biased: self.record.biased().to_vec(),
            exposure: self.exposed.auto,
            exposure_hint: self.exposed.hint,
            peak_device_bytes: self.device_bytes,
            warnings,
        }
    }

    /// The smallest and the largest number of samples of a pixel.
    fn pixel_samples(&self) -> [u64; 2] {
        let samples = || (0..self.film.pixels().len()).map(|i| self.film.samples(i));
        [samples().min().unwrap_or(0), samples().max().unwrap_or(0)]
    }

    /// The guarantee of the error bars.
    fn intervals(&self) -> Intervals {
        let stop = &self.args.stop;
        let precision =
            Precision { error: stop.error.unwrap_or(0.0), confidence: stop.confidence(), bound: stop.bound() };
        let certificate = self.film.certify();
        let Convergence { half_width, certified } = precision.reach(&self.film, &certificate);
        let finite = |half_width: f64| (half_width < f64::INFINITY).then_some(half_width);
        let chosen = certificate.provisional.iter().zip(&certificate.reachable).map(|(&light, &r)| light && r);
        let provisional = finite(precision.half_width(&self.film, &chosen.collect::<Vec<_>>(), &certificate.reachable));
        Intervals {
            certified,
            provisional: provisional
                .map(|half_width| Provisional { share: certificate.provisional_share(), half_width }),
            confidence: precision.confidence,
            bound: word(stop.bound.unwrap_or(Bound::Clt)),
            half_width: finite(half_width),
            target: stop.error,
        }
    }

    /// Samples per pixel in the film.
    fn spp(&self) -> u64 {
        (self.state.next - self.state.first).into()
    }

    /// Samples per pixel that were requested.
    fn target_spp(&self) -> Option<u32> {
        self.goal.end.or(self.goal.spp).map(|end| end - self.state.first)
    }
}
