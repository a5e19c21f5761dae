//! Rays that leave a surface, by the kernel's own offset, neither meet it again nor get out of a closed room: paths through rooms
//! of every shape, traced by the shipped walk and vertex on the device and told ray by ray.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3};
use surelight_accel::{BuildOptions, Instancing};
use surelight_render::{Directions, Integrator, Settings, run_probe};
use surelight_scene::{Scene, procedural::shapes::Shape};
use surelight_tests::render::{device, prepare};
use surelight_tests::scenes::{add, lambert, look_at, pinhole};

/// `Step` of shaders/probe/respawn.wesl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Step {
    origin: [f32; 3],
    t: f32,
    direction: [f32; 3],
    triangle: u32,
}

const SIDE: u32 = 128;
const STEPS: usize = 8;

/// A closed shape seen from inside.
fn room(shape: Shape, eye: DVec3) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, shape.turned_over(), lambert([0.95; 3]));
    scene.cameras = vec![pinhole(look_at(eye, eye + DVec3::new(0.3, -0.2, -1.0), DVec3::Y), 90.0)];
    scene
}

/// Traces four pictures' paths; `size`: of the room.
fn check(name: &str, scene: &Scene, instancing: Instancing, size: f32) -> Option<String> {
    let build = BuildOptions { instancing, ..BuildOptions::default() };
    let (mut rays, mut escaped, mut met_itself) = (0, 0, 0);
    for seed in 0..4 {
        let integrator = Integrator::Hemisphere(Directions::Bsdf);
        let prepared = prepare(scene, &Settings { seed, integrator, build, ..Settings::new(SIDE, SIDE) });
        let pixels: Vec<u32> = (0..SIDE * SIDE).collect();
        let steps: Vec<Step> =
            run_probe(device(), &prepared, "package::probe::respawn", "probe_respawn", &pixels, pixels.len() * STEPS)
                .unwrap_or_else(|e| panic!("{e}"));
        for path in steps.chunks_exact(STEPS) {
            for (k, step) in path.iter().take_while(|s| s.direction != [0.0; 3]).enumerate() {
                rays += 1;
                escaped += usize::from(step.triangle == u32::MAX);
                // A distance at which rays between walls are too rare to count: only a wall itself is so near.
                met_itself += usize::from(k > 0 && step.triangle == path[k - 1].triangle && step.t < 1e-4 * size);
            }
        }
    }
    println!("{name}: {rays} rays, {escaped} escape, {met_itself} meet the wall that they leave");
    let paths_are_whole = rays > 400_000;
    let ok = paths_are_whole && escaped <= MOST_ESCAPES && met_itself == 0;
    (!ok).then(|| format!("{name}: of {rays} rays {escaped} escape and {met_itself} meet the wall that they leave"))
}

/// Of half a million rays. A ray that starts in the very edge between two walls, nearer than its offset to the other, is beyond it.
const MOST_ESCAPES: usize = 2;

fn assert_none(failures: Vec<String>) {
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn in_rooms_of_every_shape() {
    let cube = || Shape::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
    let hall = || Shape::cuboid(DVec3::splat(-1.0), DVec3::new(40.0, 1.0, 300.0));
    let eye = DVec3::new(0.0, 0.2, 5.0);
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let rooms = [
        ("cube", room(cube(), DVec3::new(0.3, 0.25, 0.9)), 2.0),
        ("turned cube", room(cube().transformed(&turn), DVec3::new(0.2, 0.25, 0.3)), 2.0),
        ("hall", room(hall(), eye), 300.0),
        ("turned hall", room(hall().transformed(&turn), turn.transform_point3(eye)), 300.0),
        ("ball", room(Shape::icosphere(3).faceted(), DVec3::ZERO), 2.0),
        ("slivers", room(Shape::uv_sphere(200, 4).faceted().bare(), DVec3::ZERO), 2.0),
        ("tiny cube", room(cube().placed(1e-6, DVec3::ZERO), DVec3::new(3e-7, 2e-7, 9e-7)), 2e-6),
        ("huge cube", room(cube().placed(1e6, DVec3::ZERO), DVec3::new(3e5, 2e5, 9e5)), 2e6),
    ];
    assert_none(rooms.iter().filter_map(|(name, scene, size)| check(name, scene, Instancing::Never, *size)).collect());
}

#[test]
fn in_rooms_that_are_instances() {
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let rooms =
        [("turned", DVec3::ONE), ("stretched", DVec3::new(0.1, 1.0, 7.0)), ("mirrored", DVec3::new(-2.0, 1.0, 1.0))];
    let failures = rooms.iter().filter_map(|(name, scale)| {
        let cube = Shape::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)).transformed(&turn);
        let mut scene = room(cube, DVec3::ZERO);
        scene.instances[0].to_world = turn * DAffine3::from_scale(*scale);
        check(name, &scene, Instancing::Always, 2.0 * scale.abs().max_element() as f32)
    });
    assert_none(failures.collect());
}
