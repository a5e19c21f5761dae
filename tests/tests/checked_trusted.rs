//! The kernel without bounds checks gives the same bits as the kernel with all of WebGPU's: it never reads or writes where it
//! should not, and leaving the checks out has not changed what is computed.

use surelight_film::Film;
use surelight_render::{Checks, Renderer, Settings};
use surelight_scene::{Environment, Scene, procedural};
use surelight_tests::render::{all, bits, device, prepare};
use surelight_tests::scenes::{map, with_everything};

const SIZE: [u32; 2] = [40, 24];

fn check(scene: &Scene, settings: &Settings) {
    let prepared = prepare(scene, settings);
    let [checked, trusted] = [Checks::Full, Checks::Trusted].map(|checks| {
        let mut renderer = Renderer::with_checks(device(), &prepared, checks).unwrap_or_else(|e| panic!("{e}"));
        let mut film = Film::new(SIZE[0], SIZE[1]);
        renderer.trace(&mut film, 0, 2, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        renderer.trace_features(&mut film).unwrap_or_else(|e| panic!("{e}"));
        film
    });
    let lit = all(&checked).filter(|&i| checked.mean(i)[0] > 0.0).count();
    assert!(lit > 100, "{}: {lit} pixels are lit, the comparison says little", scene.name);
    let different = bits(&checked).iter().zip(bits(&trusted)).filter(|(a, b)| **a != *b).count();
    assert_eq!(different, 0, "{}: pixels differ", scene.name);
    assert!(
        checked.features().is_some() && checked.features() == trusted.features(),
        "{}: features differ",
        scene.name
    );
}

#[test]
fn gallery() {
    for entry in procedural::GALLERY {
        check(&(entry.build)(), &Settings::new(SIZE[0], SIZE[1]));
    }
}

#[test]
fn everything_at_once() {
    let settings =
        Settings { aperture: Some(0.02), focus: Some(3.0), max_radiance: Some(1e3), ..Settings::new(SIZE[0], SIZE[1]) };
    check(&with_everything(procedural::textured::textured()), &settings);
    check(&with_everything(procedural::cornell_box::cornell_box()), &settings);
}

#[test]
fn skies() {
    let mut scene = procedural::glass::glass();
    for environment in [map(16, 8, |x, y| [x as f32, y as f32, 1.0]), Environment::Uniform([0.5; 3])] {
        scene.environment = Some(environment);
        check(&scene, &Settings::new(SIZE[0], SIZE[1]));
    }
    // A map and no triangle.
    let scene =
        Scene { cameras: scene.cameras, environment: Some(map(3, 2, |x, _| [1.0 + x as f32; 3])), ..Scene::default() };
    check(&scene, &Settings::new(SIZE[0], SIZE[1]));
}
