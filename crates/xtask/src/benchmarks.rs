//! `cargo xtask benchmarks`: races the methods on five scenes and puts the charts into docs/benchmarks.
//!
//! Ten minutes on a machine that does nothing else. The words in docs/benchmarks/README.md are written by hand: read them against the new charts.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Scenes of assets/ whose reports are kept.
const SCENES: [&str; 5] = ["cornell-box", "veach-mis", "many-lights", "textured", "glass"];

/// What is kept of a scene's report.
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

/// Seconds a method, unless told otherwise.
const TIME: &str = "10s";

/// `rest`: `--surelight BINARY` and `--time TIME`, both optional.
pub(crate) fn run(repository: &Path, rest: &[&str]) -> Result<(), String> {
    let (mut binary, mut time) = (None, TIME);
    let mut words = rest.iter();
    while let Some(&word) = words.next() {
        let value = words.next().ok_or_else(|| format!("{word} needs a value"))?;
        match word {
            "--surelight" => binary = Some(PathBuf::from(value)),
            "--time" => time = value,
            _ => return Err(format!("benchmarks knows no option {word}: --surelight BINARY or --time TIME")),
        }
    }
    let mut command = match binary {
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
    command.args(["--quick", "--repeats", "4", "--time", time, "-o"]).arg(&report);
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
