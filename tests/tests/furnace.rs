//! Furnaces: scenes whose every pixel is known, whatever path light takes.

use surelight_estimate::{sidak_level, student_t_survival};
use surelight_film::Film;
use surelight_prepare::{Directions, Integrator, Sampler, Settings};
use surelight_scenes::furnace;
use surelight_tests::render::{ALPHA, Judge, all, render};

/// Smallest bias that the pooled tests must be able to see.
const POWER: f64 = 0.003;

/// No single pixel is off: Student's t, Šidák over pixels and channels.
fn assert_pixels(name: &str, film: &Film, truth: [f64; 3]) {
    let level = sidak_level(ALPHA, 3 * film.pixels().len());
    for i in all(film) {
        let (mean, variance) = (film.mean(i), film.variance_of_mean(i).expect("several batches"));
        for c in 0..3 {
            let error = variance[c].sqrt().hypot(1e-7 * truth[c]);
            let t = (mean[c] - truth[c]) / error;
            let p = 2.0 * student_t_survival(t.abs(), film.degrees_of_freedom(i));
            let at = (i as u32 % film.width(), i as u32 / film.width());
            assert!(p > level, "{name}: pixel {at:?} is {} ± {error:.1e} instead of {}", mean[c], truth[c]);
        }
    }
}

/// In a closed room where each surface emits L·(1 − ρ), every pixel is L = Le/(1 − ρ).
#[test]
fn closed_room_of_several_reflectances() {
    let film = render(&furnace::furnace(), &Settings::new(40, 40), 16, 64);
    let truth = furnace::RADIANCE.map(f64::from);
    Judge::new(POWER).mean("furnace", &film, truth);
    assert_pixels("furnace", &film, truth);
}

/// For every integrator and every sampler.
#[test]
fn closed_room_by_every_estimator() {
    let plain = Settings::new(24, 24);
    let with = |integrator| Settings { integrator, ..plain.clone() };
    let from = |sampler| Settings { sampler, ..plain.clone() };
    let ways = [
        with(Integrator::Hemisphere(Directions::Bsdf)),
        with(Integrator::Hemisphere(Directions::Cosine)),
        with(Integrator::Hemisphere(Directions::Uniform)),
        with(Integrator::Area),
        from(Sampler::Independent),
        from(Sampler::Stratified),
    ];
    for (seed, settings) in (0..).zip(&ways) {
        let film = render(&furnace::furnace(), &Settings { seed, ..settings.clone() }, 16, 64);
        let name = format!("furnace, {:?}, {:?}", settings.integrator, settings.sampler);
        // Points on lights alone are noisy where surfaces meet.
        let power = if settings.integrator == Integrator::Area { 0.02 } else { POWER };
        Judge::of(ways.len(), power).mean(&name, &film, furnace::RADIANCE.map(f64::from));
    }
}

#[test]
fn bare_room_by_depth() {
    for bounces in [Some(0), Some(1), Some(2), Some(5), None] {
        let seed = bounces.unwrap_or(100);
        let settings = Settings { max_bounces: bounces, seed, ..Settings::new(32, 32) };
        let film = render(&furnace::bare_room(), &settings, 16, 64);
        let truth = bounces.map_or(furnace::RADIANCE.map(f64::from), furnace::after_bounces);
        let name = format!("bare room after {bounces:?} bounces");
        Judge::of(5, POWER).mean(&name, &film, truth);
        assert_pixels(&name, &film, truth);
    }
}
