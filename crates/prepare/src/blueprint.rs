//! The inputs of a kernel, and predictions of them before the BVH is built.

use surelight_scene::Scene;

use super::attributes::AttributeLayout;
use crate::{compose::Constant, kernel_key::KernelKey};

/// The inputs of a path kernel: two of the same blueprint are the same program.
#[derive(Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// Its parts.
    pub(crate) key: KernelKey,
    /// Its specialisation constants.
    pub constants: Vec<Constant>,
}

impl Blueprint {
    /// The parts of the kernel.
    pub fn key(&self) -> KernelKey {
        self.key
    }

    /// The same, reading the scene from storage images or from buffers.
    #[must_use]
    pub fn on_images(&self, images: bool) -> Self {
        Self { key: self.key.on_images(images), constants: self.constants.clone() }
    }
}

/// Room that is left for trees whose depth is not known yet. Kernels are made for that, or for more
/// where a tree turns out deeper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StackReserve {
    stack: u32,
    light_levels: u32,
}

impl StackReserve {
    /// Trees over so many triangles are rarely deeper.
    pub(crate) fn likely(scene: &Scene) -> Self {
        let [triangles, emissive] = placed_triangles(scene);
        let stack = (triangles.max(1).ilog2() + 7).next_multiple_of(8);
        // Of four children each, and less than evenly filled.
        let light_levels = (3 * emissive.max(1).ilog2()).div_ceil(4) + 2;
        Self { stack, light_levels: light_levels.next_multiple_of(4) }
    }

    /// The same, and enough for trees of these depths.
    pub(crate) fn for_depths(self, stack: u32, light_levels: u32) -> Self {
        Self {
            stack: self.stack.max(stack.next_multiple_of(8)),
            light_levels: self.light_levels.max(light_levels.next_multiple_of(4)),
        }
    }

    pub(crate) fn constants(self, layout: &AttributeLayout) -> Vec<Constant> {
        let mut constants = layout.constants();
        constants.push(Constant { name: "STACK_SIZE", value: self.stack });
        constants.push(Constant { name: "LIGHT_TREE_DEPTH", value: self.light_levels });
        constants
    }
}

/// Placed triangles, and the emissive ones among them.
pub(crate) fn placed_triangles(scene: &Scene) -> [u64; 2] {
    scene.instances.iter().fold([0, 0], |[all, emissive], instance| {
        // Building the trees refuses indices that are out of range.
        let Some(mesh) = scene.meshes.get(instance.mesh) else { return [all, emissive] };
        let count = mesh.triangles.len() as u64;
        let emits = scene.materials.get(mesh.material).is_some_and(|m| m.is_emissive());
        [all + count, emissive + if emits { count } else { 0 }]
    })
}
