//! Layers that extensions put on, into or behind a material's surface; each has no effect by
//! default.

use crate::texture::{NormalTexture, TextureRef};

/// KHR_materials_clearcoat: a colourless dielectric coat of index 1.5.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clearcoat {
    /// 0 none … 1 coated everywhere.
    pub factor: f32,
    /// R, linear.
    pub texture: Option<TextureRef>,
    /// Perceptual roughness of the coat.
    pub roughness: f32,
    /// G, linear.
    pub roughness_texture: Option<TextureRef>,
    /// The coat's own normal map; without it the coat follows the smooth surface, whatever the
    /// base's map.
    pub normal_texture: Option<NormalTexture>,
}

/// KHR_materials_sheen: a layer of fibres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Linear; black is no sheen.
    pub color: [f32; 3],
    /// RGB, sRGB.
    pub color_texture: Option<TextureRef>,
    /// Perceptual roughness: how far fibres stray from the normal.
    pub roughness: f32,
    /// A, linear.
    pub roughness_texture: Option<TextureRef>,
}

/// KHR_materials_anisotropy: facets that are rougher along one direction.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// 0 none … 1: along the direction α is 1.
    pub strength: f32,
    /// Radians, counter-clockwise from the tangent.
    pub rotation: f32,
    /// RG: direction in tangent space, from [0, 1] to [−1, 1]; B: strength; linear.
    pub texture: Option<TextureRef>,
}

/// KHR_materials_iridescence: a thin film whose interference colours the reflection.
#[derive(Clone, Debug, PartialEq)]
pub struct Iridescence {
    /// 0 none … 1.
    pub factor: f32,
    /// R, linear.
    pub texture: Option<TextureRef>,
    /// Index of refraction of the film, 1 or above.
    pub ior: f32,
    /// Nanometres where the texture is 0.
    pub thickness_minimum: f32,
    /// Nanometres where the texture is 1, and without one.
    pub thickness_maximum: f32,
    /// G, linear.
    pub thickness_texture: Option<TextureRef>,
}

impl Default for Iridescence {
    fn default() -> Self {
        Self {
            factor: 0.0,
            texture: None,
            ior: 1.3,
            thickness_minimum: 100.0,
            thickness_maximum: 400.0,
            thickness_texture: None,
        }
    }
}

/// KHR_materials_diffuse_transmission: a share of the Lambertian base that leaves on the other
/// side.
#[derive(Clone, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// 0 none … 1 all.
    pub factor: f32,
    /// A, linear.
    pub texture: Option<TextureRef>,
    /// Colour of transmitted light, linear; the base colour does not apply.
    pub color: [f32; 3],
    /// RGB, sRGB.
    pub color_texture: Option<TextureRef>,
}

impl Default for DiffuseTransmission {
    fn default() -> Self {
        Self { factor: 0.0, texture: None, color: [1.0; 3], color_texture: None }
    }
}
