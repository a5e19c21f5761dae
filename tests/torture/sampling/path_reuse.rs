//! Pixels that use each other's paths see the same picture, with less noise.
//!
//! Their errors are not independent within 2×2 pixels, so that means of pictures over independent
//! seeds are compared.

use glam::{DVec3, Vec3};
use surelight_estimate::{Estimate, detectable_bias, sidak_level, welch_test};
use surelight_film::{Film, Window};
use surelight_prepare::{Part, PathReuse, Settings};
use surelight_render::Renderer;
use surelight_scene::{AlphaMode, ClipRange, Material, Scene};
use surelight_scenes::shapes::Shape;
use surelight_tests::render::{ALPHA, all, device, prepare};
use surelight_tests::scenes::{add, lambert};

use super::forms;

const SIZE: [u32; 2] = [24, 24];

/// Scenes, each compared in three channels.
const SCENES: usize = 10;

/// Means of a channel over each quarter and the whole of a picture.
fn means(film: &Film, channel: usize) -> [f64; 5] {
    let [width, height] = SIZE.map(|n| n as usize);
    let mut sums = [0.0; 5];
    for i in all(film) {
        let quarter = 2 * usize::from(i / width >= height / 2) + usize::from(i % width >= width / 2);
        sums[quarter] += 4.0 * film.mean(i)[channel];
        sums[4] += film.mean(i)[channel];
    }
    sums.map(|sum| sum / (width * height) as f64)
}

/// Pictures of so many seeds.
fn pictures(scene: &Scene, shared: bool, seeds: std::ops::Range<u32>, batches: u32, samples: u32) -> Vec<Film> {
    let settings =
        Settings { path_reuse: if shared { PathReuse::On } else { PathReuse::Off }, ..Settings::new(SIZE[0], SIZE[1]) };
    let repeats = scene.instances.len() > scene.meshes.len();
    let prepared = prepare(scene, &if repeats { forms::instanced(settings) } else { settings });
    assert_eq!((prepared.key().has(Part::PathReuse), prepared.key().has(Part::Instances)), (shared, repeats));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    seeds
        .map(|seed| {
            renderer.set_seed(seed);
            let mut film = Film::new(SIZE[0], SIZE[1]);
            renderer.trace(&mut film, 0, batches, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "samples were lost");
            film
        })
        .collect()
}

fn estimate(values: impl Iterator<Item = f64> + Clone) -> Estimate {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let squares: f64 = values.map(|x| (x - mean).powi(2)).sum();
    Estimate { mean, variance: squares / (n * (n - 1.0)), dof: n - 1.0 }
}

/// Relative variance over pictures, of the median pixel: edges and lamps, where nothing is shared,
/// have most of the sum.
fn relative_variance(pictures: &[Film]) -> f64 {
    let of = |i| {
        let pixel = estimate(pictures.iter().map(|film| film.mean(i)[1]));
        pixel.variance / (pixel.mean * pixel.mean).max(1e-12)
    };
    let mut relative: Vec<f64> = all(&pictures[0]).map(of).collect();
    relative.sort_by(f64::total_cmp);
    relative[relative.len() / 2]
}

/// Means are the same; the variance is less than `ratio` of that without path reuse.
fn check(scene: &Scene, samples: u32, power: f64, ratio: f64) {
    const SEEDS: u32 = 32;
    let apart = pictures(scene, false, 0..SEEDS, 2, samples);
    let joint = pictures(scene, true, SEEDS..2 * SEEDS, 2, samples);
    let level = sidak_level(ALPHA, 15 * SCENES);
    for channel in 0..3 {
        for part in 0..5 {
            let of = |films: &[Film]| estimate(films.iter().map(|film| means(film, channel)[part]));
            let (a, b) = (of(&apart), of(&joint));
            let test = welch_test(&b, &a);
            let detectable = detectable_bias(test.standard_error, level, 0.9) / a.mean;
            let relative = test.difference / a.mean;
            assert!(
                test.p > level,
                "{}, channel {channel}, part {part}: off by {relative:+.1e}, p {:.1e}",
                scene.name,
                test.p
            );
            if part == 4 {
                println!(
                    "{}, channel {channel}: off by {relative:+.1e}, p {:.2}, {detectable:.1e} would be detected",
                    scene.name, test.p
                );
                assert!(detectable < power, "{}: only {detectable:.1e} would be detected", scene.name);
            }
        }
    }
    let found = relative_variance(&joint) / relative_variance(&apart);
    println!("{}: variance {found:.3} of that without path reuse", scene.name);
    assert!(found < ratio, "{}: variance {found} of that without path reuse", scene.name);
}

#[test]
fn neighbours_agree_about_diffuse_walls() {
    check(&surelight_scenes::cornell_box::cornell_box(), 32, 0.01, 0.5);
}

#[test]
fn neighbours_agree_about_gloss() {
    check(&forms::lamp(), 16, 0.01, 0.95);
}

