//! The summary of a render, as text and as JSON.

use std::fmt::{self, Display};

use serde::Serialize;
use surelight_film::{CERTIFIED_SHARE, ErrorSummary, MIN_CERTIFIED_SAMPLES};

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
    /// Whether `--resume` can add samples: one of the files is an .exr.
    pub(crate) extendable: bool,
    /// Pixels a row.
    pub(crate) width: u32,
    /// Rows.
    pub(crate) height: u32,
    /// Who did the work.
    pub(crate) adapter: Adapter,
    /// Samples per pixel.
    pub(crate) spp: u64,
    /// Of these, the ones that an earlier run did.
    pub(crate) resumed_spp: u32,
    /// The source of these: a checkpoint, or a finished image; `null`: none.
    pub(crate) resumed_from: Option<String>,
    /// Part of the image, as x0, y0, x1, y1 with the last two outside; `null`: the whole.
    pub(crate) crop: Option<[u32; 4]>,
    /// The first sample and the one after the last.
    pub(crate) sample_range: [u32; 2],
    /// The file that `--resume` continues from; `null` where the goal is reached.
    pub(crate) checkpoint: Option<String>,
    /// Requested samples per pixel; `null` where time alone decided.
    pub(crate) target_spp: Option<u32>,
    /// Minimum and maximum samples of a pixel: both `spp`, unless `--adaptive` distributes them by
    /// noise.
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
    /// Million rays per second of tracing.
    pub(crate) mrays_per_second: f64,
    /// Million camera paths per second of tracing.
    pub(crate) mpaths_per_second: f64,
    /// The integrator that rendered.
    pub(crate) integrator: String,
    /// Why `--integrator auto` chose it; `null` where the user did.
    pub(crate) choice: Option<String>,
    /// Error of the image; `null` below two batches or where all is black.
    pub(crate) relative_error: Option<RelativeError>,
    /// The guarantee of the error bars.
    pub(crate) intervals: Intervals,
    /// Samples that were not finite and were left out.
    pub(crate) dropped_samples: u64,
    /// Rays that were cut short, their samples incomplete.
    pub(crate) truncated_rays: u64,
    /// Options in force that bias the picture, and light that no path finds.
    pub(crate) biased: Vec<String>,
    /// Exposure of the PNG, where it follows from the picture.
    pub(crate) exposure: Option<Automatic>,
    /// A hint at a better exposure of the PNG.
    pub(crate) exposure_hint: Option<Hint>,
    /// Bytes held on the device; all of them at once.
    pub(crate) peak_device_bytes: u64,
    /// Deviations from the file, and automatic decisions.
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
    /// Building the BVH, the lights and the textures, and composing and compiling the kernel beside
    /// them.
    pub(crate) bvh: f64,
    /// Uploading the scene, and the kernel of the first hits; all of compilation where the kernel
    /// turned out to be another.
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
    /// The 95th percentile.
    pub(crate) percentile_95: f64,
    /// Whether these are upper bounds: all points of a pixel are then of one sequence, and batches
    /// compensate each other.
    pub(crate) upper_bound: bool,
}

impl RelativeError {
    /// The error of a film by its batches; `one_sequence`: they are not independent.
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
    /// Of the pixels that light can reach, the share that is certified.
    pub(crate) certified: f64,
    /// The verdict of tails on the pixels so far, certified or not; `null` below 64 samples per
    /// pixel.
    pub(crate) provisional: Option<Provisional>,
    /// Confidence of each interval.
    pub(crate) confidence: f64,
    /// The bound that makes an interval of a standard error.
    pub(crate) bound: String,
    /// Relative half-width that nine tenths of the certified pixels stay within; `null` where none
    /// is certified.
    pub(crate) half_width: Option<f64>,
    /// The requested half-width.
    pub(crate) target: Option<f64>,
}

/// Pixels with a light tail so far.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Provisional {
    /// Their share of the pixels that light can reach.
    pub(crate) share: f64,
    /// Relative half-width that nine tenths of them stay within.
    pub(crate) half_width: f64,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Stop {
    /// Every target was reached.
    Done,
    /// `--time` was up before `--spp`.
    Time,
    /// The maximum number of samples did not reach the requested error.
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
    /// First the outputs and their quality, then the method.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for line in self.quality().into_iter().chain(self.remarks()).chain(self.work()) {
            writeln!(f, "{}", one_line(&line))?;
        }
        Ok(())
    }
}

