//! Automatic exposure of a picture, and how much of a picture its exposure loses.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::{Display, Film, linear_to_srgb, luminance};

/// Displayed luminance that the log-average becomes: the middle grey of Reinhard et al. 2002,
/// "Photographic Tone Reproduction for Digital Images".
const KEY: f64 = 0.18;

/// Of this many pixels, the brightest and the darkest are left out.
const TRIM: usize = 50;

/// Automatic exposures are multiples of this many stops. Steps that fine are invisible, and a
/// picture scaled by a power of two then gets an exposure that differs by exactly that power.
const STEP: f64 = 1.0 / 64.0;

/// Largest exposure in either direction, in stops.
const MAX_EV: f64 = 64.0;

/// The exposure that shows the log-average luminance of a picture as middle grey.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AutoExposure {
    /// Exposure in stops; 0 for a black picture.
    pub ev: f64,
    /// Log-average luminance; `None` where every pixel is black.
    pub log_average: Option<f64>,
}

impl AutoExposure {
    /// The exposure of a film's mean.
    pub fn of(film: &Film) -> Self {
        Self::of_luminances(film.pixels().par_iter().map(|pixel| luminance(pixel.mean())).collect())
    }

    /// The exposure of a picture with these luminances. Luminances that are not positive and finite
    /// are ignored, as are the brightest and the darkest fiftieth of the rest: few very bright
    /// pixels, as of fireflies and lamps, do not darken a picture.
    pub fn of_luminances(mut luminances: Vec<f64>) -> Self {
        luminances.retain(|y| y.is_normal() && *y > 0.0);
        if luminances.is_empty() {
            return Self::default();
        }
        let trim = luminances.len() / TRIM;
        if trim > 0 {
            let end = luminances.len() - trim;
            luminances.select_nth_unstable_by(end, f64::total_cmp);
            luminances.truncate(end);
            luminances.select_nth_unstable_by(trim, f64::total_cmp);
        }
        let counted = &luminances[trim..];
        // Exponents are summed as integers, so that a power of two changes only the whole stops of
        // the mean.
        let (mut exponents, mut mantissas) = (0i64, 0.0);
        for &y in counted {
            let (exponent, mantissa) = split(y);
            exponents += exponent;
            mantissas += mantissa.log2();
        }
        let count = counted.len() as i64;
        let whole = exponents.div_euclid(count) as f64;
        let fraction = (exponents.rem_euclid(count) as f64 + mantissas) / count as f64;
        let ev = ((KEY.log2() - fraction) / STEP).round() * STEP - whole;
        Self { ev: ev.clamp(-MAX_EV, MAX_EV), log_average: Some((whole + fraction).exp2()) }
    }
}

/// Exponent and mantissa, in [1, 2), of a normal positive number.
fn split(x: f64) -> (i64, f64) {
    const MANTISSA_BITS: u32 = 52;
    const BIAS: u64 = 1023;
    let bits = x.to_bits();
    let mantissa = bits & ((1 << MANTISSA_BITS) - 1) | BIAS << MANTISSA_BITS;
    ((bits >> MANTISSA_BITS) as i64 - BIAS as i64, f64::from_bits(mantissa))
}

/// An exposure as files record it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExposureRecord {
    /// Exposure of the PNG in stops.
    pub ev: f64,
    /// Whether it follows from the picture.
    pub automatic: bool,
}

/// Pixels that a PNG shows without detail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LostPixels {
    /// Share of the pixels, 0 to 1.
    pub share: f64,
    /// Why they have none.
    pub loss: Loss,
}

/// Why a pixel shows no detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Loss {
    /// Light reaches it, but it is black.
    Black,
    /// It is white, and brighter than white.
    Clipped,
}

