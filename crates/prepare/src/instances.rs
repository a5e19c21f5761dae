//! Placed meshes, as the kernel reads them.

use bytemuck::{Pod, Zeroable};
use surelight_accel::InstanceRecord;

/// Counterpart of `Instance` in `shaders/scene/instances.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct InstanceRows {
    pub(crate) world_x: [f32; 4],
    pub(crate) world_y: [f32; 4],
    pub(crate) world_z: [f32; 4],
    pub(crate) object_x: [f32; 3],
    pub(crate) first_light: u32,
    pub(crate) object_y: [f32; 3],
    pub(crate) pad_0: u32,
    pub(crate) object_z: [f32; 3],
    pub(crate) pad_1: u32,
}

impl InstanceRows {
    /// Leaves out fields that only the host needs. `first_light`: of its emissive triangles.
    pub(crate) fn new(record: &InstanceRecord, first_light: u32) -> Self {
        let [world_x, world_y, world_z] = bytemuck::cast(record.to_world);
        let rows: [[f32; 4]; 3] = bytemuck::cast(record.to_object);
        let [object_x, object_y, object_z] = rows.map(|[x, y, z, _]| [x, y, z]);
        Self { world_x, world_y, world_z, object_x, first_light, object_y, object_z, ..Self::default() }
    }
}
