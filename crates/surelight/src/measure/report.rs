//! The report of `surelight measure`.

use std::fmt::{self, Display};

use serde::Serialize;

/// A number with its error bar.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Value {
    pub(super) value: f64,
    /// Half width of the interval; `null` below two estimates.
    pub(super) half_width: Option<f64>,
}

/// A measurement; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) scene: String,
    /// `radiance`, `irradiance` or `mean radiance`.
    pub(super) quantity: &'static str,
    /// Where, in words.
    pub(super) place: String,
    /// Linear Rec. 709.
    pub(super) rgb: [Value; 3],
    /// Their Rec. 709 luminance: illuminance in lux where irradiance is measured, else luminance in
    /// nit.
    pub(super) luminance: Value,
    /// `lx` or `nit`.
    pub(super) unit: &'static str,
    pub(super) confidence: f64,
    /// Half width over value, in luminance.
    pub(super) relative_error: Option<f64>,
    /// The target of `--error`.
    pub(super) target_error: Option<f64>,
    /// Why it ended: `done`, `time`, `samples`, `missed` or `unreachable`.
    pub(super) stopped: &'static str,
    pub(super) samples: u64,
    /// Independent estimates behind the error bar.
    pub(super) replicates: u64,
    /// Samples of the pilot that fixed the number of samples; thrown away.
    pub(super) pilot_samples: u64,
    /// Shape of the tail of the estimates (Pareto k̂), and its limit for a reliable error bar.
    pub(super) tail: Option<[f64; 2]>,
    /// Whether the error bar is reliable.
    pub(super) certified: bool,
    pub(super) integrator: String,
    pub(super) seed: u32,
    pub(super) adapter: String,
    pub(super) rays: u64,
    pub(super) seconds: f64,
    pub(super) dropped_samples: u64,
    pub(super) truncated_rays: u64,
    pub(super) biased: Vec<String>,
    pub(super) warnings: Vec<String>,
    pub(super) notes: Vec<String>,
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lux = self.unit == "lx";
        let [r, g, b] = self.rgb;
        writeln!(f, "{} {}", self.quantity, self.place)?;
        writeln!(
            f,
            "  R {r}  G {g}  B {b}  (in the file's units: {} a channel)",
            if lux { "lx or W/m²" } else { "nit or W/(m² sr)" }
        )?;
        let name = if lux { "illuminance" } else { "luminance" };
        write!(f, "{name}  {} {}", self.luminance, self.unit)?;
        if let Some(half) = self.luminance.half_width {
            let (low, high) = (self.luminance.value - half, self.luminance.value + half);
            write!(f, "  ({} % confident: {} to {}", percent(self.confidence), Fitted(low, half), Fitted(high, half))?;
            match self.relative_error {
                Some(error) => write!(f, "; ± {:.2} %)", ShortNumber(error * 100.0))?,
                None => write!(f, ")")?,
            }
        }
        writeln!(f)?;
        writeln!(
            f,
            "samples  {} in {} independent estimates; {:.2} s, {} rays, integrator {}, {}",
            self.samples, self.replicates, self.seconds, self.rays, self.integrator, self.adapter
        )?;
        if self.pilot_samples > 0 {
            writeln!(
                f,
                "pilot    {} samples, which planned the number of samples and were discarded",
                self.pilot_samples
            )?;
        }
        if let Some(target) = self.target_error {
            let target_text = match self.stopped {
                "done" => "reached".to_owned(),
                "missed" => "not reached (the pilot planned too few samples)".to_owned(),
                "unreachable" => "unreachable: see the notes".to_owned(),
                why => format!("not reached ({why})"),
            };
            writeln!(f, "target   ± {} %: {target_text}", percent(target))?;
        }
        if !self.biased.is_empty() {
            writeln!(f, "biased   {}", self.biased.join(", "))?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning  {warning}")?;
        }
        for note in &self.notes {
            writeln!(f, "note     {note}")?;
        }
        Ok(())
    }
}

impl Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.half_width {
            Some(half) => write!(f, "{} ± {:.2}", Fitted(self.value, half), ShortNumber(half)),
            None => write!(f, "{} ± unknown", Fitted(self.value, 0.0)),
        }
    }
}

/// A number with as many digits as its error justifies: two of the error's, at most those of f32.
struct Fitted(f64, f64);

impl Display for Fitted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(value, half) = *self;
        let magnitude = value.abs().max(half);
        let exponent = |x: f64| if x > 0.0 { x.log10().floor() as i32 } else { -300 };
        let top = if magnitude > 0.0 { exponent(magnitude) } else { 0 };
        // The last place that is written, as a power of ten.
        let last = (exponent(half) - 1).max(top - 6);
        if !(-6..7).contains(&top) {
            return write!(f, "{:.*e}", (top - last).max(0) as usize, value);
        }
        write!(f, "{:.*}", (-last).max(0) as usize, value)
    }
}

/// Significant digits as the precision says, without an exponent where it reads well.
struct ShortNumber(f64);

impl Display for ShortNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digits = f.precision().unwrap_or(2);
        if self.0 == 0.0 {
            return f.write_str("0");
        }
        let exponent = self.0.abs().log10().floor() as i32;
        if !(-4..6).contains(&exponent) {
            return write!(f, "{:.*e}", digits - 1, self.0);
        }
        write!(f, "{:.*}", (digits as i32 - 1 - exponent).max(0) as usize, self.0)
    }
}

fn percent(share: f64) -> String {
    let text = format!("{:.4}", share * 100.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_fit_the_error() {
        for (value, half, text) in [
            (25.0, 0.0, "25.00000 ± 0"),
            (25.00314, 0.0123, "25.003 ± 0.012"),
            (0.0, 0.0, "0.000000 ± 0"),
            (1234.5678, 7.7, "1234.6 ± 7.7"),
            (1.5e-9, 2e-11, "1.500e-9 ± 2.0e-11"),
            (1.5e9, 2e7, "1.500e9 ± 2.0e7"),
        ] {
            assert_eq!(Value { value, half_width: Some(half) }.to_string(), text);
        }
        assert_eq!((percent(0.95), percent(0.001)), ("95".to_owned(), "0.1".to_owned()));
    }
}
