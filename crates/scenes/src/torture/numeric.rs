//! Numbers at the ends of f32: cases 1 to 8.

use std::f64::consts::PI;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use surelight_scene::{Environment, Light, LightKind, Material, Scene, Volume};

use super::{Case, named, orthographic};
use crate::builder::{Builder, emitter, glass, lambert, metal};
use crate::shapes::Shape;
use crate::{Entry, cornell_box, furnace, probes};

/// The group's cases.
pub const CASES: &[Case] = &[
    Case::new(
        1,
        Entry {
            name: "zero-variance-furnace",
            shows: "A convex diffuse ball under a uniform sky (`--sky 1,2,0.3`).",
            known: "Light is reflected once at most: each sample that meets the ball is ρ·L = (0.8, 0.9, 0.108), each \
                    other one L, within 4 ULP and without variance.",
            build: zero_variance_furnace,
        },
    ),
    Case::new(
        2,
        Entry {
            name: "scale-emission",
            shows: "The Cornell box, whose lamp is made brighter and darker by 2^±10.",
            known: "The picture scales by the same power of two, bit for bit: nothing but the lamp has a unit of power.",
            build: || named("scale-emission", cornell_box::cornell_box()),
        },
    ),
    Case::new(
        3,
        Entry {
            name: "scale-geometry",
            shows: "The Cornell box, made larger and smaller by 2^±20.",
            known: "The picture stays, bit for bit: radiance has no length in it, and powers of two round nothing.",
            build: || named("scale-geometry", cornell_box::cornell_box()),
        },
    ),
    Case::new(
        4,
        Entry {
            name: "far-origin",
            shows: "The furnace 2^20 = 1,048,576 units from the origin on each axis.",
            known: "Every pixel is (0.5, 0.25, 0.125), as at the origin.",
            build: || far_origin(DVec3::new(-1.0, 1.0, 1.0) * 1_048_576.0),
        },
    ),
    Case::new(
        5,
        Entry {
            name: "tiny-scene",
            shows: "The furnace with a room of two micrometres.",
            known: "Every pixel is (0.5, 0.25, 0.125), as in the room of two metres.",
            build: || tiny_scene(1e-6),
        },
    ),
    Case::new(
        6,
        Entry {
            name: "u-endpoints",
            shows: "Matt, brushed and clear balls under two lamps and a point light: every sampler there is.",
            known: "With all random numbers 0, or all 1 − 2^-24, each sampler gives a finite direction of unit length, a \
                    density above 0 and a finite weight. The picture has no closed form.",
            build: u_endpoints,
        },
    ),
    Case::new(
        7,
        Entry {
            name: "dot-above-one",
            shows: "A metal plate of GGX α = 0.01, seen along its normal, along which light falls on it.",
            known: "All cosines are 1, and each sample is E·F0/(4π·α²) = 4·F0/(4π·10⁻⁴) = (2865, 1592, 637), whatever way \
                    the plate is turned.",
            build: || dot_above_one(DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7)),
        },
    ),
    Case::new(
        8,
        Entry {
            name: "nan-quarantine",
            shows: "A small mirror before a glowing wall; the mirror shines 3·10³⁸ and shows a lamp that does, too.",
            known: "A sample that meets the mirror is infinite: it is left out, counted, and worth 0. Each pixel is the \
                    wall's (0.25, 0.5, 1) times the share of its samples that miss the mirror, exactly.",
            build: || nan_quarantine(3e38),
        },
    ),
];

/// Reflectance of the ball of [`zero_variance_furnace`].
pub const FURNACE_REFLECTANCE: [f32; 3] = [0.8, 0.45, 0.36];

/// Radiance of the sky of [`zero_variance_furnace`].
pub const FURNACE_SKY: [f32; 3] = [1.0, 2.0, 0.3];

/// A faceted ball of reflectance ρ under a sky L: ρ·L in each sample that hits it, since a convex
/// body reflects light once and the weight of a direction sampled by the cosine is ρ itself.
pub fn zero_variance_furnace() -> Scene {
    let mut scene = named("zero-variance-furnace", probes::convex_furnace(FURNACE_REFLECTANCE, 3));
    scene.environment = Some(Environment::Uniform(FURNACE_SKY));
    scene
}

/// The furnace moved by its nodes, camera included. The camera is on a grid that f32 represents at
/// 2^20.
pub fn far_origin(by: DVec3) -> Scene {
    let mut scene = named("far-origin", furnace::furnace());
    scene.cameras[0].to_world.translation = DVec3::new(0.25, 0.25, 0.875) + by;
    scene.instances.iter_mut().for_each(|i| i.to_world.translation += by);
    scene
}

/// The furnace with its vertices scaled, camera included.
pub fn tiny_scene(scale: f64) -> Scene {
    let mut scene = named("tiny-scene", furnace::furnace());
    scene.cameras[0].to_world.translation *= scale;
    for position in scene.meshes.iter_mut().flat_map(|mesh| &mut mesh.positions) {
        *position = (position.as_dvec3() * scale).as_vec3();
    }
    scene
}

