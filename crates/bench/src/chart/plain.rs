//! Charts of the figures of benches.

use super::{
    Chart, Format,
    axis::{Axis, Unit},
    both,
    canvas::{Dash, Fill},
    lines::{self, Lines, Series},
    rows::{Content, Rows},
};
use crate::error::BenchError;

/// Bars made of parts, one row per bar; `parts` are the names of the parts.
///
/// # Errors
/// Where the chart cannot be drawn.
pub fn bars(
    name: &'static str,
    title: &str,
    label: &str,
    parts: &[&str],
    rows: &[(String, Vec<f64>)],
) -> Result<Chart, BenchError> {
    let longest = rows.iter().map(|(_, parts)| parts.iter().sum::<f64>()).fold(0.0, f64::max);
    let rows = rows.iter().map(|(name, parts)| (name.clone(), Content::Parts(parts.clone()))).collect();
    let chart = Rows {
        name: name.into(),
        title: title.into(),
        x: Axis::linear(0.0, (1.02 * longest).max(1e-9), Unit::Plain),
        x_label: label.into(),
        rows,
        parts: parts.iter().map(|&p| p.into()).collect(),
    };
    both(name, |format: Format| chart.draw(format))
}

/// Lines over logarithmic axes: a name and points for each.
///
/// # Errors
/// Where the chart cannot be drawn.
pub fn curves(
    name: &'static str,
    title: &str,
    [x_label, y_label]: [&str; 2],
    curves: &[(&str, Vec<(f64, f64)>)],
) -> Result<Chart, BenchError> {
    let all = || curves.iter().flat_map(|(_, points)| points.iter().copied());
    let series = curves.iter().enumerate().map(|(i, (name, points))| Series {
        name: (*name).into(),
        style: lines::style(i, Fill::Full, Dash::Solid),
        points: points.clone(),
        band: Vec::new(),
    });
    let lines = Lines {
        name: name.into(),
        title: title.into(),
        x: Axis::log(all().map(|p| p.0), Unit::Plain),
        y: Axis::log(all().map(|p| p.1), Unit::Plain),
        x_label: x_label.into(),
        y_label: y_label.into(),
        series: series.collect(),
        guides: Vec::new(),
    };
    both(name, |format: Format| lines.draw(format))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_charts_hold_their_words() {
        let rows = [("row".to_owned(), vec![1.0, 2.0])];
        let drawn = bars("bars", "a title", "units", &["first", "second"], &rows).unwrap();
        let lines = curves("curves", "a title", ["x", "y"], &[("line", vec![(1.0, 1.0), (10.0, 2.0)])]).unwrap();
        for (chart, words) in [(drawn, ["row", "second", "units"]), (lines, ["line", "a title", "y"])] {
            assert!(words.iter().all(|word| chart.wide.contains(word)), "{}", chart.name);
        }
    }
}
