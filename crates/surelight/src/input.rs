//! The source of a scene: a file, or standard input.

use std::convert::Infallible;
use std::ffi::{OsStr, OsString};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, TypedValueParser};
use surelight_scene::{LoadError, LoadOptions, Scene};

/// The name of `-` in messages and records.
const STANDARD_INPUT: &str = "standard input";

/// Maximum number of bytes of standard input: a .glb states its length in 32 bits.
const MAX_BYTES: u64 = 4 << 30;

/// Leading bytes that show whether the stream is a scene at all.
const HEAD: u64 = 4096;

/// The source that `SCENE` names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum SceneSource {
    /// A .glb or .gltf file.
    File(PathBuf),
    /// `-`.
    StandardInput,
}

/// Parses `SCENE`, which need not be UTF-8.
pub(crate) fn scene_sources() -> impl TypedValueParser<Value = SceneSource> {
    OsStringValueParser::new().try_map(|text| Ok::<_, Infallible>(SceneSource::of(text)))
}

impl SceneSource {
    fn of(text: OsString) -> Self {
        if text == "-" { Self::StandardInput } else { Self::File(text.into()) }
    }

    /// As messages and records name it.
    pub(crate) fn name(&self) -> &Path {
        self.file().unwrap_or(Path::new(STANDARD_INPUT))
    }

    /// The file, where it is one.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::StandardInput => None,
        }
    }

    /// The stem of output names.
    pub(crate) fn stem(&self) -> &OsStr {
        self.file().map_or(OsStr::new("stdin"), |path| path.file_stem().unwrap_or(OsStr::new("surelight")))
    }

    /// Reads the scene. From standard input it must be all that the scene consists of.
    pub(crate) fn load(&self, options: &LoadOptions) -> Result<Scene, LoadError> {
        let Some(path) = self.file() else {
            let limit = options.max_buffer_bytes.min(MAX_BYTES);
            let bytes = read(std::io::stdin().lock(), limit)
                .map_err(|source| LoadError::Read { path: STANDARD_INPUT.into(), source })?;
            let options = LoadOptions { self_contained: true, ..options.clone() };
            return surelight_scene::load_bytes(&bytes, self.name(), &options);
        };
        surelight_scene::load(path, options)
    }
}

/// All bytes of a stream; the first ones alone where these are no beginning of a scene, which the
/// importer then reports.
fn read(mut stream: impl Read, limit: u64) -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    stream.by_ref().take(HEAD.min(limit)).read_to_end(&mut bytes)?;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let is_json = text.iter().find(|byte| !byte.is_ascii_whitespace()) == Some(&b'{');
    if !is_json && !bytes.starts_with(b"glTF") {
        return Ok(bytes);
    }
    stream.take(limit - bytes.len() as u64 + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(std::io::Error::new(ErrorKind::FileTooLarge, format!("it holds more than {limit} bytes")));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dash_is_standard_input_and_a_file_of_that_name_is_not() {
        assert_eq!(SceneSource::of("-".into()).stem(), "stdin");
        assert_eq!(SceneSource::of("./-".into()).file(), Some(Path::new("./-")));
        assert_eq!(SceneSource::of("a/b.glb".into()).stem(), "b");
    }

    #[test]
    fn endless_streams_are_bounded() {
        assert_eq!(read(std::io::repeat(0), 1 << 40).unwrap().len() as u64, HEAD);
        let glb = |limit| read(b"glTF".chain(std::io::repeat(7)), limit);
        assert_eq!(glb(10_000).unwrap_err().kind(), ErrorKind::FileTooLarge);
        let json = || &b"  {} "[..];
        assert_eq!(read(json(), 5).unwrap(), json());
        assert!(read(json(), 4).is_err());
    }
}
