//! Placed meshes, as the kernel reads them.

use bytemuck::{Pod, Zeroable};
use surelight_accel::InstanceRecord;

/// Twin of `Instance` in `shaders/scene/instances.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct InstanceRows {
    pub(crate) world_x: [f32; 4],
    pub(crate) world_y: [f32; 4],
    pub(crate) world_z: [f32; 4],
    pub(crate) object_x: [f32; 4],
    pub(crate) object_y: [f32; 4],
    pub(crate) object_z: [f32; 4],
}

impl InstanceRows {
    /// Leaves out what only the host needs.
    pub(crate) fn new(record: &InstanceRecord) -> Self {
        let [world_x, world_y, world_z] = bytemuck::cast(record.to_world);
        let [object_x, object_y, object_z] = bytemuck::cast(record.to_object);
        Self { world_x, world_y, world_z, object_x, object_y, object_z }
    }
}
