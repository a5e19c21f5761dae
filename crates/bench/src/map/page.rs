//! The map as a page: chart, table, a picture and a paragraph per row.

use std::fmt::Write as _;
use std::path::Path;

use surelight_film::{Display, ToneMap, write_file, write_rgb8_png};

use crate::error::BenchError;

use super::{BATCHES, METHODS, Map, Row, SIDE, Verdict, chart};

/// Enlargement of pixels.
const ZOOM: usize = 3;
/// Pixels between pictures.
const GAP: usize = 6;

const HEAD: &str = "\
# Where each method fails

After this page you know in which scenes each integrator fails, and that it says so. Each scene is
built around one difficulty, and all methods have the same number of samples: the estimators of the
lecture, one that traces caustics from the lights, and Whitted's. The truth is a closed form where
there is one; elsewhere it is a render with far more samples of the best method there.

![The map: a row per difficulty, a column per method](images/failure-map/map.svg)

- **certified**: no bias is detected (all tests of the map together err once in a hundred), nine
  tenths of the pixels and more are certified, and no other unbiased method reaches an error with
  fewer than half the rays.
- **noisy**: the same, at so many times the rays of the best.
- **flagged**: the render says that it is not to be believed: light is missing or comes by chance
  alone, or pixels are not certified.
- **wrong**: the mean is off. *As it says*: the file's metadata and the summary list the bias.
  *Silently*: they do not. The map exists to have none of these.

The **hemisphere form** is best where light is everywhere, or where the surface restricts it more
than the light does (gloss, contact, deep rooms); the **area form** where lights are small and
surfaces rough; **mis** wherever either is, at the price of a wasted shadow ray now and then.
**caustics** adds light through smooth glass or by mirrors, and equals mis everywhere else.
**Whitted's** tree suits points, mirrors and hard shadows, and nothing that is soft.
";

/// Writes `failure-map.md` into a folder, and its pictures below it.
///
/// # Errors
/// Where a file cannot be written.
pub fn write(map: &Map, folder: &Path) -> Result<(), BenchError> {
    let pictures = folder.join("images/failure-map");
    std::fs::create_dir_all(&pictures)
        .map_err(|e| BenchError::file(&pictures, format!("cannot be made: {}", surelight_film::io_cause(&e))))?;
    let svg = chart::draw(map);
    write_file(&pictures.join("map.svg"), svg.as_bytes())?;
    write_file(&pictures.join("map.png"), &crate::chart::png("map", &svg)?)?;
    for row in &map.rows {
        strip(row, &pictures.join(format!("{}.png", row.case.name)))?;
    }
    write_file(&folder.join("failure-map.md"), markdown(map).as_bytes())?;
    Ok(())
}

/// The methods' pictures side by side.
fn strip(row: &Row, path: &Path) -> Result<(), BenchError> {
    let side = SIDE as usize;
    let (tile, count) = (side * ZOOM, row.cells.len());
    let width = count * tile + (count - 1) * GAP;
    let display = Display { exposure_ev: row.case.exposure, tonemap: ToneMap::Neutral };
    let mut pixels = vec![[255; 3]; width * tile];
    for (k, cell) in row.cells.iter().enumerate() {
        for y in 0..tile {
            for x in 0..tile {
                pixels[y * width + k * (tile + GAP) + x] = display.bytes(cell.film.mean(y / ZOOM * side + x / ZOOM));
            }
        }
    }
    Ok(write_rgb8_png(path, width as u32, tile as u32, &pixels)?)
}

