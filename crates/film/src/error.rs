//! Errors of this crate. Each reads as a sentence that names the file and the cause.

use std::path::PathBuf;

/// A batch, a feature image or another film that does not fit this film.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FilmError {
    /// The batch carries another number of sums than of lanes.
    #[error("the batch has {sums} sums for {lanes} lanes; it needs one sum per lane")]
    LaneCount {
        /// Entries of the lane-to-pixel table.
        lanes: usize,
        /// Sums given.
        sums: usize,
    },
    /// A lane names a pixel outside the image.
    #[error("lane {lane} names pixel {pixel}, but the image has {pixels} pixels")]
    PixelOutOfRange {
        /// The lane at fault.
        lane: usize,
        /// The pixel that it names.
        pixel: u32,
        /// Pixels in the image.
        pixels: usize,
    },
    /// Two lanes of one batch name the same pixel.
    #[error("pixel {pixel} is named by two lanes of one batch; a batch holds a pixel once")]
    PixelTwice {
        /// The pixel named twice.
        pixel: u32,
    },
    /// A batch of no samples.
    #[error("a batch must hold at least one sample per pixel")]
    NoSamples,
    /// A film that is no part of this one.
    #[error("the part {inner:?} (x0, y0, x1, y1) is not within {outer:?} of the same image")]
    Outside {
        /// Edges of the part: x0, y0, x1, y1.
        inner: [u32; 4],
        /// Edges of the film.
        outer: [u32; 4],
    },
    /// Images of different size.
    #[error("the {what} image has {found} pixels where the film has {expected}")]
    Size {
        /// Which image.
        what: &'static str,
        /// Pixels found.
        found: usize,
        /// Pixels of the film.
        expected: usize,
    },
}

/// A file that could not be written; its target is as it was before.
#[derive(Debug, thiserror::Error)]
#[error("The file \"{}\" could not be written: {cause}.", path.display())]
pub struct WriteError {
    /// The target.
    pub path: PathBuf,
    /// The cause, without a full stop.
    pub cause: String,
}

impl WriteError {
    pub(crate) fn new(path: &std::path::Path, cause: impl Into<String>) -> Self {
        Self { path: path.to_owned(), cause: cause.into() }
    }
}

/// A file that could not be read.
#[derive(Debug, thiserror::Error)]
#[error("The file \"{}\" could not be read: {cause}.", path.display())]
pub struct ReadError {
    /// The file.
    pub path: PathBuf,
    /// The cause, without a full stop.
    pub cause: String,
}

impl ReadError {
    pub(crate) fn new(path: &std::path::Path, cause: impl Into<String>) -> Self {
        Self { path: path.to_owned(), cause: cause.into() }
    }
}

/// The cause of an input/output error, in terms of the path.
pub fn io_cause(error: &std::io::Error) -> String {
    use std::io::ErrorKind as Kind;
    match error.kind() {
        Kind::NotFound => "it does not exist".into(),
        Kind::PermissionDenied => "permission is denied".into(),
        Kind::StorageFull => "the disk is full".into(),
        Kind::QuotaExceeded => "the disk quota is used up".into(),
        Kind::ReadOnlyFilesystem => "the file system is read-only".into(),
        Kind::FileTooLarge => "it would be larger than the limit on file sizes".into(),
        Kind::IsADirectory => "it is a folder".into(),
        Kind::NotADirectory => "a part of its path is not a folder".into(),
        // The number of the error means nothing to a user.
        _ => error.to_string().split(" (os error").next().unwrap_or_default().to_owned(),
    }
}
