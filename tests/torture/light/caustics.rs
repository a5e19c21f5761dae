//! Light traced from the lights: closed forms where no path from the camera could find it, and
//! paths from the camera where they can.
//!
//! Particles land on many pixels, whose sums are therefore not independent of one another. Batches
//! are: means over pixels are judged by their spread over batches.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DAffine3, DQuat, DVec3};
use surelight_estimate::{Estimate, detectable_bias, sidak_level, welch_test, z_test};
use surelight_film::{Film, Window};
use surelight_prepare::{Integrator, Part, Settings};
use surelight_render::{Renderer, instrument};
use surelight_scene::{
    AlphaMode, Camera, Clearcoat, ClipRange, Environment, Instance, Light, LightKind, Material, Projection, Scene,
    Volume,
};
use surelight_scenes::shapes::Shape;
use surelight_scenes::torture::light::sds as globe;
use surelight_tests::render::{ALPHA, all, bits, device, prepare};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, orthographic, pinhole};

const SIDE: u32 = 16;

/// Parts of the picture whose means are compared: all of it, and its quarters.
const PARTS: usize = 5;

fn settings(integrator: Integrator, seed: u32) -> Settings {
    Settings { integrator, seed, ..Settings::new(SIDE, SIDE) }
}

/// Means over the parts of the picture, of each channel, from the spread of `batches` batches.
fn means(scene: &Scene, settings: &Settings, batches: u32, samples: u32) -> [[Estimate; 3]; PARTS] {
    let prepared = prepare(scene, settings);
    let traced = settings.integrator == Integrator::Caustics;
    assert_eq!(prepared.key().has(Part::Caustics), traced, "{:?}", prepared.no_caustics);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut sums = [[[0.0f64; 2]; 3]; PARTS];
    for batch in 0..batches {
        let mut film = Film::new(SIDE, SIDE);
        renderer.trace(&mut film, batch, 1, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        for (part, sums) in sums.iter_mut().enumerate() {
            let half = (SIDE / 2) as usize;
            let quarter = |i: usize| 1 + (i % SIDE as usize) / half + 2 * (i / SIDE as usize / half);
            let pixels: Vec<usize> = all(&film).filter(|&i| part == 0 || quarter(i) == part).collect();
            for (channel, sum) in sums.iter_mut().enumerate() {
                let mean = pixels.iter().map(|&i| film.mean(i)[channel]).sum::<f64>() / pixels.len() as f64;
                *sum = [sum[0] + mean, sum[1] + mean * mean];
            }
        }
    }
    let counts = renderer.counts;
    assert_eq!((counts.dropped, counts.truncated), (0, 0), "samples were lost");
    assert_eq!(counts.particles > 0, traced);
    let n = f64::from(batches);
    let estimate = |[sum, squares]: [f64; 2]| {
        let mean = sum / n;
        Estimate { mean, variance: (squares / n - mean * mean).max(0.0) / (n - 1.0), dof: n - 1.0 }
    };
    sums.map(|part| part.map(estimate))
}

/// Holds light that is traced from the lights against light that paths from the camera find by
/// chance: Welch's test of each part of the picture in each channel. `power`: the largest bias of
/// the whole picture that may go unseen 1 time in 10; `of`: comparisons in all.
fn assert_equal(name: &str, scene: &Scene, change: impl Fn(&mut Settings), samples: [u32; 2], power: f64, of: usize) {
    let of_method = |integrator, seed, samples| {
        let mut settings = settings(integrator, seed);
        change(&mut settings);
        means(scene, &settings, 16, samples)
    };
    let traced = of_method(Integrator::Caustics, 1, samples[0]);
    let found = of_method(Integrator::Mis, 2, samples[1]);
    let level = sidak_level(ALPHA, 3 * PARTS * of);
    let mut worst = f64::INFINITY;
    for (part, (a, b)) in traced.iter().zip(&found).enumerate() {
        for c in 0..3 {
            let test = welch_test(&a[c], &b[c]);
            worst = worst.min(test.p);
            if part == 0 {
                let detectable = detectable_bias(test.standard_error, level, 0.9) / b[c].mean;
                println!(
                    "{name}, channel {c}: {:.5} ± {:.1e} traced from the lights, {:.5} ± {:.1e} by chance; {:.2} % would be detected",
                    a[c].mean,
                    a[c].variance.sqrt(),
                    b[c].mean,
                    b[c].variance.sqrt(),
                    100.0 * detectable
                );
                assert!(detectable <= power, "{name}: only a bias of {detectable:.1e} could be detected");
            }
            assert!(
                test.p > level,
                "{name}, part {part}, channel {c}: {} ± {:.1e} traced, {} ± {:.1e} by chance, p = {:.1e}",
                a[c].mean,
                a[c].variance.sqrt(),
                b[c].mean,
                b[c].variance.sqrt(),
                test.p
            );
        }
    }
    println!("{name}: the smallest p of {} is {worst:.3}", 3 * PARTS);
}

/// Holds the mean of a picture against the truth, of one of `of` closed forms.
fn assert_mean(name: &str, scene: &Scene, samples: u32, truth: f64, power: f64, of: usize) {
    let level = sidak_level(ALPHA, of);
    let [whole, ..] = means(scene, &settings(Integrator::Caustics, 7), 32, samples);
    let mean = whole[1];
    let error = mean.variance.sqrt().hypot(1e-6 * truth);
    let test = z_test(mean.mean, error, truth, level);
    println!(
        "{name}: {:.6} ± {error:.1e}, truth {truth:.6}, z {:+.2}; a bias of {:.3} % would be detected",
        mean.mean,
        test.z,
        100.0 * test.detectable / truth
    );
    assert!(
        test.detectable <= power * truth,
        "{name}: only a bias of {:.1e} could be detected",
        test.detectable / truth
    );
    assert!(test.p > level, "{name}: {} ± {error:.1e} instead of {truth}, z = {:.2}", mean.mean, test.z);
}

fn clear() -> Volume {
    Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] }
}

