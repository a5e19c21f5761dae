//! The gain of specialising the kernel to the scene: `cargo bench --bench specialisation [--
//! --traces] [FOLDER]`.
//!
//! First, whether a kernel has a trace of features that its scene lacks: for each such feature, its
//! kernel is composed once more from sources from which all code under that feature has been
//! removed ([`surelight_tests::forget`]). Where the WGSL is the same to the letter, so are the
//! driver's program, its records and its bindings, and it is as fast as a build without the
//! feature, by identity. Each scene is tested as rendered by default, with path reuse, and with
//! caustics traced from the lights where it has any; `--traces` does this alone.
//!
//! Then the cost of the features: each scene by its own kernel, by its own once more, which shows
//! the noise, and with an invisible speck that needs every feature, by the general kernel. `FOLDER`
//! gets the chart.

use std::collections::HashMap;

use surelight_bench::{
    chart::plain::bars,
    paths::{median, race_paths},
};
use surelight_prepare::{
    Integrator, KernelKey, Part, PathReuse, Prepared, Settings, TABLE, compose, compose_modules, path_kernel,
    shader_modules,
};
use surelight_render::Renderer;
use surelight_scene::Scene;
use surelight_scenes::{cornell_box, glass, spheres, textured, veach_mis};
use surelight_tests::{
    forget::forget,
    render::{device, prepare},
    scenes::with_everything,
};

const SIZE: u32 = 128;
const ROUNDS: u32 = 9;

/// Seconds of a round.
const SECONDS: f64 = 0.5;

/// Root modules of the kernels that a render runs.
fn roots(key: &KernelKey) -> Vec<(&'static str, KernelKey)> {
    let first_hits = ("package::kernel::first_hit", key.first_hits());
    let mut roots = vec![(path_kernel(key).0, *key), first_hits];
    if key.has(Part::Caustics) {
        roots.push(("package::kernel::light_tracing", *key));
    }
    roots
}

/// Ways to render a scene, each with separate kernels.
fn ways() -> [(&'static str, Settings); 3] {
    let plain = Settings::new(SIZE, SIZE);
    [
        ("", plain.clone()),
        (", shared paths", Settings { path_reuse: PathReuse::On, ..plain.clone() }),
        (", caustics", Settings { integrator: Integrator::Caustics, ..plain }),
    ]
}

fn scenes() -> [(&'static str, Scene); 5] {
    [
        ("cornell-box", cornell_box::cornell_box()),
        ("veach-mis", veach_mis::veach_mis()),
        ("spheres", spheres::spheres()),
        ("textured", textured::textured()),
        ("glass", glass::glass()),
    ]
}

/// The sources without a part, by its name.
fn forgotten() -> HashMap<&'static str, Vec<(&'static str, String)>> {
    let without = |name| shader_modules().iter().map(|&(path, source)| (path, forget(source, name))).collect();
    TABLE.iter().map(|row| (row.name, without(row.name))).collect()
}

/// Parts that a scene lacks: how many, and those whose absence leaves a trace.
fn traces(prepared: &Prepared, sources: &HashMap<&str, Vec<(&str, String)>>) -> (usize, Vec<String>) {
    let key = prepared.key().on_images(device().info.is_cpu);
    let lacking = TABLE.iter().filter(|row| !key.has(row.part)).map(|row| row.name);
    let mut found = Vec::new();
    let mut count = 0;
    for name in lacking {
        count += 1;
        for (root, key) in roots(&key) {
            let own = compose(root, &key, &prepared.constants()).unwrap_or_else(|e| panic!("{e}"));
            match compose_modules(root, &key, &prepared.constants(), &sources[name]) {
                Ok(other) if other.wgsl == own.wgsl => {}
                Ok(_) => found.push(format!("{name} in {root}")),
                Err(e) => found.push(format!("{name} in {root}: {e}")),
            }
        }
    }
    (count, found)
}

fn main() {
    let folder = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let traces_alone = std::env::args().any(|a| a == "--traces");
    println!(
        "adapter {}, {}; {SIZE}x{SIZE} pixels, median of {ROUNDS} rounds",
        device().info.name,
        device().info.driver
    );
    let sources = forgotten();
    println!("| scene | parts lacking | of them with a trace in the kernel |\n|---|---|---|");
    for (name, scene) in scenes() {
        let mut seen: Vec<KernelKey> = Vec::new();
        for (way, settings) in ways() {
            let prepared = prepare(&scene, &settings);
            // Where a scene has no caustics, say, the kernels are those of another way.
            if seen.contains(&prepared.key()) {
                continue;
            }
            let (count, found) = traces(&prepared, &sources);
            println!("| {name}{way} | {count} | {} |", if found.is_empty() { "none".into() } else { found.join(", ") });
            seen.push(prepared.key());
        }
    }
    if traces_alone {
        return;
    }
    println!(
        "| scene | parts | own kernel, ns/path | the same again | general kernel, ns/path | general/own |\n|---|---|---|---|---|---|"
    );
    let mut rows = Vec::new();
    for (name, scene) in scenes() {
        let own = prepare(&scene, &Settings::new(SIZE, SIZE));
        let all = Settings { aperture: Some(1e-12), max_radiance: Some(1e30), ..Settings::new(SIZE, SIZE) };
        let general = prepare(&with_everything(scene), &all);
        let count = own.key().rows().count();
        let mut renderers =
            [&own, &own, &general].map(|p| Renderer::new(device(), p).unwrap_or_else(|e| panic!("{name}: {e}")));
        let times = race_paths(&mut renderers, [SIZE; 2], ROUNDS, SECONDS, device().info.is_cpu);
        let times = times.unwrap_or_else(|e| panic!("{name}: {e}"));
        let [own, again, general] = [0, 1, 2].map(|i| median(&times[i]));
        let ratios = |i: usize| median(&times[i].iter().zip(&times[0]).map(|(a, b)| a / b).collect::<Vec<_>>());
        println!(
            "| {name} | {count} | {own:.0} | {again:.0} ({:+.1} %) | {general:.0} | {:.2} |",
            100.0 * (ratios(1) - 1.0),
            ratios(2)
        );
        rows.push((name.to_owned(), vec![own, (general - own).max(0.0)]));
    }
    if let Some(folder) = folder {
        let parts = ["the scene's own kernel", "the additional time of the general kernel"];
        let label = "nanoseconds a path";
        let chart = bars("specialisation", "What specialising the kernel to the scene buys", label, &parts, &rows);
        let path = std::path::Path::new(&folder).join("specialisation.svg");
        let written = chart.map(|chart| std::fs::write(&path, chart.wide));
        println!("chart: {}: {written:?}", path.display());
    }
}
