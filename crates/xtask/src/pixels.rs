//! `cargo xtask pixels BINARY`: hashes of rendered pixels and of composed kernels, to hold a
//! refactoring against.
//!
//! Run it with the program before and after a change and compare the two lists: a line that differs
//! names the scene, the options, and whether the kernel, the pixels or both changed.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread;

use surelight_film::read_exr;
use xxhash_rust::xxh3::Xxh3;

/// Options under which each scene is rendered: every integrator, sampler and way to spend samples.
const OPTIONS: [&str; 9] = [
    "",
    "--integrator mis --shared-paths on",
    "--integrator caustics",
    "--integrator area --sampler stratified",
    "--integrator hemisphere --sampler independent",
    "--integrator whitted",
    "--shared-paths off --adaptive --max-bounces 3",
    "--env SKY --multiple-scattering",
    "--clip off --max-radiance 2 --one-scramble",
];

/// Layers whose bits are hashed.
const LAYERS: [&str; 14] = [
    "R",
    "G",
    "B",
    "Variance.R",
    "Variance.G",
    "Variance.B",
    "Samples.N",
    "Albedo.R",
    "Albedo.G",
    "Albedo.B",
    "N.X",
    "N.Y",
    "N.Z",
    "Depth.Z",
];

/// Arguments of `cargo xtask pixels`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Program that renders
    binary: PathBuf,
}

/// Prints a line for each scene of assets/ and each set of options.
pub(crate) fn run(repository: &Path, Arguments { binary }: &Arguments) -> Result<(), String> {
    let assets = repository.join("assets");
    let mut scenes = Vec::new();
    for folder in [assets.clone(), assets.join("torture"), assets.join("gltf")] {
        let files = std::fs::read_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
        let files = files.flatten().map(|entry| entry.path());
        scenes.extend(files.filter(|path| path.extension().is_some_and(|e| e == "glb" || e == "gltf")));
    }
    scenes.sort();
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let jobs: Vec<(PathBuf, &str)> = scenes.iter().flat_map(|s| OPTIONS.map(|options| (s.clone(), options))).collect();
    let workers = thread::available_parallelism().map_or(1, usize::from);
    let mut lines: Vec<(usize, String)> = thread::scope(|scope| {
        let worker = |first: usize| {
            let (jobs, assets, folder) = (&jobs, &assets, folder.path());
            scope.spawn(move || {
                let mine = jobs.iter().enumerate().skip(first).step_by(workers);
                mine.map(|(i, (scene, options))| {
                    let name = scene.strip_prefix(assets).unwrap_or(scene).display();
                    let output = folder.join(format!("{i}.exr"));
                    (i, format!("{name} [{options}] {}", line(binary, scene, options, assets, &output)))
                })
                .collect::<Vec<_>>()
            })
        };
        let running: Vec<_> = (0..workers).map(worker).collect();
        running.into_iter().flat_map(|thread| thread.join().unwrap_or_default()).collect()
    });
    lines.sort();
    lines.iter().for_each(|(_, line)| println!("{line}"));
    Ok(())
}

/// The hashes of one render, or why there are none.
fn line(binary: &Path, scene: &Path, options: &str, assets: &Path, output: &Path) -> String {
    let sky = assets.join("sky.exr").display().to_string();
    let ran = Command::new(binary)
        .arg(scene)
        .args(["--size", "40x32", "--spp", "8", "--samples", "0..8", "--quiet", "-o"])
        .arg(output)
        .args(options.split_whitespace().map(|word| if word == "SKY" { sky.as_str() } else { word }))
        .output();
    let ran = match ran {
        Ok(ran) if ran.status.success() => ran,
        Ok(ran) => return format!("failed: {}", String::from_utf8_lossy(&ran.stderr).trim()),
        Err(error) => return format!("did not start: {error}"),
    };
    drop(ran);
    let hashes = read_exr(output).map_err(|error| error.to_string()).map(|image| {
        let mut pixels = Xxh3::new();
        let planes = LAYERS.iter().filter_map(|layer| image.channels.get(*layer));
        planes.flatten().for_each(|value| pixels.update(&value.to_le_bytes()));
        let kernel = image.surelight_metadata().and_then(|m| m.part).map_or_else(String::new, |part| part.kernel);
        format!("kernel {kernel} pixels {:016x}", pixels.digest())
    });
    let _ = std::fs::remove_file(output);
    hashes.unwrap_or_else(|error| format!("failed: {error}"))
}
