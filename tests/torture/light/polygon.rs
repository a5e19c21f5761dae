//! Direct light with a closed form in every pixel: a polygon by Lambert's formula, points, spots
//! and parallel light by theirs.
//!
//! Each pixel's truth is the mean of the formula over the pixel, by the midpoint rule in f64.
//! Pixels are tested one by one (Student's t, Šidák) and all together.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec3;
use surelight_estimate::{detectable_bias, sidak_level, student_t_survival, z_test};
use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_scene::{Light, LightKind, Projection, Scene};
use surelight_scenes::{quad_light, shapes::Shape};
use surelight_tests::render::{ALPHA, render};
use surelight_tests::scenes::{add, lambert, look_at, orthographic};

/// Pixel, channel, mean, its error, the exact value.
type Tested = (usize, usize, f64, f64, f64);

/// Points along a pixel's side.
const GRID: usize = 12;

/// Holds each pixel against the mean of `truth` over it; pixels where that is `None` at any point
/// are left out.
fn check(name: &str, film: &Film, power: f64, truth: impl Fn(f64, f64) -> Option<[f64; 3]>) {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let mut tests = Vec::new();
    for i in 0..width * height {
        let points = (0..GRID * GRID).map(|k| {
            let at = |k: usize| (k as f64 + 0.5) / GRID as f64;
            let (x, y) = ((i % width) as f64 + at(k % GRID), (i / width) as f64 + at(k / GRID));
            truth(2.0 * x / width as f64 - 1.0, 1.0 - 2.0 * y / height as f64)
        });
        let Some(values) = points.collect::<Option<Vec<_>>>() else { continue };
        let exact = [0, 1, 2].map(|c| values.iter().map(|v| v[c]).sum::<f64>() / values.len() as f64);
        let (mean, variance) = (film.mean(i), film.variance_of_mean(i).expect("several batches"));
        for c in 0..3 {
            // Rounding in f32 and the midpoint rule, relative and at a spot's dark edge.
            let error = variance[c].sqrt().hypot(2e-6 * exact[c]).max(1e-8);
            tests.push((i, c, mean[c], error, exact[c]));
        }
    }
    assert!(tests.len() > 3 * 100, "{name}: too few pixels to test");
    let level = sidak_level(ALPHA, tests.len());
    for &(i, c, mean, error, exact) in &tests {
        let p = 2.0 * student_t_survival(((mean - exact) / error).abs(), film.degrees_of_freedom(i));
        let at = (i % width, i / width);
        assert!(p > level, "{name}: pixel {at:?}, channel {c} is {mean} ± {error:.1e} instead of {exact}, p = {p:.1e}");
    }
    let pool = |f: &dyn Fn(&Tested) -> f64, c| tests.iter().filter(|t| t.1 == c).map(f).sum::<f64>();
    for c in 0..3 {
        let (mean, exact) = (pool(&|t| t.2, c), pool(&|t| t.4, c));
        let error = pool(&|t| t.3 * t.3, c).sqrt().hypot(1e-6 * exact);
        let level = sidak_level(ALPHA, 3);
        let test = z_test(mean, error, exact, level);
        println!(
            "{name}, channel {c}: {:+.4} % from the truth, z {:+.2}; a bias of {:.4} % would be detected",
            100.0 * (mean / exact - 1.0),
            test.z,
            100.0 * test.detectable / exact
        );
        assert!(test.detectable / exact < power, "{name}: no power: {:.1e}", test.detectable / exact);
        assert!(test.p > level, "{name}: {mean} instead of {exact}, z = {:.2}", test.z);
    }
    let mut one: Vec<_> = tests.iter().filter(|t| t.4 > 0.0).map(|t| detectable_bias(t.3, level, 0.9) / t.4).collect();
    one.sort_by(f64::total_cmp);
    println!(
        "{name}: in half of the {} pixels a bias of {:.2} % of their own",
        one.len() / 3,
        100.0 * one[one.len() / 2]
    );
}

/// The intersection of a ray with a polygon.
fn intersects(polygon: &[DVec3], origin: DVec3, direction: DVec3) -> bool {
    let n = (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]);
    let t = (polygon[0] - origin).dot(n) / direction.dot(n);
    let p = origin + direction * t;
    t > 0.0
        && (0..polygon.len()).all(|k| {
            let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            (b - a).cross(p - a).dot(n) > 0.0
        })
}

