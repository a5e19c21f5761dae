//! Encodes a [`Scene`] as a binary glTF 2.0 file: the generated assets, and round trips in tests.
//!
//! The bytes are a function of the scene alone: keys in a fixed order, numbers in their shortest
//! form, equal vertex data stored once. Layout: glTF 2.0 specification, section 4 (GLB file
//! format).

mod buffer;
mod document;
mod layers;
mod material;
mod texture_info;

use glam::{DAffine3, DMat3, DVec3};
use surelight_scene::{
    Camera, ClipRange, Filter, Image, Instance, Light, LightKind, Mesh, Projection, Scene, Texture, Wrap,
};
use thiserror::Error;

use buffer::BufferBuilder;
use document::*;

/// Why a scene cannot be encoded.
#[derive(Debug, Error)]
pub enum EncodeError {
    /// glTF demands finite bounds of positions, and JSON has no NaN.
    #[error("mesh {index} (\"{name}\") has a vertex that is not finite; remove it before writing")]
    NonFinite {
        /// Index of the mesh.
        index: usize,
        /// Its name.
        name: String,
    },
    /// glTF forbids empty accessors.
    #[error("mesh {index} (\"{name}\") has no triangles; leave it out of the scene")]
    EmptyMesh {
        /// Index of the mesh.
        index: usize,
        /// Its name.
        name: String,
    },
    /// The writer supports TEXCOORD_0 and TEXCOORD_1 only.
    #[error("mesh {index} (\"{name}\") has {sets} UV sets; at most two can be written")]
    TooManyUvSets {
        /// Index of the mesh.
        index: usize,
        /// Its name.
        name: String,
        /// How many it has.
        sets: usize,
    },
    /// KHR_texture_transform holds an offset, a rotation and a scale.
    #[error("material \"{material}\" has a texture transform with shear, which KHR_texture_transform cannot express")]
    Shear {
        /// Name of the material.
        material: String,
    },
    /// An image whose texels do not match its size, or that the PNG encoder refused.
    #[error("image \"{name}\" cannot be encoded as PNG: {reason}")]
    Image {
        /// Name of the image.
        name: String,
        /// The defect.
        reason: String,
    },
    /// GLB lengths are 32-bit.
    #[error("the scene takes {bytes} bytes; a .glb file holds less than 4 GiB")]
    TooLarge {
        /// Length of the file.
        bytes: usize,
    },
    /// The document could not be written as JSON.
    #[error("the glTF document cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
}

/// A valid .glb of the scene: meshes (one primitive each), instances as nodes with a matrix,
/// materials with their extensions, textures as embedded PNG, cameras and punctual lights.
///
/// `notes` goes to `asset.extras.notes` (nothing is written when it is empty). Left out, because
/// glTF has no place for them: [`Scene::environment`], `extensions` and `warnings`. Matrices are
/// written in f32 precision, as readers keep them.
pub fn encode(scene: &Scene, notes: &str) -> Result<Vec<u8>, EncodeError> {
    let mut buffer = BufferBuilder::default();
    let meshes = scene
        .meshes
        .iter()
        .enumerate()
        .map(|(index, mesh)| mesh_entry(index, mesh, &mut buffer))
        .collect::<Result<Vec<_>, _>>()?;
    let images = scene.images.iter().map(|i| image_entry(i, &mut buffer)).collect::<Result<Vec<_>, _>>()?;
    let materials = scene.materials.iter().map(material::entry).collect::<Result<Vec<_>, _>>()?;
    let mut samplers = Vec::new();
    let textures = scene.textures.iter().map(|t| texture_entry(t, &mut samplers)).collect();

    let mut nodes: Vec<Node> = scene.instances.iter().map(|i| instance_node(i, scene)).collect();
    nodes.extend(scene.cameras.iter().enumerate().map(|(index, c)| camera_node(index, c)));
    nodes.extend(scene.lights.iter().enumerate().map(|(index, l)| light_node(index, l)));

    let lights: Vec<LightEntry> = scene.lights.iter().map(light_entry).collect();
    let document = Document {
        asset: Asset {
            version: "2.0",
            generator: concat!("Surelight ", env!("CARGO_PKG_VERSION")),
            extras: (!notes.is_empty()).then(|| Extras { notes: notes.to_owned() }),
        },
        extensions_used: extensions_used(&materials, !lights.is_empty()),
        scene: 0,
        scenes: vec![SceneEntry { name: scene.name.clone(), nodes: (0..nodes.len()).collect() }],
        nodes,
        cameras: scene.cameras.iter().map(|camera| camera_entry(camera, scene)).collect(),
        meshes,
        materials,
        textures,
        samplers,
        images,
        accessors: buffer.accessors,
        buffer_views: buffer.views,
        buffers: if buffer.bytes.is_empty() { Vec::new() } else { vec![Buffer { byte_length: buffer.bytes.len() }] },
        extensions: (!lights.is_empty()).then_some(DocumentExtensions { punctual: PunctualLights { lights } }),
    };
    container(serde_json::to_vec(&document)?, buffer.bytes)
}

