//! The path kernel, compiled while the BVH is still built.
//!
//! What a kernel is made from is known before the trees are, but for their depth, which is nearly always less than what is
//! allowed for ([`crate::prepare`]). Where the guess was wrong, the kernel is composed and compiled again; the picture is the same.

use surelight_prepare::{Access, Binding, Blueprint, Composed, KernelKey, RecordLayout, compose, path_kernel};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Program, Resource, Resources},
    pass::{GROUP, Pass},
    schedule::{PATH_ENTRY, cpu_threads},
    upload::Uploader,
};

/// A compiled path kernel that waits for its scene.
pub struct Ahead {
    /// What it was made from, the device's choices included.
    blueprint: Blueprint,
    device: wgpu::Device,
    pub(crate) shader: Composed,
    pub(crate) program: Program,
}

impl Ahead {
    /// Composes and compiles the kernel, and runs it over nothing: drivers compile at the first dispatch.
    pub fn compile(device: &Device, blueprint: &Blueprint) -> Result<Self, RenderError> {
        let blueprint = blueprint.on_images(device.reads_images());
        let shader = compose(path_kernel(&blueprint.key()).0, &blueprint.key(), &blueprint.constants)?;
        let program = Program::new(device, &shader, PATH_ENTRY, Checks::default())?;
        let threads = if device.info.is_cpu { cpu_threads() } else { 1 };
        let pass = Pass { size: [8, 8], samples: 1, lanes: GROUP * threads, threads, restart: 1, ..Pass::default() };
        let kernel = program.bind(device, &stand_ins(device, &blueprint.key(), &shader, &program, &pass)?)?;
        run(device, &kernel, pass.lanes / GROUP)?;
        Ok(Self { blueprint, device: device.device.clone(), shader, program })
    }

    /// Whether it is the kernel that the blueprint asks for.
    pub(crate) fn is_of(&self, device: &Device, blueprint: &Blueprint) -> bool {
        self.device == device.device && self.blueprint == *blueprint
    }
}

/// Something of the right kind for each binding. No lane starts a sample, so that nothing of the scene is read.
fn stand_ins(
    device: &Device,
    key: &KernelKey,
    shader: &Composed,
    program: &Program,
    pass: &Pass,
) -> Result<Resources, RenderError> {
    use wgpu::BufferUsages as U;
    /// More than any record but the states takes.
    const BYTES: u64 = 1 << 12;
    let mut up = Uploader::new(device);
    let state = RecordLayout::of(shader, path_kernel(key).1).map_or(256, |l| l.span);
    let states = u64::from(pass.lanes) * u64::from(state);
    let mut resources = Resources::new();
    for Binding { name, access, .. } in program.bindings() {
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

fn run(device: &Device, kernel: &Kernel, workgroups: u32) -> Result<(), RenderError> {
    device.scoped("a kernel's first dispatch", || {
        let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        kernel.record(&mut encoder, workgroups, None);
        device.queue.submit([encoder.finish()]);
    })?;
    device.wait()
}
