//! URIs: `data:`, and paths that stay inside the scene's folder or one that the caller allows.

use std::fs::{File, Metadata};
use std::io::{ErrorKind, Read};
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use super::error::{Fault, Result, io_cause};

/// Padding may be missing and stray bits set: exporters do both.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// Entries of a folder that the search for a near match reads.
const MAX_ENTRIES: usize = 1 << 12;

/// The folders in which files of URIs may be.
#[derive(Debug)]
pub(crate) struct Folders<'a> {
    /// The scene's folder, which URIs are relative to.
    scene: &'a Path,
    /// Folders outside it that the caller allows.
    allowed: &'a [PathBuf],
    /// All of them that exist, as canonical paths.
    roots: Vec<PathBuf>,
}

impl<'a> Folders<'a> {
    pub(crate) fn new(scene: &'a Path, allowed: &'a [PathBuf]) -> Self {
        let all = std::iter::once(scene).chain(allowed.iter().map(PathBuf::as_path));
        Self { scene, allowed, roots: all.filter_map(|folder| folder.canonicalize().ok()).collect() }
    }

    /// Whether a canonical path lies in one of the folders.
    fn hold(&self, canonical: &Path) -> bool {
        self.roots.iter().any(|root| canonical.starts_with(root))
    }

    /// The file outside the scene's folder that a path with `/` between its parts names, where the
    /// caller allows it. A file that does not exist is judged by the folder that would hold it.
    fn outside(&self, path: &str) -> Option<PathBuf> {
        if self.allowed.is_empty() {
            return None;
        }
        let path = match path.strip_prefix('/') {
            None => self.scene.join(resolve_dots(path)?.path()),
            Some(rest) => {
                let absolute = PathBuf::from(format!("/{}", without_dots(rest)?));
                // Compared before the path reaches the file system, which may name a network share.
                self.allowed.iter().chain(&self.roots).find(|folder| absolute.starts_with(folder))?;
                absolute
            }
        };
        let real = path.ancestors().find_map(|part| part.canonicalize().ok())?;
        self.hold(&real).then_some(path)
    }

    /// Half a sentence about a file in none of the folders.
    fn refusal(&self) -> &'static str {
        if self.allowed.is_empty() {
            "leaves the scene's folder; --allow-outside DIR lets textures and buffers lie in DIR, too"
        } else {
            "leaves the scene's folder and the folders of --allow-outside"
        }
    }
}

/// Reads the target of a URI; `place` is the object that holds it.
pub(crate) fn read(uri: &str, folders: &Folders, limit: u64, place: &str) -> Result<Vec<u8>> {
    match uri {
        _ if is_data(uri) => decode_data(&uri[5..], limit, place),
        _ => {
            let path = resolve(uri, folders, place)?;
            // Opening a pipe would wait for a writer.
            match path.metadata() {
                Ok(metadata) if !metadata.is_file() => {
                    Err(Fault::invalid(place, format!("refers to {}, which is no regular file", path.display())))
                }
                _ => read_file(&path, limit, place).map_err(|fault| with_near_match(fault, folders)),
            }
        }
    }
}

/// Adds the file that may be meant to a fault about a missing one.
fn with_near_match(fault: Fault, folders: &Folders) -> Fault {
    match fault {
        Fault::Read { path, kind: kind @ ErrorKind::NotFound, text } => {
            let text = match near_match(&path, folders) {
                Some(name) => format!("{text} (did you mean {name}?)"),
                None => text,
            };
            Fault::Read { path, kind, text }
        }
        other => other,
    }
}

/// Bytes behind a URI without reading them, or a little more for `data:`; 0 when there are none.
pub(crate) fn size(uri: &str, folders: &Folders) -> u64 {
    match uri {
        _ if is_data(uri) => uri.len() as u64,
        _ => resolve(uri, folders, "").ok().and_then(|path| path.metadata().ok()).map_or(0, |metadata| metadata.len()),
    }
}

/// Whether a URI holds its bytes itself.
pub(crate) fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Path of the file that a URI names, relative to the scene's folder where the URI is; `None` where
/// it names none, as `data:` does.
pub(crate) fn file_name(uri: &str, folders: &Folders) -> Option<String> {
    let path = resolve(uri, folders, "").ok()?;
    Some(path.strip_prefix(folders.scene).unwrap_or(&path).to_string_lossy().into_owned())
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
    // RFC 3986: a fragment is no part of the data, which must encode a #.
    let payload = payload.split('#').next().unwrap_or_default();
    let mut bytes: Vec<u8> = percent_decode_str(payload).collect();
    if !media.trim_end().to_ascii_lowercase().ends_with(";base64") {
        return Ok(bytes);
    }
    // Encoders that follow MIME break lines.
    bytes.retain(|byte| !byte.is_ascii_whitespace());
    BASE64.decode(&bytes).map_err(|e| Fault::invalid(place, format!("has a data: URI that is not base64: {e}")))
}