fn glass(volume: Volume) -> Material {
    Material { metallic: 0.0, transmission: 1.0, roughness: 0.0, volume: Some(volume), ..Material::default() }
}

fn lamp(scene: &mut Scene, kind: LightKind, intensity: [f32; 3]) {
    scene.lights.push(Light { name: "bulb".into(), kind, intensity });
}

/// A floor of reflectance ρ at height 0.
fn floor(scene: &mut Scene, reflectance: f32) {
    add(scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 20.0, DVec3::NEG_Z * 20.0), lambert([reflectance; 3]));
}

/// Straight down from a height, on a square of half a side.
fn down(at: DVec3, half: f64) -> Camera {
    let turn = DAffine3::from_quat(DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2));
    orthographic(DAffine3::from_translation(at) * turn, half)
}

/// Mean of a function over a square.
fn mean_over(middle: [f64; 2], half: f64, f: impl Fn(f64, f64) -> f64) -> f64 {
    const GRID: u32 = 64;
    let at = |k: u32| ((f64::from(k) + 0.5) / f64::from(GRID) * 2.0 - 1.0) * half;
    let points = (0..GRID * GRID).map(|k| f(middle[0] + at(k % GRID), middle[1] + at(k / GRID)));
    points.sum::<f64>() / f64::from(GRID * GRID)
}

