//! Environment maps from Radiance .hdr and OpenEXR .exr files.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};

use crate::EnvironmentMap;
use crate::import::{LoadError, read_file};

/// Texels that one map may have: 16 k × 8 k.
const MOST_TEXELS: u64 = 128 << 20;
/// A map with more texels than this must have [`MOST_TEXELS_A_BYTE`] at most, or its header is taken for a lie: memory is
/// allocated before the decoder can find out.
const TRUSTED_TEXELS: u64 = 16 << 20;
/// Run lengths of Radiance reach 16 texels a byte, ZIP on noise-free halves somewhat more.
const MOST_TEXELS_A_BYTE: u64 = 24;
/// Bytes that one file may have.
const MOST_BYTES: u64 = 4 << 30;
/// Brighter texels are cut to this: far above the sun's 1.6e9 nit, and its square stays in the range of f32.
const MOST_RADIANCE: f32 = 1e12;
/// What an infinite texel becomes: the largest half float, since halves that overflowed are where they come from.
const INFINITE: f32 = 65504.0;

/// Loads an equirectangular environment map, .hdr or .exr by its content.
///
/// Texels that are NaN or negative become 0, infinite ones 65504 (the largest half float).
///
/// # Errors
/// When the file cannot be read, is neither format, is damaged, or is larger than 128 Mi texels.
pub fn load_environment(path: &Path) -> Result<EnvironmentMap, LoadError> {
    Ok(load_environment_with_warnings(path)?.0)
}

/// The same, with a sentence for everything that was not taken as written.
///
/// # Errors
/// See [`load_environment`].
pub fn load_environment_with_warnings(path: &Path) -> Result<(EnvironmentMap, Vec<String>), LoadError> {
    let bytes = read_file(path, MOST_BYTES)?;
    let mut warnings = Vec::new();
    let decoded = if bytes.starts_with(b"#?") {
        hdr(&bytes)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr(&bytes, &mut warnings)
    } else {
        Err("it is neither Radiance HDR nor OpenEXR".into())
    };
    let mut map = decoded.map_err(|cause| LoadError::Environment { path: path.to_path_buf(), cause })?;
    for warning in &mut warnings {
        *warning = format!("Of {}, {warning}.", path.display());
    }
    let changed = sanitise(&mut map.texels);
    if changed > 0 {
        let texels = map.texels.len();
        warnings
            .push(format!("{changed} of {texels} texels of {} were negative, infinite or no number.", path.display()));
    }
    if map.width != 2 * map.height {
        warnings.push(format!(
            "{} is {} × {}, but a map of all directions is twice as wide as high; it is stretched.",
            path.display(),
            map.width,
            map.height
        ));
    }
    Ok((map, warnings))
}

fn check_size(width: u64, height: u64, file_bytes: usize) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(0) => Err("it has no texels".into()),
        Some(texels) if texels <= TRUSTED_TEXELS => Ok(()),
        Some(texels) if texels <= MOST_TEXELS => {
            if texels <= (file_bytes as u64).saturating_mul(MOST_TEXELS_A_BYTE) {
                return Ok(());
            }
            Err(format!("it states {width} × {height} texels in only {file_bytes} bytes"))
        }
        _ => Err(format!("it states {width} × {height} texels, and {MOST_TEXELS} are the most that are read")),
    }
}

fn hdr(bytes: &[u8]) -> Result<EnvironmentMap, String> {
    // Not strict: comments and unknown header lines are common.
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(hdr_cause)?;
    let metadata = decoder.metadata();
    let (width, height) = decoder.dimensions();
    check_size(width.into(), height.into(), bytes.len())?;
    let pixels = DynamicImage::from_decoder(decoder).map_err(hdr_cause)?.into_rgb32f();
    // EXPOSURE and COLORCORR state what the stored values were multiplied by.
    let exposure = metadata.exposure.unwrap_or(1.0);
    let (r, g, b) = metadata.color_correction.unwrap_or((1.0, 1.0, 1.0));
    let factor = [r, g, b].map(|c| 1.0 / (c * exposure));
    if !factor.iter().all(|f| f.is_finite() && *f > 0.0) {
        return Err("its EXPOSURE or COLORCORR is not a positive number".into());
    }
    let texels = pixels.pixels().map(|p| std::array::from_fn(|i| p.0[i] * factor[i])).collect();
    Ok(EnvironmentMap { width, height, texels })
}

