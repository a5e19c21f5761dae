//! The report of a comparison, as text and as JSON.

use std::fmt::{self, Display};
use std::path::Path;

use serde::Serialize;
use surelight_film::compare::{Comparison, Outcome, Picture, Verdict};
use surelight_film::{ExrImage, Metadata};

use crate::progress::Significant;

const CANNOT_TELL: &str = "cannot tell";
const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// A comparison; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    /// The image judged.
    a: String,
    /// The reference.
    b: String,
    width: usize,
    height: usize,
    /// Pixels compared.
    pixels: usize,
    /// Pixels left out because a value or variance is not finite.
    skipped: usize,
    /// Σ(A − B)/ΣB.
    mean_relative: f64,
    /// Its standard error, from the spread over pixels.
    mean_relative_error: f64,
    rmse: f64,
    rel_mse: f64,
    smape: f64,
    flip: f64,
    /// `null` where an image has no error estimate.
    verdict: Option<Judgement>,
    /// `null` without `--plan`, without a verdict, and where there is no noise or no light.
    plan: Option<Plan>,
    /// Notes on the rest.
    notes: Vec<String>,
}

/// The statistical verdict.
#[derive(Debug, Serialize)]
struct Judgement {
    /// `same`, `differ` or `cannot tell`.
    outcome: &'static str,
    /// Whether it is the second.
    differ: bool,
    /// Probability of that for equal pictures.
    alpha: f64,
    /// Tests of the whole picture.
    pooled: Vec<Pooled>,
    /// Level of each of them.
    pooled_level: f64,
    /// Smallest bias of the whole picture, relative, found 9 times in 10.
    detectable: f64,
    /// Side of a tile in pixels.
    tile: usize,
    tiles: usize,
    /// Level of each test of a tile and channel.
    tile_level: f64,
    /// As `detectable`, in one tile: the median over lit tiles.
    detectable_in_tile: f64,
    /// Tiles that differ, smallest p first.
    different_tiles: Vec<Different>,
}

/// The samples that it takes to detect a bias.
#[derive(Debug, Serialize)]
struct Plan {
    /// Of the whole picture, relative.
    bias: f64,
    /// How many times the samples that the images have; below 1 where fewer would do.
    times: f64,
    /// Samples per pixel of A and B; `null` where an image does not state them.
    samples: [Option<f64>; 2],
}

#[derive(Debug, Serialize)]
struct Pooled {
    channel: &'static str,
    /// Of the means, in radiance.
    difference: f64,
    standard_error: f64,
    p: f64,
}

#[derive(Debug, Serialize)]
struct Different {
    /// First column.
    x: usize,
    /// First row.
    y: usize,
    channel: &'static str,
    /// `null` where the reference is black.
    relative: f64,
    p: f64,
}

impl Report {
    pub(super) fn new(
        paths: [&Path; 2],
        images: [&ExrImage; 2],
        pictures: [&Picture; 2],
        comparison: Comparison,
        tile: usize,
        plan: Option<f64>,
    ) -> Self {
        let names = paths.map(|path| path.display().to_string());
        let metadata = images.map(ExrImage::surelight_metadata);
        let mut notes = notes(&names, &metadata, pictures);
        let verdict = comparison.verdict;
        let plan = plan.and_then(|bias| {
            let plan = verdict.as_ref().and_then(|verdict| Plan::new(bias, verdict, images));
            if plan.is_none() {
                notes.push("nothing can be planned: there is no verdict, no noise or no light in the reference".into());
            }
            plan
        });
        let [a, b] = names;
        let metrics = comparison.metrics;
        Self {
            a,
            b,
            width: images[0].width,
            height: images[0].height,
            pixels: metrics.pixels,
            skipped: comparison.skipped,
            mean_relative: metrics.mean_relative,
            mean_relative_error: metrics.mean_relative_error,
            rmse: metrics.rmse,
            rel_mse: metrics.rel_mse,
            smape: metrics.smape,
            flip: comparison.flip,
            verdict: verdict.map(|verdict| Judgement::new(verdict, tile)),
            plan,
            notes,
        }
    }

    /// One JSON object on one line.
    pub(super) fn json(&self) -> Result<String, serde_json::Error> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

/// Notes on two files that qualify the rest.
fn notes(names: &[String; 2], metadata: &[Option<Metadata>; 2], pictures: [&Picture; 2]) -> Vec<String> {
    let mut notes = Vec::new();
    let known = pictures.map(|picture| picture.variance.is_some());
    for (name, picture) in names.iter().zip(pictures) {
        if picture.variance.is_none() {
            notes.push(format!("{name} has no variance, so there is no verdict"));
        } else if picture.tail.is_none() {
            notes.push(format!(
                "{name} has no tails (Tail.K): the verdict treats its variance as exact, \
                 as it is not where light comes by rare, bright samples"
            ));
        }
    }
    for (name, metadata) in names.iter().zip(metadata) {
        match metadata {
            Some(metadata) if !metadata.biased.is_empty() => {
                notes.push(format!("{name} is biased by {}", metadata.biased.join(", ")));
            }
            _ => {}
        }
    }
    if let [Some(a), Some(b)] = metadata {
        // Versions of the settings differ in how they hash a scene.
        let versions = [a, b].map(|metadata| metadata.settings.as_ref().map(|settings| settings.version));
        let hashed_alike = !matches!(versions, [Some(a), Some(b)] if a != b);
        if hashed_alike && a.scene_hash != b.scene_hash {
            notes.push("the images show different scenes, or one scene that has changed".into());
        }
        if a.seed == b.seed && known == [true; 2] {
            notes.push(format!(
                "both have seed {}: their noise is not independent, as the verdict takes it to be",
                a.seed
            ));
        }
    }
    notes
}

impl Plan {
    fn new(bias: f64, verdict: &Verdict, images: [&ExrImage; 2]) -> Option<Self> {
        let times = verdict.times_samples(bias)?;
        let samples = images.map(|image| {
            let samples = image.channels.get("Samples.N")?;
            let total: f64 = samples.iter().map(|&n| f64::from(n)).sum();
            Some((times * total / samples.len() as f64).ceil().max(1.0))
        });
        Some(Self { bias, times, samples })
    }
}

impl Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "a bias of {} % of the picture takes {} times",
            Significant(100.0 * self.bias),
            Significant(self.times)
        )?;
        let [a, b] = self.samples.map(|n| n.map_or("an unknown number".into(), |n| format!("{n}")));
        write!(f, " these samples: {a} per pixel in A and {b} in B")
    }
}

