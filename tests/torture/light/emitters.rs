//! Emitters with alpha: a point on a light is weighted by the coverage there, for every estimator
//! that samples lights.
//!
//! A ray hits an emitter only where it is covered: BLEND's alpha is the probability of that, MASK's
//! test is 0 or 1. Light sampling must multiply by the same, or a hidden emitter lights the room.

use glam::{DAffine3, DMat3, DVec3, Vec4};
use surelight_prepare::{Directions, Integrator, Part, Settings};
use surelight_scene::{AlphaMode, Filter, Image, Instance, Material, Scene, Texture, TextureRef, Wrap};
use surelight_scenes::{quad_light, shapes::Shape};
use surelight_tests::render::{Judge, all, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, orthographic, pinhole};
use surelight_tests::welch::Comparison;

use super::caustics;

const SIZE: u32 = 24;

/// Estimators that sample lights, and the one that never does.
const INTEGRATORS: [(&str, Integrator); 3] =
    [("mis", Integrator::Mis), ("area", Integrator::Area), ("hemisphere", Integrator::Hemisphere(Directions::Bsdf))];

/// Pictures whose means are judged by closed forms, and compared.
const PICTURES: usize = 15;
const COMPARISONS: usize = 6;

fn settings(integrator: Integrator, seed: u32) -> Settings {
    Settings { integrator, seed, ..Settings::new(SIZE, SIZE) }
}

/// A floor under a black square lamp of a metre, viewed from above the lamp's edge: parallel rays
/// of half a metre around a point.
fn lit_floor(alpha: f32, mode: AlphaMode) -> Scene {
    let mut scene = Scene { name: "lit floor".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), lambert([0.5; 3]));
    let material = Material { base_color: [0.0, 0.0, 0.0, alpha], alpha_mode: mode, ..emitter([3.0, 2.0, 1.0]) };
    // It shines downwards.
    let lamp = Shape::parallelogram(DVec3::Y, DVec3::X * 0.5, DVec3::Z * 0.5);
    add(&mut scene, lamp, material);
    scene.cameras.push(orthographic(look_at(DVec3::new(1.2, 3.0, 0.0), DVec3::X * 1.2, DVec3::NEG_Z), 0.25));
    scene
}

/// Radiance of the floor under a lamp of these corners: Lambert's formula, meaned over the picture.
fn lambert_mean(corners: [[f64; 2]; 4]) -> f64 {
    const GRID: usize = 24;
    let polygon = corners.map(|[x, z]| DVec3::new(x, 1.0, z));
    let at = |k: usize| 0.25 * ((k as f64 + 0.5) / GRID as f64 * 2.0 - 1.0);
    let points = (0..GRID * GRID).map(|k| DVec3::new(1.2 + at(k % GRID), 0.0, at(k / GRID)));
    let sum: f64 = points.map(|p| surelight_scenes::polygon_irradiance(p, DVec3::Y, &polygon).abs()).sum();
    0.5 / std::f64::consts::PI * sum / (GRID * GRID) as f64
}

const WHOLE: [[f64; 2]; 4] = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];

/// A texture of texels one above the other, by their alphas.
fn alpha_texture(scene: &mut Scene, width: u32, alphas: &[u8]) -> TextureRef {
    let rgba = alphas.iter().flat_map(|&a| [0, 0, 0, a]).collect();
    let height = alphas.len() as u32 / width;
    scene.images.push(Image { name: "alpha".into(), width, height, rgba });
    let image = scene.images.len() - 1;
    let wrap = Wrap::ClampToEdge;
    scene.textures.push(Texture { image, wrap_s: wrap, wrap_t: wrap, filter: Filter::Nearest });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: None }
}

/// A lamp that is there by its alpha lights the floor by Lambert's formula times its coverage.
#[test]
fn emitters_count_by_coverage() {
    let judge = Judge { resolution: 2e-4, ..Judge::of(PICTURES, 0.06) };
    let whole = lambert_mean(WHOLE);
    let cases = [
        ("opaque", lit_floor(0.25, AlphaMode::Opaque), whole),
        ("blended", lit_floor(0.25, AlphaMode::Blend), 0.25 * whole),
        ("kept by a mask", lit_floor(0.6, AlphaMode::Mask(0.5)), whole),
        ("half by a texture", half_by_texture(), lambert_mean([[-0.5, -0.5], [0.0, -0.5], [0.0, 0.5], [-0.5, 0.5]])),
        ("by vertices", by_vertices(), 0.4 * whole),
    ];
    for (seed, (name, scene, truth)) in (1..).zip(&cases) {
        for (method, integrator) in INTEGRATORS {
            // Directions find the lamp one time in thirty, and a blended one more seldom.
            let samples = if method == "hemisphere" { 1024 } else { 64 };
            let film = render(scene, &settings(integrator, seed), 16, samples);
            judge.mean(&format!("{name}, {method}"), &film, [3.0, 2.0, 1.0].map(|l| l * truth));
        }
    }
    // Surfaces of alpha 0 emit nothing, and are no lights to sample.
    for (alpha, mode) in [(0.4, AlphaMode::Mask(0.5)), (0.0, AlphaMode::Blend)] {
        let gone = lit_floor(alpha, mode);
        for (method, integrator) in INTEGRATORS {
            let film = render(&gone, &settings(integrator, 9), 2, 16);
            assert!(all(&film).all(|i| film.mean(i) == [0.0; 3]), "{mode:?} by {method}: light from nothing");
        }
        assert!(!prepare(&gone, &settings(Integrator::Mis, 0)).key().has(Part::LightSampling), "{mode:?} is sampled");
    }
}