/// The decoder's words, but for a file that just ends.
fn hdr_cause(error: image::ImageError) -> String {
    match error {
        image::ImageError::IoError(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => "it is cut short".into(),
        other => other.to_string(),
    }
}

fn exr(bytes: &[u8], warnings: &mut Vec<String>) -> Result<EnvironmentMap, String> {
    let meta = exr::meta::MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        check_size(header.layer_size.0 as u64, header.layer_size.1 as u64, bytes.len())?;
    }
    let has = |header: &exr::meta::header::Header, name: &str| header.channels.list.iter().any(|c| c.name.eq(name));
    if !meta.headers.iter().any(|header| ["R", "G", "B"].iter().all(|name| has(header, name))) {
        return Err("it has no layer with channels R, G and B".into());
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.0, vec![[0.0_f32; 3]; size.0 * size.1]),
            |(width, texels), at, (r, g, b): (f32, f32, f32)| {
                if let Some(texel) = texels.get_mut(at.1 * *width + at.0) {
                    *texel = [r, g, b];
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let attributes = &image.layer_data.attributes;
    if attributes.environment_map == Some(exr::meta::attribute::EnvironmentMap::Cube) {
        return Err("it is a cube map, and only maps of latitude and longitude are read".into());
    }
    let data = Window { at: attributes.layer_position.into(), size: image.layer_data.size.into() };
    let shown = image.attributes.display_window;
    let shown = Window { at: shown.position.into(), size: shown.size.into() };
    check_size(shown.size.0 as u64, shown.size.1 as u64, bytes.len())?;
    if let Some(c) = image.attributes.chromaticities
        && !is_rec709(&c)
    {
        warnings.push("its primaries are not those of Rec. 709, and its colours are taken as they are".into());
    }
    let (_, texels) = image.layer_data.channel_data.pixels;
    Ok(EnvironmentMap { width: shown.size.0 as u32, height: shown.size.1 as u32, texels: shown.show(data, texels) })
}

/// A rectangle of texels in OpenEXR's pixel plane, rows downwards.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Window {
    at: (i32, i32),
    size: (usize, usize),
}

impl Window {
    /// The texels of `data` as seen through this window; black where there are none.
    fn show(self, data: Window, texels: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
        if self == data {
            return texels;
        }
        // In i64 no difference of two corners overflows.
        let shift = |from: i32, to: i32| i64::from(to) - i64::from(from);
        let (dx, dy) = (shift(self.at.0, data.at.0), shift(self.at.1, data.at.1));
        let mut out = vec![[0.0; 3]; self.size.0 * self.size.1];
        for (y, row) in texels.chunks_exact(data.size.0).enumerate() {
            for (x, texel) in row.iter().enumerate() {
                let (x, y) = (usize::try_from(x as i64 + dx), usize::try_from(y as i64 + dy));
                if let (Ok(x), Ok(y)) = (x, y)
                    && x < self.size.0
                    && y < self.size.1
                {
                    out[y * self.size.0 + x] = *texel;
                }
            }
        }
        out
    }
}

fn is_rec709(c: &exr::meta::attribute::Chromaticities) -> bool {
    let near = |a: exr::math::Vec2<f32>, x: f32, y: f32| (a.0 - x).abs() < 2e-3 && (a.1 - y).abs() < 2e-3;
    near(c.red, 0.64, 0.33) && near(c.green, 0.30, 0.60) && near(c.blue, 0.15, 0.06) && near(c.white, 0.3127, 0.3290)
}

/// Makes every texel finite, non-negative and not absurdly bright; returns how many changed.
fn sanitise(texels: &mut [[f32; 3]]) -> usize {
    let mut changed = 0;
    for texel in texels {
        let before = *texel;
        *texel = before.map(|c| match c {
            c if c.is_nan() || c < 0.0 => 0.0,
            f32::INFINITY => INFINITE,
            c => c.min(MOST_RADIANCE),
        });
        // -0.0 equals 0.0 and is no change worth a word; NaN never equals.
        changed += usize::from(*texel != before);
    }
    changed
}
