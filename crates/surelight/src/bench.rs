//! `surelight bench`: which method reaches a given error first, on anyone's scene and machine.

mod args;
mod progress;

use std::collections::HashSet;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use surelight_bench::{
    Budget, Method, Peer, Plan, Subject, campaign,
    data::{Clock, Data, slug},
    gate::{Tolerance, compare},
    map::{self, Map},
    read_overlay,
    report::{answer, read_data},
};
use surelight_prepare::{ActiveClipPlanes, Settings, may_have_caustics};
use surelight_render::Device;

use crate::error::Error;
use crate::parse::Size;
use crate::render::adapter_choice;
use crate::{STOPPED_EARLY, camera, console, fingerprint, interrupt, light};

pub(crate) use args::BenchArgs;
use progress::Progress;

/// Longer side of the pictures, pixels: errors are means over all of them, so that more would only
/// take longer.
const LONGER_SIDE: u32 = 256;
const QUICK_LONGER_SIDE: u32 = 160;

/// Seconds per scene with `--quick`: two minutes with the report.
const QUICK_SECONDS: f64 = 100.0;

/// Default seconds per method.
const DEFAULT_SECONDS: f64 = 20.0;

/// Exit code where --compare finds a loss.
const LOSS: u8 = crate::DIFFER;

/// Races, if there is a scene, and compares, if there is an earlier report.
pub(crate) fn run(args: &BenchArgs) -> Result<ExitCode, Error> {
    if args.map {
        return mapped(args);
    }
    let old = args.compare.as_deref().map(read_data).transpose()?;
    let tolerance = Tolerance { ratio: args.tolerance / 100.0, ..Tolerance::default() };
    let (data, complete) =
        if args.scenes.is_empty() { (read_data(&args.output.join("data.json"))?, true) } else { raced(args)? };
    let Some(old) = old else { return Ok(if complete { ExitCode::SUCCESS } else { ExitCode::from(STOPPED_EARLY) }) };
    let comparison = compare(&old, &data, tolerance)?;
    console::result(&comparison.to_string())?;
    let text = serde_json::to_string_pretty(&comparison).map_err(|e| Error::Print(e.into()))?;
    surelight_film::write_file(&args.output.join("comparison.json"), text.as_bytes())?;
    Ok(match (comparison.is_loss(), complete) {
        (true, _) => ExitCode::from(LOSS),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => ExitCode::from(STOPPED_EARLY),
    })
}

/// Measures and writes the failure map; fails where a method is wrong without a warning.
fn mapped(args: &BenchArgs) -> Result<ExitCode, Error> {
    interrupt::listen_and_keep("nothing");
    let device = Device::new(&adapter_choice(args.adapter.as_ref()))?;
    let map = Map::measure(&device, &mut |case| {
        if !args.quiet {
            console::note(case);
        }
        !interrupt::requested()
    })?;
    map::write(&map, &args.output)?;
    let silent = map.silent();
    let mut text = format!("map: {}\n", args.output.join("failure-map.md").display());
    for (case, method) in &silent {
        text += &format!("undetected bias: {method} on \"{case}\"\n");
    }
    console::result(&text)?;
    Ok(if silent.is_empty() { ExitCode::SUCCESS } else { ExitCode::from(LOSS) })
}

/// Races, writes the report, and prints the answers. Returns the data and whether they are
/// complete.
fn raced(args: &BenchArgs) -> Result<(Data, bool), Error> {
    interrupt::listen_and_keep("the measurements so far");
    let peers = args.overlay.as_deref().map(read_overlay).transpose()?.unwrap_or_default();
    let device = Device::new(&adapter_choice(args.adapter.as_ref()))?;
    let mut names = HashSet::new();
    let mut subjects = Vec::new();
    for path in &args.scenes {
        subjects.push(subject(args, path, &mut names)?);
    }
    let plan = plan(args, &subjects, peers, device.info.is_cpu);
    let mut progress = Progress::new(args.quiet, subjects.len());
    let (data, complete) =
        campaign(&device, &subjects, &plan, &args.output, args.resume, &args.note, &mut |scene, number, status| {
            progress.update(scene, number, status);
            !interrupt::requested()
        })?;
    progress.finish();
    let mut text = String::new();
    for scene in &data.scenes {
        text += &format!("{}: {}\n", scene.name, answer(scene));
        for warning in &scene.warnings {
            text += &format!("warning: {warning}\n");
        }
    }
    text += &format!("report: {}\n", args.output.join("index.html").display());
    if !complete {
        text += "stopped early: --resume with the same options continues\n";
    }
    console::result(&text)?;
    Ok((data, complete))
}

