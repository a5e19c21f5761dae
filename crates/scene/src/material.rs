use crate::layers::{Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Sheen};
use crate::texture::{NormalTexture, TextureRef};

/// A glTF metallic-roughness material with the supported extensions, by their glTF names and
/// defaults.
///
/// Factors are inside the ranges that glTF states; textures multiply them.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name; empty when the file gives none.
    pub name: String,
    /// Linear base colour and alpha.
    pub base_color: [f32; 4],
    /// sRGB colour, linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric … 1 metal.
    pub metallic: f32,
    /// Perceptual roughness; the GGX α is its square.
    pub roughness: f32,
    /// G: roughness, B: metallic, linear.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Tangent-space normal map.
    pub normal_texture: Option<NormalTexture>,
    /// Emissive factor × KHR_materials_emissive_strength: radiance, nit.
    pub emissive: [f32; 3],
    /// sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// The meaning of alpha.
    pub alpha_mode: AlphaMode,
    /// Visible from both sides. One-sided surfaces still reflect on both, but emit from the front
    /// alone.
    pub double_sided: bool,
    /// KHR_materials_unlit: base colour is shown as it is, and lights nothing.
    pub unlit: bool,
    /// KHR_materials_ior; 0 means "infinite" (Fresnel is 1 everywhere) as the extension says.
    pub ior: f32,
    /// KHR_materials_specular: strength of the dielectric reflection.
    pub specular: f32,
    /// A: strength, linear.
    pub specular_texture: Option<TextureRef>,
    /// KHR_materials_specular: F0 tint, linear; may exceed 1.
    pub specular_color: [f32; 3],
    /// RGB, sRGB.
    pub specular_color_texture: Option<TextureRef>,
    /// KHR_materials_transmission: share of the diffuse lobe that is transmitted instead.
    pub transmission: f32,
    /// R, linear.
    pub transmission_texture: Option<TextureRef>,
    /// KHR_materials_volume with a thickness above 0; `None` is a thin wall.
    pub volume: Option<Volume>,
    /// KHR_materials_dispersion: 20 over the Abbe number; 0 is none.
    pub dispersion: f32,
    /// KHR_materials_clearcoat.
    pub clearcoat: Clearcoat,
    /// KHR_materials_sheen.
    pub sheen: Sheen,
    /// KHR_materials_anisotropy.
    pub anisotropy: Anisotropy,
    /// KHR_materials_iridescence.
    pub iridescence: Iridescence,
    /// KHR_materials_diffuse_transmission.
    pub diffuse_transmission: DiffuseTransmission,
}

/// A homogeneous absorbing medium inside a closed mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// Metres (world) after which white light has become `attenuation_color`; infinite for a clear
    /// medium.
    pub attenuation_distance: f32,
    /// Linear.
    pub attenuation_color: [f32; 3],
}

/// The effect of a material's alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AlphaMode {
    /// Nothing.
    Opaque,
    /// Below the cutoff there is no surface.
    Mask(f32),
    /// Alpha is the share of the surface that is there (stochastic coverage).
    Blend,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
            ior: 1.5,
            specular: 1.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            dispersion: 0.0,
            clearcoat: Clearcoat::default(),
            sheen: Sheen::default(),
            anisotropy: Anisotropy::default(),
            iridescence: Iridescence::default(),
            diffuse_transmission: DiffuseTransmission::default(),
        }
    }
}

impl Material {
    /// Every place for a texture, by name.
    pub(crate) fn textures(&self) -> [(&'static str, Option<&TextureRef>); 17] {
        [
            ("base color", self.base_color_texture.as_ref()),
            ("metallic-roughness", self.metallic_roughness_texture.as_ref()),
            ("normal", self.normal_texture.as_ref().map(|n| &n.texture)),
            ("emissive", self.emissive_texture.as_ref()),
            ("specular", self.specular_texture.as_ref()),
            ("specular color", self.specular_color_texture.as_ref()),
            ("transmission", self.transmission_texture.as_ref()),
            ("clearcoat", self.clearcoat.texture.as_ref()),
            ("clearcoat roughness", self.clearcoat.roughness_texture.as_ref()),
            ("clearcoat normal", self.clearcoat.normal_texture.as_ref().map(|n| &n.texture)),
            ("sheen color", self.sheen.color_texture.as_ref()),
            ("sheen roughness", self.sheen.roughness_texture.as_ref()),
            ("anisotropy", self.anisotropy.texture.as_ref()),
            ("iridescence", self.iridescence.texture.as_ref()),
            ("iridescence thickness", self.iridescence.thickness_texture.as_ref()),
            ("diffuse transmission", self.diffuse_transmission.texture.as_ref()),
            ("diffuse transmission color", self.diffuse_transmission.color_texture.as_ref()),
        ]
    }

    /// Whether any light can leave the surface by itself (unlit ones are excluded: they light
    /// nothing).
    pub fn is_emissive(&self) -> bool {
        !self.unlit && self.emissive.iter().any(|&c| c > 0.0)
    }
}
