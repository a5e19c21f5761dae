//! Russian roulette: it ends paths, changes no mean, and ends them even where no light is ever
//! lost.

use surelight_estimate::{sidak_level, z_test};
use surelight_film::Film;
use surelight_prepare::{Instrument, Settings};
use surelight_render::Renderer;
use surelight_scenes::{cornell_box, torture::sampling::room};
use surelight_tests::render::{ALPHA, Judge, device, prepare, render, trace};
use surelight_tests::welch::Comparison;

/// Roulette on and off have one mean, at a common limit of bounces (Welch). It begins where three
/// quarters of the light is lost, so that in the Cornell box it applies to most paths; and in a
/// dark room, at any depth, the closed form holds (z).
#[test]
fn rr_on_off() {
    let scene = cornell_box::cornell_box();
    let settings = |seed| Settings { max_bounces: Some(12), seed, ..Settings::new(24, 24) };
    let on = render(&scene, &settings(1), 16, 64);
    let mut prepared = prepare(&scene, &settings(2));
    prepared = prepared.instrumented(Instrument::NoRoulette);
    let off = trace(&prepared, [24, 24], 16, 64);
    Comparison { power: 0.02, pictures: 1, pixels: true }.assert_equal("cornell, roulette on against off", &on, &off);
    for (reflectance, seed) in [(0.2, 3), (0.6, 4)] {
        let film = render(&room(reflectance), &Settings { seed, ..Settings::new(32, 32) }, 16, 64);
        Judge::of(2, 0.003).mean(&format!("room of reflectance {reflectance}"), &film, [1.0; 3]);
    }
}

/// In a white room without light nothing ends a path but roulette, which begins after 64 bounces:
/// rays per path are 65 + Σ_{b ≥ 64} Π_{j = 64}^{b} q_j with q_j = 1 − max(2/(j + 1), 0.001), and
/// their spread is known from the same law.
#[test]
fn white_rooms_end_paths() {
    let mut scene = room(1.0);
    scene.materials.iter_mut().for_each(|m| m.emissive = [0.0; 3]);
    let (mut mean, mut square, mut alive) = (65.0f64, 65.0f64.powi(2), 1.0f64);
    for bounce in 64..100_000 {
        alive *= 1.0 - (2.0 / f64::from(bounce + 1)).max(0.001);
        // One ray more, for those that are still under way.
        mean += alive;
        square += alive * f64::from(2 * (bounce + 1) + 1);
    }
    let prepared = prepare(&scene, &Settings::new(32, 32));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = Film::new(32, 32);
    renderer.trace(&mut film, 0, 8, 8, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    let paths = renderer.counts.paths as f64;
    let found = renderer.counts.rays as f64 / paths;
    let test = z_test(found, ((square - mean * mean) / paths).sqrt(), mean, sidak_level(ALPHA, 1));
    println!("{found:.3} rays per path, {mean:.3} expected, z {:+.2}", test.z);
    assert!(test.p > ALPHA, "{found} rays per path instead of {mean}, z = {}", test.z);
    assert!(test.detectable < 0.02 * mean, "no power: {}", test.detectable);
}

/// A hundred bounces deep: at ρ = 0.99 every pixel is still Le/(1 − ρ), and certified, since
/// weights have a variance (0.8 of the squared mean; a constant chance of 0.95 makes it 10⁷).
#[test]
fn deep_paths_keep_their_mean() {
    let film = render(&room(0.99), &Settings { seed: 5, ..Settings::new(16, 16) }, 16, 16);
    Judge::new(0.02).mean("room of reflectance 0.99", &film, [1.0; 3]);
    let share = film.certify().share();
    println!("{:.1} % of the pixels are certified", 100.0 * share);
    assert!(share > 0.9, "{share}");
}
