//! Filters: from values that compress well to the values of accessors.

/// Unit vectors folded onto an octahedron, in four signed bytes: x, y, the value that encodes 1,
/// and one that is unchanged.
pub(super) fn octahedral8(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let [x, y, one, _] = element.map(|b| f32::from(b as i8));
        let v = unfold(x, y, one, 127.0);
        for (out, v) in element.iter_mut().zip(v) {
            *out = v as i8 as u8;
        }
    }
}

/// The same in four signed shorts.
pub(super) fn octahedral16(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let [x, y, one, w] = shorts(element);
        let [x, y, z] = unfold(f32::from(x), f32::from(y), f32::from(one), 32767.0).map(|v| v as i16);
        set_shorts(element, [x, y, z, w]);
    }
}

fn unfold(x: f32, y: f32, one: f32, most: f32) -> [f32; 3] {
    let z = one - x.abs() - y.abs();
    let fold = z.min(0.0);
    let x = x + fold.copysign(if x >= 0.0 { -1.0 } else { 1.0 });
    let y = y + fold.copysign(if y >= 0.0 { -1.0 } else { 1.0 });
    let length = (x * x + y * y + z * z).sqrt();
    let scale = if length > 0.0 { most / length } else { 0.0 };
    [x, y, z].map(|v| (v * scale).round())
}

/// Unit quaternions without their largest component, whose place is in the lowest bits of the
/// fourth short.
pub(super) fn quaternion(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let [x, y, z, w] = shorts(element);
        let scale = std::f32::consts::FRAC_1_SQRT_2 / f32::from(w | 3);
        let [x, y, z] = [x, y, z].map(|v| f32::from(v) * scale);
        let largest = (1.0 - x * x - y * y - z * z).max(0.0).sqrt();
        let place = (w & 3) as usize;
        let mut out = [0; 4];
        for (i, v) in [largest, x, y, z].into_iter().enumerate() {
            out[(place + i) % 4] = (v * 32767.0).round() as i16;
        }
        set_shorts(element, out);
    }
}

/// Floats as a signed exponent (8 bits) over a signed mantissa (24 bits).
pub(super) fn exponential(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let word = i32::from_le_bytes(*element);
        let (exponent, mantissa) = (word >> 24, word << 8 >> 8);
        // The product rounds once, also where the result is subnormal.
        let value = (f64::from(mantissa) * f64::from(exponent).exp2()) as f32;
        *element = value.to_le_bytes();
    }
}

/// Luma and two chroma differences, in bytes, to RGBA; the highest bit set of alpha says how many
/// bits are used.
pub(super) fn color8(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<4>().0 {
        let [y, co, cg, a] = *element;
        let rgba = rgba(f32::from(y), f32::from(co as i8), f32::from(cg as i8), u32::from(a), 255.0);
        *element = rgba.map(|v| v as u8);
    }
}

/// The same in shorts.
pub(super) fn color16(bytes: &mut [u8]) {
    for element in bytes.as_chunks_mut::<8>().0 {
        let [y, co, cg, a] = shorts(element);
        let rgba = rgba(f32::from(y as u16), f32::from(co), f32::from(cg), u32::from(a as u16), 65535.0);
        set_shorts(element, rgba.map(|v| v as u16 as i16));
    }
}

fn rgba(y: f32, co: f32, cg: f32, alpha: u32, most: f32) -> [f32; 4] {
    // Alpha loses one bit to the mark above it; the mark of an alpha of 0 would be missing, and
    // nothing can be scaled.
    let Some(mark) = alpha.checked_ilog2() else { return [0.0; 4] };
    let used = (1_u32 << (mark + 1)) - 1;
    let alpha = alpha & (used >> 1);
    let alpha = alpha << 1 | alpha & 1;
    let scale = most / used as f32;
    [y + co - cg, y + cg, y - co - cg, alpha as f32].map(|v| (v * scale).round())
}

fn shorts(bytes: &[u8; 8]) -> [i16; 4] {
    [0, 2, 4, 6].map(|at| i16::from_le_bytes([bytes[at], bytes[at + 1]]))
}

fn set_shorts(bytes: &mut [u8; 8], values: [i16; 4]) {
    for (out, value) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(values) {
        *out = value.to_le_bytes();
    }
}
