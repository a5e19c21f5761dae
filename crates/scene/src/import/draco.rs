//! KHR_draco_mesh_compression, by the crate `draco-core`.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};

use draco_core::{DecodeLimits, DecoderBuffer, ErrorKind, MeshDecoder};
use gltf::json::accessor::ComponentType as Component;
use serde::Deserialize;

use super::accessor::{Accessors, Typed};
use super::document::{Int, Primitive};
use super::error::{Fault, Result};

pub(crate) const NAME: &str = "KHR_draco_mesh_compression";

/// Vertices, and triangles, that a byte of a stream may expand to where the accessors state fewer.
const MAX_ELEMENTS_PER_BYTE: u64 = 16;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Json {
    buffer_view: Int,
    #[serde(default)]
    attributes: BTreeMap<String, Int>,
}

/// A decoded primitive.
pub(crate) struct Decoded {
    mesh: draco_core::Mesh,
    attributes: BTreeMap<String, Int>,
    place: String,
}

/// Decodes a primitive that is compressed. The decoded size is bounded by the counts of the
/// primitive's accessors (`vertices` and `corners`), and where those are less, by the stream's own
/// length.
pub(crate) fn decode(
    accessors: &Accessors,
    primitive: &Primitive,
    vertices: usize,
    corners: usize,
    place: &str,
) -> Result<Option<Decoded>> {
    let Some(parsed) = primitive.extensions.parse::<Json>(NAME) else { return Ok(None) };
    let broken = |cause: String| Fault::invalid(place, format!("is compressed with Draco, but {cause}"));
    let json = parsed.map_err(|e| broken(format!("its extension cannot be read: {e}")))?;
    let stream = accessors.buffers.view(json.buffer_view, &format!("{NAME} of {place}"))?.bytes;
    let by_length = (stream.len() as u64).saturating_mul(MAX_ELEMENTS_PER_BYTE);
    let (points, faces) = (by_length.max(vertices as u64), by_length.max(corners as u64 / 3));
    // Values are at most 4 components of 8 bytes while they are decoded.
    let bytes = points.saturating_mul(32 * (json.attributes.len() as u64 + 1)).saturating_add(1 << 16);
    let limits = DecodeLimits::default().with_max_points(points).with_max_faces(faces).with_max_decoded_bytes(bytes);
    // The decoder checks its input; a panic inside on damaged data becomes an error of the file.
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let mut mesh = draco_core::Mesh::new();
        MeshDecoder::new().decode(&mut DecoderBuffer::new(stream).with_limits(limits), &mut mesh).map(|()| mesh)
    }));
    match decoded {
        Ok(Ok(mesh)) => Ok(Some(Decoded { mesh, attributes: json.attributes, place: place.to_owned() })),
        Ok(Err(e)) if e.kind() == ErrorKind::LimitExceeded => {
            Err(broken(format!("its stream has more than {points} vertices or {faces} triangles, or too many values")))
        }
        Ok(Err(e)) if e.kind() == ErrorKind::UnsupportedFeature => {
            Err(broken("its stream uses features of Draco that are not supported".into()))
        }
        Ok(Err(_)) | Err(_) => Err(broken("its stream is damaged or cut short".into())),
    }
}

impl Decoded {
    /// Vertices of the stream.
    pub(crate) fn vertices(&self) -> usize {
        self.mesh.num_points()
    }

    /// Triangles of the stream.
    pub(crate) fn triangles(&self) -> usize {
        self.mesh.num_faces()
    }

    /// Whether the stream has an attribute, so that its accessor refers to no bytes.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.attributes.contains_key(name)
    }

    /// Indices, three per triangle.
    pub(crate) fn indices(&self) -> Vec<u32> {
        self.mesh.faces().iter().flatten().map(|point| point.0).collect()
    }

    /// The elements of an attribute as the accessor describes them; `None` when it is not in the
    /// stream.
    pub(crate) fn floats<const N: usize>(
        &self,
        of: &Typed,
        name: &str,
        pick: Option<&[u32]>,
    ) -> Option<Result<Vec<[f32; N]>>> {
        let id = self.attributes.get(name)?;
        let attribute = u32::try_from(id.0).ok().and_then(|id| self.mesh.attribute_by_unique_id(id));
        let Some(attribute) = attribute.filter(|a| usize::from(a.num_components()) == N && of.width == N) else {
            let cause = format!("has no attribute {} of {N} components in its Draco stream for {name}", id.0);
            return Some(Err(Fault::invalid(&self.place, cause)));
        };
        let values = attribute.read_f32s(self.mesh.num_points(), N);
        let most = match (of.normalized, of.component) {
            (true, Component::I8) => 127.0,
            (true, Component::U8) => 255.0,
            (true, Component::I16) => 32767.0,
            (true, Component::U16) => 65535.0,
            _ => 1.0,
        };
        let elements = values.as_chunks::<N>().0;
        let scaled = |e: &[f32; N]| if most == 1.0 { *e } else { e.map(|v| (v / most).max(-1.0)) };
        Some(Ok(match pick {
            Some(pick) => pick.iter().map(|&i| scaled(&elements[i as usize])).collect(),
            None => elements.iter().map(scaled).collect(),
        }))
    }
}
