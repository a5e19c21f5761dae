//! Case 17: instances under any transform render as their copies.

use surelight_accel::{BuildOptions, Instancing};
use surelight_prepare::{Part, Settings};
use surelight_scenes::torture;
use surelight_tests::render::{all, pooled, prepare, trace};
use surelight_tests::welch::Comparison;

#[test]
fn instance_vs_baked() {
    let scene = torture::scene("instance-vs-baked");
    let film = |instancing, seed| {
        let build = BuildOptions { instancing, ..BuildOptions::default() };
        let prepared = prepare(&scene, &Settings { seed, build, ..Settings::new(48, 32) });
        assert_eq!(prepared.key().has(Part::Instances), instancing == Instancing::Always);
        trace(&prepared, [48, 32], 16, 16)
    };
    let (placed, baked) = (film(Instancing::Always, 1), film(Instancing::Never, 1));
    let mean = |film| pooled(film, 1, all(film)).mean;
    let change = mean(&placed) / mean(&baked) - 1.0;
    println!("with the same samples instances change the mean by {change:+.1e}");
    assert!(change.abs() < 2e-3, "with the same samples instances change the mean by {change:+.1e}");
    let comparison = Comparison { power: 0.02, pictures: 1, pixels: true };
    comparison.assert_equal("instances", &film(Instancing::Always, 2), &baked);
}
