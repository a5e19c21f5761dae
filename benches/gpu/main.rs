//! Everything to be known of an adapter, in one go: `cargo bench --bench gpu -- -o FOLDER
//! [SCENE…]`, or its executable carried to where the adapter is (`cargo xtask gpu` packs it with
//! the tests).
//!
//! Rewrites `gpu.json` and `gpu.md` after each step; a step that fails is recorded, and the next
//! one begins. Options: `--size WIDTHxHEIGHT` (1920x1080), `--seconds` of a measurement (2),
//! `--limit` in seconds after which no step begins (240), `--adapter NAME`, `--small` (10,000
//! triangles instead of a million).

mod report;
mod steps;

use std::path::PathBuf;
use std::time::Instant;

use surelight_render::{AdapterChoice, Device};

use report::Report;

/// The measurements, and their durations.
pub(crate) struct Plan {
    /// Pixels.
    pub(crate) size: [u32; 2],
    /// Seconds of a measurement.
    pub(crate) seconds: f64,
    /// Scene files beside the procedural scenes.
    pub(crate) files: Vec<PathBuf>,
    /// Which adapter.
    pub(crate) adapter: AdapterChoice,
    /// A small terrain.
    pub(crate) small: bool,
    /// After so many seconds no step begins.
    pub(crate) limit: f64,
}

fn main() {
    let (plan, folder) = match parse(std::env::args().skip(1)) {
        Ok(parsed) => parsed,
        Err(message) => {
            eprintln!("error: {message}");
            std::process::exit(2);
        }
    };
    let started = Instant::now();
    let mut report = Report::new(folder, started);
    report.step("adapters", || Ok(steps::adapters()));
    let open = || Device::new(&plan.adapter).map_err(|e| e.to_string());
    let device = match open() {
        Ok(device) => device,
        Err(message) => {
            report.step("device", || Err(message));
            std::process::exit(1);
        }
    };
    report.about(&device.info);
    let mut subjects = Vec::new();
    report.step("scenes", || Ok(steps::load(&plan, &mut subjects)));
    for (name, step) in steps::ALL {
        if started.elapsed().as_secs_f64() > plan.limit {
            report.step(name, || Err("not begun: the time was up".into()));
            continue;
        }
        report.step(name, || step(&plan, &device, &subjects));
    }
}

fn parse(mut words: impl Iterator<Item = String>) -> Result<(Plan, PathBuf), String> {
    let mut plan = Plan {
        size: [1920, 1080],
        seconds: 2.0,
        files: Vec::new(),
        adapter: AdapterChoice::Best,
        small: false,
        limit: 240.0,
    };
    let mut folder = None;
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--bench" => (), // cargo says so
            "-o" => folder = Some(PathBuf::from(value()?)),
            "--small" => plan.small = true,
            "--adapter" => plan.adapter = AdapterChoice::Name(value()?),
            "--seconds" => plan.seconds = value()?.parse().map_err(|e| format!("--seconds: {e}"))?,
            "--limit" => plan.limit = value()?.parse().map_err(|e| format!("--limit: {e}"))?,
            "--size" => {
                let text = value()?;
                let sides: Option<Vec<u32>> = text.split('x').map(|n| n.parse().ok().filter(|&n| n > 0)).collect();
                plan.size = sides
                    .and_then(|s| <[u32; 2]>::try_from(s).ok())
                    .ok_or_else(|| format!("--size is WIDTHxHEIGHT, not {text}"))?;
            }
            option if option.starts_with('-') => return Err(format!("there is no option {option}")),
            file => plan.files.push(PathBuf::from(file)),
        }
    }
    let folder = folder.ok_or("say where the report goes: -o FOLDER")?;
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok((plan, folder))
}
