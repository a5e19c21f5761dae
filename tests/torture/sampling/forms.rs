//! Every unbiased way to sample paths finds the same picture: hemisphere form = area form = both
//! combined, for any sampling of directions and any source of random numbers; and Whitted's does
//! not.
//!
//! Welch's test on noisy renders of different seeds at α = 0.01 in all of this file's comparisons;
//! the smallest difference that would be detected 9 times in 10 is printed and bounded.

use glam::{DAffine3, DMat3, DVec3};
use surelight_accel::{BuildOptions, Instancing};
use surelight_estimate::{Estimate, welch_test};
use surelight_film::Film;
use surelight_prepare::{Directions, Integrator, Part, Sampler, Settings};
use surelight_render::Renderer;
use surelight_scene::{
    Clearcoat, DiffuseTransmission, Environment, Instance, Light, LightKind, Material, Scene, Sheen,
};
use surelight_scenes::shapes::Shape;
use surelight_tests::render::{all, device, pooled, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, pinhole};
use surelight_tests::welch::Comparison;

const SIZE: [u32; 2] = [24, 24];
const HEMISPHERE: Integrator = Integrator::Hemisphere(Directions::Bsdf);

/// Comparisons in this file; levels are Šidák's over all of them.
const PICTURES: usize = 24;

fn metal(roughness: f32) -> Material {
    Material { base_color: [0.9, 0.7, 0.5, 1.0], roughness, double_sided: true, ..Material::default() }
}

fn plastic(roughness: f32) -> Material {
    Material { base_color: [0.2, 0.5, 0.7, 1.0], metallic: 0.0, roughness, ..Material::default() }
}

fn glass(roughness: f32) -> Material {
    Material { metallic: 0.0, roughness, transmission: 1.0, ..Material::default() }
}

