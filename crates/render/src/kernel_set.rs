//! The kernels of a scene: composed and compiled first, bound to buffers once these are made.

use surelight_prepare::{Blueprint, Composed, Prepared, compose, path_kernel};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Program, Resources},
    precompiled::PrecompiledKernel,
};

/// Entry point of both path kernels.
const PATH_ENTRY: &str = "trace_paths";

/// Root modules of the kernels for first-hit features and for light tracing.
const FEATURE_ROOT: &str = "package::kernel::first_hit";
const LIGHT_TRACING_KERNEL: &str = "package::kernel::light_tracing";

/// A composed shader and its compiled entry point.
pub(crate) struct CompiledShader {
    pub(crate) shader: Composed,
    pub(crate) program: Program,
}

impl CompiledShader {
    fn new(device: &Device, shader: Composed, entry: &str, checks: Checks) -> Result<Self, RenderError> {
        let program = Program::new(device, &shader, entry, checks)?;
        Ok(Self { shader, program })
    }

    /// The path kernel of a blueprint that includes the device's options.
    pub(crate) fn of_paths(device: &Device, blueprint: &Blueprint, checks: Checks) -> Result<Self, RenderError> {
        let key = blueprint.key();
        Self::new(device, compose(path_kernel(&key).0, &key, &blueprint.constants)?, PATH_ENTRY, checks)
    }
}

/// All compiled entry points of a scene, without bind groups.
pub(crate) struct CompiledSet {
    pub(crate) paths: CompiledShader,
    features: CompiledShader,
    /// Where particles are traced from the lights.
    pub(crate) particles: Option<CompiledShader>,
}

impl CompiledSet {
    /// Composes and compiles; uses `precompiled` where it is the scene's path kernel.
    pub(crate) fn new(
        device: &Device,
        prepared: &Prepared,
        blueprint: &Blueprint,
        checks: Checks,
        precompiled: Option<PrecompiledKernel>,
    ) -> Result<Self, RenderError> {
        let key = blueprint.key();
        let paths = match precompiled.filter(|kernel| kernel.is_of(device, blueprint)) {
            Some(kernel) => kernel.compiled,
            None => CompiledShader::of_paths(device, blueprint, checks)?,
        };
        let features = compose(FEATURE_ROOT, &key.first_hits(), &blueprint.constants)?;
        let features = CompiledShader::new(device, features, "trace_features", checks)?;
        let particles = match prepared.light_tracing() {
            Some(_) => {
                let shader = compose(LIGHT_TRACING_KERNEL, &key, &prepared.constants())?;
                Some(CompiledShader::new(device, shader, "trace_particles", checks)?)
            }
            None => None,
        };
        Ok(Self { paths, features, particles })
    }

    /// The WGSL of the path kernel and, where there is one, of the light tracing kernel.
    pub(crate) fn wgsl(&self) -> String {
        let shaders = [Some(&self.paths), self.particles.as_ref()];
        shaders.into_iter().flatten().map(|compiled| compiled.shader.wgsl.as_str()).collect()
    }

    /// Binds each kernel to its resources.
    pub(crate) fn bind(&self, device: &Device, resources: &Resources) -> Result<KernelSet, RenderError> {
        let bind = |compiled: &CompiledShader| compiled.program.bind(device, resources);
        Ok(KernelSet {
            paths: bind(&self.paths)?,
            features: bind(&self.features)?,
            particles: self.particles.as_ref().map(bind).transpose()?,
        })
    }
}

/// The kernels of a scene, ready for dispatch. Drivers may compile each at its first dispatch.
pub(crate) struct KernelSet {
    pub(crate) paths: Kernel,
    /// First-hit albedo, normal and depth.
    pub(crate) features: Kernel,
    /// Where particles are traced from the lights.
    pub(crate) particles: Option<Kernel>,
}
