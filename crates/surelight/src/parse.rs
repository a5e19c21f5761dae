//! Values of options: their syntax and their errors.

use std::ffi::OsStr;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::ValueEnum;
use clap::builder::{OsStringValueParser, TypedValueParser};

use crate::exposure::Exposure;

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// Longest side of an image; larger ones are likelier a slip of the finger than a wish.
const MAX_SIDE: u32 = 65_536;

/// `--max-bounces`: `None` is unlimited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bounces(pub(crate) Option<u32>);

/// Something chosen by name or by number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Selector(pub(crate) String);

impl Selector {
    /// The number, when it is one.
    pub(crate) fn index(&self) -> Option<usize> {
        self.0.parse().ok()
    }
}

/// The format of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Linear, all layers
    Exr,
    /// Tone mapped, sRGB
    Png,
}

/// A file to write.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OutputPath {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
}

impl OutputPath {
    /// Whether it is no file, but standard output.
    pub(crate) fn is_stdout(&self) -> bool {
        is_dash(&self.path)
    }

    /// As the summary names it.
    pub(crate) fn name(&self) -> String {
        if self.is_stdout() { STANDARD_OUTPUT.to_owned() } else { self.path.display().to_string() }
    }
}

/// The name of `-o -` in messages.
pub(crate) const STANDARD_OUTPUT: &str = "standard output";

/// Whether a path means standard output; a file of that name is `./-`.
pub(crate) fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The output that `-o` names, before `--format` is known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OutputName {
    path: PathBuf,
    /// By the name, or why the name does not determine it.
    format: Result<Format, String>,
}

/// Parses `-o PATH`, which need not be UTF-8, where `--format` may state the format.
pub(crate) fn output_names() -> impl TypedValueParser<Value = OutputName> {
    OsStringValueParser::new().try_map(|text| output_name(&text))
}

/// Parses `-o PATH` where the name alone determines the format.
pub(crate) fn output_paths() -> impl TypedValueParser<Value = OutputPath> {
    OsStringValueParser::new().try_map(|text| output_path(&text))
}

/// Parses `--map OUT.png`, which need not be UTF-8.
pub(crate) fn png_paths() -> impl TypedValueParser<Value = OutputPath> {
    OsStringValueParser::new().try_map(|text| png_path(&text))
}

/// Parses the path of a folder that exists, which need not be UTF-8.
pub(crate) fn folders() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|text| folder(text.into()))
}

fn folder(path: PathBuf) -> Result<PathBuf, String> {
    match path.metadata() {
        Ok(metadata) if metadata.is_dir() => Ok(path),
        Ok(_) => Err("this is a file, and a folder is needed".into()),
        Err(error) if error.kind() == ErrorKind::NotFound => Err("the folder does not exist".into()),
        Err(error) => Err(format!("the folder cannot be read: {}", surelight_film::io_cause(&error))),
    }
}

fn output_name(text: &OsStr) -> Result<OutputName, String> {
    if text.as_encoded_bytes().last().is_some_and(|&byte| std::path::is_separator(byte.into())) {
        return Err("expected a file, but this names a folder".into());
    }
    let path = PathBuf::from(text);
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    let format = match extension.as_deref() {
        Some("exr") => Ok(Format::Exr),
        Some("png") => Ok(Format::Png),
        Some(other) => Err(format!(".{other} is not a format Surelight writes; use .png or .exr")),
        None => Err("the name must end in .png or .exr, which is the format".to_owned()),
    };
    Ok(OutputName { path, format })
}

/// The format of `-o`, where the name alone determines it.
pub(crate) fn output_path(text: impl AsRef<OsStr>) -> Result<OutputPath, String> {
    let OutputName { path, format } = output_name(text.as_ref())?;
    Ok(OutputPath { path, format: format? })
}

