//! Placed meshes, as the kernel reads them.

use surelight_accel::InstanceRecord;

use crate::shared::InstanceRows;

impl InstanceRows {
    /// Leaves out fields that only the host needs. `first_light`: of its emissive triangles.
    pub(crate) fn new(record: &InstanceRecord, first_light: u32) -> Self {
        let [world_x, world_y, world_z] = bytemuck::cast(record.to_world);
        let rows: [[f32; 4]; 3] = bytemuck::cast(record.to_object);
        let [object_x, object_y, object_z] = rows.map(|[x, y, z, _]| [x, y, z]);
        Self { world_x, world_y, world_z, object_x, first_light, object_y, object_z, ..Self::default() }
    }
}
