//! The canvas of charts: sizes, colours, marks, text, and conversion to PNG.

use plotters::{
    coord::Shift,
    element::DashedPathElement,
    prelude::*,
    style::text_anchor::{HPos, Pos, VPos},
};

use crate::error::BenchError;

/// The medium of a chart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A large screen or print: the legend is beside the chart.
    Wide,
    /// A phone: the legend is below the chart.
    Narrow,
}

/// Drawing scale: coordinates are integers, so charts are drawn at this many times their size.
pub(super) const SCALE: i32 = 2;

/// Font size.
pub(super) const TEXT: i32 = 15 * SCALE;

/// Font family of the SVG. The PNG is drawn with the first font, which comes with this crate; the
/// fallbacks are about as wide or narrower.
const FONT: &str = "DejaVu Sans, Verdana, Segoe UI, sans-serif";

/// DejaVu Sans (see font/LICENSE), reduced to the characters of the charts.
const FONT_BYTES: &[u8] = include_bytes!("../../font/DejaVuSans-subset.ttf");

/// Colours that are safe for the colour-blind (Okabe & Ito, "Color universal design", 2008),
/// dark enough for lines: their yellow is left out.
pub(super) const COLORS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(0, 0, 0),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

pub(super) const INK: RGBColor = RGBColor(34, 34, 34);
pub(super) const GRID: RGBColor = RGBColor(205, 205, 205);
pub(super) const FAINT: RGBColor = RGBColor(235, 235, 235);

/// The dash pattern of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dash {
    #[default]
    Solid,
    Dashed,
    Dotted,
    /// Marks only.
    None,
}

/// How a mark is filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fill {
    Full,
    /// White with a dot.
    Dot,
    White,
}

