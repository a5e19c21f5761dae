//! Buffers and buffer views: bytes, checked against their stated lengths.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use super::document::{Document, Int, get};
use super::error::{Fault, Result};
use super::meshopt;
use super::uri::{self, Folders};
use crate::LoadOptions;

/// The file's buffers, read on first use: an unused one may be missing.
#[derive(Debug)]
pub(crate) struct Buffers<'a> {
    document: &'a Document,
    folders: &'a Folders<'a>,
    bin: Option<&'a [u8]>,
    limit: u64,
    loaded: Vec<OnceLock<Result<Vec<u8>>>>,
    /// Views that are compressed with meshopt, once decoded.
    decoded: Vec<OnceLock<Result<Vec<u8>>>>,
    /// Bytes that may still be decoded.
    decodable: AtomicU64,
}

/// A buffer view's bytes and stride.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View<'a> {
    pub(crate) bytes: &'a [u8],
    /// Bytes from one element to the next, where the file states it.
    pub(crate) stride: Option<usize>,
}

impl<'a> Buffers<'a> {
    /// `bin` is the binary chunk of a .glb; the options bound each buffer's bytes, and those of all
    /// decoded views.
    pub(crate) fn new(
        document: &'a Document,
        folders: &'a Folders<'a>,
        bin: Option<&'a [u8]>,
        options: &LoadOptions,
    ) -> Self {
        let loaded = document.buffers.iter().map(|_| OnceLock::new()).collect();
        let decoded = document.buffer_views.iter().map(|_| OnceLock::new()).collect();
        let decodable = AtomicU64::new(options.max_geometry_bytes);
        Self { document, folders, bin, limit: options.max_buffer_bytes, loaded, decoded, decodable }
    }

    /// Bytes of all buffers that are there: a measure of how large the asset is.
    pub(crate) fn bytes(&self) -> u64 {
        let sizes = self.document.buffers.iter().map(|buffer| {
            let there = match (&buffer.uri, self.bin) {
                (Some(uri), _) => uri::size(uri, self.folders),
                (None, Some(bin)) => bin.len() as u64,
                (None, None) => 0,
            };
            buffer.byte_length.0.min(there)
        });
        sizes.fold(0, u64::saturating_add)
    }

    /// The bytes of a buffer, exactly as many as it states.
    fn buffer(&self, index: Int, user: &str) -> Result<&[u8]> {
        let stated = get(&self.document.buffers, index, "buffer", user)?;
        let place = format!("buffer {}", index.index());
        let bytes: &[u8] = match (&stated.uri, self.bin) {
            (Some(uri), _) => {
                let slot = &self.loaded[index.index()];
                slot.get_or_init(|| uri::read(uri, self.folders, self.limit, &place)).as_ref().map_err(Fault::clone)?
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
        let stride = stated.byte_stride.filter(|s| s.0 != 0).map(Int::index);
        if let Some(compressed) = meshopt::of(stated, &place)? {
            let slot = &self.decoded[index.index()];
            let bytes = slot.get_or_init(|| self.decode(&compressed, &place)).as_ref().map_err(Fault::clone)?;
            return Ok(View { bytes, stride });
        }
        let bytes = self.part(stated.buffer, stated.byte_offset, stated.byte_length, &place)?;
        Ok(View { bytes, stride })
    }

    /// Reserves bytes of the limit on decoded data, for sizes that the accessors do not state.
    pub(crate) fn reserve(&self, bytes_requested: u64, place: &str) -> Result<()> {
        let within = |left: u64| left.checked_sub(bytes_requested);
        match self.decodable.fetch_update(Ordering::Relaxed, Ordering::Relaxed, within) {
            Ok(_) => Ok(()),
            Err(left) => {
                let cause =
                    format!("would take {bytes_requested} bytes once decoded, and {left} are left of those allowed");
                Err(Fault::too_large(place, cause))
            }
        }
    }

    /// Decodes a view that is compressed with meshopt. The plain copy that a file may have beside
    /// it is not needed.
    fn decode(&self, compressed: &meshopt::Compressed, place: &str) -> Result<Vec<u8>> {
        self.reserve(compressed.decoded_bytes(), place)?;
        let stream = self.part(compressed.buffer, compressed.byte_offset, compressed.byte_length, place)?;
        compressed.decode(stream, place)
    }

    /// Bytes of a buffer, for the view `place`.
    fn part(&self, buffer: Int, offset: Int, length: Int, place: &str) -> Result<&[u8]> {
        let bytes = self.buffer(buffer, place)?;
        range(bytes, offset.0, length.0).ok_or_else(|| {
            Fault::invalid(
                place,
                format!(
                    "reaches from byte {} over {} bytes, but buffer {} has {}",
                    offset.0,
                    length.0,
                    buffer.index(),
                    bytes.len()
                ),
            )
        })
    }
}

/// `length` bytes from `offset`, or `None` when they are not all there; never overflows.
pub(crate) fn range(bytes: &[u8], offset: u64, length: u64) -> Option<&[u8]> {
    let end = usize::try_from(offset.checked_add(length)?).ok()?;
    bytes.get(usize::try_from(offset).ok()?..end)
}
