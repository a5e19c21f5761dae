//! Cases 2, 3 and 5: brighter, larger and smaller worlds.

use glam::{DAffine3, DVec3};
use surelight_prepare::Settings;
use surelight_scene::Scene;
use surelight_scenes::{furnace, quad_light, torture};
use surelight_tests::render::{Judge, all, bits, pooled, render};

/// 2^±10 times the light is 2^±10 times the picture, bit for bit.
#[test]
fn scale_emission() {
    let lit = |factor: f32| {
        let mut scene = torture::scene("scale-emission");
        scene.materials.iter_mut().for_each(|m| m.emissive = m.emissive.map(|e| e * factor));
        render(&scene, &Settings::new(32, 32), 2, 8)
    };
    let own = lit(1.0);
    for exponent in [-10, 10] {
        let factor = f64::from(exponent).exp2();
        let film = lit(factor as f32);
        for i in all(&own) {
            assert_eq!(film.mean(i), own.mean(i).map(|v| v * factor), "pixel {i}, brighter by 2^{exponent}");
        }
    }
}

fn scaled(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    scene.instances.iter_mut().for_each(|i| i.to_world = DAffine3::from_scale(DVec3::splat(factor)) * i.to_world);
    scene.cameras.iter_mut().for_each(|c| c.to_world.translation *= factor);
    scene
}

/// Offsets of rays and ends of shadow rays scale with the surface. Scaling by a power of two rounds
/// nothing, and changes no bit.
#[test]
fn scale_geometry() {
    let scene = torture::scene("scale-geometry");
    let bits_at =
        |exponent: i32| bits(&render(&scaled(&scene, f64::from(exponent).exp2()), &Settings::new(40, 40), 2, 16));
    let own = bits_at(0);
    for exponent in [-20, -7, 7, 20] {
        let other = bits_at(exponent);
        let differ = own.iter().zip(&other).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "scaled by 2^{exponent}, pixels differ");
    }
}

/// Scaling by anything else is rounding alone.
#[test]
fn scales_that_round() {
    let scene = quad_light::quad_light();
    let mean = |factor: f64| {
        let film = render(&scaled(&scene, factor), &Settings::new(48, 48), 4, 16);
        pooled(&film, 1, all(&film)).mean
    };
    let own = mean(1.0);
    for factor in [1e-5, 3.0, 1e5] {
        let change = mean(factor) / own - 1.0;
        println!("scaled by {factor:e}: {:+.5} %", 100.0 * change);
        assert!(change.abs() < 0.002, "scaled by {factor:e} it changes by {change:+.1e}");
    }
}

/// A furnace of two micrometres is a furnace.
#[test]
fn tiny_scene() {
    let film = render(&torture::scene("tiny-scene"), &Settings::new(40, 40), 16, 64);
    Judge::new(0.003).mean("furnace of 2 µm", &film, furnace::RADIANCE.map(f64::from));
}