/// A wall before the near plane hides nothing; half of the box lies beyond the far plane, and
/// lights the rest.
#[test]
fn neighbours_agree_about_what_a_near_plane_leaves() {
    let mut scene = surelight_scenes::cornell_box::cornell_box();
    scene.name = "cut".into();
    let (low, high) = scene.bounds().expect("it has walls");
    let camera = &mut scene.cameras[0];
    let (eye, backward) = (camera.to_world.translation, camera.to_world.matrix3.z_axis);
    camera.clip = ClipRange { near: 0.02, far: backward.dot(eye - (low + high) / 2.0) };
    let [right, up] = [camera.to_world.matrix3.x_axis, camera.to_world.matrix3.y_axis].map(|axis| axis * 0.1);
    add(&mut scene, Shape::parallelogram(eye - 0.01 * backward, right, up), lambert([0.5; 3]));
    assert!(prepare(&scene, &Settings::new(8, 8)).key().has(Part::CameraClip));
    check(&scene, 32, 0.02, 0.6);
}

#[test]
fn neighbours_agree_about_glass() {
    check(&forms::glass_balls(), 16, 0.01, 1.1);
}

#[test]
fn neighbours_agree_about_layers() {
    check(&forms::layers(), 16, 0.02, 0.95);
}

#[test]
fn neighbours_agree_about_smooth_coats() {
    check(&forms::smooth_coats(), 16, 0.02, 0.95);
}

#[test]
fn neighbours_agree_under_lanterns() {
    check(&forms::lanterns(), 16, 0.02, 0.95);
}

#[test]
fn neighbours_agree_under_a_map() {
    check(&forms::sky_map(), 16, 0.01, 0.95);
}

/// Sheets that are there by chance.
fn veils() -> Scene {
    let mut scene = forms::lamp();
    scene.name = "veils".into();
    let veil = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: [0.8, 0.3, 0.3, 0.5],
        double_sided: true,
        metallic: 0.0,
        roughness: 1.0,
        ..Material::default()
    };
    for x in [-0.7, 0.0, 0.7] {
        let sheet = Shape::parallelogram(DVec3::new(x, 0.4, 0.2), DVec3::new(0.1, 0.0, 0.6), DVec3::Y * 0.4);
        add(&mut scene, sheet, veil.clone());
    }
    scene
}

/// Stochastic coverage must be the same for all rays that hit a point.
#[test]
fn neighbours_agree_about_veils() {
    check(&veils(), 16, 0.02, 0.95);
}

/// However one sequence is cut into passes, and chance about veils with it.
#[test]
fn slices_have_the_bits_of_the_whole() {
    let settings = Settings { path_reuse: PathReuse::On, one_scramble: true, ..Settings::new(SIZE[0], SIZE[1]) };
    let prepared = prepare(&veils(), &settings);
    assert!(prepared.key().has(Part::Alpha) && prepared.key().has(Part::PathReuse));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = |passes: &[(u32, u32)]| {
        let mut film = Film::new(SIZE[0], SIZE[1]);
        for &(first, batches) in passes {
            renderer.trace(&mut film, first, batches, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        }
        all(&film).map(|i| film.mean(i)).collect::<Vec<_>>()
    };
    assert_eq!(film(&[(0, 4)]), film(&[(0, 1), (4, 2), (12, 1)]));
}

/// Shading normals that lean by some 20° from those of the balls.
#[test]
fn neighbours_agree_about_leaning_normals() {
    let mut scene = forms::lamp();
    scene.name = "leaning normals".into();
    for normal in scene.meshes.iter_mut().filter_map(|mesh| mesh.normals.as_mut()).flatten() {
        *normal = (*normal + 0.35 * Vec3::new(normal.y, normal.z, normal.x)).normalize();
    }
    assert!(prepare(&scene, &Settings::new(8, 8)).key().has(Part::VertexNormals));
    check(&scene, 16, 0.02, 0.95);
}

/// Squares lie on a grid from the image's corner, so that a crop with odd sides has the whole
/// picture's pixels, bit for bit.
#[test]
fn crops_have_the_pixels_of_the_whole() {
    let settings = Settings { path_reuse: PathReuse::On, ..Settings::new(37, 21) };
    let prepared = prepare(&forms::lamp(), &settings);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut whole = Film::new(37, 21);
    renderer.trace(&mut whole, 0, 2, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    let (corner, size) = ([5, 3], [19, 11]);
    let mut crop = Film::of_window(Window { whole: [37, 21], corner, size });
    renderer.trace(&mut crop, 0, 2, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    for i in all(&crop) {
        let (x, y) = (i % size[0] as usize + corner[0] as usize, i / size[0] as usize + corner[1] as usize);
        assert_eq!(crop.mean(i), whole.mean(y * 37 + x), "pixel {x}, {y}");
    }
    assert!(all(&whole).all(|i| whole.samples(i) == 8));
}