impl Judgement {
    fn new(verdict: Verdict, tile: usize) -> Self {
        let pooled = verdict.pooled.iter().zip(CHANNELS).map(|(test, channel)| Pooled {
            channel,
            difference: test.difference,
            standard_error: test.standard_error,
            p: test.p,
        });
        let different = verdict.different.iter().map(|tile| Different {
            x: tile.x,
            y: tile.y,
            channel: CHANNELS[tile.channel],
            relative: tile.relative,
            p: tile.p,
        });
        Self {
            outcome: match verdict.outcome {
                Outcome::Same => "same",
                Outcome::Differ => "differ",
                Outcome::CannotTell => CANNOT_TELL,
            },
            differ: verdict.differs(),
            alpha: verdict.alpha,
            pooled: pooled.collect(),
            pooled_level: verdict.pooled_level,
            detectable: verdict.detectable,
            tile,
            tiles: verdict.tiles,
            tile_level: verdict.tile_level,
            detectable_in_tile: verdict.detectable_in_tile,
            different_tiles: different.collect(),
        }
    }

    /// The differences, in words.
    fn findings(&self) -> String {
        let whole = self.pooled.iter().filter(|test| test.p < self.pooled_level);
        let mut found: Vec<_> =
            whole.map(|test| format!("the mean in {} (p {})", test.channel, PValue(test.p))).collect();
        if let Some(worst) = self.different_tiles.first() {
            let relative = match worst.relative {
                relative if relative.is_finite() => format!("{} % in {}", Signed(100.0 * relative), worst.channel),
                _ => format!("the reference is black in {}", worst.channel),
            };
            found.push(format!(
                "{} of {} tiles, most surely the one at {},{} ({relative}, p {})",
                self.different_tiles.len(),
                self.tiles,
                worst.x,
                worst.y,
                PValue(worst.p)
            ));
        }
        found.join("; ")
    }
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "images    {} against {}, {}x{}", self.a, self.b, self.width, self.height)?;
        writeln!(
            f,
            "mean      {} % ± {} % (signed, relative to the reference; ± its standard error)",
            Signed(100.0 * self.mean_relative),
            Significant(100.0 * self.mean_relative_error)
        )?;
        writeln!(f, "RMSE      {:.4e}", self.rmse)?;
        writeln!(f, "relMSE    {:.4e}", self.rel_mse)?;
        writeln!(f, "SMAPE     {:.4e}", self.smape)?;
        writeln!(f, "FLIP      {:.4} (visible difference; it hides bias)", self.flip)?;
        if self.skipped > 0 {
            writeln!(f, "skipped   {} pixels that are not finite", self.skipped)?;
        }
        for note in &self.notes {
            writeln!(f, "note      {note}")?;
        }
        let Some(verdict) = &self.verdict else {
            return writeln!(f, "verdict   none");
        };
        if verdict.differ {
            writeln!(f, "verdict   they differ: {}", verdict.findings())?;
        } else if verdict.outcome == CANNOT_TELL {
            writeln!(f, "verdict   cannot tell: even a black picture might have passed")?;
        } else {
            writeln!(f, "verdict   the same, as far as their noise lets one see")?;
        }
        writeln!(
            f,
            "power     9 times in 10 a bias of {} % of the picture would have been detected, or of {} % in one tile of {s}x{s}",
            Significant(100.0 * verdict.detectable),
            Significant(100.0 * verdict.detectable_in_tile),
            s = verdict.tile
        )?;
        writeln!(
            f,
            "          Welch tests of the mean and of {} tiles, Šidák; equal pictures would differ with probability {}",
            verdict.tiles, verdict.alpha
        )?;
        match &self.plan {
            Some(plan) => writeln!(f, "plan      {plan}"),
            None => Ok(()),
        }
    }
}

/// A p-value: to two digits, however small.
struct PValue(f64);

impl Display for PValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 < 1e-300 { write!(f, "< 1e-300") } else { write!(f, "{:.1e}", self.0) }
    }
}

/// A number to three digits, with its sign.
struct Signed(f64);

impl Display for Signed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0.0 { '−' } else { '+' };
        write!(f, "{sign}{:.3}", Significant(self.0.abs()))
    }
}
