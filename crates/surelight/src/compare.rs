//! `surelight compare`: how far apart two images are, and whether more than their own noise explains it.

mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use surelight_film::compare::{CompareError, CompareOptions, Picture, compare, heat_map};
use surelight_film::{ExrImage, read_exr, write_rgb8_png};

use crate::error::Error;
use crate::parse::{self as value, OutputPath};
use crate::{console, output};

use report::Report;

/// `surelight compare A.exr B.exr`.
#[derive(Debug, Args)]
pub(crate) struct CompareArgs {
    /// The image to judge
    #[arg(value_name = "A.exr")]
    a: PathBuf,

    /// The reference: differences are A − B, and relative to B
    #[arg(value_name = "B.exr")]
    b: PathBuf,

    /// Write a picture of the differences: warm where A is brighter, cool where it is darker
    #[arg(long, value_name = "OUT.png", value_parser = value::png_path)]
    map: Option<OutputPath>,

    /// The variance of B's pixels (of their means, not of single samples), as an image of the same size; instead of B's own layer
    #[arg(long, value_name = "VAR.exr")]
    reference_variance: Option<PathBuf>,

    /// One JSON object on standard output
    #[arg(long)]
    json: bool,
}

/// Compares, prints, writes the map. Returns whether the images differ; without a verdict they do not.
pub(crate) fn run(args: &CompareArgs) -> Result<bool, Error> {
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

    let differ = comparison.verdict.as_ref().is_some_and(|verdict| verdict.differ);
    let report = Report::new([&args.a, &args.b], [&a, &b], [&picture_a, &picture_b], comparison, options.tile);
    console::result(&if args.json { report.json().map_err(|e| Error::Print(e.into()))? } else { report.to_string() })?;
    Ok(differ)
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
