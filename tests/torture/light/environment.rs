//! Environment maps: the right way round, sampled as claimed, and lighting surfaces as the integral
//! over the map says.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DVec3};
use surelight_estimate::{chi_squared_test, sidak_level};
use surelight_prepare::Settings;
use surelight_scene::{Environment, Scene};
use surelight_scenes::shapes::Shape;
use surelight_tests::light::{Query, probe, random_queries};
use surelight_tests::random::Random;
use surelight_tests::render::{ALPHA, Judge, all, prepare, render};
use surelight_tests::scenes::{add, lambert, look_at, map, orthographic, pinhole};

/// Nothing but a sky.
fn sky(environment: Environment) -> Scene {
    Scene {
        name: "sky".into(),
        cameras: vec![pinhole(DAffine3::IDENTITY, 60.0)],
        environment: Some(environment),
        ..Scene::default()
    }
}

fn turned(environment: Environment, angle: f32) -> Environment {
    match environment {
        Environment::Map { map, scale, .. } => Environment::Map { map, scale, rotation: angle },
        other => other,
    }
}

/// The direction at (u, v) of a map: u = ½ + atan2(z, x)/2π, v = ½ − asin(y)/π.
fn direction(u: f64, v: f64) -> DVec3 {
    let (phi, y) = ((u - 0.5) * TAU, (PI * (0.5 - v)).sin());
    let r = (1.0 - y * y).sqrt();
    DVec3::new(r * phi.cos(), y, r * phi.sin())
}

/// Radiance of a map in a direction, in f64: bilinear between texel centres, round the seam,
/// clamped at the poles.
fn lookup(environment: &Environment, direction: DVec3) -> DVec3 {
    let Environment::Map { map, rotation, scale } = environment else { panic!("not a map") };
    let (width, height) = (i64::from(map.width), i64::from(map.height));
    let u = 0.5 + direction.z.atan2(direction.x) / TAU + f64::from(*rotation) / TAU;
    let v = 0.5 - direction.y.clamp(-1.0, 1.0).asin() / PI;
    let (x, y) = (u * width as f64 - 0.5, v * height as f64 - 0.5);
    let texel = |x: i64, y: i64| {
        let at = y.clamp(0, height - 1) * width + x.rem_euclid(width);
        DVec3::from(map.texels[at as usize].map(f64::from))
    };
    let (x0, y0) = (x.floor() as i64, y.floor() as i64);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let row = |y| texel(x0, y).lerp(texel(x0 + 1, y), fx);
    row(y0).lerp(row(y0 + 1), fy) * f64::from(*scale)
}

/// A map that is different everywhere.
fn colourful(width: u32, height: u32) -> Environment {
    map(width, height, |x, y| [(x + 1) as f32, (y + 1) as f32, ((3 * x + 5 * y) % 7) as f32])
}

/// A map with a small sun 1e4 as bright as the rest, black parts, and noise.
fn sunny(width: u32, height: u32, seed: u64) -> Environment {
    let mut random = Random::new(seed);
    let noise: Vec<f32> = (0..width * height).map(|_| random.unit()).collect();
    map(width, height, |x, y| {
        let sun = if (x, y) == (width / 5, height / 4) { 1e4 } else { 1.0 };
        let ground = if y > 2 * height / 3 && x > width / 2 { 0.0 } else { 1.0 };
        let value = noise[(y * width + x) as usize] * sun * ground;
        [value, 0.5 * value, 0.25 * value]
    })
}

/// Every texel's centre shows its texel, where glTF space says, also when the map is turned.
#[test]
fn directions_find_their_texels() {
    for angle in [0.0f32, 1.0, -2.5, 7.0] {
        let environment = turned(colourful(16, 8), angle);
        let prepared = prepare(&sky(environment.clone()), &Settings::new(8, 8));
        let mut random = Random::new(1);
        let mut directions: Vec<_> =
            (0..128).map(|k| direction((f64::from(k % 16) + 0.5) / 16.0, (f64::from(k / 16) + 0.5) / 8.0)).collect();
        directions.extend((0..2000).map(|_| random.cube().as_dvec3().normalize()));
        directions.extend([DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z]);
        let queries: Vec<_> = directions.iter().map(|&d| Query::towards(d)).collect();
        for (query, found) in queries.iter().zip(probe(&prepared, "probe_environment_eval", &queries)) {
            let direction = DVec3::from(query.position.map(f64::from));
            let exact = lookup(&environment, direction);
            let mut difference = DVec3::from(found.radiance.map(f64::from)) - exact;
            if direction.x == 0.0 && direction.z == 0.0 {
                // At a pole any column is right; green identifies the row.
                difference = DVec3::splat(difference.y);
            }
            let error = difference.abs().max_element();
            // The map changes by 16 per texel at most.
            assert!(error < 1e-4, "{direction} turned by {angle}: {:?} instead of {exact}", found.radiance);
        }
    }
}

