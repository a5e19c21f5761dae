//! The JSON of a glTF file as Rust types: only the fields that the importer reads, and nothing
//! checked beyond the JSON types.
//!
//! The crate `gltf` has such types too, but truncates indices to 32 bits silently, so that `"mesh":
//! 4294967296` becomes mesh 0, and gives up the whole file for a mistyped optional extension. Here
//! indices keep their 64 bits and extensions stay JSON text until a reader that knows them parses
//! it. The meanings of numbers and names (component types, modes, wrap modes, interpolations) and
//! the usual .glb do come from `gltf`, whose validator also checks the files of `surelight-scenes`
//! in tests.

use std::collections::BTreeMap;
use std::fmt;

use serde::Deserialize;
use serde::de::{self, DeserializeOwned, Deserializer, MapAccess, Visitor};
use serde_json::Value;
use serde_json::value::RawValue;

use super::error::{Fault, Result};
use super::json;
use super::uri;

/// The JSON object `extensions`, by name: each kept as text until a reader that knows it parses it.
/// (As a tree of values, a million nodes with a light each would take gigabytes.)
#[derive(Debug, Default, Clone)]
pub(crate) struct Extensions(Vec<(Box<str>, Box<RawValue>)>);

impl Extensions {
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The names, in the file's order.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| &**name)
    }

    pub(crate) fn has(&self, name: &str) -> bool {
        self.names().any(|n| n == name)
    }

    /// The extension `name` as a type, if the object has it.
    ///
    /// # Errors
    /// When it has it, and it is not of that type.
    pub(crate) fn parse<T: DeserializeOwned>(&self, name: &str) -> Option<std::result::Result<T, String>> {
        let (_, raw) = self.0.iter().find(|(n, _)| &**n == name)?;
        Some(parse_raw(raw))
    }
}

/// Text of JSON as a type. By way of a tree, since a line and a column inside the fragment would
/// lead nowhere.
pub(crate) fn parse_raw<T: DeserializeOwned>(raw: &RawValue) -> std::result::Result<T, String> {
    let value: Value = serde_json::from_str(raw.get()).map_err(|e| format!("it {}", json::fault(&e)))?;
    json::read(&value)
}

impl<'de> Deserialize<'de> for Extensions {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct MapVisitor;
        impl<'de> Visitor<'de> for MapVisitor {
            type Value = Extensions;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object of extensions")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> std::result::Result<Extensions, A::Error> {
                let mut all = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    all.push(entry);
                }
                all.shrink_to_fit();
                Ok(Extensions(all))
            }
        }
        deserializer.deserialize_map(MapVisitor)
    }
}

/// A whole number of the JSON: an index, a count or a constant. Accepts `3.0` for `3`, as some
/// exporters write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub(crate) struct Int(pub(crate) u64);

impl Int {
    /// As an index into a `Vec`; one that does not fit the address space is past the end of every
    /// `Vec`.
    pub(crate) fn index(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Int {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct IntVisitor;
        impl Visitor<'_> for IntVisitor {
            type Value = Int;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a whole number, 0 or above")
            }

            fn visit_u64<E: de::Error>(self, value: u64) -> std::result::Result<Int, E> {
                Ok(Int(value))
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> std::result::Result<Int, E> {
                // Up to 2^53 every whole number is exact as f64.
                if (0.0..=9_007_199_254_740_992.0).contains(&value) && value.fract() == 0.0 {
                    Ok(Int(value as u64))
                } else {
                    Err(E::invalid_value(de::Unexpected::Float(value), &self))
                }
            }
        }
        deserializer.deserialize_any(IntVisitor)
    }
}

