//! A kernel specialised to its scene gives the picture of the general kernel: the same scene with
//! an invisible speck that needs every feature, compared by Welch's test.

use surelight_prepare::{Settings, TABLE};
use surelight_scene::Scene;
use surelight_scenes::{cornell_box, glass, textured};
use surelight_tests::kernel_keys::is_chosen_elsewhere;
use surelight_tests::render::{prepare, trace};
use surelight_tests::scenes::{map, with_everything};
use surelight_tests::welch::Comparison;

fn check(scene: &Scene, comparison: Comparison, batches: u32, samples: u32) {
    let size = [24, 24];
    let own = prepare(scene, &Settings { seed: 1, ..Settings::new(24, 24) });
    // A lens without width and a clamp that nothing reaches.
    let all = Settings { seed: 2, aperture: Some(1e-12), max_radiance: Some(1e30), ..Settings::new(24, 24) };
    let general = prepare(&with_everything(scene.clone()), &all);
    for row in TABLE.iter().filter(|row| !general.key().has(row.part)) {
        assert!(is_chosen_elsewhere(row), "the general kernel lacks {}", row.name);
    }
    let saved = TABLE.len() - own.key().rows().count();
    assert!(saved > 5, "{} needs nearly everything by itself", scene.name);
    let (own, general) = (trace(&own, size, batches, samples), trace(&general, size, batches, samples));
    comparison.assert_equal(&format!("{}, without {saved} parts", scene.name), &own, &general);
}

const PICTURES: usize = 3;

#[test]
fn diffuse() {
    let comparison = Comparison { power: 0.05, pictures: PICTURES, pixels: true };
    check(&cornell_box::cornell_box(), comparison, 16, 16);
}

#[test]
fn textures_under_a_sky() {
    // Pixels are far from normal here and below; their mean is near enough.
    let mut scene = textured::textured();
    scene.environment = Some(map(16, 8, |x, y| [(x % 5) as f32, 1.0, (y % 3) as f32]));
    check(&scene, Comparison { power: 0.1, pictures: PICTURES, pixels: false }, 16, 16);
}

#[test]
fn glass() {
    check(&glass::glass(), Comparison { power: 0.25, pictures: PICTURES, pixels: false }, 16, 16);
}

/// Kernels with coverage tests and textures run loops within loops, whose iterations CPU drivers
/// add up to a limit that ends them all silently. Dispatches grow while they are fast: on a small
/// picture they are, and nothing may be lost.
#[test]
fn long_dispatches_of_the_general_kernel_lose_nothing() {
    let scene = with_everything(glass::glass());
    // Fails where traversals are cut short.
    trace(&prepare(&scene, &Settings::new(8, 8)), [8, 8], 4, 256);
}
