//! Runs an entry point of a test-only shader module on the device: buffers in, one buffer out.
//!
//! The module is composed exactly as the product composes its kernels, so it includes the shipped
//! code.

use std::sync::OnceLock;

use surelight_prepare::{Constant, KernelKey, compose};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// An entry point, compiled for one key.
///
/// The module binds its inputs as read-only storage buffers at group 0, bindings 0, 1, …, and one
/// result buffer after them. Lanes are `global_invocation_id.x`, 64 to a workgroup.
pub struct Probe {
    pipeline: wgpu::ComputePipeline,
}

/// The device that all tests of a binary share.
struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
}

fn gpu() -> &'static Gpu {
    static GPU: OnceLock<Gpu> = OnceLock::new();
    GPU.get_or_init(|| {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::PRIMARY,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
            .expect("these tests need a graphics adapter: ./setup.sh installs a software one");
        println!("probes run on {}", adapter.get_info().name);
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..wgpu::DeviceDescriptor::default() };
        let (device, queue) =
            pollster::block_on(adapter.request_device(&descriptor)).expect("the adapter gives a device");
        Gpu { device, queue }
    })
}

/// The key with the parts of these names and all that they need; panics where there is none.
pub fn key(names: &[&str]) -> KernelKey {
    KernelKey::from_names(names).unwrap_or_else(|e| panic!("{names:?}: {e}"))
}

impl Probe {
    /// Composes `root` (such as `package::probe::bsdf`) and compiles its entry point.
    pub fn new(root: &str, entry: &str, key: &KernelKey, constants: &[Constant]) -> Self {
        let composed = compose(root, key, constants).unwrap_or_else(|e| panic!("{e}"));
        let gpu = gpu();
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(root),
            source: wgpu::ShaderSource::Wgsl(composed.wgsl.into()),
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(entry),
            layout: None,
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        });
        Self { pipeline }
    }

    /// Runs at least `lanes` lanes over the inputs; returns the result buffer of `results`
    /// elements, zero where not written.
    pub fn run<T: bytemuck::Pod>(&self, inputs: &[&[u8]], lanes: usize, results: usize) -> Vec<T> {
        self.run_with(inputs, &[], lanes, results)
    }

    /// Runs with more inputs at separate bindings.
    pub fn run_with<T: bytemuck::Pod>(
        &self,
        inputs: &[&[u8]],
        more: &[(u32, &[u8])],
        lanes: usize,
        results: usize,
    ) -> Vec<T> {
        let Gpu { device, queue } = gpu();
        let bytes = (results * size_of::<T>()) as u64;
        let buffer = |usage| wgpu::BufferDescriptor { label: None, size: bytes, usage, mapped_at_creation: false };
        let output = device.create_buffer(&buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC));
        let staging = device.create_buffer(&buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST));
        let input = |contents| {
            let usage = wgpu::BufferUsages::STORAGE;
            device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
        };
        let mut buffers: Vec<_> = (0u32..).zip(inputs.iter().map(|contents| input(contents))).collect();
        buffers.push((inputs.len() as u32, output.clone()));
        buffers.extend(more.iter().map(|&(binding, contents)| (binding, input(contents))));
        let entries: Vec<_> = buffers
            .iter()
            .map(|(binding, b)| wgpu::BindGroupEntry { binding: *binding, resource: b.as_entire_binding() })
            .collect();
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.dispatch_workgroups(lanes.div_ceil(64) as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&output, 0, &staging, 0, bytes);
        queue.submit([encoder.finish()]);
        staging.map_async(wgpu::MapMode::Read, .., |r| r.expect("the result maps"));
        device.poll(wgpu::PollType::wait_indefinitely()).expect("the device finishes");
        bytemuck::pod_collect_to_vec(&staging.get_mapped_range(..).expect("the result is mapped"))
    }
}
