//! Charts of lines on two axes, with a legend that never covers them.

use plotters::{
    prelude::*,
    style::text_anchor::{HPos, VPos},
};

use super::{
    axis::Axis,
    canvas::{
        Area, COLORS, Dash, Drawn, FAINT, Fill, Format, GRID, INK, SCALE, Style, TEXT, line, mark, sheet, text_style,
        text_width, write,
    },
};
use crate::error::BenchError;

/// A line with its marks and band.
pub(super) struct Series {
    pub(super) name: String,
    pub(super) style: Style,
    pub(super) points: Vec<(f64, f64)>,
    /// Lower and upper end of the band at each point.
    pub(super) band: Vec<[f64; 2]>,
}

/// A straight line for orientation.
pub(super) enum Guide {
    /// y = c·x^p for every c: faint diagonals.
    Power {
        /// p.
        exponent: f64,
        /// Its meaning.
        name: String,
    },
    /// y at a height.
    Level {
        /// y.
        at: f64,
        /// Its meaning.
        name: String,
    },
    /// y = x.
    Diagonal {
        /// Its meaning.
        name: String,
    },
}

/// A chart of lines.
pub(super) struct Lines {
    pub(super) name: String,
    pub(super) title: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) x_label: String,
    pub(super) y_label: String,
    pub(super) series: Vec<Series>,
    pub(super) guides: Vec<Guide>,
}

/// Colour of diagonals: lighter than the data, and unlike the grid in hue.
const DIAGONAL: RGBColor = RGBColor(214, 196, 150);

const ROW: i32 = 21 * SCALE;
const KEY: i32 = 46 * SCALE;

impl Lines {
    /// Draws the chart.
    pub(super) fn draw(&self, format: Format) -> Result<String, BenchError> {
        let rows = (self.series.len() + self.guides.len()) as i32;
        let names = self.series.iter().map(|s| s.name.as_str()).chain(self.guides.iter().map(Guide::name));
        let legend_width = KEY + names.map(|n| text_width(n, TEXT)).max().unwrap_or(0) + 16 * SCALE;
        let (size, plot) = match format {
            Format::Wide => {
                let height = (470 * SCALE).max((rows + 3) * ROW);
                ([620 * SCALE + legend_width, height], (620 * SCALE, height))
            }
            Format::Narrow => {
                let plot = (380 * SCALE, 340 * SCALE);
                ([plot.0.max(legend_width), plot.1 + (rows + 2) * ROW], plot)
            }
        };
        sheet(&self.name, &self.title, size, |sheet| {
            let (above, below) = sheet.split_vertically(plot.1);
            let (left, right) = above.split_horizontally(plot.0);
            self.plot(&left, sheet, format)?;
            match format {
                Format::Wide => self.legend(&right, (0, 64 * SCALE)),
                Format::Narrow => self.legend(&below, (10 * SCALE, ROW)),
            }
        })
    }

    fn plot(&self, area: &Area<'_>, sheet: &Area<'_>, format: Format) -> Drawn {
        let small = format == Format::Narrow;
        let label = text_style(TEXT, INK, HPos::Center, VPos::Center);
        let mut chart = ChartBuilder::on(area)
            .margin_top(56 * SCALE)
            .margin_right(18 * SCALE)
            .x_label_area_size(44 * SCALE)
            .y_label_area_size(62 * SCALE)
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        let title_size = if small { TEXT } else { TEXT + 2 * SCALE };
        write(sheet, &self.title, (12 * SCALE, 18 * SCALE), title_size, HPos::Left)?;
        // Above the axis, since a label beside it would be rotated.
        write(sheet, &self.y_label, (12 * SCALE, 40 * SCALE), TEXT, HPos::Left)?;
        chart
            .configure_mesh()
            .x_labels(if small { 5 } else { 8 })
            .y_labels(8)
            .bold_line_style(GRID.stroke_width(SCALE as u32))
            .light_line_style(FAINT.stroke_width(SCALE as u32))
            .axis_style(INK.stroke_width(SCALE as u32))
            .label_style(label.clone())
            .axis_desc_style(label)
            .x_desc(self.x_label.as_str())
            .draw()?;
        let at = |x: f64, y: f64| chart.backend_coord(&(x, y));
        for guide in &self.guides {
            self.guide(sheet, guide, &at)?;
        }
        for series in &self.series {
            if series.band.len() == series.points.len() && series.points.len() > 1 {
                let upper = series.points.iter().zip(&series.band).map(|(p, b)| at(p.0, b[1].min(self.y.high)));
                let lower = series.points.iter().zip(&series.band).rev().map(|(p, b)| at(p.0, b[0].max(self.y.low)));
                let edge: Vec<_> = upper.chain(lower).collect();
                sheet.draw(&Polygon::new(edge, series.style.color.mix(0.14)))?;
            }
        }
        for series in &self.series {
            let points: Vec<_> = series.points.iter().map(|p| at(p.0, p.1)).collect();
            line(sheet, &points, series.style.color, 2 * SCALE as u32, series.style.dash)?;
            for &point in &points {
                mark(sheet, point, &series.style, 4 * SCALE)?;
            }
        }
        Ok(())
    }

