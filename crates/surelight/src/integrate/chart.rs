//! The chart of convergence: error against evaluations, both logarithmic, as a plain SVG.

use std::fmt::Write as _;

/// One method's line.
pub(super) struct Series {
    pub(super) name: &'static str,
    /// Evaluations and error; points without an error above zero are left out.
    pub(super) points: Vec<(f64, f64)>,
}

/// Okabe & Ito's colours, which the colour-blind can distinguish; dashes and marks distinguish them
/// in grey.
const STYLES: [(&str, &str, Mark); 6] = [
    ("#000000", "", Mark::Circle),
    ("#0072B2", "7 3", Mark::Square),
    ("#D55E00", "", Mark::Diamond),
    ("#009E73", "2 3", Mark::Triangle),
    ("#CC79A7", "9 3 2 3", Mark::Cross),
    ("#E69F00", "4 2", Mark::Plus),
];

#[derive(Clone, Copy)]
enum Mark {
    Circle,
    Square,
    Diamond,
    Triangle,
    Cross,
    Plus,
}

const WIDTH: f64 = 860.0;
const HEIGHT: f64 = 520.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 620.0;
const TOP: f64 = 66.0;
const BOTTOM: f64 = 450.0;

/// An axis over whole decades.
struct Axis {
    low: i32,
    high: i32,
    from: f64,
    to: f64,
}

impl Axis {
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v.log10()), h.max(v.log10())));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let low = low.floor() as i32;
        Self { low, high: (high.ceil() as i32).max(low + 1), from, to }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.log10() - f64::from(self.low)) / f64::from(self.high - self.low);
        self.from + share * (self.to - self.from)
    }

    /// Decades, thinned out where there are many.
    fn ticks(&self) -> impl Iterator<Item = (f64, i32)> {
        let step = ((self.high - self.low) / 9 + 1) as usize;
        (self.low..=self.high).step_by(step).map(|decade| (self.at(10f64.powi(decade)), decade))
    }
}

/// Draws the chart. `error` names the measure of error.
pub(super) fn draw(title: &str, error: &str, series: &[Series]) -> String {
    let shown = |s: &Series| -> Vec<(f64, f64)> {
        s.points.iter().copied().filter(|&(n, e)| n > 0.0 && e > 0.0 && e.is_finite()).collect()
    };
    let all: Vec<(f64, f64)> = series.iter().flat_map(shown).collect();
    let x = Axis::over(all.iter().map(|p| p.0), LEFT, RIGHT);
    let y = Axis::over(all.iter().map(|p| p.1), BOTTOM, TOP);
    let mut svg = String::new();
    // Writing to a string cannot fail.
    let _ = write!(
        svg,
        r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" font-family="system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif" font-size="13" fill="#222" role="img">
<title>{0}</title>
<rect width="100%" height="100%" fill="#fff"/>
<text x="{LEFT}" y="28" font-size="16" font-weight="600">{0}</text>
<text x="{LEFT}" y="48" fill="#555">error: {1}</text>
"##,
        escape(&shorten(title)),
        escape(error)
    );
    for (at, decade) in x.ticks() {
        let _ = writeln!(
            svg,
            r##"<path d="M{at:.1} {TOP}V{BOTTOM}" stroke="#ddd"/>{}"##,
            power(at, BOTTOM + 20.0, "middle", decade)
        );
    }
    for (at, decade) in y.ticks() {
        let _ = writeln!(
            svg,
            r##"<path d="M{LEFT} {at:.1}H{RIGHT}" stroke="#ddd"/>{}"##,
            power(LEFT - 8.0, at + 4.0, "end", decade)
        );
    }
    let (middle_x, middle_y) = (0.5 * (LEFT + RIGHT), 0.5 * (TOP + BOTTOM));
    let _ = write!(
        svg,
        r##"<path d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}" fill="none" stroke="#222"/>
<text x="{middle_x}" y="{0}" text-anchor="middle">evaluations of the formula</text>
<text transform="translate(22 {middle_y}) rotate(-90)" text-anchor="middle">error</text>
"##,
        BOTTOM + 46.0
    );
    for (i, (s, &(color, dash, mark))) in series.iter().zip(STYLES.iter().cycle()).enumerate() {
        let points: Vec<(f64, f64)> = shown(s).into_iter().map(|(n, e)| (x.at(n), y.at(e))).collect();
        let line: Vec<String> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(svg, r#"<g stroke="{color}" stroke-width="1.8" fill="none">"#);
        let _ = writeln!(svg, r#"<polyline points="{}" stroke-dasharray="{dash}"/>"#, line.join(" "));
        for &(x, y) in &points {
            let _ = writeln!(svg, "{}", mark.draw(x, y));
        }
        let (at, from) = (TOP + 16.0 + 26.0 * i as f64, RIGHT + 20.0);
        let _ =
            writeln!(svg, r#"<path d="M{from} {at}h30" stroke-dasharray="{dash}"/>{}</g>"#, mark.draw(from + 15.0, at));
        let empty = if points.is_empty() { " (no error seen)" } else { "" };
        let _ = writeln!(svg, r#"<text x="{}" y="{}">{}{empty}</text>"#, from + 38.0, at + 4.0, escape(s.name));
    }
    svg + "</svg>\n"
}

impl Mark {
    fn draw(self, x: f64, y: f64) -> String {
        let path = match self {
            Self::Circle => return format!(r##"<circle cx="{x:.1}" cy="{y:.1}" r="3.2" fill="#fff"/>"##),
            Self::Square => "m-3 -3h6v6h-6z",
            Self::Diamond => "m0 -4.2l4.2 4.2l-4.2 4.2l-4.2 -4.2z",
            Self::Triangle => "m0 -4l4 7h-8z",
            Self::Cross => "m-3.4 -3.4l6.8 6.8m0 -6.8l-6.8 6.8",
            Self::Plus => "m-4 0h8m-4 -4v8",
        };
        format!(r##"<path d="M{x:.1} {y:.1}{path}" fill="#fff"/>"##)
    }
}

/// A power of ten.
fn power(x: f64, y: f64, anchor: &str, decade: i32) -> String {
    format!(
        r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">10<tspan font-size="10" dy="-5">{decade}</tspan></text>"#
    )
}

fn shorten(title: &str) -> String {
    match title.char_indices().nth(90) {
        Some((end, _)) => format!("{}…", &title[..end]),
        None => title.to_owned(),
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_logarithmic_and_hold_every_point() {
        let axis = Axis::over([32.0, 1e6].into_iter(), 0.0, 500.0);
        assert_eq!((axis.low, axis.high), (1, 6));
        assert!((axis.at(1e6) - 500.0).abs() < 1e-9 && (axis.at(1e3) - 200.0).abs() < 1e-9);
        assert_eq!(axis.ticks().count(), 6);
        assert_eq!(Axis::over([].into_iter(), 0.0, 1.0).ticks().count(), 2);
        assert!(Axis::over([1e-300, 1e300].into_iter(), 0.0, 1.0).ticks().count() <= 11);
    }

    #[test]
    fn text_is_escaped_and_zero_errors_do_not_break_the_chart() {
        let svg =
            draw("a < b && \"c\"", "error", &[Series { name: "exact", points: vec![(16.0, 0.0), (32.0, f64::NAN)] }]);
        assert!(svg.contains("a &lt; b &amp;&amp; &quot;c&quot;") && svg.contains("no error seen"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
