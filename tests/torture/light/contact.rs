//! A lamp that touches the surface that it lights.

use surelight_estimate::{sidak_level, z_test};
use surelight_film::Film;
use surelight_prepare::{Integrator, Settings};
use surelight_scenes::torture::{self, light::contact_radiance};
use surelight_tests::render::{ALPHA, pooled, render};

const SIDE: u32 = 16;
/// Rows from the top whose every pixel is within 3 cm of the lamp.
const NEAR: usize = SIDE as usize * 2;

/// Mean of the closed form over the film, or over its rows that touch the lamp.
fn truth(pixels: std::ops::Range<usize>) -> f64 {
    const GRID: usize = 16;
    let side = 0.5 / f64::from(SIDE);
    let at = |k: usize, sub: usize| (k as f64 + (sub as f64 + 0.5) / GRID as f64) * side;
    let of = |i: usize| {
        let (column, row) = (i % SIDE as usize, i / SIDE as usize);
        let points = (0..GRID * GRID).map(|s| contact_radiance(at(column, s % GRID) - 0.25, at(row, s / GRID)));
        points.sum::<f64>() / (GRID * GRID) as f64
    };
    let n = pixels.len() as f64;
    pixels.map(of).sum::<f64>() / n
}

fn picture(integrator: Integrator, samples: u32) -> Film {
    let settings = Settings { integrator, seed: 35, ..Settings::new(SIDE, SIDE) };
    render(&torture::scene("contact-light"), &settings, 16, samples)
}

/// Joined by multiple importance sampling the picture is Lambert's formula, at the edge too, and
/// every pixel is certified. By the area form alone the pixels at the edge have no variance: they
/// are *not* certified, while those away from it are.
#[test]
fn contact_light() {
    let mis = picture(Integrator::Mis, 64);
    let level = sidak_level(ALPHA, 2);
    for (name, pixels) in [("everywhere", 0..mis.pixels().len()), ("at the edge", 0..NEAR)] {
        let mean = pooled(&mis, 1, pixels.clone());
        // 1e-4 for the midpoint rule at the edge.
        let exact = truth(pixels);
        let test = z_test(mean.mean, mean.variance.sqrt().hypot(1e-4 * exact), exact, level);
        let seen = 100.0 * test.detectable / exact;
        println!(
            "mis, {name}: {:.5}, exactly {exact:.5}, z {:+.2}; a bias of {seen:.2} % would be detected",
            mean.mean, test.z
        );
        assert!(test.p > level && seen < 1.0, "mis, {name}: {test:?}");
    }
    let certified = |film: &Film, pixels: std::ops::Range<usize>| {
        let certificate = film.certify();
        let n = pixels.len() as f64;
        pixels.filter(|&i| certificate.certified[i]).count() as f64 / n
    };
    let area = picture(Integrator::Area, 64);
    let all = mis.pixels().len();
    let shares = [certified(&mis, 0..all), certified(&area, 0..NEAR), certified(&area, all / 2..all)];
    println!("certified: mis {:.3}; area {:.3} at the edge, {:.3} away from it", shares[0], shares[1], shares[2]);
    assert!(shares[0] > 0.98, "mis is not certified");
    assert!(shares[1] < 0.1, "area is certified at the edge");
    assert!(shares[2] > 0.98, "area is not certified away from the edge");
}
