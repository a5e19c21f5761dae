//! Runs a shader module of one's own over a prepared scene: single modules of the renderer can then be asked what they do,
//! with the very data and bindings that the path kernel has.

use bytemuck::{AnyBitPattern, NoUninit};

use crate::{
    compose::compose,
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Resource},
    prepare::Prepared,
    resources::scene_resources,
    upload::Uploader,
};

/// Lanes of a probe's workgroup.
const GROUP: usize = 64;

/// Runs an entry point of `root` with one lane a query, 64 to a workgroup along x, all accesses checked.
///
/// The module declares `queries`, a read-only storage array, and `results`, a read-write one, wherever the scene's modules
/// bind nothing; it may import anything that the scene's features have. Returns `results` elements, zero where not written.
///
/// # Errors
/// Where the module does not compose for this scene, or the device refuses: 65,535 workgroups are the most.
pub fn run_probe<Q: NoUninit, R: AnyBitPattern + NoUninit>(
    device: &Device,
    prepared: &Prepared,
    root: &str,
    entry: &str,
    queries: &[Q],
    results: usize,
) -> Result<Vec<R>, RenderError> {
    use wgpu::BufferUsages as U;
    let mut features = prepared.features;
    features.items_image = device.reads_images();
    let shader = compose(root, &features, &prepared.constants())?;
    let mut up = Uploader::new(device);
    let mut resources = scene_resources(&mut up, prepared, &features, &shader)?;
    let view = up.buffer("the view", &[prepared.view], U::UNIFORM)?;
    let size = (results * size_of::<R>()) as u64;
    let input = up.buffer("the queries", queries, U::STORAGE)?;
    let output = up.zeros("the results", size, U::STORAGE | U::COPY_SRC)?;
    let readback = up.zeros("the results' copy", size, U::MAP_READ | U::COPY_DST)?;
    resources.insert("view".into(), Resource::Buffer(view));
    resources.insert("queries".into(), Resource::Buffer(input));
    resources.insert("results".into(), Resource::Buffer(output.clone()));
    let kernel = Kernel::new(device, &shader, entry, Checks::Full, &resources)?;
    device.scoped("a probe", || {
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        kernel.record(&mut encoder, queries.len().div_ceil(GROUP) as u32, None);
        encoder.copy_buffer_to_buffer(&output, 0, &readback, 0, size);
        device.queue.submit([encoder.finish()]);
    })?;
    device.read(&readback, size, bytemuck::pod_collect_to_vec)
}