impl Summary {
    /// At most four lines, for `--quiet`.
    pub(crate) fn short(&self) -> String {
        let quality = self.quality();
        // The verdict that says most is the last one.
        let lines = quality.iter().take(2).chain(quality.last().filter(|_| quality.len() > 2)).cloned();
        let remarks: Vec<String> = self
            .remarks()
            .iter()
            .map(|line| {
                line.split_once(char::is_whitespace).map_or(line.clone(), |(a, b)| format!("{a}: {}", b.trim_start()))
            })
            .collect();
        let remarks = (!remarks.is_empty()).then(|| format!("remarks   {}", remarks.join("; ")));
        lines.chain(remarks).map(|line| one_line(&line) + "\n").collect()
    }

    /// The outputs and their quality: the image, its noise, and the verdicts on its error bars.
    fn quality(&self) -> Vec<String> {
        let place = self.crop.map_or_else(String::new, |[x, y, ..]| format!(" at {x},{y}"));
        let noise = match self.relative_error {
            Some(error) => error.to_string(),
            None if self.spp < 2 => "unknown: an estimate takes two samples per pixel".to_owned(),
            None => "unknown: the image is black".to_owned(),
        };
        let mut lines = Vec::from([
            format!("image     {} ({}x{}{place})", self.outputs.join(", "), self.width, self.height),
            format!("noise     {noise}"),
        ]);
        lines.extend(self.intervals.verdict(self.spp, self.extendable));
        lines
    }

    /// Limits of the picture, and remedies.
    fn remarks(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(exposure) = &self.exposure {
            lines.push(format!("picture   {exposure}"));
        }
        if let Some(hint) = &self.exposure_hint {
            lines.push(format!("hint      {hint}"));
        }
        if !self.biased.is_empty() {
            lines.push(format!("biased    {}", self.biased.join(", ")));
        }
        if self.dropped_samples > 0 {
            lines.push(format!("dropped   {} samples that were not finite", self.dropped_samples));
        }
        if let Some(checkpoint) = &self.checkpoint {
            lines.push(format!("resume    --resume continues from {checkpoint}"));
        }
        lines.extend(self.warnings.iter().map(|warning| format!("warning   {warning}")));
        lines
    }

    /// How it was made.
    fn work(&self) -> Vec<String> {
        let s = &self.seconds;
        let mut lines = Vec::from([self.samples()]);
        if let Some(choice) = &self.choice {
            lines.push(format!("method    {}: {choice}", self.integrator));
        }
        lines.push(format!(
            "seconds   load {:.2}, device {:.2}, BVH {:.2}, compile {:.2}, trace {:.2}, write {:.2}; {:.2} in all",
            s.load,
            s.device,
            s.bvh,
            s.compile,
            s.trace + s.features,
            s.write,
            s.total
        ));
        let (mpaths, mrays) = (Significant(self.mpaths_per_second), Significant(self.mrays_per_second));
        lines.push(format!("speed     {mpaths:.3} Mpaths/s, {mrays:.3} Mrays/s"));
        let Adapter { name, backend, driver, .. } = &self.adapter;
        lines.push(format!("adapter   {name}, {backend}, driver {driver}"));
        lines.push(format!("memory    {} MiB on the device at most", self.peak_device_bytes.div_ceil(1 << 20)));
        lines
    }

    fn samples(&self) -> String {
        let mut line = format!("samples   {} per pixel", self.spp);
        if let [least, most] = self.pixel_samples
            && least < most
        {
            line += &format!(", {least} to {most} by noise");
        }
        line += &match (self.stopped, self.target_spp) {
            (Stop::Done, _) => String::new(),
            (Stop::Time, target) => format!("{} when the time was up", Of(target)),
            (Stop::Samples, _) => ", the maximum, before the error reached its target".to_owned(),
            (Stop::Interrupt, target) => format!("{} when interrupted", Of(target)),
        };
        if let Some(source) = &self.resumed_from {
            line += &format!(", {} of them from {source}", self.resumed_spp);
        }
        if self.sample_range[0] > 0 {
            line += &format!(" (from {} on)", self.sample_range[0]);
        }
        let shared = if self.shared_paths { ", shared by 2×2 pixels" } else { "" };
        line + &format!("; {} paths{shared}, {} rays", Count(self.paths), Count(self.rays))
    }
}

