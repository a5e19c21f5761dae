//! Lights that are hard to sample, or cannot be: cases 34 to 39.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DMat3, DQuat, DVec3};
use surelight_scene::{Camera, ClipRange, Light, LightKind, Projection, Scene, Volume};

use super::Case;
use crate::Entry;
use crate::builder::{Builder, emitter, glass, lambert, look_at};
use crate::random::SplitMix;
use crate::shapes::Shape;
use crate::{polygon_irradiance, probes, quad_light};

/// The group's cases. The one-hot texel (36) is an environment map, which glTF does not hold.
pub const CASES: &[Case] = &[
    Case::new(
        34,
        Entry {
            name: "polygon-irradiance",
            shows: "A tilted lamp over a floor.",
            known: "Lambert's polygon formula in every pixel.",
            build: quad_light::quad_light,
        },
    ),
    Case::new(
        35,
        Entry {
            name: "contact-light",
            shows: "A lamp on the floor, seen from above: they touch at the top edge of the picture.",
            known: "Lambert's polygon formula in every pixel, ρL/2 in the limit at the edge. Points on the lamp come as close as they \
                    please: by the area form a sample exceeds x with a probability of x^−1.5, and has no variance.",
            build: contact_light,
        },
    ),
    Case::new(
        37,
        Entry {
            name: "linearity",
            shows: "A floor under sixteen point lights of three decades of intensity.",
            known: "Light adds: every pixel is ρ/π·Σ I·cosθ/r².",
            build: || linearity(16),
        },
    ),
    Case::new(
        38,
        Entry {
            name: "sds",
            shows: "A point light in a globe of clear glass above a floor.",
            known: "No path connects the camera with the light: the picture is 0, and is said to lack all of its light.",
            build: || sds(None),
        },
    ),
    Case::new(
        39,
        Entry {
            name: "mirror-corridor",
            shows: "A lamp by five mirrors, each at 45°.",
            known: "Every pixel is F⁵ with Schlick's F at 45°: (0.7742, 0.5912, 0.3286).",
            build: || probes::mirror_corridor(5, [0.95, 0.9, 0.8]),
        },
    ),
];

/// Reflectance of the floors here.
pub const REFLECTANCE: f64 = 0.5;

/// Radiance of the lamp of [`contact_light`].
pub const CONTACT_RADIANCE: f64 = 2.0;

fn from_above(at: DVec3, half: f64) -> Camera {
    let turn = DMat3::from_quat(DQuat::from_rotation_x(-FRAC_PI_2));
    Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_mat3_translation(turn, at + DVec3::Y * 3.0),
        projection: Projection::Orthographic { xmag: half, ymag: half },
        clip: ClipRange::NONE,
    }
}

fn floor(b: &mut Builder) {
    let material = b.material(lambert("floor", [REFLECTANCE as f32; 3]));
    b.add("floor", Shape::parallelogram(DVec3::ZERO, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), material);
}

fn contact_lamp() -> [DVec3; 4] {
    [(-1.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0))
}

/// A lamp of 2 m × 1 m, upright on the floor, that faces +Z; the picture is a quarter of a square
/// metre in front of it.
pub fn contact_light() -> Scene {
    let mut b = Builder::new("contact-light");
    floor(&mut b);
    let lamp = b.material(emitter("lamp", [CONTACT_RADIANCE as f32; 3]));
    b.add("lamp", Shape::quad(contact_lamp()), lamp);
    let mut scene = b.finish();
    scene.cameras.push(from_above(DVec3::Z * 0.25, 0.25));
    scene
}

/// Radiance of the floor of [`contact_light`] at (x, 0, z), z > 0.
pub fn contact_radiance(x: f64, z: f64) -> f64 {
    let irradiance = polygon_irradiance(DVec3::new(x, 0.0, z), DVec3::Y, &contact_lamp());
    REFLECTANCE / PI * CONTACT_RADIANCE * irradiance
}

/// Positions and intensities of the lights of [`linearity`].
fn punctual(n: u32) -> Vec<(DVec3, f64)> {
    let mut random = SplitMix::new(37);
    (0..n)
        .map(|_| {
            let at = DVec3::new(random.range(-1.0, 1.0), random.range(0.5, 2.0), random.range(-1.0, 1.0));
            (at, f64::from(10f64.powf(random.range(-3.0, 0.0)) as f32))
        })
        .collect()
}

/// A floor of 2 m under `n` point lights, half a metre to two metres above.
pub fn linearity(n: u32) -> Scene {
    let mut b = Builder::new("linearity");
    floor(&mut b);
    let mut scene = b.finish();
    scene.cameras.push(from_above(DVec3::ZERO, 1.0));
    scene.lights = punctual(n)
        .into_iter()
        .enumerate()
        .map(|(k, (position, intensity))| Light {
            name: format!("light {k}"),
            kind: LightKind::Point { position },
            intensity: [intensity as f32; 3],
        })
        .collect();
    scene
}

