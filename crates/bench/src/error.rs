//! What ends a race early.

use std::path::{Path, PathBuf};

/// A race or a report that cannot be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// The device or the renderer.
    #[error(transparent)]
    Render(#[from] surelight_render::RenderError),
    /// Films that do not fit together.
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
        /// Which.
        path: PathBuf,
        /// The fault, as the end of a sentence.
        cause: String,
    },
    /// A reference that does not fit the scene.
    #[error("the reference \"{}\" does not fit: {cause}", path.display())]
    Reference {
        /// The image.
        path: PathBuf,
        /// Why.
        cause: String,
    },
    /// A chart that could not be drawn.
    #[error("the chart \"{name}\" could not be drawn: {cause}")]
    Chart {
        /// Which.
        name: String,
        /// Why.
        cause: String,
    },
    /// Reports that have nothing in common.
    #[error("the reports cannot be compared: {0}")]
    Compare(String),
    /// Stopped before there was anything to report.
    #[error("interrupted before anything was measured; nothing was written")]
    Interrupted,
}

impl From<surelight_prepare::PrepareError> for BenchError {
    fn from(error: surelight_prepare::PrepareError) -> Self {
        Self::Render(error.into())
    }
}

impl BenchError {
    /// Something about a file.
    pub(crate) fn file(path: &Path, cause: impl std::fmt::Display) -> Self {
        Self::File { path: path.to_owned(), cause: cause.to_string() }
    }
}
