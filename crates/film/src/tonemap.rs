//! From linear Rec. 709 radiance to display values: tone curves and the sRGB transfer function.
//!
//! Everything is f64 and branch-free of the platform's fast-math, so equal radiance gives equal
//! bytes.

/// Maps radiance to the display's range.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub enum ToneMap {
    /// Khronos PBR Neutral (Khronos Group 2024, `ToneMapping/PBR_Neutral`): base colours are kept,
    /// only highlights are compressed.
    #[default]
    Neutral,
    /// AgX (Sobotka 2022) with its default look, its sigmoid as the sixth-order polynomial of
    /// Wrensch ("Minimal AgX Implementation", 2023).
    Agx,
    /// ACES reference and output transform for sRGB at 100 nit, as fitted by Stephen Hill
    /// (published in Pettineo's BakingLab, 2016).
    Aces,
    /// No curve: values above 1 are clipped.
    None,
}

impl ToneMap {
    /// Display-linear Rec. 709 of a linear radiance; not yet clipped to [0, 1].
    pub fn map(self, rgb: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Neutral => neutral(rgb),
            Self::Agx => agx(rgb),
            Self::Aces => aces(rgb),
            Self::None => rgb,
        }
    }
}

/// Khronos PBR Neutral with its published constants.
fn neutral(rgb: [f64; 3]) -> [f64; 3] {
    const START: f64 = 0.8 - 0.04;
    const DESATURATION: f64 = 0.15;
    let smallest = rgb[0].min(rgb[1]).min(rgb[2]);
    let offset = if smallest < 0.08 { smallest - 6.25 * smallest * smallest } else { 0.04 };
    let rgb = rgb.map(|x| x - offset);
    let peak = rgb[0].max(rgb[1]).max(rgb[2]);
    if peak < START {
        return rgb;
    }
    const D: f64 = 1.0 - START;
    let new_peak = 1.0 - D * D / (peak + D - START);
    let desaturated = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    rgb.map(|x| {
        let scaled = x * (new_peak / peak);
        scaled + (new_peak - scaled) * desaturated
    })
}

type Matrix = [[f64; 3]; 3];

