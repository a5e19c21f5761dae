//! Light through panes, smooth thin walls: shadow rays go straight through them with their
//! transmittance, exactly once.

use std::f64::consts::PI;

use glam::DVec3;
use surelight_prepare::{Directions, Integrator, Part, PathReuse, Settings};
use surelight_scene::{
    AlphaMode, Clearcoat, Environment, Filter, Image, Light, LightKind, Material, Scene, Sheen, Texture, TextureRef,
    Volume, Wrap,
};
use surelight_scenes::{shapes::Shape, window};
use surelight_tests::render::{all, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, orthographic, pinhole};
use surelight_tests::welch::Comparison;

const SIZE: u32 = 24;

/// Comparisons in this file.
const PICTURES: usize = 12;

fn pane(tint: [f32; 3]) -> Material {
    let [r, g, b] = tint;
    Material {
        base_color: [r, g, b, 1.0],
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        double_sided: true,
        ..Material::default()
    }
}

fn light(kind: LightKind) -> Light {
    Light { name: String::new(), kind, intensity: [3.0, 2.0, 1.0] }
}

/// A floor of reflectance 0.5, and panes as large above it, one over the other.
fn floor_under(panes: &[Material], lights: &[Light]) -> Scene {
    let mut scene = Scene { name: "floor under panes".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 20.0, DVec3::NEG_Z * 20.0), lambert([0.5; 3]));
    for (k, material) in panes.iter().enumerate() {
        let up = DVec3::Y * (1.0 + 0.1 * k as f64);
        add(&mut scene, Shape::parallelogram(up, DVec3::X * 20.0, DVec3::NEG_Z * 20.0), material.clone());
    }
    scene.lights = lights.to_vec();
    scene.cameras.push(orthographic(look_at(DVec3::Y * 0.5, DVec3::ZERO, DVec3::NEG_Z), 0.2));
    scene
}

/// Fresnel's reflectance of an index of 1.5.
fn reflectance(cosine: f64) -> f64 {
    let (n, sine2) = (1.5, 1.0 - cosine * cosine);
    let inside = (1.0 - sine2 / (n * n)).sqrt();
    let s = (cosine - n * inside) / (cosine + n * inside);
    let p = (n * cosine - inside) / (n * cosine + inside);
    0.5 * (s * s + p * p)
}

/// Parallel light through one, two and eight panes, straight and slanting, clear and tinted: the
/// floor has the open floor's radiance times the product of transmittances. One bounce is direct
/// light, since passing a pane is no scattering event.
#[test]
fn transmittance() {
    for slant in [0.0f64, 0.8, 1.3] {
        let direction = DVec3::new(slant.sin(), -slant.cos(), 0.0);
        let sun = [light(LightKind::Directional { direction })];
        let through = 1.0 - reflectance(slant.cos());
        for (count, tint) in [(1, [1.0f32; 3]), (2, [0.9, 0.5, 0.2]), (8, [1.0, 0.8, 0.6])] {
            let scene = floor_under(&vec![pane(tint); count], &sun);
            for integrator in [Integrator::Mis, Integrator::Area] {
                let settings = Settings { integrator, max_bounces: Some(1), ..Settings::new(8, 8) };
                let film = render(&scene, &settings, 2, 4);
                for (c, tint) in tint.into_iter().enumerate() {
                    let open = 0.5 / PI * f64::from(sun[0].intensity[c]) * slant.cos();
                    let truth = open * (through * f64::from(tint)).powi(count as i32);
                    for i in all(&film) {
                        let error = film.mean(i)[c] / truth - 1.0;
                        assert!(error.abs() < 2e-5, "{count} panes at {slant} by {integrator:?}: {error:+.1e}");
                    }
                }
            }
        }
    }
}

