//! A material's JSON: factors that differ from glTF's defaults, and the extensions that they need.

use surelight_scene::{AlphaMode, Material, TextureRef, Volume};

use super::document::*;
use super::layers::LayerExtensions;
use super::texture_info::{TextureInfo, normal_info, texture_info};
use super::{EncodeError, split_strength};

pub(super) fn entry(material: &Material) -> Result<MaterialEntry, EncodeError> {
    let info = |texture: &Option<TextureRef>| texture.as_ref().map(|t| texture_info(t, material)).transpose();
    let (emissive_factor, strength) = split_strength(material.emissive);
    let (alpha_mode, alpha_cutoff) = match material.alpha_mode {
        AlphaMode::Opaque => (None, None),
        AlphaMode::Mask(cutoff) => (Some("MASK"), Some(cutoff)),
        AlphaMode::Blend => (Some("BLEND"), None),
    };
    let default = Material::default();
    let has_specular = material.specular != default.specular
        || material.specular_color != default.specular_color
        || material.specular_texture.is_some()
        || material.specular_color_texture.is_some();
    let has_transmission = material.transmission != 0.0 || material.transmission_texture.is_some();

    Ok(MaterialEntry {
        name: material.name.clone(),
        pbr_metallic_roughness: MetallicRoughness {
            base_color_factor: material.base_color,
            base_color_texture: info(&material.base_color_texture)?,
            metallic_factor: material.metallic,
            roughness_factor: material.roughness,
            metallic_roughness_texture: info(&material.metallic_roughness_texture)?,
        },
        normal_texture: normal_info(material.normal_texture.as_ref(), material)?,
        emissive_factor,
        emissive_texture: info(&material.emissive_texture)?,
        alpha_mode,
        alpha_cutoff,
        double_sided: material.double_sided,
        extensions: MaterialExtensions {
            emissive_strength: (strength != 1.0).then_some(EmissiveStrength { emissive_strength: strength }),
            ior: (material.ior != default.ior).then_some(Ior { ior: material.ior }),
            specular: if has_specular {
                Some(Specular {
                    specular_factor: material.specular,
                    specular_texture: info(&material.specular_texture)?,
                    specular_color_factor: material.specular_color,
                    specular_color_texture: info(&material.specular_color_texture)?,
                })
            } else {
                None
            },
            transmission: if has_transmission {
                Some(Transmission {
                    transmission_factor: material.transmission,
                    transmission_texture: info(&material.transmission_texture)?,
                })
            } else {
                None
            },
            unlit: material.unlit.then_some(Unlit {}),
            volume: material.volume.as_ref().map(volume),
            layers: LayerExtensions::of(material)?,
        },
    })
}

/// Every texture that a material names.
pub(super) fn texture_infos(m: &MaterialEntry) -> impl Iterator<Item = &TextureInfo> {
    let specular = m.extensions.specular.as_ref();
    [
        m.pbr_metallic_roughness.base_color_texture.as_ref(),
        m.pbr_metallic_roughness.metallic_roughness_texture.as_ref(),
        m.normal_texture.as_ref(),
        m.emissive_texture.as_ref(),
        specular.and_then(|s| s.specular_texture.as_ref()),
        specular.and_then(|s| s.specular_color_texture.as_ref()),
        m.extensions.transmission.as_ref().and_then(|t| t.transmission_texture.as_ref()),
    ]
    .into_iter()
    .flatten()
    .chain(m.extensions.layers.texture_infos())
}

/// Any thickness above 0 means "closed mesh" to a path tracer, which measures distances itself.
fn volume(volume: &Volume) -> VolumeEntry {
    VolumeEntry {
        thickness_factor: 1.0,
        attenuation_distance: volume.attenuation_distance.is_finite().then_some(volume.attenuation_distance),
        attenuation_color: volume.attenuation_color,
    }
}
