//! A material's JSON: factors that differ from glTF's defaults, and the extensions that they need.

use glam::Affine2;

use super::document::*;
use super::layers::LayerExtensions;
use super::{GlbWriteError, split_strength};
use crate::{AlphaMode, Material, NormalTexture, TextureRef, Volume};

/// How far, relative to the scales, a texture transform's axes may be from perpendicular.
const SHEAR_TOLERANCE: f32 = 1e-5;

pub(super) fn entry(material: &Material) -> Result<MaterialEntry, GlbWriteError> {
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

/// Any thickness above 0 says "closed mesh" to a path tracer, which measures distances itself.
fn volume(volume: &Volume) -> VolumeEntry {
    VolumeEntry {
        thickness_factor: 1.0,
        attenuation_distance: volume.attenuation_distance.is_finite().then_some(volume.attenuation_distance),
        attenuation_color: volume.attenuation_color,
    }
}

pub(super) fn texture_info(texture: &TextureRef, material: &Material) -> Result<TextureInfo, GlbWriteError> {
    let extensions = match &texture.transform {
        Some(transform) => {
            let transform =
                texture_transform(transform).ok_or_else(|| GlbWriteError::Shear { material: material.name.clone() })?;
            Some(TextureInfoExtensions { transform })
        }
        None => None,
    };
    Ok(TextureInfo { index: texture.texture, tex_coord: texture.uv_set, scale: None, extensions })
}

/// A normal map with its strength.
pub(super) fn normal_info(
    normal: Option<&NormalTexture>,
    material: &Material,
) -> Result<Option<TextureInfo>, GlbWriteError> {
    let Some(normal) = normal else { return Ok(None) };
    let mut info = texture_info(&normal.texture, material)?;
    info.scale = (normal.scale != 1.0).then_some(normal.scale);
    Ok(Some(info))
}

/// Splits into KHR_texture_transform's offset, rotation and scale.
///
/// The extension's matrix is T·R·S with R = [cos, sin; −sin, cos] by rows (v points down, so that a positive angle
/// turns counter-clockwise as seen). `None` where the axes are not perpendicular.
fn texture_transform(transform: &Affine2) -> Option<TextureTransform> {
    let (x_axis, y_axis) = (transform.matrix2.x_axis, transform.matrix2.y_axis);
    let (sx, length_y) = (x_axis.length(), y_axis.length());
    if x_axis.dot(y_axis).abs() > SHEAR_TOLERANCE * sx * length_y {
        return None;
    }
    // x_axis = sx·(cos, −sin), y_axis = sy·(sin, cos); a mirror goes into the sign of sy.
    let rotation = if sx > 0.0 { (-x_axis.y).atan2(x_axis.x) } else { y_axis.x.atan2(y_axis.y) };
    let sy = if sx > 0.0 && x_axis.perp_dot(y_axis) < 0.0 { -length_y } else { length_y };
    Some(TextureTransform { offset: transform.translation.to_array(), rotation: rotation + 0.0, scale: [sx, sy] })
}