/// Lobes and lights of every kind, to be sampled with the ends of the random numbers' range.
pub fn u_endpoints() -> Scene {
    let mut b = Builder::new("u-endpoints");
    let clear = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let floor = b.material(lambert("floor", [0.5; 3]));
    let kinds = [lambert("matt", [0.8, 0.4, 0.2]), metal("brushed", [0.9, 0.8, 0.6], 0.1), glass("clear", 1.5, clear)];
    b.add("floor", Shape::parallelogram(DVec3::NEG_Y, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), floor);
    for (k, kind) in kinds.into_iter().enumerate() {
        let material = b.material(kind);
        b.add("ball", Shape::icosphere(2).placed(0.9, DVec3::X * (2.0 * k as f64 - 2.0)), material);
    }
    for (k, radiance) in [4.0, 0.01].into_iter().enumerate() {
        let lamp = b.material(emitter("lamp", [radiance; 3]));
        let x = 4.0 * k as f64 - 2.0;
        b.add("lamp", Shape::parallelogram(DVec3::new(x, 3.0, 0.0), DVec3::X * 0.5, DVec3::Z * 0.5), lamp);
    }
    b.camera(DVec3::new(0.0, 2.0, 7.0), DVec3::new(0.0, -0.2, 0.0), 45.0, 1.5);
    let mut scene = b.finish();
    let kind = LightKind::Point { position: DVec3::new(1.0, 2.5, 2.0) };
    scene.lights.push(Light { name: "point".to_owned(), kind, intensity: [3.0; 3] });
    scene
}

/// GGX α of [`dot_above_one`].
pub const PLATE_ALPHA: f64 = 0.01;

/// Reflectance at normal incidence of the plate of [`dot_above_one`].
pub const PLATE_F0: [f32; 3] = [0.9, 0.5, 0.2];

/// Irradiance of the light of [`dot_above_one`].
pub const PLATE_IRRADIANCE: f32 = 4.0;

/// Radiance of the plate: f·E with f = F0·D·G/4, D = 1/(π·α²) at the normal and G = 1 there.
pub fn dot_above_one_radiance() -> [f64; 3] {
    // The file's roughness is the rounded root of α.
    let alpha = f64::from(PLATE_ALPHA.sqrt() as f32).powi(2);
    PLATE_F0.map(|f0| f64::from(f0) * f64::from(PLATE_IRRADIANCE) / (4.0 * PI * alpha * alpha))
}

/// Plate, camera and light turned together: in f32, unit vectors then have lengths 1 ± 1 ULP and
/// cosines come out above 1.
pub fn dot_above_one(turn: DQuat) -> Scene {
    let mut b = Builder::new("dot-above-one");
    let [x, y, z] = DMat3::from_quat(turn).to_cols_array_2d().map(DVec3::from);
    let plate = b.material(metal("plate", PLATE_F0, PLATE_ALPHA));
    b.add("plate", Shape::parallelogram(DVec3::ZERO, x * 2.0, y * 2.0), plate);
    let mut scene = b.finish();
    scene.cameras.push(orthographic(DAffine3::from_rotation_translation(turn, z), 0.5));
    let kind = LightKind::Directional { direction: -z };
    scene.lights.push(Light { name: "sun".to_owned(), kind, intensity: [PLATE_IRRADIANCE; 3] });
    scene
}

/// Radiance of the wall of [`nan_quarantine`].
pub const QUARANTINE_WALL: [f32; 3] = [0.25, 0.5, 1.0];

/// A wall, and before it a mirror at 45° that shines with `radiance` and shows a lamp beside the
/// view that does, too. 0 for the same picture without any bad sample: the mirror then is black.
pub fn nan_quarantine(radiance: f32) -> Scene {
    let mut b = Builder::new("nan-quarantine");
    let wall = b.material(emitter("wall", QUARANTINE_WALL));
    let reflectance = if radiance == 0.0 { [0.0; 3] } else { [1.0; 3] };
    let mirror = Material { emissive: [radiance; 3], ..metal("mirror", reflectance, 0.0) };
    let mirror = b.material(if radiance == 0.0 { lambert("hole", [0.0; 3]) } else { mirror });
    let lamp = b.material(emitter("lamp", [radiance; 3]));
    b.add("wall", Shape::parallelogram(DVec3::NEG_Z, DVec3::X * 1.5, DVec3::Y * 1.5), wall);
    let middle = DVec3::new(0.1, 0.07, 0.0);
    let along = DVec3::new(1.0, 0.0, -1.0) * 0.2;
    b.add("mirror", Shape::parallelogram(middle, along, DVec3::Y * 0.3), mirror);
    b.add("lamp", Shape::parallelogram(middle + DVec3::X * 3.0, DVec3::Z, DVec3::Y), lamp);
    let mut scene = b.finish();
    scene.cameras.push(orthographic(DAffine3::from_translation(DVec3::Z), 1.0));
    scene
}
