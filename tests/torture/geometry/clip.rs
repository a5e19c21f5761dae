//! Clipping planes of cameras (glTF 2.0, section 3.10.3): surfaces nearer than the near plane or
//! beyond the far plane are not shown.
//!
//! Surfaces are unlit, so that pictures have no variance. Scenes go through files, so that the
//! planes are those that were read.

use std::path::Path;

use glam::{DAffine3, DVec3};
use surelight_film::Film;
use surelight_prepare::{ActiveClipPlanes, Part, Prepared, Settings};
use surelight_render::Renderer;
use surelight_scene::{Camera, ClipRange, Environment, LoadOptions, Material, Scene, load_bytes};
use surelight_scenes::{glb, shapes::Shape};
use surelight_tests::render::{all, bits, device, prepare, trace};
use surelight_tests::scenes::{add, orthographic, pinhole};

const SIDE: u32 = 32;
const RED: [f64; 3] = [1.0, 0.0, 0.0];
const GREEN: [f64; 3] = [0.0, 1.0, 0.0];
const SKY: [f64; 3] = [0.0, 0.0, 1.0];

fn unlit(color: [f64; 3]) -> Material {
    let [r, g, b] = color.map(|c| c as f32);
    Material { unlit: true, base_color: [r, g, b, 1.0], double_sided: true, ..Material::default() }
}

/// Adds a wall across the view at this depth, from `left` to `right` of the axis.
fn wall(scene: &mut Scene, depth: f64, [left, right]: [f64; 2], color: [f64; 3]) {
    let center = DVec3::new(0.5 * (left + right), 0.0, -depth);
    add(scene, Shape::parallelogram(center, DVec3::X * 0.5 * (right - left), DVec3::Y * 20.0), unlit(color));
}

const EVERYWHERE: [f64; 2] = [-20.0, 20.0];

/// A camera at the origin along −Z, with a right angle of view or 4 m wide.
fn camera(is_orthographic: bool, near: f64, far: f64) -> Camera {
    let place = DAffine3::IDENTITY;
    let camera = if is_orthographic { orthographic(place, 2.0) } else { pinhole(place, 90.0) };
    Camera { clip: ClipRange { near, far }, ..camera }
}

/// The scene as it is read from its file, under a blue sky.
fn through_file(mut scene: Scene, camera: Camera) -> Scene {
    scene.cameras = vec![camera];
    let bytes = glb::encode(&scene, "").unwrap_or_else(|e| panic!("{e}"));
    let mut read = load_bytes(&bytes, Path::new("clip.glb"), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read.warnings, Vec::<String>::new());
    read.environment = Some(Environment::Uniform(SKY.map(|c| c as f32)));
    read
}

fn settings() -> Settings {
    Settings::new(SIDE, SIDE)
}

/// The picture, whose kernel contains the planes if they clip something.
fn picture(scene: &Scene, settings: &Settings, cut: ActiveClipPlanes) -> Film {
    let prepared = prepare(scene, settings);
    assert_eq!(prepared.cut, cut);
    assert_eq!(prepared.key().has(Part::CameraClip), cut.any());
    trace(&prepared, [SIDE; 2], 2, 8)
}

/// Every pixel has the `color` of its column and row.
fn assert_shows(film: &Film, color: impl Fn(usize, usize) -> [f64; 3]) {
    for i in all(film) {
        let (x, y) = (i % SIDE as usize, i / SIDE as usize);
        assert_eq!(film.mean(i), color(x, y), "pixel {x}, {y}");
    }
}

const NEAR: ActiveClipPlanes = ActiveClipPlanes { near: true, far: false, medium: false };
const FAR: ActiveClipPlanes = ActiveClipPlanes { near: false, far: true, medium: false };

/// Red is before the near plane, green just behind it. A sphere of its radius would leave red in
/// the corners.
fn near_plane(is_orthographic: bool) {
    let mut scene = Scene::default();
    wall(&mut scene, 1.9, EVERYWHERE, RED);
    wall(&mut scene, 2.1, EVERYWHERE, GREEN);
    let clipped = through_file(scene.clone(), camera(is_orthographic, 2.0, 64.0));
    assert_shows(&picture(&clipped, &settings(), NEAR), |_, _| GREEN);
    let whole = through_file(scene, camera(is_orthographic, 1.0, 64.0));
    assert_shows(&picture(&whole, &settings(), ActiveClipPlanes::default()), |_, _| RED);
}

