//! The files of `assets/gltf/` that are made for one extension each: read from disk, they have the
//! stated radiance.

use std::path::PathBuf;

use surelight_prepare::Settings;
use surelight_scene::{Environment, LoadOptions, Scene, load};
use surelight_scenes::extensions::FILES;
use surelight_tests::render::{Judge, all, render};

fn file(name: &str) -> Scene {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("../assets/gltf/{name}.glb"));
    let scene = load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
    scene
}

fn in_white_sky(name: &str) -> Scene {
    Scene { environment: Some(Environment::Uniform([1.0; 3])), ..file(name) }
}

/// 32 × 32 pixels × 512 samples: a lobe that is chosen 1 time in 50 deviates by 1 % of its share;
/// the test states its power.
#[test]
fn plates_and_slabs_show_what_is_stated() {
    let known: Vec<_> = FILES.iter().filter_map(|f| Some((f.entry.name, f.radiance?))).collect();
    // Without random choices, some roundings of f32 remain.
    let judge = Judge { resolution: 1e-6, ..Judge::of(known.len(), 0.04) };
    for (name, radiance) in known {
        let film = render(&in_white_sky(name), &Settings::new(32, 32), 16, 32);
        judge.mean(name, &film, radiance);
    }
}

#[test]
fn sheen_has_its_colour() {
    let film = render(&in_white_sky("sheen"), &Settings::new(8, 8), 16, 16);
    for i in all(&film) {
        let [r, g, b] = film.mean(i);
        assert!(r > 0.02 && r < 1.0, "{r}");
        assert!((g / r - 0.5).abs() < 1e-5 && (b / r - 0.25).abs() < 1e-5, "{r} : {g} : {b}");
    }
}

/// A sun's light needs no chance: pixels are exact.
#[test]
fn turning_the_grain_is_turning_the_plate() {
    let size = 24;
    let film = render(&file("anisotropy"), &Settings::new(size, size), 2, 1);
    // A pixel in the middle of each third, some rows down.
    let plate = |i: u32| film.mean((size * 12 + size * (2 * i + 1) / 6) as usize);
    let [by_extension, by_node, not_turned] = [0, 1, 2].map(plate);
    println!("{by_extension:?}, {by_node:?}, {not_turned:?}");
    for c in 0..3 {
        assert!(by_node[c] > 0.01);
        assert!((by_extension[c] / by_node[c] - 1.0).abs() < 1e-4, "{by_extension:?} instead of {by_node:?}");
        assert!((not_turned[c] / by_node[c] - 1.0).abs() > 0.1, "{not_turned:?} is no different");
    }
}
