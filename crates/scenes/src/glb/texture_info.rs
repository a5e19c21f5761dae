//! How a material's JSON names a texture.

use glam::Affine2;
use serde::Serialize;
use surelight_scene::{Material, NormalTexture, TextureRef};

use super::EncodeError;

/// How far, relative to the scales, a texture transform's axes may be from perpendicular.
const SHEAR_TOLERANCE: f32 = 1e-5;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct TextureInfo {
    pub(super) index: usize,
    #[serde(skip_serializing_if = "is_zero")]
    pub(super) tex_coord: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) scale: Option<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extensions: Option<TextureInfoExtensions>,
}

#[derive(Serialize)]
pub(super) struct TextureInfoExtensions {
    #[serde(rename = "KHR_texture_transform")]
    pub(super) transform: TextureTransform,
}

#[derive(Serialize)]
pub(super) struct TextureTransform {
    pub(super) offset: [f32; 2],
    pub(super) rotation: f32,
    pub(super) scale: [f32; 2],
}

pub(super) fn texture_info(texture: &TextureRef, material: &Material) -> Result<TextureInfo, EncodeError> {
    let extensions = match &texture.transform {
        Some(transform) => {
            let transform =
                texture_transform(transform).ok_or_else(|| EncodeError::Shear { material: material.name.clone() })?;
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
) -> Result<Option<TextureInfo>, EncodeError> {
    let Some(normal) = normal else { return Ok(None) };
    let mut info = texture_info(&normal.texture, material)?;
    info.scale = (normal.scale != 1.0).then_some(normal.scale);
    Ok(Some(info))
}

/// Splits into KHR_texture_transform's offset, rotation and scale.
///
/// The extension's matrix is T·R·S with R = [cos, sin; −sin, cos] by rows (v points down, so that a
/// positive angle turns counter-clockwise in the image). `None` where the axes are not
/// perpendicular.
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

fn is_zero(x: &u32) -> bool {
    *x == 0
}
