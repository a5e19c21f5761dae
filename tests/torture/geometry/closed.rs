//! Cases 9 and 12: closed surfaces that must not let light through.

use glam::{DVec3, Vec3};
use surelight_accel::Instancing;
use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_scene::Scene;
use surelight_scenes::torture::{self, geometry};
use surelight_tests::render::{all, prepare, render, trace};
use surelight_tests::respawn::paths;

/// Pixels that light has reached.
fn lit(film: &Film) -> usize {
    all(film).filter(|&i| film.mean(i) != [0.0; 3]).count()
}

/// Camera rays of a picture of this scene, and pixels that light has reached.
fn primary_hits(scene: &Scene, batches: u32) -> (u64, usize) {
    let film = trace(&prepare(scene, &Settings::new(256, 256)), [256, 256], batches, 16);
    (all(&film).map(|i| film.samples(i)).sum(), lit(&film))
}

#[test]
fn watertight_inside() {
    // Short of 1e8 rays in all the rounding up is to whole batches.
    let batches = if cfg!(feature = "long") { 48 } else { 2 };
    let (mut rays, mut pixels) = (0, 0);
    for scene in [torture::scene("watertight-inside"), torture::scene("vertex-edge-aim")] {
        let (r, p) = primary_hits(&scene, batches);
        (rays, pixels) = (rays + r, pixels + p);
    }
    println!("{rays} rays, light in {pixels} pixels");
    assert_eq!(pixels, 0, "light comes into a closed ball");
    // A single missing triangle is detected.
    let mut open = geometry::watertight_inside(DVec3::ZERO);
    let (ahead, mesh) = (-open.cameras[0].to_world.translation.as_vec3(), &mut open.meshes[0]);
    let along = |t: &[u32; 3]| t.iter().map(|&i| mesh.positions[i as usize]).sum::<Vec3>().dot(ahead);
    let seen =
        (0..mesh.triangles.len()).max_by(|&a, &b| along(&mesh.triangles[a]).total_cmp(&along(&mesh.triangles[b])));
    mesh.triangles.remove(seen.expect("it has triangles"));
    assert!(primary_hits(&open, 1).1 > 0, "a hole is not detected");
}

#[test]
fn concentric_4e_5() {
    let scene = geometry::concentric();
    let film = render(&scene, &Settings { max_bounces: Some(12), ..Settings::new(96, 96) }, 1, 16);
    assert_eq!(lit(&film), 0, "light comes into the gap");
    // Between the shells no ray is longer than along a face; one through the inside is.
    let (mut rays, mut longest) = (0, 0.0_f32);
    for path in (0..2).flat_map(|seed| paths(&scene, Instancing::Never, seed)) {
        for step in path {
            rays += 1;
            assert_ne!(step.triangle, u32::MAX, "a ray leaves the outer shell: {step:?}");
            longest = longest.max(step.t);
        }
    }
    println!("{rays} rays in the gap, the longest of {longest}");
    assert!(rays > 50_000 && longest < 0.5, "of {rays} rays one goes through the inside: {longest}");
}
