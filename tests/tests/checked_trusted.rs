//! The kernel without bounds checks gives the same bits as the kernel with all of WebGPU's: it
//! never reads or writes out of bounds, and leaving the checks out does not change the results. Nor
//! does it matter whether the kernel was compiled while the BVH was built, or whether its inputs
//! were predicted correctly.

use surelight_film::Film;
use surelight_prepare::{Blueprint, Directions, Integrator, Prepared, Settings};
use surelight_render::{Checks, PrecompiledKernel, Renderer, instrument};
use surelight_scene::{Environment, Scene};
use surelight_scenes::{GALLERY, cornell_box, glass, probes, textured};
use surelight_tests::render::{all, bits, device, prepare};
use surelight_tests::scenes::{map, probes, with_everything};

const SIZE: [u32; 2] = [40, 24];

fn check(scene: &Scene, settings: &Settings) {
    let prepared = prepare(scene, settings);
    let [checked, trusted] = [Checks::Full, Checks::Trusted].map(|checks| {
        let mut renderer = instrument::with_checks(device(), &prepared, checks).unwrap_or_else(|e| panic!("{e}"));
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
    for entry in GALLERY {
        check(&(entry.build)(), &Settings::new(SIZE[0], SIZE[1]));
    }
}

#[test]
fn everything_at_once() {
    let settings =
        Settings { aperture: Some(0.02), focus: Some(3.0), max_radiance: Some(1e3), ..Settings::new(SIZE[0], SIZE[1]) };
    check(&with_everything(textured::textured()), &settings);
    check(&with_everything(cornell_box::cornell_box()), &settings);
}

#[test]
fn skies() {
    let mut scene = glass::glass();
    for environment in [map(16, 8, |x, y| [x as f32, y as f32, 1.0]), Environment::Uniform([0.5; 3])] {
        scene.environment = Some(environment);
        check(&scene, &Settings::new(SIZE[0], SIZE[1]));
    }
    // A map and no triangle.
    let scene =
        Scene { cameras: scene.cameras, environment: Some(map(3, 2, |x, _| [1.0 + x as f32; 3])), ..Scene::default() };
    check(&scene, &Settings::new(SIZE[0], SIZE[1]));
}

/// A kernel's predicted blueprint before the BVH, and the final one.
fn blueprints(scene: &Scene, settings: &Settings) -> [Blueprint; 2] {
    let (prepared, expected) = Prepared::with_work(scene, &scene.cameras[0], settings, Blueprint::clone)
        .unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    [expected, prepared.blueprint()]
}

#[test]
fn kernels_are_known_before_the_bvh() {
    let mut scenes: Vec<Scene> = GALLERY.iter().map(|entry| (entry.build)()).collect();
    scenes.extend(probes());
    scenes.push(probes::terrain(224));
    scenes.push(with_everything(cornell_box::cornell_box()));
    let directions = Integrator::Hemisphere(Directions::Cosine);
    let mut kernels = std::collections::HashSet::new();
    for scene in &scenes {
        for integrator in [Integrator::Mis, Integrator::Area, Integrator::Whitted, directions] {
            let [expected, found] = blueprints(scene, &Settings { integrator, ..Settings::new(8, 8) });
            assert_eq!(expected, found, "{}, {integrator:?}", scene.name);
            kernels.insert(found.key());
        }
    }
    assert!(kernels.len() > 20, "{} kernels say little", kernels.len());
}

#[test]
fn kernels_compiled_ahead_give_the_same_bits() {
    let settings = Settings::new(SIZE[0], SIZE[1]);
    let traced = |mut renderer: Renderer| {
        let mut film = Film::new(SIZE[0], SIZE[1]);
        renderer.trace(&mut film, 0, 2, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        (bits(&film), renderer.wgsl)
    };
    for scene in [cornell_box::cornell_box(), textured::textured()] {
        let prepared = prepare(&scene, &settings);
        let plain = traced(Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}")));
        let right = prepared.blueprint();
        let mut shallow = right.clone();
        // A stack of two entries would lose hits, had the guess been taken.
        shallow.constants.iter_mut().filter(|c| c.name == "STACK_SIZE").for_each(|c| c.value = 2);
        let clamped = Settings { max_radiance: Some(1.0), ..settings.clone() };
        let other = prepare(&scene, &clamped).blueprint();
        for guess in [right, shallow, other] {
            let precompiled = PrecompiledKernel::compile(device(), &guess).unwrap_or_else(|e| panic!("{e}"));
            let renderer = Renderer::with_kernel(device(), &prepared, precompiled).unwrap_or_else(|e| panic!("{e}"));
            assert!(traced(renderer) == plain, "{}: the picture or its kernel is another", scene.name);
        }
    }
}
