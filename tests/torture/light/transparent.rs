//! Pictures whose environment is transparent: the coverage of a pixel, and radiance premultiplied
//! by it.

use glam::DVec3;
use surelight_film::{Film, Window};
use surelight_prepare::{Directions, Integrator, PathReuse, Settings};
use surelight_render::Renderer;
use surelight_scene::{AlphaMode, Environment, Light, LightKind, Material, Scene, Volume};
use surelight_scenes::shapes::Shape;
use surelight_tests::render::{all, device, prepare};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, orthographic};

/// Pixels a side of a square picture of four metres.
const SIZE: u32 = 16;

const SKY: [f32; 3] = [0.9, 0.5, 0.25];

/// More samples than one subtotal holds.
const SAMPLES: u32 = 96;

/// Deviations, in binomial standard errors, that no pixel has by chance.
const MAX_Z: f64 = 5.0;

fn picture() -> Settings {
    Settings { transparent: true, ..Settings::new(SIZE, SIZE) }
}

/// Viewed along −Z, under a uniform sky.
fn under_sky() -> Scene {
    let mut scene = Scene { environment: Some(Environment::Uniform(SKY)), ..Scene::default() };
    scene.cameras.push(orthographic(look_at(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y), 2.0));
    scene
}

/// A square that faces the camera.
fn card(center: DVec3, half: f64) -> Shape {
    Shape::parallelogram(center, DVec3::X * half, DVec3::Y * half)
}

fn pane(tint: f32) -> Material {
    let smooth =
        Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, double_sided: true, ..Material::default() };
    Material { base_color: [tint, tint, tint, 1.0], ..smooth }
}

fn trace(scene: &Scene, settings: &Settings) -> Film {
    let mut renderer = Renderer::new(device(), &prepare(scene, settings)).unwrap_or_else(|e| panic!("{e}"));
    let mut film = Film::new(SIZE, SIZE);
    renderer.adapt(None, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    renderer.trace(&mut film, 0, 2, SAMPLES, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    film
}

/// Compares a pixel's coverage with its probability.
fn assert_covered(name: &str, film: &Film, i: usize, truth: f64) {
    let error = (truth * (1.0 - truth) / film.samples(i) as f64).sqrt();
    let (found, z) = (film.coverage(i), (film.coverage(i) - truth) / error.max(1e-12));
    assert!(z.abs() < MAX_Z, "{name}: pixel {i} is covered to {found} instead of {truth}, z = {z:.1}");
}

/// Every way to render, by name.
fn ways() -> Vec<(String, Settings)> {
    let integrators = [
        Integrator::Mis,
        Integrator::Caustics,
        Integrator::Area,
        Integrator::Hemisphere(Directions::Bsdf),
        Integrator::Hemisphere(Directions::Cosine),
        Integrator::Whitted,
    ];
    let with = |integrator| (format!("{integrator:?}"), Settings { integrator, ..picture() });
    let shared = Settings { path_reuse: PathReuse::On, ..picture() };
    let mut ways: Vec<_> = integrators.map(with).into();
    ways.push(("shared paths".into(), shared.clone()));
    ways.push(("adaptive".into(), Settings { adaptive: true, ..picture() }));
    ways.push(("adaptive, shared paths".into(), Settings { adaptive: true, ..shared }));
    ways
}

/// A card whose edge cuts a column of pixels: A is the area covered, and the card's radiance ρ
/// under the sky is premultiplied by it.
#[test]
fn coverage_is_the_area_of_a_pixel() {
    let mut scene = under_sky();
    let card = Shape::parallelogram(DVec3::new(-4.9, 0.0, 0.0), DVec3::X * 5.0, DVec3::Y * 5.0);
    add(&mut scene, card, lambert([0.5; 3]));
    for (name, settings) in ways() {
        let film = trace(&scene, &settings);
        for i in all(&film) {
            // The edge is at 0.1 m, in the column from 0 to 0.25 m.
            match i as u32 % SIZE {
                8 => assert_covered(&name, &film, i, 0.4),
                column => assert_eq!(film.coverage(i), f64::from(u8::from(column < 8)), "{name}"),
            }
            // Whitted's sky does not light diffuse surfaces, and uniform or cosine directions vary.
            if ["Mis", "Area", "shared paths"].contains(&name.as_str()) {
                for (c, sky) in SKY.into_iter().enumerate() {
                    let truth = 0.5 * f64::from(sky) * film.coverage(i);
                    assert!(
                        (film.mean(i)[c] - truth).abs() <= 1e-5 * truth,
                        "{name}: {}, not {truth}",
                        film.mean(i)[c]
                    );
                }
            }
        }
    }
}

/// Coverage of a blended surface is its alpha.
#[test]
fn alpha_is_coverage() {
    let mut scene = under_sky();
    let blended = Material { base_color: [0.5, 0.5, 0.5, 0.25], alpha_mode: AlphaMode::Blend, ..lambert([0.0; 3]) };
    add(&mut scene, card(DVec3::ZERO, 5.0), blended);
    for (name, settings) in ways() {
        let film = trace(&scene, &settings);
        all(&film).for_each(|i| assert_covered(&name, &film, i, 0.25));
    }
}

/// A ball in a furnace is ρ wherever it is, and the map beside it does not show.
#[test]
fn a_furnace_does_not_show() {
    let mut scene = under_sky();
    add(&mut scene, Shape::uv_sphere(48, 48), lambert([0.5; 3]));
    let uniform = trace(&scene, &picture());
    scene.environment = Some(map(8, 4, |_, _| SKY));
    let mapped = trace(&scene, &picture());
    let (mut full, mut none) = (0, 0);
    for i in all(&uniform) {
        let covered = uniform.coverage(i);
        assert_eq!(mapped.coverage(i), covered, "pixel {i}");
        full += u32::from(covered == 1.0);
        none += u32::from(covered == 0.0);
        if covered == 0.0 {
            assert_eq!((uniform.mean(i), mapped.mean(i)), ([0.0; 3], [0.0; 3]), "pixel {i}");
        }
        for (c, sky) in SKY.into_iter().enumerate() {
            let truth = 0.5 * f64::from(sky) * covered;
            assert!((uniform.mean(i)[c] - truth).abs() <= 1e-5 * truth, "{}, not {truth}", uniform.mean(i)[c]);
        }
    }
    assert!(full > 20 && none > 100, "{full} and {none} pixels");
}

/// Objects of all kinds that transmit or reflect the sky, and a lamp.
fn exhibits() -> Scene {
    let mut scene = under_sky();
    add(&mut scene, card(DVec3::new(-1.0, 1.0, 0.0), 0.8), pane(0.5));
    add(&mut scene, card(DVec3::new(-1.0, 1.0, -0.5), 0.5), pane(1.0));
    let mirror = Material { roughness: 0.0, double_sided: true, ..Material::default() };
    add(&mut scene, card(DVec3::new(1.0, 1.0, 0.0), 0.7), mirror);
    let blended = Material { base_color: [0.5, 0.5, 0.5, 0.3], alpha_mode: AlphaMode::Blend, ..lambert([0.0; 3]) };
    add(&mut scene, card(DVec3::new(-1.0, -1.0, 0.3), 0.9), blended);
    add(&mut scene, card(DVec3::new(-1.0, -1.0, 0.0), 0.6), pane(0.25));
    let glass = Material {
        volume: Some(Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] }),
        double_sided: false,
        ..pane(1.0)
    };
    add(&mut scene, Shape::cuboid(DVec3::new(0.4, -1.6, -0.6), DVec3::new(1.6, -0.4, 0.6)), glass);
    add(&mut scene, Shape::panel(DVec3::new(0.0, 3.0, 2.0), DVec3::ZERO, 0.5, 0.5), emitter([4.0; 3]));
    let kind = LightKind::Point { position: DVec3::new(1.0, 2.0, 3.0) };
    scene.lights.push(Light { name: String::new(), kind, intensity: [3.0, 2.0, 1.0] });
    scene
}

