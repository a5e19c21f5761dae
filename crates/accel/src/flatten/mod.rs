//! From trees to the items that a kernel reads.

use crate::{Item, TriangleSource};

pub(crate) mod binary;
pub(crate) mod wide;

/// A flattened forest.
#[derive(Default)]
pub(crate) struct Flat {
    pub(crate) items: Vec<Item>,
    /// By prim id.
    pub(crate) triangles: Vec<TriangleSource>,
    /// Σ area × items read over the top-level tree, over the area of its bounds.
    pub(crate) sah: f64,
    /// Most entries on the stack of a walk.
    pub(crate) depth: u32,
}