/// A corner of a room with two balls, of `left` and `right`, before the camera.
fn corner(name: &str, left: Material, right: Material) -> Scene {
    let mut scene = Scene { name: name.into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert([0.7, 0.6, 0.5]));
    let wall = Shape::parallelogram(DVec3::new(0.0, 1.0, -1.0), DVec3::X * 2.0, DVec3::Y);
    add(&mut scene, wall, lambert([0.4, 0.6, 0.3]));
    add(&mut scene, Shape::icosphere(2).placed(0.45, DVec3::new(-0.6, 0.46, 0.0)), left);
    add(&mut scene, Shape::icosphere(2).placed(0.45, DVec3::new(0.6, 0.46, 0.0)), right);
    let eye = look_at(DVec3::new(0.0, 1.3, 3.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Y);
    scene.cameras.push(pinhole(eye, 40.0));
    scene
}

/// A large lamp above, which directions find often enough to be compared.
fn add_lamp(scene: &mut Scene, radiance: [f32; 3]) {
    let lamp = Shape::parallelogram(DVec3::new(0.0, 2.2, 0.3), DVec3::X * 0.9, DVec3::Z * 0.9);
    add(scene, lamp, emitter(radiance));
}

/// Diffuse and glossy surfaces under a lamp.
pub(super) fn lamp() -> Scene {
    let mut scene = corner("lamp", metal(0.5), plastic(0.4));
    add_lamp(&mut scene, [4.0, 3.0, 2.0]);
    scene
}

/// The same under a map with a bright quarter.
pub(super) fn sky_map() -> Scene {
    let mut scene = corner("map", metal(0.5), plastic(0.4));
    let texel = |x: u32, y: u32| if y < 3 && x % 8 < 4 { [3.0, 2.5, 2.0] } else { [0.3, 0.4, 0.6] };
    scene.environment = Some(map(16, 8, texel));
    scene
}

/// Clear and frosted glass under a lamp and a uniform sky.
pub(super) fn glass_balls() -> Scene {
    let mut scene = corner("glass", glass(0.0), glass(0.6));
    add_lamp(&mut scene, [2.0, 2.0, 2.0]);
    scene.environment = Some(Environment::Uniform([0.5, 0.6, 0.7]));
    scene
}

fn settings(integrator: Integrator, seed: u32) -> Settings {
    Settings { integrator, seed, ..Settings::new(SIZE[0], SIZE[1]) }
}

/// A way to render, with its samples per batch.
type Way = (&'static str, Settings, u32);

/// The scene by multiple importance sampling against other ways.
fn check(scene: &Scene, ways: &[Way], power: f64) {
    let Settings { max_bounces, build, .. } = ways[0].1;
    let reference = Settings { max_bounces, build, ..settings(Integrator::Mis, 1000) };
    let reference = render(scene, &reference, 16, 64);
    for (name, settings, samples) in ways {
        let film = render(scene, settings, 16, *samples);
        let comparison = Comparison { power, pictures: PICTURES, pixels: false };
        comparison.assert_equal(&format!("{}: {name} against mis", scene.name), &film, &reference);
    }
}

/// All forms; directions that do not follow the BSDF are noisy, and get more samples.
fn forms(first_seed: u32) -> [Way; 4] {
    let directions = |directions, k| settings(Integrator::Hemisphere(directions), first_seed + k);
    [
        ("hemisphere, by the BSDF", directions(Directions::Bsdf, 0), 64),
        ("hemisphere, by the cosine", directions(Directions::Cosine, 1), 256),
        ("hemisphere, uniform", directions(Directions::Uniform, 2), 256),
        ("area", settings(Integrator::Area, first_seed + 3), 64),
    ]
}

#[test]
fn hemisphere_area_mis() {
    check(&lamp(), &forms(1), 0.02);
}

#[test]
fn forms_agree_about_glass() {
    check(&glass_balls(), &forms(7), 0.04);
}

/// Coats over scattering and over emissive surfaces, fibres, and a leaf that lets light through to
/// the wall behind it.
pub(super) fn layers() -> Scene {
    let velvet = Material {
        sheen: Sheen { color: [0.8, 0.7, 0.6], roughness: 0.5, ..Sheen::default() },
        clearcoat: Clearcoat { factor: 0.7, roughness: 0.6, ..Clearcoat::default() },
        ..plastic(0.5)
    };
    let mut scene = corner("layers", velvet, metal(0.6));
    let leaf = Material {
        diffuse_transmission: DiffuseTransmission {
            factor: 0.6,
            color: [0.3, 0.9, 0.4],
            ..DiffuseTransmission::default()
        },
        ..plastic(0.7)
    };
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 1.5, 0.2), DVec3::X * 0.6, DVec3::Z * 0.6), leaf);
    let lamp = Shape::parallelogram(DVec3::new(0.0, 2.2, 0.3), DVec3::X * 0.9, DVec3::Z * 0.9);
    let coat = Clearcoat { factor: 1.0, roughness: 0.7, ..Clearcoat::default() };
    add(&mut scene, lamp, Material { clearcoat: coat, ..emitter([4.0, 3.0, 2.0]) });
    scene
}

#[test]
fn forms_agree_about_layers() {
    let scene = layers();
    let directions = |directions, k: u32| settings(Integrator::Hemisphere(directions), 20 + k);
    let ways = [
        ("hemisphere, by the BSDF", directions(Directions::Bsdf, 0), 64),
        ("hemisphere, uniform", directions(Directions::Uniform, 1), 128),
        ("area", settings(Integrator::Area, 22), 64),
    ];
    check(&scene, &ways, 0.03);
}

