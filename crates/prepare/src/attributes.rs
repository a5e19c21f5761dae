//! Shading records of triangles, packed with only the words that the scene needs.

use glam::{DMat3, Vec3, Vec4};
use surelight_accel::Accel;
use surelight_scene::Scene;

use super::octahedral::octahedral;
use crate::{
    compose::Constant,
    kernel_key::{KernelKey, Part},
};

/// The positions of a record's words. Counterpart of the constants in `package::generated`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct AttributeLayout {
    stride: u32,
    light: u32,
    normals: u32,
    tangents: u32,
    colors: u32,
    uvs: u32,
    uv_sets: u32,
}

impl AttributeLayout {
    pub(crate) fn of(scene: &Scene, key: &KernelKey) -> Self {
        let uv_sets = scene.meshes.iter().map(|m| m.uvs.len()).max().unwrap_or(0).max(1) as u32;
        Self::new(key, uv_sets)
    }

    pub(crate) fn new(key: &KernelKey, uv_sets: u32) -> Self {
        let mut next = 1;
        let mut take = |on: bool, words: u32| {
            let at = next;
            next += if on { words } else { 0 };
            at
        };
        let light = take(key.has(Part::AreaLights), 1);
        let normals = take(key.has(Part::VertexNormals), 3);
        let tangents = take(key.has(Part::Tangents), 3);
        let colors = take(key.has(Part::VertexColors), 6);
        let uvs = take(key.has(Part::Textures), 6 * uv_sets);
        Self { stride: next, light, normals, tangents, colors, uvs, uv_sets }
    }

    pub(crate) fn constants(&self) -> Vec<Constant> {
        [
            ("ATTRIBUTE_STRIDE", self.stride),
            ("ATTRIBUTE_LIGHT", self.light),
            ("ATTRIBUTE_NORMALS", self.normals),
            ("ATTRIBUTE_TANGENTS", self.tangents),
            ("ATTRIBUTE_COLORS", self.colors),
            ("ATTRIBUTE_UVS", self.uvs),
        ]
        .map(|(name, value)| Constant { name, value })
        .to_vec()
    }

    /// The records of all triangles in prim order. `light_words`: one per triangle, when area
    /// lights are sampled.
    pub(crate) fn pack(&self, scene: &Scene, accel: &Accel, key: &KernelKey, light_words: &[u32]) -> Vec<u32> {
        let mut words = vec![0; self.stride as usize * accel.triangles.len()];
        for (prim, (record, source)) in words.chunks_exact_mut(self.stride as usize).zip(&accel.triangles).enumerate() {
            let mesh = &scene.meshes[source.mesh as usize];
            let corners = source.corners.map(|c| c as usize);
            record[0] = mesh.material as u32;
            if key.has(Part::AreaLights) {
                record[self.light as usize] = light_words[prim];
            }
            // Triangles baked into the world need their directions taken there too.
            let to_world =
                (source.instance != u32::MAX).then(|| scene.instances[source.instance as usize].to_world.matrix3);
            let normal_matrix = to_world.map(|m| {
                // Inverse transpose up to a positive factor: cofactors with the determinant's sign.
                let cofactors =
                    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
                cofactors * m.determinant().signum()
            });
            for (k, &corner) in corners.iter().enumerate() {
                if key.has(Part::VertexNormals) {
                    let normal = match &mesh.normals {
                        Some(normals) => {
                            let n = normals[corner];
                            normal_matrix.map_or(n, |m| (m * n.as_dvec3()).normalize_or_zero().as_vec3())
                        }
                        None => flat_normal(mesh, corners, to_world),
                    };
                    record[self.normals as usize + k] = octahedral(normal);
                }
                if key.has(Part::Tangents) {
                    let tangent = mesh.tangents.as_ref().map_or(Vec4::new(1.0, 0.0, 0.0, 1.0), |t| t[corner]);
                    let direction = tangent.truncate();
                    let direction =
                        to_world.map_or(direction, |m| (m * direction.as_dvec3()).normalize_or_zero().as_vec3());
                    // A mirroring transform turns the bitangent's side over with everything else.
                    let mirrored = to_world.is_some_and(|m| m.determinant() < 0.0);
                    let side = u32::from((tangent.w < 0.0) != mirrored);
                    record[self.tangents as usize + k] = octahedral(direction) & !1 | side;
                }
                if key.has(Part::VertexColors) {
                    let color = mesh.colors.as_ref().map_or(Vec4::ONE, |c| c[corner]).clamp(Vec4::ZERO, Vec4::ONE);
                    let unorm = color.to_array().map(|c| (c * 65535.0).round() as u32);
                    record[self.colors as usize + 2 * k] = unorm[0] | unorm[1] << 16;
                    record[self.colors as usize + 2 * k + 1] = unorm[2] | unorm[3] << 16;
                }
                if key.has(Part::Textures) {
                    for set in 0..self.uv_sets as usize {
                        let uv = mesh.uvs.get(set).map_or(glam::Vec2::ZERO, |uvs| uvs[corner]);
                        let at = self.uvs as usize + 6 * set + 2 * k;
                        record[at] = uv.x.to_bits();
                        record[at + 1] = uv.y.to_bits();
                    }
                }
            }
        }
        words
    }
}

/// The front's normal of a triangle whose corners are in the order of its item, in the space that
/// the item is in.
fn flat_normal(mesh: &surelight_scene::Mesh, corners: [usize; 3], to_world: Option<DMat3>) -> Vec3 {
    let [a, b, c] = corners.map(|i| to_world.unwrap_or(DMat3::IDENTITY) * mesh.positions[i].as_dvec3());
    (b - a).cross(c - a).normalize_or_zero().as_vec3()
}
