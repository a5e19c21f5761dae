//! `cargo xtask gallery`: renders the still life and draws the four pictures of README.md into
//! `docs/images/gallery`.
//!
//! Two renders of 480 × 320 pixels, six minutes on two cores of a software driver. The error map
//! and the mask show layers of the first render's EXR; nothing is rendered for them.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use image::{Rgb, RgbImage};
use surelight_film::{ExrImage, LUMINANCE_FLOOR, read_exr};
use surelight_scenes::{glb, still_life};

use crate::{lettering, surelight_beside};

/// No picture of the gallery may be larger.
const MAX_BYTES: u64 = 300 * 1024;
/// Size of the renders.
const SIZE: &str = "480x320";
/// Height of the strip with the legend, below a picture.
const LEGEND: u32 = 30;
/// Relative errors at the ends of the colour map, on a logarithmic scale.
const ERRORS: [f64; 2] = [0.005, 0.5];
/// Weights of linear Rec. 709 in luminance.
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];
/// Viridis (Smith and van der Walt 2015) at nine even steps, sRGB: it rises evenly in lightness,
/// and readers who are colour-blind tell its ends apart.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];
/// Colours of certified and other pixels: blue and orange of Okabe and Ito's palette (2008).
const CERTIFIED: [u8; 3] = [0, 114, 178];
const UNCERTIFIED: [u8; 3] = [230, 159, 0];

/// Arguments of `cargo xtask gallery`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Program that renders [default: the one beside this tool's own: cargo build --release]
    #[arg(long, value_name = "BINARY")]
    surelight: Option<PathBuf>,
    /// Samples per pixel; pixels are certified from 256 on
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=65536))]
    spp: u32,
}

/// Renders and draws. The error is a sentence for the user.
pub(crate) fn run(repository: &Path, arguments: &Arguments) -> Result<(), String> {
    let scratch = repository.join("target/gallery");
    let target = repository.join("docs/images/gallery");
    for folder in [&scratch, &target] {
        fs::create_dir_all(folder).map_err(|e| format!("{} cannot be created: {e}", folder.display()))?;
    }
    let scene = scratch.join("still-life.glb");
    let bytes = glb::encode(&still_life::still_life(), "It has no closed form.").map_err(|e| e.to_string())?;
    fs::write(&scene, bytes).map_err(|e| format!("{} cannot be written: {e}", scene.display()))?;

    let surelight = arguments.surelight.clone().unwrap_or_else(surelight_beside);
    let render = |options: &[&str], outputs: &[&Path]| {
        let mut command = Command::new(&surelight);
        command.arg(&scene).args(["--size", SIZE, "--spp", &arguments.spp.to_string()]).args(options);
        for path in outputs {
            command.arg("-o").arg(path);
        }
        let status = command.status().map_err(|e| format!("{} cannot be run: {e}", surelight.display()))?;
        if status.success() { Ok(()) } else { Err(format!("{} ended with {status}", surelight.display())) }
    };
    // Renders keep their checkpoints beside them.
    let layers = scratch.join("still-life.exr");
    let [picture, detail] = ["still-life.png", "detail.png"].map(|name| target.join(name));
    let rendered = ["still-life.png", "detail.png"].map(|name| scratch.join(name));
    render(&[], &[&rendered[0], &layers])?;
    render(&["--camera", "detail", "--aperture", "0.01", "--focus", "0.9"], &[&rendered[1]])?;
    for (from, to) in rendered.iter().zip([&picture, &detail]) {
        fs::copy(from, to).map_err(|e| format!("{} cannot be written: {e}", to.display()))?;
    }

    let exr = read_exr(&layers).map_err(|e| format!("{}: {e}", layers.display()))?;
    let error = target.join("error.png");
    let mask = target.join("certified.png");
    save(&error_map(&exr)?, &error)?;
    save(&certified_mask(&exr)?, &mask)?;
    for path in [picture, error, mask, detail] {
        let bytes = fs::metadata(&path).map_err(|e| format!("{}: {e}", path.display()))?.len();
        println!("{}: {bytes} bytes", path.display());
        if bytes > MAX_BYTES {
            return Err(format!("{} takes {bytes} bytes; the limit is {MAX_BYTES}", path.display()));
        }
    }
    Ok(())
}

/// Standard error of each pixel's luminance over the luminance, as in a render's summary: pixels
/// darker than a tenth of the mean are taken as that bright. The standard errors of the channels
/// are added, which is exact for grey light and an upper bound for any other.
fn error_map(exr: &ExrImage) -> Result<RgbImage, String> {
    let luminance = luminance(exr)?;
    let variance = exr.rgb("Variance").ok_or("the render has no variance")?;
    let floor = LUMINANCE_FLOOR * luminance.iter().sum::<f64>() / luminance.len() as f64;
    let decades = (ERRORS[1] / ERRORS[0]).log10();
    let mut map = canvas(exr);
    for (i, &y) in luminance.iter().enumerate() {
        let error: f64 = (0..3).map(|c| LUMINANCE[c] * f64::from(variance[c][i]).sqrt()).sum();
        put(&mut map, exr, i, viridis((error / y.max(floor) / ERRORS[0]).log10() / decades));
    }
    let (width, height) = map.dimensions();
    let mut words = text(8, height, "relative error");
    let bar = [110, width - 48];
    for x in bar[0]..bar[1] {
        let color = viridis(f64::from(x - bar[0]) / f64::from(bar[1] - bar[0] - 1));
        (height - LEGEND + 5..height - 13).for_each(|y| map.put_pixel(x, y, Rgb(color)));
    }
    for (label, value) in
        [("0.5 %", 0.005), ("1 %", 0.01), ("2 %", 0.02), ("5 %", 0.05), ("10 %", 0.1), ("20 %", 0.2), ("50 %", 0.5)]
    {
        let at = (value / ERRORS[0]).log10() / decades;
        let x = f64::from(bar[0]) + at * f64::from(bar[1] - bar[0]) - 3.0 * label.len() as f64;
        words += &text(x as u32, height + 7, label);
    }
    lettering::print(&mut map, &words)?;
    Ok(map)
}

