//! What a render tells when it ends, for people and for programs.

use std::fmt::{self, Display};

use serde::Serialize;
use surelight_film::{CERTIFIED_SHARE, ErrorSummary, LEAST_SAMPLES};

use crate::exposure::{Automatic, Hint};
use crate::progress::Significant;

/// The summary of a render; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
pub(crate) struct Summary {
    /// Version of Surelight.
    pub(crate) version: &'static str,
    /// The scene as it was given.
    pub(crate) scene: String,
    /// Files written.
    pub(crate) outputs: Vec<String>,
    /// Pixels a row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Who did the work.
    pub(crate) adapter: Adapter,
    /// Samples a pixel.
    pub(crate) spp: u64,
    /// Of these, the ones that an earlier run did.
    pub(crate) resumed_spp: u32,
    /// Part of the image, as x0, y0, x1, y1 with the last two outside; `null`: the whole.
    pub(crate) crop: Option<[u32; 4]>,
    /// The first sample and the one after the last.
    pub(crate) sample_range: [u32; 2],
    /// The file that `--resume` goes on from; `null` where the goal is met.
    pub(crate) checkpoint: Option<String>,
    /// Samples a pixel that were asked for; `null` where time alone decided.
    pub(crate) target_spp: Option<u32>,
    /// The fewest and the most samples of a pixel: `spp` both, unless `--adaptive` puts them where noise is.
    pub(crate) pixel_samples: [u64; 2],
    /// Camera paths, one for each sample.
    pub(crate) paths: u64,
    /// Rays traced for them, shadow rays included.
    pub(crate) rays: u64,
    /// Whether the four pixels of each 2×2 square used one another's.
    pub(crate) shared_paths: bool,
    /// Seed of the samples.
    pub(crate) seed: u32,
    /// Why it ended.
    pub(crate) stopped: Stop,
    /// Seconds by stage.
    pub(crate) seconds: Seconds,
    /// Million rays in a second of tracing.
    pub(crate) mrays_per_second: f64,
    /// Million camera paths in a second of tracing.
    pub(crate) mpaths_per_second: f64,
    /// The integrator that rendered.
    pub(crate) integrator: String,
    /// Why `--integrator auto` chose it; `null` where the user did.
    pub(crate) choice: Option<String>,
    /// Error of the image; `null` below two batches or where all is black.
    pub(crate) relative_error: Option<RelativeError>,
    /// What the error bars promise.
    pub(crate) intervals: Intervals,
    /// Samples that were not finite and were left out.
    pub(crate) dropped_samples: u64,
    /// Rays that were given up, their samples incomplete.
    pub(crate) truncated_rays: u64,
    /// Options in force that bias the picture, and light that no path finds.
    pub(crate) biased: Vec<String>,
    /// Exposure of the PNG, where it follows from the picture.
    pub(crate) exposure: Option<Automatic>,
    /// What another exposure of the PNG would bring out.
    pub(crate) exposure_hint: Option<Hint>,
    /// Bytes held on the device; all of them at once.
    pub(crate) peak_device_bytes: u64,
    /// What was not as written, or decided without being asked.
    pub(crate) warnings: Vec<String>,
}

/// The adapter that rendered.
#[derive(Debug, Serialize)]
pub(crate) struct Adapter {
    pub(crate) name: String,
    pub(crate) driver: String,
    pub(crate) backend: String,
    pub(crate) software: bool,
}

/// Seconds by stage, and from start to end.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    /// Reading the scene and its environment.
    pub(crate) load: f64,
    /// Opening the device.
    pub(crate) device: f64,
    /// Building the BVH, the lights and the textures, and composing and compiling the kernel beside them.
    pub(crate) bvh: f64,
    /// Uploading the scene, and the kernel of the first hits; all of compilation where the kernel turned out to be another.
    pub(crate) compile: f64,
    /// Deciding where samples go, with `--adaptive`.
    pub(crate) adapt: f64,
    /// Tracing.
    pub(crate) trace: f64,
    /// Albedo, normal and depth of first hits.
    pub(crate) features: f64,
    /// Writing the images.
    pub(crate) write: f64,
    /// Everything.
    pub(crate) total: f64,
}

/// Standard error over mean, in luminance, over the pixels that are not black.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct RelativeError {
    /// Mean over pixels.
    pub(crate) mean: f64,
    /// What 95 % of the pixels stay below.
    pub(crate) percentile_95: f64,
    /// Whether these are upper bounds: all points of a pixel are then of one sequence, and batches make up for each other.
    pub(crate) upper_bound: bool,
}