    fn guide(&self, sheet: &Area<'_>, guide: &Guide, at: &dyn Fn(f64, f64) -> (i32, i32)) -> Drawn {
        let (x, y) = (&self.x, &self.y);
        match guide {
            Guide::Level { at: level, .. } => {
                line(sheet, &[at(x.low, *level), at(x.high, *level)], INK, SCALE as u32, Dash::Dashed)
            }
            Guide::Diagonal { .. } => {
                let (low, high) = (x.low.max(y.low), x.high.min(y.high));
                line(sheet, &[at(low, low), at(high, high)], INK, SCALE as u32, Dash::Dashed)
            }
            Guide::Power { exponent, .. } => {
                // One diagonal per half decade, from the left edge along the top.
                let constant = |x: f64, y: f64| y / x.powf(*exponent);
                let (first, last) = (constant(x.low, y.low).log10(), constant(x.high, y.high).log10());
                for step in (first * 2.0).ceil() as i32..=(last * 2.0).floor() as i32 {
                    let c = 10f64.powf(f64::from(step) / 2.0);
                    let from = (y.high / c).powf(1.0 / exponent).max(x.low);
                    let to = (y.low / c).powf(1.0 / exponent).min(x.high);
                    if from < to {
                        let ends = [at(from, c * from.powf(*exponent)), at(to, c * to.powf(*exponent))];
                        line(sheet, &ends, DIAGONAL, SCALE as u32, Dash::Solid)?;
                    }
                }
                Ok(())
            }
        }
    }

    fn legend(&self, area: &Area<'_>, (x, y): (i32, i32)) -> Drawn {
        let mut y = y;
        for series in &self.series {
            line(area, &[(x, y), (x + KEY - 10 * SCALE, y)], series.style.color, 2 * SCALE as u32, series.style.dash)?;
            mark(area, (x + (KEY - 10 * SCALE) / 2, y), &series.style, 4 * SCALE)?;
            write(area, &series.name, (x + KEY, y), TEXT, HPos::Left)?;
            y += ROW;
        }
        for guide in &self.guides {
            let (color, dash) = match guide {
                Guide::Power { .. } => (DIAGONAL, Dash::Solid),
                _ => (INK, Dash::Dashed),
            };
            line(area, &[(x, y), (x + KEY - 10 * SCALE, y)], color, SCALE as u32, dash)?;
            write(area, guide.name(), (x + KEY, y), TEXT, HPos::Left)?;
            y += ROW;
        }
        Ok(())
    }
}

impl Guide {
    fn name(&self) -> &str {
        match self {
            Self::Power { name, .. } | Self::Level { name, .. } | Self::Diagonal { name } => name,
        }
    }
}

/// A style for the `group`th of the colours.
pub(super) fn style(group: usize, fill: Fill, dash: Dash) -> Style {
    Style { color: COLORS[group % COLORS.len()], shape: group, fill, dash }
}