impl Intervals {
    /// Findings about the error bars, the most certain first.
    fn verdict(&self, spp: u64, extendable: bool) -> Vec<String> {
        let resume = if extendable { "--resume " } else { "" };
        let confidence = Percent(self.confidence);
        if let Some(half_width) =
            self.half_width.filter(|_| spp >= MIN_CERTIFIED_SAMPLES || self.certified >= CERTIFIED_SHARE)
        {
            let outcome = match self.target {
                None => String::new(),
                Some(target) if half_width > target => format!("; the target is {}", Percent(target)),
                Some(_) if self.certified < CERTIFIED_SHARE => {
                    ", but half of the pixels must be certified: rare, bright samples dominate the others".to_owned()
                }
                Some(target) => format!("; the target of {} is reached", Percent(target)),
            };
            let (share, half_width) = (Percent(self.certified), Percent(half_width));
            return vec![format!(
                "certified {share} of the pixels that light can reach; nine tenths of these within {half_width} at {confidence} confidence{outcome}"
            )];
        }
        let mut lines = Vec::from([if spp < MIN_CERTIFIED_SAMPLES {
            format!(
                "certified no pixel yet: a certificate takes {MIN_CERTIFIED_SAMPLES} samples ({resume}--spp {MIN_CERTIFIED_SAMPLES})"
            )
        } else {
            format!(
                "certified no pixel: rare, bright samples dominate all of them; try more samples ({resume}--spp) or --integrator auto"
            )
        }]);
        if let Some(Provisional { share, half_width }) = self.provisional {
            let (share, half_width) = (Percent(share), Percent(half_width));
            lines.push(format!(
                "so far    {share} of the pixels that light can reach have no heavy tail; nine tenths of these within {half_width} at \
                 {confidence} confidence (provisional: in tests at 64 samples such intervals hold for 95 to 98 % of the pixels)"
            ));
        }
        lines
    }
}

/// The text on one line: names of files may have ends of lines.
fn one_line(text: &str) -> String {
    text.replace('\n', "\\n")
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
            extendable: true,
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
            resumed_from: Some("a checkpoint".into()),
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
                provisional: Some(Provisional { share: 0.99, half_width: 0.06 }),
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
            "resume    --resume continues from box.checkpoint.exr\n",
            "samples   12 per pixel of 64 when the time was up, 4 of them from a checkpoint; 3.69 million paths, shared by 2×2 pixels, 20.0 million rays\n",
            "speed     1.84 Mpaths/s, 10.0 Mrays/s\n",
            "noise     3.1 % mean, 9.8 % at the 95th percentile",
            "certified 99 % of the pixels that light can reach; nine tenths of these within 5.1 % at 95 % confidence\n",
            "memory    1 MiB on the device at most\n",
            "dropped   3 samples that were not finite\n",
            "biased    max-radiance 10\n",
            "warning   the file has no light\n",
        ] {
            assert!(text.contains(line), "{line:?} is not in\n{text}");
        }
    }

    #[test]
    fn it_leads_with_the_outputs_and_their_quality() {
        let text = summary().to_string();
        let heads: Vec<_> = text.lines().filter_map(|line| line.split_whitespace().next()).collect();
        assert_eq!(heads[..3], ["image", "noise", "certified"]);
        assert!(!heads.contains(&"error"), "{text}");
    }

    #[test]
    fn quiet_is_four_lines() {
        let text = summary().short();
        assert_eq!(text.lines().count(), 4, "{text}");
        assert!(text.ends_with("warning: the file has no light\n"), "{text}");
        let odd = Summary { outputs: vec!["a\nb.png".into()], ..summary() }.short();
        assert!(odd.starts_with("image     a\\nb.png (") && odd.lines().count() == 4, "{odd}");
        let plain = Summary { biased: vec![], dropped_samples: 0, checkpoint: None, warnings: vec![], ..summary() };
        assert_eq!(plain.short().lines().count(), 3);
        let few = Summary { intervals: few(), ..plain };
        assert_eq!(few.short().lines().count(), 3);
        assert!(few.short().contains("so far    99 %"), "{}", few.short());
    }

    fn few() -> Intervals {
        Intervals { certified: 0.0, half_width: None, ..summary().intervals }
    }

    #[test]
    fn below_a_certificate_the_verdict_is_provisional() {
        let lines = few().verdict(64, true);
        assert!(lines[0].contains("--resume --spp 256"), "{lines:?}");
        assert!(lines[1].contains("99 % of the pixels that light can reach have no heavy tail"), "{lines:?}");
        let lines = Intervals { provisional: None, ..few() }.verdict(1024, false);
        assert!(lines.len() == 1 && lines[0].contains("more samples"), "{lines:?}");
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
