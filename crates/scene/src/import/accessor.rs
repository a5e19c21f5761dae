//! Accessors: typed elements out of buffer views, with strides, normalised integers, sparse parts
//! and implied zeros.

use gltf::json::accessor::{self, Type};

use super::buffers::{Buffers, range};
use super::document::{Accessor, Document, Int, Sparse, get};
use super::error::{Fault, Result};
pub(crate) use gltf::json::accessor::ComponentType as Component;

/// The meaning of a component type of the JSON.
fn component(value: Int, place: &str) -> Result<Component> {
    Ok(match u32::try_from(value.0) {
        Ok(accessor::BYTE) => Component::I8,
        Ok(accessor::UNSIGNED_BYTE) => Component::U8,
        Ok(accessor::SHORT) => Component::I16,
        Ok(accessor::UNSIGNED_SHORT) => Component::U16,
        Ok(accessor::UNSIGNED_INT) => Component::U32,
        Ok(accessor::FLOAT) => Component::F32,
        _ => return Err(Fault::invalid(place, format!("has the unknown component type {}", value.0))),
    })
}

/// An accessor whose type, component type and count are known to make sense; its bytes are not yet
/// read.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Typed<'a> {
    json: &'a Accessor,
    index: usize,
    /// Type of each component.
    pub(crate) component: Component,
    /// Components an element.
    pub(crate) width: usize,
    /// Elements.
    pub(crate) count: usize,
    /// Whether integers encode fractions.
    pub(crate) normalized: bool,
}

impl Typed<'_> {
    /// Whether some elements are replaced, which needs all of them in memory.
    pub(crate) fn is_sparse(&self) -> bool {
        self.json.sparse.is_some()
    }
}

/// Elements in a buffer, or zeros where there is no buffer view.
#[derive(Clone, Copy, Debug)]
struct Strided<'a> {
    bytes: Option<&'a [u8]>,
    stride: usize,
    size: usize,
    count: usize,
}

/// Reads accessors of one document.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accessors<'a> {
    pub(crate) document: &'a Document,
    pub(crate) buffers: &'a Buffers<'a>,
    /// Whether the file uses KHR_mesh_quantization: vertices may be integers.
    pub(crate) quantized: bool,
}