/// The picture's right, up and forward are the map's, through the whole renderer; a turn of +90°
/// about +Y takes +X to −Z.
#[test]
fn cameras_see_the_map_the_right_way_round() {
    for angle in [0.0f32, FRAC_PI_2 as f32] {
        let environment = turned(colourful(16, 8), angle);
        for forward in [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z, DVec3::Y, DVec3::NEG_Y] {
            let up = if forward.y == 0.0 { DVec3::Y } else { DVec3::X };
            let mut scene = sky(environment.clone());
            // Small enough a view to be flat, large enough that right and up show.
            let to_world = look_at(DVec3::ZERO, forward, up);
            scene.cameras = vec![pinhole(to_world, 2.0)];
            let film = render(&scene, &Settings::new(2, 2), 4, 64);
            let half = 1.0f64.to_radians().tan();
            let unturned = |d: DVec3| {
                let (sin, cos) = f64::from(angle).sin_cos();
                DVec3::new(d.x * cos - d.z * sin, d.y, d.x * sin + d.z * cos)
            };
            for i in all(&film) {
                // The mean over the pixel's quarter of the view.
                let points = (0..256).map(|k| {
                    let at = |k: usize| (k as f64 + 0.5) / 16.0;
                    let (x, y) = (at(k % 16) - 1.0 + (i % 2) as f64, 1.0 - at(k / 16) - (i / 2) as f64);
                    unturned(to_world.transform_vector3(DVec3::new(half * x, half * y, -1.0)).normalize())
                });
                let exact = points.map(|d| lookup(&turned(environment.clone(), 0.0), d)).sum::<DVec3>() / 256.0;
                let error = (DVec3::from(film.mean(i)) - exact).abs().max_element();
                // A pixel at a pole covers a quarter of all columns.
                let allowed = if forward.y == 0.0 { 0.01 } else { 0.2 };
                assert!(error < allowed, "towards {forward}, turned by {angle}: {:?}, not {exact}", film.mean(i));
            }
        }
    }
}

/// Samples follow the pdf that BSDF sampling evaluates: χ² over quarters of texels.
#[test]
fn samples_follow_the_pdf() {
    const SAMPLES: usize = 1_000_000;
    let cases = [
        ("sunny", sunny(32, 16, 3)),
        ("turned", turned(sunny(32, 16, 4), 2.0)),
        ("constant", map(8, 4, |_, _| [1.0; 3])),
        ("odd", sunny(31, 7, 5)),
        ("single row", map(5, 1, |x, _| [x as f32; 3])),
    ];
    let level = sidak_level(ALPHA, cases.len());
    for (k, (name, environment)) in cases.iter().enumerate() {
        let Environment::Map { map, rotation, .. } = environment else { panic!("not a map") };
        let (columns, rows) = (2 * map.width as usize, 2 * map.height as usize);
        let prepared = prepare(&sky(environment.clone()), &Settings::new(8, 8));
        let turn = f64::from(*rotation) / TAU;
        // A texel's halves along v have the same solid angle when they are cut at the middle of its
        // height.
        let edge = |row: usize| {
            let at = |r: usize| (PI * r as f64 / f64::from(map.height)).cos();
            if row.is_multiple_of(2) { at(row / 2) } else { 0.5 * (at(row / 2) + at(row / 2 + 1)) }
        };
        let edges: Vec<_> = (0..=rows).map(edge).collect();
        let centres: Vec<_> = (0..columns * rows)
            .map(|cell| {
                let (u, y) = (
                    ((cell % columns) as f64 + 0.5) / columns as f64,
                    0.5 * (edges[cell / columns] + edges[cell / columns + 1]),
                );
                let phi = (u - turn - 0.5) * TAU;
                let r = (1.0 - y * y).sqrt();
                Query::towards(DVec3::new(r * phi.cos(), y, r * phi.sin()))
            })
            .collect();
        let expected: Vec<f64> = probe(&prepared, "probe_environment_eval", &centres)
            .iter()
            .enumerate()
            .map(|(cell, s)| {
                let solid_angle = TAU / columns as f64 * (edges[cell / columns] - edges[cell / columns + 1]);
                f64::from(s.pdf) * solid_angle * SAMPLES as f64
            })
            .collect();
        let mass = expected.iter().sum::<f64>() / SAMPLES as f64;
        assert!((mass - 1.0).abs() < 1e-5, "{name}: the pdf integrates to {mass}");

        let samples = probe(&prepared, "probe_environment_sample", &random_queries([0.0; 3], SAMPLES, 20 + k as u64));
        let mut observed = vec![0u64; columns * rows];
        let mut strayed = 0;
        for s in &samples {
            let d = s.direction();
            assert!((d.length() - 1.0).abs() < 1e-5 && s.pdf > 0.0, "{name}: {s:?}");
            let u = (0.5 + d.z.atan2(d.x) / TAU + turn).rem_euclid(1.0);
            let column = ((u * columns as f64) as usize).min(columns - 1);
            let row = edges[1..].iter().position(|&e| d.y >= e).unwrap_or(rows - 1);
            observed[row * columns + column] += 1;
            // At a texel's very edge rounding may find its neighbour.
            strayed += usize::from((s.pdf / s.other_pdf - 1.0).abs() > 1e-5);
        }
        assert!(strayed < SAMPLES / 20_000, "{name}: {strayed} samples have another pdf than their directions");
        let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{name}: {e}"));
        println!("{name}: χ² p = {:.4}, {} degrees of freedom, mass {mass:.7}, {strayed} strayed", test.p, test.dof);
        assert!(test.p > level, "{name}: p = {:.1e}", test.p);
    }
}

