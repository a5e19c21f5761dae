//! A prepared scene in device memory: its arrays and the view of it, bound by name.

use std::time::Instant;

use surelight_prepare::{Composed, KernelKey, Part, Prepared, View};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Resource, Resources},
    upload::Uploader,
};

/// A scene's buffers and images, and its view.
pub(crate) struct SceneOnDevice {
    view: wgpu::Buffer,
    /// Pixels of the whole image.
    pub(crate) size: [u32; 2],
    seed: u32,
    /// Seconds of uploading.
    pub(crate) upload_seconds: f64,
}

impl SceneOnDevice {
    /// Uploads the arrays that a shader binds, and the view; adds both to the resources.
    pub(crate) fn upload(
        up: &mut Uploader<'_>,
        resources: &mut Resources,
        prepared: &Prepared,
        key: &KernelKey,
        shader: &Composed,
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        let started = Instant::now();
        for array in prepared.arrays(shader) {
            let resource = if key.has(Part::ItemsImage) {
                Resource::Image(up.image(array.what, &array.bytes)?)
            } else {
                Resource::Buffer(up.buffer(array.what, &array.bytes, U::STORAGE)?)
            };
            resources.insert(array.name.into(), resource);
        }
        let view = up.buffer("the view", &[prepared.view()], U::UNIFORM | U::COPY_DST)?;
        resources.insert("view".into(), Resource::Buffer(view.clone()));
        let View { size, seed, .. } = prepared.view();
        Ok(Self { view, size, seed, upload_seconds: started.elapsed().as_secs_f64() })
    }

    /// The seed of the samples.
    pub(crate) fn seed(&self) -> u32 {
        self.seed
    }

    /// Changes the seed of the samples of later dispatches.
    pub(crate) fn set_seed(&mut self, device: &Device, seed: u32) {
        self.seed = seed;
        let offset = std::mem::offset_of!(View, seed) as u64;
        device.queue.write_buffer(&self.view, offset, bytemuck::bytes_of(&seed));
    }
}
