//! Materials: the core metallic-roughness model; [`super::material_extensions`] adds the rest.

use glam::Affine2;

use super::document::{Document, Int, MaterialJson, TextureInfo};
use super::material_extensions;
use super::material_layers::{self, LayerLookups};
use super::specular_glossiness;
use super::textures::{Binder, Lookup, lookup};
use super::warnings::Warnings;
use crate::{AlphaMode, Material, NormalTexture};

/// A material before its textures are decoded.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    /// Everything but the textures.
    pub(crate) material: Material,
    pub(crate) base_color: Option<Lookup>,
    pub(crate) metallic_roughness: Option<Lookup>,
    pub(crate) normal: Option<(Lookup, f32)>,
    pub(crate) emissive: Option<Lookup>,
    pub(crate) specular: Option<Lookup>,
    pub(crate) specular_color: Option<Lookup>,
    pub(crate) transmission: Option<Lookup>,
    /// Of the layers that extensions add.
    pub(crate) layers: LayerLookups,
    /// Glossiness in alpha and its factor: becomes `metallic_roughness`, whose lookup is then none.
    pub(crate) glossiness: Option<(Lookup, f32)>,
}

impl Draft {
    /// All texture lookups.
    pub(crate) fn lookups(&self) -> impl Iterator<Item = &Lookup> {
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

    /// The texture coordinates along which tangents are to run, where the material needs any: those of the normal map, then
    /// of the other maps that speak of tangents, then the first set.
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
pub(crate) fn bind_normal(map: Option<&(Lookup, f32)>, binder: &mut Binder) -> Option<NormalTexture> {
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
    pub(crate) fn texture(&mut self, info: Option<&TextureInfo>) -> Option<Lookup> {
        lookup(self.document, info?, &self.place, self.warnings)
    }

    /// The same for a normal map and its strength.
    pub(crate) fn normal_map(&mut self, info: Option<&TextureInfo>) -> Option<(Lookup, f32)> {
        let scale = info?.scale.unwrap_or(1.0).clamp(-1e6, 1e6) as f32;
        self.texture(info).map(|lookup| (lookup, scale))
    }
}

/// Reads material `index`, which must be in range.
pub(crate) fn read(document: &Document, index: usize, warnings: &mut Warnings) -> Draft {
    let Some(json) = document.materials.get(index) else {
        return Draft::default();
    };
    let place = match &json.name {
        Some(name) => format!("material {index} ({name:?})"),
        None => format!("material {index}"),
    };
    let mut reader = Reader { document, place, warnings };
    let mut draft = core(json, &mut reader);
    specular_glossiness::read(json, &mut draft, &mut reader);
    material_extensions::read(json, &mut draft, &mut reader);
    material_layers::read(json, &mut draft, &mut reader);
    draft
}

fn core(json: &MaterialJson, reader: &mut Reader) -> Draft {
    let pbr = &json.pbr_metallic_roughness;
    let material = Material {
        name: json.name.clone().unwrap_or_default(),
        base_color: reader.factors(pbr.base_color_factor, [1.0; 4], 1.0, "baseColorFactor"),
        metallic: reader.factor(pbr.metallic_factor, 1.0, 0.0, 1.0, "metallicFactor"),
        roughness: reader.factor(pbr.roughness_factor, 1.0, 0.0, 1.0, "roughnessFactor"),
        emissive: reader.factors(json.emissive_factor, [0.0; 3], 1.0, "emissiveFactor"),
        alpha_mode: alpha_mode(json, reader),
        double_sided: json.double_sided,
        ..Material::default()
    };
    Draft {
        base_color: reader.texture(pbr.base_color_texture.as_ref()),
        metallic_roughness: reader.texture(pbr.metallic_roughness_texture.as_ref()),
        normal: reader.normal_map(json.normal_texture.as_ref()),
        emissive: reader.texture(json.emissive_texture.as_ref()),
        material,
        ..Draft::default()
    }
}

fn alpha_mode(json: &MaterialJson, reader: &mut Reader) -> AlphaMode {
    match json.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        // A cutoff above 1 is allowed and hides everything.
        Some("MASK") => AlphaMode::Mask(reader.factor(json.alpha_cutoff, 0.5, 0.0, f32::MAX, "alphaCutoff")),
        Some("BLEND") => AlphaMode::Blend,
        Some(other) => {
            let text = format!("alphaMode of {} is {other:?}, which is unknown; it is drawn opaque.", reader.place);
            reader.warnings.push(text);
            AlphaMode::Opaque
        }
    }
}

/// The index of a primitive's material, or `None` for the default one; an index out of range is a warning.
pub(crate) fn index_of(
    document: &Document,
    material: Option<Int>,
    place: &str,
    warnings: &mut Warnings,
) -> Option<usize> {
    let index = material?.index();
    if index < document.materials.len() {
        return Some(index);
    }
    let fault = super::error::Fault::no_such(place, "material", index, document.materials.len());
    warnings.push(format!("The default material is used: {}.", fault.reason()));
    None
}
