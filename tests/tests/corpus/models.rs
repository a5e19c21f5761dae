//! Khronos' models that check themselves, judged by number.
//!
//! An orthographic camera along −Z frames the whole model in a very large picture, of which only
//! small windows are traced.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3, Vec2};
use surelight_film::{Film, Window};
use surelight_prepare::{Prepared, Settings};
use surelight_render::instrument;
use surelight_scene::{Camera, ClipRange, Environment, LoadOptions, Projection, Scene, load};
use surelight_tests::render::{Judge, all, device, pooled};

use crate::corpus;

/// Pixels on a side of the whole picture.
const PIXELS: u32 = 4096;

fn model(name: &str) -> Option<Scene> {
    Some(load(&corpus()?.join(Path::new(name)), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")))
}

/// Whether the material of an instance has a name that passes.
fn retain(scene: &mut Scene, passes: impl Fn(&str) -> bool) {
    let keep: Vec<bool> = scene.meshes.iter().map(|m| passes(&scene.materials[m.material].name)).collect();
    scene.instances.retain(|i| keep[i.mesh]);
}

/// A square of the plane z = 0 around the origin, viewed from +Z.
struct Front {
    prepared: Prepared,
    half: f64,
}

impl Front {
    /// Of `half` metres to each side; paths have this many bounces at most.
    fn new(scene: &Scene, half: f64, max_bounces: Option<u32>) -> Self {
        let camera = Camera {
            name: String::new(),
            to_world: DAffine3 { matrix3: DMat3::IDENTITY, translation: DVec3::new(0.0, 0.0, 100.0) },
            projection: Projection::Orthographic { xmag: half, ymag: half },
            clip: ClipRange::NONE,
        };
        let settings = Settings { max_bounces, ..Settings::new(PIXELS, PIXELS) };
        let prepared = Prepared::new(scene, &camera, &settings).unwrap_or_else(|e| panic!("{e}"));
        Self { prepared, half }
    }

    /// Windows of `size` pixels a side around points, and where their centres truly are.
    fn films(&self, points: &[DVec2], size: u32, samples: u32) -> Vec<(Film, DVec2)> {
        // Few lanes: the windows are small.
        let mut renderer = instrument::with_lanes(device(), &self.prepared, 1).unwrap_or_else(|e| panic!("{e}"));
        let scale = f64::from(PIXELS) / (2.0 * self.half);
        let film = |point: &DVec2| {
            let corner = DVec2::new(point.x + self.half, self.half - point.y) * scale - f64::from(size) / 2.0;
            let [x, y] = [corner.x, corner.y].map(|c| c.round() as u32);
            let window = Window::crop([PIXELS; 2], [x, y, x + size, y + size]).expect("inside the picture");
            let mut film = Film::of_window(window);
            renderer.trace(&mut film, 0, 16, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
            let centre = DVec2::new(f64::from(x), f64::from(y)) + f64::from(size) / 2.0;
            (film, DVec2::new(centre.x / scale - self.half, self.half - centre.y / scale))
        };
        let films = points.iter().map(film).collect();
        assert_eq!((renderer.counts.dropped, renderer.counts.truncated), (0, 0), "samples were lost");
        films
    }
}

fn mean(film: &Film) -> [f64; 3] {
    std::array::from_fn(|c| pooled(film, c, all(film)).mean)
}

/// "Every column shows one shade of blue": blocks of other sizes, scales and attenuation distances
/// against thin panes whose colour is the answer. Straight through a block the radiance of a white
/// sky is r + (1 − r)² c/(1 − r c), r being Fresnel's 0.04; through a pane of one interface it is
/// r + (1 − r) c.
#[test]
fn attenuation_test() {
    let Some(mut scene) = model("materials/AttenuationTest.glb") else { return };
    // Without the backdrop and the labels: nothing but the sky behind.
    retain(&mut scene, |name| name.starts_with('R'));
    assert_eq!(scene.instances.len(), 21);
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    let front = Front::new(&scene, 10.24, None);
    // Thickness in units of the distance after which white is [0.1, 0.5, 0.9], and the column's x.
    let columns = [(0.25, -3.5), (0.5, -2.0), (1.0, 0.0), (1.5, 2.5), (2.0, 6.0)];
    let rows = [6.0, 3.0, 0.0, -3.0, -6.0];
    let points: Vec<DVec2> = columns.iter().flat_map(|&(_, x)| rows.map(|y| DVec2::new(x, y))).collect();
    let films = front.films(&points, 16, 16);
    let judge = Judge::of(points.len(), 0.06);
    let r = 0.04;
    for (&(thickness, _), column) in columns.iter().zip(films.chunks_exact(rows.len())) {
        let shade = [0.1_f64, 0.5, 0.9].map(|c| c.powf(thickness));
        for (row, (film, _)) in column.iter().enumerate() {
            let truth = shade.map(|c| match row {
                0 => r + (1.0 - r) * c,
                _ => r + (1.0 - r) * (1.0 - r) * c / (1.0 - r * c),
            });
            judge.mean(&format!("thickness {thickness}, row {}", row + 1), film, truth);
        }
    }
}

/// Factors alone, textures, textures with a stated gamma, textures with a colour profile: all four
/// the same.
#[test]
fn texture_encoding_test() {
    let Some(mut scene) = model("textures/TextureEncodingTest.glb") else { return };
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    let front = Front::new(&scene, 10.24, None);
    for (row, y) in [("base colour", 2.0), ("emission", -1.0), ("metal and roughness", -4.0)] {
        // The foremost points of the balls are invisible to one another.
        let points = [-2.75, 0.25, 3.25, 6.25].map(|x| DVec2::new(x, y));
        let films = front.films(&points, 16, 64);
        let [stated, textures @ ..] = &films[..] else { unreachable!("four films") };
        let stated = mean(&stated.0);
        println!("{row}: {stated:.5?}");
        for ((film, _), column) in textures.iter().zip(["plain", "gamma", "profile"]) {
            let textured = mean(film);
            println!("    {column}: {textured:.5?}");
            // Read with the wrong curve, 0.246 would be 0.533; a roughness of 0.533 would be 0.25.
            for (a, b) in stated.iter().zip(textured) {
                assert!((a - b).abs() < 0.01 * a.max(0.1), "{row}, {column}: {textured:?} instead of {stated:?}");
            }
        }
    }
}

/// Half of green, stated and interpolated between two texels.
#[test]
fn texture_linear_interpolation_test() {
    let Some(scene) = model("textures/TextureLinearInterpolationTest.glb") else { return };
    let films = Front::new(&scene, 4.096, Some(0)).films(&[DVec2::new(-1.5, -1.0), DVec2::new(1.5, -1.0)], 16, 1);
    let [stated, interpolated] = [0, 1].map(|i: usize| mean(&films[i].0));
    println!("stated {stated:?}, interpolated {interpolated:?}");
    assert_eq!(stated, [0.0, 0.5, 0.0]);
    assert!((interpolated[1] - 0.5).abs() < 0.003 && interpolated[0] == 0.0 && interpolated[2] == 0.0);
}

/// Marks under vertex colours equal the marks below them, which were drawn in those colours.
#[test]
fn vertex_color_test() {
    let Some(mut scene) = model("textures/VertexColorTest.glb") else { return };
    retain(&mut scene, |name| name == "VC_Checks_Mat");
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    // The cards are 0.46 wide; 1,600 pixels are 0.39 of them.
    let front = Front::new(&scene, 20.48, None);
    for (x, channel) in [(-0.548, 0), (0.0, 1), (0.592, 2)] {
        let films = front.films(&[DVec2::new(x, 0.3405), DVec2::new(x, -0.528)], 40, 16);
        let [tinted, drawn] = [0, 1].map(|i: usize| mean(&films[i].0));
        println!("channel {channel}: tinted {tinted:.4?}, drawn {drawn:.4?}");
        // Without vertex colours crosses in the two other channels would show.
        assert!(drawn[channel] > 0.1 + drawn[(channel + 1) % 3] && drawn[channel] > 0.1 + drawn[(channel + 2) % 3]);
        for (a, b) in tinted.iter().zip(drawn) {
            assert!((a - b).abs() < 0.02, "{tinted:?} instead of {drawn:?}");
        }
    }
}

/// Each cube twice its left neighbour.
#[test]
fn emissive_strength_test() {
    let Some(scene) = model("materials/EmissiveStrengthTest.glb") else { return };
    let points = [-6.0, -3.0, 0.0, 3.0, 6.0].map(|x| DVec2::new(x, 0.0));
    let films = Front::new(&scene, 10.24, Some(0)).films(&points, 8, 1);
    for (i, (film, _)) in films.iter().enumerate() {
        let (shown, strength) = (mean(film), f64::from(1 << i));
        println!("strength {strength}: {shown:?}");
        for (shown, color) in shown.iter().zip([0.1_f64, 0.5, 0.9]) {
            assert!((shown - strength * color).abs() < 1e-6 * strength, "{shown} instead of {strength} · {color}");
        }
    }
}

/// The emissive texture follows the second set of coordinates, and the first would show something
/// else.
#[test]
fn multi_uv_test() {
    let Some(scene) = model("textures/MultiUVTest.glb") else { return };
    let mesh = &scene.meshes[0];
    let reference = scene.materials[mesh.material].emissive_texture.as_ref().expect("an emissive texture");
    assert_eq!(reference.uv_set, 1);
    let image = &scene.images[scene.textures[reference.texture].image];
    // Bilinear in linear light, texels at half-integers, repeated.
    let lookup = |uv: Vec2| -> [f64; 3] {
        let at = DVec2::new(f64::from(uv.x) * f64::from(image.width), f64::from(uv.y) * f64::from(image.height)) - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        std::array::from_fn(|c| {
            let texel = |dx: f64, dy: f64| {
                let x = (low.x + dx).rem_euclid(f64::from(image.width)) as usize;
                let y = (low.y + dy).rem_euclid(f64::from(image.height)) as usize;
                let value = f64::from(image.rgba[(y * image.width as usize + x) * 4 + c]) / 255.0;
                if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
            };
            let row = |dy| texel(0.0, dy) * (1.0 - part.x) + texel(1.0, dy) * part.x;
            row(0.0) * (1.0 - part.y) + row(1.0) * part.y
        })
    };
    // Points of the face z = 1, and their coordinates in both sets.
    let at = |p: DVec2, set: usize| {
        let corners = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
        mesh.triangles.iter().find_map(|t| {
            let [a, b, c] = corners(t);
            if [a, b, c].iter().any(|v| v.z < 0.99) {
                return None;
            }
            let (ab, ac, ap) = (b - a, c - a, p.as_vec2() - a.truncate());
            let area = ab.truncate().perp_dot(ac.truncate());
            let (u, v) = (ap.perp_dot(ac.truncate()) / area, ab.truncate().perp_dot(ap) / area);
            let [ta, tb, tc] = t.map(|i| mesh.uvs[set][i as usize]);
            (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| ta + (tb - ta) * u + (tc - ta) * v)
        })
    };
    let points: Vec<DVec2> =
        (0..64).map(|i| DVec2::new(f64::from(i % 8) - 3.5, f64::from(i / 8) - 3.5) * 0.2371 + 0.013).collect();
    let films = Front::new(&scene, 2.048, Some(0)).films(&points, 1, 1);
    let (mut error, mut other) = (0.0, 0.0);
    for (film, centre) in films {
        let shown = mean(&film);
        let distance = |set| {
            let expected = lookup(at(centre, set).expect("a point of the face"));
            shown.iter().zip(expected).map(|(a, b)| (a - b).abs()).sum::<f64>()
        };
        error += distance(1) / 64.0;
        other += distance(0) / 64.0;
    }
    println!("mean difference from the second set {error:.5}, from the first {other:.5}");
    assert!(error < 0.02 && other > 0.2, "{error} from the second set, {other} from the first");
}

/// Arrows that are turned by quaternions and by matrices point at targets that are not turned.
#[test]
fn orientation_test() {
    let Some(scene) = model("geometry/OrientationTest.glb") else { return };
    for name in ["MatX1", "MatX2", "MatY1", "MatY2", "MatZ1", "MatZ2"] {
        let placed: Vec<_> = scene
            .instances
            .iter()
            .filter(|i| scene.materials[scene.meshes[i.mesh].material].name == name)
            .map(|i| (i.to_world, &scene.meshes[i.mesh]))
            .collect();
        let [a, b] = placed[..] else { panic!("{name} has {} parts", placed.len()) };
        // The target is placed by the identity.
        let (arrow, target) = if a.0 == DAffine3::IDENTITY { (b, a) } else { (a, b) };
        // Both are symmetric about the line from the arrow's pivot, so the middles of their boxes
        // lie on it.
        let middle = |mesh: &surelight_scene::Mesh| {
            let (low, high) = mesh
                .positions
                .iter()
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p.as_dvec3()), h.max(p.as_dvec3())));
            (low + high) * 0.5
        };
        let pointed = arrow.0.transform_vector3(middle(arrow.1));
        let angle = pointed.angle_between(middle(target.1) - arrow.0.translation).to_degrees();
        println!("{name}: {angle:.2}°");
        // A transposed rotation is 10° to 70° off.
        assert!(angle < 3.0, "{name} points {angle}° past its target");
    }
}