/// Irradiance of a plane from a map, by the midpoint rule over at least four cells per texel.
fn irradiance(environment: &Environment, normal: DVec3) -> DVec3 {
    let (columns, rows) = (1024, 512);
    let mut sum = DVec3::ZERO;
    for row in 0..rows {
        let edge = |r: usize| (PI * r as f64 / rows as f64).cos();
        let solid_angle = TAU / columns as f64 * (edge(row) - edge(row + 1));
        for column in 0..columns {
            let d = direction((column as f64 + 0.5) / columns as f64, (row as f64 + 0.5) / rows as f64);
            sum += lookup(environment, d) * d.dot(normal).max(0.0) * solid_angle;
        }
    }
    sum
}

/// A single bright texel, at the equator, beside a pole and under the seam, lights planes as the
/// integral over it says.
#[test]
fn one_hot_texel() {
    let reflectance = [0.8f32, 0.5, 0.3];
    let texels = [("equator", 11, 8), ("pole", 5, 0), ("seam", 0, 6), ("nadir", 30, 15)];
    let normals = [DVec3::Y, DVec3::X, DVec3::new(-1.0, 0.3, -2.0).normalize(), DVec3::NEG_Y];
    let mut pictures = Vec::new();
    for (name, column, row) in texels {
        for normal in normals {
            let environment =
                turned(map(32, 16, |x, y| if (x, y) == (column, row) { [100.0; 3] } else { [0.0; 3] }), 0.4);
            let exact = irradiance(&environment, normal);
            // Where there is almost no light, relative errors are meaningless.
            if exact.x > 0.02 {
                pictures.push((format!("{name} on {normal:.2}"), environment, normal, exact));
            }
        }
    }
    assert!(pictures.len() > 5);
    let judge = Judge { resolution: 1e-4, ..Judge::of(pictures.len(), 0.015) };
    for (seed, (name, environment, normal, exact)) in (0..).zip(&pictures) {
        let mut scene = Scene { environment: Some(environment.clone()), ..Scene::default() };
        let side = normal.any_orthonormal_vector();
        add(&mut scene, Shape::parallelogram(DVec3::ZERO, side, normal.cross(side)), lambert(reflectance));
        scene.cameras = vec![orthographic(look_at(*normal * 2.0, DVec3::ZERO, side), 0.5)];
        let film = render(&scene, &Settings { seed, ..Settings::new(32, 32) }, 16, 32);
        let truth = *exact * DVec3::from(reflectance.map(f64::from)) / PI;
        judge.mean(&format!("texel at {name}"), &film, truth.to_array());
    }
}
