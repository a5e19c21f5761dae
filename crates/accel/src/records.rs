//! Tables beside the item stream: the sources of triangles and instances, and the counts of skipped
//! triangles.

use std::ops::AddAssign;

use glam::DAffine3;

/// The source of a triangle of the item stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TriangleSource {
    /// Index into [`surelight_scene::Scene::meshes`].
    pub mesh: u32,
    /// Vertex indices in the order of the item: b1 belongs to `corners[1]`, b2 to `corners[2]`.
    /// Copies under a negative determinant have their last two swapped, so that e1 × e2 points to
    /// glTF's front.
    pub corners: [u32; 3],
    /// Index into [`surelight_scene::Scene::instances`], or [`crate::NO_INSTANCE`] when the mesh is
    /// placed as instances.
    pub instance: u32,
}

/// A mesh placed as an instance.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct InstanceRecord {
    /// Index into [`surelight_scene::Scene::instances`].
    pub scene_instance: u32,
    /// Object to camera space: three rows of x, y, z and translation.
    pub to_world: [f32; 12],
    /// Camera to object space, inverted in f64. Its transpose takes e1 × e2 to the side that is
    /// glTF's front, whatever the sign of the determinant.
    pub to_object: [f32; 12],
}

/// Triangles left out, counted once for each placement that is copied and once for a mesh that is
/// placed as instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// With a coordinate that is NaN, ∞ or beyond [`crate::COORDINATE_LIMIT`] once in camera space
    /// and f32.
    pub non_finite: u64,
    /// With parallel or vanishing edges, in f32.
    pub zero_area: u64,
}

impl AddAssign for Skipped {
    fn add_assign(&mut self, other: Self) {
        self.non_finite += other.non_finite;
        self.zero_area += other.zero_area;
    }
}

/// Three rows of x, y, z and translation.
pub(crate) fn rows(a: &DAffine3) -> [f32; 12] {
    let m = a.matrix3.transpose();
    let t = a.translation;
    let mut out = [0.0; 12];
    for (k, (row, shift)) in [(m.x_axis, t.x), (m.y_axis, t.y), (m.z_axis, t.z)].into_iter().enumerate() {
        out[4 * k..4 * k + 4].copy_from_slice(&[row.x as f32, row.y as f32, row.z as f32, shift as f32]);
    }
    out
}
