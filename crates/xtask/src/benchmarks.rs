//! `cargo xtask benchmarks`: races the methods on five scenes and puts the charts into
//! docs/benchmarks.
//!
//! Ten minutes on an idle machine. The text of docs/benchmarks/README.md is written by hand:
//! compare it with the new charts.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Scenes of assets/ whose reports are kept.
const SCENES: [&str; 5] = ["cornell-box", "veach-mis", "many-lights", "textured", "glass"];

/// The files of a scene's report that are kept.
const KEPT: [&str; 8] = [
    "error-time.svg",
    "error-samples.svg",
    "front.svg",
    "calibration.svg",
    "bias.svg",
    "stages.svg",
    "reference.png",
    "mis-sobol-error.png",
];

/// Arguments of `cargo xtask benchmarks`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Program that races [default: the one that cargo builds]
    #[arg(long, value_name = "BINARY")]
    surelight: Option<PathBuf>,
    /// Time per method, as in surelight bench --time
    #[arg(long, value_name = "TIME", default_value = "10s")]
    time: String,
}

/// Races, and copies the files that are kept.
pub(crate) fn run(repository: &Path, arguments: &Arguments) -> Result<(), String> {
    let mut command = match &arguments.surelight {
        Some(binary) => Command::new(binary),
        None => {
            let mut cargo = Command::new("cargo");
            cargo.args(["run", "--release", "-p", "surelight", "--"]);
            cargo
        }
    };
    let report = repository.join("target/benchmarks");
    let scenes = SCENES.map(|name| repository.join("assets").join(name).with_extension("glb"));
    command.current_dir(repository).arg("bench").args(scenes);
    command.args(["--quick", "--repeats", "4", "--time", &arguments.time, "-o"]).arg(&report);
    let status = command.status().map_err(|e| format!("surelight cannot be run: {e}"))?;
    if !status.success() {
        return Err(format!("surelight bench ended with {status}"));
    }
    let target = repository.join("docs/benchmarks");
    let copy = |from: PathBuf, to: PathBuf| {
        std::fs::copy(&from, &to).map(drop).map_err(|e| format!("{} to {}: {e}", from.display(), to.display()))
    };
    for name in SCENES {
        let folder = target.join(name);
        std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        for file in KEPT {
            copy(report.join(name).join(file), folder.join(file))?;
        }
    }
    copy(report.join("data.csv"), target.join("data.csv"))?;
    println!("charts and data.csv are in docs/benchmarks; the whole report is {}", report.join("index.html").display());
    Ok(())
}