/// Rows times vector.
fn transform(rows: &Matrix, v: [f64; 3]) -> [f64; 3] {
    rows.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

fn agx(rgb: [f64; 3]) -> [f64; 3] {
    const INSET: Matrix = [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ];
    const OUTSET: Matrix = [
        [1.19687900512017, -0.0980208811401368, -0.0990297440797205],
        [-0.0528968517574562, 1.15190312990417, -0.0989611768448433],
        [-0.0529716355144438, -0.0980434501171241, 1.15107367264116],
    ];
    const MIN_EV: f64 = -12.47393;
    const MAX_EV: f64 = 4.026069;
    let curve = |x: f64| {
        let x = (x.max(1e-10).log2().clamp(MIN_EV, MAX_EV) - MIN_EV) / (MAX_EV - MIN_EV);
        let coefficients = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
        coefficients.into_iter().fold(0.0, |sum, c| sum * x + c)
    };
    let displayed = transform(&OUTSET, transform(&INSET, rgb).map(curve));
    // The curve ends in display code values of a 2.2 power display; back to light.
    displayed.map(|x| x.max(0.0).powf(2.2))
}

fn aces(rgb: [f64; 3]) -> [f64; 3] {
    // sRGB → XYZ → D65 to D60 → AP1 → desaturation of the reference transform.
    const INPUT: Matrix = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    // Desaturation of the output transform → XYZ → D60 to D65 → sRGB.
    const OUTPUT: Matrix =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let curve = |x: f64| (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
    transform(&OUTPUT, transform(&INPUT, rgb).map(curve))
}

/// The sRGB transfer function (IEC 61966-2-1): display light in [0, 1] to code value in [0, 1].
/// Values outside are clipped; NaN becomes 0.
pub fn linear_to_srgb(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    if x.is_nan() {
        0.0
    } else if x <= 0.0031308 {
        12.92 * x
    } else {
        1.055 * x.powf(1.0 / 2.4) - 0.055
    }
}

/// A code value in [0, 1] as a byte, to the nearest, halves up.
pub fn to_u8(x: f64) -> u8 {
    (x * 255.0 + 0.5).floor().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [ToneMap; 4] = [ToneMap::Neutral, ToneMap::Agx, ToneMap::Aces, ToneMap::None];

    #[test]
    fn neutral_keeps_base_colours() {
        // The specification's design: a base colour is displayed 4 % darker, for the 4 % of Fresnel
        // reflection that a lit dielectric adds to it.
        let mapped = ToneMap::Neutral.map([0.5, 0.2, 0.3]);
        for (value, expected) in mapped.into_iter().zip([0.46, 0.16, 0.26]) {
            assert!((value - expected).abs() < 1e-12);
        }
        // Toe: x − (x − 6.25 x²) = 6.25 x² for grey below 0.08.
        assert!((ToneMap::Neutral.map([0.04; 3])[0] - 0.01).abs() < 1e-12);
        // Shoulder at grey 1.04: peak 1.0, new peak 1 − 0.24²/(1.0 + 0.24 − 0.76) = 0.88.
        assert!((ToneMap::Neutral.map([1.04; 3])[1] - 0.88).abs() < 1e-12);
        // A pure red of 2: offset 0, new peak 1 − 0.0576/1.48, whitened by 1 − 1/(0.15·(2 − new
        // peak) + 1).
        let new_peak = 1.0 - 0.0576 / 1.48;
        let white = 1.0 - 1.0 / (0.15 * (2.0 - new_peak) + 1.0);
        let red = ToneMap::Neutral.map([2.0, 0.0, 0.0]);
        assert!((red[0] - new_peak).abs() < 1e-12 && (red[1] - new_peak * white).abs() < 1e-12);
    }

    #[test]
    fn agx_and_aces_hit_known_greys() {
        // AgX puts middle grey, 0.18, at a code value of about 0.5 on its 2.2 display.
        let grey = ToneMap::Agx.map([0.18; 3])[0].powf(1.0 / 2.2);
        assert!((grey - 0.4975).abs() < 0.01, "{grey}");
        // Hill's fit by hand at 0.18: (0.18·0.2045786 − 9.0537e-5)/(0.18·(0.17707122 + 0.432951) +
        // 0.238081); rows of both matrices sum to one up to their five digits.
        let curve = (0.18 * 0.2045786 - 0.000090537) / (0.18 * (0.983729 * 0.18 + 0.432951) + 0.238081);
        assert!((ToneMap::Aces.map([0.18; 3])[1] - curve).abs() < 1e-5);
        assert!((curve - 0.1054).abs() < 1e-3);
    }

    #[test]
    fn curves_rise_and_stay_grey() {
        for tone_map in ALL {
            let mut last = -1.0;
            for step in 0..200 {
                let x = 2f64.powf(f64::from(step) / 8.0 - 14.0);
                let rgb = tone_map.map([x; 3]);
                assert!((rgb[0] - rgb[1]).abs() < 2e-4 * (1.0 + x) && (rgb[1] - rgb[2]).abs() < 2e-4 * (1.0 + x));
                assert!(rgb[1] >= last - 1e-9, "{tone_map:?} falls at {x}");
                last = rgb[1];
            }
        }
    }

    #[test]
    fn every_value_fits_a_byte() {
        for tone_map in ALL {
            for x in [0.0, -1.0, 1e-40, 1.0, 65504.0, f64::from(f32::MAX)] {
                for rgb in [[x; 3], [x, 0.0, 0.0], [0.0, x, 1.0]] {
                    for y in tone_map.map(rgb) {
                        let code = linear_to_srgb(y);
                        assert!((0.0..=1.0).contains(&code), "{tone_map:?} {rgb:?}");
                    }
                }
            }
        }
        assert_eq!(to_u8(linear_to_srgb(f64::NAN)), 0);
    }

    #[test]
    fn srgb_code_values() {
        // Published pairs: middle grey 0.2140 ↔ 127.5/255; the knee; the ends.
        assert_eq!(to_u8(linear_to_srgb(0.0)), 0);
        assert_eq!(to_u8(linear_to_srgb(1.0)), 255);
        assert_eq!(to_u8(linear_to_srgb(7.0)), 255);
        assert!((linear_to_srgb(0.21404114) - 0.5).abs() < 1e-7);
        assert!((linear_to_srgb(0.0031308) - 0.04045).abs() < 1e-5);
        assert_eq!(to_u8(0.5), 128);
    }
}
