//! Volumes with alpha: an object is hit or skipped as a whole by a path. In a white furnace that
//! gives 1, exactly.

use glam::{DAffine3, DMat3, DVec3, Vec2};
use surelight_accel::Instancing;
use surelight_prepare::{Directions, Integrator, Part, Settings};
use surelight_scene::{
    AlphaMode, Environment, Filter, Image, Instance, Material, Scene, Texture, TextureRef, Volume, Wrap,
};
use surelight_scenes::shapes::Shape;
use surelight_tests::render::{all, prepare, render};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, pinhole};
use surelight_tests::welch::Comparison;

const CLEAR: Volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };

fn glass(alpha: f32, alpha_mode: AlphaMode, roughness: f32) -> Material {
    Material {
        base_color: [1.0, 1.0, 1.0, alpha],
        alpha_mode,
        metallic: 0.0,
        roughness,
        transmission: 1.0,
        volume: Some(CLEAR),
        ..Material::default()
    }
}

/// Alpha in stripes: there, half there, and not.
fn stripes(scene: &mut Scene) -> TextureRef {
    let rgba = [255u8, 128, 0, 255].iter().flat_map(|&a| [255, 255, 255, a]).collect();
    scene.images.push(Image { name: "stripes".into(), width: 4, height: 1, rgba });
    let (wrap, filter) = (Wrap::Repeat, Filter::Nearest);
    scene.textures.push(Texture { image: scene.images.len() - 1, wrap_s: wrap, wrap_t: wrap, filter });
    TextureRef { texture: scene.textures.len() - 1, uv_set: 0, transform: None }
}

