//! A scene that stands 1e5 units from the origin looks as it does at the origin: within 0.2 % of the mean.

use glam::{DAffine3, DVec3, Vec3};
use surelight_render::Settings;
use surelight_scene::{LightKind, Scene, procedural};
use surelight_tests::render::{Judge, all, bits, pooled, render};

const LIMIT: f64 = 0.002;

/// The whole scene moved: by its nodes, or by its vertices as far as f32 has room.
fn moved(mut scene: Scene, by: DVec3, vertices: bool) -> Scene {
    if vertices {
        for mesh in &mut scene.meshes {
            mesh.positions.iter_mut().for_each(|p| *p = (p.as_dvec3() + by).as_vec3());
        }
    } else {
        scene.instances.iter_mut().for_each(|i| i.to_world = DAffine3::from_translation(by) * i.to_world);
    }
    scene.cameras.iter_mut().for_each(|c| c.to_world.translation += by);
    for light in &mut scene.lights {
        if let LightKind::Point { position } | LightKind::Spot { position, .. } = &mut light.kind {
            *position += by;
        }
    }
    scene
}

const DISTANCES: [DVec3; 3] = [
    DVec3::new(1e3, 2e3, -1e3),
    DVec3::new(-1e5, 1e5, 1e5),
    // The Earth's radius in metres.
    DVec3::new(0.0, 6.4e6, 0.0),
];

/// Same seed, same samples: what differs is rounding alone.
#[test]
fn by_its_nodes() {
    for scene in
        [procedural::cornell_box::cornell_box(), procedural::quad_light::quad_light(), procedural::glass::glass()]
    {
        let near = render(&scene, &Settings::new(48, 48), 4, 16);
        for by in DISTANCES {
            let far = render(&moved(scene.clone(), by, false), &Settings::new(48, 48), 4, 16);
            let mean = |film| all(film).map(|i| film.mean(i)[1]).sum::<f64>();
            let change = mean(&far) / mean(&near) - 1.0;
            println!("{} at {by}: {:+.4} %", scene.name, 100.0 * change);
            assert!(change.abs() < LIMIT, "{} at {by} changes by {change:+.1e}", scene.name);
        }
    }
}

/// Vertices at 1e5 keep 2^-7 of a unit: a room whose corners lie on that grid is the same room, and its furnace exact.
#[test]
fn by_its_vertices() {
    let by = DVec3::new(-1e5, 1e5, 1e5);
    let room = moved(procedural::furnace::bare_room(), by, true);
    for mesh in &room.meshes {
        assert!(mesh.positions.iter().all(|p| (*p - by.as_vec3()).abs() == Vec3::ONE), "f32 has moved the corners");
    }
    let film = render(&room, &Settings::new(40, 40), 16, 32);
    Judge::new(LIMIT).mean("room at 1e5", &film, procedural::furnace::RADIANCE.map(f64::from));
}

/// Large and small worlds look alike: offsets of rays and ends of shadow rays scale with what they stand on. Scaling by a power of
/// two rounds nothing, and changes no bit.
#[test]
fn at_any_scale() {
    let scene = procedural::quad_light::quad_light();
    let scaled = |factor: f64| {
        let mut scene = scene.clone();
        scene.instances.iter_mut().for_each(|i| i.to_world = DAffine3::from_scale(DVec3::splat(factor)) * i.to_world);
        scene.cameras.iter_mut().for_each(|c| c.to_world.translation *= factor);
        render(&scene, &Settings::new(48, 48), 4, 16)
    };
    let own = scaled(1.0);
    for exponent in [-20, -7, 7, 20] {
        assert!(
            bits(&scaled(f64::from(exponent).exp2())) == bits(&own),
            "scaled by 2^{exponent} it is another picture"
        );
    }
    for factor in [1e-5, 3.0, 1e5] {
        let film = scaled(factor);
        let (a, b) = (pooled(&own, 1, all(&own)), pooled(&film, 1, all(&film)));
        let change = b.mean / a.mean - 1.0;
        println!("scaled by {factor:e}: {:+.5} %", 100.0 * change);
        assert!(change.abs() < LIMIT, "scaled by {factor:e} it changes by {change:+.1e}");
    }
}

/// Twice the light is twice the picture, bit for bit.
#[test]
fn at_any_brightness() {
    let lit = |factor: f32| {
        let mut scene = procedural::cornell_box::cornell_box();
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
