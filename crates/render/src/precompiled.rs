//! The path kernel, compiled while the BVH is still built.
//!
//! The contents of a kernel are known before the trees are, except for their depth, which is
//! nearly always less than the room left for it ([`Blueprint`]). Where the guess was wrong, the
//! kernel is composed and compiled again; the image is the same.

use surelight_prepare::{Access, Binding, Blueprint, KernelKey, RecordLayout, path_kernel};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Resource, Resources},
    kernel_set::CompiledShader,
    lanes::driver_threads,
    pass::{GROUP, Pass, warm_up},
    upload::Uploader,
};

/// A compiled path kernel that is not bound to its scene yet.
pub struct PrecompiledKernel {
    /// Its blueprint, the device's choices included.
    blueprint: Blueprint,
    device: wgpu::Device,
    pub(crate) compiled: CompiledShader,
}

impl PrecompiledKernel {
    /// Composes and compiles the kernel, and dispatches an empty pass: drivers compile at the first
    /// dispatch.
    pub fn compile(device: &Device, blueprint: &Blueprint) -> Result<Self, RenderError> {
        let blueprint = blueprint.on_images(device.reads_images());
        let compiled = CompiledShader::of_paths(device, &blueprint, Checks::default())?;
        let pass = warm_up(driver_threads(device));
        let resources = placeholders(device, &blueprint.key(), &compiled, &pass)?;
        dispatch(device, &compiled.program.bind(device, &resources)?, pass.lanes / GROUP)?;
        Ok(Self { blueprint, device: device.device.clone(), compiled })
    }

    /// Whether it is the kernel of this blueprint on this device.
    pub(crate) fn is_of(&self, device: &Device, blueprint: &Blueprint) -> bool {
        self.device == device.device && self.blueprint == *blueprint
    }
}

/// A placeholder of the right kind for each binding. No lane starts a sample, so nothing of the
/// scene is read.
fn placeholders(
    device: &Device,
    key: &KernelKey,
    compiled: &CompiledShader,
    pass: &Pass,
) -> Result<Resources, RenderError> {
    use wgpu::BufferUsages as U;
    /// More than the size of any record except the states.
    const BYTES: u64 = 1 << 12;
    let mut up = Uploader::new(device);
    let state = RecordLayout::of(&compiled.shader, path_kernel(key).1).map_or(256, |l| l.span);
    let states = u64::from(pass.lanes) * u64::from(state);
    let mut resources = Resources::new();
    for Binding { name, access, .. } in compiled.program.bindings() {
        let resource = match access {
            Access::ReadOnlyImage => Resource::Image(up.image::<u8>(name, &[])?),
            Access::Uniform if name == "pass_info" => Resource::Buffer(up.buffer(name, &[*pass], U::UNIFORM)?),
            Access::Uniform => Resource::Buffer(up.zeros(name, BYTES, U::UNIFORM)?),
            _ => Resource::Buffer(up.zeros(name, states.max(BYTES), U::STORAGE)?),
        };
        resources.insert(name.clone().into(), resource);
    }
    Ok(resources)
}

fn dispatch(device: &Device, kernel: &Kernel, workgroups: u32) -> Result<(), RenderError> {
    device.scoped("a kernel's first dispatch", || {
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        kernel.record(&mut encoder, workgroups, None);
        device.queue.submit([encoder.finish()]);
    })?;
    device.wait()
}