/// The lamp's left half, by a mask whose texture has two texels.
fn half_by_texture() -> Scene {
    let mut scene = lit_floor(1.0, AlphaMode::Mask(0.5));
    let texture = alpha_texture(&mut scene, 2, &[255, 0]);
    scene.materials[1].base_color_texture = Some(texture);
    let mesh = &mut scene.meshes[1];
    mesh.uvs = vec![mesh.positions.iter().map(|p| glam::Vec2::new(p.x + 0.5, p.z + 0.5)).collect()];
    scene
}

/// A blended lamp whose vertices have an alpha of 0.5 beside the material's 0.8.
fn by_vertices() -> Scene {
    let mut scene = lit_floor(0.8, AlphaMode::Blend);
    let mesh = &mut scene.meshes[1];
    mesh.colors = Some(vec![Vec4::new(1.0, 1.0, 1.0, 0.5); mesh.positions.len()]);
    scene
}

/// Lamps of every kind of coverage at once, under a light tree, one of them placed twice and
/// mirrored once; and shining to both sides.
fn lamps() -> Scene {
    let mut scene = Scene { name: "lamps with alpha".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert([0.7, 0.6, 0.5]));
    let texture = alpha_texture(&mut scene, 4, &[255, 200, 40, 0, 255, 90, 0, 20, 180, 255, 130, 60]);
    let glowing = Material {
        emissive_texture: Some(texture.clone()),
        base_color_texture: Some(texture),
        alpha_mode: AlphaMode::Blend,
        double_sided: true,
        ..emitter([8.0, 6.0, 4.0])
    };
    // Colours that differ from corner to corner distinguish a mirrored lamp from its image.
    for (i, texel) in scene.images[0].rgba.chunks_exact_mut(4).enumerate() {
        texel[..3].copy_from_slice(&[255 - 20 * i as u8, 60 + 10 * i as u8, 30 * (i % 4) as u8]);
    }
    let lamp = Shape::parallelogram(DVec3::ZERO, DVec3::X * 0.4, DVec3::Z * 0.3);
    scene.materials.push(glowing);
    scene.meshes.push(lamp.into_mesh("lamp", scene.materials.len() - 1, false));
    for (x, mirror) in [(-0.5, 1.0), (0.5, -1.0)] {
        let matrix3 = DMat3::from_diagonal(DVec3::new(mirror, 1.0, 1.0));
        let to_world = DAffine3 { matrix3, translation: DVec3::new(x, 0.6, 0.2) };
        scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world });
    }
    let masked = Material { base_color: [0.0, 0.0, 0.0, 0.3], alpha_mode: AlphaMode::Mask(0.5), ..emitter([50.0; 3]) };
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 0.5, -0.5), DVec3::X * 0.3, DVec3::Z * 0.3), masked);
    let eye = look_at(DVec3::new(0.4, 1.6, 2.0), DVec3::new(0.0, 0.1, 0.0), DVec3::Y);
    scene.cameras.push(pinhole(eye, 45.0));
    scene
}

/// All estimators agree about lamps of varying coverage, copied and instanced.
#[test]
fn estimators_agree_about_emitters_with_alpha() {
    let scene = lamps();
    for (k, instanced) in [(0, false), (1, true)] {
        let of = |integrator, seed| {
            let mut settings = settings(integrator, seed);
            if instanced {
                settings.build.instancing = surelight_accel::Instancing::Always;
            }
            settings
        };
        assert_eq!(prepare(&scene, &of(Integrator::Mis, 0)).key().has(Part::Instances), instanced);
        let reference = render(&scene, &of(INTEGRATORS[2].1, 20 + k), 16, 512);
        for (method, integrator) in &INTEGRATORS[..2] {
            let film = render(&scene, &of(*integrator, 30 + k), 16, 64);
            let comparison = Comparison { power: 0.03, pictures: COMPARISONS, pixels: false };
            comparison.assert_equal(&format!("{method}, instanced: {instanced}"), &film, &reference);
        }
    }
}

/// Particles leave a blended lamp by its coverage, as paths hit it by chance.
#[test]
fn particles_leave_emitters_by_coverage() {
    let mut scene = caustics::table_of_glass();
    let lamp = scene.materials.iter().position(Material::is_emissive).expect("there is a lamp");
    scene.materials[lamp].alpha_mode = AlphaMode::Blend;
    scene.materials[lamp].base_color[3] = 0.4;
    caustics::assert_as_by_chance("a blended lamp over glass", &scene);
}

/// A lamp that is its own size in the scene of Lambert's formula.
#[test]
fn a_blended_lamp_is_seen_by_its_coverage() {
    let mut scene = quad_light::quad_light();
    let lamp = scene.materials.iter().position(Material::is_emissive).expect("there is a lamp");
    let whole = render(&scene, &Settings::new(48, 32), 16, 64);
    scene.materials[lamp].alpha_mode = AlphaMode::Blend;
    scene.materials[lamp].base_color[3] = 0.5;
    let half = render(&scene, &Settings { seed: 1, ..Settings::new(48, 32) }, 16, 256);
    // Pixels that show the floor alone are half as bright.
    let floor = |i: &usize| whole.mean(*i)[0] < 1.0 && whole.mean(*i)[0] > 0.0;
    let sum = |film: &surelight_film::Film| all(film).filter(floor).map(|i| film.mean(i)[0]).sum::<f64>();
    let ratio = sum(&half) / sum(&whole);
    println!("the floor has {ratio:.5} of its light");
    assert!((ratio - 0.5).abs() < 2e-3, "{ratio}");
}
