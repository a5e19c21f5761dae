//! URIs: `data:`, and relative paths that stay inside the scene's folder.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::error::{Fault, Result};

/// Padding may be missing and stray bits set: exporters do both.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Reads what a URI refers to; `place` is the object that holds it.
pub(crate) fn read(uri: &str, folder: &Path, limit: u64, place: &str) -> Result<Vec<u8>> {
    match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data:") => decode_data(&uri[5..], limit, place),
        _ => {
            let path = resolve(uri, folder, place)?;
            // Opening a pipe would wait for a writer.
            match path.metadata() {
                Ok(metadata) if !metadata.is_file() => {
                    Err(Fault::invalid(place, format!("refers to {}, which is no regular file", path.display())))
                }
                _ => read_file(&path, limit, place),
            }
        }
    }
}

/// Bytes behind a URI without reading them, or a little more for `data:`; 0 when there are none.
pub(crate) fn size(uri: &str, folder: &Path) -> u64 {
    match uri.get(..5) {
        Some(scheme) if scheme.eq_ignore_ascii_case("data:") => uri.len() as u64,
        _ => resolve(uri, folder, "").ok().and_then(|path| path.metadata().ok()).map_or(0, |metadata| metadata.len()),
    }
}

/// Path of the file that a URI names, relative to the scene's folder; `None` where it
/// names none, as `data:` does.
pub(crate) fn file_name(uri: &str, folder: &Path) -> Option<String> {
    let path = resolve(uri, folder, "").ok()?;
    Some(path.strip_prefix(folder).ok()?.to_string_lossy().into_owned())
}

/// A URI as shown in messages: data URIs are cut.
pub(crate) fn shown(uri: &str) -> String {
    const LONGEST: usize = 80;
    if uri.len() <= LONGEST {
        return uri.to_owned();
    }
    let head: String = uri.chars().take(LONGEST - 1).collect();
    format!("{head}…")
}

fn decode_data(rest: &str, limit: u64, place: &str) -> Result<Vec<u8>> {
    let Some((media, payload)) = rest.split_once(',') else {
        return Err(Fault::invalid(place, "has a data: URI without a comma"));
    };
    if payload.len() as u64 / 4 * 3 > limit {
        return Err(Fault::too_large(place, format!("has a data: URI of more than {limit} bytes")));
    }
    let bytes: Vec<u8> = percent_decode_str(payload).collect();
    if !media.trim_end().to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    BASE64.decode(&bytes).map_err(|e| Fault::invalid(place, format!("has a data: URI that is not base64: {e}")))
}

/// The file that a relative URI names; refuses to leave the folder, by `..`, absolute paths, schemes or links.
fn resolve(uri: &str, folder: &Path, place: &str) -> Result<PathBuf> {
    let refuse = |cause: String| Err(Fault::invalid(place, cause));
    if uri.is_empty() {
        return refuse("has an empty URI".into());
    }
    if let Some((scheme, _)) = uri.split_once(':')
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
        && !scheme.is_empty()
    {
        return refuse(format!("has the URI {}, and only data: and relative ones are read", shown(uri)));
    }
    let Ok(decoded) = percent_decode_str(uri).decode_utf8() else {
        return refuse(format!("has the URI {}, which is not UTF-8 once decoded", shown(uri)));
    };
    if decoded.contains('\0') {
        return refuse(format!("has the URI {}, which holds a zero byte", shown(uri)));
    }
    // Before the file system is asked anything: on Windows even looking for a network share goes out to the network.
    // Windows exporters write back-slashes, so they separate, whatever the platform.
    let slashed = decoded.replace('\\', "/");
    if leaves(&slashed) || leaves(&uri.replace('\\', "/")) {
        return refuse(format!("has the URI {}, which leaves the scene's folder", shown(uri)));
    }
    // A name with a literal % that the exporter forgot to encode exists as it stands.
    let candidates = [decoded.as_ref(), uri, slashed.as_str()];
    let name = candidates.into_iter().find(|name| folder.join(name).exists()).unwrap_or(&decoded);
    let path = folder.join(name);
    // Links could still lead out. A missing file is told when it is opened.
    if let (Ok(real), Ok(root)) = (path.canonicalize(), folder.canonicalize())
        && !real.starts_with(&root)
    {
        return refuse(format!("has the URI {}, a link that leaves the scene's folder", shown(uri)));
    }
    Ok(path)
}

/// Whether a path with `/` between its parts is absolute or climbs above where it starts.
fn leaves(path: &str) -> bool {
    let mut depth = 0_i64;
    let drive = path.as_bytes().get(1) == Some(&b':');
    path.starts_with('/')
        || drive
        || path.split('/').any(|part| {
            depth += match part {
                "" | "." => 0,
                ".." => -1,
                _ => 1,
            };
            depth < 0
        })
}

/// Reads a whole file, refusing one above the limit before its bytes are in memory.
pub(crate) fn read_file(path: &Path, limit: u64, place: &str) -> Result<Vec<u8>> {
    let fault = |e: std::io::Error| Fault::Read { path: path.to_path_buf(), kind: e.kind(), text: e.to_string() };
    let file = File::open(path).map_err(fault)?;
    let metadata = file.metadata().map_err(fault)?;
    if metadata.is_dir() {
        return Err(fault(std::io::ErrorKind::IsADirectory.into()));
    }
    let too_large = || Fault::too_large(place, format!("is {} with more than {limit} bytes", path.display()));
    if metadata.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // Devices and growing files have no honest length.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}
