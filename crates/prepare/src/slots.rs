//! Where a material can have a texture.

use surelight_scene::{Material, TextureRef};

use super::lobes::{has_diffuse_transmission, has_facets, has_film, has_sheen, is_anisotropic, is_coated};
use crate::kernel_key::Part;

/// A texture's place in a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Emissive,
    Specular,
    SpecularColor,
    Transmission,
    Clearcoat,
    ClearcoatRoughness,
    ClearcoatNormal,
    SheenColor,
    SheenRoughness,
    Anisotropy,
    Iridescence,
    IridescenceThickness,
    DiffuseTransmission,
    DiffuseTransmissionColor,
}

impl Slot {
    /// All of them, in the order of their declaration.
    pub(crate) const ALL: [Self; 17] = [
        Self::BaseColor,
        Self::MetallicRoughness,
        Self::Normal,
        Self::Emissive,
        Self::Specular,
        Self::SpecularColor,
        Self::Transmission,
        Self::Clearcoat,
        Self::ClearcoatRoughness,
        Self::ClearcoatNormal,
        Self::SheenColor,
        Self::SheenRoughness,
        Self::Anisotropy,
        Self::Iridescence,
        Self::IridescenceThickness,
        Self::DiffuseTransmission,
        Self::DiffuseTransmissionColor,
    ];

    /// Whether the kernel may sample it, the texture, and whether its colours are sRGB.
    pub(super) fn of(self, m: &Material) -> (bool, Option<&TextureRef>, bool) {
        let shaded = !m.unlit;
        let facets = has_facets(m);
        let rough = facets && (m.roughness > 0.0 || m.metallic > 0.0);
        let (coat, sheen) = (&m.clearcoat, &m.sheen);
        match self {
            Self::BaseColor => (true, m.base_color_texture.as_ref(), true),
            Self::MetallicRoughness => (rough, m.metallic_roughness_texture.as_ref(), false),
            Self::Normal => (shaded, m.normal_texture.as_ref().map(|n| &n.texture), false),
            Self::Emissive => (m.is_emissive(), m.emissive_texture.as_ref(), true),
            Self::Specular => (facets && m.specular > 0.0, m.specular_texture.as_ref(), false),
            Self::SpecularColor => (facets && m.specular > 0.0, m.specular_color_texture.as_ref(), true),
            Self::Transmission => (shaded && m.transmission > 0.0, m.transmission_texture.as_ref(), false),
            Self::Clearcoat => (is_coated(m), coat.texture.as_ref(), false),
            Self::ClearcoatRoughness => (is_coated(m) && coat.roughness > 0.0, coat.roughness_texture.as_ref(), false),
            Self::ClearcoatNormal => (is_coated(m), coat.normal_texture.as_ref().map(|n| &n.texture), false),
            Self::SheenColor => (has_sheen(m), sheen.color_texture.as_ref(), true),
            Self::SheenRoughness => (has_sheen(m) && sheen.roughness > 0.0, sheen.roughness_texture.as_ref(), false),
            Self::Anisotropy => (is_anisotropic(m), m.anisotropy.texture.as_ref(), false),
            Self::Iridescence => (has_film(m), m.iridescence.texture.as_ref(), false),
            Self::IridescenceThickness => (has_film(m), m.iridescence.thickness_texture.as_ref(), false),
            Self::DiffuseTransmission => (has_diffuse_transmission(m), m.diffuse_transmission.texture.as_ref(), false),
            Self::DiffuseTransmissionColor => {
                (has_diffuse_transmission(m), m.diffuse_transmission.color_texture.as_ref(), true)
            }
        }
    }

    /// Its field in the kernel's material record.
    pub(super) fn field(self) -> &'static str {
        match self {
            Self::BaseColor => "base_color_texture",
            Self::MetallicRoughness => "metallic_roughness_texture",
            Self::Normal => "normal_texture",
            Self::Emissive => "emissive_texture",
            Self::Specular => "specular_texture",
            Self::SpecularColor => "specular_color_texture",
            Self::Transmission => "transmission_texture",
            Self::Clearcoat => "coat_texture",
            Self::ClearcoatRoughness => "coat_roughness_texture",
            Self::ClearcoatNormal => "coat_normal_texture",
            Self::SheenColor => "sheen_color_texture",
            Self::SheenRoughness => "sheen_roughness_texture",
            Self::Anisotropy => "anisotropy_texture",
            Self::Iridescence => "film_texture",
            Self::IridescenceThickness => "film_thickness_texture",
            Self::DiffuseTransmission => "diffuse_transmission_texture",
            Self::DiffuseTransmissionColor => "through_color_texture",
        }
    }

    /// The part of the kernel that samples it.
    pub(super) fn part(self) -> Part {
        match self {
            Self::BaseColor => Part::BaseColorTexture,
            Self::MetallicRoughness => Part::MetallicRoughnessTexture,
            Self::Normal => Part::NormalTexture,
            Self::Emissive => Part::EmissiveTexture,
            Self::Specular => Part::SpecularTexture,
            Self::SpecularColor => Part::SpecularColorTexture,
            Self::Transmission => Part::TransmissionTexture,
            Self::Clearcoat => Part::ClearcoatTexture,
            Self::ClearcoatRoughness => Part::ClearcoatRoughnessTexture,
            Self::ClearcoatNormal => Part::ClearcoatNormalTexture,
            Self::SheenColor => Part::SheenColorTexture,
            Self::SheenRoughness => Part::SheenRoughnessTexture,
            Self::Anisotropy => Part::AnisotropyTexture,
            Self::Iridescence => Part::IridescenceTexture,
            Self::IridescenceThickness => Part::IridescenceThicknessTexture,
            Self::DiffuseTransmission => Part::DiffuseTransmissionTexture,
            Self::DiffuseTransmissionColor => Part::DiffuseTransmissionColorTexture,
        }
    }
}
