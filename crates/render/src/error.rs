//! What can go wrong between a scene and its pixels, in sentences.

use surelight_accel::AccelError;
use surelight_film::FilmError;
use surelight_scene::SceneError;

/// An error of the driver or of a compiler.
pub(crate) type Source = Box<dyn std::error::Error + Send + Sync>;

/// An error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    #[error(
        "the adapter \"{adapter}\" cannot be opened: {}; --adapter chooses another",
        .source.to_string().trim_end_matches('.')
    )]
    NoDevice {
        /// Its name.
        adapter: String,
        /// Why.
        source: Source,
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
    #[error("the device refused {what}: {source}")]
    Device {
        /// What was being done.
        what: String,
        /// What it said.
        source: Source,
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
        /// The compiler's message, with the lines of the source where there are some.
        message: String,
        /// The compiler's error; none where a resource is missing.
        source: Option<Source>,
    },
    /// The film is of another image than the view.
    #[error(
        "the film is of an image of {}x{} pixels, the view of one of {}x{}", film[0], film[1], view[0], view[1]
    )]
    FilmSize {
        /// Pixels of the film's whole image: width, height.
        film: [u32; 2],
        /// Pixels of the view.
        view: [u32; 2],
    },
    /// More batches at once than there is room for.
    #[error("{batches} batches do not fit one call: there is room for {limit}")]
    TooManyBatches {
        /// Batches requested.
        batches: u32,
        /// [`crate::Renderer::most_batches`].
        limit: u32,
    },
    /// The film refused what was traced.
    #[error("what was traced does not fit the film: {0}")]
    Film(#[from] FilmError),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene could not be made into a BVH.
    #[error(transparent)]
    Accel(#[from] AccelError),
}
