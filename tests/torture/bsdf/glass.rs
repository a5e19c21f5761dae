//! Smooth glass in closed form: slabs with all their internal reflections, absorption, bodies in a
//! uniform sky, and mirrors.

use glam::DVec3;
use surelight_prepare::Settings;
use surelight_scene::{Environment, LoadOptions, Material, Scene, Volume, load_bytes};
use surelight_scenes::{glb, probes, shapes::Shape};
use surelight_tests::render::{Judge, all, render};
use surelight_tests::scenes::{add, look_at, pinhole};

/// Transmittance (red), reflectance (green) and their sum (blue) of slabs, clear and tinted: R =
/// 2r/(1 + r) for the clear ones.
#[test]
fn slab() {
    for (ior, absorption) in [(1.5f32, 1.0f32), (2.4, 1.0), (1.33, 1.0), (1.5, 0.5), (1.5, 0.05)] {
        let (t, r) = probes::slab_answer(f64::from(ior), f64::from(absorption));
        if absorption == 1.0 {
            let face = ((f64::from(ior) - 1.0) / (f64::from(ior) + 1.0)).powi(2);
            assert!((r - 2.0 * face / (1.0 + face)).abs() < 1e-12 && (t + r - 1.0).abs() < 1e-12);
        }
        let film = render(&probes::slab(ior, 0.7, absorption), &Settings::new(32, 32), 16, 32);
        Judge::of(5, 0.03).mean(&format!("slab of index {ior}, absorption {absorption}"), &film, [t, r, t + r]);
    }
}

fn glass(volume: Volume) -> Material {
    Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, volume: Some(volume), ..Material::default() }
}

const CLEAR: Volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };

