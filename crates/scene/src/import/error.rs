//! Errors of reading a scene or an environment.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a file was refused: one sentence that names the file, the place in it where that helps, and
/// the cause.
#[derive(Debug, Error)]
pub enum LoadError {
    /// A file is missing or cannot be read.
    #[error("cannot read {}: {source}.", path.display())]
    Read {
        /// The requested file, or one that it refers to.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The file is no glTF 2.0 at all, or is cut short.
    #[error("{} is not a readable glTF 2.0 file: {cause}.", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The defect of its container, its JSON or its version.
        cause: String,
    },
    /// A part of the file breaks glTF's rules in a way that leaves nothing sensible to draw.
    #[error("{}: {place} {cause}.", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// The object, by kind and index: for example `accessor 3`.
        place: String,
        /// Its defect.
        cause: String,
    },
    /// The file cannot be drawn without an extension that Surelight does not have.
    #[error("{} requires the extension {extension}, which is not supported{remedy}.", path.display())]
    RequiredExtension {
        /// The file.
        path: PathBuf,
        /// The extension's name.
        extension: String,
        /// How to convert the file, where a way is known; begins with `: ` then.
        remedy: &'static str,
    },
    /// The file needs more memory than the limits of [`crate::LoadOptions`] allow.
    #[error("{}: {place} {cause}.", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The object, by kind and index.
        place: String,
        /// The figure and the limit.
        cause: String,
    },
    /// An environment map cannot be decoded.
    #[error("{} cannot be used as an environment map: {cause}.", path.display())]
    Environment {
        /// The file.
        path: PathBuf,
        /// The error of the decoder.
        cause: String,
    },
}

/// The cause of an input/output error, in terms of the path.
pub(crate) fn io_cause(error: &std::io::Error) -> String {
    use std::io::ErrorKind as Kind;
    match error.kind() {
        Kind::NotFound => "it does not exist".into(),
        Kind::PermissionDenied => "permission is denied".into(),
        Kind::IsADirectory => "it is a folder".into(),
        Kind::NotADirectory => "a part of the path is not a folder".into(),
        Kind::InvalidFilename => "its name is too long for the file system".into(),
        kind => kind.to_string(),
    }
}

/// A [`LoadError`] before the path of the scene file is known.
#[derive(Clone, Debug)]
pub(crate) enum Fault {
    /// A referenced file cannot be read.
    Read { path: PathBuf, kind: std::io::ErrorKind, text: String },
    /// See [`LoadError::Format`].
    Format(String),
    /// See [`LoadError::Invalid`].
    Invalid { place: String, cause: String },
    /// See [`LoadError::TooLarge`].
    TooLarge { place: String, cause: String },
    /// See [`LoadError::RequiredExtension`].
    RequiredExtension { extension: String, remedy: &'static str },
}

pub(crate) type Result<T> = std::result::Result<T, Fault>;

impl Fault {
    /// Something wrong at a place such as `accessor 3`.
    pub(crate) fn invalid(place: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::Invalid { place: place.into(), cause: cause.into() }
    }

    /// A limit of [`crate::LoadOptions`] that would be passed.
    pub(crate) fn too_large(place: impl Into<String>, cause: impl Into<String>) -> Self {
        Self::TooLarge { place: place.into(), cause: cause.into() }
    }

    /// An index that points past the end of a top-level array.
    pub(crate) fn no_such(place: impl Into<String>, kind: &str, index: usize, count: usize) -> Self {
        let cause = match count {
            0 => format!("refers to {kind} {index}, but the file has none"),
            1 => format!("refers to {kind} {index}, but the file has only {kind} 0"),
            _ => format!("refers to {kind} {index}, but the last one is {}", count - 1),
        };
        Self::invalid(place, cause)
    }

    /// Says on whose behalf an accessor or a buffer was read: `accessor 3 (NORMAL of mesh 0,
    /// primitive 1)`.
    pub(crate) fn used_by(self, user: &str) -> Self {
        match self {
            Self::Invalid { place, cause } if !place.contains('(') => {
                Self::Invalid { place: format!("{place} ({user})"), cause }
            }
            other => other,
        }
    }

    /// The error that [`crate::load`] returns.
    pub(crate) fn at(self, file: &Path) -> LoadError {
        let scene = file.to_path_buf();
        match self {
            Self::Read { path, kind, text } => LoadError::Read { path, source: std::io::Error::new(kind, text) },
            Self::Format(cause) => LoadError::Format { path: scene, cause },
            Self::Invalid { place, cause } => LoadError::Invalid { path: scene, place, cause },
            Self::TooLarge { place, cause } => LoadError::TooLarge { path: scene, place, cause },
            Self::RequiredExtension { extension, remedy } => {
                LoadError::RequiredExtension { path: scene, extension, remedy }
            }
        }
    }

    /// The fault as half a sentence, for a warning about something that can be done without.
    pub(crate) fn reason(&self) -> String {
        match self {
            Self::Read { path, text, .. } => format!("{} cannot be read ({text})", path.display()),
            Self::Format(cause) => cause.clone(),
            Self::Invalid { place, cause } | Self::TooLarge { place, cause } => format!("{place} {cause}"),
            Self::RequiredExtension { extension, .. } => format!("it needs {extension}"),
        }
    }
}
