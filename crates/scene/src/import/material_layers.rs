//! Material extensions that add layers and lobes: clearcoat, sheen, anisotropy, iridescence,
//! dispersion, diffuse_transmission.

use serde::Deserialize;

use super::document::{MaterialJson, TextureInfo};
use super::material_draft::{MaterialDraft, Reader, parse};
use super::specular_glossiness;
use crate::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Sheen};

/// Films thicker than this show no colours, and phases would lose their digits.
const MAX_NANOMETRES: f32 = 1e6;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct ClearcoatJson {
    clearcoat_factor: Option<f64>,
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: Option<f64>,
    clearcoat_roughness_texture: Option<TextureInfo>,
    clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SheenJson {
    sheen_color_factor: Option<[f64; 3]>,
    sheen_color_texture: Option<TextureInfo>,
    sheen_roughness_factor: Option<f64>,
    sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct AnisotropyJson {
    anisotropy_strength: Option<f64>,
    anisotropy_rotation: Option<f64>,
    anisotropy_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct IridescenceJson {
    iridescence_factor: Option<f64>,
    iridescence_texture: Option<TextureInfo>,
    iridescence_ior: Option<f64>,
    iridescence_thickness_minimum: Option<f64>,
    iridescence_thickness_maximum: Option<f64>,
    iridescence_thickness_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
struct DispersionJson {
    dispersion: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct DiffuseTransmissionJson {
    diffuse_transmission_factor: Option<f64>,
    diffuse_transmission_texture: Option<TextureInfo>,
    diffuse_transmission_color_factor: Option<[f64; 3]>,
    diffuse_transmission_color_texture: Option<TextureInfo>,
}

/// Adds the layers of a material to its draft. They are excluded beside specular-glossiness, as its
/// specification demands.
pub(crate) fn read(json: &MaterialJson, draft: &mut MaterialDraft, reader: &mut Reader) {
    let extensions = &json.extensions;
    if extensions.has(specular_glossiness::NAME) {
        return;
    }
    let material = &mut draft.material;
    let layers = &mut draft.layers;
    if let Some(json) = parse::<ClearcoatJson>(extensions, "KHR_materials_clearcoat", reader) {
        material.clearcoat = Clearcoat {
            factor: reader.factor(json.clearcoat_factor, 0.0, 0.0, 1.0, "clearcoatFactor"),
            roughness: reader.factor(json.clearcoat_roughness_factor, 0.0, 0.0, 1.0, "clearcoatRoughnessFactor"),
            ..Clearcoat::default()
        };
        layers.clearcoat = reader.texture(json.clearcoat_texture.as_ref());
        layers.clearcoat_roughness = reader.texture(json.clearcoat_roughness_texture.as_ref());
        layers.clearcoat_normal = reader.normal_map(json.clearcoat_normal_texture.as_ref());
    }
    if let Some(json) = parse::<SheenJson>(extensions, "KHR_materials_sheen", reader) {
        material.sheen = Sheen {
            color: reader.factors(json.sheen_color_factor, [0.0; 3], 1.0, "sheenColorFactor"),
            roughness: reader.factor(json.sheen_roughness_factor, 0.0, 0.0, 1.0, "sheenRoughnessFactor"),
            ..Sheen::default()
        };
        layers.sheen_color = reader.texture(json.sheen_color_texture.as_ref());
        layers.sheen_roughness = reader.texture(json.sheen_roughness_texture.as_ref());
    }
    if let Some(json) = parse::<AnisotropyJson>(extensions, "KHR_materials_anisotropy", reader) {
        material.anisotropy = Anisotropy {
            strength: reader.factor(json.anisotropy_strength, 0.0, 0.0, 1.0, "anisotropyStrength"),
            rotation: reader.factor(json.anisotropy_rotation, 0.0, -1e4, 1e4, "anisotropyRotation"),
            texture: None,
        };
        layers.anisotropy = reader.texture(json.anisotropy_texture.as_ref());
    }
    if let Some(json) = parse::<IridescenceJson>(extensions, "KHR_materials_iridescence", reader) {
        let default = Iridescence::default();
        let mut thickness = |value, default, name| reader.factor(value, default, 0.0, MAX_NANOMETRES, name);
        let minimum =
            thickness(json.iridescence_thickness_minimum, default.thickness_minimum, "iridescenceThicknessMinimum");
        let maximum =
            thickness(json.iridescence_thickness_maximum, default.thickness_maximum, "iridescenceThicknessMaximum");
        material.iridescence = Iridescence {
            factor: reader.factor(json.iridescence_factor, 0.0, 0.0, 1.0, "iridescenceFactor"),
            ior: reader.factor(json.iridescence_ior, default.ior, 1.0, 100.0, "iridescenceIor"),
            thickness_minimum: minimum,
            thickness_maximum: maximum,
            ..default
        };
        layers.iridescence = reader.texture(json.iridescence_texture.as_ref());
        layers.iridescence_thickness = reader.texture(json.iridescence_thickness_texture.as_ref());
    }
    if let Some(json) = parse::<DispersionJson>(extensions, "KHR_materials_dispersion", reader) {
        material.dispersion = reader.factor(json.dispersion, 0.0, 0.0, 1e3, "dispersion");
    }
    if let Some(json) = parse::<DiffuseTransmissionJson>(extensions, "KHR_materials_diffuse_transmission", reader) {
        let color = json.diffuse_transmission_color_factor;
        material.diffuse_transmission = DiffuseTransmission {
            factor: reader.factor(json.diffuse_transmission_factor, 0.0, 0.0, 1.0, "diffuseTransmissionFactor"),
            color: reader.factors(color, [1.0; 3], 1.0, "diffuseTransmissionColorFactor"),
            ..DiffuseTransmission::default()
        };
        layers.diffuse_transmission = reader.texture(json.diffuse_transmission_texture.as_ref());
        layers.diffuse_transmission_color = reader.texture(json.diffuse_transmission_color_texture.as_ref());
    }
}
