//! `cargo xtask references`: renders against a folder of reference images.
//!
//! The folder holds `scenes/NAME.glb`, `references/NAME.exr` (mean) and, where the reference is
//! itself an estimate, `references/NAME_var.exr` (variance of that mean). `NAME-d2` without its own
//! scene is NAME cut after two segments: `--max-bounces 1`. All are linear Rec. 709, box filter of
//! one pixel, row 0 at the top.
//!
//! A scene passes where, in each of the three channels,
//!
//! - the image's mean differs from the reference's by at most 0.2 % of it plus three standard
//!   errors of the difference, and
//! - at least 98.8 % of pixels lie inside the two-sided 99.9 % bound: Student's t with the degrees
//!   of freedom of the difference's variance (batches − 1 for ours; a reference's variance is
//!   treated as exact; both by Welch and Satterthwaite), widened by four units in the last place of
//!   an f32, so that pixels without any variance can be compared at all.
//!
//! A pixel whose error bar is unknown, or whose value is not finite, is outside. The required share
//! is below 99.9 % because pixels with skewed samples are covered less often than by the level of
//! t.

mod judgement;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use surelight_film::read_exr;

use judgement::{Outcome, compare};

/// Arguments of `cargo xtask references`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder of scenes and references
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Program that renders
    #[arg(long, value_name = "BINARY")]
    surelight: PathBuf,
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 1024)]
    spp: u32,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    seed: u32,
    /// Take these references only
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    only: Vec<String>,
    /// Keep the renders in this folder
    #[arg(long, value_name = "FOLDER")]
    keep: Option<PathBuf>,
}

/// Renders every reference's scene and compares. The error is a sentence for the user.
pub(crate) fn run(options: &Arguments) -> Result<(), String> {
    let names = references(options)?;
    let scratch = tempfile::tempdir().map_err(|error| format!("no temporary folder could be made: {error}"))?;
    let renders = options.keep.clone().unwrap_or_else(|| scratch.path().to_owned());
    std::fs::create_dir_all(&renders)
        .map_err(|error| format!("the folder \"{}\" could not be made: {error}", renders.display()))?;
    println!(
        "{} spp, seed {}; mean within 0.2 % + 3 standard errors, and 98.8 % of pixels inside the 99.9 % bound, per channel",
        options.spp, options.seed
    );
    println!(
        "{:<18} {:>8} {:>8} {:>7} | {:>9} {:>8} {:>8} {:>8}  verdict",
        "reference", "mean R%", "G%", "B%", "allowed%", "inside%", "all 3%", "pixel SE%"
    );
    let mut failed = Vec::new();
    for name in &names {
        let started = Instant::now();
        match check(options, name, &renders) {
            Ok(outcome) => {
                println!("{name:<18} {outcome}  {:.1} s", started.elapsed().as_secs_f64());
                if !outcome.passes() {
                    failed.push(name.as_str());
                }
            }
            Err(message) => {
                println!("{name:<18} error: {message}");
                failed.push(name);
            }
        }
    }
    match failed[..] {
        [] => Ok(()),
        _ => Err(format!("{} of {} references do not match: {}", failed.len(), names.len(), failed.join(", "))),
    }
}

/// Names of the references in the folder, sorted.
fn references(options: &Arguments) -> Result<Vec<String>, String> {
    let folder = options.folder.join("references");
    let unreadable = |error: std::io::Error| format!("the folder \"{}\" could not be read: {error}", folder.display());
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|extension| extension == "exr")
            && let Some(stem) = path.file_stem().and_then(|stem| stem.to_str())
            && !stem.ends_with("_var")
        {
            names.push(stem.to_owned());
        }
    }
    names.sort();
    if let Some(missing) = options.only.iter().find(|name| !names.contains(name)) {
        return Err(format!("there is no reference \"{missing}\" in \"{}\"", folder.display()));
    }
    if !options.only.is_empty() {
        names.retain(|name| options.only.contains(name));
    }
    if names.is_empty() {
        return Err(format!("there are no references in \"{}\"", folder.display()));
    }
    Ok(names)
}

/// The scene of a reference and the bounces it is cut at.
fn scene_of(folder: &Path, name: &str) -> (PathBuf, Option<u32>) {
    let scene = |name: &str| folder.join("scenes").join(format!("{name}.glb"));
    if !scene(name).is_file()
        && let Some((stem, depth)) = name.rsplit_once("-d")
        && let Ok(depth) = depth.parse::<u32>()
        && depth > 0
    {
        return (scene(stem), Some(depth - 1));
    }
    (scene(name), None)
}

fn check(options: &Arguments, name: &str, renders: &Path) -> Result<Outcome, String> {
    let read = |path: &Path| read_exr(path).map_err(|error| error.to_string());
    let references = options.folder.join("references");
    let reference = read(&references.join(format!("{name}.exr")))?;
    let variance_path = references.join(format!("{name}_var.exr"));
    let reference_variance = variance_path.is_file().then(|| read(&variance_path)).transpose()?;

    let (scene, bounces) = scene_of(&options.folder, name);
    let output = renders.join(format!("{name}.exr"));
    let mut command = Command::new(&options.surelight);
    command.arg(&scene).args(["--quiet", "--spp", &options.spp.to_string(), "--seed", &options.seed.to_string()]);
    command.args(["--size", &format!("{}x{}", reference.width, reference.height)]);
    if let Some(bounces) = bounces {
        command.args(["--max-bounces", &bounces.to_string()]);
    }
    command.arg("-o").arg(&output).stdin(Stdio::null()).stdout(Stdio::null());
    let finished = command
        .output()
        .map_err(|error| format!("\"{}\" could not be started: {error}", options.surelight.display()))?;
    if !finished.status.success() {
        let errors = String::from_utf8_lossy(&finished.stderr);
        return Err(format!("the render failed ({}): {}", finished.status, errors.trim()));
    }
    compare(&read(&output)?, &reference, reference_variance.as_ref())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_suffix_names_a_cut_scene() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("scenes")).unwrap();
        for name in ["veach", "own-d3"] {
            std::fs::write(folder.path().join(format!("scenes/{name}.glb")), b"").unwrap();
        }
        let of = |name| scene_of(folder.path(), name);
        assert_eq!(of("veach-d2"), (folder.path().join("scenes/veach.glb"), Some(1)));
        assert_eq!(of("own-d3"), (folder.path().join("scenes/own-d3.glb"), None));
        assert_eq!(of("veach"), (folder.path().join("scenes/veach.glb"), None));
    }
}