/// Lanterns of one mesh, stretched and mirrored, and a sheet that shines to both sides, over a
/// leaf: a light tree over instances.
pub(super) fn lanterns() -> Scene {
    let leaf = Material {
        diffuse_transmission: DiffuseTransmission {
            factor: 0.5,
            color: [0.3, 0.9, 0.4],
            ..DiffuseTransmission::default()
        },
        ..plastic(0.5)
    };
    let mut scene = corner("lanterns", metal(0.3), leaf);
    add(&mut scene, Shape::icosphere(3).placed(0.2, DVec3::new(-1.1, 1.3, 0.4)), emitter([6.0, 4.0, 2.0]));
    let mesh = scene.instances.len() - 1;
    let mesh = scene.instances[mesh].mesh;
    for (x, y, z, mirror) in [(0.9, 1.2, 0.9, -1.0), (0.1, 1.6, -0.6, 1.0), (1.4, 0.1, 0.5, -0.4)] {
        let to_world = DAffine3 {
            matrix3: DMat3::from_diagonal(DVec3::new(mirror, 1.2, 0.8)),
            translation: DVec3::new(x, y, z) - DVec3::new(-1.1 * mirror, 1.3 * 1.2, 0.4 * 0.8),
        };
        scene.instances.push(Instance { mesh, to_world });
    }
    let sheet = Shape::parallelogram(DVec3::new(-0.2, 0.8, 0.7), DVec3::X * 0.2, DVec3::new(0.0, 0.15, 0.1));
    add(&mut scene, sheet, Material { double_sided: true, ..emitter([1.0, 2.0, 3.0]) });
    scene
}

/// Instances, however few triangles their copies would have.
pub(super) fn instanced(settings: Settings) -> Settings {
    Settings { build: BuildOptions { instancing: Instancing::Always, ..BuildOptions::default() }, ..settings }
}

#[test]
fn forms_agree_under_lanterns() {
    let scene = lanterns();
    let settings = |integrator, seed| instanced(settings(integrator, seed));
    let prepared = prepare(&scene, &settings(Integrator::Mis, 0));
    assert!(prepared.key().has(Part::LightTree) && prepared.key().has(Part::Instances), "{:?}", prepared.key());
    let ways = [
        ("hemisphere, by the BSDF", settings(HEMISPHERE, 31), 64),
        ("hemisphere, by the cosine", settings(Integrator::Hemisphere(Directions::Cosine), 32), 128),
        ("area", settings(Integrator::Area, 33), 64),
    ];
    check(&scene, &ways, 0.04);
}

/// Coats that are deltas over bases that are not: the base is lit by sampled lights, the coat by
/// directions alone.
pub(super) fn smooth_coats() -> Scene {
    let coat = Clearcoat { factor: 1.0, roughness: 0.0, ..Clearcoat::default() };
    let mut scene = corner(
        "coats",
        Material { clearcoat: coat.clone(), ..metal(0.4) },
        Material { clearcoat: coat, ..plastic(0.5) },
    );
    add_lamp(&mut scene, [4.0, 3.0, 2.0]);
    scene
}

#[test]
fn forms_agree_about_smooth_coats() {
    let scene = smooth_coats();
    let ways = [("hemisphere", settings(HEMISPHERE, 41), 64), ("area", settings(Integrator::Area, 42), 64)];
    check(&scene, &ways, 0.02);
}

#[test]
fn forms_agree_under_a_map() {
    let ways = [("hemisphere", settings(HEMISPHERE, 5), 64), ("area", settings(Integrator::Area, 6), 64)];
    check(&sky_map(), &ways, 0.02);
}

#[test]
fn forms_agree_at_one_bounce() {
    let one = |integrator, seed| Settings { max_bounces: Some(1), ..settings(integrator, seed) };
    let ways = [("hemisphere", one(HEMISPHERE, 11), 64), ("area", one(Integrator::Area, 12), 64)];
    check(&lamp(), &ways, 0.02);
}

#[test]
fn samplers_agree() {
    let sampler = |sampler, seed| Settings { sampler, ..settings(Integrator::Mis, seed) };
    let ways =
        [("independent", sampler(Sampler::Independent, 13), 64), ("stratified", sampler(Sampler::Stratified, 14), 64)];
    check(&lamp(), &ways, 0.01);
}

