//! The glTF 2.0 JSON document as the writer fills it in: only the properties that it writes.
//!
//! Typed structs rather than a JSON map, so that the order of the keys (and with it the bytes of
//! the file) is the order of the fields here and depends on nothing else.

use serde::Serialize;

use super::layers::LayerExtensions;
use super::texture_info::TextureInfo;

/// The whole document.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Document {
    pub(super) asset: Asset,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) extensions_used: Vec<&'static str>,
    pub(super) scene: usize,
    pub(super) scenes: Vec<SceneEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) nodes: Vec<Node>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) cameras: Vec<CameraEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) meshes: Vec<MeshEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) materials: Vec<MaterialEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) textures: Vec<TextureEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) samplers: Vec<Sampler>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) images: Vec<ImageEntry>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) accessors: Vec<Accessor>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) buffer_views: Vec<BufferView>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) buffers: Vec<Buffer>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extensions: Option<DocumentExtensions>,
}

#[derive(Serialize)]
pub(super) struct Asset {
    pub(super) version: &'static str,
    pub(super) generator: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extras: Option<Extras>,
}

#[derive(Serialize)]
pub(super) struct Extras {
    pub(super) notes: String,
}

#[derive(Serialize)]
pub(super) struct SceneEntry {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) nodes: Vec<usize>,
}

#[derive(Default, Serialize)]
pub(super) struct Node {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mesh: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) camera: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) matrix: Option<[f64; 16]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) extensions: Option<NodeExtensions>,
}

#[derive(Serialize)]
pub(super) struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) light: LightIndex,
}

#[derive(Serialize)]
pub(super) struct LightIndex {
    pub(super) light: usize,
}

#[derive(Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
pub(super) enum CameraEntry {
    Perspective { name: String, perspective: Perspective },
    Orthographic { name: String, orthographic: Orthographic },
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Perspective {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) aspect_ratio: Option<f64>,
    pub(super) yfov: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) zfar: Option<f64>,
    pub(super) znear: f64,
}

#[derive(Serialize)]
pub(super) struct Orthographic {
    pub(super) xmag: f64,
    pub(super) ymag: f64,
    pub(super) zfar: f64,
    pub(super) znear: f64,
}

#[derive(Serialize)]
pub(super) struct MeshEntry {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    pub(super) primitives: [Primitive; 1],
}

#[derive(Serialize)]
pub(super) struct Primitive {
    pub(super) attributes: Attributes,
    pub(super) indices: usize,
    pub(super) material: usize,
}

#[derive(Serialize)]
pub(super) struct Attributes {
    #[serde(rename = "POSITION")]
    pub(super) position: usize,
    #[serde(rename = "NORMAL", skip_serializing_if = "Option::is_none")]
    pub(super) normal: Option<usize>,
    #[serde(rename = "TANGENT", skip_serializing_if = "Option::is_none")]
    pub(super) tangent: Option<usize>,
    #[serde(rename = "TEXCOORD_0", skip_serializing_if = "Option::is_none")]
    pub(super) uv0: Option<usize>,
    #[serde(rename = "TEXCOORD_1", skip_serializing_if = "Option::is_none")]
    pub(super) uv1: Option<usize>,
    #[serde(rename = "COLOR_0", skip_serializing_if = "Option::is_none")]
    pub(super) color: Option<usize>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MaterialEntry {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    pub(super) pbr_metallic_roughness: MetallicRoughness,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) normal_texture: Option<TextureInfo>,
    #[serde(skip_serializing_if = "is_zero3")]
    pub(super) emissive_factor: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) emissive_texture: Option<TextureInfo>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) alpha_mode: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) alpha_cutoff: Option<f32>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) double_sided: bool,
    #[serde(skip_serializing_if = "MaterialExtensions::is_empty")]
    pub(super) extensions: MaterialExtensions,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct MetallicRoughness {
    pub(super) base_color_factor: [f32; 4],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) base_color_texture: Option<TextureInfo>,
    pub(super) metallic_factor: f32,
    pub(super) roughness_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) metallic_roughness_texture: Option<TextureInfo>,
}

