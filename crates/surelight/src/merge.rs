//! `surelight merge`: joins parts of one render.

use std::fmt::{self, Display};
use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use surelight_film::{Compatibility, MergePlan, PartFile};

use crate::error::Error;
use crate::exposure::{self, Automatic, Exposure, Hint};
use crate::options::Tonemap;
use crate::parse::{self as value, Format, OutputPath};
use crate::summary::{Percent, RelativeError};
use crate::{console, output, render};

/// `surelight merge PART.exr…`.
#[derive(Debug, Args)]
pub(crate) struct MergeArgs {
    /// Parts of one render, in any order
    ///
    /// Written with --samples or --crop, checkpoints, or merged parts.
    #[arg(value_name = "PART.exr", required = true)]
    parts: Vec<PathBuf>,

    /// File to write, .exr (linear, all layers) or .png (tone mapped, sRGB); repeatable
    #[arg(short, long, value_name = "PATH", value_parser = value::output_paths(), required = true)]
    output: Vec<OutputPath>,

    /// Merge parts that different adapters or drivers rendered, too; recorded in the files: means
    /// and error bars hold, bits differ from a render in one go
    #[arg(long)]
    mixed: bool,

    /// Exposure of the PNG in stops, or `auto` [default: 0]
    #[arg(long, value_name = "EV|auto", value_parser = value::exposure_or_auto, allow_hyphen_values = true)]
    exposure: Option<Exposure>,

    /// Tone-mapping operator of the PNG
    #[arg(long, value_enum, default_value_t = Tonemap::Neutral)]
    tonemap: Tonemap,

    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
}

/// Joins the parts, writes the result and reports missing parts. Returns whether it is complete.
pub(crate) fn run(args: &MergeArgs) -> Result<bool, Error> {
    output::check(&args.output, &args.parts)?;
    let parts = args.parts.iter().map(|path| PartFile::open(path)).collect::<Result<Vec<_>, _>>()?;
    let transparent = parts.iter().any(|part| part.metadata.is_transparent());
    let plan = MergePlan::new(parts, if args.mixed { Compatibility::Estimator } else { Compatibility::Bits })?;
    render::check_memory(&plan.window, transparent)?;
    let (missing, samples) = (plan.missing, plan.samples);
    let (film, mut metadata) = plan.join()?;
    let exposed = exposure::choose(args.exposure, args.tonemap, &film, &args.output);
    metadata.exposure = exposed.record();
    render::write(&args.output, &film, &exposed.display, &metadata)?;

    let whole = film.window().whole;
    let one_sequence = metadata.has_one_sequence();
    let merged = Merged {
        outputs: args.output.iter().map(|output| output.path.display().to_string()).collect(),
        parts: args.parts.len(),
        width: film.width(),
        height: film.height(),
        image_size: whole,
        crop: metadata.crop,
        sample_range: samples,
        spp: samples[1] - samples[0],
        missing: missing.map(|missing| missing.to_string()),
        can_be_merged: missing.is_some() && args.output.iter().any(|output| output.format == Format::Exr),
        relative_error: film.error_summary().map(|error| RelativeError::new(error, one_sequence)),
        certified: film.certify().share(),
        mixed: metadata.mixed,
        dropped_samples: metadata.dropped_samples,
        exposure: exposed.auto,
        exposure_hint: exposed.hint,
        biased: metadata.biased,
    };
    let text = if args.json {
        serde_json::to_string(&merged).map_err(|error| Error::Print(error.into()))? + "\n"
    } else {
        merged.to_string()
    };
    console::result(&text)?;
    Ok(missing.is_none())
}

/// Result of a merge; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
struct Merged {
    /// Files written.
    outputs: Vec<String>,
    /// Files read.
    parts: usize,
    /// Pixels a row.
    width: u32,
    /// Rows.
    height: u32,
    /// Pixels a row and rows of the whole image.
    image_size: [u32; 2],
    /// Part of the image, as x0, y0, x1, y1 with the last two outside; `null`: the whole.
    crop: Option<[u32; 4]>,
    /// The first sample and the one after the last.
    sample_range: [u64; 2],
    /// Samples per pixel.
    spp: u64,
    /// The missing parts of the whole render; `null`: nothing.
    missing: Option<String>,
    /// Whether an output is a part itself.
    can_be_merged: bool,
    /// Error of the image; `null` below two batches or where all is black.
    relative_error: Option<RelativeError>,
    /// Share of the pixels that are certified.
    certified: f64,
    /// Adapters and drivers of the parts, where they differ.
    mixed: Vec<String>,
    /// Samples that were not finite and were left out.
    dropped_samples: u64,
    /// Exposure of the PNG, where it follows from the picture.
    exposure: Option<Automatic>,
    /// A hint at a better exposure.
    exposure_hint: Option<Hint>,
    /// Options in force that bias the picture.
    biased: Vec<String>,
}

impl Display for Merged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "image     {} ({}x{}", self.outputs.join(", "), self.width, self.height)?;
        if let (Some([x, y, ..]), [width, height]) = (self.crop, self.image_size) {
            write!(f, " at {x},{y} of {width}x{height}")?;
        }
        let plural = if self.parts == 1 { "" } else { "s" };
        writeln!(f, ")\nsamples   {} per pixel from {} part{plural}", self.spp, self.parts)?;
        if let Some(missing) = &self.missing {
            let more = if self.can_be_merged { "; the .exr can be merged with them" } else { "" };
            writeln!(f, "missing   {missing}{more}")?;
        }
        if let Some(error) = self.relative_error {
            writeln!(f, "noise     {error}")?;
        }
        writeln!(f, "certified {} of the pixels that light can reach", Percent(self.certified))?;
        if !self.mixed.is_empty() {
            writeln!(f, "mixed     {}: means and error bars hold, bits do not", self.mixed.join("; "))?;
        }
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
        Ok(())
    }
}
