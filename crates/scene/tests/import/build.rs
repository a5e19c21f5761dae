//! A glTF document under construction.

use std::path::Path;

use serde_json::{Value, json};
use surelight_scene::{LoadError, LoadOptions, Scene, load_bytes};

pub(crate) const BYTE: u32 = 5120;
pub(crate) const UBYTE: u32 = 5121;
pub(crate) const SHORT: u32 = 5122;
pub(crate) const USHORT: u32 = 5123;
pub(crate) const UINT: u32 = 5125;
pub(crate) const FLOAT: u32 = 5126;

/// JSON and binary chunk of a .glb.
#[derive(Clone)]
pub(crate) struct Gltf {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

/// Little-endian bytes of floats.
pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Little-endian bytes of shorts.
pub(crate) fn shorts(values: &[u16]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Little-endian bytes of 32-bit integers.
pub(crate) fn words(values: &[u32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// A square of two triangles in the xy plane, facing +Z.
pub(crate) const SQUARE: [f32; 12] = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0.];

impl Gltf {
    /// A document with nothing but a version.
    pub(crate) fn empty() -> Self {
        Self {
            json: json!({
                "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
                "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
            }),
            bin: Vec::new(),
        }
    }

    /// One node with one mesh of one primitive: the triangle (0,0,0), (1,0,0), (0,1,0), without
    /// indices.
    pub(crate) fn triangle() -> Self {
        let mut gltf = Self::empty();
        let positions = gltf.accessor(&floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]), FLOAT, "VEC3", 3);
        gltf.json["meshes"] = json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]);
        gltf.json["nodes"] = json!([{"mesh": 0}]);
        gltf.json["scenes"] = json!([{"nodes": [0]}]);
        gltf
    }

    /// One node with [`SQUARE`], indexed as 0 1 2, 0 2 3, with normals and TEXCOORD_0 (v
    /// downwards).
    pub(crate) fn square() -> Self {
        let mut gltf = Self::triangle();
        let positions = gltf.accessor(&floats(&SQUARE), FLOAT, "VEC3", 4);
        let normals = gltf.accessor(&floats(&[0., 0., 1.].repeat(4)), FLOAT, "VEC3", 4);
        let uvs = gltf.accessor(&floats(&[0., 1., 1., 1., 1., 0., 0., 0.]), FLOAT, "VEC2", 4);
        let indices = gltf.accessor(&shorts(&[0, 1, 2, 0, 2, 3]), USHORT, "SCALAR", 6);
        gltf.json["meshes"][0]["primitives"][0] = json!({
            "attributes": {"POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs}, "indices": indices,
        });
        gltf
    }

    /// The first primitive of the first mesh.
    pub(crate) fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }

    /// Appends to a top-level array; the index.
    pub(crate) fn push(&mut self, array: &str, value: Value) -> usize {
        if self.json[array].is_null() {
            self.json[array] = json!([]);
        }
        let array = self.json[array].as_array_mut().expect("array");
        array.push(value);
        array.len() - 1
    }

    /// Appends bytes as a buffer view; its index.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let offset = self.bin.len();
        self.bin.extend_from_slice(bytes);
        self.json["buffers"][0]["byteLength"] = json!(self.bin.len());
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Appends bytes as a tightly packed accessor; its index.
    pub(crate) fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let json = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", json)
    }

    /// The primitive's material becomes this one.
    pub(crate) fn material(mut self, material: Value) -> Self {
        let index = self.push("materials", material);
        self.primitive()["material"] = json!(index);
        self
    }

    /// A 2×2 PNG (red, green / blue, white) as texture; its index.
    pub(crate) fn texture(&mut self) -> usize {
        let view = self.view(&png(2, 2, &[255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255]));
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        self.push("textures", json!({"source": image}))
    }

    /// The file as .glb.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut bin = self.bin.clone();
        bin.resize(bin.len().next_multiple_of(4), 0);
        let total = 12 + 8 + text.len() + 8 + bin.len();
        let mut out = b"glTF".to_vec();
        out.extend(words(&[2, total as u32, text.len() as u32, 0x4E4F_534A]));
        out.extend(text);
        out.extend(words(&[bin.len() as u32, 0x004E_4942]));
        out.extend(bin);
        out
    }

    /// Loads it as a .glb.
    pub(crate) fn try_load(&self) -> Result<Scene, LoadError> {
        load_bytes(&self.glb(), Path::new("made.glb"), &LoadOptions::default())
    }

    /// Loads it, and it must load.
    #[track_caller]
    pub(crate) fn load(&self) -> Scene {
        match self.try_load() {
            Ok(scene) => scene,
            Err(error) => panic!("{error}"),
        }
    }

    /// Loads it, and it must be refused with a sentence that holds all of `parts`.
    #[track_caller]
    pub(crate) fn refused(&self, parts: &[&str]) {
        let message = match self.try_load() {
            Ok(_) => panic!("loaded"),
            Err(error) => error.to_string(),
        };
        assert!(message.starts_with("made.glb") && message.ends_with('.'), "{message}");
        for part in parts {
            assert!(message.contains(part), "{message:?} lacks {part:?}");
        }
    }
}

/// Exactly one warning, which holds `part`.
#[track_caller]
pub(crate) fn warned(scene: &Scene, part: &str) {
    assert_eq!(scene.warnings.len(), 1, "{:?}", scene.warnings);
    assert!(scene.warnings[0].contains(part), "{:?} lacks {part:?}", scene.warnings);
}

/// An RGBA PNG.
pub(crate) fn png(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(width, height, rgba.to_vec()).expect("size");
    let mut out = std::io::Cursor::new(Vec::new());
    image.write_to(&mut out, image::ImageFormat::Png).expect("encodes");
    out.into_inner()
}
