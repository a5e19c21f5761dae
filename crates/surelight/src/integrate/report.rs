//! The report of `surelight integrate`.

use std::fmt::{self, Display};

use serde::Serialize;

/// An integral by several methods; its fields are the keys of `--json`.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    pub(super) formula: String,
    pub(super) over: Vec<[f64; 2]>,
    pub(super) adapter: String,
    pub(super) precision: &'static str,
    pub(super) confidence: f64,
    pub(super) seed: u32,
    pub(super) exact: Option<f64>,
    pub(super) methods: Vec<Row>,
    pub(super) chart: Option<String>,
    pub(super) notes: Vec<String>,
}

/// One method's result.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    pub(super) method: &'static str,
    /// `null` where the method needs more evaluations than it may use.
    pub(super) estimate: Option<f64>,
    /// Half width of the interval at the stated confidence; sampling alone has one.
    pub(super) half_width: Option<f64>,
    /// Independent sets of points behind it.
    pub(super) replicates: Option<u32>,
    /// Change from about half as fine a grid; quadrature alone has one. No bound.
    pub(super) change: Option<f64>,
    /// |estimate − exact|.
    pub(super) true_error: Option<f64>,
    pub(super) evaluations: u64,
    pub(super) seconds: f64,
    /// Values counted as 0 because they were not finite.
    pub(super) non_finite: u64,
    /// Evaluations and error at ever more evaluations, where a chart was requested.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) convergence: Vec<(f64, f64)>,
}

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ranges: Vec<_> = self.over.iter().map(|[a, b]| format!("{a}..{b}")).collect();
        writeln!(f, "integral of {} over {}", self.formula, ranges.join(", "))?;
        writeln!(
            f,
            "on {}, evaluated in f32 (errors below about 1e-7 of the value are not resolved), summed in f64",
            self.adapter
        )?;
        writeln!(f)?;
        let exact = if self.exact.is_some() { "   true error" } else { "" };
        writeln!(
            f,
            "{:<26}{:>16}  {:>14}{exact}  {:>12}  {:>9}",
            "method", "estimate", "error", "evaluations", "seconds"
        )?;
        for row in &self.methods {
            let Some(estimate) = row.estimate else {
                writeln!(f, "{:<26}{:>16}  needs more evaluations than --samples allows", row.method, "none")?;
                continue;
            };
            let error = match (row.half_width, row.change) {
                (Some(half), _) => format!("± {half:.2e}"),
                (None, Some(change)) => format!("~ {change:.2e}"),
                (None, None) => "unknown".to_owned(),
            };
            write!(f, "{:<26}{:>16}  {error:>14}", row.method, format!("{}", Digits(estimate)))?;
            if let Some(error) = row.true_error {
                write!(f, "  {:>11}", format!("{error:.2e}"))?;
            }
            writeln!(f, "  {:>12}  {:>9.4}", row.evaluations, row.seconds)?;
        }
        writeln!(f)?;
        writeln!(
            f,
            "±: {} % confidence interval (Student's t) from {} independent replicates",
            Digits(self.confidence * 100.0),
            self.methods.iter().find_map(|row| row.replicates).unwrap_or(0)
        )?;
        writeln!(f, "~: change from about half as fine a grid: a hint, not a bound; quadrature has no error bar")?;
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        if let Some(chart) = &self.chart {
            writeln!(f, "chart: {chart}")?;
        }
        Ok(())
    }
}

/// A number with 8 significant digits, no more zeros than needed.
pub(super) struct Digits(pub(super) f64);

impl Display for Digits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let magnitude = self.0.abs();
        if magnitude != 0.0 && !(1e-4..1e9).contains(&magnitude) {
            return write!(f, "{:.7e}", self.0);
        }
        let before = if magnitude < 1.0 { 0 } else { magnitude.log10().floor() as usize };
        let text = format!("{:.*}", 8usize.saturating_sub(before).max(1), self.0);
        write!(f, "{}", text.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_suffice_and_are_not_too_many() {
        for (number, text) in [
            (1.0, "1"),
            (95.0, "95"),
            (0.123_456_789_1, "0.12345679"),
            (-12.5, "-12.5"),
            (0.0, "0"),
            (1e-9, "1.0000000e-9"),
        ] {
            assert_eq!(Digits(number).to_string(), text);
        }
    }
}