/// The picture in grey, tinted by the verdict on each pixel's error bar.
fn certified_mask(exr: &ExrImage) -> Result<RgbImage, String> {
    let certified = exr.channels.get("Certified.V").ok_or("the render has no certificates")?;
    let mut mask = canvas(exr);
    for (i, y) in luminance(exr)?.into_iter().enumerate() {
        let grey = 0.35 + 0.65 * (y / (y + 0.18));
        let tint = if certified[i] > 0.5 { CERTIFIED } else { UNCERTIFIED };
        put(&mut mask, exr, i, tint.map(|c| (f64::from(c) * grey) as u8));
    }
    let share = 100.0 * certified.iter().filter(|&&v| v > 0.5).count() as f64 / certified.len() as f64;
    let (width, height) = mask.dimensions();
    let mut words = String::new();
    let labels = [format!("certified: {share:.0} % of the pixels"), "not certified".to_owned()];
    for ((label, tint), x) in labels.iter().zip([CERTIFIED, UNCERTIFIED]).zip([8, width / 2 + 40]) {
        for y in height - LEGEND + 8..height - 10 {
            (x..x + 12).for_each(|x| mask.put_pixel(x, y, Rgb(tint)));
        }
        words += &text(x + 18, height, label);
    }
    lettering::print(&mut mask, &words)?;
    Ok(mask)
}

fn luminance(exr: &ExrImage) -> Result<Vec<f64>, String> {
    let rgb = exr.rgb("").ok_or("the render has no picture")?;
    Ok((0..rgb[0].len()).map(|i| (0..3).map(|c| LUMINANCE[c] * f64::from(rgb[c][i])).sum()).collect())
}

/// White, as large as a render and the strip of its legend.
fn canvas(exr: &ExrImage) -> RgbImage {
    RgbImage::from_pixel(exr.width as u32, exr.height as u32 + LEGEND, Rgb([255; 3]))
}

fn put(image: &mut RgbImage, exr: &ExrImage, pixel: usize, color: [u8; 3]) {
    image.put_pixel((pixel % exr.width) as u32, (pixel / exr.width) as u32, Rgb(color));
}

/// SVG text in the strip of a picture of this height.
fn text(x: u32, height: u32, words: &str) -> String {
    format!("<text x=\"{x}\" y=\"{}\">{words}</text>", height - LEGEND / 2 + 4)
}

/// Viridis at a share of its range, interpolated linearly; ends outside of it, black for NaN.
fn viridis(at: f64) -> [u8; 3] {
    if at.is_nan() {
        return [0; 3];
    }
    let steps = VIRIDIS.len() - 1;
    let at = at.clamp(0.0, 1.0) * steps as f64;
    let low = (at as usize).min(steps - 1);
    let f = at - low as f64;
    let channel = |c: usize| f64::from(VIRIDIS[low][c]) * (1.0 - f) + f64::from(VIRIDIS[low + 1][c]) * f;
    [0, 1, 2].map(|c| channel(c).round() as u8)
}

/// A PNG as small as the encoder makes it.
fn save(image: &RgbImage, path: &Path) -> Result<(), String> {
    use image::ImageEncoder;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};

    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(image, image.width(), image.height(), image::ExtendedColorType::Rgb8)
        .map_err(|e| format!("{}: {e}", path.display()))?;
    fs::write(path, bytes).map_err(|e| format!("{} cannot be written: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_show_the_layers() {
        let mut exr = ExrImage { width: 160, height: 2, ..ExrImage::default() };
        let count = exr.width * exr.height;
        for name in ["R", "G", "B"] {
            exr.channels.insert(name.into(), vec![1.0; count]);
            let variance = (0..count).map(|i| if i == 0 { 0.25 } else { 0.0 }).collect();
            exr.channels.insert(format!("Variance.{name}"), variance);
        }
        exr.channels.insert("Certified.V".into(), (0..count).map(|i| (i % 2) as f32).collect());
        let map = error_map(&exr).expect("all layers are there");
        assert_eq!((map.get_pixel(0, 0).0, map.get_pixel(1, 0).0), (VIRIDIS[8], VIRIDIS[0]));
        let mask = certified_mask(&exr).expect("all layers are there");
        assert!(mask.get_pixel(0, 0)[0] > 100 && mask.get_pixel(1, 0)[0] == 0);
        assert_eq!(mask.dimensions(), (160, 2 + LEGEND));
    }
}
