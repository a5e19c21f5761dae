use glam::{DAffine3, Vec2, Vec3, Vec4};

/// Triangles with one material: a glTF primitive.
///
/// Attribute arrays, where present, are as long as `positions`; indices are in range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name of the glTF mesh.
    pub name: String,
    /// Object space, metres. May hold NaN or ∞ when the file does: such triangles are skipped, with
    /// a count, by the BVH.
    pub positions: Vec<Vec3>,
    /// Three vertices per triangle, counter-clockwise from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Unit vertex normals; `None` means flat.
    pub normals: Option<Vec<Vec3>>,
    /// Unit tangents with the sign of the bitangent in w; present only where a normal map needs
    /// them.
    pub tangents: Option<Vec<Vec4>>,
    /// UV sets, each as long as `positions`: `uvs[k]` is TEXCOORD_k. Only as many as the material
    /// uses.
    pub uvs: Vec<Vec<Vec2>>,
    /// Linear vertex colours, multiplied with the base colour.
    pub colors: Option<Vec<Vec4>>,
    /// Index into [`crate::Scene::materials`].
    pub material: usize,
}

/// A mesh placed in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Index into [`crate::Scene::meshes`].
    pub mesh: usize,
    /// Object to world. A negative determinant turns the winding over, as glTF says.
    pub to_world: DAffine3,
}