/// Point and parallel lights, which no path from the camera hits: all light of a point at the
/// centre of a globe leaves along its radii, so that the floor is lit as by the bare point; a
/// mirror forms a point's image; a pane lets (1 − r)²τ / (1 − r²τ²) through (Born & Wolf, section
/// 1.6).
#[test]
fn closed_forms() {
    // A ball of smooth normals about the light, which reflections cross again and again: none is
    // lost.
    let mut scene = Scene::default();
    // The interreflection between floor and globe is 0.05 of some hundredth.
    floor(&mut scene, 0.05);
    place(&mut scene, Shape::icosphere(4).placed(0.4, DVec3::Y), glass(clear()));
    lamp(&mut scene, LightKind::Point { position: DVec3::Y }, [1.0; 3]);
    scene.cameras.push(down(DVec3::new(0.8, 0.5, 0.0), 0.3));
    let lit = mean_over([0.8, 0.0], 0.3, |x, z| 0.05 / PI / (x * x + z * z + 1.0).powf(1.5));
    assert_mean("a point in a globe", &scene, 512, lit, 0.02, 3);

    // A mirror under a point; a screen keeps the direct light off.
    let mut scene = Scene::default();
    let mirror = Material { roughness: 0.0, ..Material::default() };
    add(&mut scene, Shape::parallelogram(DVec3::ZERO, DVec3::X * 2.0, DVec3::NEG_Z * 2.0), mirror);
    let wall = Shape::parallelogram(DVec3::new(0.0, 0.5, -1.0), DVec3::X * 0.15, DVec3::Y * 0.15);
    add(&mut scene, wall, lambert([0.5; 3]));
    let screen = Shape::parallelogram(DVec3::new(0.0, 0.975, -0.3), DVec3::X * 0.5, DVec3::Y * 0.325);
    add(&mut scene, screen, lambert([0.0; 3]));
    lamp(&mut scene, LightKind::Point { position: DVec3::Y }, [10.0; 3]);
    scene.cameras.push(orthographic(DAffine3::from_translation(DVec3::new(0.0, 0.5, -0.5)), 0.1));
    let image = mean_over([0.0, 1.5], 0.1, |x, y| 0.5 / PI * 10.0 / (x * x + y * y + 1.0).powf(1.5));
    assert_mean("a point by a mirror", &scene, 512, image, 0.04, 3);

    // Parallel light at 45° through a tinted pane of 2 cm, three metres up.
    let mut scene = Scene::default();
    floor(&mut scene, 0.01);
    let (half, thick, up) = (1.0, 0.02, 3.0);
    let pane = Shape::cuboid(DVec3::new(-half, up, -half), DVec3::new(half, up + thick, half));
    add(&mut scene, pane, glass(Volume { attenuation_distance: 0.02, attenuation_color: [0.5, 0.6, 0.7] }));
    lamp(&mut scene, LightKind::Directional { direction: DVec3::new(1.0, -1.0, 0.0).normalize() }, [2.0; 3]);
    scene.cameras.push(down(DVec3::new(up, 0.3, 0.0), 0.5));
    let (cosine, n) = (FRAC_PI_4.cos(), 1.5);
    let inside = (1.0 - (1.0 - cosine * cosine) / (n * n)).sqrt();
    let s = (cosine - n * inside) / (cosine + n * inside);
    let p = (n * cosine - inside) / (n * cosine + inside);
    let through = |r: f64| {
        let tau = 0.6f64.powf(1.0 / inside);
        (1.0 - r).powi(2) * tau / (1.0 - r * r * tau * tau)
    };
    // The renderer takes light to be unpolarised at each surface.
    let transmitted = through(0.5 * (s * s + p * p));
    assert_mean("parallel light through a pane", &scene, 256, 0.01 / PI * 2.0 * cosine * transmitted, 0.02, 3);
}

/// Adds a shape with its normals.
fn place(scene: &mut Scene, shape: Shape, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(shape.into_mesh("", scene.materials.len() - 1, false));
    scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world: DAffine3::IDENTITY });
}

/// A floor, a shape of a material half a metre above it, a lamp at the side; the floor and the
/// shape are in the picture.
fn table(shape: Shape, smooth: bool, material: Material) -> Scene {
    let mut scene = Scene::default();
    floor(&mut scene, 0.5);
    place(&mut scene, if smooth { shape } else { shape.bare() }, material);
    let panel = Shape::panel(DVec3::new(-1.0, 1.6, 0.4), DVec3::new(0.0, 0.4, 0.0), 0.5, 0.5);
    add(&mut scene, panel, emitter([3.0, 2.5, 2.0]));
    scene.cameras.push(pinhole(look_at(DVec3::new(0.9, 1.6, 1.6), DVec3::new(0.25, 0.1, 0.0), DVec3::Y), 35.0));
    scene
}

/// A ball of glass on the table.
pub(super) fn table_of_glass() -> Scene {
    table(ball(), true, glass(clear()))
}

/// Compares a scene like those of [`as_by_chance`] with paths that find the light by chance.
pub(super) fn assert_as_by_chance(name: &str, scene: &Scene) {
    assert_equal(name, scene, |_| {}, [256, 512], 0.03, 1);
}

fn ball() -> Shape {
    Shape::icosphere(2).placed(0.3, DVec3::Y * 0.45)
}

