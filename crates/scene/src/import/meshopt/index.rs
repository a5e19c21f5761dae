//! Modes TRIANGLES and INDICES: connectivity from recently used edges and vertices, and plain
//! differences.

use super::{Reader, unzigzag};

/// Bytes of the table that ends a stream of triangles.
const TABLE: usize = 16;

/// The last 16 entries pushed; read indices start at the newest.
#[derive(Clone, Copy)]
struct Recent<T> {
    entries: [T; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn new(empty: T) -> Self {
        Self { entries: [empty; 16], next: 0 }
    }

    fn push(&mut self, entry: T) {
        self.entries[self.next] = entry;
        self.next = (self.next + 1) % 16;
    }

    /// Entry `back` pushes ago; 0 is the newest.
    fn get(&self, back: u8) -> T {
        self.entries[(self.next + 15 - usize::from(back % 16)) % 16]
    }
}

/// Decodes `count` indices (a multiple of 3) of `size` bytes (2 or 4); `None` when the stream is
/// damaged.
pub(super) fn triangles(stream: &[u8], size: usize, count: usize) -> Option<Vec<u8>> {
    let version = stream.first()? & 0x0F;
    if stream[0] & 0xF0 != 0xE0 || version > 1 {
        return None;
    }
    let body = stream.get(1..stream.len().checked_sub(TABLE)?)?;
    let table = &stream[stream.len() - TABLE..];
    // One code a triangle is there before anything is reserved.
    let (codes, data) = body.split_at_checked(count / 3)?;
    let mut data = Reader(data);
    let mut out = Vec::with_capacity(count * size);
    let mut edges = Recent::new((u32::MAX, u32::MAX));
    let mut vertices = Recent::new(u32::MAX);
    let (mut next, mut last) = (0_u32, 0_u32);
    // Version 0 uses all of 1 to 14 for recent vertices.
    let recent_end = if version == 0 { 15 } else { 13 };
    for &code in codes {
        let (high, low) = (code >> 4, code & 15);
        if high < 15 {
            let (a, b) = edges.get(high);
            let c = match low {
                0 => fresh(&mut next),
                low if low < recent_end => vertices.get(low),
                13 => offset(&mut last, u32::MAX),
                14 => offset(&mut last, 1),
                _ => free(&mut data, &mut last)?,
            };
            if low == 0 || low >= recent_end {
                vertices.push(c);
            }
            edges.push((c, b));
            edges.push((a, c));
            write(&mut out, size, [a, b, c]);
        } else {
            let pair = if low < 14 { table[usize::from(low)] } else { data.byte()? };
            if low >= 14 && pair == 0 {
                next = 0;
            }
            let kinds = [if low == 15 { 15 } else { 0 }, pair >> 4, pair & 15];
            // New indices are counted for all three before any is read from the data.
            let known = kinds.map(|kind| match kind {
                0 => Some(fresh(&mut next)),
                15 => None,
                kind => Some(vertices.get(kind - 1)),
            });
            let mut corners = [0; 3];
            for (corner, known) in corners.iter_mut().zip(known) {
                *corner = match known {
                    Some(index) => index,
                    None => free(&mut data, &mut last)?,
                };
            }
            for (kind, corner) in kinds.into_iter().zip(corners) {
                if kind == 0 || kind == 15 {
                    vertices.push(corner);
                }
            }
            let [a, b, c] = corners;
            edges.push((b, a));
            edges.push((c, b));
            edges.push((a, c));
            write(&mut out, size, corners);
        }
    }
    data.0.is_empty().then_some(out)
}

/// Decodes `count` indices of `size` bytes, each a difference to one of two running values.
pub(super) fn sequence(stream: &[u8], size: usize, count: usize) -> Option<Vec<u8>> {
    if stream.first()? & 0xF0 != 0xD0 || stream[0] & 0x0F > 1 || count > stream.len() {
        return None;
    }
    // Four bytes of padding end the stream.
    let mut reader = Reader(stream.get(1..stream.len().checked_sub(4)?)?);
    let mut out = Vec::with_capacity(count * size);
    let mut last = [0_u32; 2];
    for _ in 0..count {
        let v = reader.varint()?;
        let base = &mut last[(v & 1) as usize];
        *base = base.wrapping_add(unzigzag(v >> 1));
        write(&mut out, size, [*base]);
    }
    reader.0.is_empty().then_some(out)
}

fn fresh(next: &mut u32) -> u32 {
    let index = *next;
    *next = next.wrapping_add(1);
    index
}

fn offset(last: &mut u32, by: u32) -> u32 {
    *last = last.wrapping_add(by);
    *last
}

fn free(data: &mut Reader, last: &mut u32) -> Option<u32> {
    Some(offset(last, unzigzag(data.varint()?)))
}

fn write<const N: usize>(out: &mut Vec<u8>, size: usize, indices: [u32; N]) {
    for index in indices {
        out.extend_from_slice(&index.to_le_bytes()[..size]);
    }
}
