//! Material extensions that add layers and lobes: clearcoat, sheen, anisotropy, iridescence, dispersion, diffuse_transmission.

use serde::Deserialize;

use super::document::{MaterialJson, TextureInfo};
use super::material_extensions::parse;
use super::materials::{Draft, Reader, bind_normal};
use super::specular_glossiness;
use super::textures::{Binder, Lookup};
use crate::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Sheen};

/// Films thicker than this show no colours, and phases would lose their digits.
const MOST_NANOMETRES: f32 = 1e6;

/// Textures of the layers before they are decoded.
#[derive(Debug, Default)]
pub(crate) struct LayerLookups {
    clearcoat: Option<Lookup>,
    clearcoat_roughness: Option<Lookup>,
    pub(crate) clearcoat_normal: Option<(Lookup, f32)>,
    sheen_color: Option<Lookup>,
    sheen_roughness: Option<Lookup>,
    pub(crate) anisotropy: Option<Lookup>,
    iridescence: Option<Lookup>,
    iridescence_thickness: Option<Lookup>,
    diffuse_transmission: Option<Lookup>,
    diffuse_transmission_color: Option<Lookup>,
}

impl LayerLookups {
    pub(crate) fn lookups(&self) -> impl Iterator<Item = &Lookup> {
        [
            &self.clearcoat,
            &self.clearcoat_roughness,
            &self.sheen_color,
            &self.sheen_roughness,
            &self.anisotropy,
            &self.iridescence,
            &self.iridescence_thickness,
            &self.diffuse_transmission,
            &self.diffuse_transmission_color,
        ]
        .into_iter()
        .flatten()
        .chain(self.clearcoat_normal.as_ref().map(|(lookup, _)| lookup))
    }

    /// Puts the bound textures into the material.
    pub(crate) fn bind(&self, material: &mut Material, binder: &mut Binder) {
        material.clearcoat.texture = binder.bind(self.clearcoat.as_ref());
        material.clearcoat.roughness_texture = binder.bind(self.clearcoat_roughness.as_ref());
        material.clearcoat.normal_texture = bind_normal(self.clearcoat_normal.as_ref(), binder);
        material.sheen.color_texture = binder.bind(self.sheen_color.as_ref());
        material.sheen.roughness_texture = binder.bind(self.sheen_roughness.as_ref());
        material.anisotropy.texture = binder.bind(self.anisotropy.as_ref());
        material.iridescence.texture = binder.bind(self.iridescence.as_ref());
        material.iridescence.thickness_texture = binder.bind(self.iridescence_thickness.as_ref());
        material.diffuse_transmission.texture = binder.bind(self.diffuse_transmission.as_ref());
        material.diffuse_transmission.color_texture = binder.bind(self.diffuse_transmission_color.as_ref());
    }
}

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

/// Adds the layers of a material to its draft. They are not to stand beside specular-glossiness, whose texts exclude them.
pub(crate) fn read(json: &MaterialJson, draft: &mut Draft, reader: &mut Reader) {
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
        let mut thickness = |value, default, name| reader.factor(value, default, 0.0, MOST_NANOMETRES, name);
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