impl LostPixels {
    /// The detail that a display loses in most of a film; `None` where most pixels keep their
    /// detail, or lack light altogether.
    pub fn of(film: &Film, display: &Display) -> Option<Self> {
        let scale = display.exposure_ev.exp2();
        let tally = |pixel: &crate::PixelMoments| -> [usize; 3] {
            let mean = pixel.mean();
            let codes = display.tonemap.map(mean.map(|c| c * scale)).map(linear_to_srgb);
            let (lit, black) = (luminance(mean) > 0.0, codes.iter().all(|&code| code < 1.0 / 255.0));
            let white = luminance(codes) >= 254.0 / 255.0 && luminance(mean) * scale > 1.0;
            [black && lit, black && !lit, white].map(usize::from)
        };
        let add = |a: [usize; 3], b: [usize; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let [dark, unlit, white] = film.pixels().par_iter().map(tally).reduce(|| [0; 3], add);
        let all = film.pixels().len();
        let share = |count: usize| count as f64 / all as f64;
        // No exposure reveals unlit pixels: a black background alone is no loss.
        if 2 * (dark + unlit) > all && 2 * dark > all - unlit {
            Some(Self { share: share(dark), loss: Loss::Black })
        } else if 2 * white > all {
            Some(Self { share: share(white), loss: Loss::Clipped })
        } else {
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BatchSum, ToneMap};

    /// A picture with five decades of luminance, by a linear congruential generator.
    fn varied(count: usize) -> Vec<f64> {
        let mut state = 1u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..count).map(|_| 10f64.powf(5.0 * next() - 3.0)).collect()
    }

    #[test]
    fn a_grey_picture_becomes_middle_grey() {
        for (luminance, ev) in [(0.18, 0.0), (0.36, -1.0), (0.045, 2.0), (0.18 * 1024.0, -10.0)] {
            let found = AutoExposure::of_luminances(vec![luminance; 7]);
            assert!((found.ev - ev).abs() < 1e-12, "{luminance}: {found:?}");
            assert!((found.log_average.unwrap() / luminance - 1.0).abs() < 1e-12);
        }
        // The geometric mean of 0.09 and 0.36 is 0.18.
        assert_eq!(AutoExposure::of_luminances(vec![0.09, 0.36]).ev, 0.0);
    }

    #[test]
    fn scaling_by_a_power_of_two_changes_the_exposure_by_exactly_as_many_stops() {
        for count in [1, 7, 64, 1000] {
            let picture = varied(count);
            let plain = AutoExposure::of_luminances(picture.clone()).ev;
            for stops in [-20, -7, -1, 1, 2, 9, 30] {
                let scaled = picture.iter().map(|y| y * f64::from(stops).exp2()).collect();
                assert_eq!(AutoExposure::of_luminances(scaled).ev, plain - f64::from(stops), "{count}, {stops}");
            }
        }
    }

    #[test]
    fn few_extreme_pixels_do_not_change_the_exposure() {
        let picture = varied(1000);
        let plain = AutoExposure::of_luminances(picture.clone()).ev;
        let extremes: [(f64, f64); 6] =
            [(1e9, 0.1), (1e-30, 0.1), (0.0, 0.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0), (-1.0, 0.0)];
        for (extreme, tolerance) in extremes {
            let mut picture = picture.clone();
            picture.extend([extreme; 8]);
            let found = AutoExposure::of_luminances(picture).ev;
            assert!((found - plain).abs() <= tolerance, "{extreme}: {found} instead of {plain}");
        }
    }

    #[test]
    fn a_black_picture_keeps_its_exposure() {
        for black in [vec![], vec![0.0; 9], vec![f64::NAN, f64::INFINITY, -1.0]] {
            assert_eq!(AutoExposure::of_luminances(black), AutoExposure { ev: 0.0, log_average: None });
        }
        assert_eq!(AutoExposure::of(&Film::new(3, 3)).ev, 0.0);
        // Exposures are bounded beyond the range of any display.
        assert_eq!(AutoExposure::of_luminances(vec![1e-300]).ev, 64.0);
    }

    fn film(radiance: &[f32]) -> Film {
        let mut film = Film::new(radiance.len() as u32, 1);
        let lanes: Vec<u32> = (0..radiance.len() as u32).collect();
        let sums: Vec<_> = radiance.iter().map(|&r| BatchSum::constant(2, [r; 3])).collect();
        film.add_batch(2, &lanes, &sums).unwrap();
        film
    }

    #[test]
    fn detail_must_be_lost_in_most_pixels() {
        let plain = Display { exposure_ev: 0.0, tonemap: ToneMap::None };
        let lost = |radiance: &[f32]| LostPixels::of(&film(radiance), &plain);
        assert_eq!(lost(&[1e-6, 1e-6, 1e-6, 0.5]), Some(LostPixels { share: 0.75, loss: Loss::Black }));
        assert_eq!(lost(&[7.0, 7.0, 7.0, 0.5]), Some(LostPixels { share: 0.75, loss: Loss::Clipped }));
        // Half is not most, white is not brighter than white, and a black background is no loss.
        for kept in [&[1e-6, 1e-6, 0.5, 0.5][..], &[7.0, 7.0, 0.5, 0.5], &[1.0; 4], &[0.0, 0.0, 0.0, 0.5], &[0.0; 4]] {
            assert_eq!(lost(kept), None, "{kept:?}");
        }
        // Behind a black background, all that is lit is lost.
        assert_eq!(lost(&[0.0, 0.0, 0.0, 1e-6]), Some(LostPixels { share: 0.25, loss: Loss::Black }));
        let bright = Display { exposure_ev: 16.0, ..plain };
        assert_eq!(LostPixels::of(&film(&[1e-6, 1e-6, 1e-6, 0.5]), &bright), None);
    }
}
