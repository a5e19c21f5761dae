//! The picture for people: tone mapped, sRGB, 8 bits.

use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

use crate::{Film, ToneMap, WriteError, linear_to_srgb, to_u8};

/// How radiance becomes a picture.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Display {
    /// Radiance is multiplied by 2 to this power.
    pub exposure_ev: f64,
    /// The tone curve.
    pub tonemap: ToneMap,
}

impl Display {
    /// sRGB bytes of a linear Rec. 709 radiance.
    pub fn bytes(&self, rgb: [f64; 3]) -> [u8; 3] {
        let scale = self.exposure_ev.exp2();
        self.tonemap.map(rgb.map(|x| x * scale)).map(|x| to_u8(linear_to_srgb(x)))
    }
}

/// Writes the mean of a film as an 8-bit RGB PNG; of a film with coverage, as RGBA with straight
/// alpha: the colour of the covering surfaces is tone mapped, and alpha is the linear share that it
/// covers.
///
/// # Errors
/// Where the file cannot be written; the target is then as it was.
pub fn write_png(path: &Path, film: &Film, display: &Display) -> Result<(), WriteError> {
    let bytes = encode_png(film, display).map_err(|cause| WriteError::new(path, cause))?;
    crate::write_file(path, &bytes)
}

/// The bytes that [`write_png`] writes.
///
/// # Errors
/// The cause, without a full stop, where the film cannot be encoded (an empty image).
pub fn encode_png(film: &Film, display: &Display) -> Result<Vec<u8>, String> {
    if film.has_coverage() {
        let pixels: Vec<_> = (0..film.pixels().len()).into_par_iter().map(|i| straight(film, i, display)).collect();
        return encode(film.width(), film.height(), pixels.as_flattened(), ExtendedColorType::Rgba8);
    }
    let pixels: Vec<_> = film.pixels().par_iter().map(|p| display.bytes(p.mean())).collect();
    encode(film.width(), film.height(), pixels.as_flattened(), ExtendedColorType::Rgb8)
}

/// Colour and alpha of a pixel with coverage. Where nothing covers it, there is no colour.
fn straight(film: &Film, i: usize, display: &Display) -> [u8; 4] {
    let alpha = film.coverage(i);
    let [r, g, b] = if alpha > 0.0 { display.bytes(film.mean(i).map(|x| x / alpha)) } else { [0; 3] };
    [r, g, b, to_u8(alpha)]
}

/// Writes sRGB bytes, one triple per pixel from the top left, as a PNG.
///
/// # Errors
/// Where the size does not fit or the file cannot be written; the target is then as it was.
pub fn write_rgb8_png(path: &Path, width: u32, height: u32, pixels: &[[u8; 3]]) -> Result<(), WriteError> {
    let bytes = encode(width, height, pixels.as_flattened(), ExtendedColorType::Rgb8)
        .map_err(|cause| WriteError::new(path, cause))?;
    crate::write_file(path, &bytes)
}

fn encode(width: u32, height: u32, samples: &[u8], color: ExtendedColorType) -> Result<Vec<u8>, String> {
    let pixels = samples.len() / usize::from(color.channel_count());
    if pixels == 0 || pixels as u64 != u64::from(width) * u64::from(height) {
        return Err(format!("{pixels} pixels do not make an image of {width}×{height}"));
    }
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive)
        .write_image(samples, width, height, color)
        .map_err(|error| error.to_string())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BatchSum;

    #[test]
    fn a_picture_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        let mut film = Film::new(2, 1);
        film.add_batch(2, &[0, 1], &[[0.214_041_14, 0.0, 4.5], [0.0; 3]].map(|c| BatchSum::constant(2, c))).unwrap();
        let plain = Display { exposure_ev: 0.0, tonemap: ToneMap::None };
        write_png(&path, &film, &plain).unwrap();
        let image = image::open(&path).unwrap().into_rgb8();
        assert_eq!(image.get_pixel(0, 0).0, [128, 0, 255]);
        assert_eq!(image.get_pixel(1, 0).0, [0, 0, 0]);
    }

    #[test]
    fn alpha_is_straight() {
        let mut film = Film::new(3, 1);
        let sums = [[0.107_020_57; 3], [0.0; 3], [0.214_041_14; 3]].map(|c| BatchSum::constant(4, c));
        film.add_covered_batch(|_, _| 4, &[0, 1, 2], &sums, &[2.0, 0.0, 4.0]).unwrap();
        let plain = Display { exposure_ev: 0.0, tonemap: ToneMap::None };
        let image = image::load_from_memory(&encode_png(&film, &plain).unwrap()).unwrap().into_rgba8();
        // Half of the first pixel has the colour that the last one has everywhere.
        let pixels = [0, 1, 2].map(|x| image.get_pixel(x, 0).0);
        assert_eq!(pixels, [[128, 128, 128, 128], [0; 4], [128, 128, 128, 255]]);
    }

    #[test]
    fn exposure_is_in_stops() {
        let at = |exposure_ev| Display { exposure_ev, tonemap: ToneMap::None };
        assert_eq!(at(1.0).bytes([0.1; 3]), at(0.0).bytes([0.2; 3]));
        assert_eq!(at(-2.0).bytes([0.4; 3]), at(0.0).bytes([0.1; 3]));
    }

    #[test]
    fn sizes_must_fit() {
        assert!(encode(2, 2, &[0; 9], ExtendedColorType::Rgb8).is_err());
        assert!(encode(0, 0, &[], ExtendedColorType::Rgb8).is_err());
    }
}