/// The outputs that `-o` and `--format` name together, or the error in them.
pub(crate) fn outputs(names: &[OutputName], format: Option<Format>) -> Result<Vec<OutputPath>, String> {
    let output = |OutputName { path, format: known }: &OutputName| match (known, format) {
        (&Ok(format), _) | (Err(_), Some(format)) => Ok(OutputPath { path: path.clone(), format }),
        (Err(_), None) if is_dash(path) => Err("'--output -' needs '--format png' or '--format exr'".to_owned()),
        (Err(cause), None) => Err(format!("invalid value '{}' for '--output <PATH>': {cause}", path.display())),
    };
    let outputs = names.iter().map(output).collect::<Result<Vec<_>, _>>()?;
    if outputs.iter().filter(|output| output.is_stdout()).count() > 1 {
        return Err("'--output -' is given twice, and there is one standard output".to_owned());
    }
    if format.is_some() && names.iter().all(|name| name.format.is_ok()) {
        return Err("'--format' is for '--output -' and for names that end in neither .png nor .exr".to_owned());
    }
    Ok(outputs)
}

fn png_path(text: &OsStr) -> Result<OutputPath, String> {
    match output_path(text)? {
        output if output.format == Format::Png => Ok(output),
        _ => Err("the name must end in .png".into()),
    }
}

/// `--size WxH`.
pub(crate) fn size(text: &str) -> Result<Size, String> {
    let wrong = || "expected width x height in pixels, for example 640x480".to_owned();
    let (width, height) = text.split_once(['x', 'X', '×']).ok_or_else(wrong)?;
    let side = |text: &str| match text.trim().parse::<u64>() {
        Ok(0) => Err("an image has at least 1 pixel a side".to_owned()),
        Ok(side) if side > u64::from(MAX_SIDE) => Err(format!("an image has at most {MAX_SIDE} pixels a side")),
        Ok(side) => Ok(side as u32),
        Err(_) => Err(wrong()),
    };
    Ok(Size { width: side(width)?, height: side(height)? })
}

/// `--time 90s`: numbers with the units h, m, s or ms, added up; a bare number is seconds.
pub(crate) fn duration(text: &str) -> Result<Duration, String> {
    let wrong = || "expected a time, for example 90s, 1.5m or 1h30m".to_owned();
    let mut rest = text.trim();
    let mut seconds = 0.0;
    if rest.is_empty() {
        return Err(wrong());
    }
    while !rest.is_empty() {
        let digits = rest.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(rest.len());
        let number: f64 = rest[..digits].parse().map_err(|_| wrong())?;
        rest = &rest[digits..];
        let letters = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
        let unit = match &rest[..letters] {
            "h" => 3600.0,
            "m" | "min" => 60.0,
            "s" => 1.0,
            "ms" => 1e-3,
            "" if digits == text.trim().len() => 1.0,
            _ => return Err(wrong()),
        };
        seconds += number * unit;
        rest = &rest[letters..];
    }
    if seconds <= 0.0 {
        return Err("the time must be longer than zero".into());
    }
    Duration::try_from_secs_f64(seconds).map_err(|_| "that is longer than any machine lasts".into())
}

/// `--max-bounces N|unlimited`.
pub(crate) fn bounces(text: &str) -> Result<Bounces, String> {
    if text == "unlimited" {
        return Ok(Bounces(None));
    }
    let number = text.parse().map_err(|_| "expected a number such as 8, or unlimited".to_owned())?;
    Ok(Bounces(Some(number)))
}

/// A name or a number.
pub(crate) fn selector(text: &str) -> Result<Selector, String> {
    if text.is_empty() {
        return Err("expected a name or a number".into());
    }
    Ok(Selector(text.to_owned()))
}

/// `--spp N`.
pub(crate) fn count(text: &str) -> Result<u32, String> {
    match text.trim().parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err(format!("expected a whole number from 1 to {}", u32::MAX)),
    }
}

/// A finite number.
pub(crate) fn finite(text: &str) -> Result<f32, String> {
    match text.trim().parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("expected a number".into()),
    }
}

/// A finite number above zero.
pub(crate) fn positive(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(number) if number > 0.0 => Ok(number),
        _ => Err("expected a number above zero".into()),
    }
}

/// `--tolerance PERCENT`.
pub(crate) fn percentage(text: &str) -> Result<f64, String> {
    match text.trim().trim_end_matches('%').parse::<f64>() {
        Ok(number) if (0.0..=1000.0).contains(&number) => Ok(number),
        _ => Err("expected percent, for example 5".into()),
    }
}

