//! Lights behind glass: light that cannot be found is reported as missing, light that is found by
//! chance is not certified.

use glam::DVec3;
use surelight_prepare::{Integrator, Settings, Unreachable};
use surelight_scene::{Light, LightKind, Material, Scene, Volume};
use surelight_scenes::shapes::Shape;
use surelight_scenes::torture::{self, light::sds as globe};
use surelight_tests::render::{all, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, pinhole};

/// A point light in a globe gives 0, by every estimator, and all of its light is reported as
/// missing. A small bulb in the globe is found by chance: that is reported too, and few pixels are
/// certified.
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
        println!("{integrator:?}: {lit} of 256 pixels have hit the bulb, {:.3} are certified", certificate.share());
        assert!(lit > 20, "too few pixels have hit the bulb: {lit}");
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

/// A point light in the middle of a room of six like walls, but for the material of one.
fn room(material: Material) -> Scene {
    let mut scene = Scene::default();
    for (k, axis) in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z].into_iter().enumerate() {
        let (u, v) = axis.any_orthonormal_pair();
        let wall = if k == 0 { material.clone() } else { lambert([0.5; 3]) };
        add(&mut scene, Shape::parallelogram(axis, u, v), wall);
    }
    scene.lights.push(Light {
        name: String::new(),
        kind: LightKind::Point { position: DVec3::ZERO },
        intensity: [1.0; 3],
    });
    scene.cameras.push(pinhole(look_at(DVec3::new(0.0, 0.2, 0.9), DVec3::X, DVec3::Y), 40.0));
    scene
}

/// Mean reflectance of a wall's smooth surface of index 1.5 over the solid angle that it fills.
fn mean_reflectance() -> f64 {
    const GRID: usize = 64;
    let at = |k: usize| (k as f64 + 0.5) / GRID as f64 * 2.0 - 1.0;
    let (mut sum, mut all) = (0.0, 0.0);
    for k in 0..GRID * GRID {
        let squared = 1.0 + at(k % GRID).powi(2) + at(k / GRID).powi(2);
        let (cosine, solid_angle) = (1.0 / squared.sqrt(), squared.powf(-1.5));
        let inside = (1.0 - (1.0 - cosine * cosine) / 2.25).sqrt();
        let s = (cosine - 1.5 * inside) / (cosine + 1.5 * inside);
        let p = (1.5 * cosine - inside) / (1.5 * cosine + inside);
        sum += 0.5 * (s * s + p * p) * solid_angle;
        all += solid_angle;
    }
    sum / all
}

/// The missing share of the light in the room, in closed form: a wall has a sixth of the light, and
/// mirrors it all to others.
#[test]
fn shares_are_solid_angles() {
    let half = Material { base_color: [0.5, 0.5, 0.5, 1.0], ..smooth(1.0, 0.0) };
    // A pane before a black void: transmitted light is lost, mirrored light reaches surfaces.
    let reflected = mean_reflectance();
    let pane = Material { volume: None, ..smooth(0.0, 1.0) };
    for (name, material, share) in [
        ("a mirror", smooth(1.0, 0.0), 1.0 / 6.0),
        ("a mirror of a half", half, 0.5 / 5.5),
        ("a pane", pane, reflected / (5.0 + reflected)),
        ("plastic", Material { base_color: [0.5, 0.5, 0.5, 1.0], ..smooth(0.0, 0.0) }, reflected / 6.0),
        ("rough metal", Material { roughness: 0.5, ..smooth(1.0, 0.0) }, 0.0),
        ("a wall", lambert([0.5; 3]), 0.0),
    ] {
        let found = missing(&room(material));
        // Less than 1 % is not reported.
        let expected = if share < 0.01 { 0.0 } else { share };
        println!("{name}: {found:.4}, exactly {share:.4}");
        assert!((found - expected).abs() < 0.005, "{name}: {found} instead of {expected}");
    }
    // A spot that a ball of glass fills, and one that faces away from it.
    let spot = |direction| LightKind::Spot { position: DVec3::Y * 2.0, direction, inner: 0.1, outer: 0.3 };
    assert!(missing(&ball(smooth(0.0, 1.0), spot(DVec3::NEG_Y))) > 0.999);
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
