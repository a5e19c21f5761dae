//! EXT_lights_image_based: the six faces of a scene's cube map, as a map of latitude and longitude.
//!
//! Of the light, the sharpest level of the cube map is taken, as radiance; blurred levels and
//! spherical harmonics are shortcuts for renderers that do not integrate.

use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};
use rayon::prelude::*;
use serde::Deserialize;

use super::document::{Document, Int};
use super::images::{self, Sources};
use super::nodes;
use super::warnings::Warnings;
use crate::{Environment, EnvironmentMap, Image};

const NAME: &str = "EXT_lights_image_based";

/// Most texels on a side of a face.
const LARGEST_FACE: u32 = 4096;
/// The divisor in place of an alpha of 0 in an RGBD image.
const MIN_ALPHA: f64 = 1.0 / 255.0;

#[derive(Deserialize)]
struct SceneLight {
    light: Int,
}

#[derive(Deserialize)]
struct Lights {
    lights: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct LightJson {
    rotation: Option<[f64; 4]>,
    intensity: Option<f64>,
    /// Levels, each of six images: +X, −X, +Y, −Y, +Z, −Z.
    specular_images: Vec<[Int; 6]>,
}

/// The light of the chosen scene; one that is broken is left out with a warning.
pub(crate) fn read(sources: Sources, wanted: Option<usize>, warnings: &mut Warnings) -> Option<Environment> {
    let scene = nodes::chosen(sources.document, wanted)?;
    let reference = sources.document.scenes.get(scene)?.extensions.parse::<SceneLight>(NAME)?;
    let light = reference.and_then(|scene| definition(sources.document, scene.light.index()));
    match light.and_then(|light| environment(sources, &light, warnings)) {
        Ok(environment) => Some(environment),
        Err(cause) => {
            warnings.push(format!("The image-based light of scene {scene} is left out: {cause}."));
            None
        }
    }
}

fn definition(document: &Document, index: usize) -> Result<LightJson, String> {
    let lights = document.extensions.parse::<Lights>(NAME).ok_or("the file defines none")??;
    let count = lights.lights.len();
    let json = lights.lights.get(index).ok_or(format!("it names light {index}, and there are {count}"))?;
    LightJson::deserialize(json).map_err(|e| format!("light {index}: {e}"))
}

fn environment(sources: Sources, light: &LightJson, warnings: &mut Warnings) -> Result<Environment, String> {
    let named = light.specular_images.first().ok_or("it has no specularImages")?.map(Int::index);
    let decoded = images::decode_all(sources, &named.map(|index| vec![index]));
    warnings.append(decoded.warnings);
    let mut faces = Vec::new();
    for index in named {
        let slot = decoded.slots.get(&index).ok_or(format!("image {index} cannot be read"))?;
        faces.push(&decoded.images[*slot]);
    }
    let size = faces[0].width;
    if faces.iter().any(|face| face.width != size || face.height != size) {
        return Err("its images are not six squares of one size".into());
    }
    if size > LARGEST_FACE {
        return Err(format!("its images are {size} pixels wide, and {LARGEST_FACE} are the most that are read"));
    }
    let rotation = light.rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    if !(rotation.length() > 0.0 && rotation.is_finite()) {
        return Err("its rotation is no quaternion".into());
    }
    let intensity = light.intensity.unwrap_or(1.0);
    let clamped = intensity.clamp(0.0, 1e12);
    if clamped != intensity {
        warnings.push(format!("The intensity of an image-based light is {intensity}; {clamped} is used."));
    }
    let linear: Vec<Vec<[f32; 3]>> = faces.iter().map(|face| texels(face)).collect();
    let map = unrolled(&linear, size, rotation.normalize().inverse());
    Ok(Environment::Map { map: Arc::new(map), rotation: 0.0, scale: clamped as f32 })
}

/// Linear radiance of an image: sRGB, and divided by alpha, which is 1 except in RGBD.
fn texels(image: &Image) -> Vec<[f32; 3]> {
    let curve: Vec<f64> = (0..=255)
        .map(|byte| {
            let c = f64::from(byte) / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
        .collect();
    let texel = |rgba: &[u8]| {
        let alpha = (f64::from(rgba[3]) / 255.0).max(MIN_ALPHA);
        std::array::from_fn(|c| (curve[usize::from(rgba[c])] / alpha) as f32)
    };
    image.rgba.chunks_exact(4).map(texel).collect()
}

/// The map with texels of about the faces' size, each the mean of four lookups.
fn unrolled(faces: &[Vec<[f32; 3]>], size: u32, to_local: DQuat) -> EnvironmentMap {
    let (width, height) = (4 * size, 2 * size);
    let texel = |i: usize| -> [f32; 3] {
        let (column, row) = (i as u32 % width, i as u32 / width);
        let mut sum = [0.0; 3];
        for (du, dv) in [(0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)] {
            let azimuth = ((f64::from(column) + du) / f64::from(width) - 0.5) * std::f64::consts::TAU;
            let (y, radius) = ((0.5 - (f64::from(row) + dv) / f64::from(height)) * std::f64::consts::PI).sin_cos();
            let radiance =
                lookup(faces, size, to_local * DVec3::new(radius * azimuth.cos(), y, radius * azimuth.sin()));
            for (sum, c) in sum.iter_mut().zip(radiance) {
                *sum += 0.25 * c;
            }
        }
        sum
    };
    let texels = (0..width as usize * height as usize).into_par_iter().map(texel).collect();
    EnvironmentMap { width, height, texels }
}

/// The face that a direction hits, and where: x to the right and y downwards, both in [0, 1].
///
/// OpenGL's cube maps appear mirrored from within; the extension's images are mirrored again, so
/// that each is the view of a camera at the origin.
fn face(direction: DVec3) -> (usize, DVec2) {
    let size = direction.abs();
    let (face, major, right, down) = if size.x >= size.y && size.x >= size.z {
        let sign = direction.x.signum();
        (usize::from(sign < 0.0), size.x, sign * direction.z, -direction.y)
    } else if size.y >= size.z {
        let sign = direction.y.signum();
        (2 + usize::from(sign < 0.0), size.y, -direction.x, sign * direction.z)
    } else {
        let sign = direction.z.signum();
        (4 + usize::from(sign < 0.0), size.z, -sign * direction.x, -direction.y)
    };
    (face, DVec2::new(right / major, down / major) * 0.5 + 0.5)
}

/// Bilinear within a face.
fn lookup(faces: &[Vec<[f32; 3]>], size: u32, direction: DVec3) -> [f32; 3] {
    let (face, at) = face(direction);
    let last = size as usize - 1;
    let at = (at * f64::from(size) - 0.5).clamp(DVec2::ZERO, DVec2::splat(last as f64));
    let (x, y) = (at.x as usize, at.y as usize);
    let (fx, fy) = (at.x.fract() as f32, at.y.fract() as f32);
    let texel = |x: usize, y: usize| faces[face][y.min(last) * size as usize + x.min(last)];
    let corners = [texel(x, y), texel(x + 1, y), texel(x, y + 1), texel(x + 1, y + 1)];
    std::array::from_fn(|c| {
        let [a, b, d, e] = corners.map(|corner| corner[c]);
        (a * (1.0 - fx) + b * fx) * (1.0 - fy) + (d * (1.0 - fx) + e * fx) * fy
    })
}
