//! Lights behind glass: what cannot be found is said to be missing, what is found by chance is not believed.

use glam::DVec3;
use surelight_render::{Integrator, Settings, Unreachable};
use surelight_scene::procedural::shapes::Shape;
use surelight_scene::procedural::torture::{self, light::sds as globe};
use surelight_scene::{Light, LightKind, Material, Scene, Volume};
use surelight_tests::render::{all, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, pinhole};

/// A point light in a globe gives 0, by every estimator, and all of its light is said to be missing. A small bulb in the globe is
/// found by chance: that is said too, and hardly a pixel is certified.
#[test]
fn sds() {
    for integrator in [Integrator::Mis, Integrator::Area] {
        let settings = Settings { integrator, ..Settings::new(16, 16) };
        let scene = torture::scene("sds");
        let prepared = prepare(&scene, &settings);
        let [Unreachable::Missing { lights, share }] = &prepared.unreachable[..] else {
            panic!("{:?}", prepared.unreachable);
        };
        assert!(lights == &["'bulb'"] && *share > 0.99, "{lights:?}: {share}");
        let film = render(&scene, &settings, 2, 8);
        assert!(all(&film).all(|i| film.mean(i) == [0.0; 3]), "light comes through");

        let scene = globe(Some(0.02));
        let prepared = prepare(&scene, &settings);
        let [Unreachable::ByChance { share }] = &prepared.unreachable[..] else { panic!("{:?}", prepared.unreachable) };
        assert!(*share > 0.99, "{share}");
        let film = render(&scene, &settings, 16, 64);
        let (certificate, lit) = (film.certify(), all(&film).filter(|&i| film.mean(i)[1] > 0.0).count());
        println!("{integrator:?}: {lit} of 256 pixels have met the bulb, {:.3} are certified", certificate.share());
        assert!(lit > 20, "hardly a pixel has met the bulb: {lit}");
        assert!(certificate.share() < 0.1, "{:.3} of the pixels are certified", certificate.share());
    }
}

fn smooth(metallic: f32, transmission: f32) -> Material {
    let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    Material { metallic, transmission, roughness: 0.0, volume: Some(volume), ..Material::default() }
}

/// A floor, and a ball of half a metre a metre above it, with a light of the kind given.
fn ball(material: Material, kind: LightKind) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 1e4, DVec3::NEG_Z * 1e4), lambert([0.5; 3]));
    add(&mut scene, Shape::icosphere(5).placed(0.5, DVec3::Y), material);
    scene.lights.push(Light { name: String::new(), kind, intensity: [1.0; 3] });
    scene.cameras.push(pinhole(look_at(DVec3::new(0.0, 1.0, 3.0), DVec3::Y, DVec3::Y), 40.0));
    scene
}

fn missing(scene: &Scene) -> f64 {
    match &prepare(scene, &Settings::new(8, 8)).unreachable[..] {
        [] => 0.0,
        [Unreachable::Missing { share, .. }] => *share,
        other => panic!("{other:?}"),
    }
}

/// How much is missing, in closed form: the solid angle of the ball over that of all that the light meets.
#[test]
fn shares_are_solid_angles() {
    let above = LightKind::Point { position: DVec3::Y * 2.0 };
    // Half a metre from a distance of one: a cap of 1 − √3/2 of a hemisphere, and the floor all of it but for its ends.
    let cap = 1.0 - 0.75f64.sqrt();
    for (material, share) in [
        (smooth(1.0, 0.0), cap),
        (smooth(0.0, 1.0), cap),
        // Smooth plastic mirrors 4 %; a rough ball connects all that it gets.
        (smooth(0.0, 0.0), 0.04 * cap),
        (Material { roughness: 0.5, ..smooth(1.0, 0.0) }, 0.0),
        (lambert([0.5; 3]), 0.0),
    ] {
        let found = missing(&ball(material.clone(), above));
        // Less than 1 % is not told.
        let expected = if share < 0.01 { 0.0 } else { share };
        println!(
            "metallic {}, transmission {}: {found:.4}, exactly {share:.4}",
            material.metallic, material.transmission
        );
        assert!((found - expected).abs() < 0.004, "{found} instead of {expected}");
    }
    // A spot that the ball fills, and one that looks away from it.
    let spot = |direction| LightKind::Spot { position: DVec3::Y * 2.0, direction, inner: 0.1, outer: 0.3 };
    assert!(missing(&ball(smooth(1.0, 0.0), spot(DVec3::NEG_Y))) > 0.999);
    assert_eq!(missing(&ball(smooth(1.0, 0.0), spot(DVec3::new(1.0, -1.0, 0.0).normalize()))), 0.0);
}

/// An emitter next to glass, and one that an environment drowns, are no warning.
#[test]
fn emitters_in_the_open_are_no_warning() {
    let mut scene = ball(smooth(0.0, 1.0), LightKind::Point { position: DVec3::Y * 2.0 });
    scene.lights.clear();
    add(&mut scene, Shape::icosphere(1).placed(0.05, DVec3::new(1.0, 1.0, 0.0)), emitter([1.0; 3]));
    assert_eq!(prepare(&scene, &Settings::new(8, 8)).unreachable, []);
}