#[test]
fn near_plane_perspective() {
    near_plane(false);
}

#[test]
fn near_plane_orthographic() {
    near_plane(true);
}

/// The left half is before the far plane, the right half beyond it, where the sky shows. A sphere
/// of the plane's distance would take the left wall's corners, too.
#[test]
fn far_plane() {
    for is_orthographic in [false, true] {
        let mut scene = Scene::default();
        wall(&mut scene, 2.9, [-20.0, 0.0], GREEN);
        wall(&mut scene, 3.1, [0.0, 20.0], RED);
        let scene = through_file(scene, camera(is_orthographic, 0.5, 3.0));
        let half = SIDE as usize / 2;
        assert_shows(&picture(&scene, &settings(), FAR), |x, _| if x < half { GREEN } else { SKY });
    }
}

/// A wall that leans through the near plane is cut along a straight line, where it should be.
#[test]
fn leaning_wall() {
    // Through (0, y, −2 − y/2): its depth is that of the plane at y = 0.5.
    let (near, edge) = (2.25, 0.5);
    for is_orthographic in [false, true] {
        let mut scene = Scene::default();
        let across = DVec3::new(0.0, 1.0, -0.5) * 20.0;
        add(&mut scene, Shape::parallelogram(DVec3::Z * -2.0, DVec3::X * 20.0, across), unlit(GREEN));
        let scene = through_file(scene, camera(is_orthographic, near, 64.0));
        let cut = picture(&scene, &settings(), NEAR);
        let height = if is_orthographic { edge / 2.0 } else { edge / near };
        // Rows count from the top; the row with the edge shows both.
        let row = 0.5 * (1.0 - height) * f64::from(SIDE);
        for i in all(&cut) {
            let y = (i / SIDE as usize) as f64;
            let [red, green, blue] = cut.mean(i);
            let expected = (row - y).clamp(0.0, 1.0);
            let tolerance = if expected == 0.0 || expected == 1.0 { 0.0 } else { 0.25 };
            assert!((green - expected).abs() <= tolerance, "row {y}: {green} instead of {expected}");
            assert!(red == 0.0 && (green + blue - 1.0).abs() < 1e-6);
        }
    }
}

/// Depths are measured from the camera, wherever the planes are.
#[test]
fn depth_counts_from_the_camera() {
    for is_orthographic in [false, true] {
        let mut scene = Scene::default();
        wall(&mut scene, 1.0, EVERYWHERE, RED);
        wall(&mut scene, 3.0, [-20.0, 0.0], GREEN);
        wall(&mut scene, 9.0, [0.0, 20.0], RED);
        let scene = through_file(scene, camera(is_orthographic, 2.0, 8.0));
        let prepared = prepare(&scene, &settings());
        assert_eq!(prepared.cut, ActiveClipPlanes { near: true, far: true, medium: false });
        let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
        let mut film = Film::new(SIDE, SIDE);
        renderer.trace_features(&mut film).unwrap_or_else(|e| panic!("{e}"));
        let depth = &film.features().expect("they were traced").depth;
        for (i, &found) in depth.iter().enumerate() {
            let at = [i % SIDE as usize, i / SIDE as usize].map(|k| (k as f64 + 0.5) / f64::from(SIDE) * 2.0 - 1.0);
            let stretch = if is_orthographic { 1.0 } else { (1.0 + at[0] * at[0] + at[1] * at[1]).sqrt() };
            let expected = if at[0] < 0.0 { 3.0 * stretch } else { 0.0 };
            assert!((f64::from(found) - expected).abs() <= 2e-6 * expected, "{found} instead of {expected}");
        }
    }
}

