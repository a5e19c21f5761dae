//! Buffers and buffer views: bytes, checked against their stated lengths.

use std::path::Path;
use std::sync::OnceLock;

use super::document::{Document, Int, get};
use super::error::{Fault, Result};
use super::uri;

/// The file's buffers, read when first asked for: an unused one may be missing.
#[derive(Debug)]
pub(crate) struct Buffers<'a> {
    document: &'a Document,
    folder: &'a Path,
    bin: Option<&'a [u8]>,
    limit: u64,
    loaded: Vec<OnceLock<Result<Vec<u8>>>>,
}

/// A buffer view's bytes and stride.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a> {
    pub(crate) bytes: &'a [u8],
    /// Bytes from one element to the next, where the file states it.
    pub(crate) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// `bin` is the binary chunk of a .glb; `limit` bounds each buffer's bytes.
    pub(crate) fn new(document: &'a Document, folder: &'a Path, bin: Option<&'a [u8]>, limit: u64) -> Self {
        let loaded = document.buffers.iter().map(|_| OnceLock::new()).collect();
        Self { document, folder, bin, limit, loaded }
    }

    /// Bytes of all buffers as the document states them: a measure of how large the asset claims to be.
    pub(crate) fn stated_bytes(&self) -> u64 {
        self.document.buffers.iter().fold(0, |sum: u64, b| sum.saturating_add(b.byte_length.0))
    }

    /// The bytes of a buffer, exactly as many as it states.
    fn buffer(&self, index: Int, user: &str) -> Result<&[u8]> {
        let stated = get(&self.document.buffers, index, "buffer", user)?;
        let place = format!("buffer {}", index.index());
        let bytes: &[u8] = match (&stated.uri, self.bin) {
            (Some(uri), _) => {
                let slot = &self.loaded[index.index()];
                slot.get_or_init(|| uri::read(uri, self.folder, self.limit, &place)).as_ref().map_err(Fault::clone)?
            }
            (None, Some(bin)) if index.0 == 0 => bin,
            (None, _) => return Err(Fault::invalid(place, "has no URI, and the file has no binary chunk for it")),
        };
        usize::try_from(stated.byte_length.0).ok().and_then(|n| bytes.get(..n)).ok_or_else(|| {
            Fault::invalid(place, format!("states {} bytes, but only {} are there", stated.byte_length.0, bytes.len()))
        })
    }

    /// The bytes of a buffer view, for the object `user`.
    pub(crate) fn view(&self, index: Int, user: &str) -> Result<View<'_>> {
        let stated = get(&self.document.buffer_views, index, "bufferView", user)?;
        let place = format!("bufferView {}", index.index());
        if stated.extensions.has("EXT_meshopt_compression") || stated.extensions.has("KHR_meshopt_compression") {
            // The uncompressed fallback, if the file has one, stands in the plain fields and is read below.
            let fallback = get(&self.document.buffers, stated.buffer, "buffer", &place)?;
            if fallback.uri.is_none() && !(stated.buffer.0 == 0 && self.bin.is_some()) {
                return Err(Fault::invalid(place, "is compressed with meshopt, which is not supported"));
            }
        }
        let buffer = self.buffer(stated.buffer, &place)?;
        let (offset, length) = (stated.byte_offset.0, stated.byte_length.0);
        let bytes = range(buffer, offset, length).ok_or_else(|| {
            Fault::invalid(
                &place,
                format!(
                    "reaches from byte {offset} over {length} bytes, but buffer {} has {}",
                    stated.buffer.index(),
                    buffer.len()
                ),
            )
        })?;
        Ok(View { bytes, stride: stated.byte_stride.filter(|s| s.0 != 0).map(Int::index) })
    }
}

/// `length` bytes from `offset`, or `None` when they are not all there; never overflows.
pub(crate) fn range(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}
