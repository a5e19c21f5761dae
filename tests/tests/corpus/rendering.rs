//! Every valid file renders: no sample lost, and a picture that can be one of it.

use std::path::Path;
use std::time::Instant;

use surelight_film::Film;
use surelight_prepare::{Prepared, Settings};
use surelight_render::Renderer;
use surelight_scene::{Environment, LoadOptions, load};
use surelight_tests::render::{all, device};

use crate::{corpus, files_below};

const SIZE: u32 = 64;
/// 2 batches of 4: 8 samples per pixel.
const BATCHES: u32 = 2;
const SAMPLES: u32 = 4;

/// glTF's base under Fresnel returns up to this much more than it gets, averaged over directions
/// (see shaders/README.md), and 8 samples of 4,096 pixels stray by less than the rest.
const MAX_WHITE_SKY_RADIANCE: f64 = 1.06;
/// Share of the picture that a file must fill at least, through its own camera or the one that
/// frames it.
const MIN_COVERAGE: f64 = 0.005;

/// Files whose picture under a white sky is that sky and nothing else: points and lines, an alpha
/// that is never reached, and a smooth mirror of white metal.
const UNSEEN: [&str; 10] = [
    "Mesh_PrimitiveMode_00",
    "Mesh_PrimitiveMode_01",
    "Mesh_PrimitiveMode_02",
    "Mesh_PrimitiveMode_03",
    "Mesh_PrimitiveMode_07",
    "Mesh_PrimitiveMode_08",
    "Mesh_PrimitiveMode_09",
    "Mesh_PrimitiveMode_10",
    "Material_AlphaMask_03",
    "Material_MetallicRoughness_06",
];

#[test]
fn every_valid_file_renders() {
    let Some(corpus) = corpus() else { return };
    let mut failures = Vec::new();
    let mut rendered = 0;
    for folder in ["geometry", "materials", "scenes", "textures"] {
        for path in files_below(&corpus.join(folder)) {
            let short = path.strip_prefix(&corpus).unwrap_or(&path).display().to_string();
            // A later version and a required extension that does not exist: both are refused (see
            // `loading`).
            if short.ends_with("Compatibility_04.gltf") || short.ends_with("Compatibility_05.gltf") {
                continue;
            }
            rendered += 1;
            if let Err(cause) = render(&path, &short) {
                println!("FAILED   {short}: {cause}");
                failures.push(format!("{short}: {cause}"));
            }
        }
    }
    println!("{rendered} files rendered");
    assert!(rendered > 170, "only {rendered} files");
    assert!(failures.is_empty(), "{failures:#?}");
}

fn render(path: &Path, short: &str) -> Result<(), String> {
    let started = Instant::now();
    let mut scene = load(path, &LoadOptions::default()).map_err(|e| e.to_string())?;
    // Whatever light it has: many files have a dim lamp or a lit screen that shows little of them.
    let own_light = scene.has_light();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
    let loaded = started.elapsed();
    let settings = Settings::new(SIZE, SIZE);
    let prepared = Prepared::new(&scene, &camera, &settings).map_err(|e| e.to_string())?;
    let built = started.elapsed();
    let mut renderer = Renderer::new(device(), &prepared).map_err(|e| e.to_string())?;
    let compiled = started.elapsed();
    let mut film = Film::new(SIZE, SIZE);
    renderer.trace(&mut film, 0, BATCHES, SAMPLES, &mut |_| true).map_err(|e| e.to_string())?;
    let traced = started.elapsed();

    let pixels: Vec<f64> = all(&film).map(|i| film.mean(i).iter().sum::<f64>() / 3.0).collect();
    let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
    // Nothing but the sky shows exactly the sky.
    let cover = pixels.iter().filter(|&&l| l != 1.0).count() as f64 / pixels.len() as f64;
    println!(
        "load {:5.2} s, prepare {:5.2} s, compile {:5.2} s, trace {:5.2} s: mean {mean:8.4}, cover {:5.1} %  {short}",
        loaded.as_secs_f64(),
        (built - loaded).as_secs_f64(),
        (compiled - built).as_secs_f64(),
        (traced - compiled).as_secs_f64(),
        100.0 * cover
    );
    let counts = renderer.counts;
    if counts.dropped + counts.truncated > 0 {
        return Err(format!("{} samples were dropped and {} rays cut short", counts.dropped, counts.truncated));
    }
    if !pixels.iter().all(|l| l.is_finite() && *l >= 0.0) {
        return Err("a pixel is negative or no number".into());
    }
    if UNSEEN.iter().any(|name| short.contains(name)) {
        return if cover == 0.0 { Ok(()) } else { Err("something shows that has no area".into()) };
    }
    if cover < MIN_COVERAGE {
        return Err(format!("only {:.2} % of the picture shows the scene", 100.0 * cover));
    }
    let seen = pixels.iter().filter(|&&l| l != 1.0).sum::<f64>() / (cover * pixels.len() as f64);
    if seen < 0.01 {
        return Err(format!("the scene is black: {seen:.1e} on average"));
    }
    if !own_light && mean > MAX_WHITE_SKY_RADIANCE {
        return Err(format!("under a sky of radiance 1 the mean is {mean}"));
    }
    Ok(())
}