/// Against chance, where the lamp is so large that chance finds it: curved glass by shading normals
/// on coarse triangles, with a tint; a coat on glass; plastic and coats whose other lobes scatter;
/// blended cover; dispersion; a lens, parallel rays; a map's sun through a thin pane.
#[test]
fn as_by_chance() {
    const OF: usize = 5;
    let tint = Volume { attenuation_distance: 0.3, attenuation_color: [0.3, 0.6, 0.8] };
    let mut curved = table(ball(), true, glass(tint));
    // Another between it and the lamp: one is in the other's cone.
    place(&mut curved, Shape::icosphere(2).placed(0.12, DVec3::new(-0.6, 1.14, 0.24)), glass(tint));
    assert_equal("tinted glass by shading normals", &curved, |_| {}, [256, 512], 0.02, OF);

    let coat = Clearcoat { factor: 1.0, roughness: 0.0, ..Clearcoat::default() };
    let coated = table(ball(), true, Material { clearcoat: coat.clone(), dispersion: 3.0, ..glass(clear()) });
    let lens = |s: &mut Settings| (s.aperture, s.focus) = (Some(0.2), Some(2.2));
    assert_equal("coated glass that disperses, through a lens", &coated, lens, [256, 512], 0.02, OF);

    // A rough red base under a coat that mirrors 4 % and more: the lobe decides.
    let coat = Clearcoat { factor: 0.8, ..coat };
    let paint = Material {
        base_color: [0.8, 0.1, 0.1, 1.0],
        metallic: 0.5,
        roughness: 0.4,
        clearcoat: coat,
        ..Material::default()
    };
    let mut painted = table(Shape::cuboid(DVec3::new(-0.3, 0.1, -0.3), DVec3::new(0.3, 0.7, 0.3)), false, paint);
    let plastic = Material { metallic: 0.0, roughness: 0.0, base_color: [0.2, 0.7, 0.3, 1.0], ..Material::default() };
    add(&mut painted, Shape::icosphere(2).placed(0.15, DVec3::new(0.6, 0.2, 0.2)), plastic);
    painted.cameras[0] = orthographic(look_at(DVec3::new(0.9, 1.6, 1.6), DVec3::new(0.2, 0.1, 0.0), DVec3::Y), 0.6);
    assert_equal("a coat over paint, and plastic, in parallel rays", &painted, |_| {}, [256, 256], 0.02, OF);

    // Half of a mirror is there.
    let blend = Material {
        base_color: [0.9, 0.7, 0.5, 0.5],
        roughness: 0.0,
        alpha_mode: AlphaMode::Blend,
        ..Material::default()
    };
    let panel = Shape::panel(DVec3::new(0.2, 0.5, -0.5), DVec3::new(0.0, 0.0, 0.5), 0.4, 0.4);
    let mut mirrors = table(panel, true, blend);
    // Shading normals that lean, of the mirror and of the surface that it lights: flux differs from
    // that of flat surfaces.
    for (mesh, lean) in [(0, DVec3::new(-0.3, 0.0, 0.2)), (1, DVec3::new(0.25, 0.15, 0.0))] {
        let mesh = &mut mirrors.meshes[mesh];
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize].as_dvec3());
        let normal = ((b - a).cross(c - a).normalize() + lean).normalize().as_vec3();
        mesh.normals = Some(vec![normal; mesh.positions.len()]);
    }
    assert_equal(
        "a mirror that is half there, and normals that lean",
        &mirrors,
        |s| s.max_bounces = Some(3),
        [256, 256],
        0.02,
        OF,
    );

    // A sun of a few texels in a dim sky, through a thin pane over a box.
    let thin = Material { volume: None, ..glass(clear()) };
    let pane = Shape::parallelogram(DVec3::Y * 0.7, DVec3::X * 0.5, DVec3::NEG_Z * 0.5);
    let mut window = table(pane, false, thin);
    add(&mut window, Shape::cuboid(DVec3::new(-0.1, 0.0, -0.1), DVec3::new(0.1, 0.3, 0.1)), lambert([0.6, 0.5, 0.4]));
    window.environment = Some(sun());
    assert_equal("a map's sun through a pane", &window, |_| {}, [256, 512], 0.02, OF);
}

/// 16 texels of 32 × 16 are bright.
fn sun() -> Environment {
    map(32, 16, |x, y| if (8..12).contains(&x) && (2..6).contains(&y) { [20.0, 18.0, 15.0] } else { [0.2, 0.3, 0.5] })
}