#[derive(Default, Serialize)]
pub(super) struct MaterialExtensions {
    #[serde(rename = "KHR_materials_emissive_strength", skip_serializing_if = "Option::is_none")]
    pub(super) emissive_strength: Option<EmissiveStrength>,
    #[serde(rename = "KHR_materials_ior", skip_serializing_if = "Option::is_none")]
    pub(super) ior: Option<Ior>,
    #[serde(rename = "KHR_materials_specular", skip_serializing_if = "Option::is_none")]
    pub(super) specular: Option<Specular>,
    #[serde(rename = "KHR_materials_transmission", skip_serializing_if = "Option::is_none")]
    pub(super) transmission: Option<Transmission>,
    #[serde(rename = "KHR_materials_unlit", skip_serializing_if = "Option::is_none")]
    pub(super) unlit: Option<Unlit>,
    #[serde(rename = "KHR_materials_volume", skip_serializing_if = "Option::is_none")]
    pub(super) volume: Option<VolumeEntry>,
    #[serde(flatten)]
    pub(super) layers: LayerExtensions,
}

impl MaterialExtensions {
    pub(super) fn is_empty(&self) -> bool {
        self.names().next().is_none()
    }

    /// Names of the extensions that are there.
    pub(super) fn names(&self) -> impl Iterator<Item = &'static str> {
        [
            self.emissive_strength.as_ref().map(|_| "KHR_materials_emissive_strength"),
            self.ior.as_ref().map(|_| "KHR_materials_ior"),
            self.specular.as_ref().map(|_| "KHR_materials_specular"),
            self.transmission.as_ref().map(|_| "KHR_materials_transmission"),
            self.unlit.as_ref().map(|_| "KHR_materials_unlit"),
            self.volume.as_ref().map(|_| "KHR_materials_volume"),
        ]
        .into_iter()
        .flatten()
        .chain(self.layers.names())
    }
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct EmissiveStrength {
    pub(super) emissive_strength: f32,
}

#[derive(Serialize)]
pub(super) struct Ior {
    pub(super) ior: f32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Specular {
    pub(super) specular_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) specular_texture: Option<TextureInfo>,
    #[serde(skip_serializing_if = "is_one3")]
    pub(super) specular_color_factor: [f32; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) specular_color_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Transmission {
    pub(super) transmission_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) transmission_texture: Option<TextureInfo>,
}

#[derive(Serialize)]
pub(super) struct Unlit {}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct VolumeEntry {
    pub(super) thickness_factor: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) attenuation_distance: Option<f32>,
    #[serde(skip_serializing_if = "is_one3")]
    pub(super) attenuation_color: [f32; 3],
}

#[derive(Serialize)]
pub(super) struct TextureEntry {
    pub(super) sampler: usize,
    pub(super) source: usize,
}

#[derive(PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Sampler {
    pub(super) mag_filter: u32,
    pub(super) min_filter: u32,
    pub(super) wrap_s: u32,
    pub(super) wrap_t: u32,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ImageEntry {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    pub(super) buffer_view: usize,
    pub(super) mime_type: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    pub(super) buffer_view: usize,
    pub(super) component_type: u32,
    pub(super) count: usize,
    #[serde(rename = "type")]
    pub(super) kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) min: Option<[f32; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) max: Option<[f32; 3]>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    pub(super) buffer: usize,
    pub(super) byte_offset: usize,
    pub(super) byte_length: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) target: Option<u32>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    pub(super) byte_length: usize,
}

#[derive(Serialize)]
pub(super) struct DocumentExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub(super) punctual: PunctualLights,
}

#[derive(Serialize)]
pub(super) struct PunctualLights {
    pub(super) lights: Vec<LightEntry>,
}

#[derive(Serialize)]
pub(super) struct LightEntry {
    #[serde(skip_serializing_if = "String::is_empty")]
    pub(super) name: String,
    #[serde(rename = "type")]
    pub(super) kind: &'static str,
    pub(super) color: [f32; 3],
    pub(super) intensity: f32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) spot: Option<Spot>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Spot {
    pub(super) inner_cone_angle: f32,
    pub(super) outer_cone_angle: f32,
}

fn is_zero3(c: &[f32; 3]) -> bool {
    *c == [0.0; 3]
}

fn is_one3(c: &[f32; 3]) -> bool {
    *c == [1.0; 3]
}