impl RelativeError {
    /// What a film's batches tell of its error; `one_sequence`: they are not independent.
    pub(crate) fn new(error: ErrorSummary, one_sequence: bool) -> Self {
        Self { mean: error.mean, percentile_95: error.percentile_95, upper_bound: one_sequence }
    }
}

impl Display for RelativeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let at_most = if self.upper_bound { "at most " } else { "" };
        let (mean, most) = (Percent(self.mean), Percent(self.percentile_95));
        write!(f, "{at_most}{mean} mean, {most} at the 95th percentile (standard error of a pixel's luminance)")
    }
}

/// The intervals of certified pixels, in luminance.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Intervals {
    /// Share of the pixels that are certified.
    pub(crate) certified: f64,
    /// Confidence of each interval.
    pub(crate) confidence: f64,
    /// What makes an interval of a standard error.
    pub(crate) bound: String,
    /// Relative half-width that nine tenths of the certified pixels stay within; `null` where none is certified.
    pub(crate) half_width: Option<f64>,
    /// The half-width asked for.
    pub(crate) target: Option<f64>,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Stop {
    /// Every target was met.
    Done,
    /// `--time` was up before `--spp`.
    Time,
    /// The most samples that it may take did not bring the error asked for.
    Samples,
    /// Ctrl-C.
    Interrupt,
}

impl Summary {
    /// One JSON object on one line.
    pub(crate) fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let s = &self.seconds;
        write!(f, "image     {} ({}x{}", self.outputs.join(", "), self.width, self.height)?;
        match self.crop {
            Some([x, y, ..]) => writeln!(f, " at {x},{y})")?,
            None => writeln!(f, ")")?,
        }
        writeln!(f, "adapter   {}, {}, driver {}", self.adapter.name, self.adapter.backend, self.adapter.driver)?;
        write!(f, "samples   {} a pixel", self.spp)?;
        if let [least, most] = self.pixel_samples
            && least < most
        {
            write!(f, ", {least} to {most} by noise")?;
        }
        match (self.stopped, self.target_spp) {
            (Stop::Done, _) => {}
            (Stop::Time, target) => write!(f, "{} when the time was up", Of(target))?,
            (Stop::Samples, _) => write!(f, ", the most it may take, and the error is not what was asked for")?,
            (Stop::Interrupt, target) => write!(f, "{} when interrupted", Of(target))?,
        }
        if self.resumed_spp > 0 {
            write!(f, ", {} of them from a checkpoint", self.resumed_spp)?;
        }
        if self.sample_range[0] > 0 {
            write!(f, " (from {} on)", self.sample_range[0])?;
        }
        let shared = if self.shared_paths { ", shared by 2×2 pixels" } else { "" };
        writeln!(f, "; {} paths{shared}, {} rays", Count(self.paths), Count(self.rays))?;
        writeln!(
            f,
            "seconds   load {:.2}, device {:.2}, BVH {:.2}, compile {:.2}, trace {:.2}, write {:.2}; {:.2} in all",
            s.load,
            s.device,
            s.bvh,
            s.compile,
            s.trace + s.features,
            s.write,
            s.total
        )?;
        writeln!(
            f,
            "speed     {:.3} Mpaths/s, {:.3} Mrays/s",
            Significant(self.mpaths_per_second),
            Significant(self.mrays_per_second)
        )?;
        if let Some(choice) = &self.choice {
            writeln!(f, "method    {}: {choice}", self.integrator)?;
        }
        match self.relative_error {
            Some(error) => writeln!(f, "error     {error}")?,
            None if self.spp < 2 => writeln!(f, "error     unknown: it takes two samples a pixel to tell")?,
            None => writeln!(f, "error     unknown: the image is black")?,
        }
        writeln!(f, "certified {}", self.intervals)?;
        if let Some(checkpoint) = &self.checkpoint {
            writeln!(f, "go on     --resume, from {checkpoint}")?;
        }
        writeln!(f, "memory    {} MiB on the device at most", self.peak_device_bytes.div_ceil(1 << 20))?;
        if self.dropped_samples > 0 {
            writeln!(f, "dropped   {} samples that were not finite", self.dropped_samples)?;
        }
        if !self.biased.is_empty() {
            writeln!(f, "biased    {}", self.biased.join(", "))?;
        }
        if let Some(exposure) = &self.exposure {
            writeln!(f, "picture   {exposure}")?;
        }
        if let Some(hint) = &self.exposure_hint {
            writeln!(f, "hint      {hint}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning   {warning}")?;
        }
        Ok(())
    }
}

