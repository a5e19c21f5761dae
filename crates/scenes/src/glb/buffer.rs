//! The binary chunk: accessors over one buffer, equal data stored once.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};

use super::document::{Accessor, BufferView};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Collects buffer views and accessors. Adding equal data again gives the index of the first.
#[derive(Default)]
pub(super) struct BufferBuilder {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<BufferView>,
    pub(super) accessors: Vec<Accessor>,
    known: HashMap<(&'static str, Vec<u8>), usize>,
}

impl BufferBuilder {
    /// Appends a view that starts at a multiple of four, and returns its index.
    pub(super) fn view(&mut self, data: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(BufferView { buffer: 0, byte_offset: self.bytes.len(), byte_length: data.len(), target });
        self.bytes.extend_from_slice(data);
        self.views.len() - 1
    }

    /// POSITION, with the bounds that glTF demands.
    pub(super) fn positions(&mut self, values: &[Vec3]) -> usize {
        let lo = values.iter().copied().fold(Vec3::MAX, Vec3::min);
        let hi = values.iter().copied().fold(Vec3::MIN, Vec3::max);
        let index = self.floats("VEC3", values.iter().map(Vec3::to_array));
        self.accessors[index].min = Some(lo.to_array());
        self.accessors[index].max = Some(hi.to_array());
        index
    }

    /// NORMAL.
    pub(super) fn vec3(&mut self, values: &[Vec3]) -> usize {
        self.floats("VEC3", values.iter().map(Vec3::to_array))
    }

    /// TEXCOORD_n.
    pub(super) fn vec2(&mut self, values: &[Vec2]) -> usize {
        self.floats("VEC2", values.iter().map(Vec2::to_array))
    }

    /// TANGENT or COLOR_0.
    pub(super) fn vec4(&mut self, values: &[Vec4]) -> usize {
        self.floats("VEC4", values.iter().map(Vec4::to_array))
    }

    /// Three indices a triangle; 16 bits wide where the vertices allow it (65535 is the restart
    /// value).
    pub(super) fn indices(&mut self, triangles: &[[u32; 3]], vertices: usize) -> usize {
        let flat = triangles.iter().flatten();
        let (bytes, component_type): (Vec<u8>, _) = if vertices <= 0xffff {
            (flat.flat_map(|&i| (i as u16).to_le_bytes()).collect(), UNSIGNED_SHORT)
        } else {
            (flat.flat_map(|&i| i.to_le_bytes()).collect(), UNSIGNED_INT)
        };
        self.accessor(bytes, "SCALAR", component_type, triangles.len() * 3, ELEMENT_ARRAY_BUFFER)
    }

    fn floats<const N: usize>(&mut self, kind: &'static str, values: impl ExactSizeIterator<Item = [f32; N]>) -> usize {
        let count = values.len();
        let bytes = values.flatten().flat_map(f32::to_le_bytes).collect();
        self.accessor(bytes, kind, FLOAT, count, ARRAY_BUFFER)
    }

    fn accessor(
        &mut self,
        bytes: Vec<u8>,
        kind: &'static str,
        component_type: u32,
        count: usize,
        target: u32,
    ) -> usize {
        let key = (kind, bytes);
        if let Some(&index) = self.known.get(&key) {
            // 16- and 32-bit indices cannot be distinguished by their bytes alone.
            let seen = &self.accessors[index];
            if seen.component_type == component_type && seen.count == count {
                return index;
            }
        }
        let buffer_view = self.view(&key.1, Some(target));
        let index = self.accessors.len();
        self.accessors.push(Accessor { buffer_view, component_type, count, kind, min: None, max: None });
        self.known.insert(key, index);
        index
    }
}