/// Header and chunks; JSON is padded with spaces, binary data with zeros.
fn container(mut json: Vec<u8>, mut binary: Vec<u8>) -> Result<Vec<u8>, EncodeError> {
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let binary_chunk = if binary.is_empty() { 0 } else { 8 + binary.len() };
    let bytes = 12 + 8 + json.len() + binary_chunk;
    if u32::try_from(bytes).is_err() {
        return Err(EncodeError::TooLarge { bytes });
    }
    let mut file = Vec::with_capacity(bytes);
    file.extend_from_slice(b"glTF");
    file.extend_from_slice(&2u32.to_le_bytes());
    file.extend_from_slice(&(bytes as u32).to_le_bytes());
    file.extend_from_slice(&(json.len() as u32).to_le_bytes());
    file.extend_from_slice(b"JSON");
    file.extend_from_slice(&json);
    if !binary.is_empty() {
        file.extend_from_slice(&(binary.len() as u32).to_le_bytes());
        file.extend_from_slice(b"BIN\0");
        file.extend_from_slice(&binary);
    }
    Ok(file)
}

fn extensions_used(materials: &[MaterialEntry], lights: bool) -> Vec<&'static str> {
    let mut names: Vec<_> = materials.iter().flat_map(|m| m.extensions.names()).collect();
    if lights {
        names.push("KHR_lights_punctual");
    }
    if materials.iter().flat_map(material::texture_infos).any(|t| t.extensions.is_some()) {
        names.push("KHR_texture_transform");
    }
    names.sort_unstable();
    names.dedup();
    names
}

fn mesh_entry(index: usize, mesh: &Mesh, buffer: &mut BufferBuilder) -> Result<MeshEntry, EncodeError> {
    let name = mesh.name.clone();
    if mesh.triangles.is_empty() {
        return Err(EncodeError::EmptyMesh { index, name });
    }
    let finite = |v: &[f32]| v.iter().all(|x| x.is_finite());
    if !mesh.positions.iter().all(|p| finite(&p.to_array())) {
        return Err(EncodeError::NonFinite { index, name });
    }
    if mesh.uvs.len() > 2 {
        return Err(EncodeError::TooManyUvSets { index, name, sets: mesh.uvs.len() });
    }
    let attributes = Attributes {
        position: buffer.positions(&mesh.positions),
        normal: mesh.normals.as_ref().map(|n| buffer.vec3(n)),
        tangent: mesh.tangents.as_ref().map(|t| buffer.vec4(t)),
        uv0: mesh.uvs.first().map(|uv| buffer.vec2(uv)),
        uv1: mesh.uvs.get(1).map(|uv| buffer.vec2(uv)),
        color: mesh.colors.as_ref().map(|c| buffer.vec4(c)),
    };
    let indices = buffer.indices(&mesh.triangles, mesh.positions.len());
    Ok(MeshEntry { name, primitives: [Primitive { attributes, indices, material: mesh.material }] })
}

fn image_entry(image: &Image, buffer: &mut BufferBuilder) -> Result<ImageEntry, EncodeError> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    use image::{ExtendedColorType, ImageEncoder};

    let error = |reason: String| EncodeError::Image { name: image.name.clone(), reason };
    let texels = image.width as usize * image.height as usize;
    if image.rgba.len() != texels * 4 {
        return Err(error(format!("it has {} bytes instead of {}", image.rgba.len(), texels * 4)));
    }
    let opaque = image.rgba.chunks_exact(4).all(|t| t[3] == 255);
    let (bytes, color) = if opaque {
        (image.rgba.chunks_exact(4).flat_map(|t| [t[0], t[1], t[2]]).collect(), ExtendedColorType::Rgb8)
    } else {
        (image.rgba.clone(), ExtendedColorType::Rgba8)
    };
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive)
        .write_image(&bytes, image.width, image.height, color)
        .map_err(|e| error(e.to_string()))?;
    let buffer_view = buffer.view(&png, None);
    Ok(ImageEntry { name: image.name.clone(), buffer_view, mime_type: "image/png" })
}

fn texture_entry(texture: &Texture, samplers: &mut Vec<Sampler>) -> TextureEntry {
    let filter = match texture.filter {
        Filter::Nearest => 9728,
        Filter::Linear => 9729,
    };
    let wrap = |w| match w {
        Wrap::Repeat => 10497,
        Wrap::MirroredRepeat => 33648,
        Wrap::ClampToEdge => 33071,
    };
    let sampler =
        Sampler { mag_filter: filter, min_filter: filter, wrap_s: wrap(texture.wrap_s), wrap_t: wrap(texture.wrap_t) };
    let index = samplers.iter().position(|s| *s == sampler).unwrap_or_else(|| {
        samplers.push(sampler);
        samplers.len() - 1
    });
    TextureEntry { sampler: index, source: texture.image }
}