impl<'a> Accessors<'a> {
    /// Finds an accessor of vectors and checks its type; `user` is the object that refers to it.
    pub(crate) fn typed(&self, index: Int, user: &str) -> Result<Typed<'a>> {
        let typed = self.any(index, user)?;
        match typed.json.kind.as_str() {
            "MAT4" => Err(Fault::invalid(format!("accessor {}", typed.index), "is a MAT4, where a vector is needed")
                .used_by(user)),
            _ => Ok(typed),
        }
    }

    /// The same for whatever can be read: vectors and 4×4 matrices.
    pub(crate) fn any(&self, index: Int, user: &str) -> Result<Typed<'a>> {
        let json = get(&self.document.accessors, index, "accessor", user)?;
        let index = index.index();
        let place = format!("accessor {index}");
        let component = component(json.component_type, &place)?;
        let kind = match json.kind.as_str() {
            "SCALAR" => Type::Scalar,
            "VEC2" => Type::Vec2,
            "VEC3" => Type::Vec3,
            "VEC4" => Type::Vec4,
            "MAT4" => Type::Mat4,
            // Columns of these are padded to four bytes, and nothing of glTF uses them.
            "MAT2" | "MAT3" => {
                return Err(
                    Fault::invalid(place, format!("is a {}, where a vector is needed", json.kind)).used_by(user)
                );
            }
            other => return Err(Fault::invalid(place, format!("has the unknown type {}", super::uri::shown(other)))),
        };
        let width = kind.multiplicity();
        // Vertex indices are 32 bits wide, in glTF and in `Mesh`.
        let count = match u32::try_from(json.count.0) {
            Ok(count) => count as usize,
            Err(_) => return Err(Fault::invalid(place, format!("has {} elements", json.count.0)).used_by(user)),
        };
        Ok(Typed { json, index, component, width, count, normalized: json.normalized })
    }

    /// Elements as `f32`, all of them or those in `pick` (indices that must be below `count`).
    ///
    /// Normalised integers become fractions as glTF 2.0 section 3.11 says: c / max, and for signed
    /// ones not below −1.
    pub(crate) fn floats<const N: usize>(&self, of: &Typed, pick: Option<&[u32]>) -> Result<Vec<[f32; N]>> {
        let place = format!("accessor {}", of.index);
        if of.width != N {
            return Err(Fault::invalid(place, format!("is a {}, where {N} components are needed", of.json.kind)));
        }
        let base = self.strided(of, &place)?;
        let Some(sparse) = &of.json.sparse else {
            return Ok(gather(base, of, pick));
        };
        let mut all = gather(base, of, None);
        let (at, values) = self.sparse(sparse, of, &place)?;
        for (&at, value) in at.iter().zip(gather::<N>(values, of, None)) {
            all[at as usize] = value;
        }
        Ok(match pick {
            Some(pick) => pick.iter().map(|&i| all[i as usize]).collect(),
            None => all,
        })
    }

    /// Elements of an index accessor.
    pub(crate) fn indices(&self, of: &Typed) -> Result<Vec<u32>> {
        let place = format!("accessor {}", of.index);
        if of.width != 1 || !matches!(of.component, Component::U8 | Component::U16 | Component::U32) {
            return Err(Fault::invalid(place, "holds no unsigned integers, where indices are needed"));
        }
        let base = self.strided(of, &place)?;
        let mut all = gather_indices(base, of.component);
        if let Some(sparse) = &of.json.sparse {
            let (at, values) = self.sparse(sparse, of, &place)?;
            for (&at, value) in at.iter().zip(gather_indices(values, of.component)) {
                all[at as usize] = value;
            }
        }
        Ok(all)
    }

    /// The base elements, with every offset checked.
    fn strided(&self, of: &Typed, place: &str) -> Result<Strided<'_>> {
        let size = of.component.size() * of.width;
        let Some(view_index) = of.json.buffer_view else {
            return Ok(Strided { bytes: None, stride: size, size, count: of.count });
        };
        let view = self.buffers.view(view_index, place)?;
        let stride = view.stride.unwrap_or(size);
        let described = format!("bufferView {}", view_index.index());
        strided(view.bytes, of.json.byte_offset.0, stride, size, of.count, place, &described)
    }

    /// The places and values that a sparse accessor replaces.
    fn sparse(&self, sparse: &Sparse, of: &Typed, place: &str) -> Result<(Vec<u32>, Strided<'_>)> {
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        if count > of.count {
            let cause = format!("replaces {count} elements by its sparse part, but has only {}", of.count);
            return Err(Fault::invalid(place, cause));
        }
        let component = component(sparse.indices.component_type, place)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(Fault::invalid(place, "has sparse indices that are no unsigned integers"));
        }
        let view = self.buffers.view(sparse.indices.buffer_view, place)?;
        let described = format!("bufferView {} (sparse indices)", sparse.indices.buffer_view.index());
        let (offset, size) = (sparse.indices.byte_offset.0, component.size());
        let at = gather_indices(strided(view.bytes, offset, size, size, count, place, &described)?, component);
        if let Some(bad) = at.iter().find(|&&i| i as usize >= of.count) {
            let cause = format!("replaces element {bad} by its sparse part, but has only {}", of.count);
            return Err(Fault::invalid(place, cause));
        }
        let view = self.buffers.view(sparse.values.buffer_view, place)?;
        let described = format!("bufferView {} (sparse values)", sparse.values.buffer_view.index());
        let size = of.component.size() * of.width;
        let values = strided(view.bytes, sparse.values.byte_offset.0, size, size, count, place, &described)?;
        Ok((at, values))
    }
}

