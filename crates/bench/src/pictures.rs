//! Maps of a picture's errors.

use std::path::Path;

use surelight_film::{Film, compare::heat_color, write_rgb8_png};

use crate::{
    error::BenchError,
    measure::{EPSILON, Reference},
};

/// Relative error at full colour: the scale of all maps, so that they can be compared.
pub const FULL_ERROR: f64 = 0.5;

/// Colour of the hatching on pixels that are not certified.
const HATCH: [u8; 3] = [120, 120, 120];

/// Signed relative error (x − r)/√(r² + 0.01·r̄²) of luminance: warm where the film is brighter,
/// cool where it is darker. Pixels that the film does not certify are hatched: every fourth
/// diagonal is grey.
pub fn error_map(path: &Path, film: &Film, reference: &Reference) -> Result<(), BenchError> {
    let luminance = |rgb: [f64; 3]| 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    let floor = EPSILON * reference.mean().powi(2);
    let certificate = film.certify();
    let width = film.width() as usize;
    let pixels: Vec<[u8; 3]> = (0..film.pixels().len())
        .map(|i| {
            if !certificate.certified[i] && (i % width + i / width).is_multiple_of(4) {
                return HATCH;
            }
            let r = luminance(std::array::from_fn(|c| f64::from(reference.rgb[c][i])));
            heat_color((luminance(film.mean(i)) - r) / (r * r + floor).sqrt() / FULL_ERROR)
        })
        .collect();
    Ok(write_rgb8_png(path, film.width(), film.height(), &pixels)?)
}
