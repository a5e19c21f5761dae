//! Which light: the table's choice among a few, and a map's among its texels.

use glam::DVec3;
use surelight_estimate::chi_squared_test;
use surelight_prepare::{Integrator, Settings};
use surelight_tests::light::{Query, Sample, probe, random_queries};
use surelight_tests::render::{ALPHA, prepare};
use surelight_tests::scenes::map;

use crate::lamps::{Chosen, POINT, POSITION, SAMPLES, area_pdf, chosen, lamps, samples_of, scene};

/// The table's choice among a lamp, a point light and an environment follows the stated
/// probabilities of samples.
#[test]
fn choice_follows_the_pdf() {
    let lamps: Vec<_> = lamps().into_iter().take(1).collect();
    let prepared = prepare(&scene(&lamps), &Settings::new(8, 8));
    let all = samples_of(&lamps, &prepared, 1);
    let (mut observed, mut expected) = (Vec::new(), Vec::new());
    // The estimate of a point light over its true irradiance is one over its probability.
    let r2 = (POINT - DVec3::from(POSITION.map(f64::from))).length_squared();
    let points: Vec<_> = all.iter().filter(|(_, c)| *c == Chosen::Point).collect();
    let value = f64::from(points.first().expect("the point light is chosen").0.radiance[0]);
    observed.push(points.len() as u64);
    expected.push(0.3 / r2 / value * SAMPLES as f64);
    assert!(points.iter().all(|(s, _)| s.pdf == 0.0), "a point has no solid angle");
    // And the environment's pdf over the pdf of the map alone is its probability.
    let skies: Vec<_> = all.iter().filter(|(_, c)| *c == Chosen::Environment).map(|(s, _)| *s).collect();
    let directions: Vec<_> = skies.iter().take(64).map(|s| Query::towards(s.direction())).collect();
    let alone = probe(&prepared, "probe_environment_eval", &directions);
    observed.push(skies.len() as u64);
    expected.push(f64::from(skies[0].pdf) / f64::from(alone[0].pdf) * SAMPLES as f64);
    for (s, map) in skies.iter().zip(&alone) {
        let exact = map.radiance[0] / s.pdf;
        assert!((s.radiance[0] / exact - 1.0).abs() < 1e-4, "{s:?} against {map:?}");
    }
    observed.push(SAMPLES as u64 - observed.iter().sum::<u64>());
    expected.push(SAMPLES as f64 - expected.iter().sum::<f64>());
    let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{e}"));
    println!("choice of a light: {observed:?}, χ² p = {:.4}", test.p);
    assert!(test.p > ALPHA, "{observed:?} instead of {expected:?}, p = {:.1e}", test.p);
}

/// Half of the choice goes to every emitter alike, half by power: luminance times area.
#[test]
fn choice_is_half_even_half_by_power() {
    // Whitted chooses by the table however many there are, with points that are uniform, and does
    // without the environment.
    let lamps: Vec<_> = lamps().into_iter().step_by(2).take(2).collect();
    let emitters = lamps.len() as f64 + 1.0; // the point light
    let settings = Settings { integrator: Integrator::Whitted, ..Settings::new(8, 8) };
    let prepared = prepare(&scene(&lamps), &settings);
    let samples = probe(&prepared, "probe_light", &random_queries(POSITION, 20_000, 2));
    let mut per_power = Vec::new();
    for (k, lamp) in lamps.iter().enumerate() {
        let Some(s) = samples.iter().find(|s| matches!(chosen(&lamps, s), Chosen::Lamp(of, ..) if of == k)) else {
            continue;
        };
        let [a, b, c] = lamp.corners;
        let area = 0.5 * (b - a).cross(c - a).length();
        let luminance: f64 = lamp.radiance.iter().zip([0.2126, 0.7152, 0.0722]).map(|(&r, w)| f64::from(r) * w).sum();
        let by_power = area_pdf(lamp, s) * area - 0.5 / emitters;
        per_power.push(by_power / (luminance * area));
    }
    assert_eq!(per_power.len(), 2);
    // Rounding of the even share weighs most in the faintest lamp.
    for ratio in &per_power {
        assert!((ratio / per_power[0] - 1.0).abs() < 1e-3, "{per_power:?}");
    }
}

/// A large map leaves the choice of a texel few random bits, and among other lights fewer: a bright
/// spot in a dark sky must still be chosen as often as it should.
///
/// A million samples of the sky estimate its share, about 2/3, to 0.07 %: a bias of 0.33 % would be
/// detected 9 times in 10.
#[test]
fn large_maps_are_sampled_fairly() {
    let (width, height) = (1024u32, 512u32);
    let bright = |x: u32, y: u32| (300..316).contains(&x) && (100..116).contains(&y);
    let mut scene = scene(&lamps());
    scene.environment =
        Some(map(width, height, |x, y| [if bright(x, y) { 50.0 } else { 0.001 + 0.002 * (x % 7) as f32 }; 3]));
    let settings = Settings { integrator: Integrator::Area, ..Settings::new(8, 8) };
    let prepared = prepare(&scene, &settings);
    let samples = probe(&prepared, "probe_light", &random_queries(POSITION, 2_000_000, 5));
    let skies: Vec<_> = samples.iter().filter(|s| s.distance > 1e30).map(Sample::direction).collect();
    // Inside the spot's edge, where the pdf is constant.
    let texel = |d: &DVec3| {
        let u = 0.5 + d.z.atan2(d.x) / std::f64::consts::TAU;
        ((u * f64::from(width)) as u32, (d.y.acos() / std::f64::consts::PI * f64::from(height)) as u32)
    };
    let inside = |x: u32, y: u32| (301..315).contains(&x) && (101..115).contains(&y);
    let found = skies.iter().map(texel).filter(|&(x, y)| inside(x, y)).count();
    let mut share = 0.0;
    let centre = |x: u32, y: u32| {
        let turn = std::f64::consts::TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5);
        let (sin, cos) = (std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(height)).sin_cos();
        DVec3::new(sin * turn.cos(), cos, sin * turn.sin())
    };
    for y in 101..115 {
        let reported = probe(&prepared, "probe_environment_eval", &[Query::towards(centre(308, y))])[0].other_pdf;
        let edge = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(height)).cos();
        share += 14.0 * f64::from(reported) * std::f64::consts::TAU / f64::from(width) * (edge(y) - edge(y + 1));
    }
    let n = skies.len() as f64;
    let z = (found as f64 - share * n) / (n * share * (1.0 - share)).sqrt();
    println!("{found} of {n} samples of the sky in the spot, {:.1} expected, z {z:+.2}", share * n);
    assert!(n > 500_000.0 && (0.3..0.9).contains(&share), "{n} samples, share {share}");
    assert!(z.abs() < 3.3, "{found} samples instead of {}, z = {z}", share * n);
}
