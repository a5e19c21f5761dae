//! A flat surface under a uniform sky shows its directional albedo: the whole renderer against quadrature in f64, with the sky
//! found by chance (uniform) and sampled as a light (the same sky as a map).

use glam::DVec3;
use surelight_render::Settings;
use surelight_scene::{Environment, Material, Scene, procedural::shapes::Shape};
use surelight_tests::bsdf::Material as Probed;
use surelight_tests::bsdf_oracle::albedo;
use surelight_tests::render::{Judge, render};
use surelight_tests::scenes::{add, look_at, map, orthographic};

/// Pictures in this file.
const PICTURES: usize = 36;

/// `seed`: pictures with the same seed would err alike.
fn check(name: &str, seed: u32, material: Material, probed: impl Fn(f64) -> Probed) {
    for (degrees, look) in [(0.0f64, 0), (60.0, 2), (80.0, 4)] {
        let exact = albedo(&probed(degrees), 384).sum();
        let half = albedo(&probed(degrees), 192).sum();
        // The error of quadrature is at most its change from half the points.
        let resolution = ((exact - half) / exact).abs().max_element().max(2e-5);
        assert!(resolution < 1e-3, "{name} at {degrees}°: quadrature has not converged: {half}, {exact}");
        let judge = Judge { resolution, ..Judge::of(PICTURES, 0.006) };
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut scene = Scene { name: name.into(), ..Scene::default() };
        add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 50.0, DVec3::NEG_Z * 50.0), material.clone());
        let eye = DVec3::new(0.6 * sin, cos, 0.8 * sin) * 5.0;
        scene.cameras = vec![orthographic(look_at(eye, DVec3::ZERO, DVec3::new(-0.8, 0.1, 0.6)), 0.5)];
        for ((sky, environment), look) in
            [("found", Environment::Uniform([1.0; 3])), ("sampled", map(16, 8, |_, _| [1.0; 3]))]
                .into_iter()
                .zip(look..)
        {
            scene.environment = Some(environment);
            let settings = Settings { seed: 10 * seed + look, ..Settings::new(32, 32) };
            let film = render(&scene, &settings, 16, 16);
            judge.mean(&format!("{name} at {degrees}°, sky {sky}"), &film, exact.to_array());
        }
    }
}

#[test]
fn metals() {
    for (alpha, seed) in [(0.01f32, 1), (0.1, 2), (0.5, 3), (1.0, 4)] {
        let base = [0.9, 0.6, 0.3];
        let material = Material {
            base_color: [base[0], base[1], base[2], 1.0],
            metallic: 1.0,
            roughness: alpha.sqrt(),
            ..Material::default()
        };
        check(&format!("metal, α {alpha}"), seed, material, |degrees| Probed {
            base_color: base,
            ..Probed::metal(alpha, degrees)
        });
    }
}

#[test]
fn dielectrics() {
    for (alpha, seed) in [(0.05f32, 5), (0.5, 6)] {
        let base = [0.8, 0.5, 0.2];
        let material = Material {
            base_color: [base[0], base[1], base[2], 1.0],
            metallic: 0.0,
            roughness: alpha.sqrt(),
            ..Material::default()
        };
        let probed = |degrees| Probed { base_color: base, ..Probed::dielectric(alpha, degrees) };
        check(&format!("dielectric, α {alpha}"), seed, material, probed);
    }
}
