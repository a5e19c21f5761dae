//! Mode ATTRIBUTES: blocks of up to 256 elements, byte by byte, as differences to the element
//! before.

use super::{Reader, unzigzag};

/// Elements that share one choice of bit width.
const GROUP: usize = 16;

/// Decodes `count` elements of `stride` bytes (a multiple of 4, at most 256); `None` when the
/// stream is damaged.
pub(super) fn decode(stream: &[u8], stride: usize, count: usize) -> Option<Vec<u8>> {
    let version = match stream.first()? {
        0xA0 => 0,
        0xA1 => 1,
        _ => return None,
    };
    let channels = stride / 4;
    // After the blocks come the element before the first and, in version 1, a mode for every four
    // bytes, both at the very end; padding before them makes the tail long enough for decoders that
    // read ahead.
    let (tail, least) = if version == 0 { (stride, 32) } else { (stride + channels, 24) };
    let body_end = stream.len().checked_sub(tail.max(least)).filter(|&end| end >= 1)?;
    let (last, modes) = stream[stream.len() - tail..].split_at(stride);
    let mut last = last.to_vec();
    let mut reader = Reader(&stream[1..body_end]);
    let block_size = ((8192 / stride) & !(GROUP - 1)).min(256);

    let mut out = Vec::new();
    let mut deltas = vec![0_u8; block_size * 4];
    let mut done = 0;
    while done < count {
        let n = block_size.min(count - done);
        let controls = if version == 0 { &[][..] } else { reader.take(channels)? };
        let start = out.len();
        out.resize(start + n * stride, 0);
        for channel in 0..channels {
            let control = controls.get(channel).copied().unwrap_or(0);
            for byte in 0..4 {
                let plane = &mut deltas[byte * block_size..][..block_size];
                match (version, control >> (2 * byte) & 3) {
                    (0, _) => groups(&mut reader, plane, n, [0, 2, 4, 8])?,
                    (_, 0) => groups(&mut reader, plane, n, [0, 1, 2, 4])?,
                    (_, 1) => groups(&mut reader, plane, n, [1, 2, 4, 8])?,
                    (_, 2) => plane.fill(0),
                    (_, _) => plane[..n].copy_from_slice(reader.take(n)?),
                }
            }
            let mode = modes.get(channel).copied().unwrap_or(0);
            let previous = <&mut [u8; 4]>::try_from(&mut last[4 * channel..][..4]).ok()?;
            for i in 0..n {
                let delta = [0, 1, 2, 3].map(|byte| deltas[byte * block_size + i]);
                *previous = step(*previous, delta, mode)?;
                out[start + i * stride + 4 * channel..][..4].copy_from_slice(previous);
            }
        }
        done += n;
    }
    // Bytes remain: the stream has another count.
    reader.0.is_empty().then_some(out)
}

/// Four bytes of an element from those of the one before.
fn step(previous: [u8; 4], delta: [u8; 4], mode: u8) -> Option<[u8; 4]> {
    match mode & 3 {
        0 => {
            let mut out = previous;
            for (out, delta) in out.iter_mut().zip(delta) {
                *out = out.wrapping_add(unzigzag(u32::from(delta)) as u8);
            }
            Some(out)
        }
        1 => {
            let half = |at: usize| {
                let difference = unzigzag(u32::from(u16::from_le_bytes([delta[at], delta[at + 1]]))) as u16;
                u16::from_le_bytes([previous[at], previous[at + 1]]).wrapping_add(difference).to_le_bytes()
            };
            let ([a, b], [c, d]) = (half(0), half(2));
            Some([a, b, c, d])
        }
        2 => {
            let turned = u32::from_le_bytes(delta).rotate_right(u32::from(mode >> 4));
            Some((u32::from_le_bytes(previous) ^ turned).to_le_bytes())
        }
        _ => None,
    }
}

/// One byte of `count` elements, in groups of 16, each with one of four bit widths.
fn groups(reader: &mut Reader, plane: &mut [u8], count: usize, widths: [u32; 4]) -> Option<()> {
    let groups = count.div_ceil(GROUP);
    let header = reader.take(groups.div_ceil(4))?;
    for (i, group) in plane.chunks_exact_mut(GROUP).take(groups).enumerate() {
        match widths[usize::from(header[i / 4] >> (2 * (i % 4)) & 3)] {
            0 => group.fill(0),
            8 => group.copy_from_slice(reader.take(GROUP)?),
            bits => {
                let packed = reader.take(GROUP * bits as usize / 8)?;
                let sentinel = (1_u8 << bits) - 1;
                let per_byte = 8 / bits as usize;
                for (k, value) in group.iter_mut().enumerate() {
                    let place = (k % per_byte) as u32;
                    // Single bits are stored lowest first, all others highest first.
                    let shift = if bits == 1 { place } else { 8 - bits * (place + 1) };
                    *value = packed[k / per_byte] >> shift & sentinel;
                }
                // The largest value marks a whole byte that follows the packed ones.
                for value in group.iter_mut().filter(|value| **value == sentinel) {
                    *value = reader.byte()?;
                }
            }
        }
    }
    Some(())
}
