//! The container: a .glb's chunks, or plain JSON.

use std::borrow::Cow;

use gltf::binary::Glb;

use super::error::{Fault, Result};
use super::warnings::Warnings;
use crate::kind::kind_of;

/// `glTF` in ASCII.
pub(crate) const MAGIC: &[u8; 4] = b"glTF";
const CHUNK_JSON: u32 = 0x4E4F_534A;
const CHUNK_BIN: u32 = 0x004E_4942;

/// The two parts of a file that the importer reads.
#[derive(Debug)]
pub(crate) struct Container<'a> {
    pub(crate) json: &'a [u8],
    pub(crate) bin: Option<&'a [u8]>,
}

/// Splits a file, whatever its name ends with: a .glb by its magic, else JSON.
pub(crate) fn split<'a>(file: &'a [u8], warnings: &mut Warnings) -> Result<Container<'a>> {
    if !file.starts_with(MAGIC) {
        let first = file.strip_prefix(b"\xef\xbb\xbf").unwrap_or(file).iter().find(|b| !b.is_ascii_whitespace());
        return match first {
            Some(b'{') => Ok(Container { json: file, bin: None }),
            _ => Err(Fault::Format(match kind_of(file) {
                Some(kind) => format!("it is {kind}"),
                None => "it begins neither with the letters glTF nor with a JSON object".into(),
            })),
        };
    }
    let version = word(file, 4)?;
    if version != 2 {
        return Err(Fault::Format(format!("its container has version {version}, and only 2 is supported")));
    }
    let stated = word(file, 8)? as usize;
    if stated > file.len() {
        return Err(Fault::Format(format!(
            "it is cut short: the header states {stated} bytes, the file has {}",
            file.len()
        )));
    }
    if stated < 12 {
        return Err(Fault::Format(format!("its header states a length of {stated} bytes")));
    }
    if stated < file.len() {
        warnings.push(format!("The .glb has {} bytes after its stated end; they are ignored.", file.len() - stated));
    }
    let file = &file[..stated];
    match usual(file) {
        Some(container) => Ok(container),
        None => chunks(file, warnings),
    }
}

/// A file of one JSON chunk and at most one binary chunk with nothing around them, which nearly all
/// are. The header's length must have been checked: `Glb` subtracts from it.
fn usual(file: &[u8]) -> Option<Container<'_>> {
    let glb = Glb::from_slice(file).ok()?;
    let (Cow::Borrowed(json), bin) = (glb.json, glb.bin) else { return None };
    let bin = match bin {
        None => None,
        Some(Cow::Borrowed(bin)) => Some(bin),
        Some(Cow::Owned(_)) => return None,
    };
    let chunks = json.len() + bin.map_or(0, |bin| 8 + bin.len());
    (12 + 8 + chunks == file.len()).then_some(Container { json, bin })
}

/// All other files: chunks of other kinds, several of one kind, chunks cut short; the error states
/// the defect and its place.
fn chunks<'a>(file: &'a [u8], warnings: &mut Warnings) -> Result<Container<'a>> {
    let mut json = None;
    let mut bin = None;
    let mut at = 12;
    while at < file.len() {
        let length = word(file, at)? as usize;
        let kind = word(file, at + 4)?;
        let body = file[at + 8..].get(..length).ok_or_else(|| {
            Fault::Format(format!(
                "it is cut short: the chunk at byte {at} states {length} bytes, and {} are left",
                file.len() - at - 8
            ))
        })?;
        match (kind, json.is_some()) {
            (CHUNK_JSON, false) => json = Some(body),
            (_, false) => return Err(Fault::Format("its first chunk is not JSON".into())),
            (CHUNK_BIN, true) if bin.is_none() => bin = Some(body),
            (CHUNK_JSON | CHUNK_BIN, true) => {
                warnings.push("The .glb has a chunk of JSON or binary data too many; it is ignored.");
            }
            _ => {} // Chunks of unknown kinds are to be skipped.
        }
        at += 8 + length;
    }
    let json = json.ok_or_else(|| Fault::Format("it has no JSON chunk".into()))?;
    Ok(Container { json, bin })
}

/// The little-endian word at a byte.
fn word(file: &[u8], at: usize) -> Result<u32> {
    match file.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        Some(bytes) => Ok(u32::from_le_bytes(*bytes)),
        None => Err(Fault::Format(format!("it is cut short at byte {}", file.len()))),
    }
}
