//! A material between its JSON and its bound textures, and helpers for all readers of its parts.

use glam::Affine2;
use serde::de::DeserializeOwned;

use super::document::{Document, Extensions, TextureInfo};
use super::textures::{Binder, TextureLookup, lookup};
use super::warnings::Warnings;
use crate::{Material, NormalTexture};

/// A material before its textures are decoded.
#[derive(Debug, Default)]
pub(crate) struct MaterialDraft {
    /// Everything but the textures.
    pub(crate) material: Material,
    pub(crate) base_color: Option<TextureLookup>,
    pub(crate) metallic_roughness: Option<TextureLookup>,
    pub(crate) normal: Option<(TextureLookup, f32)>,
    pub(crate) emissive: Option<TextureLookup>,
    pub(crate) specular: Option<TextureLookup>,
    pub(crate) specular_color: Option<TextureLookup>,
    pub(crate) transmission: Option<TextureLookup>,
    /// Of the layers that extensions add.
    pub(crate) layers: LayerLookups,
    /// Glossiness in alpha and its factor: becomes `metallic_roughness`, whose lookup is then none.
    pub(crate) glossiness: Option<(TextureLookup, f32)>,
}

impl MaterialDraft {
    /// All texture lookups.
    pub(crate) fn lookups(&self) -> impl Iterator<Item = &TextureLookup> {
        [
            &self.base_color,
            &self.metallic_roughness,
            &self.emissive,
            &self.specular,
            &self.specular_color,
            &self.transmission,
        ]
        .into_iter()
        .flatten()
        .chain(self.normal.as_ref().map(|(lookup, _)| lookup))
        .chain(self.layers.lookups())
    }

    /// How many coordinate sets a mesh must carry: one more than the highest used.
    pub(crate) fn uv_sets(&self) -> usize {
        let looked_up = self.lookups().map(|l| l.uv_set as usize + 1).max().unwrap_or(0);
        self.tangent_space().map_or(looked_up, |(set, _)| looked_up.max(set as usize + 1))
    }

    /// The texture coordinates along which tangents are to run, where the material needs any: those
    /// of the normal map, then of the other maps that need tangents, then the first set.
    pub(crate) fn tangent_space(&self) -> Option<(u32, Option<Affine2>)> {
        let maps = [self.normal.as_ref(), self.layers.clearcoat_normal.as_ref()];
        let map = maps.into_iter().flatten().map(|(lookup, _)| lookup).next();
        let anisotropic = self.material.anisotropy.strength > 0.0;
        let lookup = map.or(self.layers.anisotropy.as_ref().filter(|_| anisotropic));
        lookup.map(|l| (l.uv_set, l.transform)).or(anisotropic.then_some((0, None)))
    }

    /// The material with its textures bound.
    pub(crate) fn bind(mut self, binder: &mut Binder) -> Material {
        let base_color_texture = binder.bind(self.base_color.as_ref());
        let mut metallic_roughness_texture = binder.bind(self.metallic_roughness.as_ref());
        if let Some((lookup, glossiness)) = &self.glossiness {
            metallic_roughness_texture = binder.bind_glossiness(lookup, *glossiness);
            if metallic_roughness_texture.is_some() {
                self.material.roughness = 1.0;
            }
        }
        self.layers.bind(&mut self.material, binder);
        Material {
            base_color_texture,
            metallic_roughness_texture,
            normal_texture: bind_normal(self.normal.as_ref(), binder),
            emissive_texture: binder.bind(self.emissive.as_ref()),
            specular_texture: binder.bind(self.specular.as_ref()),
            specular_color_texture: binder.bind(self.specular_color.as_ref()),
            transmission_texture: binder.bind(self.transmission.as_ref()),
            ..self.material
        }
    }
}

/// A normal map with its texture bound.
fn bind_normal(map: Option<&(TextureLookup, f32)>, binder: &mut Binder) -> Option<NormalTexture> {
    let (lookup, scale) = map?;
    Some(NormalTexture { texture: binder.bind(Some(lookup))?, scale: *scale })
}

/// Reads factors within their ranges and says where they were not.
pub(crate) struct Reader<'a> {
    pub(crate) document: &'a Document,
    /// `material 3 ("glass")`.
    pub(crate) place: String,
    pub(crate) warnings: &'a mut Warnings,
}

impl Reader<'_> {
    /// A factor, or its default; clamped to `[low, high]` with a warning.
    pub(crate) fn factor(&mut self, value: Option<f64>, default: f32, low: f32, high: f32, name: &str) -> f32 {
        let Some(value) = value else { return default };
        let clamped = value.clamp(f64::from(low), f64::from(high));
        if clamped != value {
            self.warnings.push(format!("{name} of {} is {value}; {clamped} is used.", self.place));
        }
        clamped as f32
    }

    /// The same for each component of a colour.
    pub(crate) fn factors<const N: usize>(
        &mut self,
        values: Option<[f64; N]>,
        default: [f32; N],
        high: f32,
        name: &str,
    ) -> [f32; N] {
        match values {
            Some(values) => values.map(|value| self.factor(Some(value), 0.0, 0.0, high, name)),
            None => default,
        }
    }

    /// A texture lookup, if the material has it and it leads somewhere.
    pub(crate) fn texture(&mut self, info: Option<&TextureInfo>) -> Option<TextureLookup> {
        lookup(self.document, info?, &self.place, self.warnings)
    }

    /// The same for a normal map and its strength.
    pub(crate) fn normal_map(&mut self, info: Option<&TextureInfo>) -> Option<(TextureLookup, f32)> {
        let scale = info?.scale.unwrap_or(1.0).clamp(-1e6, 1e6) as f32;
        self.texture(info).map(|lookup| (lookup, scale))
    }
}

/// Textures of the layers before they are decoded.
#[derive(Debug, Default)]
pub(crate) struct LayerLookups {
    pub(crate) clearcoat: Option<TextureLookup>,
    pub(crate) clearcoat_roughness: Option<TextureLookup>,
    pub(crate) clearcoat_normal: Option<(TextureLookup, f32)>,
    pub(crate) sheen_color: Option<TextureLookup>,
    pub(crate) sheen_roughness: Option<TextureLookup>,
    pub(crate) anisotropy: Option<TextureLookup>,
    pub(crate) iridescence: Option<TextureLookup>,
    pub(crate) iridescence_thickness: Option<TextureLookup>,
    pub(crate) diffuse_transmission: Option<TextureLookup>,
    pub(crate) diffuse_transmission_color: Option<TextureLookup>,
}

impl LayerLookups {
    pub(crate) fn lookups(&self) -> impl Iterator<Item = &TextureLookup> {
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

/// An extension's object as a type; a mistyped one is ignored with a warning.
pub(crate) fn parse<T: DeserializeOwned>(extensions: &Extensions, name: &str, reader: &mut Reader) -> Option<T> {
    match extensions.parse(name)? {
        Ok(value) => Some(value),
        Err(e) => {
            reader.warnings.push(format!("{name} of {} is ignored: {e}.", reader.place));
            None
        }
    }
}
