/// Why no acceleration structure was built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AccelError {
    /// An instance names a mesh that is not there.
    #[error("instance {instance} places mesh {mesh}, but the scene has {meshes} meshes")]
    MeshIndex {
        /// Index of the instance.
        instance: usize,
        /// The index it holds.
        mesh: usize,
        /// How many there are.
        meshes: usize,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} of mesh {mesh} names a vertex beyond the mesh's {vertices}")]
    VertexIndex {
        /// Index of the mesh.
        mesh: usize,
        /// Index of the triangle in it.
        triangle: usize,
        /// How many vertices the mesh has.
        vertices: usize,
    },
    /// The tree would not fit the item references.
    #[error(
        "the scene needs up to {needed} acceleration items ({} GiB), more than the {limit} that can be addressed: \
         simplify meshes or place repeated ones as instances of one mesh",
        .needed.div_ceil(1 << 24)
    )]
    TooManyItems {
        /// Items needed at most.
        needed: u64,
        /// Items that references can name.
        limit: u64,
    },
    /// More triangles or instances than 32-bit ids.
    #[error("the scene places {count} instances, more than the {limit} that can be numbered")]
    TooManyInstances {
        /// How many.
        count: usize,
        /// Most that is possible.
        limit: usize,
    },
}
