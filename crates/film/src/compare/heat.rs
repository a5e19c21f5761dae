//! Where two pictures differ, as a picture.

use super::{Picture, beyond_rounding};
use crate::{linear_to_srgb, to_u8};

/// Standard errors, where variances are known, at which the colour is full.
const FULL_ERRORS: f64 = 5.0;
/// Relative difference |a − b|/(|a| + |b| + 0.01), otherwise, at which it is.
const FULL_RELATIVE: f64 = 0.5;

/// A colour for a signed amount in [−1, 1]: black for none, through red and orange to near white
/// for more, through blue and cyan for less.
///
/// Either arm rises evenly in luminance, so that it reads in grey too, and the two arms are equally
/// bright.
pub fn heat_color(amount: f64) -> [u8; 3] {
    // Linear Rec. 709; luminances 0, 0.04, 0.25, 0.85 are about even in lightness (0, 24, 57, 94).
    const WARM: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.165, 0.005, 0.02], [0.72, 0.13, 0.02], [1.0, 0.84, 0.5]];
    const COOL: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [0.012, 0.03, 0.22], [0.03, 0.29, 0.5], [0.6, 0.93, 0.8]];
    if amount.is_nan() {
        // Not a colour of either arm.
        return [255, 0, 255];
    }
    let stops = if amount < 0.0 { &COOL } else { &WARM };
    let at = amount.abs().min(1.0) * 3.0;
    let low = (at.floor() as usize).min(2);
    let f = at - low as f64;
    std::array::from_fn(|c| to_u8(linear_to_srgb(stops[low][c] * (1.0 - f) + stops[low + 1][c] * f)))
}

/// Heat map of a − b, one colour per pixel: warm where `a` is brighter, cool where it is darker,
/// magenta where a value is not finite.
///
/// The amount is that of the channel that differs most: in standard errors of the difference, full
/// at 5, where both pictures have a variance; else (a − b)/(|a| + |b| + 0.01), full at a half.
/// Differences of rounding are ignored. The pictures must have the same size.
pub fn heat_map(a: &Picture, b: &Picture) -> Vec<[u8; 3]> {
    let count = (a.width * a.height).min(b.width * b.height);
    (0..count)
        .map(|i| {
            let variances = a.pixel_variance(i).zip(b.pixel_variance(i));
            let mut worst = 0.0f64;
            for (channel, (x, y)) in a.pixel(i).into_iter().zip(b.pixel(i)).enumerate() {
                let d = beyond_rounding(x, y);
                let amount = match variances {
                    Some((va, vb)) if d != 0.0 => d / (va[channel] + vb[channel]).sqrt() / FULL_ERRORS,
                    Some(_) => 0.0,
                    None => d / (x.abs() + y.abs() + 1e-2) / FULL_RELATIVE,
                };
                if amount.is_nan() {
                    return heat_color(f64::NAN);
                }
                if amount.abs() > worst.abs() {
                    worst = amount;
                }
            }
            heat_color(worst)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::Planes;
    use super::*;

    #[test]
    fn both_arms_rise_and_match() {
        let luminance = |rgb: [u8; 3]| {
            let light = rgb.map(|x| (f64::from(x) / 255.0).powf(2.2));
            0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2]
        };
        let mut last = -1.0;
        for step in 0..=30 {
            let amount = f64::from(step) / 30.0;
            let (warm, cool) = (luminance(heat_color(amount)), luminance(heat_color(-amount)));
            assert!(warm > last && (warm - cool).abs() < 0.04, "{amount}: {warm} {cool}");
            last = warm;
        }
        assert_eq!(heat_color(0.0), [0; 3]);
        assert_eq!(heat_color(7.0), heat_color(1.0));
    }

    #[test]
    fn signs_and_units() {
        let mut a = Planes::new(4, 1, |x, _| [[1.0, 1.5, 0.5, f32::NAN][x]; 3]);
        let mut b = Planes::new(4, 1, |_, _| [1.0; 3]);
        let map = heat_map(&a.picture(), &b.picture());
        assert_eq!(map[0], heat_color(0.0));
        assert_eq!(map[1], heat_color(0.5 / 2.51 / 0.5));
        assert_eq!(map[2], heat_color(-0.5 / 1.51 / 0.5));
        assert_eq!(map[3], [255, 0, 255]);
        for planes in [&mut a, &mut b] {
            planes.variance = Some([(); 3].map(|()| vec![0.005; 4]));
        }
        // Standard error 0.1: five of them.
        assert_eq!(heat_map(&a.picture(), &b.picture())[1], heat_color(0.5 / 0.1 / 5.0));
    }
}
