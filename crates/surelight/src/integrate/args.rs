//! Options of `surelight integrate`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{OsStringValueParser, TypedValueParser};

use crate::parse::{self as value, Selector};

/// `surelight integrate EXPR --over a..b[,c..d…]`.
#[derive(Debug, Args)]
#[command(after_help = "\
The formula is one expression in WGSL syntax. Its variables are x0, x1, … x9, one for each range of --over; the first four are \
also x, y, z and w. The numbers pi, tau and e are known. It is evaluated in f32 on the device, so errors below about 1e-7 of \
the value are not resolved; sums are f64.

Examples:
  surelight integrate '5*pow(x,4)' --over 0..1
  surelight integrate 'f32(x*x + y*y < 1)' --over 0..1,0..1 --exact 0.7853982 -o circle.svg
  surelight integrate 'exp(-(x*x + y*y + z*z + w*w + x4*x4 + x5*x5))' --over 0..1,0..1,0..1,0..1,0..1,0..1")]
pub(crate) struct IntegrateArgs {
    /// Integrand, an expression in WGSL syntax such as '5*pow(x,4)'
    #[arg(value_name = "EXPR", allow_hyphen_values = true)]
    pub(crate) formula: String,

    /// Domain: a range per dimension, 1 to 10 of them, for example -1..1,0..2*pi
    #[arg(long, value_name = "a..b[,c..d…]", value_parser = ranges, allow_hyphen_values = true)]
    pub(crate) over: Ranges,

    /// Evaluations per method
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(32..=1 << 36), default_value_t = 1 << 20)]
    pub(crate) samples: u64,

    /// Confidence level of the error bars
    #[arg(long, value_name = "C%", value_parser = value::confidence, default_value = "95%")]
    pub(crate) confidence: f64,

    /// Exact value, where it is known, to measure errors from
    #[arg(long, value_name = "X", value_parser = number, allow_hyphen_values = true)]
    pub(crate) exact: Option<f64>,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u32,

    /// Convergence chart to write, .svg
    #[arg(short, long, value_name = "PATH", value_parser = OsStringValueParser::new().try_map(svg))]
    pub(crate) output: Option<PathBuf>,

    /// Adapter to run on, by name or index [default: the fastest kind]
    #[arg(long, value_name = "NAME|INDEX", value_parser = value::selector)]
    pub(crate) adapter: Option<Selector>,

    /// Print one JSON object
    #[arg(long)]
    pub(crate) json: bool,
}

/// A box: from and to of each dimension.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ranges(pub(crate) Vec<[f64; 2]>);

/// `--over`.
fn ranges(text: &str) -> Result<Ranges, String> {
    let all: Vec<_> = text.split(',').map(range).collect::<Result<_, _>>()?;
    if all.len() > surelight_render::MAX_DIMENSIONS {
        return Err(format!("{} dimensions, and 10 are the most", all.len()));
    }
    Ok(Ranges(all))
}

fn range(text: &str) -> Result<[f64; 2], String> {
    let (a, b) = text.split_once("..").ok_or_else(|| format!("expected a range such as 0..1, not \"{text}\""))?;
    let (a, b) = (number(a)?, number(b)?);
    if a >= b {
        return Err(format!("the range {text} is empty: its end must lie above its start"));
    }
    if !((b - a) as f32).is_finite() || ((b - a) as f32) < f32::MIN_POSITIVE || (a as f32) == (b as f32) {
        return Err(format!("the range {text} is too wide or too narrow for 32-bit numbers"));
    }
    Ok([a, b])
}

/// A finite number, `pi`, `tau`, `e`, or a multiple such as `2*pi`, `-0.5pi`.
fn number(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let named = |name: &str, value: f64| {
        let factor = text.strip_suffix(name)?.trim_end().trim_end_matches('*').trim_end();
        match factor {
            "" => Some(value),
            "-" => Some(-value),
            factor => factor.parse::<f64>().ok().map(|f| f * value),
        }
    };
    let value = text
        .parse::<f64>()
        .ok()
        .or_else(|| named("pi", std::f64::consts::PI))
        .or_else(|| named("tau", std::f64::consts::TAU))
        .or_else(|| named("e", std::f64::consts::E));
    value
        .filter(|v| v.is_finite())
        .ok_or_else(|| format!("\"{text}\" is not a number; write 0.5, -3, 1e-2, pi or 2*pi"))
}

fn svg(text: OsString) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension() {
        Some(extension) if extension.eq_ignore_ascii_case("svg") => Ok(path),
        _ => Err("the name must end in .svg".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read() {
        assert_eq!(ranges("0..1,-2.5..1e1"), Ok(Ranges(vec![[0.0, 1.0], [-2.5, 10.0]])));
        let Ok(Ranges(found)) = ranges("-pi..2*pi,0..e") else { panic!() };
        assert_eq!(found, [[-std::f64::consts::PI, std::f64::consts::TAU], [0.0, std::f64::consts::E]]);
        for wrong in ["", "0", "0..", "1..0", "1..1", "0..inf", "nan..1", "0..1,", "1..1.000000001", "0..1e300"] {
            assert!(ranges(wrong).is_err(), "{wrong}");
        }
        assert!(ranges(&["0..1"; 11].join(",")).unwrap_err().contains("10 are the most"));
    }
}
