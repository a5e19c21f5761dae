//! `cargo xtask contact-sheet`: a small picture of every glTF file below a folder, beside the
//! published one where there is one.
//!
//! Files below a folder `malformed` are left out. The picture of `NAME.glb`, or of any file in a
//! folder `NAME`, is beside the first image in `DIR/docs/NAME/screenshot`, when there is one. Below
//! each are its name and the program's warnings.

mod sheet;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use sheet::Entry;

use crate::surelight_beside;

/// Arguments of `cargo xtask contact-sheet`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder of the files
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder of the sheets
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Program that renders [default: the one beside this tool's own: cargo build --release]
    #[arg(long, value_name = "BINARY")]
    surelight: Option<PathBuf>,
    /// Light [default: that of the files, or a white sky]
    #[arg(long, value_name = "FILE")]
    env: Option<PathBuf>,
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=4096))]
    spp: u32,
    /// Pixels on a side
    #[arg(long, value_name = "N", default_value_t = 192, value_parser = clap::value_parser!(u32).range(1..=4096))]
    size: u32,
    /// Take only files whose path contains this
    #[arg(long, value_name = "TEXT", default_value = "", hide_default_value = true)]
    only: String,
}

/// Renders all files and writes `sheet-01.png` and so on. The error is a sentence for the user.
pub(crate) fn run(options: &Arguments) -> Result<(), String> {
    let surelight = options.surelight.clone().unwrap_or_else(surelight_beside);
    let mut files = Vec::new();
    scenes_below(&options.folder, &mut files)?;
    files.retain(|file| file.to_string_lossy().contains(&options.only));
    files.sort();
    if files.is_empty() {
        return Err(format!("below \"{}\" there is no such glTF file", options.folder.display()));
    }
    std::fs::create_dir_all(&options.output)
        .map_err(|error| format!("the folder \"{}\" could not be made: {error}", options.output.display()))?;
    let scratch = tempfile::tempdir().map_err(|error| format!("no temporary folder could be made: {error}"))?;
    let mut entries = Vec::new();
    for file in &files {
        let entry = render(options, &surelight, file, &scratch.path().join("picture.png"))?;
        println!("{:<60} {}", entry.name, entry.note);
        entries.push(entry);
    }
    let failed = entries.iter().filter(|e| e.picture.is_none()).count();
    println!("{} files, {failed} without a picture", entries.len());
    sheet::write(&entries, options.size, &options.output)
}

fn scenes_below(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let failed = |error| format!("the folder \"{}\" cannot be read: {error}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_dir() {
            if !path.ends_with("malformed") {
                scenes_below(&path, files)?;
            }
        } else if path.extension().is_some_and(|e| e == "glb" || e == "gltf") {
            files.push(path);
        }
    }
    Ok(())
}

/// A file's picture, or why there is none.
fn render(options: &Arguments, surelight: &Path, file: &Path, picture: &Path) -> Result<Entry, String> {
    let mut command = Command::new(surelight);
    command.arg(file).args(["--quiet", "--spp", &options.spp.to_string()]);
    command.args(["--size", &format!("{0}x{0}", options.size)]).arg("-o").arg(picture);
    if let Some(env) = &options.env {
        command.arg("--env").arg(env);
    }
    let output = command
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("{} cannot be run: {error}", surelight.display()))?;
    let mut entry = Entry {
        name: file.strip_prefix(&options.folder).unwrap_or(file).display().to_string(),
        note: String::new(),
        picture: None,
        published: published(&options.folder, file),
    };
    if output.status.success() {
        let bytes = std::fs::read(picture).map_err(|error| format!("a picture cannot be read: {error}"))?;
        entry.picture = image::load_from_memory(&bytes).ok();
        let summary = String::from_utf8_lossy(&output.stdout);
        // That a camera and a sky were chosen is no news here.
        let warnings = summary.lines().filter_map(|line| line.strip_prefix("warning   "));
        entry.note = warnings.filter(|note| !note.starts_with("the file has no")).collect::<Vec<_>>().join(" ");
    } else {
        entry.note = String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or("no word").to_owned();
    }
    Ok(entry)
}

/// The picture that was published with a model.
fn published(folder: &Path, file: &Path) -> Option<image::DynamicImage> {
    let own = file.file_stem()?.to_str()?;
    let parent = file.parent()?.file_name()?.to_str()?;
    // "Duck-Draco" is a Duck.
    [own, parent].into_iter().find_map(|name| {
        let shots = folder.join("docs").join(name.split("-").next()?).join("screenshot");
        let mut shots: Vec<_> = std::fs::read_dir(shots).ok()?.flatten().map(|entry| entry.path()).collect();
        shots.sort_by_key(|path| !path.to_string_lossy().contains("screenshot."));
        shots.iter().find_map(|path| image::open(path).ok())
    })
}
