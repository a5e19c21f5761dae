//! The map as a chart: a cell shows a verdict by its colour, its mark and a few words, each of
//! which suffices alone.

use std::fmt::Write as _;

use crate::chart::escape;

use super::{METHODS, Map, Verdict};

/// Left edge and width of the columns, top and height of the rows.
const LEFT: i32 = 250;
const COLUMN: i32 = 150;
const TOP: i32 = 44;
const ROW: i32 = 40;
/// Room for the legend.
const LEGEND: i32 = 62;

/// The appearance of a verdict: colour of the cell (Okabe & Ito, "Color universal design", 2008),
/// colour of its text, mark.
fn appearance(verdict: &Verdict) -> (&'static str, &'static str, &'static str) {
    match verdict {
        Verdict::Certified => ("#0072b2", "#ffffff", "M-5,0 L-1,5 L6,-5"),
        Verdict::Noisy(_) => ("#b5dcf2", "#222222", "M-6,0 Q-3,-8 0,0 T6,0"),
        Verdict::Flagged(_) => ("#f0e0b0", "#222222", "M-4,6 L-4,-6 L5,-3 L-4,0"),
        Verdict::Wrong(..) => ("#d55e00", "#ffffff", "M-5,-5 L5,5 M-5,5 L5,-5"),
    }
}

/// The text of a cell.
pub(super) fn words(verdict: &Verdict) -> String {
    match verdict {
        Verdict::Certified => "certified".into(),
        Verdict::Noisy(times) if *times >= 9.5 => format!("noisy, {} × the cost", two_digits(*times)),
        Verdict::Noisy(times) => format!("noisy, {times:.1} × the cost"),
        Verdict::Flagged(what) => what.clone(),
        Verdict::Wrong(share, stated) => {
            let sign = if *share < 0.0 { "−" } else { "+" };
            let size = 100.0 * share.abs();
            let size = if size < 9.95 { format!("{size:.1}") } else { format!("{size:.0}") };
            format!("{sign}{size} %{}", if *stated { ", as it says" } else { ", silently" })
        }
    }
}

fn two_digits(x: f64) -> String {
    let unit = 10f64.powf(x.log10().floor() - 1.0);
    format!("{:.0}", (x / unit).round() * unit)
}

/// The chart, SVG.
pub(super) fn draw(map: &Map) -> String {
    let columns = METHODS.len() as i32;
    let (width, height) = (LEFT + columns * COLUMN + 10, TOP + map.rows.len() as i32 * ROW + LEGEND);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         aria-label=\"Which estimator is good for what, and where it breaks\" font-family=\"DejaVu Sans, Verdana, sans-serif\" \
         font-size=\"13\">\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    let mut put = |x: i32, y: i32, text: &str, more: &str| {
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\" {more}>{}</text>", escape(text));
    };
    for (k, (name, _)) in (0..).zip(METHODS) {
        put(
            LEFT + k * COLUMN + COLUMN / 2,
            TOP - 14,
            name,
            "text-anchor=\"middle\" font-weight=\"bold\" fill=\"#222222\"",
        );
    }
    for (r, row) in (0..).zip(&map.rows) {
        put(LEFT - 12, TOP + r * ROW + ROW / 2 + 5, row.case.title, "text-anchor=\"end\" fill=\"#222222\"");
    }
    for (r, row) in (0..).zip(&map.rows) {
        for (k, cell) in (0..).zip(&row.cells) {
            tile(&mut svg, LEFT + k * COLUMN, TOP + r * ROW, COLUMN, &cell.verdict, &words(&cell.verdict));
        }
    }
    let legend = [
        (Verdict::Certified, "unbiased, certified"),
        (Verdict::Noisy(1.0), "the same, noisier"),
        (Verdict::Flagged(String::new()), "says: do not believe"),
        (Verdict::Wrong(0.0, true), "wrong"),
    ];
    let top = TOP + map.rows.len() as i32 * ROW + 16;
    let wide = (width - 20) / 4;
    for (k, (verdict, text)) in (0..).zip(&legend) {
        tile(&mut svg, 10 + k * wide, top, wide, verdict, text);
    }
    svg + "</svg>\n"
}

fn tile(svg: &mut String, x: i32, y: i32, width: i32, verdict: &Verdict, text: &str) {
    let (fill, ink, mark) = appearance(verdict);
    let (w, h, middle) = (width - 4, ROW - 4, y + ROW / 2);
    let _ = write!(
        svg,
        "<rect x=\"{}\" y=\"{}\" width=\"{w}\" height=\"{h}\" rx=\"3\" fill=\"{fill}\"/>\n\
         <path transform=\"translate({},{middle})\" d=\"{mark}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"2\"/>\n\
         <text x=\"{}\" y=\"{}\" fill=\"{ink}\" font-size=\"11\">{}</text>\n",
        x + 2,
        y + 2,
        x + 16,
        x + 28,
        middle + 4,
        escape(text)
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_say_what_they_are() {
        for (verdict, text) in [
            (Verdict::Noisy(3.12), "noisy, 3.1 × the cost"),
            (Verdict::Noisy(1234.0), "noisy, 1200 × the cost"),
            (Verdict::Wrong(-0.123, true), "−12 %, as it says"),
            (Verdict::Wrong(0.0123, false), "+1.2 %, silently"),
            (Verdict::Flagged("light is missing".into()), "light is missing"),
        ] {
            assert_eq!(words(&verdict), text);
        }
    }
}