/// Means and variances of a picture's pixels, over seeds, at 64 samples per pixel in batches as a
/// render makes them.
fn over_seeds(one_scramble: bool) -> (Vec<f64>, f64) {
    const SEEDS: u32 = 8;
    let scene = surelight_scenes::cornell_box::cornell_box();
    let pictures: Vec<Vec<f64>> = (0..SEEDS)
        .map(|seed| {
            let settings = Settings { one_scramble, seed, ..Settings::new(24, 24) };
            let mut renderer = Renderer::new(device(), &prepare(&scene, &settings)).expect("the kernel compiles");
            let mut film = Film::new(24, 24);
            // With one scramble, batches are numbered by their first sample; these numbers do for
            // both.
            for (first, batches, samples) in [(0, 1, 1), (1, 1, 1), (2, 1, 2), (4, 15, 4)] {
                renderer.trace(&mut film, first, batches, samples, &mut |_| true).expect("the scene is traced");
            }
            all(&film).map(|i| film.mean(i)[1]).collect()
        })
        .collect();
    let means = pictures.iter().map(|p| p.iter().sum::<f64>() / p.len() as f64).collect();
    let mean_of = |i: usize| pictures.iter().map(|p| p[i]).sum::<f64>() / f64::from(SEEDS);
    let squares = |i: usize| pictures.iter().map(|p| (p[i] - mean_of(i)).powi(2)).sum::<f64>();
    (means, (0..pictures[0].len()).map(squares).sum())
}

/// Batches that are pieces of one sequence leave the mean alone and lower the error.
///
/// Over 8 seeds the squared errors have 7 · 576 degrees of freedom: their ratio is known to some 5
/// %, tails included.
#[test]
fn one_scramble_errs_less() {
    let (apart, squares_apart) = over_seeds(false);
    let (joint, squares_joint) = over_seeds(true);
    let estimate = |means: &[f64]| {
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n * (n - 1.0));
        Estimate { mean, variance, dof: n - 1.0 }
    };
    let test = welch_test(&estimate(&apart), &estimate(&joint));
    let ratio = squares_joint / squares_apart;
    println!("one scramble: squared error {ratio:.3} of that of 16, p of the means {:.2}", test.p);
    assert!(test.p > 0.01, "means differ by {:+.2e}, p {}", test.difference, test.p);
    assert!(ratio < 0.85, "squared error {ratio} of that of independent batches");
}

/// Of mirrors, clear glass and point lights Whitted's picture is complete up to light between
/// surfaces: at one bounce it is the truth.
#[test]
fn whitted_is_right_about_direct_light_of_points() {
    let mut scene = corner("points", lambert([0.8, 0.2, 0.2]), lambert([0.2, 0.8, 0.2]));
    let light = |position, intensity| Light { name: String::new(), kind: LightKind::Point { position }, intensity };
    scene.lights.push(light(DVec3::new(-1.0, 2.0, 1.0), [9.0, 5.0, 5.0]));
    scene.lights.push(light(DVec3::new(1.5, 1.5, 2.0), [1.0, 4.0, 4.0]));
    let one = Settings { max_bounces: Some(1), ..settings(Integrator::Whitted, 15) };
    check(&scene, &[("whitted", one, 32)], 0.005);
}

#[test]
fn whitted_is_biased_and_says_so() {
    for integrator in [HEMISPHERE, Integrator::Area, Integrator::Mis] {
        assert!(!integrator.is_biased());
    }
    assert!(Integrator::Whitted.is_biased());
    let scene = lamp();
    let whitted = render(&scene, &settings(Integrator::Whitted, 16), 16, 16);
    let truth = render(&scene, &settings(Integrator::Mis, 17), 16, 16);
    let mean = |film: &Film| pooled(film, 1, all(film));
    let test = welch_test(&mean(&whitted), &mean(&truth));
    let relative = test.difference / mean(&truth).mean;
    println!("whitted differs by {:+.1} %, p {:.1e}", 100.0 * relative, test.p);
    assert!(relative < -0.05 && test.p < 1e-12, "whitted differs by {relative}, p = {}", test.p);
}
