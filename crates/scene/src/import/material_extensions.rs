//! Material extensions: emissive_strength, ior, specular, transmission, volume, unlit.

use serde::Deserialize;

use super::document::{MaterialJson, TextureInfo};
use super::material_draft::{MaterialDraft, Reader, parse};
use super::specular_glossiness;
use crate::Volume;

/// Radiance beyond this is no physical light, and its square would leave the range of `f32`.
const MAX_EMISSION: f32 = 1e18;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct EmissiveStrength {
    emissive_strength: Option<f64>,
}

#[derive(Deserialize)]
struct Ior {
    ior: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Specular {
    specular_factor: Option<f64>,
    specular_texture: Option<TextureInfo>,
    specular_color_factor: Option<[f64; 3]>,
    specular_color_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Transmission {
    transmission_factor: Option<f64>,
    transmission_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct VolumeJson {
    thickness_factor: Option<f64>,
    attenuation_distance: Option<f64>,
    attenuation_color: Option<[f64; 3]>,
}

/// Adds the extensions of a material to its draft.
pub(crate) fn read(json: &MaterialJson, draft: &mut MaterialDraft, reader: &mut Reader) {
    let extensions = &json.extensions;
    let material = &mut draft.material;
    material.unlit = extensions.has("KHR_materials_unlit");

    if let Some(json) = parse::<EmissiveStrength>(extensions, "KHR_materials_emissive_strength", reader) {
        let strength = reader.factor(json.emissive_strength, 1.0, 0.0, MAX_EMISSION, "emissiveStrength");
        material.emissive = material.emissive.map(|factor| factor * strength);
    }
    if extensions.has(specular_glossiness::NAME) {
        // The two describe one thing in different ways and exclude each other.
        return;
    }
    if let Some(json) = parse::<Ior>(extensions, "KHR_materials_ior", reader) {
        // 0 is the extension's way to write an infinite index.
        material.ior = match json.ior {
            Some(0.0) => 0.0,
            other => reader.factor(other, 1.5, 1.0, 1e6, "ior"),
        };
    }
    if let Some(json) = parse::<Specular>(extensions, "KHR_materials_specular", reader) {
        material.specular = reader.factor(json.specular_factor, 1.0, 0.0, 1.0, "specularFactor");
        material.specular_color = reader.factors(json.specular_color_factor, [1.0; 3], 1e6, "specularColorFactor");
        draft.specular = reader.texture(json.specular_texture.as_ref());
        draft.specular_color = reader.texture(json.specular_color_texture.as_ref());
    }
    if let Some(json) = parse::<Transmission>(extensions, "KHR_materials_transmission", reader) {
        material.transmission = reader.factor(json.transmission_factor, 0.0, 0.0, 1.0, "transmissionFactor");
        draft.transmission = reader.texture(json.transmission_texture.as_ref());
    }
    if let Some(json) = parse::<VolumeJson>(extensions, "KHR_materials_volume", reader) {
        material.volume = volume(&json, reader);
    }
}

/// A thickness of 0 is a thin wall. Any other value states only that the mesh encloses a volume:
/// paths cross its geometry, and the thickness texture has no effect. The attenuation distance is
/// in world units, whatever the node's scale.
fn volume(json: &VolumeJson, reader: &mut Reader) -> Option<Volume> {
    let thickness = reader.factor(json.thickness_factor, 0.0, 0.0, f32::MAX, "thicknessFactor");
    let attenuation_color = reader.factors(json.attenuation_color, [1.0; 3], 1.0, "attenuationColor");
    let attenuation_distance = match json.attenuation_distance {
        Some(distance) if distance as f32 > 0.0 => distance as f32,
        Some(distance) => {
            let text = format!("attenuationDistance of {} is {distance}; the medium is clear.", reader.place);
            reader.warnings.push(text);
            f32::INFINITY
        }
        None => f32::INFINITY,
    };
    (thickness > 0.0).then_some(Volume { attenuation_distance, attenuation_color })
}
