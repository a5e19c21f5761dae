//! Errors of races and reports.

use std::path::{Path, PathBuf};

/// An error of a race or a report.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// An error of the device or the renderer.
    #[error(transparent)]
    Render(#[from] surelight_render::RenderError),
    /// Films that cannot be combined.
    #[error(transparent)]
    Film(#[from] surelight_film::FilmError),
    /// A file that could not be written.
    #[error(transparent)]
    Write(#[from] surelight_film::WriteError),
    /// An image that could not be read.
    #[error(transparent)]
    Read(#[from] surelight_film::ReadError),
    /// A report, a list of points or a folder that is malformed.
    #[error("\"{}\" {cause}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// The fault, as the end of a sentence.
        cause: String,
    },
    /// A reference that does not fit the scene.
    #[error("the reference \"{}\" does not fit: {cause}", path.display())]
    Reference {
        /// The path of the image.
        path: PathBuf,
        /// Why.
        cause: String,
    },
    /// A chart that could not be drawn.
    #[error("the chart \"{name}\" could not be drawn: {cause}")]
    Chart {
        /// Its name.
        name: String,
        /// Why.
        cause: String,
    },
    /// Reports without a method on a scene in common.
    #[error("the reports cannot be compared: {0}")]
    Compare(String),
    /// Stopped before the first measurement.
    #[error("interrupted before anything was measured; nothing was written")]
    Interrupted,
}

impl From<surelight_prepare::PrepareError> for BenchError {
    fn from(error: surelight_prepare::PrepareError) -> Self {
        Self::Render(error.into())
    }
}

impl BenchError {
    /// An error about a file.
    pub(crate) fn file(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::File { path: path.to_owned(), cause: cause.to_string() }
    }
}