/// A transparent picture over the sky is the picture with the sky: panes dim the view through them,
/// and refracted or reflected sky is part of the picture. The same paths are traced, so that this
/// holds to rounding.
#[test]
fn over_its_sky_it_is_the_whole_picture() {
    let scene = exhibits();
    // Another picture has its noise, and so its adaptive samples, elsewhere.
    for (name, settings) in ways().into_iter().filter(|(_, settings)| !settings.adaptive) {
        let film = trace(&scene, &settings);
        let whole = trace(&scene, &Settings { transparent: false, ..settings });
        let mut between = 0;
        for i in all(&film) {
            let left = 1.0 - film.coverage(i);
            between += u32::from(left > 0.0 && left < 1.0);
            for (c, sky) in SKY.into_iter().enumerate() {
                let (over, truth) = (film.mean(i)[c] + left * f64::from(sky), whole.mean(i)[c]);
                assert!((over / truth - 1.0).abs() < 1e-5, "{name}: pixel {i} is {over} instead of {truth}");
            }
        }
        assert!(between > 60, "{name}: {between} pixels are covered in part");
    }
}

/// Light that comes straight through a pane is not covered: 1 − F of the rays, times the pane's
/// tint.
#[test]
fn a_pane_covers_what_it_keeps_back() {
    let mut scene = under_sky();
    add(&mut scene, card(DVec3::ZERO, 5.0), pane(0.5));
    let film = trace(&scene, &picture());
    // Both sides of a thin wall of index 1.5, as one: Fresnel's 4 %.
    let truth = 1.0 - 0.96 * 0.5;
    let mean = all(&film).map(|i| film.coverage(i)).sum::<f64>() / all(&film).len() as f64;
    let error = 0.5 / f64::from(SIZE * SIZE * 2 * SAMPLES).sqrt();
    assert!((mean - truth).abs() < MAX_Z * error, "{mean} instead of {truth} ± {error:.1e}");
}

/// Crops and batches, joined, have the coverage of one render, bit for bit.
#[test]
fn parts_have_the_coverage_of_the_whole() {
    let scene = exhibits();
    let mut renderer = Renderer::new(device(), &prepare(&scene, &picture())).unwrap_or_else(|e| panic!("{e}"));
    let mut of = |window: Window, first: u32, batches: u32| {
        let mut film = Film::of_window(window);
        renderer.trace(&mut film, first, batches, 70, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        film
    };
    let all_of_it = Window::all(SIZE, SIZE);
    let crop = |edges| Window::crop([SIZE; 2], edges).expect("it is inside");
    let whole = of(all_of_it, 0, 3);
    let mut joined = of(all_of_it, 2, 1);
    for edges in [[0, 0, 5, SIZE], [5, 0, SIZE, 9], [5, 9, SIZE, SIZE]] {
        let part = of(crop(edges), 0, 2);
        joined.merge(&part).unwrap_or_else(|e| panic!("{e}"));
    }
    for i in all(&whole) {
        assert_eq!((joined.coverage(i), joined.mean(i)), (whole.coverage(i), whole.mean(i)), "pixel {i}");
    }
}
