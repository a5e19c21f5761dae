//! Case 19: shading normals that lean, and that face the wrong way.

use glam::{DVec3, Vec3};
use surelight_accel::oracle::{Oracle, ray_towards};
use surelight_prepare::Settings;
use surelight_scene::{Projection, Scene};
use surelight_scenes::torture;
use surelight_tests::render::{ALPHA, all, pooled, render};

use surelight_estimate::{sidak_level, z_test};

const SIZE: [u32; 2] = [48, 32];

/// Subpixels along each side that the truth is averaged over.
const FINE: u32 = 8;

/// The documented rule: a point whose shading normal leans by θ reflects (1 + cos θ)/2 of a white
/// sky. A normal that does not face the viewer is turned until it just does; one that then leaves
/// the surface's side is replaced by the geometric normal.
fn rule(shading: DVec3, geometric: DVec3, direction: DVec3) -> f64 {
    let side = -geometric.dot(direction).signum();
    let (ng, ns) = (geometric * side, shading * side);
    let lacking = (1e-3 + ns.dot(direction)).max(0.0);
    let turned = (ns - direction * lacking).normalize();
    let ns = if turned.dot(ng) > 0.0 { turned } else { ng };
    (1.0 + ns.dot(ng)) / 2.0
}

/// The average of each half of the picture by the rule, by rays in f64.
fn truth(scene: &Scene) -> [f64; 2] {
    let camera = &scene.cameras[0];
    let eye = camera.to_world.translation;
    let oracle = Oracle::new(scene, eye);
    let Projection::Perspective { yfov, .. } = camera.projection else { panic!("a pinhole") };
    let [width, height] = SIZE.map(|n| n * FINE);
    let (up, mut sums) = ((yfov / 2.0).tan(), [0.0; 2]);
    for y in 0..height {
        for x in 0..width {
            let at = |i: u32, n: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0;
            let across = up * f64::from(width) / f64::from(height);
            let local = DVec3::new(at(x, width) * across, -at(y, height) * up, -1.0);
            let direction = camera.to_world.transform_vector3(local).normalize();
            let ray = ray_towards(Vec3::ZERO, direction.as_vec3());
            let shown = oracle.intersect(&ray).map_or(1.0, |c| {
                let mesh = &scene.meshes[c.mesh as usize];
                let [p, q, r] = c.vertices.map(|i| mesh.positions[i as usize].as_dvec3());
                let normals = mesh.normals.as_ref().expect("the balls are smooth");
                let [a, b, d] = c.vertices.map(|i| normals[i as usize].as_dvec3());
                let shading = (a * (1.0 - c.b[0] - c.b[1]) + b * c.b[0] + d * c.b[1]).normalize();
                rule(shading, (q - p).cross(r - p).normalize(), direction)
            });
            sums[usize::from(x >= width / 2)] += shown;
        }
    }
    sums.map(|s| s * 2.0 / f64::from(width * height))
}

#[test]
fn shading_normal_flip() {
    let scene = torture::scene("shading-normal-flip");
    let film = render(&scene, &Settings::new(SIZE[0], SIZE[1]), 16, 64);
    let brightest = all(&film).map(|i| film.mean(i)[1]).fold(0.0, f64::max);
    assert!(brightest <= 1.0, "a white ball in a white sky shows {brightest}");
    let level = sidak_level(ALPHA, 2);
    for (half, truth) in truth(&scene).into_iter().enumerate() {
        let own = |i: &usize| usize::from(*i as u32 % SIZE[0] >= SIZE[0] / 2) == half;
        let mean = pooled(&film, 1, all(&film).filter(own));
        // The truth is an average over finite subpixels, too: silhouettes make it uncertain by some
        // 1e-4.
        let test = z_test(mean.mean, mean.variance.sqrt().hypot(1e-4), truth, level);
        let name = ["smooth", "turned over"][half];
        println!(
            "{name}: {:.5}, truth {truth:.5}, z {:+.2}; a bias of {:.2} % would be detected",
            mean.mean,
            test.z,
            100.0 * test.detectable
        );
        assert!(
            test.p > level && test.detectable < 0.01,
            "{name}: {} instead of {truth}, z = {:.2}",
            mean.mean,
            test.z
        );
    }
}