/// `--exposure EV|auto`.
pub(crate) fn exposure_or_auto(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    exposure(text).map(Exposure::Stops).map_err(|_| "expected auto, or stops between -64 and 64".into())
}

/// `--exposure EV`. Beyond ±64 stops every picture is black or white.
pub(crate) fn exposure(text: &str) -> Result<f32, String> {
    match finite(text) {
        Ok(number) if number.abs() <= 64.0 => Ok(number),
        _ => Err("expected stops between -64 and 64".into()),
    }
}

/// `--fov DEG`.
pub(crate) fn field_of_view(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees),
        _ => Err("expected degrees above 0 and below 180".into()),
    }
}

/// `X0,Y0,X1,Y1`: a rectangle of pixels, the last two outside.
pub(crate) fn rectangle(text: &str) -> Result<[u32; 4], String> {
    let numbers: Vec<u32> =
        text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>().unwrap_or_default();
    match <[u32; 4]>::try_from(numbers) {
        Ok([x0, y0, x1, y1]) if x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        Ok(_) => Err("the region is empty: X1 and Y1 must be above X0 and Y0".into()),
        Err(_) => Err("expected four whole numbers with commas, for example 100,50,140,80".into()),
    }
}

/// `A..B`: samples from A up to B, B not included.
pub(crate) fn samples(text: &str) -> Result<[u32; 2], String> {
    let ends = text.split_once("..").and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    match ends {
        Some([first, end]) if first < end => Ok([first, end]),
        Some(_) => Err("there is no sample between them: B must be above A".into()),
        None => Err("expected A..B, for example 0..16: samples from A up to B, B not included".into()),
    }
}

fn triple(text: &str) -> Option<[f64; 3]> {
    let numbers: Vec<f64> = text.split(',').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    let triple: [f64; 3] = numbers.try_into().ok()?;
    triple.iter().all(|number| number.is_finite()).then_some(triple)
}

/// `x,y,z`.
pub(crate) fn point(text: &str) -> Result<[f64; 3], String> {
    triple(text).ok_or_else(|| "expected three numbers with commas, for example 0,1.5,4".into())
}

/// `R,G,B`.
pub(crate) fn radiance(text: &str) -> Result<[f32; 3], String> {
    match triple(text).map(|rgb| rgb.map(|c| c as f32)) {
        Some(rgb) if rgb.iter().all(|&c| c >= 0.0 && c.is_finite()) => Ok(rgb),
        _ => Err("expected three numbers of at least zero with commas, for example 1,1,1".into()),
    }
}

/// `--error 2%`.
pub(crate) fn relative_error(text: &str) -> Result<f64, String> {
    let percent = text.trim().strip_suffix('%').map(str::trim_end);
    let share = percent.unwrap_or(text).trim().parse::<f64>().map(|v| if percent.is_some() { v / 100.0 } else { v });
    match share {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("expected a relative error between 0 and 100%, for example 2%".into()),
    }
}

