//! The respawn probe: paths through rooms, traced by the shipped traversal and vertex on the device
//! and recorded ray by ray.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use surelight_accel::{BuildOptions, Instancing};
use surelight_prepare::{Directions, Integrator, Settings};
use surelight_render::run_probe;
use surelight_scene::Scene;
use surelight_scenes::shapes::Shape;

use crate::render::{device, prepare};
use crate::scenes::{add, lambert, look_at, pinhole};

/// `Step` of shaders/probe/respawn.wesl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Step {
    /// Of the ray.
    pub origin: [f32; 3],
    /// Where it ends, in lengths of the direction.
    pub t: f32,
    /// Unit; zero where the path had ended.
    pub direction: [f32; 3],
    /// The triangle that it hits: `u32::MAX` for none.
    pub triangle: u32,
}

const SIDE: u32 = 128;
const STEPS: usize = 8;

/// The paths of a picture of 128 × 128 pixels, one per pixel, up to eight rays each.
pub fn paths(scene: &Scene, instancing: Instancing, seed: u32) -> Vec<Vec<Step>> {
    let build = BuildOptions { instancing, ..BuildOptions::default() };
    let integrator = Integrator::Hemisphere(Directions::Bsdf);
    let prepared = prepare(scene, &Settings { seed, integrator, build, ..Settings::new(SIDE, SIDE) });
    let pixels: Vec<u32> = (0..SIDE * SIDE).collect();
    let steps: Vec<Step> =
        run_probe(device(), &prepared, "package::probe::respawn", "probe_respawn", &pixels, pixels.len() * STEPS)
            .unwrap_or_else(|e| panic!("{e}"));
    let path = |steps: &[Step]| steps.iter().copied().take_while(|s| s.direction != [0.0; 3]).collect();
    steps.chunks_exact(STEPS).map(path).collect()
}

/// A closed shape viewed from inside.
pub fn room(shape: Shape, eye: DVec3) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, shape.turned_over(), lambert([0.95; 3]));
    scene.cameras = vec![pinhole(look_at(eye, eye + DVec3::new(0.3, -0.2, -1.0), DVec3::Y), 90.0)];
    scene
}

/// Traces four pictures' paths through a closed room and reports errors; `size`: of the room.
pub fn check(name: &str, scene: &Scene, instancing: Instancing, size: f32) -> Option<String> {
    let (mut rays, mut escaped, mut self_hits) = (0, 0, 0);
    for path in (0..4).flat_map(|seed| paths(scene, instancing, seed)) {
        for (k, step) in path.iter().enumerate() {
            rays += 1;
            escaped += usize::from(step.triangle == u32::MAX);
            // A distance at which rays between walls are too rare to matter: only a wall itself is
            // so near.
            self_hits += usize::from(k > 0 && step.triangle == path[k - 1].triangle && step.t < 1e-4 * size);
        }
    }
    println!("{name}: {rays} rays, {escaped} escape, {self_hits} hit the wall that they leave");
    let paths_are_whole = rays > 400_000;
    let ok = paths_are_whole && escaped <= MAX_ESCAPES && self_hits == 0;
    (!ok).then(|| format!("{name}: of {rays} rays {escaped} escape and {self_hits} hit the wall that they leave"))
}

/// Of half a million rays. A ray that starts in the very edge between two walls, nearer than its
/// offset to the other, is beyond it.
const MAX_ESCAPES: usize = 2;

/// No check has failed.
pub fn assert_none(failures: impl IntoIterator<Item = Option<String>>) {
    let failures: Vec<_> = failures.into_iter().flatten().collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