/// The sunlit room behind a window has 0.96 of the light that it has without the pane, by default:
/// nothing is set but the size.
#[test]
fn a_sunlit_room_behind_a_window() {
    let settings = Settings { integrator: Integrator::Auto, ..Settings::new(32, 32) };
    let mut scene = window::window();
    let prepared = prepare(&scene, &settings);
    println!("{:?}: {:?}", prepared.integrator, prepared.choice);
    assert_eq!(prepared.integrator, Integrator::Mis, "{:?}", prepared.choice);
    assert!(prepared.unreachable.is_empty(), "{:?}", prepared.unreachable);
    // The sun alone has no noise.
    let emissive: Vec<bool> = scene.materials.iter().map(Material::is_emissive).collect();
    let meshes: Vec<usize> = scene.meshes.iter().map(|mesh| mesh.material).collect();
    scene.instances.retain(|i| !emissive[meshes[i.mesh]]);
    let settings = Settings { max_bounces: Some(1), ..settings };
    let behind = render(&scene, &settings, 4, 16);
    let mut open = scene.clone();
    let pane = open.materials.iter().position(|m| m.transmission > 0.0).expect("there is a pane");
    open.instances.retain(|i| scene.meshes[i.mesh].material != pane);
    let open = render(&open, &settings, 4, 16);
    let through = 1.0 - reflectance(window::SUN_COSINE);
    // Pixels that the sun lights evenly, behind the pane and without it.
    let mut lit = 0;
    for i in all(&open) {
        let (a, b) = (behind.mean(i)[0], open.mean(i)[0]);
        if b > 0.05 && open.variance_of_mean(i).expect("four batches")[0] < 1e-12 {
            lit += 1;
            assert!((a / b / through - 1.0).abs() < 1e-4, "pixel {i}: {} instead of {through}", a / b);
        }
    }
    assert!(lit > 40, "the sun lights {lit} pixels");
}

/// A box with a window on one side, of panes of every kind, lit from outside and inside, and viewed
/// through one.
fn conservatory(lamps: usize) -> Scene {
    let mut scene = Scene { name: "conservatory".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert([0.7, 0.6, 0.5]));
    let wall = Shape::parallelogram(DVec3::new(0.0, 1.0, -1.0), DVec3::X * 2.0, DVec3::Y);
    add(&mut scene, wall, lambert([0.4, 0.6, 0.3]));
    let rgba = [255, 255, 255, 255, 40, 200, 220, 255, 230, 90, 60, 255, 120, 120, 40, 255];
    scene.images.push(Image { name: "glass".into(), width: 2, height: 2, rgba: rgba.to_vec() });
    let wrap = Wrap::Repeat;
    scene.textures.push(Texture { image: 0, wrap_s: wrap, wrap_t: wrap, filter: Filter::Linear });
    let texture = TextureRef { texture: 0, uv_set: 0, transform: None };
    let kinds = [
        // Stained glass, a dirty pane of which a part is there, coated velvet glass, and a part
        // that scatters.
        Material { base_color_texture: Some(texture), ..pane([1.0; 3]) },
        Material { base_color: [0.8, 0.9, 1.0, 0.5], alpha_mode: AlphaMode::Blend, ..pane([1.0; 3]) },
        Material {
            clearcoat: Clearcoat { factor: 1.0, roughness: 0.3, ..Clearcoat::default() },
            sheen: Sheen { color: [0.3, 0.2, 0.1], roughness: 0.6, ..Sheen::default() },
            transmission: 0.7,
            ..pane([0.9, 0.9, 0.6])
        },
    ];
    for (k, material) in kinds.into_iter().enumerate() {
        scene.materials.push(material);
        let at = DVec3::new(-0.7 + 0.7 * k as f64, 0.9, 0.1);
        let shape = Shape::parallelogram(at, DVec3::X * 0.33, DVec3::new(0.0, 0.15, 0.3));
        scene.meshes.push(shape.into_mesh("pane", scene.materials.len() - 1, false));
        scene
            .instances
            .push(surelight_scene::Instance { mesh: scene.meshes.len() - 1, to_world: glam::DAffine3::IDENTITY });
    }
    // A curved one in front of the camera.
    let visor = Shape::icosphere(3).placed(0.35, DVec3::new(0.4, 0.4, 0.7));
    scene.materials.push(pane([0.9, 0.8, 0.9]));
    scene.meshes.push(visor.into_mesh("visor", scene.materials.len() - 1, false));
    scene
        .instances
        .push(surelight_scene::Instance { mesh: scene.meshes.len() - 1, to_world: glam::DAffine3::IDENTITY });
    let halves = 0.9 / lamps as f64;
    for k in 0..lamps {
        let x = (2 * k + 1) as f64 * halves - 0.9;
        let lamp = Shape::parallelogram(DVec3::new(x, 2.0, 0.4), DVec3::X * halves, DVec3::Z * 0.6);
        add(&mut scene, lamp, emitter([3.0, 2.5 - k as f32, 2.0]));
    }
    let eye = look_at(DVec3::new(0.5, 1.1, 2.6), DVec3::new(0.0, 0.5, 0.0), DVec3::Y);
    scene.cameras.push(pinhole(eye, 45.0));
    scene
}