fn in_white_sky(shape: Shape, material: Material, yfov: f64) -> Scene {
    let mut scene = Scene { name: "glass furnace".into(), ..Scene::default() };
    add(&mut scene, shape, material);
    scene.cameras = vec![pinhole(look_at(DVec3::new(1.0, 2.0, 4.0), DVec3::ZERO, DVec3::Y), yfov)];
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// Clear glass in a uniform sky is invisible: all light that enters leaves, and radiance is
/// unchanged outside.
#[test]
fn clear_bodies_are_invisible() {
    let bodies = [
        // Not its rim: light that enters a faceted ball there may go round inside for long, by
        // total reflection.
        ("ball", Shape::icosphere(4).faceted(), 12.5),
        ("cube", Shape::cuboid(DVec3::splat(-0.7), DVec3::splat(0.7)), 30.0),
        ("lens", Shape::lens(1.5, 0.9, 6, 24).faceted(), 30.0),
    ];
    for (name, shape, yfov) in bodies {
        let film = render(&in_white_sky(shape, glass(CLEAR), yfov), &Settings::new(32, 32), 16, 16);
        Judge::of(4, 0.006).mean(&format!("glass {name}"), &film, [1.0; 3]);
    }
    // Colours that part come together again.
    let prism = Material { dispersion: 2.0, ..glass(CLEAR) };
    let cube = Shape::cuboid(DVec3::splat(-0.7), DVec3::splat(0.7));
    let film = render(&in_white_sky(cube, prism, 30.0), &Settings::new(32, 32), 16, 64);
    Judge::of(4, 0.012).mean("dispersive cube", &film, [1.0; 3]);
}

/// Open meshes have no inside: a file's sheets and bowls of clear glass are thin walls, which a
/// furnace does not show from either side. (As boundaries of a medium they are 0.47 and 2.2.) Every
/// sample is 1.
#[test]
fn open_volumes_are_thin_walls() {
    let sheet = Shape::parallelogram(DVec3::ZERO, DVec3::X, DVec3::Y).placed(1.0, DVec3::new(1.0, 2.0, 4.0) * 0.1);
    let mut bowl = Shape::icosphere(3).faceted();
    let z = |triangle: &[u32; 3]| triangle.iter().map(|&v| bowl.positions[v as usize].z).sum::<f64>();
    bowl.triangles = bowl.triangles.iter().filter(|triangle| z(triangle) > 0.0).copied().collect();
    let shapes = [sheet.clone(), sheet.turned_over(), bowl.clone(), bowl.turned_over()];
    for (i, shape) in shapes.into_iter().enumerate() {
        let made = in_white_sky(shape, glass(CLEAR), 30.0);
        let file = glb::encode(&made, "").expect("writes");
        let read = load_bytes(&file, "open.glb".as_ref(), &LoadOptions::default()).expect("loads");
        assert!(read.warnings.len() == 1 && read.warnings[0].contains("not closed"), "{:?}", read.warnings);
        let film = render(&Scene { environment: made.environment, ..read }, &Settings::new(32, 32), 1, 16);
        for pixel in all(&film) {
            let mean = film.mean(pixel);
            assert!(mean.iter().all(|c| (c - 1.0).abs() < 1e-5), "shape {i}: pixel {pixel} is {mean:?}");
        }
    }
}

/// A path through a block of matched index is straight: e^(−σd) and nothing else.
#[test]
fn absorption_is_exponential() {
    let volume = Volume { attenuation_distance: 0.8, attenuation_color: [0.9, 0.5, 0.1] };
    // An index next to 1 reflects 2.5e-13; exactly 1 would be the same surface without a lobe.
    let material = Material { ior: 1.000_001, ..glass(volume) };
    for thickness in [0.1, 1.0, 2.5] {
        let mut scene = probes::slab(1.5, thickness, 1.0);
        let slab = scene.meshes[0].material;
        scene.materials[slab] = Material { name: "slab".into(), ..material.clone() };
        let exact =
            volume.attenuation_color.map(|c| f64::from(c).powf(thickness / f64::from(volume.attenuation_distance)));
        // Both lamps white, so that all channels see the one behind.
        for lamp in 0..scene.materials.len() {
            if scene.materials[lamp].is_emissive() {
                scene.materials[lamp].emissive = [1.0; 3];
            }
        }
        let film = render(&scene, &Settings::new(16, 16), 4, 4);
        for i in all(&film) {
            for (value, exact) in film.mean(i).into_iter().zip(exact) {
                let error = (value / exact - 1.0).abs();
                assert!(error < 2e-5, "pixel {i} at {thickness} m: {value} instead of {exact}");
            }
        }
    }
}

/// Transmittance and reflectance of a stack of interfaces, incoherently: each adds to those before
/// it.
fn stack(layers: &[(f64, f64)]) -> (f64, f64) {
    // Of the stack so far: transmittance, reflectance from the front and from the back.
    let (mut t, mut front, mut back) = (1.0, 0.0, 0.0);
    let mut before: f64 = 1.0;
    for &(ior, through) in layers.iter().chain(&[(1.0, 1.0)]) {
        let r = ((ior - before) / (ior + before)).powi(2);
        let series = 1.0 / (1.0 - back * r);
        front += t * t * r * series;
        back = r + (1.0 - r) * (1.0 - r) * back * series;
        t *= (1.0 - r) * series;
        // Then through the layer.
        t *= through;
        back *= through * through;
        before = ior;
    }
    (t, front)
}

fn volume(ior: f32, per_metre: f32) -> Material {
    let distance = if per_metre < 1.0 { 1.0 } else { f32::INFINITY };
    Material { ior, ..glass(Volume { attenuation_distance: distance, attenuation_color: [per_metre; 3] }) }
}

/// The lamps of a slab's scene, with these blocks between them: from and to in z, and a material
/// each. Half-widths fall, so that the later block is the smaller.
fn blocks(all: &[(f64, f64, Material)]) -> Scene {
    let mut scene = probes::slab(1.5, 1.0, 1.0);
    scene.instances.remove(0);
    for (k, (from, to, material)) in all.iter().enumerate() {
        let half = 60.0 - 5.0 * k as f64;
        add(&mut scene, Shape::cuboid(DVec3::new(-half, -half, *from), DVec3::new(half, half, *to)), material.clone());
    }
    scene
}

/// Volumes within volumes, overlapping, and of one medium, by closed form; rays come from z = 2
/// downwards.
#[test]
fn nested_volumes() {
    let (water, ice) = (volume(1.33, 0.8), volume(1.8, 0.6));
    let same = volume(1.5, 0.7);
    let power = |base: f64, length: f64| base.powf(length);
    let cases = [
        // Ice wholly inside water: four interfaces, two of them against water.
        (
            "ice in water",
            blocks(&[(-1.0, 1.0, water.clone()), (-0.3, 0.2, ice.clone())]),
            stack(&[(1.33, power(0.8, 0.8)), (1.8, power(0.6, 0.5)), (1.33, power(0.8, 0.7))]),
        ),
        // Ice that sticks out of the water below: where both are, it is ice.
        (
            "overlapping",
            blocks(&[(-0.5, 1.0, water), (-1.0, 0.2, ice)]),
            stack(&[(1.33, power(0.8, 0.8)), (1.8, power(0.6, 1.2))]),
        ),
        // Two blocks of one material are one block.
        (
            "joined",
            {
                let mut scene = blocks(&[(-0.5, 1.0, same.clone()), (-1.0, 0.2, same)]);
                let first = scene.meshes[scene.instances[scene.instances.len() - 2].mesh].material;
                let last = scene.instances.last().expect("two blocks").mesh;
                scene.meshes[last].material = first;
                scene
            },
            stack(&[(1.5, power(0.7, 2.0))]),
        ),
        // Air in glass: an index of 1 within one of 1.5.
        (
            "bubble",
            blocks(&[(-1.0, 1.0, volume(1.5, 1.0)), (-0.3, 0.2, volume(1.0, 1.0))]),
            stack(&[(1.5, 1.0), (1.0, 1.0), (1.5, 1.0)]),
        ),
    ];
    let count = cases.len();
    for (name, scene, (t, r)) in cases {
        let film = render(&scene, &Settings::new(32, 32), 16, 32);
        Judge::of(count, 0.05).mean(name, &film, [t, r, t + r]);
    }
}

/// An index of 1, none at all and attenuation at both ends of f32: no sample is lost (`render`
/// would fail), and the result is light or darkness.
#[test]
fn extreme_media_stay_finite() {
    let film = |distance: f32, color: [f32; 3], ior: f32| {
        let material = Material { ior, ..glass(Volume { attenuation_distance: distance, attenuation_color: color }) };
        let block = blocks(&[(-1.0, 1.0, material.clone()), (-0.5, 0.5, material)]);
        render(&block, &Settings::new(8, 8), 4, 8)
    };
    for ior in [1.0, 1.000_001, 1.5, 1e6] {
        let dark = film(f32::MIN_POSITIVE, [0.0; 3], ior);
        assert!(all(&dark).all(|i| dark.mean(i)[0] == 0.0), "light comes through black at index {ior}");
        let clear = film(f32::MAX, [0.0; 3], ior);
        let exact = 1.0 - ((f64::from(ior) - 1.0) / (f64::from(ior) + 1.0)).powi(2);
        let mean = all(&clear).map(|i| clear.mean(i)[2]).sum::<f64>() / 64.0;
        assert!((mean - 1.0).abs() < 0.05 || exact < 0.01, "{mean} at index {ior}");
    }
}

/// The whole faceted ball, rim included, where light goes round inside for long by total
/// reflection: 1.000 at unbounded depth.
#[test]
fn glass_sphere_furnace() {
    let scene = surelight_scenes::torture::scene("glass-sphere-furnace");
    let film = render(&scene, &Settings { seed: 30, ..Settings::new(48, 48) }, 16, 64);
    Judge::new(0.01).mean("the whole glass ball", &film, [1.0; 3]);
}