/// The style of a method in every chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Style {
    pub(super) color: RGBColor,
    /// Shape of its marks.
    pub(super) shape: usize,
    /// How marks are filled.
    pub(super) fill: Fill,
    pub(super) dash: Dash,
}

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Draws on a sheet of this size and returns the SVG.
pub(super) fn sheet(
    name: &str,
    title: &str,
    [width, height]: [i32; 2],
    draw: impl FnOnce(&Area<'_>) -> Drawn,
) -> Result<String, BenchError> {
    let mut svg = String::new();
    let failed = |cause: String| BenchError::Chart { name: name.into(), cause };
    {
        let area = SVGBackend::with_string(&mut svg, (width as u32, height as u32)).into_drawing_area();
        area.fill(&WHITE)
            .and_then(|()| draw(&area))
            .and_then(|()| area.present())
            .map_err(|e| failed(e.to_string()))?;
    }
    // The size on the page is that of the nominal pixels; its content is named for those who
    // cannot see it.
    let head = format!(
        "<svg width=\"{}\" height=\"{}\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\" font-family=\"{FONT}\" xmlns",
        width / SCALE,
        height / SCALE,
        escape(title)
    );
    let rest =
        svg.find("xmlns").map(|at| &svg[at + "xmlns".len()..]).ok_or_else(|| failed("it is not an SVG".into()))?;
    Ok(head + &compact(rest))
}

/// The same drawing in fewer bytes: successive lines of one style, such as the dashes of a curve,
/// become one path.
fn compact(svg: &str) -> String {
    let plain = svg.replace(" opacity=\"1\"", "").replace(&format!(" font-family=\"{FONT}\""), "");
    let mut out = String::new();
    let mut open: Option<String> = None;
    for line in plain.lines() {
        let stroke = strokes(line);
        if let Some((look, steps)) = &stroke
            && open.as_ref() == Some(look)
        {
            out += steps;
            continue;
        }
        if open.take().is_some() {
            out += "\"/>\n";
        }
        match stroke {
            Some((look, steps)) => {
                out += &format!("<path fill=\"none\"{look} d=\"{steps}");
                open = Some(look);
            }
            None => {
                out += line;
                out.push('\n');
            }
        }
    }
    out
}

/// Style and path commands of a line, where the element is one.
fn strokes(element: &str) -> Option<(String, String)> {
    if let Some(rest) = element.strip_prefix("<polyline fill=\"none\"") {
        let (look, points) = rest.split_once(" points=\"")?;
        let points = points.strip_suffix("\"/>")?.trim();
        return Some((look.to_owned(), format!("M{}", points.replace(' ', "L"))));
    }
    let (look, ends) = element.strip_prefix("<line")?.split_once(" x1=\"")?;
    let numbers: Vec<&str> = ends.strip_suffix("\"/>")?.split('"').step_by(2).collect();
    let [x1, y1, x2, y2] = numbers[..] else { return None };
    Some((look.to_owned(), format!("M{x1},{y1}L{x2},{y2}")))
}

/// Text escaped for XML.
pub(crate) fn escape(text: &str) -> String {
    maud::html! { (text) }.into_string()
}

/// Approximate width of text in DejaVu Sans.
pub(super) fn text_width(text: &str, size: i32) -> i32 {
    let ems: f64 = text.chars().map(|c| if "iljtfr.,:;|' ()/−-".contains(c) { 0.40 } else { 0.63 }).sum();
    (ems * f64::from(size)).ceil() as i32
}

/// A style for text.
pub(super) fn text_style<'a>(size: i32, color: RGBColor, h: HPos, v: VPos) -> TextStyle<'a> {
    (FontFamily::Name(FONT), size).into_font().color(&color).pos(Pos::new(h, v))
}

/// Writes a line of text.
pub(super) fn write(area: &Area<'_>, text: &str, at: (i32, i32), size: i32, h: HPos) -> Drawn {
    area.draw(&Text::new(text.to_owned(), at, text_style(size, INK, h, VPos::Center)))
}

/// Draws a line through some points.
pub(super) fn line(area: &Area<'_>, points: &[(i32, i32)], color: RGBColor, width: u32, dash: Dash) -> Drawn {
    let style = color.stroke_width(width);
    let points = points.to_vec();
    match dash {
        Dash::None => Ok(()),
        Dash::Solid => area.draw(&PathElement::new(points, style)),
        Dash::Dashed => area.draw(&DashedPathElement::new(points, 8 * SCALE, 4 * SCALE, style)),
        Dash::Dotted => area.draw(&DashedPathElement::new(points, 2 * SCALE, 4 * SCALE, style)),
    }
}

/// Draws a mark of a style; `usize::MAX` is none.
pub(super) fn mark(area: &Area<'_>, (x, y): (i32, i32), style: &Style, size: i32) -> Drawn {
    if style.shape == usize::MAX {
        return Ok(());
    }
    let corners: &[(i32, i32)] = match style.shape % 6 {
        0 => &[],
        1 => &[(-9, -9), (9, -9), (9, 9), (-9, 9)],
        2 => &[(0, -13), (13, 0), (0, 13), (-13, 0)],
        3 => &[(0, -12), (12, 9), (-12, 9)],
        4 => &[(-12, -9), (12, -9), (0, 12)],
        _ => &[
            (-4, -12),
            (4, -12),
            (4, -4),
            (12, -4),
            (12, 4),
            (4, 4),
            (4, 12),
            (-4, 12),
            (-4, 4),
            (-12, 4),
            (-12, -4),
            (-4, -4),
        ],
    };
    let pen = style.color.stroke_width(SCALE as u32);
    let inside = if style.fill == Fill::Full { style.color.filled() } else { WHITE.filled() };
    if corners.is_empty() {
        area.draw(&Circle::new((x, y), size, inside))?;
        area.draw(&Circle::new((x, y), size, pen))?;
    } else {
        let mut points: Vec<_> = corners.iter().map(|&(u, v)| (x + u * size / 10, y + v * size / 10)).collect();
        area.draw(&Polygon::new(points.clone(), inside))?;
        points.push(points[0]);
        area.draw(&PathElement::new(points, pen))?;
    }
    if style.fill == Fill::Dot {
        let half = size / 4;
        area.draw(&Rectangle::new([(x - half, y - half), (x + half, y + half)], style.color.filled()))?;
    }
    Ok(())
}

/// The chart as a PNG, rendered from the SVG with the font that comes with this crate.
pub(crate) fn png(name: &str, svg: &str) -> Result<Vec<u8>, BenchError> {
    use resvg::{tiny_skia, usvg};
    let failed = |cause: String| BenchError::Chart { name: name.into(), cause };
    let mut options = usvg::Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_font_data(FONT_BYTES.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let tree = usvg::Tree::from_str(svg, &options).map_err(|e| failed(e.to_string()))?;
    let size = tree.size().to_int_size();
    let scale = SCALE as u32;
    let mut pixels = tiny_skia::Pixmap::new(size.width() * scale, size.height() * scale)
        .ok_or_else(|| failed("it has no size".into()))?;
    let enlarge = tiny_skia::Transform::from_scale(scale as f32, scale as f32);
    resvg::render(&tree, enlarge, &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| failed(e.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_one_look_become_one_path() {
        let svg = "<g>\n<line opacity=\"1\" stroke=\"#EBEBEB\" x1=\"1\" y1=\"2\" x2=\"3\" y2=\"4\"/>\n\
                   <line opacity=\"1\" stroke=\"#EBEBEB\" x1=\"5\" y1=\"6\" x2=\"7\" y2=\"8\"/>\n\
                   <polyline fill=\"none\" opacity=\"1\" stroke=\"#000\" points=\"1,2 3,4 5,6 \"/>\n<text>\n</g>\n";
        assert_eq!(
            compact(svg),
            "<g>\n<path fill=\"none\" stroke=\"#EBEBEB\" d=\"M1,2L3,4M5,6L7,8\"/>\n\
             <path fill=\"none\" stroke=\"#000\" d=\"M1,2L3,4L5,6\"/>\n<text>\n</g>\n"
        );
    }
}
