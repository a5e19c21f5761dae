//! The cost of more triangles: `cargo bench --bench size [-- FOLDER [MOST]]`.
//!
//! One terrain, ever finer, from 8 triangles to 4 million (or `MOST`), through the same camera, so
//! that nearly the same light is found. Only paths are timed, without the first-hit features and
//! the film. `FOLDER` gets the chart.

use std::time::Instant;

use surelight_bench::{
    chart::plain::curves,
    paths::{median, race_paths},
};
use surelight_prepare::Settings;
use surelight_render::Renderer;
use surelight_scenes::probes::terrain;
use surelight_tests::render::{device, prepare};

const SIZE: u32 = 192;
const ROUNDS: u32 = 5;

/// Seconds of a round.
const SECONDS: f64 = 0.5;

/// Sides of the terrains in squares of two triangles.
const SIDES: [u32; 7] = [2, 7, 22, 71, 224, 707, 1415];

fn main() {
    let mut words = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let folder = words.next();
    let most: u64 = words.next().and_then(|w| w.parse().ok()).unwrap_or(u64::MAX);
    let settings = Settings::new(SIZE, SIZE);
    let info = &device().info;
    println!("adapter {}, {}; {SIZE}x{SIZE} pixels, median of {ROUNDS} rounds", info.name, info.driver);
    println!("one binding holds {} MiB", info.max_binding >> 20);
    println!(
        "| triangles | built in s | uploaded in s | MiB on the device | bytes a triangle | ns/path | Mpaths/s | rays a path |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut renderers = Vec::new();
    let mut rows = Vec::new();
    // Buffers whose size is the picture's are on every device that shows anything; they are
    // reported once.
    let mut fixed = None;
    for side in SIDES {
        let triangles = 2 * u64::from(side) * u64::from(side);
        if triangles > most {
            break;
        }
        let scene = terrain(side);
        let started = Instant::now();
        let prepared = prepare(&scene, &settings);
        let built = started.elapsed().as_secs_f64();
        let renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{triangles} triangles: {e}"));
        let fixed = *fixed.get_or_insert(renderer.device_bytes);
        rows.push((triangles, built, renderer.compile_seconds, renderer.device_bytes, fixed));
        renderers.push(renderer);
    }
    let times = race_paths(&mut renderers, [SIZE; 2], ROUNDS, SECONDS, info.is_cpu).unwrap_or_else(|e| panic!("{e}"));
    let mut points = Vec::new();
    for ((renderer, times), (triangles, built, uploaded, bytes, fixed)) in renderers.iter().zip(&times).zip(rows) {
        let ns = median(times);
        let each =
            if triangles >= 1000 { format!("{:.1}", (bytes - fixed) as f64 / triangles as f64) } else { "–".into() };
        let rays = renderer.counts.rays as f64 / renderer.counts.paths as f64;
        println!(
            "| {triangles} | {built:.2} | {uploaded:.2} | {:.1} | {each} | {ns:.0} | {:.3} | {rays:.2} |",
            bytes as f64 / f64::from(1 << 20),
            1e3 / ns,
        );
        points.push((triangles as f64, ns));
    }
    if let Some(folder) = folder {
        let chart =
            curves("size", "What more triangles cost", ["triangles", "nanoseconds a path"], &[("terrain", points)]);
        let path = std::path::Path::new(&folder).join("size.svg");
        let written = chart.map(|chart| std::fs::write(&path, chart.wide));
        println!("chart: {}: {written:?}", path.display());
    }
}