fn instance_node(instance: &Instance, scene: &Scene) -> Node {
    Node {
        name: scene.meshes[instance.mesh].name.clone(),
        mesh: Some(instance.mesh),
        matrix: matrix(&instance.to_world),
        ..Node::default()
    }
}

fn camera_node(index: usize, camera: &Camera) -> Node {
    Node { name: camera.name.clone(), camera: Some(index), matrix: matrix(&camera.to_world), ..Node::default() }
}

fn camera_entry(camera: &Camera, scene: &Scene) -> CameraEntry {
    let name = camera.name.clone();
    let ClipRange { near, far } = camera.clip;
    match camera.projection {
        Projection::Perspective { yfov, aspect } => {
            // The near plane of a perspective camera must lie before it.
            let znear = short(if near > 0.0 { near } else { NEAR_SHARE * reach(camera, scene) });
            let zfar = far.is_finite().then(|| short(far));
            let perspective = Perspective { aspect_ratio: aspect.map(short), yfov: short(yfov), zfar, znear };
            CameraEntry::Perspective { name, perspective }
        }
        Projection::Orthographic { xmag, ymag } => {
            // An orthographic camera must have a far plane.
            let zfar = short(if far.is_finite() { far } else { near + 2.0 * reach(camera, scene) });
            let orthographic = Orthographic { xmag: short(xmag), ymag: short(ymag), zfar, znear: short(near) };
            CameraEntry::Orthographic { name, orthographic }
        }
    }
}

/// The near plane of a camera that clips nothing, as a share of its [`reach`]: nearer than all
/// geometry.
const NEAR_SHARE: f64 = 1e-6;

/// Distance from a camera to the farthest corner of the scene's box; 1 where there is nothing.
fn reach(camera: &Camera, scene: &Scene) -> f64 {
    let eye = camera.to_world.translation;
    let distance = scene.bounds().map_or(0.0, |(low, high)| (low - eye).abs().max((high - eye).abs()).length());
    if distance > 0.0 { distance } else { 1.0 }
}

fn light_node(index: usize, light: &Light) -> Node {
    let (position, direction) = match light.kind {
        LightKind::Point { position } => (position, DVec3::NEG_Z),
        LightKind::Spot { position, direction, .. } => (position, direction),
        LightKind::Directional { direction } => (DVec3::ZERO, direction),
    };
    // Light travels along the node's −Z; the turn about that axis is free.
    let z = -direction.normalize();
    let to_world = if z == DVec3::Z {
        DAffine3::from_translation(position)
    } else {
        let x = z.any_orthonormal_vector();
        DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), position)
    };
    Node {
        name: light.name.clone(),
        matrix: matrix(&to_world),
        extensions: Some(NodeExtensions { light: LightIndex { light: index } }),
        ..Node::default()
    }
}

fn light_entry(light: &Light) -> LightEntry {
    let (color, intensity) = split_strength(light.intensity);
    let (kind, spot) = match light.kind {
        LightKind::Point { .. } => ("point", None),
        LightKind::Directional { .. } => ("directional", None),
        LightKind::Spot { inner, outer, .. } => {
            ("spot", Some(Spot { inner_cone_angle: inner, outer_cone_angle: outer }))
        }
    };
    LightEntry { name: light.name.clone(), kind, color, intensity, spot }
}

/// A colour as a factor in [0, 1] and a strength ≥ 1 that is a power of two, so that their f32
/// product is the colour again, bit for bit.
fn split_strength(color: [f32; 3]) -> ([f32; 3], f32) {
    let most = color.iter().fold(1.0f32, |a, &b| a.max(b));
    let mut strength = 1.0f32;
    while strength < most {
        strength *= 2.0;
    }
    (color.map(|c| c / strength), strength)
}

/// The shortest decimal of the f32 nearest to `x`, as f64: readers turn it into that f32.
fn short(x: f64) -> f64 {
    (x as f32).to_string().parse().unwrap_or(x)
}

/// Column-major, or nothing for the identity.
fn matrix(m: &DAffine3) -> Option<[f64; 16]> {
    (*m != DAffine3::IDENTITY).then(|| {
        let mut out = [0.0; 16];
        for (column, v) in [m.x_axis, m.y_axis, m.z_axis, m.translation].into_iter().enumerate() {
            // Adding 0 turns −0 into 0.
            out[column * 4..column * 4 + 3].copy_from_slice(&v.to_array().map(|x| short(x) + 0.0));
        }
        out[15] = 1.0;
        out
    })
}

#[cfg(test)]
mod round_trip;
#[cfg(test)]
mod tests;