/// Radiance of the floor of [`linearity`] at points (x, 0, z): ρ/π·Σ I·cosθ/r².
pub fn linearity_radiance(n: u32, points: &[[f64; 2]]) -> Vec<f64> {
    let lights = punctual(n);
    let at = |&[x, z]: &[f64; 2]| {
        let sum = lights.iter().map(|(p, intensity)| {
            let r2 = (p.x - x).powi(2) + p.y * p.y + (p.z - z).powi(2);
            intensity * p.y / (r2 * r2.sqrt())
        });
        REFLECTANCE / PI * sum.sum::<f64>()
    };
    points.iter().map(at).collect()
}

/// Lamps of [`many_lamps`], each a triangle that faces the floor, and its radiance. They are in
/// cells of one plane, so that none hides another.
fn lamps(n: u32) -> Vec<([DVec3; 3], f64)> {
    let mut random = SplitMix::new(38);
    let columns = f64::from(n).sqrt().ceil();
    let cell = 2.0 / columns;
    let one = |k| {
        let at = |index: f64| (index + 0.5) * cell - 1.0;
        let at = DVec3::new(at(f64::from(k) % columns), 1.0, at((f64::from(k) / columns).floor()));
        let (size, turn) = (cell * random.range(0.1, 0.3), random.range(0.0, TAU));
        let (x, z) = (DVec3::new(turn.cos(), 0.0, turn.sin()) * size, DVec3::new(turn.sin(), 0.0, -turn.cos()) * size);
        // As f32 rounds them.
        let corners = [at, at + z, at + x].map(|p| p.as_vec3().as_dvec3());
        (corners, f64::from(10f64.powf(random.range(-1.0, 2.0)) as f32))
    };
    (0..n).map(one).collect()
}

/// A floor of 2 m under `n` small triangular lamps, of which `only` one shines where it is given.
pub fn many_lamps(n: u32, only: Option<u32>) -> Scene {
    let mut b = Builder::new("many-lamps");
    floor(&mut b);
    for (k, (corners, radiance)) in (0..).zip(lamps(n)) {
        if only.is_none_or(|only| only == k) {
            let material = b.material(emitter(&format!("lamp {k}"), [radiance as f32; 3]));
            let shape = Shape { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Shape::default() };
            b.add(&format!("lamp {k}"), shape, material);
        }
    }
    let mut scene = b.finish();
    // From below the lamps, so that none is visible.
    let turn = DMat3::from_quat(DQuat::from_rotation_x(-FRAC_PI_2));
    scene.cameras.push(Camera {
        name: "camera".to_owned(),
        to_world: DAffine3::from_mat3_translation(turn, DVec3::Y * 0.4),
        projection: Projection::Orthographic { xmag: 1.0, ymag: 1.0 },
        clip: ClipRange::NONE,
    });
    scene
}

/// Radiance of the floor of [`many_lamps`] at points (x, 0, z), by Lambert's polygon formula.
pub fn many_lamps_radiance(n: u32, points: &[[f64; 2]]) -> Vec<f64> {
    let lamps = lamps(n);
    let at = |&[x, z]: &[f64; 2]| {
        let p = DVec3::new(x, 0.0, z);
        REFLECTANCE / PI * lamps.iter().map(|(corners, l)| l * polygon_irradiance(p, DVec3::Y, corners)).sum::<f64>()
    };
    points.iter().map(at).collect()
}

/// A globe of clear glass 1 m above a floor, and in it a point light, or a shining ball of this
/// radius in metres and the same power.
///
/// All paths from the light to the camera are of the class L S D E (Heckbert 1990). No point on the
/// light can be connected with the floor.
pub fn sds(radius: Option<f64>) -> Scene {
    let mut b = Builder::new("sds");
    floor(&mut b);
    let volume = Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] };
    let clear = b.material(glass("globe", 1.5, volume));
    let at = DVec3::Y;
    b.add("globe", Shape::icosphere(3).faceted().placed(0.4, at), clear);
    if let Some(radius) = radius {
        // Φ = 4π·I of a point light of 1 cd, spread as π·L·A.
        let shape = Shape::icosphere(2).placed(radius, at);
        let bulb = b.material(emitter("bulb", [(4.0 / shape.area()) as f32; 3]));
        b.add("bulb", shape, bulb);
    }
    let mut scene = b.finish();
    if radius.is_none() {
        let kind = LightKind::Point { position: at };
        scene.lights.push(Light { name: "bulb".to_owned(), kind, intensity: [1.0; 3] });
    }
    // The floor beside the globe.
    scene.cameras.push(Camera {
        name: "camera".to_owned(),
        to_world: look_at(DVec3::new(0.0, 1.2, 3.0), DVec3::new(0.0, 0.1, 0.2)),
        projection: Projection::Perspective { yfov: 30f64.to_radians(), aspect: Some(1.0) },
        clip: ClipRange::NONE,
    });
    scene
}
