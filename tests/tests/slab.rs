//! Smooth glass in closed form: slabs with all their internal reflections, absorption, bodies in a uniform sky, and mirrors.

use glam::DVec3;
use surelight_render::Settings;
use surelight_scene::{Environment, Material, Scene, Volume, procedural::probes, procedural::shapes::Shape};
use surelight_tests::render::{Judge, all, render};
use surelight_tests::scenes::{add, look_at, pinhole};

/// Transmittance (red), reflectance (green) and their sum (blue) of slabs, clear and tinted: R = 2r/(1 + r) for the clear ones.
#[test]
fn slabs() {
    for (ior, absorption) in [(1.5f32, 1.0f32), (2.4, 1.0), (1.33, 1.0), (1.5, 0.5), (1.5, 0.05)] {
        let (t, r) = probes::slab_answer(f64::from(ior), f64::from(absorption));
        if absorption == 1.0 {
            let face = ((f64::from(ior) - 1.0) / (f64::from(ior) + 1.0)).powi(2);
            assert!((r - 2.0 * face / (1.0 + face)).abs() < 1e-12 && (t + r - 1.0).abs() < 1e-12);
        }
        let film = render(&probes::slab(ior, 0.7, absorption), &Settings::new(32, 32), 16, 32);
        Judge::of(5, 0.03).mean(&format!("slab of index {ior}, absorption {absorption}"), &film, [t, r, t + r]);
    }
}

fn glass(volume: Volume) -> Material {
    Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, volume: Some(volume), ..Material::default() }
}

const CLEAR: Volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };

fn in_white_sky(shape: Shape, material: Material, yfov: f64) -> Scene {
    let mut scene = Scene { name: "glass furnace".into(), ..Scene::default() };
    add(&mut scene, shape, material);
    scene.cameras = vec![pinhole(look_at(DVec3::new(1.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y), yfov)];
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// Clear glass in a uniform sky cannot be seen: all that goes in comes out, and radiance is back to itself outside.
#[test]
fn clear_bodies_are_invisible() {
    let bodies = [
        // Not its rim: light that enters a faceted ball there may go round inside for long, by total reflection.
        ("ball", Shape::icosphere(4).faceted(), 12.5),
        ("cube", Shape::cuboid(DVec3::splat(-0.7), DVec3::splat(0.7)), 30.0),
        ("lens", Shape::lens(1.5, 0.9, 6, 24).faceted(), 30.0),
    ];
    for (name, shape, yfov) in bodies {
        let film = render(&in_white_sky(shape, glass(CLEAR), yfov), &Settings::new(32, 32), 16, 16);
        Judge::of(4, 0.006).mean(&format!("glass {name}"), &film, [1.0; 3]);
    }
    // Colours that part come together again.
    let prism = Material { dispersion: 2.0, ..glass(CLEAR) };
    let cube = Shape::cuboid(DVec3::splat(-0.7), DVec3::splat(0.7));
    let film = render(&in_white_sky(cube, prism, 30.0), &Settings::new(32, 32), 16, 64);
    Judge::of(4, 0.012).mean("dispersive cube", &film, [1.0; 3]);
}

/// A path through a block of matched index runs straight: e^(−σd) and nothing else.
#[test]
fn absorption_is_exponential() {
    let volume = Volume { attenuation_distance: 0.8, attenuation_color: [0.9, 0.5, 0.1] };
    // An index next to 1 reflects 2.5e-13; exactly 1 would be the same surface without a lobe.
    let material = Material { ior: 1.000_001, ..glass(volume) };
    for thickness in [0.1, 1.0, 2.5] {
        let mut scene = probes::slab(1.5, thickness, 1.0);
        let slab = scene.meshes[0].material;
        scene.materials[slab] = Material { name: "slab".into(), ..material.clone() };
        let exact =
            volume.attenuation_color.map(|c| f64::from(c).powf(thickness / f64::from(volume.attenuation_distance)));
        // Both lamps white, so that all channels see the one behind.
        for lamp in 0..scene.materials.len() {
            if scene.materials[lamp].is_emissive() {
                scene.materials[lamp].emissive = [1.0; 3];
            }
        }
        let film = render(&scene, &Settings::new(16, 16), 4, 4);
        for i in all(&film) {
            for (value, exact) in film.mean(i).into_iter().zip(exact) {
                let error = (value / exact - 1.0).abs();
                assert!(error < 2e-5, "pixel {i} at {thickness} m: {value} instead of {exact}");
            }
        }
    }
}

/// Light between two mirrors: Fᵏ after k reflections, without variance while roulette spares the path.
#[test]
fn mirrors() {
    let f0 = [0.95f32, 0.9, 0.8];
    for bounces in [0, 1, 2, 5, 12] {
        let film = render(&probes::mirror_corridor(bounces, f0), &Settings::new(16, 16), 4, 4);
        let truth = probes::mirror_corridor_radiance(bounces, f0.map(f64::from));
        for i in all(&film) {
            for (value, truth) in film.mean(i).into_iter().zip(truth) {
                assert!((value / truth - 1.0).abs() < 1e-5, "{bounces} mirrors: {value} instead of {truth}");
            }
        }
    }
}
