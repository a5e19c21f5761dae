//! KHR_texture_basisu: KTX2 files with ETC1S or UASTC, decoded to RGBA by the crate `basisu`.

use std::panic::{AssertUnwindSafe, catch_unwind};

use basisu::{DecodeFlags, TargetFormat, Transcoder};

use super::error::{Fault, Result};

/// How a KTX2 file begins.
pub(crate) const MAGIC: &[u8] = b"\xABKTX 20\xBB\r\n\x1A\n";

/// Width and height from the header.
pub(crate) fn size(file: &[u8], place: &str) -> Result<(u32, u32)> {
    match (word(file, 20), word(file, 24)) {
        (Some(width), Some(height)) => Ok((width, height)),
        _ => Err(Fault::invalid(place, "is a KTX2 file that is cut short")),
    }
}

/// The largest level of the first image as RGBA; `size` must be within the limits.
pub(crate) fn decode(file: &[u8], size: (u32, u32), place: &str) -> Result<Vec<u8>> {
    // With zstd around the blocks, the header states how much to reserve: UASTC takes a byte per
    // pixel.
    let padded = u64::from(size.0).next_multiple_of(4) * u64::from(size.1).next_multiple_of(4);
    let levels = word(file, 40).unwrap_or(0).clamp(1, 32) as usize;
    for level in 0..levels {
        let stated = file.get(80 + 24 * level + 16..).and_then(|rest| rest.first_chunk::<8>());
        if stated.is_none_or(|bytes| u64::from_le_bytes(*bytes) > padded * 2 + 64) {
            return Err(Fault::invalid(place, "is a KTX2 file whose levels do not go with its size"));
        }
    }
    // The transcoder checks its input; a panic inside on damaged data becomes an error of the file.
    let decoded = catch_unwind(AssertUnwindSafe(|| {
        let transcoder = Transcoder::new(file)?;
        if transcoder.base_dimensions() != size {
            return Err(basisu::Error::InvalidData);
        }
        transcoder.transcode(0, TargetFormat::Rgba32, DecodeFlags::NONE)
    }));
    match decoded {
        Ok(Ok(rgba)) if rgba.len() as u64 == u64::from(size.0) * u64::from(size.1) * 4 => Ok(rgba),
        Ok(Err(basisu::Error::Unsupported { .. } | basisu::Error::UnsupportedFeature(_))) => {
            Err(Fault::invalid(place, "is a KTX2 file of a kind that KHR_texture_basisu does not have"))
        }
        _ => Err(Fault::invalid(place, "is a KTX2 file that cannot be decoded")),
    }
}

fn word(file: &[u8], at: usize) -> Option<u32> {
    file.get(at..)?.first_chunk::<4>().map(|bytes| u32::from_le_bytes(*bytes))
}
