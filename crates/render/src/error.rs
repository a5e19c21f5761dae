//! Errors of rendering.

use surelight_film::FilmError;
use surelight_prepare::PrepareError;

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
    /// No adapter matches the request.
    #[error("no adapter matches \"{wanted}\"; available: {available}")]
    UnknownAdapter {
        /// The requested name or index.
        wanted: String,
        /// Names of the available adapters.
        available: String,
    },
    /// The adapter cannot be opened.
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
        /// The driver's message.
        message: String,
    },
    /// The driver refused an operation.
    #[error("the device refused {what}: {source}")]
    Device {
        /// The work that failed.
        what: String,
        /// Its message.
        source: Source,
    },
    /// A resource is larger than the adapter can bind.
    #[error("{what} needs {needed} MiB, but \"{adapter}\" can bind at most {limit} MiB ({limit_name})")]
    TooLarge {
        /// Which resource.
        what: String,
        /// MiB required.
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
        /// The missing results.
        message: String,
    },
    /// A kernel binds something that the host does not have: a defect of this program.
    #[error("Surelight has a defect, please report it: the host has no resource \"{name}\" that a kernel binds")]
    Binding {
        /// Name of the resource.
        name: String,
    },
    /// The film and the view have different sizes.
    #[error(
        "the film is of an image of {}x{} pixels, the view of one of {}x{}", film[0], film[1], view[0], view[1]
    )]
    FilmSize {
        /// Pixels of the film's whole image: width, height.
        film: [u32; 2],
        /// Pixels of the view.
        view: [u32; 2],
    },
    /// More batches than one call can hold.
    #[error("{batches} batches do not fit in one call: the limit is {limit}")]
    TooManyBatches {
        /// Batches requested.
        batches: u32,
        /// [`crate::Renderer::max_batches`].
        limit: u32,
    },
    /// The film refused the traced samples.
    #[error("the traced samples do not fit the film: {0}")]
    Film(#[from] FilmError),
    /// The scene cannot be prepared.
    #[error(transparent)]
    Prepare(#[from] PrepareError),
}
