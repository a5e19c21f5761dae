use surelight_scene::SceneError;

/// Why no acceleration structure was built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AccelError {
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
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
}