fn furnace() -> Scene {
    Scene {
        name: "alpha volumes".into(),
        environment: Some(Environment::Uniform([1.0; 3])),
        cameras: vec![pinhole(look_at(DVec3::new(1.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y), 30.0)],
        ..Scene::default()
    }
}

/// Blended glass, a mask with holes, one within another, mirrored instances: never above 1, and
/// never below.
#[test]
fn alpha_volumes_in_a_furnace() {
    let cube = || Shape::cuboid(DVec3::splat(-0.7), DVec3::splat(0.7));
    let mut scenes = Vec::new();
    for (alpha, mode) in [(0.5, AlphaMode::Blend), (0.0, AlphaMode::Blend), (1.0, AlphaMode::Blend)] {
        let mut scene = furnace();
        add(&mut scene, cube(), glass(alpha, mode, 0.0));
        scenes.push((format!("{mode:?} {alpha}"), scene));
    }
    for mode in [AlphaMode::Blend, AlphaMode::Mask(0.4)] {
        let mut scene = furnace();
        let texture = stripes(&mut scene);
        scene.materials.push(Material { base_color_texture: Some(texture), ..glass(1.0, mode, 0.0) });
        let mut mesh = cube().into_mesh("striped", 0, false);
        mesh.uvs = vec![mesh.positions.iter().map(|p| Vec2::new(1.3 * p.x + 0.7 * p.y, 0.9 * p.z + 0.4)).collect()];
        scene.meshes.push(mesh);
        // Mirrored, for whom front and back must not change places.
        let matrix3 = DMat3::from_diagonal(DVec3::new(-1.0, 0.8, 1.1));
        scene.instances.push(Instance { mesh: 0, to_world: DAffine3 { matrix3, translation: DVec3::ZERO } });
        scenes.push((format!("{mode:?} in stripes"), scene.clone()));
        // Another inside: media have ranks then.
        add(&mut scene, Shape::cuboid(DVec3::splat(-0.3), DVec3::splat(0.3)), glass(0.6, AlphaMode::Blend, 0.0));
        scenes.push((format!("{mode:?} in stripes around another"), scene));
    }
    for (name, scene) in &scenes {
        for instancing in [Instancing::Never, Instancing::Always] {
            let mut settings = Settings::new(24, 24);
            settings.build.instancing = instancing;
            let prepared = prepare(scene, &settings);
            assert!(prepared.key().has(Part::VolumeAlpha), "{name}");
            let film = render(scene, &settings, 4, 16);
            for i in all(&film) {
                let error = film.mean(i).map(|c| (c - 1.0).abs()).into_iter().fold(0.0, f64::max);
                assert!(error < 2e-5, "{name}, {instancing:?}: pixel {i} is {:?}", film.mean(i));
            }
        }
    }
}

/// A ball of rough glass with alpha on a floor: light sampling agrees with directions, inside and
/// out.
#[test]
fn estimators_agree_about_alpha_volumes() {
    let tint = Volume { attenuation_distance: 0.4, attenuation_color: [0.4, 0.7, 0.9] };
    let mut scene = Scene { name: "alpha volumes".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert([0.7, 0.6, 0.5]));
    let ball = Shape::icosphere(2).placed(0.45, DVec3::new(0.0, 0.5, 0.0));
    add(&mut scene, ball, Material { volume: Some(tint), ..glass(0.6, AlphaMode::Blend, 0.6) });
    // Something inside, which is there though the ball may not be.
    add(&mut scene, Shape::icosphere(1).placed(0.2, DVec3::new(0.05, 0.5, 0.0)), lambert([0.8, 0.3, 0.2]));
    add(&mut scene, Shape::parallelogram(DVec3::new(0.0, 2.2, 0.3), DVec3::X * 0.9, DVec3::Z * 0.9), emitter([4.0; 3]));
    scene.cameras.push(pinhole(look_at(DVec3::new(0.0, 1.3, 3.0), DVec3::new(0.0, 0.4, 0.0), DVec3::Y), 35.0));
    let of = |integrator, seed| Settings { integrator, seed, ..Settings::new(24, 24) };
    let reference = render(&scene, &of(Integrator::Hemisphere(Directions::Bsdf), 1), 16, 256);
    for (seed, integrator) in [(2, Integrator::Mis), (3, Integrator::Area)] {
        let film = render(&scene, &of(integrator, seed), 16, 128);
        let comparison = Comparison { power: 0.03, pictures: 2, pixels: false };
        comparison.assert_equal(&format!("{integrator:?}"), &film, &reference);
    }
}

/// A tub of tinted rough glass without a lid, under a map: light between the medium and the sky is
/// attenuated equally for directions and for light sampling.
#[test]
fn estimators_agree_about_open_media() {
    let tint = Volume { attenuation_distance: 1.0, attenuation_color: [0.4, 0.7, 1.0] };
    let mut scene = Scene { name: "a tub".into(), ..Scene::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), lambert([0.7, 0.6, 0.5]));
    let tub = Shape::cuboid(DVec3::new(-0.8, 0.1, -0.8), DVec3::new(0.8, 0.7, 0.8));
    add(&mut scene, tub, Material { volume: Some(tint), ..glass(1.0, AlphaMode::Opaque, 0.5) });
    let mesh = scene.meshes.last_mut().expect("the tub");
    let positions = mesh.positions.clone();
    mesh.triangles.retain(|t| t.iter().any(|&i| positions[i as usize].y < 0.5));
    // Something in the medium that scatters.
    add(&mut scene, Shape::icosphere(2).placed(0.2, DVec3::new(0.0, 0.4, 0.0)), lambert([0.8; 3]));
    scene.environment = Some(map(16, 8, |x, y| if x < 8 && y < 4 { [3.0, 2.5, 2.0] } else { [0.2, 0.3, 0.5] }));
    scene.cameras.push(pinhole(look_at(DVec3::new(0.0, 1.6, 3.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y), 35.0));
    let of = |integrator, seed| Settings { integrator, seed, ..Settings::new(24, 24) };
    let reference = render(&scene, &of(Integrator::Hemisphere(Directions::Bsdf), 1), 16, 256);
    for (seed, integrator) in [(2, Integrator::Mis), (3, Integrator::Area)] {
        let film = render(&scene, &of(integrator, seed), 16, 128);
        let comparison = Comparison { power: 0.03, pictures: 2, pixels: false };
        comparison.assert_equal(&format!("{integrator:?}"), &film, &reference);
    }
}
