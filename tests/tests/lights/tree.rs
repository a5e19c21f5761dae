//! Which of many lights: the tree's choice.

use glam::{DVec3, Vec3};
use surelight_estimate::{chi_squared_test, sidak_level};
use surelight_prepare::{Part, Settings};
use surelight_scene::{Light, LightKind, Material, Scene};
use surelight_scenes::shapes::Shape;
use surelight_tests::light::{Query, probe};
use surelight_tests::random::Random;
use surelight_tests::render::{ALPHA, prepare};
use surelight_tests::scenes::{add, emitter, look_at, pinhole};

use crate::lamps::POINT;

/// Forty-eight triangles of a spiral, a third of them shining to both sides, some very bright, and
/// a cluster of 40 in one place.
fn many() -> Scene {
    let mut scene = Scene { name: "many".into(), ..Scene::default() };
    for k in 0..48 {
        let t = 0.5 + f64::from(k) * 0.3;
        let at = DVec3::new(t * t.cos(), 0.4 * t - 2.0, t * t.sin());
        let (e1, e2) = (DVec3::new(0.2, 0.1 * t.sin(), 0.0), DVec3::new(0.0, 0.1, 0.2 * t.cos()));
        let shape = Shape { positions: vec![at, at + e1, at + e2], triangles: vec![[0, 1, 2]], ..Shape::default() };
        let material = emitter([if k % 5 == 0 { 50.0 } else { 1.0 }; 3]);
        add(&mut scene, shape, Material { double_sided: k % 3 == 0, ..material });
    }
    // A glossy surface, so that the tree uses the mirrored direction, too.
    let shiny = Material { roughness: 0.3, ..Material::default() };
    add(&mut scene, Shape::parallelogram(DVec3::Z * -50.0, DVec3::X, DVec3::Y), shiny);
    add(&mut scene, Shape::icosphere(1).placed(0.1, DVec3::new(1.0, 0.5, -0.5)), emitter([2.0; 3]));
    scene.cameras = vec![pinhole(look_at(DVec3::ZERO, DVec3::Z, DVec3::Y), 60.0)];
    scene
}

/// Receivers that query the tree: within the spiral, on a light, in the cluster, far away; facing
/// anywhere, dull and glossy.
fn receivers() -> Vec<Query> {
    let mut random = Random::new(3);
    let mut receivers = Vec::new();
    let mut direction = || DVec3::from([0; 3].map(|_| 2.0 * f64::from(random.unit()) - 1.0)).normalize();
    for position in [[0.0; 3], [0.439, -1.8, 0.24], [1.0, 0.5, -0.5], [1.0, 0.61, -0.5], [300.0, 20.0, 1e4]] {
        for (both_sides, alpha, share) in [(0, 0.0, 0.0), (1, 0.3, 0.5), (0, 0.005, 0.96)] {
            let (normal, viewer) = (direction(), direction());
            let viewer = if viewer.dot(normal) < 0.0 { -viewer } else { viewer };
            let [normal, viewer] = [normal, viewer].map(|v| v.as_vec3().to_array());
            receivers.push(Query { both_sides, normal, alpha, viewer, share, ..Query::with(position, 0, [0.5; 2]) });
        }
    }
    receivers
}

/// At every receiver, a tree's choice of a light follows its stated probabilities, which add up to
/// one, are positive, and are the same from either end: from the descent that chooses, and from the
/// light that a direction hit.
#[test]
fn light_tree_choices_follow_its_probabilities() {
    let prepared = prepare(&many(), &Settings::new(8, 8));
    assert!(prepared.key().has(Part::LightTree));
    let lights = 48 + 80;
    let n = 100_000;
    let receivers = receivers();
    let level = sidak_level(ALPHA, receivers.len());
    for (k, receiver) in receivers.iter().enumerate() {
        let mut random = Random::new(100 + k as u64);
        let queries: Vec<_> =
            (0..n).map(|i| Query { choice: (random.bits() >> 32) as u32, light: i % lights, ..*receiver }).collect();
        let results = probe(&prepared, "probe_light_tree", &queries);
        let probabilities: Vec<f64> = results[..lights as usize].iter().map(|r| f64::from(r.other_pdf)).collect();
        let sum: f64 = probabilities.iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "probabilities at {receiver:?} add up to {sum}");
        assert!(probabilities.iter().all(|&p| p > 0.0), "a light is left out at {receiver:?}: {probabilities:?}");
        let mut observed = vec![0u64; lights as usize];
        for r in &results {
            let light = r.distance as usize;
            observed[light] += 1;
            assert!(
                (f64::from(r.pdf) / probabilities[light] - 1.0).abs() < 1e-4,
                "light {light} at {receiver:?}: {r:?}"
            );
        }
        let expected: Vec<_> = probabilities.iter().map(|p| p * f64::from(n)).collect();
        let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{e}"));
        println!(
            "asker {k}: the likeliest of {lights} lights {:.3}, χ² p = {:.4}",
            probabilities.iter().fold(0.0, |a, &b| b.max(a)),
            test.p
        );
        assert!(test.p > level, "{observed:?} instead of {expected:?} at {receiver:?}, p = {:.1e}", test.p);
    }
}

/// The ends of the range of choices give lights; and samples of the whole table carry the tree's
/// probability.
#[test]
fn a_trees_samples_are_whole() {
    let mut scene = many();
    scene.lights.push(Light { name: String::new(), kind: LightKind::Point { position: POINT }, intensity: [0.3; 3] });
    let prepared = prepare(&scene, &Settings::new(8, 8));
    let choices = (0..=64u64).map(|k| (k << 26).min(u64::from(u32::MAX)) as u32).flat_map(|c| [c, c.wrapping_sub(1)]);
    let queries: Vec<_> =
        choices.flat_map(|choice| receivers().into_iter().map(move |q| Query { choice, ..q })).collect();
    for s in probe(&prepared, "probe_light", &queries) {
        assert!(s.radiance.iter().all(|r| r.is_finite() && *r >= 0.0) && s.pdf.is_finite(), "{s:?}");
        assert!((Vec3::from(s.direction).length() - 1.0).abs() < 1e-5, "{s:?}");
    }
}
