//! Case 40: however many samples, their mean does not stagnate.

use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_render::{Goal, Renderer, render};
use surelight_scenes::torture::accumulation::{self, WALL};
use surelight_tests::render::{device, prepare};

/// Samples of the pixel. In a plain f32 sum already 2^22 equal samples are off by percents.
const SPP: u32 = if cfg!(feature = "long") { 1 << 26 } else { 1 << 22 };

#[test]
fn stagnation() {
    let prepared = prepare(&accumulation::stagnation(), &Settings::new(1, 1));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = Film::new(1, 1);
    let goal = Goal { spp: Some(SPP), ..Goal::default() };
    render(&mut renderer, &mut film, &goal, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(film.samples(0), u64::from(SPP));
    for (found, wall) in film.mean(0).into_iter().zip(WALL) {
        let off = found / f64::from(wall) - 1.0;
        println!("{wall} after {SPP} samples: off by {off:+.1e}");
        assert!(off.abs() < 1e-5, "{wall} after {SPP} samples is off by {off:+.1e}");
    }
}
