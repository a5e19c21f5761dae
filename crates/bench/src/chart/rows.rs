//! Charts with a row for each method: intervals, and bars made of parts.

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, VPos},
};

use super::{
    axis::{Axis, Unit},
    canvas::{
        Area, COLORS, Dash, Drawn, FAINT, Format, GRID, INK, SCALE, Style, TEXT, line, mark, sheet, text_style,
        text_width, write,
    },
};
use crate::error::BenchError;

/// The content of a row.
pub(super) enum Content {
    /// A value with its interval.
    Interval {
        /// Style of the mark.
        style: Style,
        /// Lower end, value, upper end; beyond the axis an arrow replaces it.
        ends: [f64; 3],
    },
    /// Successive lengths.
    Parts(Vec<f64>),
}

/// A chart of rows.
pub(super) struct Rows {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) x_label: String,
    pub(super) rows: Vec<(String, Content)>,
    /// Names of the parts.
    pub(super) parts: Vec<String>,
}

const ROW: i32 = 26 * SCALE;

/// Position of the legend.
const LEGEND_LEFT: i32 = 14 * SCALE;
const LEGEND_TOP: i32 = 52 * SCALE;

/// Colours of parts: colour-blind safe, with different grey levels for neighbours.
const PARTS: [RGBColor; 5] = [RGBColor(190, 190, 190), COLORS[6], COLORS[5], RGBColor(240, 228, 66), COLORS[0]];

impl Rows {
    /// Draws the chart.
    pub(super) fn draw(&self, format: Format) -> Result<String, BenchError> {
        let small = format == Format::Narrow;
        // In the narrow format a row's name is above it.
        let row = if small { 2 * ROW - 6 * SCALE } else { ROW };
        let names = self.rows.iter().map(|(name, _)| text_width(name, TEXT)).max().unwrap_or(0);
        let left = if small { 14 * SCALE } else { names + 24 * SCALE };
        let width = if small { 380 * SCALE } else { (left + 560 * SCALE).max(860 * SCALE) };
        let places = self.legend_places(width, small);
        let legend = places.last().map_or(0, |&(_, y)| y - LEGEND_TOP + 30 * SCALE);
        let top = 44 * SCALE + legend;
        let height = top + self.rows.len() as i32 * row + 58 * SCALE;
        sheet(&self.name, &self.title, [width, height], |sheet| {
            let title_size = if small { TEXT } else { TEXT + 2 * SCALE };
            write(sheet, &self.title, (12 * SCALE, 20 * SCALE), title_size, HPos::Left)?;
            self.legend(sheet, &places)?;
            let label = text_style(TEXT, INK, HPos::Center, VPos::Center);
            let mut chart = ChartBuilder::on(sheet)
                .margin_top(top)
                .margin_left(left)
                .margin_right(if small { 14 } else { 60 } * SCALE)
                .x_label_area_size(50 * SCALE)
                .build_cartesian_2d(self.x.clone(), Axis::linear(self.rows.len() as f64, 0.0, Unit::Plain))?;
            chart
                .configure_mesh()
                .disable_y_mesh()
                .disable_y_axis()
                .x_labels(if small { 4 } else { 8 })
                .bold_line_style(GRID.stroke_width(SCALE as u32))
                .light_line_style(FAINT)
                .axis_style(INK.stroke_width(SCALE as u32))
                .label_style(label.clone())
                .axis_desc_style(label)
                .x_desc(self.x_label.as_str())
                .draw()?;
            let at = |x: f64, y: f64| chart.backend_coord(&(x.clamp(self.x.low, self.x.high), y));
            if self.x.low < 0.0 && self.x.high > 0.0 {
                let count = self.rows.len() as f64;
                line(sheet, &[at(0.0, 0.0), at(0.0, count)], INK, SCALE as u32, Dash::Solid)?;
            }
            for (index, (name, content)) in self.rows.iter().enumerate() {
                let (x0, y) = at(self.x.low, index as f64 + if small { 0.66 } else { 0.5 });
                if small {
                    let above = at(self.x.low, index as f64 + 0.25).1;
                    write(sheet, name, (left, above), TEXT, HPos::Left)?;
                } else {
                    write(sheet, name, (x0 - 10 * SCALE, y), TEXT, HPos::Right)?;
                }
                self.content(sheet, content, y, &|x| at(x, 0.0).0)?;
            }
            Ok(())
        })
    }

