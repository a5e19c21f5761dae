//! `surelight compare`: how far apart two images are, and whether more than their own noise
//! explains it.

mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use surelight_film::compare::{CompareError, CompareOptions, Outcome, Picture, compare, heat_map};
use surelight_film::{ExrImage, read_exr, write_rgb8_png};

use crate::error::Error;
use crate::parse::{self as value, OutputPath};
use crate::{console, output};

use report::Report;

/// `surelight compare A.exr B.exr`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// Image to judge
    #[arg(value_name = "A.exr")]
    a: PathBuf,

    /// Reference; differences are A − B, and relative to B
    #[arg(value_name = "B.exr")]
    b: PathBuf,

    /// Heat map to write: warm where A is brighter, cool where it is darker
    #[arg(long, value_name = "OUT.png", value_parser = value::png_paths())]
    map: Option<OutputPath>,

    /// Image with the variance of B's pixel means [default: B's own layer]
    #[arg(long, value_name = "VAR.exr")]
    reference_variance: Option<PathBuf>,

    /// Estimate the samples needed to detect a bias of this size
    ///
    /// A bias of the whole picture, detected with a probability of 90 %.
    #[arg(long, value_name = "E%", value_parser = value::relative_error)]
    plan: Option<f64>,

    /// Exit with code 5, not 0, when the test is inconclusive
    #[arg(long)]
    strict: bool,

    /// Print one JSON object
    #[arg(long)]
    json: bool,
}

/// Result of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CompareResult {
    /// No difference was found.
    Same,
    /// The images differ by more than noise.
    Differ,
    /// No test has enough power, and `--strict` is set.
    CannotTell,
}

/// Compares, prints, writes the map.
pub(crate) fn run(args: &CompareArgs) -> Result<CompareResult, Error> {
    let mut inputs = vec![args.a.clone(), args.b.clone()];
    inputs.extend(args.reference_variance.clone());
    if let Some(map) = &args.map {
        output::check(std::slice::from_ref(map), &inputs)?;
    }
    let (a, b) = (read_exr(&args.a)?, read_exr(&args.b)?);
    let variance = args.reference_variance.as_deref().map(read_exr).transpose()?;
    let picture_a = picture(&args.a, &a, None)?;
    let picture_b = picture(&args.b, &b, args.reference_variance.as_deref().zip(variance.as_ref()))?;

    let together = |cause: CompareError| Error::Compare {
        files: format!("\"{}\" and \"{}\"", args.a.display(), args.b.display()),
        cause,
    };
    if a.position != b.position {
        return Err(together(CompareError::Position { a: a.position, b: b.position }));
    }
    let options = CompareOptions::default();
    let comparison = compare(&picture_a, &picture_b, &options).map_err(together)?;
    if let Some(map) = &args.map {
        let pixels = heat_map(&picture_a, &picture_b);
        write_rgb8_png(&map.path, a.width as u32, a.height as u32, &pixels)?;
    }

    let finding = match comparison.verdict.as_ref().map(|verdict| verdict.outcome) {
        Some(Outcome::Same) => CompareResult::Same,
        Some(Outcome::Differ) => CompareResult::Differ,
        Some(Outcome::CannotTell) | None if args.strict => CompareResult::CannotTell,
        Some(Outcome::CannotTell) | None => CompareResult::Same,
    };
    let pictures = [&picture_a, &picture_b];
    let report = Report::new([&args.a, &args.b], [&a, &b], pictures, comparison, options.tile, args.plan);
    console::result(&if args.json { report.json().map_err(|e| Error::Print(e.into()))? } else { report.to_string() })?;
    Ok(finding)
}

/// The picture of a file with its variance, its own or that of another file.
fn picture<'a>(
    path: &Path,
    image: &'a ExrImage,
    variance: Option<(&Path, &'a ExrImage)>,
) -> Result<Picture<'a>, Error> {
    let named = |path: &Path| format!("\"{}\"", path.display());
    let files = match variance {
        Some((variance, _)) => format!("{} and its variance {}", named(path), named(variance)),
        None => named(path),
    };
    Picture::of(image, variance.map(|(_, image)| image)).map_err(|cause| Error::Compare { files, cause })
}
