//! A flat surface under a uniform sky shows its directional albedo: the whole renderer against
//! quadrature in f64, with the sky found by chance (uniform) and sampled as a light (the same sky
//! as a map).

use glam::DVec3;
use surelight_prepare::{Part, Settings};
use surelight_scene::{Anisotropy, Clearcoat, DiffuseTransmission, Environment, Iridescence, Material, Scene, Sheen};
use surelight_scenes::shapes::Shape;
use surelight_tests::bsdf::Material as Probed;
use surelight_tests::bsdf_oracle::albedo;
use surelight_tests::layer_oracle::Layered;
use surelight_tests::render::{Judge, render};
use surelight_tests::scenes::{add, look_at, map, orthographic};

/// Pictures in this file.
const PICTURES: usize = 60;

/// The light that the material scatters under uniform illumination, by quadrature.
fn exact(probed: &Probed, n: usize) -> DVec3 {
    if probed.key().has(Part::Clearcoat) || probed.key().has(Part::Sheen) || probed.alpha != probed.alpha_along {
        return Layered::new(probed).albedos(n).iter().sum();
    }
    albedo(probed, n).sum()
}

/// `seed`: pictures with the same seed would err alike.
fn check(name: &str, seed: u32, material: Material, probed: impl Fn(f64) -> Probed) {
    for (degrees, look) in [(0.0f64, 0), (60.0, 2), (80.0, 4)] {
        let half = exact(&probed(degrees), 192);
        let exact = exact(&probed(degrees), 384);
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

/// With multiple scattering, white metal returns all light at every roughness.
#[test]
fn white_metal_loses_nothing_to_multiple_scattering() {
    for (k, alpha) in [0.1f32, 0.3, 0.6, 1.0].into_iter().enumerate() {
        for (degrees, look) in [(0.0f64, 0), (60.0, 1), (80.0, 2)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let mut scene = Scene { name: format!("white metal, α {alpha}, at {degrees}°"), ..Scene::default() };
            let white = Material { metallic: 1.0, roughness: alpha.sqrt(), ..Material::default() };
            add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 50.0, DVec3::NEG_Z * 50.0), white);
            let eye = DVec3::new(0.6 * sin, cos, 0.8 * sin) * 5.0;
            scene.cameras = vec![orthographic(look_at(eye, DVec3::ZERO, DVec3::new(-0.8, 0.1, 0.6)), 0.5)];
            scene.environment = Some(Environment::Uniform([1.0; 3]));
            let settings = Settings { seed: 500 + 10 * k as u32 + look, ..Settings::new(32, 32) };
            let once = render(&scene, &settings, 16, 16).mean(0)[0];
            let film = render(&scene, &Settings { multiple_scattering: true, ..settings }, 16, 16);
            assert!(alpha < 0.2 || once < 0.98, "{}: facets that scatter once return {once}", scene.name);
            // The table between its nodes.
            let judge = Judge { resolution: 0.0018, ..Judge::of(12, 0.01) };
            judge.mean(&scene.name, &film, [1.0; 3]);
        }
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

/// From the camera of `check`, in a frame whose x is the tangent (the world's X).
fn seen(m: Probed, degrees: f64) -> Probed {
    let (s, c) = degrees.to_radians().sin_cos();
    Probed { wo: [(0.6 * s) as f32, (-0.8 * s) as f32, c as f32], ..m }
}

#[test]
fn coated_velvet() {
    let base = [0.8, 0.5, 0.2];
    let material = Material {
        base_color: [base[0], base[1], base[2], 1.0],
        metallic: 0.0,
        roughness: 0.6,
        clearcoat: Clearcoat { factor: 0.8, roughness: 0.5, ..Clearcoat::default() },
        sheen: Sheen { color: [0.9, 0.6, 0.3], roughness: 0.7, ..Sheen::default() },
        ..Material::default()
    };
    let alpha = |roughness: f32| roughness * roughness;
    check("coated velvet", 7, material, |degrees| {
        let m = Probed::dielectric(alpha(0.6), degrees).with_sheen(alpha(0.7)).coated(alpha(0.5));
        seen(Probed { base_color: base, coat_normal: [0.0, 0.0, 1.0], ..m }, degrees)
    });
}

/// An anisotropy turned by 90° is along y.
#[test]
fn brushed_metal() {
    let base = [0.9, 0.6, 0.3];
    for (turn, seed) in [(0.0f32, 8), (std::f32::consts::FRAC_PI_2, 9)] {
        let material = Material {
            base_color: [base[0], base[1], base[2], 1.0],
            roughness: 0.5,
            anisotropy: Anisotropy { strength: 0.8, rotation: turn, texture: None },
            ..Material::default()
        };
        let (alpha, along) = (0.25, 0.25 + 0.75 * 0.64);
        check(&format!("metal brushed at {turn}"), seed, material, |degrees| {
            let m = seen(Probed { base_color: base, ..Probed::metal(alpha, degrees).brushed(along) }, degrees);
            if turn == 0.0 { m } else { Probed { alpha: along, alpha_along: alpha, ..m } }
        });
    }
}

#[test]
fn filmed_leaf() {
    let base = [0.2, 0.6, 0.3];
    let material = Material {
        base_color: [base[0], base[1], base[2], 1.0],
        metallic: 0.0,
        roughness: 0.7,
        iridescence: Iridescence { factor: 0.9, thickness_maximum: 300.0, ..Iridescence::default() },
        diffuse_transmission: DiffuseTransmission {
            factor: 0.4,
            color: [0.2, 0.5, 0.9],
            ..DiffuseTransmission::default()
        },
        // For the oracle's other quadrature.
        sheen: Sheen { color: [0.0, 0.01, 0.0], roughness: 1.0, ..Sheen::default() },
        ..Material::default()
    };
    check("leaf with a film", 10, material, |degrees| {
        let m = Probed::dielectric(0.49, degrees).filmed(300.0).translucent(0.4);
        seen(Probed { base_color: base, sheen_color: [0.0, 0.01, 0.0], sheen_alpha: 1.0, ..m }, degrees)
    });
}
