//! How surfaces scatter: cases 27 to 33.

use std::f64::consts::FRAC_PI_2;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use surelight_scene::{
    AlphaMode, Camera, ClipRange, Environment, Light, LightKind, Material, Projection, Scene, Volume,
};

use super::Case;
use crate::Entry;
use crate::builder::{Builder, emitter, glass, lambert, metal};
use crate::probes;
use crate::shapes::Shape;

/// The group's cases. Reciprocity (27) is of the BSDF alone and has no scene.
pub const CASES: &[Case] = &[
    Case::new(
        28,
        Entry {
            name: "furnace-ggx",
            shows: "Six plates of white metal under a white sky: α = 0.001, 0.01, 0.1, 0.3, 0.6 and 1.",
            known: "A plate shows the directional albedo of GGX at normal incidence: 1 for α → 0, 1 − ln 2 = 0.3069 for \
                    α = 1 (D = 1/π, G2 = 2c/(1 + c)).",
            build: furnace_ggx,
        },
    ),
    Case::new(
        29,
        Entry {
            name: "ggx-mirror",
            shows: "A rough (α = 0.0002) and a smooth metal side by side mirror a lamp at 45°.",
            known: "Both show F·L with Schlick's F at 45°: (0.9002, 0.5011, 0.1019) to within the lobe's width.",
            build: ggx_mirror,
        },
    ),
    Case::new(
        30,
        Entry {
            name: "glass-sphere-furnace",
            shows: "A faceted ball of clear glass in a white sky.",
            known: "It cannot be seen: every pixel is 1 at unbounded depth.",
            build: glass_sphere_furnace,
        },
    ),
    Case::new(
        31,
        Entry {
            name: "slab",
            shows: "A slab of glass between two lamps.",
            known: "n = 1.5: r = 0.04, so red (transmittance) is 0.9231, green (reflectance) 2r/(1 + r) = 0.0769, blue their sum 1.",
            build: || probes::slab(1.5, 0.7, 1.0),
        },
    ),
    Case::new(
        32,
        Entry {
            name: "tir-cone",
            shows: "Straight up from below a surface of water: the sky within a cone.",
            known: "n = 1.333: within asin(1/n) = 48.6° of the vertical n²·(1 − F), beyond exactly 0.",
            build: || tir_cone(TIR_IOR),
        },
    ),
    Case::new(
        33,
        Entry {
            name: "alpha-64",
            shows: "A lamp through 64 black sheets of 2 % cover.",
            known: "Every pixel is (1 − α)⁶⁴ = 0.2744.",
            build: || alpha_64(0.02),
        },
    ),
];

/// Refractive index in the file of `tir-cone`.
pub const TIR_IOR: f32 = 1.333;

/// Half the opening of the camera of [`tir_cone`].
pub const TIR_HALF_VIEW: f64 = 60.0;

/// Sheets of [`alpha_64`].
const SHEETS: u32 = 64;

fn white_sky(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// The camera is 5 m above, facing down, +X to the right.
fn from_above(half_width: f64, half_height: f64) -> Camera {
    let turn = DMat3::from_quat(DQuat::from_rotation_x(-FRAC_PI_2));
    Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_mat3_translation(turn, DVec3::Y * 5.0),
        projection: Projection::Orthographic { xmag: half_width, ymag: half_height },
        clip: ClipRange::NONE,
    }
}

fn furnace_ggx() -> Scene {
    let mut b = Builder::new("furnace-ggx");
    for (k, alpha) in [0.001, 0.01, 0.1, 0.3, 0.6, 1.0].into_iter().enumerate() {
        let material = b.material(metal(&format!("alpha {alpha}"), [1.0; 3], alpha));
        let at = DVec3::X * (k as f64 - 2.5);
        b.add(&format!("plate {alpha}"), Shape::parallelogram(at, DVec3::X * 0.5, DVec3::NEG_Z * 0.5), material);
    }
    let mut scene = white_sky(b.finish());
    scene.cameras.push(from_above(3.0, 0.5));
    scene
}

