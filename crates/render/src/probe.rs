//! Runs a test's own entry point over a prepared scene, to test single shader modules with the data
//! and bindings of the path kernel.

use bytemuck::{AnyBitPattern, NoUninit};

use surelight_prepare::{Prepared, compose};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Resource, Resources},
    scene_on_device::SceneOnDevice,
    upload::Uploader,
};

/// Lanes of a probe's workgroup.
const GROUP: usize = 64;

/// An entry point over a prepared scene, one lane per query, 64 lanes per workgroup along x.
///
/// Its module declares `queries`, a read-only storage array, and `results`, a read-write one,
/// at bindings that the scene's modules leave free; it may import every module of the scene's
/// kernel.
pub struct Probe<'a> {
    device: &'a Device,
    kernel: Kernel,
    input: wgpu::Buffer,
    output: wgpu::Buffer,
    readback: wgpu::Buffer,
    workgroups: u32,
}

impl<'a> Probe<'a> {
    /// Composes and compiles entry point `entry` of module `root`, for this number of queries and
    /// of results.
    ///
    /// # Errors
    /// Where the module does not compose for this scene, or the device refuses; the maximum is
    /// 65,535 workgroups.
    pub fn new<Q: NoUninit, R: AnyBitPattern>(
        device: &'a Device,
        prepared: &Prepared,
        [root, entry]: [&str; 2],
        queries: &[Q],
        results: usize,
        checks: Checks,
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        let key = prepared.key().on_images(device.reads_images());
        let shader = compose(root, &key, &prepared.constants())?;
        let mut up = Uploader::new(device);
        let mut resources = Resources::new();
        SceneOnDevice::upload(&mut up, &mut resources, prepared, &key, &shader)?;
        let size = (results * size_of::<R>()) as u64;
        let input = up.buffer("the queries", queries, U::STORAGE | U::COPY_DST)?;
        let output = up.zeros("the results", size, U::STORAGE | U::COPY_SRC)?;
        let readback = up.zeros("the results' copy", size, U::MAP_READ | U::COPY_DST)?;
        resources.insert("queries".into(), Resource::Buffer(input.clone()));
        resources.insert("results".into(), Resource::Buffer(output.clone()));
        let kernel = Kernel::new(device, &shader, entry, checks, &resources)?;
        Ok(Self { device, kernel, input, output, readback, workgroups: queries.len().div_ceil(GROUP) as u32 })
    }

    /// Replaces the queries by as many or fewer.
    pub fn ask<Q: NoUninit>(&self, queries: &[Q]) {
        self.device.queue.write_buffer(&self.input, 0, bytemuck::cast_slice(queries));
    }

    /// Runs all queries; results that are not written are zero.
    ///
    /// # Errors
    /// Where the device fails.
    pub fn run<R: AnyBitPattern + NoUninit>(&self) -> Result<Vec<R>, RenderError> {
        let size = self.readback.size();
        self.device.scoped("a probe", || {
            let mut encoder = self.device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.kernel.record(&mut encoder, self.workgroups, None);
            encoder.copy_buffer_to_buffer(&self.output, 0, &self.readback, 0, size);
            self.device.queue.submit([encoder.finish()]);
        })?;
        self.device.read(&self.readback, size, bytemuck::pod_collect_to_vec)
    }
}

/// Runs an entry point of `root` once with all accesses checked: [`Probe`].
///
/// # Errors
/// As [`Probe::new`] and [`Probe::run`].
pub fn run_probe<Q: NoUninit, R: AnyBitPattern + NoUninit>(
    device: &Device,
    prepared: &Prepared,
    root: &str,
    entry: &str,
    queries: &[Q],
    results: usize,
) -> Result<Vec<R>, RenderError> {
    Probe::new::<Q, R>(device, prepared, [root, entry], queries, results, Checks::Full)?.run()
}