/// Rays of a lens start all over it; the plane stays at its depth.
#[test]
fn near_plane_of_a_lens() {
    let mut scene = Scene::default();
    wall(&mut scene, 1.9, EVERYWHERE, RED);
    wall(&mut scene, 2.1, EVERYWHERE, GREEN);
    let scene = through_file(scene, camera(false, 2.0, 64.0));
    let lens = Settings { aperture: Some(1.0), focus: Some(3.0), ..settings() };
    assert_shows(&picture(&scene, &lens, NEAR), |_, _| GREEN);

    // Beside the pinhole's view, within the lens' blur.
    let mut scene = Scene::default();
    wall(&mut scene, 1.0, [1.05, 2.0], RED);
    wall(&mut scene, 3.0, EVERYWHERE, GREEN);
    let scene = through_file(scene, camera(false, 2.0, 64.0));
    assert_shows(&picture(&scene, &settings(), ActiveClipPlanes::default()), |_, _| GREEN);
    assert_shows(&picture(&scene, &lens, NEAR), |_, _| GREEN);
}

/// Clipped surfaces still cast shadows, and show in mirrors.
#[test]
fn cut_surfaces_keep_light_off() {
    let mut scene = Scene::default();
    let white = Material { metallic: 0.0, specular: 0.0, double_sided: true, ..Material::default() };
    add(&mut scene, Shape::parallelogram(DVec3::Z * -3.0, DVec3::X * 20.0, DVec3::Y * 20.0), white);
    wall(&mut scene, 1.0, EVERYWHERE, RED);
    // The red wall is farther from the white one than the planes are from one another.
    let scene = through_file(scene, camera(true, 2.0, 3.5));
    let film = picture(&scene, &settings(), NEAR);
    let mean = |c: usize| all(&film).map(|i| film.mean(i)[c]).sum::<f64>() / all(&film).len() as f64;
    // Nearly all light on the white wall is from the red one.
    assert!(mean(0) > 0.9 && mean(1) == 0.0 && mean(2) < 0.05, "{} {} {}", mean(0), mean(1), mean(2));
}

/// Planes that cut nothing leave no trace: neither in the kernel nor in a bit of the picture.
#[test]
fn planes_that_cut_nothing() {
    let mut scene = Scene::default();
    wall(&mut scene, 2.0, EVERYWHERE, GREEN);
    // Beside the view, behind the camera, and in the planes themselves.
    wall(&mut scene, 0.5, [1.0, 2.0], RED);
    wall(&mut scene, -1.0, EVERYWHERE, RED);
    wall(&mut scene, 4.0, EVERYWHERE, RED);
    let clipped = through_file(scene.clone(), camera(false, 2.0, 4.0));
    let mut whole = clipped.clone();
    whole.cameras[0].clip = ClipRange::NONE;
    let [clipped, whole] = [clipped, whole].map(|scene| {
        let prepared = prepare(&scene, &settings());
        let wgsl = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}")).wgsl;
        (prepared.key(), wgsl, bits(&picture(&scene, &settings(), ActiveClipPlanes::default())))
    });
    assert!(!whole.1.contains("clip"), "the kernel contains clipping");
    assert!(clipped == whole, "planes that cut nothing change the kernel or the picture");
}

/// Ranges that no file can have neither panic nor hang.
#[test]
fn hostile_ranges() {
    let mut scene = Scene::default();
    wall(&mut scene, 2.0, EVERYWHERE, GREEN);
    for (near, far) in
        [(f64::NAN, 1.0), (1.0, f64::NAN), (-1.0, -2.0), (f64::INFINITY, 0.0), (1e300, 1e301), (5e-324, 1e-320)]
    {
        let camera = camera(false, near, far);
        let prepared = Prepared::new(&scene, &camera, &settings()).unwrap_or_else(|e| panic!("{e}"));
        trace(&prepared, [SIDE; 2], 1, 1);
    }
}

/// The generated files show all that they hold.
#[test]
fn assets_are_not_cut() {
    let mut count = 0;
    for folder in ["", "gltf", "torture"] {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../assets")).join(folder);
        for entry in std::fs::read_dir(&folder).expect("it is there").flatten() {
            let path = entry.path();
            if path.extension().is_none_or(|e| e != "glb") {
                continue;
            }
            let scene = surelight_scene::load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
            for camera in &scene.cameras {
                assert_eq!(
                    ActiveClipPlanes::find(&scene, camera, &settings()),
                    ActiveClipPlanes::default(),
                    "{}",
                    path.display()
                );
                count += 1;
            }
        }
    }
    assert!(count > 40, "only {count} cameras");
}
