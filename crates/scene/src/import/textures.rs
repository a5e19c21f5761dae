//! Textures: an image with a sampler, and its use by a material.

use std::collections::{BTreeSet, HashMap};

use glam::{Affine2, Vec2};
use gltf::json::texture::{CLAMP_TO_EDGE, MIRRORED_REPEAT, NEAREST, REPEAT};
use serde::Deserialize;

use super::document::{Document, Int, TextureInfo, get};
use super::images::Decoded;
use super::warnings::Warnings;
use crate::{Filter, Image, Texture, TextureRef, Wrap};

/// Coordinate sets above this are refused: every vertex would carry them all.
pub(crate) const MAX_UV_SETS: u64 = 8;

/// A texture reference of a material with everything but its final index.
#[derive(Clone, Debug)]
pub(crate) struct TextureLookup {
    /// glTF texture index, in range.
    texture: usize,
    pub(crate) uv_set: u32,
    pub(crate) transform: Option<Affine2>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TransformJson {
    #[serde(default)]
    offset: [f32; 2],
    #[serde(default)]
    rotation: f32,
    scale: Option<[f32; 2]>,
    tex_coord: Option<Int>,
}

/// Reads a textureInfo with its KHR_texture_transform; `None`, with a warning, when it leads
/// nowhere.
pub(crate) fn lookup(
    document: &Document,
    info: &TextureInfo,
    place: &str,
    warnings: &mut Warnings,
) -> Option<TextureLookup> {
    let Some(index) = info.index else {
        warnings.push(format!("A texture is left out: {place} does not say which."));
        return None;
    };
    if let Err(fault) = get(&document.textures, index, "texture", place) {
        warnings.push(format!("A texture is left out: {}.", fault.reason()));
        return None;
    }
    let mut uv_set = info.tex_coord;
    let mut transform = None;
    if let Some(parsed) = info.extensions.parse::<TransformJson>("KHR_texture_transform") {
        match parsed {
            Ok(json) => {
                uv_set = json.tex_coord.unwrap_or(uv_set);
                transform = affine(&json);
                if !transform.is_none_or(is_in_range) {
                    warnings.push(format!(
                        "KHR_texture_transform of {place} is not finite or absurdly large; it is ignored."
                    ));
                    transform = None;
                }
            }
            Err(e) => warnings.push(format!("KHR_texture_transform of {place} is ignored: {e}.")),
        }
    }
    if uv_set.0 >= MAX_UV_SETS {
        warnings.push(format!(
            "A texture of {place} is left out: it uses TEXCOORD_{}, and sets up to TEXCOORD_{} are read.",
            uv_set.0,
            MAX_UV_SETS - 1
        ));
        return None;
    }
    Some(TextureLookup { texture: index.index(), uv_set: uv_set.0 as u32, transform })
}

/// uv′ = offset + R · (scale · uv). The extension measures the angle counter-clockwise in an image
/// whose v points down, so the matrix turns (u, v) by the negative angle.
fn affine(json: &TransformJson) -> Option<Affine2> {
    let scale = Vec2::from(json.scale.unwrap_or([1.0, 1.0]));
    let affine = Affine2::from_scale_angle_translation(scale, -json.rotation, Vec2::from(json.offset));
    (affine != Affine2::IDENTITY).then_some(affine)
}

/// Whether transformed coordinates stay in the range of `f32`.
fn is_in_range(t: Affine2) -> bool {
    t.to_cols_array().iter().all(|c| c.abs() < 1e9)
}

/// Extensions that name an image of another format, which takes precedence over the core `source`:
/// that is for readers without the format. In order of precedence.
const SOURCES: [&str; 2] = ["KHR_texture_basisu", "EXT_texture_webp"];

#[derive(Deserialize)]
struct SourceJson {
    source: Option<Int>,
}

/// The glTF images that can serve a texture, best first: the core `source` is the fallback of an
/// extension's.
fn images_for(document: &Document, texture: usize) -> Vec<usize> {
    let Some(json) = document.textures.get(texture) else { return Vec::new() };
    let others = SOURCES.iter().filter_map(|name| json.extensions.parse::<SourceJson>(name)?.ok()?.source);
    others.chain(json.source).map(Int::index).collect()
}

/// The images that can serve each texture of these lookups, best first, in the order of the best
/// ones.
pub(crate) fn images_of<'a>(document: &Document, lookups: impl Iterator<Item = &'a TextureLookup>) -> Vec<Vec<usize>> {
    let set: BTreeSet<Vec<usize>> = lookups.map(|l| images_for(document, l.texture)).collect();
    set.into_iter().collect()
}