/// The file that a URI names; refuses to leave the folders, by `..`, absolute paths, schemes or
/// links.
fn resolve(uri: &str, folders: &Folders, place: &str) -> Result<PathBuf> {
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
    // RFC 3986: query and fragment are no part of the path, but a percent-encoded ? or # is.
    let raw_path = &uri[..uri.find(['?', '#']).unwrap_or(uri.len())];
    let (Ok(path), Ok(whole)) = (percent_decode_str(raw_path).decode_utf8(), percent_decode_str(uri).decode_utf8())
    else {
        return refuse(format!("has the URI {}, which is not UTF-8 once decoded", shown(uri)));
    };
    if whole.contains('\0') {
        return refuse(format!("has the URI {}, which holds a zero byte", shown(uri)));
    }
    // Before any access to the file system: on Windows even a look-up of a network share contacts
    // the network. Windows exporters write back-slashes, so they separate, whatever the platform.
    let slashed = path.replace('\\', "/");
    let (Some(named), Some(_)) = (without_dots(&slashed), without_dots(&raw_path.replace('\\', "/"))) else {
        return match folders.outside(&slashed) {
            Some(path) => Ok(path),
            None => refuse(format!("has the URI {}, which {}", shown(uri), folders.refusal())),
        };
    };
    let folder = folders.scene;
    // Exporters forget to encode: a file may also have a literal %, ?, # or back-slash in its name.
    // On Windows its back-slashes separate.
    let stays = |name: &&str| without_dots(&name.replace('\\', "/")).is_some();
    let literal = [&path, raw_path, &whole, uri].into_iter().filter(stays).filter_map(without_dots);
    let mut candidates = std::iter::once(named.clone()).chain(literal).filter(|name| !name.is_empty());
    let name = candidates.find(|name| folder.join(name).exists()).unwrap_or(named);
    if name.is_empty() {
        return refuse(format!("has the URI {}, which names no file", shown(uri)));
    }
    let path = folder.join(name);
    // Links could still lead out. A missing file is reported when it is opened.
    if path.canonicalize().is_ok_and(|real| !folders.hold(&real)) {
        return refuse(format!("has the URI {}, a link that {}", shown(uri), folders.refusal()));
    }
    Ok(path)
}

/// A relative path whose dot segments are resolved.
struct Resolved<'a> {
    /// Folders that it climbs above where it starts.
    climbs: usize,
    parts: Vec<&'a str>,
}

impl Resolved<'_> {
    /// As a path again.
    fn path(&self) -> String {
        "../".repeat(self.climbs) + &self.parts.join("/")
    }
}

/// Resolves the dot segments of a path with `/` between its parts; `None` when it is absolute.
fn resolve_dots(path: &str) -> Option<Resolved<'_>> {
    let drive = path.as_bytes().get(1) == Some(&b':');
    if path.starts_with('/') || drive {
        return None;
    }
    let mut resolved = Resolved { climbs: 0, parts: Vec::new() };
    for part in path.split('/') {
        match part {
            "" | "." => {}
            ".." if resolved.parts.pop().is_some() => {}
            ".." => resolved.climbs += 1,
            _ => resolved.parts.push(part),
        }
    }
    Some(resolved)
}

/// The same as a path; `None` also when it climbs above its start.
fn without_dots(path: &str) -> Option<String> {
    resolve_dots(path).filter(|resolved| resolved.climbs == 0).map(|resolved| resolved.path())
}

/// The file in one of the folders whose path differs from the missing `path` in upper and lower
/// case alone.
fn near_match(path: &Path, folders: &Folders) -> Option<String> {
    let mut found = folders.scene.to_path_buf();
    for part in path.strip_prefix(folders.scene).ok()?.components() {
        let part = part.as_os_str();
        let exact = found.join(part);
        if exact.exists() {
            found = exact;
            continue;
        }
        if !folders.hold(&found.canonicalize().ok()?) {
            return None;
        }
        let wanted = part.to_str()?.to_lowercase();
        let entries =
            found.read_dir().ok()?.take(MAX_ENTRIES).filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        // File systems list entries in any order; the least name makes the message deterministic.
        found = found.join(entries.filter(|name| name.to_lowercase() == wanted).min()?);
    }
    let name = found.strip_prefix(folders.scene).ok()?.to_str()?.replace('\\', "/");
    Some(shown(&name))
}

/// Whether reading could be endless, as of /dev/zero. Pipes end with their writers.
fn is_device(metadata: &Metadata) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        metadata.file_type().is_char_device()
    }
    #[cfg(not(unix))]
    {
        let _ = metadata;
        false
    }
}

/// Reads a whole file, refusing one above the limit before its bytes are in memory.
pub(crate) fn read_file(path: &Path, limit: u64, place: &str) -> Result<Vec<u8>> {
    let fault = |e: std::io::Error| Fault::Read { path: path.to_path_buf(), kind: e.kind(), text: io_cause(&e) };
    let file = File::open(path).map_err(fault)?;
    let metadata = file.metadata().map_err(fault)?;
    if metadata.is_dir() {
        return Err(fault(ErrorKind::IsADirectory.into()));
    }
    if is_device(&metadata) {
        let text = "it is a device, and a file is needed".into();
        return Err(Fault::Read { path: path.to_path_buf(), kind: ErrorKind::InvalidInput, text });
    }
    let too_large = || Fault::too_large(place, format!("is {} with more than {limit} bytes", path.display()));
    if metadata.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    // Devices and growing files have no reliable length.
    file.take(limit + 1).read_to_end(&mut bytes).map_err(fault)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}