    fn content(&self, sheet: &Area<'_>, content: &Content, y: i32, at: &dyn Fn(f64) -> i32) -> Drawn {
        match content {
            Content::Parts(parts) => {
                let mut from = 0.0;
                for (index, part) in parts.iter().enumerate() {
                    let (x0, x1) = (at(from), at(from + part));
                    let color = PARTS[index % PARTS.len()];
                    sheet.draw(&Rectangle::new([(x0, y - 7 * SCALE), (x1, y + 7 * SCALE)], color.filled()))?;
                    from += part;
                }
                Ok(())
            }
            Content::Interval { style, ends: [low, value, high] } => {
                let beyond = if *value > self.x.high { 1 } else { -i32::from(*value < self.x.low) };
                if beyond != 0 {
                    // An arrow at the edge, and the value beside it, towards the middle.
                    let x = at(*value);
                    let tip = vec![
                        (x, y),
                        (x - beyond * 10 * SCALE, y - 6 * SCALE),
                        (x - beyond * 10 * SCALE, y + 6 * SCALE),
                    ];
                    sheet.draw(&Polygon::new(tip, style.color.filled()))?;
                    let side = if beyond > 0 { HPos::Right } else { HPos::Left };
                    return write(sheet, &self.x.label(rounded(*value)), (x - beyond * 16 * SCALE, y), TEXT, side);
                }
                line(sheet, &[(at(*low), y), (at(*high), y)], style.color, 2 * SCALE as u32, Dash::Solid)?;
                for end in [low, high] {
                    let x = at(*end);
                    line(sheet, &[(x, y - 5 * SCALE), (x, y + 5 * SCALE)], style.color, 2 * SCALE as u32, Dash::Solid)?;
                }
                mark(sheet, (at(*value), y), style, 4 * SCALE)
            }
        }
    }

    /// The position of each part's entry: one below the other in the narrow format, otherwise in
    /// lines as wide as the chart.
    fn legend_places(&self, width: i32, small: bool) -> Vec<(i32, i32)> {
        let (mut x, mut y) = (LEGEND_LEFT, LEGEND_TOP);
        let mut places = Vec::new();
        for part in &self.parts {
            let needed = text_width(part, TEXT) + 44 * SCALE;
            if x > LEGEND_LEFT && (small || x + needed > width) {
                (x, y) = (LEGEND_LEFT, y + 20 * SCALE);
            }
            places.push((x, y));
            x += needed;
        }
        places
    }

    fn legend(&self, sheet: &Area<'_>, places: &[(i32, i32)]) -> Drawn {
        for (index, (part, &(x, y))) in self.parts.iter().zip(places).enumerate() {
            let color = PARTS[index % PARTS.len()];
            sheet.draw(&Rectangle::new([(x, y - 6 * SCALE), (x + 12 * SCALE, y + 6 * SCALE)], color.filled()))?;
            write(sheet, part, (x + 18 * SCALE, y), TEXT, HPos::Left)?;
        }
        Ok(())
    }
}

/// A value to two digits.
fn rounded(value: f64) -> f64 {
    let unit = 10f64.powf(value.abs().log10().floor() - 1.0);
    if unit.is_finite() && unit > 0.0 { (value / unit).round() * unit } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legends_stay_within_the_chart() {
        let parts: Vec<String> = crate::analysis::STAGES.map(Into::into).to_vec();
        let chart = Rows {
            name: String::new(),
            title: String::new(),
            x: Axis::linear(0.0, 1.0, Unit::Plain),
            x_label: String::new(),
            rows: Vec::new(),
            parts: parts.clone(),
        };
        let width = 860 * SCALE;
        let wide = chart.legend_places(width, false);
        assert!(wide.iter().zip(&parts).all(|(&(x, _), part)| x + 18 * SCALE + text_width(part, TEXT) <= width));
        assert_eq!(wide.iter().map(|p| p.1).max(), Some(LEGEND_TOP + 20 * SCALE));
        assert!(chart.legend_places(width, true).iter().all(|p| p.0 == LEGEND_LEFT));
    }

    #[test]
    fn two_digits_stay() {
        assert!((rounded(-0.2345) + 0.23).abs() < 1e-12);
        assert_eq!(rounded(0.0), 0.0);
    }
}