/// `--confidence 95%`: a share below 1.
pub(crate) fn confidence(text: &str) -> Result<f64, String> {
    let percent = text.trim().strip_suffix('%').map(str::trim_end);
    let share = percent.unwrap_or(text).trim().parse::<f64>().map(|v| if percent.is_some() { v / 100.0 } else { v });
    match share {
        Ok(share) if (0.5..=0.999_999).contains(&share) => Ok(share),
        _ => Err("expected a confidence between 50% and 99.9999%, for example 95%".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("640x480"), Ok(Size { width: 640, height: 480 }));
        assert_eq!(size("1×4096"), Ok(Size { width: 1, height: 4096 }));
        for wrong in ["", "640", "640x", "x480", "0x5", "-1x5", "640x480x3", "99999999999x1", "6.5x3"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn durations() {
        for (text, milliseconds) in
            [("90s", 90_000), ("1.5m", 90_000), ("1h30m", 5_400_000), ("250ms", 250), ("2", 2_000)]
        {
            assert_eq!(duration(text), Ok(Duration::from_millis(milliseconds)), "{text}");
        }
        for wrong in ["", "s", "0", "0s", "-1s", "5x", "1h30", "1.2.3s", "5 s", "1e400s"] {
            assert!(duration(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn rectangles_and_samples() {
        assert_eq!(rectangle("1,2, 3,4"), Ok([1, 2, 3, 4]));
        for wrong in ["", "1,2,3", "1,2,1,4", "-1,0,2,2", "1,2,3,4,5"] {
            assert!(rectangle(wrong).is_err(), "{wrong}");
        }
        assert_eq!(samples("0..16"), Ok([0, 16]));
        for wrong in ["", "16", "..", "4..", "..4", "4..4", "5..4", "-1..4", "0..1..2"] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn outputs_are_known_by_their_ending() {
        assert_eq!(output_path("a/b.PNG").map(|o| o.format), Ok(Format::Png));
        assert_eq!(output_path("b.exr").map(|o| o.format), Ok(Format::Exr));
        for wrong in ["a.jpg", "a", ".png", "a.png/"] {
            assert!(output_path(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_format_is_for_names_that_tell_none() {
        let typed = |names: &[&str], format| {
            let names: Vec<_> = names.iter().map(|name| output_name(OsStr::new(name)).unwrap()).collect();
            outputs(&names, format).map(|all| all.into_iter().map(|output| output.format).collect::<Vec<_>>())
        };
        assert_eq!(typed(&["-", "a.png"], Some(Format::Exr)), Ok(vec![Format::Exr, Format::Png]));
        assert_eq!(typed(&["/dev/fd/3"], Some(Format::Png)), Ok(vec![Format::Png]));
        for (names, format, words) in [
            (&["-"][..], None, "'--format png' or '--format exr'"),
            (&["a.jpg"], None, "'a.jpg' for '--output <PATH>': .jpg"),
            (&["-", "-"], Some(Format::Png), "twice"),
            (&["a.png"], Some(Format::Png), "'--format' is for"),
        ] {
            let cause = typed(names, format).unwrap_err();
            assert!(cause.contains(words), "{cause}");
        }
    }

    #[test]
    fn numbers_are_checked() {
        assert_eq!(bounces("unlimited"), Ok(Bounces(None)));
        assert_eq!(bounces("0"), Ok(Bounces(Some(0))));
        assert_eq!(count("4294967295"), Ok(u32::MAX));
        assert!(count("0").is_err() && count("-3").is_err() && count("4294967296").is_err());
        assert!(bounces("-1").is_err() && bounces("many").is_err());
        assert_eq!(point("1,-2, 3e1"), Ok([1.0, -2.0, 30.0]));
        assert!(point("1,2").is_err() && point("1,2,nan").is_err() && point("1,2,3,4").is_err());
        assert!(radiance("1,-1,1").is_err() && radiance("1,1,1e39").is_err());
        assert_eq!(percentage("5%"), Ok(5.0));
        assert!(percentage("-1").is_err() && percentage("much").is_err());
        assert!(positive("0").is_err() && positive("inf").is_err() && positive("0.5").is_ok());
        assert!(field_of_view("180").is_err() && field_of_view("0").is_err());
        assert!(exposure("65").is_err() && exposure("-3").is_ok());
        assert_eq!(exposure_or_auto("auto"), Ok(Exposure::Auto));
        assert_eq!(exposure_or_auto("+1.5"), Ok(Exposure::Stops(1.5)));
        assert!(exposure_or_auto("automatic").unwrap_err().contains("auto"));
        assert_eq!(Selector("3".into()).index(), Some(3));
        assert_eq!(Selector("3a".into()).index(), None);
    }

    #[test]
    fn errors_are_read() {
        assert_eq!((relative_error("2%"), relative_error("0.5")), (Ok(0.02), Ok(0.5)));
        for wrong in ["", "0", "100%", "2", "-1%"] {
            assert!(relative_error(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn confidences_are_read() {
        assert_eq!((confidence("95%"), confidence("0.99")), (Ok(0.95), Ok(0.99)));
        for wrong in ["", "0", "1", "100%", "10%", "95"] {
            assert!(confidence(wrong).is_err(), "{wrong}");
        }
    }
}