/// Cuts elements out of a view, and refuses ranges past its end.
fn strided<'v>(
    view: &'v [u8],
    offset: u64,
    stride: usize,
    size: usize,
    count: usize,
    place: &str,
    described: &str,
) -> Result<Strided<'v>> {
    if count == 0 {
        return Ok(Strided { bytes: Some(&[]), stride, size, count });
    }
    if stride < size {
        let cause = format!("has elements of {size} bytes, but {described} has a stride of {stride}");
        return Err(Fault::invalid(place, cause));
    }
    let length = (stride as u64).checked_mul(count as u64 - 1).and_then(|n| n.checked_add(size as u64));
    match length.and_then(|length| range(view, offset, length)) {
        Some(bytes) => Ok(Strided { bytes: Some(bytes), stride, size, count }),
        None => {
            let cause = format!(
                "needs {count} elements of {size} bytes, {stride} apart, from byte {offset} of {described}, which has {} bytes",
                view.len()
            );
            Err(Fault::invalid(place, cause))
        }
    }
}

fn gather<const N: usize>(from: Strided, of: &Typed, pick: Option<&[u32]>) -> Vec<[f32; N]> {
    let normalized = of.normalized;
    // One monomorphic loop a component type: the conversion inlines, and packed f32 becomes a copy.
    match of.component {
        Component::F32 => collect::<N, 4>(from, pick, f32::from_le_bytes),
        Component::U8 if normalized => collect::<N, 1>(from, pick, |[b]| f32::from(b) / 255.0),
        Component::U8 => collect::<N, 1>(from, pick, |[b]| f32::from(b)),
        Component::I8 if normalized => {
            collect::<N, 1>(from, pick, |b| (f32::from(i8::from_le_bytes(b)) / 127.0).max(-1.0))
        }
        Component::I8 => collect::<N, 1>(from, pick, |b| f32::from(i8::from_le_bytes(b))),
        Component::U16 if normalized => collect::<N, 2>(from, pick, |b| f32::from(u16::from_le_bytes(b)) / 65535.0),
        Component::U16 => collect::<N, 2>(from, pick, |b| f32::from(u16::from_le_bytes(b))),
        Component::I16 if normalized => {
            collect::<N, 2>(from, pick, |b| (f32::from(i16::from_le_bytes(b)) / 32767.0).max(-1.0))
        }
        Component::I16 => collect::<N, 2>(from, pick, |b| f32::from(i16::from_le_bytes(b))),
        Component::U32 if normalized => {
            collect::<N, 4>(from, pick, |b| (f64::from(u32::from_le_bytes(b)) / f64::from(u32::MAX)) as f32)
        }
        Component::U32 => collect::<N, 4>(from, pick, |b| u32::from_le_bytes(b) as f32),
    }
}

/// Elements of `N` components of `S` bytes each.
fn collect<const N: usize, const S: usize>(
    from: Strided,
    pick: Option<&[u32]>,
    convert: impl Fn([u8; S]) -> f32 + Copy,
) -> Vec<[f32; N]> {
    let element = |bytes: &[u8]| {
        let mut out = [0.0; N];
        let (components, _) = bytes.as_chunks::<S>();
        for (out, bytes) in out.iter_mut().zip(components) {
            *out = convert(*bytes);
        }
        out
    };
    let Some(bytes) = from.bytes else {
        return vec![[0.0; N]; pick.map_or(from.count, <[u32]>::len)];
    };
    match pick {
        Some(pick) => pick
            .iter()
            .map(|&i| {
                let start = i as usize * from.stride;
                element(&bytes[start..start + from.size])
            })
            .collect(),
        None if from.stride == from.size => bytes.chunks_exact(N * S).map(element).collect(),
        // The last chunk is one element long, not one stride.
        None => bytes.chunks(from.stride).map(|chunk| element(&chunk[..from.size])).collect(),
    }
}

fn gather_indices(from: Strided, component: Component) -> Vec<u32> {
    let Some(bytes) = from.bytes else {
        return vec![0; from.count];
    };
    let strided = bytes.chunks(from.stride.max(1));
    match (component, from.stride == from.size) {
        (Component::U8, true) => bytes.iter().map(|&b| u32::from(b)).collect(),
        (Component::U16, true) => bytes.as_chunks().0.iter().map(|&b| u32::from(u16::from_le_bytes(b))).collect(),
        (Component::U32, true) => bytes.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect(),
        (_, _) => strided
            .map(|chunk| chunk[..from.size].iter().rev().fold(0, |value, &b| value << 8 | u32::from(b)))
            .collect(),
    }
}
