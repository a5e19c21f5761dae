//! What a kernel reads of the scene: uploaded once, bound by name.

use surelight_prepare::{Composed, KernelKey, Part, Prepared};

use crate::{
    error::RenderError,
    kernel::{Resource, Resources},
    upload::Uploader,
};

/// Uploads the scene, but for the view of it.
pub(crate) fn scene_resources(
    up: &mut Uploader<'_>,
    prepared: &Prepared,
    key: &KernelKey,
    shader: &Composed,
) -> Result<Resources, RenderError> {
    let mut resources = Resources::new();
    for array in prepared.arrays(shader) {
        let resource = if key.has(Part::ItemsImage) {
            Resource::Image(up.image(array.what, &array.bytes)?)
        } else {
            Resource::Buffer(up.buffer(array.what, &array.bytes, wgpu::BufferUsages::STORAGE)?)
        };
        resources.insert(array.name.into(), resource);
    }
    Ok(resources)
}