fn ggx_mirror() -> Scene {
    let mut b = Builder::new("ggx-mirror");
    let lamp = b.material(emitter("lamp", [1.0; 3]));
    for (name, alpha, x) in [("rough", 2e-4, -0.5), ("smooth", 0.0, 0.5)] {
        let material = b.material(metal(name, [0.9, 0.5, 0.1], alpha));
        b.add(name, Shape::parallelogram(DVec3::X * x, DVec3::X * 0.5, DVec3::NEG_Z), material);
    }
    // Behind the plates, in the view of the camera's mirror image.
    b.add("lamp", Shape::parallelogram(DVec3::new(0.0, 3.0, -3.0), DVec3::X * 4.0, DVec3::new(0.0, 3.0, 0.0)), lamp);
    let mut scene = b.finish();
    let turn = DMat3::from_quat(DQuat::from_rotation_x(-0.5 * FRAC_PI_2));
    scene.cameras.push(Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_mat3_translation(turn, DVec3::new(0.0, 2.0, 2.0)),
        projection: Projection::Orthographic { xmag: 0.5, ymag: 0.5 },
        clip: ClipRange::NONE,
    });
    scene
}

/// Without its flat facets a tessellated ball bends light by normals that are not its own.
fn glass_sphere_furnace() -> Scene {
    let mut b = Builder::new("glass-sphere-furnace");
    let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let material = b.material(glass("glass", 1.5, volume));
    b.add("ball", Shape::icosphere(4).faceted(), material);
    b.camera(DVec3::new(1.0, 2.0, 4.0), DVec3::ZERO, 30.0, 1.0);
    white_sky(b.finish())
}

/// Water over a black bed, its surface 1 m above a camera that faces straight up, under a lamp as
/// large as the sky.
///
/// Snell's law sends directions within asin(1/n) of the vertical up to the lamp, the others back
/// down into darkness. Radiance is n² times as large within the water (Veach 1997, section 5.2), so
/// that the picture shows n²·(1 − F).
pub fn tir_cone(ior: f32) -> Scene {
    let mut b = Builder::new("tir-cone");
    let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let water = b.material(glass("water", ior, volume));
    let sky = b.material(emitter("sky", [1.0; 3]));
    let bed = b.material(lambert("bed", [0.0; 3]));
    b.add("water", Shape::cuboid(DVec3::new(-50.0, -2.0, -50.0), DVec3::new(50.0, 1.0, 50.0)), water);
    b.add("bed", Shape::parallelogram(DVec3::NEG_Y, DVec3::X * 50.0, DVec3::NEG_Z * 50.0), bed);
    b.add("sky", Shape::parallelogram(DVec3::Y * 2.0, DVec3::X * 1e4, DVec3::Z * 1e4), sky);
    let mut scene = b.finish();
    scene.cameras.push(Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_quat(DQuat::from_rotation_x(FRAC_PI_2)),
        projection: Projection::Perspective { yfov: 2.0 * TIR_HALF_VIEW.to_radians(), aspect: Some(1.0) },
        clip: ClipRange::NONE,
    });
    scene
}

fn sheets(b: &mut Builder, alpha: f32) {
    let base = lambert("sheet", [0.0; 3]);
    let sheet = Material { base_color: [0.0, 0.0, 0.0, alpha], alpha_mode: AlphaMode::Blend, ..base };
    let sheet = b.material(sheet);
    for k in 0..SHEETS {
        let at = DVec3::Y * (1.0 + 0.02 * f64::from(k));
        b.add(&format!("sheet {k}"), Shape::parallelogram(at, DVec3::X, DVec3::NEG_Z), sheet);
    }
}

/// Sheets of coverage `alpha` between a lamp and the camera, which face each other.
pub fn alpha_64(alpha: f32) -> Scene {
    let mut b = Builder::new("alpha-64");
    sheets(&mut b, alpha);
    let lamp = b.material(emitter("lamp", [1.0; 3]));
    b.add("lamp", Shape::parallelogram(DVec3::ZERO, DVec3::X, DVec3::NEG_Z), lamp);
    let mut scene = b.finish();
    scene.cameras.push(from_above(0.5, 0.5));
    scene
}

/// The same sheets between a floor (ρ = 0.5) and parallel light of 1 lux from straight above,
/// viewed from below them: ρ/π·(1 − α)⁶⁴.
pub fn alpha_64_shadow(alpha: f32) -> Scene {
    let mut b = Builder::new("alpha-64-shadow");
    sheets(&mut b, alpha);
    let floor = b.material(lambert("floor", [0.5; 3]));
    b.add("floor", Shape::parallelogram(DVec3::ZERO, DVec3::X, DVec3::NEG_Z), floor);
    b.camera(DVec3::new(0.0, 0.5, 0.5), DVec3::ZERO, 20.0, 1.0);
    let mut scene = b.finish();
    let kind = LightKind::Directional { direction: DVec3::NEG_Y };
    scene.lights.push(Light { name: "sun".to_owned(), kind, intensity: [1.0; 3] });
    scene
}