/// Turns lookups into [`TextureRef`]s and collects the distinct textures.
#[derive(Debug)]
pub(crate) struct Binder<'a> {
    document: &'a Document,
    decoded: &'a Decoded,
    slots: HashMap<Texture, usize>,
    /// The scene's textures.
    pub(crate) textures: Vec<Texture>,
    /// Textures without a readable source, samplers out of range.
    pub(crate) warnings: Warnings,
    /// Images made from others; their indices follow those of the decoded ones.
    pub(crate) made: Vec<Image>,
    /// Roughness maps by the image and the glossiness factor (as bits) that they were made from.
    roughness: HashMap<(usize, u32), usize>,
}

impl<'a> Binder<'a> {
    pub(crate) fn new(document: &'a Document, decoded: &'a Decoded) -> Self {
        Self {
            document,
            decoded,
            slots: HashMap::new(),
            textures: Vec::new(),
            warnings: Warnings::default(),
            made: Vec::new(),
            roughness: HashMap::new(),
        }
    }

    /// `None` when the image could not be read (it has been warned of).
    pub(crate) fn bind(&mut self, lookup: Option<&TextureLookup>) -> Option<TextureRef> {
        let lookup = lookup?;
        let choices = images_for(self.document, lookup.texture);
        if choices.is_empty() {
            let json = self.document.textures.get(lookup.texture)?;
            let reason = match json.extensions.names().next() {
                Some(name) => format!("has its image only in the extension {name}, which is not supported"),
                None => "has no source".into(),
            };
            self.warnings.push(format!("A texture is left out: texture {} {reason}.", lookup.texture));
            return None;
        }
        let image = self.decoded.first_of(&choices)?;
        let texture = self.sampled(lookup.texture, image);
        Some(self.reference(lookup, texture))
    }

    /// A roughness map made of the glossiness in an image's alpha.
    pub(crate) fn bind_glossiness(&mut self, lookup: &TextureLookup, glossiness: f32) -> Option<TextureRef> {
        let image = self.decoded.first_of(&images_for(self.document, lookup.texture))?;
        let key = (image, glossiness.to_bits());
        let index = match self.roughness.get(&key) {
            Some(&index) => index,
            None => {
                let from = &self.decoded.images[image];
                let rgba = roughness(&from.rgba, glossiness);
                self.made.push(Image { name: format!("{} (roughness)", from.name), rgba, ..*from });
                let index = self.decoded.images.len() + self.made.len() - 1;
                self.roughness.insert(key, index);
                index
            }
        };
        let texture = self.sampled(lookup.texture, index);
        Some(self.reference(lookup, texture))
    }

    fn reference(&mut self, lookup: &TextureLookup, texture: Texture) -> TextureRef {
        let index = match self.slots.get(&texture) {
            Some(&index) => index,
            None => {
                self.textures.push(texture.clone());
                self.slots.insert(texture, self.textures.len() - 1);
                self.textures.len() - 1
            }
        };
        TextureRef { texture: index, uv_set: lookup.uv_set, transform: lookup.transform }
    }

    fn sampled(&mut self, index: usize, image: usize) -> Texture {
        let place = format!("texture {index}");
        let mut texture = Texture { image, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Linear };
        let Some(sampler) = self.document.textures.get(index).and_then(|t| t.sampler) else {
            return texture;
        };
        match get(&self.document.samplers, sampler, "sampler", &place) {
            Ok(json) => {
                let place = format!("sampler {}", sampler.index());
                texture.wrap_s = wrap(json.wrap_s, &place, &mut self.warnings);
                texture.wrap_t = wrap(json.wrap_t, &place, &mut self.warnings);
                if json.mag_filter == Some(Int(u64::from(NEAREST))) {
                    texture.filter = Filter::Nearest;
                }
            }
            Err(fault) => self.warnings.push(format!("A sampler is replaced by the default: {}.", fault.reason())),
        }
        texture
    }
}

fn wrap(json: Option<Int>, place: &str, warnings: &mut Warnings) -> Wrap {
    let number = json.map_or(u64::from(REPEAT), |v| v.0);
    match u32::try_from(number) {
        Ok(REPEAT) => Wrap::Repeat,
        Ok(CLAMP_TO_EDGE) => Wrap::ClampToEdge,
        Ok(MIRRORED_REPEAT) => Wrap::MirroredRepeat,
        _ => {
            warnings.push(format!("The wrap mode {number} of {place} is unknown; the texture repeats."));
            Wrap::Repeat
        }
    }
}

/// A roughness map (in G) out of a map with glossiness in its alpha, for a roughness factor of 1.
fn roughness(rgba: &[u8], glossiness: f32) -> Vec<u8> {
    let table: Vec<u8> =
        (0..=255_u8).map(|a| ((1.0 - f32::from(a) / 255.0 * glossiness) * 255.0).round() as u8).collect();
    rgba.as_chunks::<4>().0.iter().flat_map(|&[_, _, _, a]| [0, table[usize::from(a)], 0, 255]).collect()
}