/// A scene with its race settings.
fn subject(args: &BenchArgs, path: &Path, names: &mut HashSet<String>) -> Result<Subject, Error> {
    let started = Instant::now();
    let options = args.file.load_options();
    let mut scene = surelight_scene::load(path, &options)?;
    let mut view = camera::choose(&scene, path, &args.camera, args.size)?;
    if args.size.is_none() {
        view.size = smaller(view.size, if args.quick { QUICK_LONGER_SIDE } else { LONGER_SIDE });
    }
    let light_note = light::set(&mut scene, &args.light)?;
    let mut warnings = std::mem::take(&mut scene.warnings);
    warnings.extend(view.note);
    warnings.extend(light_note);
    let settings = Settings {
        seed: args.seed,
        aperture: view.lens.map(|lens| lens.aperture),
        focus: view.lens.map(|lens| lens.focus),
        ..Settings::new(view.size.width, view.size.height)
    };
    warnings.extend(camera::clipping_warning(&view.camera, ActiveClipPlanes::find(&scene, &view.camera, &settings)));
    let stem = path.file_stem().map_or_else(String::new, |stem| slug(&stem.to_string_lossy()));
    let stem = if stem.is_empty() { "scene".to_owned() } else { stem };
    let mut name = stem.clone();
    for number in 2.. {
        if names.insert(name.clone()) {
            break;
        }
        name = format!("{stem}-{number}");
    }
    Ok(Subject {
        name,
        file: path.display().to_string(),
        hash: fingerprint::of(&scene),
        camera: view.camera,
        settings,
        scene,
        load_seconds: started.elapsed().as_secs_f64(),
        warnings,
    })
}

/// The size, reduced to a longer side.
fn smaller(size: Size, longer: u32) -> Size {
    let factor = f64::from(longer) / f64::from(size.width.max(size.height));
    let side = |n: u32| (f64::from(n) * factor).round().max(1.0) as u32;
    if factor < 1.0 { Size { width: side(size.width), height: side(size.height) } } else { size }
}

fn plan(args: &BenchArgs, subjects: &[Subject], peers: Vec<Peer>, software: bool) -> Plan {
    let budget = match (args.spp, args.time) {
        (Some(n), _) => Budget::Samples(n),
        (None, Some(time)) => Budget::Seconds(time.as_secs_f64()),
        (None, None) if args.quick => Budget::Total(QUICK_SECONDS),
        (None, None) => Budget::Seconds(DEFAULT_SECONDS),
    };
    let variations = args.variations();
    let mut methods = variations.methods(args.quick);
    if !variations.names_integrators() && subjects.iter().any(|subject| may_have_caustics(&subject.scene)) {
        methods.push(Method::CAUSTICS);
    }
    Plan {
        methods,
        repeats: args.repeats.unwrap_or(if args.quick { 3 } else { 4 }),
        budget,
        clock: args.clock.map_or(if software { Clock::Cpu } else { Clock::Wall }, Into::into),
        reference: args.reference.clone(),
        peers,
        exposure: args.exposure.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_keep_their_aspect() {
        let bounded = |width, height| {
            let size = smaller(Size { width, height }, 256);
            (size.width, size.height)
        };
        assert_eq!(bounded(1024, 512), (256, 128));
        assert_eq!(bounded(1024, 1), (256, 1));
        assert_eq!(bounded(100, 80), (100, 80));
    }
}
