//! A compute pipeline with its bindings, made from the reflection of the composed shader.

use std::{borrow::Cow, collections::HashMap};

use surelight_prepare::{Access, Binding, Composed, bindings};

use crate::{device::Device, error::RenderError};

/// A resource that can be bound, by its name in the shader.
pub(crate) enum Resource {
    Buffer(wgpu::Buffer),
    Image(wgpu::TextureView),
}

/// Named resources.
pub(crate) type Resources = HashMap<Cow<'static, str>, Resource>;

/// A compiled entry point without bind groups.
pub(crate) struct Program {
    pipeline: wgpu::ComputePipeline,
    bindings: Vec<Binding>,
    /// One per group.
    layouts: Vec<wgpu::BindGroupLayout>,
}

/// A compiled entry point and its bind groups.
pub(crate) struct Kernel {
    pipeline: wgpu::ComputePipeline,
    groups: Vec<(u32, wgpu::BindGroup)>,
}

/// Whether the driver's bounds checks are compiled in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Checks {
    /// Loops are bounded, accesses are not checked: this project's shaders stay within their
    /// buffers.
    #[default]
    Trusted,
    /// All of WebGPU's checks; tests prove that images are the same, bit for bit.
    Full,
}

impl Program {
    pub(crate) fn new(device: &Device, shader: &Composed, entry: &str, checks: Checks) -> Result<Self, RenderError> {
        device.scoped("a kernel", || {
            let module = shader_module(&device.device, &shader.wgsl, checks);
            let bindings = bindings(shader);
            let count = bindings.iter().map(|b| b.group + 1).max().unwrap_or(0);
            let layouts: Vec<_> = (0..count)
                .map(|g| {
                    let entries: Vec<_> = bindings.iter().filter(|b| b.group == g).map(layout_entry).collect();
                    let descriptor = wgpu::BindGroupLayoutDescriptor { label: None, entries: &entries };
                    device.device.create_bind_group_layout(&descriptor)
                })
                .collect();
            let pipeline_layout = device.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(entry),
                bind_group_layouts: &layouts.iter().map(Some).collect::<Vec<_>>(),
                immediate_size: 0,
            });
            let pipeline = device.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry),
                layout: Some(&pipeline_layout),
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions {
                    zero_initialize_workgroup_memory: true,
                    ..Default::default()
                },
                cache: None,
            });
            Self { pipeline, bindings, layouts }
        })
    }

    /// A binding.
    pub(crate) fn bindings(&self) -> &[Binding] {
        &self.bindings
    }

    /// With its resource.
    pub(crate) fn bind(&self, device: &Device, resources: &Resources) -> Result<Kernel, RenderError> {
        let groups = (0..).zip(&self.layouts).map(|(group, layout)| {
            let bindings = self.bindings.iter().filter(|b| b.group == group);
            let entries: Vec<_> = bindings.map(|b| group_entry(b, resources)).collect::<Result<_, _>>()?;
            let descriptor = wgpu::BindGroupDescriptor { label: None, layout, entries: &entries };
            Ok((group, device.scoped("a kernel", || device.device.create_bind_group(&descriptor))?))
        });
        Ok(Kernel { pipeline: self.pipeline.clone(), groups: groups.collect::<Result<_, RenderError>>()? })
    }
}

impl Kernel {
    pub(crate) fn new(
        device: &Device,
        shader: &Composed,
        entry: &str,
        checks: Checks,
        resources: &Resources,
    ) -> Result<Self, RenderError> {
        Program::new(device, shader, entry, checks)?.bind(device, resources)
    }

    /// Records a dispatch of `workgroups` along x, timed where there is a stopwatch.
    pub(crate) fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        workgroups: u32,
        timestamp_writes: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes });
        pass.set_pipeline(&self.pipeline);
        for (index, group) in &self.groups {
            pass.set_bind_group(*index, group, &[]);
        }
        pass.dispatch_workgroups(workgroups, 1, 1);
    }
}

#[allow(unsafe_code, reason = "the one place where bounds checks are left out")]
fn shader_module(device: &wgpu::Device, wgsl: &str, checks: Checks) -> wgpu::ShaderModule {
    let source = wgpu::ShaderModuleDescriptor { label: None, source: wgpu::ShaderSource::Wgsl(wgsl.into()) };
    match checks {
        Checks::Full => device.create_shader_module(source),
        Checks::Trusted => {
            // Loops stay bounded: drivers may assume that an unbounded one ends, and miscompile
            // what follows.
            let checks = wgpu::ShaderRuntimeChecks { bounds_checks: false, ..wgpu::ShaderRuntimeChecks::checked() };
            // SAFETY: the source is composed from this project's own modules alone. Every index in
            // them is below the length of its buffer because the host sizes buffers and records
            // together; a test renders scenes with full checks and finds the same bits.
            unsafe { device.create_shader_module_trusted(source, checks) }
        }
    }
}

fn layout_entry(b: &Binding) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: b.binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: binding_type(b.access),
        count: None,
    }
}

fn binding_type(access: Access) -> wgpu::BindingType {
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    match access {
        Access::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        Access::ReadOnlyStorage => buffer(wgpu::BufferBindingType::Storage { read_only: true }),
        Access::Storage => buffer(wgpu::BufferBindingType::Storage { read_only: false }),
        Access::ReadOnlyImage => wgpu::BindingType::StorageTexture {
            access: wgpu::StorageTextureAccess::ReadOnly,
            format: wgpu::TextureFormat::Rgba32Uint,
            view_dimension: wgpu::TextureViewDimension::D2,
        },
    }
}

fn group_entry<'a>(b: &Binding, resources: &'a Resources) -> Result<wgpu::BindGroupEntry<'a>, RenderError> {
    let resource = match resources.get(b.name.as_str()) {
        Some(Resource::Buffer(buffer)) => buffer.as_entire_binding(),
        Some(Resource::Image(view)) => wgpu::BindingResource::TextureView(view),
        None => {
            return Err(RenderError::Binding { name: b.name.clone() });
        }
    };
    Ok(wgpu::BindGroupEntry { binding: b.binding, resource })
}
