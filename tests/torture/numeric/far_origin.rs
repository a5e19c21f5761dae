//! Case 4 and companions: a scene far from the origin, or far from the camera, renders as one
//! nearby.

use glam::{DAffine3, DVec3, Vec3};
use surelight_accel::Instancing;
use surelight_prepare::Settings;
use surelight_scene::{LightKind, Scene};
use surelight_scenes::{
    cornell_box, furnace, glass, quad_light,
    shapes::Shape,
    torture::{self, numeric},
};
use surelight_tests::render::{Judge, all, render, ulps};
use surelight_tests::respawn::{assert_none, check, room};
use surelight_tests::scenes::{look_at, pinhole};

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

/// A furnace at 2^20 is a furnace, and no ray in a room whose corners are at 1e5 hits the wall that
/// it leaves.
#[test]
fn far_origin() {
    let film = render(&torture::scene("far-origin"), &Settings::new(40, 40), 16, 32);
    Judge::new(0.003).mean("furnace at 2^20", &film, furnace::RADIANCE.map(f64::from));
    let by = DVec3::new(-1e5, 1e5, 1e5);
    let cube = Shape::cuboid(by - DVec3::ONE, by + DVec3::ONE);
    assert_none([check("room at 1e5", &room(cube, by + DVec3::new(0.3, 0.25, 0.9)), Instancing::Never, 2.0)]);
    pictures();
}

/// Far from the *camera* the precision of f32 limits positions: at a distance d they are known to
/// some d·2^-22. A convex ball shows that rays are offset by as much: up to 1,000 radii away each
/// sample is the ball or the sky, and none is reflected twice.
///
/// A known issue beyond: at the ball's outline, the far side's computed distance is less than the
/// near side's, and a path that starts there is trapped inside. When none is any more, the last
/// assertion fails: raise the limit.
#[test]
fn through_a_telephoto_lens() {
    let (rho, sky) = (numeric::FURNACE_REFLECTANCE, numeric::FURNACE_SKY);
    let mut lost = Vec::new();
    for distance in [1e2, 1e3, 1e4, 1e6] {
        let mut scene = numeric::zero_variance_furnace();
        let eye = DVec3::new(0.6, 0.48, 0.64) * distance;
        scene.cameras = vec![pinhole(look_at(eye, DVec3::ZERO, DVec3::Y), (1.5 / distance).atan().to_degrees() * 2.0)];
        let film = render(&scene, &Settings::new(64, 64), 1, 1);
        let is = |i: usize, expected: [f32; 3]| (0..3).all(|c| ulps(film.mean(i)[c] as f32, expected[c]) <= 4);
        let reflected = all(&film).filter(|&i| is(i, [0, 1, 2].map(|c| rho[c] * sky[c]))).count();
        let missed = all(&film).filter(|&i| is(i, sky)).count();
        let black = all(&film).filter(|&i| is(i, [0.0; 3])).count();
        println!("at {distance:e}: {reflected} samples of the ball, {missed} of the sky, {black} lost in it");
        assert_eq!(reflected + missed + black, film.pixels().len(), "at {distance:e} some samples hit the ball twice");
        let share = reflected as f64 / film.pixels().len() as f64;
        // A circle of radius 1 in a square of 3.
        assert!(
            (share - std::f64::consts::PI / 9.0).abs() < 0.03,
            "{share} of the picture is the ball at {distance:e}"
        );
        lost.push(black);
    }
    assert_eq!(lost[..2], [0, 0], "within a thousand radii samples are lost");
    assert!(lost[3] > 0 && lost[3] < 82, "at a million radii {} of 4,096 samples are lost", lost[3]);
}

/// Same seed, same samples: only rounding differs.
fn pictures() {
    for scene in [cornell_box::cornell_box(), quad_light::quad_light(), glass::glass()] {
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

/// Vertices at 1e5 keep 2^-7 of a unit: a room whose corners are on that grid is the same room, and
/// its furnace exact.
#[test]
fn rooms_with_far_vertices() {
    let by = DVec3::new(-1e5, 1e5, 1e5);
    let room = moved(furnace::bare_room(), by, true);
    for mesh in &room.meshes {
        assert!(mesh.positions.iter().all(|p| (*p - by.as_vec3()).abs() == Vec3::ONE), "f32 has moved the corners");
    }
    let film = render(&room, &Settings::new(40, 40), 16, 32);
    Judge::new(LIMIT).mean("room at 1e5", &film, furnace::RADIANCE.map(f64::from));
}
