//! Text in a PNG: how its exposure was chosen.

use std::path::Path;

use crate::exposure::ExposureRecord;
use crate::{Display, Film, WriteError, encode_png};

/// Keyword of the text, as of the attribute of an EXR.
const KEYWORD: &str = "surelight";

/// Bytes before the first chunk that may hold text: the signature and IHDR.
const HEAD: usize = 8 + 25;

/// Like [`crate::write_png`], with the exposure as a JSON text under the keyword `surelight`.
///
/// # Errors
/// Where the file cannot be written; the target is then as it was.
pub fn write_png_with_exposure(
    path: &Path,
    film: &Film,
    display: &Display,
    exposure: &ExposureRecord,
) -> Result<(), WriteError> {
    let fail = |cause: String| WriteError::new(path, cause);
    let png = encode_png(film, display).map_err(fail)?;
    let json = serde_json::to_string(exposure).map_err(|error| fail(error.to_string()))?;
    crate::write_file(path, &with_text(&png, &format!("{{\"exposure\":{json}}}")))
}

/// A PNG with a chunk of text, which must be Latin-1.
fn with_text(png: &[u8], text: &str) -> Vec<u8> {
    let body = [b"tEXt", KEYWORD.as_bytes(), &[0], text.as_bytes()].concat();
    let length = (body.len() - 4) as u32; // the type of the chunk does not count
    [&png[..HEAD], &length.to_be_bytes(), &body, &crc(&body).to_be_bytes(), &png[HEAD..]].concat()
}

/// The checksum of a chunk (ISO 3309).
fn crc(bytes: &[u8]) -> u32 {
    let update = |crc: u32, &byte: &u8| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 })
    };
    !bytes.iter().fold(!0, update)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BatchSum;

    #[test]
    fn checksums_are_those_of_the_standard() {
        assert_eq!(crc(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc(b"IEND"), 0xAE42_6082);
    }

    /// The decoder checks every checksum.
    #[test]
    fn a_png_with_text_shows_the_same_picture() {
        let folder = tempfile::tempdir().unwrap();
        let mut film = Film::new(2, 1);
        film.add_batch(2, &[0, 1], &[[0.5; 3], [0.1; 3]].map(|c| BatchSum::constant(2, c))).unwrap();
        let display = Display { exposure_ev: 1.25, ..Display::default() };
        let record = ExposureRecord { ev: 1.25, automatic: true };
        let path = folder.path().join("a.png");
        write_png_with_exposure(&path, &film, &display, &record).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let text = b"tEXtsurelight\0{\"exposure\":{\"ev\":1.25,\"automatic\":true}}";
        assert!(bytes.windows(text.len()).any(|window| window == text));
        let plain = image::load_from_memory(&encode_png(&film, &display).unwrap()).unwrap();
        assert_eq!(image::load_from_memory(&bytes).unwrap(), plain);
    }
}
