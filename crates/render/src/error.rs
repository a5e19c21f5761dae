//! What can go wrong between a scene and its pixels, in sentences.

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// No adapter at all.
    #[error(
        "no graphics adapter was found: install a Vulkan, Metal or DX12 driver (on Linux, ./setup.sh installs a software one)"
    )]
    NoAdapter,
    /// Parts of a kernel that exclude one another: a defect of this crate, or a blueprint of a caller.
    #[error("the kernel cannot be made: {0}")]
    Kernel(#[from] crate::kernel_key::KeyError),
    /// None that was asked for.
    #[error("no adapter matches \"{wanted}\"; there is: {available}")]
    UnknownAdapter {
        /// What was asked for.
        wanted: String,
        /// Names of those present.
        available: String,
    },
    /// The adapter gave no device.
    #[error("the adapter \"{adapter}\" cannot be opened: {message}; --adapter chooses another")]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why.
        message: String,
    },
    /// The driver dropped the device.
    #[error("the device \"{adapter}\" was lost: {message}; --adapter chooses another")]
    DeviceLost {
        /// Its name.
        adapter: String,
        /// What the driver said.
        message: String,
    },
    /// The driver refused something.
    #[error("the device refused {what}: {message}")]
    Device {
        /// What was being done.
        what: String,
        /// What it said.
        message: String,
    },
    /// A resource is larger than the adapter can bind.
    #[error("{what} needs {needed} MiB, but \"{adapter}\" can bind at most {limit} MiB ({limit_name})")]
    TooLarge {
        /// Which resource.
        what: String,
        /// MiB needed.
        needed: u64,
        /// MiB available.
        limit: u64,
        /// The limit's name.
        limit_name: &'static str,
        /// Adapter.
        adapter: String,
    },
    /// A dispatch did not do all its work.
    #[error("the driver lost work: {message}; the picture would be wrong, so nothing is written")]
    LostWork {
        /// What is missing.
        message: String,
    },
    /// A shader did not compose or validate: a defect of this program.
    #[error("Surelight has a defect, please report it: the shader {root} does not compile: {message}")]
    Shader {
        /// Root module.
        root: String,
        /// The compiler's message.
        message: String,
    },
    /// The scene could not be made into a BVH.
    #[error(transparent)]
    Accel(#[from] surelight_accel::AccelError),
}