#[test]
fn polygon_irradiance() {
    let scene = quad_light::quad_light();
    let camera = scene.cameras[0].clone();
    let Projection::Perspective { yfov, .. } = camera.projection else { panic!("the camera is a pinhole") };
    let film = render(&scene, &Settings::new(48, 32), 32, 64);
    let lamp = quad_light::lamp();
    // Points where the picture has edges are left out: at the lamp's outline, the line in which its
    // plane intersects the floor, the floor's end.
    let tangent = (0.5 * yfov).tan();
    let origin = camera.to_world.translation;
    let floor = |x: f64, y: f64| {
        let d = camera.to_world.transform_vector3(DVec3::new(x * 1.5 * tangent, y * tangent, -1.0));
        let t = -origin.y / d.y;
        (!intersects(&lamp, origin, d) && t > 0.0)
            .then(|| origin + d * t)
            .filter(|p| p.x.abs() < 4.0 && p.z.abs() < 4.0)
    };
    let front = (lamp[1] - lamp[0]).cross(lamp[3] - lamp[0]);
    check("quad light", &film, 0.003, |x, y| {
        let p = floor(x, y)?;
        (front.dot(p - lamp[0]) > 0.0).then(|| quad_light::radiance(p.x, p.z))
    });
    // Behind the lamp it is dark.
    let mut dark = 0;
    for i in 0..48 * 32 {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| {
            floor(2.0 * f64::from(i % 48 + dx) / 48.0 - 1.0, 1.0 - 2.0 * f64::from(i / 48 + dy) / 32.0)
        });
        if corners.iter().all(|p| p.is_some_and(|p| front.dot(p - lamp[0]) < 0.0)) {
            assert_eq!(film.mean(i as usize), [0.0; 3], "behind the lamp");
            dark += 1;
        }
    }
    assert!(dark > 50, "only {dark} pixels lie behind the lamp");
}

const REFLECTANCE: [f32; 3] = [0.25, 0.5, 0.75];

/// A floor of 2 m viewed straight from above, +X to the right and −Z upwards.
fn floor(lights: &[Light]) -> Scene {
    let mut scene = Scene { name: "floor".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert(REFLECTANCE));
    scene.lights = lights.to_vec();
    scene.cameras = vec![orthographic(look_at(DVec3::Y * 3.0, DVec3::ZERO, DVec3::NEG_Z), 1.0)];
    scene
}

/// Irradiance at a floor point, by the definitions of KHR_lights_punctual.
fn irradiance(light: &Light, x: f64, z: f64) -> [f64; 3] {
    let from = |position: DVec3| {
        let to = position - DVec3::new(x, 0.0, z);
        (to.normalize(), to.y / to.length().powi(3))
    };
    let factor = match light.kind {
        LightKind::Point { position } => from(position).1,
        LightKind::Spot { position, direction, inner, outer } => {
            let (to, value) = from(position);
            let angle = (-to).dot(direction).clamp(-1.0, 1.0);
            let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            value * ((angle - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2)
        }
        LightKind::Directional { direction } => -direction.y,
    };
    light.intensity.map(|i| f64::from(i) * factor)
}

fn punctual() -> [(&'static str, Light); 3] {
    let light = |kind| Light { name: String::new(), kind, intensity: [3.0, 2.0, 1.0] };
    [
        ("point", light(LightKind::Point { position: DVec3::new(0.3, 0.7, -0.2) })),
        (
            "spot",
            light(LightKind::Spot {
                position: DVec3::new(-0.2, 1.5, 0.1),
                direction: DVec3::new(0.3, -1.0, 0.1).normalize(),
                inner: 0.2,
                outer: 0.5,
            }),
        ),
        ("directional", light(LightKind::Directional { direction: DVec3::new(1.0, -0.7, 0.4).normalize() })),
    ]
}

fn check_floor(name: &str, lights: &[Light], batches: u32, power: f64) {
    let film = render(&floor(lights), &Settings::new(32, 32), batches, 16);
    check(name, &film, power, |x, y| {
        // The camera sits at x = z = 0 and y upwards is −Z.
        let sum = lights.iter().map(|l| irradiance(l, x, -y)).fold([0.0; 3], |a, b| [0, 1, 2].map(|c| a[c] + b[c]));
        Some([0, 1, 2].map(|c| f64::from(REFLECTANCE[c]) / PI * sum[c]))
    });
}

#[test]
fn punctual_lights_are_their_formulas() {
    for (name, light) in punctual() {
        check_floor(name, &[light], 16, 1e-3);
    }
}

/// Light adds: chosen among, several lights give the sum of each by itself.
#[test]
fn punctual_lights_add_up() {
    check_floor("all three", &punctual().map(|(_, light)| light), 64, 0.005);
}

/// A spot's edge is where the file says, up to a right angle.
#[test]
fn spots_end_at_their_outer_angle() {
    for outer in [0.3f32, 0.9, FRAC_PI_2 as f32] {
        let spot = Light {
            name: String::new(),
            kind: LightKind::Spot { position: DVec3::Y * 0.8, direction: DVec3::NEG_Y, inner: 0.1, outer },
            intensity: [1.0; 3],
        };
        check_floor(&format!("spot of {outer} rad"), &[spot], 16, 2e-3);
    }
}