impl Display for Intervals {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(half_width) = self.half_width else {
            return write!(
                f,
                "no pixel: it takes {LEAST_SAMPLES} samples, and light that does not come by rare, bright ones"
            );
        };
        let (share, confidence) = (Percent(self.certified), Percent(self.confidence));
        write!(
            f,
            "{share} of the pixels; nine tenths of these within {} at {confidence} confidence",
            Percent(half_width)
        )?;
        match self.target {
            None => Ok(()),
            Some(target) if half_width > target => write!(f, ", where {} was asked for", Percent(target)),
            Some(_) if self.certified < CERTIFIED_SHARE => {
                write!(f, ", but half of the pixels must be: the light of the others comes by rare, bright samples")
            }
            Some(target) => write!(f, ", as asked for ({})", Percent(target)),
        }
    }
}

/// " of 64", or nothing.
struct Of(Option<u32>);

impl Display for Of {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |target| write!(f, " of {target}"))
    }
}

/// A share, in percent.
pub(crate) struct Percent(pub(crate) f64);

impl Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.2} %", Significant(self.0 * 100.0))
    }
}

/// "1024", "3.69 million".
struct Count(u64);

impl Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            count @ 0..100_000 => write!(f, "{count}"),
            count => write!(f, "{:.3} million", Significant(count as f64 / 1e6)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary() -> Summary {
        Summary {
            version: "0.1.0",
            scene: "box.glb".into(),
            outputs: vec!["box.png".into(), "box.exr".into()],
            width: 640,
            height: 480,
            adapter: Adapter {
                name: "llvmpipe".into(),
                driver: "Mesa".into(),
                backend: "Vulkan".into(),
                software: true,
            },
            spp: 12,
            resumed_spp: 4,
            crop: Some([8, 2, 648, 482]),
            sample_range: [0, 12],
            checkpoint: Some("box.checkpoint.exr".into()),
            target_spp: Some(64),
            paths: 3_686_400,
            pixel_samples: [64, 64],
            rays: 20_000_000,
            shared_paths: true,
            seed: 0,
            stopped: Stop::Time,
            seconds: Seconds { trace: 2.0, total: 2.5, ..Seconds::default() },
            mrays_per_second: 10.0,
            mpaths_per_second: 1.8432,
            integrator: "mis".into(),
            choice: None,
            intervals: Intervals {
                certified: 0.987,
                confidence: 0.95,
                bound: "clt".into(),
                half_width: Some(0.0512),
                target: None,
            },
            relative_error: Some(RelativeError { mean: 0.0312, percentile_95: 0.0981, upper_bound: false }),
            dropped_samples: 3,
            truncated_rays: 0,
            biased: vec!["max-radiance 10".into()],
            exposure: None,
            exposure_hint: None,
            peak_device_bytes: 1,
            warnings: vec!["the file has no light".into()],
        }
    }

    #[test]
    fn the_summary_reads_well() {
        let text = summary().to_string();
        for line in [
            "image     box.png, box.exr (640x480 at 8,2)\n",
            "go on     --resume, from box.checkpoint.exr\n",
            "samples   12 a pixel of 64 when the time was up, 4 of them from a checkpoint; 3.69 million paths, shared by 2×2 pixels, 20.0 million rays\n",
            "speed     1.84 Mpaths/s, 10.0 Mrays/s\n",
            "error     3.1 % mean, 9.8 % at the 95th percentile",
            "certified 99 % of the pixels; nine tenths of these within 5.1 % at 95 % confidence\n",
            "memory    1 MiB on the device at most\n",
            "dropped   3 samples that were not finite\n",
            "biased    max-radiance 10\n",
            "warning   the file has no light\n",
        ] {
            assert!(text.contains(line), "{line:?} is not in\n{text}");
        }
    }

    #[test]
    fn the_json_is_one_object_on_one_line() {
        let text = summary().json().unwrap();
        assert_eq!(text.lines().count(), 1);
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["stopped"], "time");
        assert_eq!(value["seconds"]["trace"], 2.0);
        assert_eq!(value["relative_error"]["percentile_95"], 0.0981);
    }
}
