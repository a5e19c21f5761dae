//! Radiance .hdr: the header is read here, run lengths by the crate `image`.

use std::io::{Cursor, Read};

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageError};

use super::load::check_size;
use crate::EnvironmentMap;

/// CIE XYZ to linear Rec. 709, whose white is D65.
const REC709_FROM_XYZ: [[f32; 3]; 3] = [
    [3.240_97, -1.537_383_2, -0.498_610_76],
    [-0.969_243_65, 1.875_967_5, 0.041_555_06],
    [0.055_630_08, -0.203_976_96, 1.056_971_5],
];

/// The fields of the header.
struct Header<'a> {
    /// Whether texels are CIE XYZ instead of RGB.
    xyz: bool,
    /// The factor of a stored component.
    factor: [f32; 3],
    resolution: Resolution,
    /// The run lengths.
    pixels: &'a [u8],
}

/// How the stored scanlines lie in the picture.
#[derive(Clone, Copy)]
struct Resolution {
    /// Scanlines, and texels in each.
    scanlines: u32,
    length: u32,
    /// Whether scanlines are rows, and not columns.
    rows: bool,
    /// Whether the first scanline is the bottom row or the right column.
    scanlines_reversed: bool,
    /// Whether a scanline begins at its right or lower end.
    texels_reversed: bool,
}

pub(super) fn decode(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    let header = header(bytes)?;
    let Resolution { scanlines, length, .. } = header.resolution;
    let (width, height) = header.resolution.size();
    check_size(width.into(), height.into(), bytes.len())?;
    // The decoder reads one orientation and RGB: it reads scanlines of any orientation as rows
    // downwards.
    let plain = format!("#?RADIANCE\n\n-Y {scanlines} +X {length}\n");
    let stream = Cursor::new(plain).chain(header.pixels);
    let decoder = HdrDecoder::new_nonstrict(stream).map_err(cause)?;
    let stored = DynamicImage::from_decoder(decoder).map_err(cause)?.into_rgb32f();
    let texel = |(column, row): (u32, u32)| {
        let stored = stored.get_pixel(column, row).0;
        let texel: [f32; 3] = std::array::from_fn(|i| stored[i] * header.factor[i]);
        match header.xyz {
            true => REC709_FROM_XYZ.map(|row| row[0] * texel[0] + row[1] * texel[1] + row[2] * texel[2]),
            false => texel,
        }
    };
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let texels = places.map(|(x, y)| texel(header.resolution.stored(x, y))).collect();
    Ok(EnvironmentMap { width, height, texels })
}

/// The header is plain, so that only the pixels can be wrong.
fn cause(error: ImageError) -> String {
    match error {
        ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => "it is cut short".into(),
        ImageError::Limits(_) => "it has more texels than fit in memory".into(),
        _ => "the run lengths of its pixels do not fit its width".into(),
    }
}

fn header(bytes: &[u8]) -> Result<Header<'_>, String> {
    let mut rest = bytes;
    let mut line = || {
        let end = rest.iter().position(|&byte| byte == b'\n').ok_or("it is cut short")?;
        let (line, after) = (&rest[..end], &rest[end + 1..]);
        rest = after;
        Ok::<_, String>(String::from_utf8_lossy(line).trim_end_matches('\r').to_owned())
    };
    let mut xyz = false;
    // EXPOSURE and COLORCORR state factors of the stored values, and may be repeated.
    let mut multiplied = [1.0_f32; 3];
    loop {
        let line = line()?;
        if line.is_empty() {
            break;
        }
        // Commands of the programs that the picture came through, and comments, have no meaning
        // here.
        let Some((key, value)) = line.split_once('=').filter(|_| !line.starts_with('#')) else { continue };
        let numbers: Vec<f32> = value.split_whitespace().map_while(|number| number.parse().ok()).collect();
        match (key.trim(), numbers.as_slice()) {
            ("FORMAT", _) => {
                xyz = match value.trim() {
                    "32-bit_rle_rgbe" => false,
                    "32-bit_rle_xyze" => true,
                    other => {
                        let read = "32-bit_rle_rgbe and 32-bit_rle_xyze are read";
                        return Err(format!("its FORMAT is {:?}, and only {read}", shown(other)));
                    }
                }
            }
            ("EXPOSURE", [exposure, ..]) => multiplied = multiplied.map(|m| m * exposure),
            ("COLORCORR", [r, g, b, ..]) => {
                multiplied = [multiplied[0] * r, multiplied[1] * g, multiplied[2] * b];
            }
            _ => {}
        }
    }
    let factor = multiplied.map(f32::recip);
    if !factor.iter().all(|f| f.is_finite() && *f > 0.0) {
        return Err("its EXPOSURE or COLORCORR is not a positive number".into());
    }
    let line = line()?;
    let resolution = Resolution::parse(&line).ok_or_else(|| {
        let form = "the form is -Y HEIGHT +X WIDTH, with either axis first and either sign";
        format!("its resolution line is {:?}, and {form}", shown(&line))
    })?;
    Ok(Header { xyz, factor, resolution, pixels: rest })
}

/// A piece of the file as shown in messages.
fn shown(text: &str) -> String {
    const MAX_CHARS: usize = 40;
    text.chars().take(MAX_CHARS).collect()
}

impl Resolution {
    fn parse(line: &str) -> Option<Self> {
        let parts: Vec<&str> = line.split_whitespace().collect();
        let [first, scanlines, second, length] = parts[..] else { return None };
        // Y grows upwards and X to the right.
        let (rows, scanlines_reversed, texels_reversed) = match (first, second) {
            ("-Y" | "+Y", "-X" | "+X") => (true, first == "+Y", second == "-X"),
            ("-X" | "+X", "-Y" | "+Y") => (false, first == "-X", second == "+Y"),
            _ => return None,
        };
        let (scanlines, length) = (scanlines.parse().ok()?, length.parse().ok()?);
        Some(Self { scanlines, length, rows, scanlines_reversed, texels_reversed })
    }

    /// Width and height of the picture.
    fn size(self) -> (u32, u32) {
        if self.rows { (self.length, self.scanlines) } else { (self.scanlines, self.length) }
    }

    /// Column and scanline of a texel of the picture.
    fn stored(self, x: u32, y: u32) -> (u32, u32) {
        let (along, scanline) = if self.rows { (x, y) } else { (y, x) };
        (
            if self.texels_reversed { self.length - 1 - along } else { along },
            if self.scanlines_reversed { self.scanlines - 1 - scanline } else { scanline },
        )
    }
}
