//! JSON of the extensions that add layers and lobes to a material.

use serde::Serialize;
use surelight_scene::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Sheen, TextureRef};

use super::EncodeError;
use super::texture_info::{TextureInfo, normal_info, texture_info};

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ClearcoatEntry {
    clearcoat_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    clearcoat_texture: Option<TextureInfo>,
    clearcoat_roughness_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    clearcoat_roughness_texture: Option<TextureInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    clearcoat_normal_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct SheenEntry {
    sheen_color_factor: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    sheen_color_texture: Option<TextureInfo>,
    sheen_roughness_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    sheen_roughness_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct AnisotropyEntry {
    anisotropy_strength: f32,
    anisotropy_rotation: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    anisotropy_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct IridescenceEntry {
    iridescence_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    iridescence_texture: Option<TextureInfo>,
    iridescence_ior: f32,
    iridescence_thickness_minimum: f32,
    iridescence_thickness_maximum: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    iridescence_thickness_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
pub(super) struct DispersionEntry {
    dispersion: f32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct DiffuseTransmissionEntry {
    diffuse_transmission_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    diffuse_transmission_texture: Option<TextureInfo>,
    diffuse_transmission_color_factor: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    diffuse_transmission_color_texture: Option<TextureInfo>,
}

/// All of them, by their names in the file.
#[derive(Default, Serialize)]
pub(super) struct LayerExtensions {
    #[serde(rename = "KHR_materials_anisotropy", skip_serializing_if = "Option::is_none")]
    anisotropy: Option<AnisotropyEntry>,
    #[serde(rename = "KHR_materials_clearcoat", skip_serializing_if = "Option::is_none")]
    clearcoat: Option<ClearcoatEntry>,
    #[serde(rename = "KHR_materials_diffuse_transmission", skip_serializing_if = "Option::is_none")]
    diffuse_transmission: Option<DiffuseTransmissionEntry>,
    #[serde(rename = "KHR_materials_dispersion", skip_serializing_if = "Option::is_none")]
    dispersion: Option<DispersionEntry>,
    #[serde(rename = "KHR_materials_iridescence", skip_serializing_if = "Option::is_none")]
    iridescence: Option<IridescenceEntry>,
    #[serde(rename = "KHR_materials_sheen", skip_serializing_if = "Option::is_none")]
    sheen: Option<SheenEntry>,
}

impl LayerExtensions {
    /// Those that the material sets.
    pub(super) fn of(m: &Material) -> Result<Self, EncodeError> {
        let info = |texture: &Option<TextureRef>| texture.as_ref().map(|t| texture_info(t, m)).transpose();
        let mut all = Self::default();
        if m.clearcoat != Clearcoat::default() {
            all.clearcoat = Some(ClearcoatEntry {
                clearcoat_factor: m.clearcoat.factor,
                clearcoat_texture: info(&m.clearcoat.texture)?,
                clearcoat_roughness_factor: m.clearcoat.roughness,
                clearcoat_roughness_texture: info(&m.clearcoat.roughness_texture)?,
                clearcoat_normal_texture: normal_info(m.clearcoat.normal_texture.as_ref(), m)?,
            });
        }
        if m.sheen != Sheen::default() {
            all.sheen = Some(SheenEntry {
                sheen_color_factor: m.sheen.color,
                sheen_color_texture: info(&m.sheen.color_texture)?,
                sheen_roughness_factor: m.sheen.roughness,
                sheen_roughness_texture: info(&m.sheen.roughness_texture)?,
            });
        }
        if m.anisotropy != Anisotropy::default() {
            all.anisotropy = Some(AnisotropyEntry {
                anisotropy_strength: m.anisotropy.strength,
                anisotropy_rotation: m.anisotropy.rotation,
                anisotropy_texture: info(&m.anisotropy.texture)?,
            });
        }
        if m.iridescence != Iridescence::default() {
            all.iridescence = Some(IridescenceEntry {
                iridescence_factor: m.iridescence.factor,
                iridescence_texture: info(&m.iridescence.texture)?,
                iridescence_ior: m.iridescence.ior,
                iridescence_thickness_minimum: m.iridescence.thickness_minimum,
                iridescence_thickness_maximum: m.iridescence.thickness_maximum,
                iridescence_thickness_texture: info(&m.iridescence.thickness_texture)?,
            });
        }
        all.dispersion = (m.dispersion != 0.0).then_some(DispersionEntry { dispersion: m.dispersion });
        if m.diffuse_transmission != DiffuseTransmission::default() {
            all.diffuse_transmission = Some(DiffuseTransmissionEntry {
                diffuse_transmission_factor: m.diffuse_transmission.factor,
                diffuse_transmission_texture: info(&m.diffuse_transmission.texture)?,
                diffuse_transmission_color_factor: m.diffuse_transmission.color,
                diffuse_transmission_color_texture: info(&m.diffuse_transmission.color_texture)?,
            });
        }
        Ok(all)
    }

    /// Names of the extensions that are there, in alphabetical order.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        [
            self.anisotropy.as_ref().map(|_| "KHR_materials_anisotropy"),
            self.clearcoat.as_ref().map(|_| "KHR_materials_clearcoat"),
            self.diffuse_transmission.as_ref().map(|_| "KHR_materials_diffuse_transmission"),
            self.dispersion.as_ref().map(|_| "KHR_materials_dispersion"),
            self.iridescence.as_ref().map(|_| "KHR_materials_iridescence"),
            self.sheen.as_ref().map(|_| "KHR_materials_sheen"),
        ]
        .into_iter()
        .flatten()
    }

    /// Every texture that they name.
    pub(super) fn texture_infos(&self) -> impl Iterator<Item = &TextureInfo> {
        let (coat, sheen) = (self.clearcoat.as_ref(), self.sheen.as_ref());
        let (film, diffuse) = (self.iridescence.as_ref(), self.diffuse_transmission.as_ref());
        [
            coat.and_then(|c| c.clearcoat_texture.as_ref()),
            coat.and_then(|c| c.clearcoat_roughness_texture.as_ref()),
            coat.and_then(|c| c.clearcoat_normal_texture.as_ref()),
            sheen.and_then(|s| s.sheen_color_texture.as_ref()),
            sheen.and_then(|s| s.sheen_roughness_texture.as_ref()),
            self.anisotropy.as_ref().and_then(|a| a.anisotropy_texture.as_ref()),
            film.and_then(|i| i.iridescence_texture.as_ref()),
            film.and_then(|i| i.iridescence_thickness_texture.as_ref()),
            diffuse.and_then(|d| d.diffuse_transmission_texture.as_ref()),
            diffuse.and_then(|d| d.diffuse_transmission_color_texture.as_ref()),
        ]
        .into_iter()
        .flatten()
    }
}
