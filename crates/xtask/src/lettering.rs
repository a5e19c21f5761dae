//! Words on pictures.

use image::RgbImage;
use resvg::{tiny_skia, usvg};

const FONT: &[u8] = include_bytes!("../../bench/font/DejaVuSans-subset.ttf");

/// Draws SVG text in black over a picture.
pub(crate) fn print(sheet: &mut RgbImage, words: &str) -> Result<(), String> {
    let (width, height) = sheet.dimensions();
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         font-family=\"DejaVu Sans\" font-size=\"10\">{words}</svg>"
    );
    let mut options = usvg::Options::default();
    options.fontdb_mut().load_font_data(FONT.to_vec());
    let tree = usvg::Tree::from_str(&svg, &options).map_err(|error| format!("the text cannot be set: {error}"))?;
    let mut ink = tiny_skia::Pixmap::new(width, height).ok_or("a sheet has no size")?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut ink.as_mut());
    for (paper, ink) in sheet.pixels_mut().zip(ink.pixels()) {
        for channel in &mut paper.0 {
            *channel = (u32::from(*channel) * (255 - u32::from(ink.alpha())) / 255) as u8;
        }
    }
    Ok(())
}
