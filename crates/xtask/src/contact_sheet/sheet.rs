//! Pictures in rows, with words under them.

use std::path::Path;

use image::imageops::FilterType;
use image::{DynamicImage, GenericImage, Rgb, RgbImage};

use crate::lettering;

/// A file on the sheet.
#[derive(Debug)]
pub(crate) struct Entry {
    /// Path below the folder.
    pub(crate) name: String,
    /// The warnings of the program.
    pub(crate) note: String,
    /// The rendered picture.
    pub(crate) picture: Option<DynamicImage>,
    /// The published picture.
    pub(crate) published: Option<DynamicImage>,
}

const COLUMNS: usize = 3;
const ROWS: usize = 5;
/// Pixels around pictures, and below them for three lines of text.
const GAP: u32 = 8;
const TEXT: u32 = 36;
const PAPER: Rgb<u8> = Rgb([250, 250, 250]);

/// Writes the entries, 15 a sheet, each as rendered beside as published.
pub(crate) fn write(entries: &[Entry], size: u32, folder: &Path) -> Result<(), String> {
    let cell = [2 * size + 3 * GAP, size + 2 * GAP + TEXT];
    for (number, entries) in entries.chunks(COLUMNS * ROWS).enumerate() {
        let rows = entries.len().div_ceil(COLUMNS) as u32;
        let mut sheet = RgbImage::from_pixel(cell[0] * COLUMNS as u32, cell[1] * rows, PAPER);
        let mut words = String::new();
        for (i, entry) in entries.iter().enumerate() {
            let [x, y] = [(i % COLUMNS) as u32 * cell[0], (i / COLUMNS) as u32 * cell[1]];
            for (picture, x) in [(&entry.picture, x + GAP), (&entry.published, x + 2 * GAP + size)] {
                if let Some(picture) = picture {
                    let small = picture.resize(size, size, FilterType::Triangle).to_rgb8();
                    sheet.copy_from(&small, x, y + GAP).map_err(|error| format!("a picture does not fit: {error}"))?;
                }
            }
            let most = (2 * size / 6) as usize;
            let note: Vec<char> = entry.note.chars().collect();
            let second = note.chunks(most).nth(1).unwrap_or(&[]).iter().collect();
            let lines = [entry.name.clone(), note.iter().take(most).collect(), second];
            for (line, text) in lines.iter().enumerate() {
                let baseline = y + size + GAP + 11 * (line as u32 + 1);
                words += &format!("<text x=\"{}\" y=\"{baseline}\">{}</text>", x + GAP, escaped(text));
            }
        }
        lettering::print(&mut sheet, &words)?;
        let path = folder.join(format!("sheet-{:02}.png", number + 1));
        sheet.save(&path).map_err(|error| format!("\"{}\" cannot be written: {error}", path.display()))?;
        println!("{}", path.display());
    }
    Ok(())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_has_pictures_and_words() {
        let red = DynamicImage::ImageRgb8(RgbImage::from_pixel(8, 8, Rgb([200, 0, 0])));
        let entry = |picture| Entry { name: "a & b".into(), note: String::new(), picture, published: None };
        let folder = tempfile::tempdir().expect("a folder");
        let entries: Vec<_> = (0..16).map(|i| entry((i == 15).then(|| red.clone()))).collect();
        write(&entries, 64, folder.path()).expect("two sheets");
        let second = image::open(folder.path().join("sheet-02.png")).expect("the second").to_rgb8();
        assert_eq!(second.get_pixel(GAP + 32, GAP + 32), &Rgb([200, 0, 0]));
        let text = (0..second.width()).any(|x| second.get_pixel(x, 64 + GAP + 8)[0] < 128);
        assert!(text, "no words under the picture");
    }
}