/// The root object.
#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct Document {
    pub(crate) asset: Asset,
    pub(crate) scene: Option<Int>,
    #[serde(default)]
    pub(crate) scenes: Vec<SceneJson>,
    #[serde(default)]
    pub(crate) nodes: Vec<Node>,
    #[serde(default)]
    pub(crate) meshes: Vec<MeshJson>,
    #[serde(default)]
    pub(crate) cameras: Vec<CameraJson>,
    #[serde(default)]
    pub(crate) materials: Vec<MaterialJson>,
    #[serde(default)]
    pub(crate) textures: Vec<TextureJson>,
    #[serde(default)]
    pub(crate) samplers: Vec<Sampler>,
    #[serde(default)]
    pub(crate) images: Vec<ImageJson>,
    #[serde(default)]
    pub(crate) accessors: Vec<Accessor>,
    #[serde(default)]
    pub(crate) buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub(crate) buffers: Vec<Buffer>,
    /// As text: a broken one matters only where it is shown.
    pub(crate) skins: Option<Box<RawValue>>,
    /// The same.
    pub(crate) animations: Option<Box<RawValue>>,
    #[serde(default)]
    pub(crate) extensions_used: Vec<String>,
    #[serde(default)]
    pub(crate) extensions_required: Vec<String>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