fn settings(integrator: Integrator, seed: u32) -> Settings {
    Settings { integrator, seed, ..Settings::new(SIZE, SIZE) }
}

fn compare(name: &str, scene: &Scene, settings: [&Settings; 2], samples: [u32; 2], power: f64) {
    let [a, b] = [0, 1].map(|k| render(scene, settings[k], 16, samples[k]));
    Comparison { power, pictures: PICTURES, pixels: false }.assert_equal(name, &a, &b);
}

/// One lamp, a light tree and a map: light sampling through panes agrees with directions.
#[test]
fn estimators_agree_through_panes() {
    let mut under_a_map = conservatory(1);
    let texel = |x: u32, y: u32| if y < 3 && x % 8 < 4 { [3.0, 2.5, 2.0] } else { [0.3, 0.4, 0.6] };
    under_a_map.environment = Some(map(16, 8, texel));
    for (k, (name, scene)) in
        [("one lamp", conservatory(1)), ("a light tree", conservatory(3)), ("a map", under_a_map)].iter().enumerate()
    {
        let hemisphere = settings(Integrator::Hemisphere(Directions::Bsdf), 10 + k as u32);
        for (method, integrator) in [("mis", Integrator::Mis), ("area", Integrator::Area)] {
            let own = settings(integrator, 20 + k as u32);
            assert!(prepare(scene, &own).key().has(Part::Panes));
            compare(&format!("{name}, {method}"), scene, [&own, &hemisphere], [128, 256], 0.03);
        }
        // Mirrors of the panes are traced from the lights, the rest is not.
        let traced = settings(Integrator::Caustics, 30 + k as u32);
        assert!(prepare(scene, &traced).key().has(Part::Caustics));
        compare(&format!("{name}, caustics"), scene, [&traced, &hemisphere], [128, 256], 0.03);
    }
}

/// Neighbours share paths on either side of panes, and none through them.
#[test]
fn path_reuse_agrees_through_panes() {
    for (name, scene) in [("one lamp", conservatory(1)), ("a light tree", conservatory(3))] {
        for bounces in [None, Some(2)] {
            let of =
                |path_reuse, seed| Settings { path_reuse, max_bounces: bounces, ..settings(Integrator::Mis, seed) };
            let shared = of(PathReuse::On, 40);
            assert!(prepare(&scene, &shared).key().has(Part::PathReuse));
            compare(&format!("{name}, {bounces:?}"), &scene, [&shared, &of(PathReuse::Off, 41)], [128, 128], 0.03);
        }
    }
}

/// A pane within a medium leaves the medium as it is: light has the medium's absorption and the
/// pane's transmittance.
#[test]
fn panes_in_media_bound_none() {
    let tint = Volume { attenuation_distance: 1.0, attenuation_color: [0.5, 0.6, 0.7] };
    let mut scene = Scene { name: "aquarium".into(), ..Scene::default() };
    // Matched in index, so that only absorption is visible.
    let water = Material { ior: 1.000_001, volume: Some(tint), ..pane([1.0; 3]) };
    add(&mut scene, Shape::cuboid(DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 1.0, 1.0)), water);
    let divider = Shape::parallelogram(DVec3::Y * 0.5, DVec3::X * 0.9, DVec3::NEG_Z * 0.9);
    add(&mut scene, divider, pane([1.0; 3]));
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene.cameras.push(orthographic(look_at(DVec3::Y * 3.0, DVec3::ZERO, DVec3::NEG_Z), 0.2));
    let film = render(&scene, &Settings::new(8, 8), 16, 64);
    // Light reflected by the divider has the same way: half a metre there and back.
    for (c, truth) in [0.5, 0.6, 0.7].into_iter().enumerate() {
        let mean = all(&film).map(|i| film.mean(i)[c]).sum::<f64>() / 64.0;
        assert!((mean / truth - 1.0).abs() < 2e-5, "channel {c}: {mean} instead of {truth}");
    }
}