fn markdown(map: &Map) -> String {
    let mut text = HEAD.to_owned();
    // Writing to a string cannot fail.
    let _ = write!(text, "\n| |{}\n|---|{}\n", columns(|name| format!(" {name} |")), columns(|_| "---|".into()));
    for row in &map.rows {
        let cells: String = row.cells.iter().map(|cell| format!(" {} |", chart::words(&cell.verdict))).collect();
        let _ = writeln!(text, "| [{}](#{}) |{cells}", row.case.title, anchor(row.case.title));
    }
    for row in &map.rows {
        let case = row.case;
        let _ = write!(
            text,
            "\n## {}\n\n![{}: {}](images/failure-map/{}.png)\n\n{}\n\n| | mean over truth | certified | cost |\n|---|---:|---:|---:|\n",
            case.title,
            case.title,
            METHODS.map(|m| m.0).join(", "),
            case.name,
            wrapped(case.why)
        );
        for (cell, (name, _)) in row.cells.iter().zip(METHODS) {
            let [off, error] = cell.deviation;
            let cost = match cell.verdict {
                Verdict::Certified | Verdict::Noisy(_) => format!("{:.3}", cell.cost),
                _ => "–".into(),
            };
            let _ =
                writeln!(text, "| {name} | {:.4} ± {error:.4} | {:.0} % | {cost} |", 1.0 + off, 100.0 * cell.certified);
        }
    }
    text + &accumulation() + &foot(map)
}

fn columns(of: impl Fn(&str) -> String) -> String {
    METHODS.iter().map(|(name, _)| of(name)).collect()
}

/// The anchor that GitHub makes for a heading.
fn anchor(title: &str) -> String {
    let kept = title.to_lowercase();
    kept.chars()
        .filter(|c| c.is_alphanumeric() || *c == ' ' || *c == '-')
        .map(|c| if c == ' ' { '-' } else { c })
        .collect()
}

/// The failure of f32 sums, which is independent of the estimator.
fn accumulation() -> String {
    const COUNT: u32 = 1 << 26;
    const BATCH: u32 = 4096;
    let (mut running, mut batch, mut total) = (0.0f32, 0.0f32, 0.0f64);
    for i in 0..COUNT {
        // A radiance of about 1, as samples are: even over [0.5, 1.5).
        let sample = 0.5 + (i.wrapping_mul(2_654_435_769) >> 8) as f32 / 16_777_216.0;
        running += sample;
        batch += sample;
        if (i + 1).is_multiple_of(BATCH) {
            total += f64::from(batch);
            batch = 0.0;
        }
    }
    let n = f64::from(COUNT);
    format!(
        "\n## Adding up\n\n{}\n",
        wrapped(&format!(
            "No estimator helps a sum that stops growing. An f32 has 24 bits: from 2²⁴ on, a sample of 1 is half a step. \
             Of 2²⁶ samples whose mean is 1, a running f32 sum makes {:.4}; batches of {BATCH} in f32, added in wider \
             numbers as the film does, make {:.7}.",
            f64::from(running) / n,
            total / n
        ))
    )
}

fn foot(map: &Map) -> String {
    format!(
        "\n## How it was made\n\n{}\n",
        wrapped(&format!(
            "`surelight bench --map -o docs` on {}: pictures of {SIDE} × {SIDE} pixels, {BATCHES} scrambles of 16 to \
             256 Sobol points per pixel, every method the same number. *Cost* is the relative variance of a sample times \
             the rays of a path, and so does not depend on the machine; heavy tails have none. Scenes and closed forms: \
             `crates/bench/src/map/cases.rs`.",
            map.device
        ))
    )
}

/// A paragraph in lines of at most 100 columns.
fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is a line");
        if line.is_empty() {
            line.push_str(word);
        } else if line.chars().count() + 1 + word.chars().count() <= 100 {
            line.push(' ');
            line.push_str(word);
        } else {
            lines.push(word.to_owned());
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_found() {
        assert_eq!(anchor("A light that touches a surface"), "a-light-that-touches-a-surface");
        assert_eq!(anchor("Albedo 0.99"), "albedo-099");
    }

    #[test]
    fn an_f32_sum_stagnates_and_batches_do_not() {
        let text = accumulation();
        assert!(text.contains("make 1.00000") || text.contains("make 0.99999"), "{text}");
    }
}
