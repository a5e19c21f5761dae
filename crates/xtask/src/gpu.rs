//! `cargo xtask gpu`: packs all that is to be known of an adapter into a folder that needs neither
//! cargo nor sources.
//!
//! Benches and tests as executables, the scenes, and `benches/gpu.sh`, which runs them one after
//! the other.

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Benches of the script.
const BENCHES: [&str; 3] = ["gpu", "bounces", "device"];

/// Tests that say most about a driver, in this order; those that need no device, or files, stay
/// here.
const TESTS: [&str; 9] = [
    "checked_trusted",
    "furnace",
    "lights",
    "specialised",
    "torture_accumulation",
    "torture_numeric",
    "torture_geometry",
    "torture_bsdf",
    "torture_light",
];

/// Arguments of `cargo xtask gpu`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Folder of the package
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,
    /// Scenes to render there
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
}

/// Builds everything and packs it.
pub(crate) fn run(repository: &Path, arguments: &Arguments) -> Result<(), String> {
    let folder = &arguments.output;
    make(&folder.join("tests"))?;
    let benches = executables(repository, &["bench", "-p", "surelight-benches"])?;
    for name in BENCHES {
        carry(find(&benches, name)?, &folder.join(name))?;
    }
    let tests = executables(repository, &["test", "--release", "-p", "surelight-tests"])?;
    for (k, name) in TESTS.iter().enumerate() {
        // The script takes them in the order of their names.
        carry(find(&tests, name)?, &folder.join(format!("tests/{}-{name}", k + 1)))?;
    }
    copy(&repository.join("benches/gpu.sh"), &folder.join("gpu.sh"))?;
    let git =
        Command::new("git").current_dir(repository).args(["describe", "--always", "--dirty", "--abbrev=10"]).output();
    let commit = git.map(|output| output.stdout).unwrap_or_default();
    std::fs::write(folder.join("COMMIT"), commit).map_err(|e| format!("COMMIT: {e}"))?;
    for scene in &arguments.scenes {
        carry_scene(scene, &folder.join("scenes"))?;
    }
    println!("on the machine with the adapter: {}/gpu.sh OUT", folder.display());
    Ok(())
}

/// Names and files of the executables that cargo builds.
fn executables(repository: &Path, arguments: &[&str]) -> Result<Vec<(String, PathBuf)>, String> {
    let mut cargo = Command::new("cargo");
    cargo.current_dir(repository).args(arguments).args(["--no-run", "--message-format=json"]);
    let output = cargo.stderr(std::process::Stdio::inherit()).output().map_err(|e| format!("cargo: {e}"))?;
    if !output.status.success() {
        return Err(format!("cargo {} ended with {}", arguments.join(" "), output.status));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let named = |line: &str| {
        let message: Value = serde_json::from_str(line).ok()?;
        Some((message["target"]["name"].as_str()?.to_owned(), PathBuf::from(message["executable"].as_str()?)))
    };
    Ok(text.lines().filter_map(named).collect())
}

fn find<'a>(built: &'a [(String, PathBuf)], name: &str) -> Result<&'a Path, String> {
    let found = built.iter().find(|(built, _)| built == name);
    found.map(|(_, path)| path.as_path()).ok_or_else(|| format!("cargo built no {name}"))
}

/// Copies an executable, without its symbols where `strip` is there to take them out.
fn carry(from: &Path, to: &Path) -> Result<(), String> {
    copy(from, to)?;
    // It works as well with them.
    let _ = Command::new("strip").arg(to).status();
    Ok(())
}

/// A .glb alone, any other file with its folder.
fn carry_scene(scene: &Path, scenes: &Path) -> Result<(), String> {
    let file = scene.file_name().ok_or_else(|| format!("{} is no file", scene.display()))?;
    if scene.extension().is_some_and(|extension| extension == "glb") {
        make(scenes)?;
        return copy(scene, &scenes.join(file));
    }
    let target = scenes.join(scene.file_stem().unwrap_or(file));
    let beside = scene.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    copy_folder(beside, &target)
}

fn copy_folder(from: &Path, to: &Path) -> Result<(), String> {
    make(to)?;
    for entry in std::fs::read_dir(from).map_err(|e| format!("{}: {e}", from.display()))? {
        let path = entry.map_err(|e| format!("{}: {e}", from.display()))?.path();
        let Some(name) = path.file_name() else { continue };
        if path.is_dir() { copy_folder(&path, &to.join(name))? } else { copy(&path, &to.join(name))? }
    }
    Ok(())
}

fn make(folder: &Path) -> Result<(), String> {
    std::fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

fn copy(from: &Path, to: &Path) -> Result<(), String> {
    std::fs::copy(from, to).map(drop).map_err(|e| format!("{} to {}: {e}", from.display(), to.display()))
}
