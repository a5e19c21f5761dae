//! Choices of a build.

/// How much time goes into the trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Least build time.
    Fast,
    /// A little more build time for most of the quality.
    #[default]
    Medium,
    /// Several times the build time.
    Slow,
}

/// Which meshes are placed as instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instancing {
    /// A mesh of at least 64 triangles placed at least twice, whose copies would have 4096
    /// triangles or more; none, where the copies of all such meshes have less than 2^20. A
    /// placement whose matrix is singular or whose condition number is above some 1e4 is copied
    /// nevertheless.
    #[default]
    Auto,
    /// None: everything is copied.
    Never,
    /// All that can be inverted; for tests.
    Always,
}

/// Choices of [`crate::Accel::build`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// How much time goes into the trees.
    pub quality: Quality,
    /// Which meshes are placed as instances.
    pub instancing: Instancing,
}