impl Document {
    /// Refuses buffers and images in separate files.
    pub(crate) fn check_self_contained(&self) -> Result<()> {
        let buffers = self.buffers.iter().enumerate().map(|(i, buffer)| ("buffer", i, &buffer.uri));
        let images = self.images.iter().enumerate().map(|(i, image)| ("image", i, &image.uri));
        for (kind, index, uri) in buffers.chain(images) {
            if let Some(uri) = uri.as_deref().filter(|uri| !uri::is_data(uri)) {
                let cause = format!(
                    "refers to the file {}, and a scene that comes through a pipe has no folder to find it in: \
                     name the scene's file instead, or pack everything into one .glb",
                    uri::shown(uri)
                );
                return Err(Fault::invalid(format!("{kind} {index}"), cause));
            }
        }
        Ok(())
    }
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct Asset {
    pub(crate) version: String,
    pub(crate) min_version: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct SceneJson {
    #[serde(default)]
    pub(crate) nodes: Vec<Int>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct Node {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) children: Vec<Int>,
    pub(crate) mesh: Option<Int>,
    pub(crate) camera: Option<Int>,
    pub(crate) skin: Option<Int>,
    pub(crate) matrix: Option<Box<[f64; 16]>>,
    pub(crate) translation: Option<[f64; 3]>,
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    #[serde(default)]
    pub(crate) weights: Vec<f64>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct MeshJson {
    pub(crate) name: Option<String>,
    pub(crate) primitives: Vec<Primitive>,
    #[serde(default)]
    pub(crate) weights: Vec<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct Primitive {
    pub(crate) attributes: BTreeMap<String, Int>,
    pub(crate) indices: Option<Int>,
    pub(crate) material: Option<Int>,
    pub(crate) mode: Option<Int>,
    #[serde(default)]
    pub(crate) targets: Vec<BTreeMap<String, Int>>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct CameraJson {
    pub(crate) name: Option<String>,
    #[serde(rename = "type")]
    pub(crate) kind: Option<String>,
    pub(crate) perspective: Option<PerspectiveJson>,
    pub(crate) orthographic: Option<OrthographicJson>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct PerspectiveJson {
    pub(crate) yfov: f64,
    pub(crate) aspect_ratio: Option<f64>,
    pub(crate) znear: Option<f64>,
    pub(crate) zfar: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct OrthographicJson {
    pub(crate) xmag: f64,
    pub(crate) ymag: f64,
    pub(crate) znear: Option<f64>,
    pub(crate) zfar: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct MaterialJson {
    pub(crate) name: Option<String>,
    #[serde(default)]
    pub(crate) pbr_metallic_roughness: PbrJson,
    pub(crate) normal_texture: Option<TextureInfo>,
    pub(crate) emissive_texture: Option<TextureInfo>,
    pub(crate) emissive_factor: Option<[f64; 3]>,
    pub(crate) alpha_mode: Option<String>,
    pub(crate) alpha_cutoff: Option<f64>,
    #[serde(default)]
    pub(crate) double_sided: bool,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct PbrJson {
    pub(crate) base_color_factor: Option<[f64; 4]>,
    pub(crate) base_color_texture: Option<TextureInfo>,
    pub(crate) metallic_factor: Option<f64>,
    pub(crate) roughness_factor: Option<f64>,
    pub(crate) metallic_roughness_texture: Option<TextureInfo>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct TextureInfo {
    pub(crate) index: Option<Int>,
    #[serde(default)]
    pub(crate) tex_coord: Int,
    /// Normal textures only.
    pub(crate) scale: Option<f64>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct TextureJson {
    pub(crate) source: Option<Int>,
    pub(crate) sampler: Option<Int>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Default, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct Sampler {
    pub(crate) mag_filter: Option<Int>,
    pub(crate) wrap_s: Option<Int>,
    pub(crate) wrap_t: Option<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct ImageJson {
    pub(crate) uri: Option<String>,
    pub(crate) buffer_view: Option<Int>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub(crate) buffer_view: Option<Int>,
    #[serde(default)]
    pub(crate) byte_offset: Int,
    pub(crate) component_type: Int,
    #[serde(default)]
    pub(crate) normalized: bool,
    pub(crate) count: Int,
    #[serde(rename = "type")]
    pub(crate) kind: String,
    pub(crate) sparse: Option<Box<Sparse>>,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object")]
pub(crate) struct Sparse {
    pub(crate) count: Int,
    pub(crate) indices: SparseIndices,
    pub(crate) values: SparseValues,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct SparseIndices {
    pub(crate) buffer_view: Int,
    #[serde(default)]
    pub(crate) byte_offset: Int,
    pub(crate) component_type: Int,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct SparseValues {
    pub(crate) buffer_view: Int,
    #[serde(default)]
    pub(crate) byte_offset: Int,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct BufferView {
    pub(crate) buffer: Int,
    #[serde(default)]
    pub(crate) byte_offset: Int,
    pub(crate) byte_length: Int,
    pub(crate) byte_stride: Option<Int>,
    #[serde(default)]
    pub(crate) extensions: Extensions,
}

#[derive(Debug, Deserialize)]
#[serde(expecting = "an object", rename_all = "camelCase")]
pub(crate) struct Buffer {
    pub(crate) uri: Option<String>,
    pub(crate) byte_length: Int,
}

/// The text of the JSON.
pub(crate) fn text(json: &[u8]) -> Result<&str> {
    // Padding of the GLB chunk and a byte order mark are not JSON, and common.
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|&b| b != 0).map_or(0, |last| last + 1);
    let json = &json[..end];
    if json.iter().all(u8::is_ascii_whitespace) {
        return Err(Fault::Format("its JSON is empty".into()));
    }
    std::str::from_utf8(json).map_err(|e| Fault::Format(format!("its JSON is not UTF-8 (byte {})", e.valid_up_to())))
}

/// Parses the JSON; an error names the object inside the document, and not only a column of its one
/// long line.
pub(crate) fn parse(text: &str) -> Result<Document> {
    serde_json::from_str(text).map_err(|quick| {
        // Only a refused file pays for the second pass that tracks the path.
        let mut reader = serde_json::Deserializer::from_str(text);
        match serde_path_to_error::deserialize::<_, Document>(&mut reader) {
            // The path of a mere syntax error says no more than its line and column.
            Err(e) if e.path().iter().next().is_some() && !e.inner().is_syntax() && !e.inner().is_eof() => {
                Fault::Format(format!("{} in its JSON {}", e.path(), json::fault(e.inner())))
            }
            _ => Fault::Format(format!("its JSON cannot be parsed: {quick}")),
        }
    })
}

/// Looks up `index` in a top-level array for the object `place`.
pub(crate) fn get<'a, T>(items: &'a [T], index: Int, kind: &str, place: &str) -> Result<&'a T> {
    items.get(index.index()).ok_or_else(|| Fault::no_such(place, kind, index.index(), items.len()))
}
