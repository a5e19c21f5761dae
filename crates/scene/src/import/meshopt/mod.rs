//! EXT_meshopt_compression and its successor KHR_meshopt_compression: buffer views that are decoded
//! before they are read.
//!
//! Written after the bit streams and filters in the two extensions' texts (appendices A and B).
//! Every read is checked, and the output grows with the data of the stream, so that a count alone
//! takes no memory.

mod filter;
mod index;
mod vertex;

use serde::Deserialize;

use super::document::{BufferView, Int};
use super::error::{Fault, Result};

/// The two names of the extension, in the order in which they are looked for.
pub(crate) const NAMES: [&str; 2] = ["KHR_meshopt_compression", "EXT_meshopt_compression"];

/// How a view is compressed.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Compressed {
    pub(crate) buffer: Int,
    #[serde(default)]
    pub(crate) byte_offset: Int,
    pub(crate) byte_length: Int,
    byte_stride: Int,
    count: Int,
    mode: String,
    filter: Option<String>,
}

/// The compression of a buffer view, if it has one.
pub(crate) fn of(view: &BufferView, place: &str) -> Result<Option<Compressed>> {
    let Some(parsed) = NAMES.iter().find_map(|name| view.extensions.parse::<Compressed>(name)) else {
        return Ok(None);
    };
    parsed
        .map(Some)
        .map_err(|e| Fault::invalid(place, format!("is compressed with meshopt, but its extension is invalid: {e}")))
}

impl Compressed {
    /// Bytes once decoded.
    pub(crate) fn decoded_bytes(&self) -> u64 {
        self.byte_stride.0.saturating_mul(self.count.0)
    }

    /// Decodes the stream.
    pub(crate) fn decode(&self, stream: &[u8], place: &str) -> Result<Vec<u8>> {
        let (stride, count) = (self.byte_stride.index(), self.count.index());
        let broken = |what: &str| Fault::invalid(place, format!("is compressed with meshopt, but {what}"));
        let mut bytes = match self.mode.as_str() {
            "ATTRIBUTES" if stride % 4 != 0 || !(4..=256).contains(&stride) => {
                return Err(broken(&format!("its stride is {stride}, not a multiple of 4 up to 256")));
            }
            "ATTRIBUTES" => vertex::decode(stream, stride, count),
            "TRIANGLES" | "INDICES" if stride != 2 && stride != 4 => {
                return Err(broken(&format!("its indices have {stride} bytes, not 2 or 4")));
            }
            "TRIANGLES" if count % 3 != 0 => return Err(broken(&format!("its {count} indices make no triangles"))),
            "TRIANGLES" => index::triangles(stream, stride, count),
            "INDICES" => index::sequence(stream, stride, count),
            other => return Err(broken(&format!("its mode {} is unknown", super::uri::shown(other)))),
        }
        .ok_or_else(|| broken("its stream is cut short or damaged"))?;
        match (self.filter.as_deref().unwrap_or("NONE"), stride) {
            ("NONE", _) => {}
            ("OCTAHEDRAL", 4) => filter::octahedral8(&mut bytes),
            ("OCTAHEDRAL", 8) => filter::octahedral16(&mut bytes),
            ("QUATERNION", 8) => filter::quaternion(&mut bytes),
            ("EXPONENTIAL", _) if stride % 4 == 0 => filter::exponential(&mut bytes),
            ("COLOR", 4) => filter::color8(&mut bytes),
            ("COLOR", 8) => filter::color16(&mut bytes),
            (other, _) => {
                let other = super::uri::shown(other);
                return Err(broken(&format!("its filter {other} is unknown or does not go with a stride of {stride}")));
            }
        }
        Ok(bytes)
    }
}

/// A stream that is read from its front; every read may fail.
struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn byte(&mut self) -> Option<u8> {
        let (&first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(first)
    }

    /// A number in groups of seven bits, the lowest first: at most five bytes.
    fn varint(&mut self) -> Option<u32> {
        let mut value = 0_u32;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            value |= u32::from(byte & 127) << shift;
            if byte < 128 {
                break;
            }
        }
        Some(value)
    }
}

/// A number whose sign is its lowest bit.
fn unzigzag(v: u32) -> u32 {
    (v >> 1) ^ (v & 1).wrapping_neg()
}