/// Runs, crops, one sequence or several, and parts of a pass are the same picture, bit for bit.
#[test]
fn crops_and_parts_are_the_whole() {
    let scene = globe(None);
    for one_scramble in [false, true] {
        let settings = Settings { one_scramble, ..settings(Integrator::Caustics, 3) };
        let prepared = prepare(&scene, &settings);
        let step = if one_scramble { 8 } else { 1 };
        let trace = |lanes: Option<u32>, window: Window, batches: &[[u32; 2]]| {
            let renderer = match lanes {
                Some(lanes) => instrument::with_lanes(device(), &prepared, lanes),
                None => Renderer::new(device(), &prepared),
            };
            let mut renderer = renderer.unwrap_or_else(|e| panic!("{e}"));
            let mut film = Film::of_window(window);
            for &[first, count] in batches {
                let done = renderer.trace(&mut film, step * first, count, 8, &mut |_| true);
                assert!(done.unwrap_or_else(|e| panic!("{e}")));
            }
            film
        };
        let whole = trace(None, Window::all(SIDE, SIDE), &[[0, 6]]);
        assert!(all(&whole).filter(|&i| whole.mean(i)[1] > 0.0).count() > 20, "the globe lets no light through");
        assert!(bits(&whole) == bits(&trace(None, Window::all(SIDE, SIDE), &[[0, 6]])), "two runs differ");
        assert!(bits(&whole) == bits(&trace(Some(128), Window::all(SIDE, SIDE), &[[4, 2], [0, 4]])), "parts differ");
        let window = Window::crop([SIDE, SIDE], [3, 5, 14, 15]).expect("it lies inside");
        let crop = trace(None, window, &[[0, 6]]);
        for (k, mean) in bits(&crop).into_iter().enumerate() {
            let (x, y) = (3 + k % 11, 5 + k / 11);
            assert_eq!(mean, bits(&whole)[y * SIDE as usize + x], "pixel {x}, {y}");
        }
    }
}

/// Through the globe all light is traced from the lamp, for pixels of few samples and of many:
/// paths from the camera add none.
#[test]
fn adaptive_pixels_are_as_bright() {
    let mut scene = globe(None);
    scene.cameras[0].projection = Projection::Perspective { yfov: 2.4, aspect: None };
    let picture = |adaptive| {
        let settings = Settings { adaptive, integrator: Integrator::Caustics, ..Settings::new(2 * SIDE, 2 * SIDE) };
        let mut renderer = Renderer::new(device(), &prepare(&scene, &settings)).unwrap_or_else(|e| panic!("{e}"));
        assert!(renderer.adapt(Some(64), &mut |_| true).unwrap_or_else(|e| panic!("{e}")));
        let mut film = Film::new(2 * SIDE, 2 * SIDE);
        renderer.trace(&mut film, 0, 4, 8, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        film
    };
    let [plain, adaptive] = [false, true].map(picture);
    let lit = || all(&plain).filter(|&i| plain.mean(i)[1] > 0.0);
    for fewer in [true, false] {
        let differs = |i| adaptive.samples(i) != 32 && (adaptive.samples(i) < 32) == fewer;
        assert!(lit().any(differs), "all have as many");
    }
    for i in lit() {
        let [a, b] =
            [&plain, &adaptive].map(|film| (film.mean(i)[1], film.variance_of_mean(i).expect("four batches")[1]));
        assert!((a.0 - b.0).abs() < 1e-6 * a.0 && (a.1 - b.1).abs() < 1e-5 * a.1, "{a:?} and {b:?} in pixel {i}");
    }
}

/// Particles are visible between the camera's planes alone: a wall before the near plane hides
/// nothing, and the floor ends at the far plane. Visible depths are from 1.7 to 2.6 m.
#[test]
fn between_clipping_planes() {
    const OF: usize = 2;
    for lens in [false, true] {
        let mut scene = table(ball(), true, glass(clear()));
        let camera = &mut scene.cameras[0];
        let (eye, axes) = (camera.to_world.translation, camera.to_world.matrix3);
        camera.clip = ClipRange { near: 1.0, far: 2.2 };
        let screen = Shape::parallelogram(eye - 0.9 * axes.z_axis, axes.x_axis, axes.y_axis);
        add(&mut scene, screen, lambert([0.2, 0.5, 0.8]));
        let cut = prepare(&scene, &settings(Integrator::Caustics, 0)).cut;
        assert!(cut.near && cut.far && !cut.medium, "{cut:?}");
        let through = |s: &mut Settings| (s.aperture, s.focus) = (lens.then_some(0.2), lens.then_some(2.2));
        assert_equal("between clipping planes", &scene, through, [256, 512], 0.03, OF);
    }
}

/// A near plane through a medium puts rays inside, where nothing says by how much light has been
/// absorbed.
#[test]
fn near_planes_through_absorbing_media_trace_nothing() {
    let tint = Volume { attenuation_distance: 0.3, attenuation_color: [0.3, 0.6, 0.8] };
    let mut scene = table(ball(), true, glass(tint));
    let refused = |scene: &Scene| prepare(scene, &settings(Integrator::Caustics, 0)).no_caustics;
    assert_eq!(refused(&scene), None);
    scene.cameras[0].clip.near = 2.0;
    assert!(refused(&scene).is_some_and(|why| why.contains("near plane")));
}
