//! LDR-FLIP: the difference that a person sees when flipping between two displayed pictures.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, "FLIP: a difference evaluator
//! for alternating images", Proc. ACM Comput. Graph. Interact. Tech. 3(2) (HPG 2020); section and
//! equation numbers below are the paper's. The viewing distance is the paper's: 0.7 m from a
//! monitor of 0.7 m and 3840 pixels width, 67 pixels a degree.

use rayon::prelude::*;

use super::Picture;
use crate::Display;

/// Pixels a degree of visual angle: 0.7 m · 3840 px / 0.7 m · π/180.
const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

type Plane = Vec<f64>;

/// Mean of [`flip`], the figure usually quoted.
pub fn mean_flip(a: &Picture, b: &Picture, display: &Display) -> f64 {
    let map = flip(a, b, display);
    map.iter().sum::<f64>() / map.len().max(1) as f64
}

/// The FLIP map of two pictures as `display` shows them: 0 (no visible difference) to 1 per pixel.
/// The pictures must have the same size.
pub fn flip(a: &Picture, b: &Picture, display: &Display) -> Vec<f64> {
    let (width, height) = (a.width.min(b.width), a.height.min(b.height));
    if width == 0 || height == 0 {
        return Vec::new();
    }
    let [shown_a, shown_b] = [a, b].map(|picture| opponent(picture, display));
    let color = color_difference(&shown_a, &shown_b, width);
    let feature = feature_difference(&shown_a[0], &shown_b[0], width);
    // Section 4.3, equation 17.
    color.into_par_iter().zip(feature).map(|(color, feature)| color.powf(1.0 - feature)).collect()
}

/// Rec. 709 to XYZ, and the white that it makes of (1, 1, 1).
const TO_XYZ: [[f64; 3]; 3] = [
    [10135552.0 / 24577794.0, 8788810.0 / 24577794.0, 4435075.0 / 24577794.0],
    [2613072.0 / 12288897.0, 8788810.0 / 12288897.0, 887015.0 / 12288897.0],
    [1425312.0 / 73733382.0, 8788810.0 / 73733382.0, 70074185.0 / 73733382.0],
];

fn white() -> [f64; 3] {
    TO_XYZ.map(|row| row.iter().sum())
}

/// The display's light in the linear opponent space YyCxCz (section 4.1).
fn opponent(picture: &Picture, display: &Display) -> [Plane; 3] {
    let white = white();
    let pixels: Vec<[f64; 3]> = (0..picture.width * picture.height)
        .into_par_iter()
        .map(|i| {
            // Through the bytes that the screen gets.
            let rgb = display.bytes(picture.pixel(i)).map(|byte| srgb_to_linear(f64::from(byte) / 255.0));
            let xyz: [f64; 3] = std::array::from_fn(|k| dot(TO_XYZ[k], rgb) / white[k]);
            [116.0 * xyz[1] - 16.0, 500.0 * (xyz[0] - xyz[1]), 200.0 * (xyz[1] - xyz[2])]
        })
        .collect();
    std::array::from_fn(|c| pixels.iter().map(|pixel| pixel[c]).collect())
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn srgb_to_linear(x: f64) -> f64 {
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// A Gaussian of the contrast sensitivity function: `a·√(π/b)·exp(−π²x²/b)` with x in degrees
/// (section 4.1, table 1).
struct Sensitivity {
    a: f64,
    b: f64,
}

/// Colour difference, 0 to 1 per pixel (sections 4.1.1–4.1.3).
fn color_difference(a: &[Plane; 3], b: &[Plane; 3], width: usize) -> Plane {
    let channels: [&[Sensitivity]; 3] = [
        &[Sensitivity { a: 1.0, b: 0.0047 }],
        &[Sensitivity { a: 1.0, b: 0.0053 }],
        &[Sensitivity { a: 34.1, b: 0.04 }, Sensitivity { a: 13.5, b: 0.025 }],
    ];
    let filter = |planes: &[Plane; 3]| -> [Plane; 3] {
        std::array::from_fn(|c| sensitivity_filter(&planes[c], width, channels[c]))
    };
    let (a, b) = (filter(a), filter(b));
    let largest = hyab(hunt_lab([0.0, 1.0, 0.0]), hunt_lab([0.0, 0.0, 1.0])).powf(0.7);
    // Section 4.1.3: differences below 0.4 of the largest take 0.95 of the range.
    let knee = 0.4 * largest;
    (0..a[0].len())
        .into_par_iter()
        .map(|i| {
            let [x, y] = [&a, &b].map(|planes| hunt_lab(display_light([planes[0][i], planes[1][i], planes[2][i]])));
            let difference = hyab(x, y).powf(0.7);
            if difference < knee {
                0.95 / knee * difference
            } else {
                0.95 + (difference - knee) / (largest - knee) * 0.05
            }
        })
        .collect()
}

/// Convolution with a sum of Gaussians, together of weight one.
fn sensitivity_filter(plane: &Plane, width: usize, terms: &[Sensitivity]) -> Plane {
    let pi = std::f64::consts::PI;
    // Radius of the widest Gaussian of all channels, three standard deviations.
    let radius = (3.0 * (0.04 / (2.0 * pi * pi)).sqrt() * PIXELS_PER_DEGREE).ceil() as i64;
    let kernels: Vec<(f64, Vec<f64>)> = terms
        .iter()
        .map(|term| {
            let at = |x: i64| (-(pi * x as f64 / PIXELS_PER_DEGREE).powi(2) / term.b).exp();
            (term.a * (pi / term.b).sqrt(), (-radius..=radius).map(at).collect())
        })
        .collect();
    // Each Gaussian is a product of one in x and one in y; only their sum is normalised.
    let weight: f64 = kernels.iter().map(|(scale, kernel)| scale * kernel.iter().sum::<f64>().powi(2)).sum();
    let mut sum = vec![0.0; plane.len()];
    for (scale, kernel) in &kernels {
        let filtered = convolve(plane, width, kernel, kernel);
        sum.iter_mut().zip(filtered).for_each(|(sum, x)| *sum += scale / weight * x);
    }
    sum
}

/// Linear Rec. 709 of an opponent colour, clipped to the gamut of a display.
fn display_light([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    // Inverse of TO_XYZ.
    const FROM_XYZ: [[f64; 3]; 3] = [
        [3.2410032329763587, -1.5373989694887855, -0.4986158819963629],
        [-0.9692242522025166, 1.875929983695176, 0.041554226340084724],
        [0.055639419851975444, -0.20401120612390997, 1.0571489771875335],
    ];
    let y = (y + 16.0) / 116.0;
    let white = white();
    let xyz = [(y + cx / 500.0) * white[0], y * white[1], (y - cz / 200.0) * white[2]];
    FROM_XYZ.map(|row| dot(row, xyz).clamp(0.0, 1.0))
}

/// CIELAB with its chroma weighed by lightness: the Hunt effect (equation 4).
fn hunt_lab(rgb: [f64; 3]) -> [f64; 3] {
    let white = white();
    let f = |t: f64| {
        const DELTA: f64 = 6.0 / 29.0;
        if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z]: [f64; 3] = std::array::from_fn(|k| f(dot(TO_XYZ[k], rgb) / white[k]));
    let lightness = 116.0 * y - 16.0;
    let hunt = 0.01 * lightness;
    [lightness, hunt * 500.0 * (x - y), hunt * 200.0 * (y - z)]
}

/// Distance that is additive in lightness and Euclidean in chroma, for large differences (equation
/// 5).
fn hyab(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypot(a[2] - b[2])
}

/// Difference of edges and points, 0 to 1 per pixel (section 4.2).
fn feature_difference(a: &Plane, b: &Plane, width: usize) -> Plane {
    let deviation = 0.5 * 0.082 * PIXELS_PER_DEGREE;
    let radius = (3.0 * deviation).ceil() as i64;
    let kernel = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (-radius..=radius).map(|x| x as f64).map(|x| f(x) * (-x * x / (2.0 * deviation * deviation)).exp()).collect()
    };
    let smooth = normalised(kernel(&|_| 1.0));
    let edge = normalised(kernel(&|x| -x));
    let point = normalised(kernel(&|x| x * x / (deviation * deviation) - 1.0));
    let detect = |plane: &Plane, detector: &[f64]| -> Plane {
        let gray: Plane = plane.iter().map(|y| (y + 16.0) / 116.0).collect();
        let (x, y) = (convolve(&gray, width, detector, &smooth), convolve(&gray, width, &smooth, detector));
        x.into_iter().zip(y).map(|(x, y): (f64, f64)| x.hypot(y)).collect()
    };
    let [edges, points] = [&edge, &point].map(|detector| [detect(a, detector), detect(b, detector)]);
    (0..a.len())
        .map(|i| {
            let [edge, point] = [&edges, &points].map(|[a, b]| (a[i] - b[i]).abs());
            (edge.max(point) / std::f64::consts::SQRT_2).sqrt().min(1.0)
        })
        .collect()
}

/// Scales the positive weights to sum 1 and the negative ones to −1.
fn normalised(kernel: Vec<f64>) -> Vec<f64> {
    let positive: f64 = kernel.iter().filter(|w| **w > 0.0).sum();
    let negative: f64 = -kernel.iter().filter(|w| **w < 0.0).sum::<f64>();
    kernel
        .into_iter()
        .map(|w| {
            if w > 0.0 {
                w / positive
            } else if w < 0.0 {
                w / negative
            } else {
                w
            }
        })
        .collect()
}

/// Correlates rows with `across` and columns with `down`; the border's pixels are repeated outward.
fn convolve(plane: &Plane, width: usize, across: &[f64], down: &[f64]) -> Plane {
    let height = plane.len() / width;
    let sum = |kernel: &[f64], centre: usize, count: usize, at: &dyn Fn(usize) -> f64| -> f64 {
        let radius = kernel.len() / 2;
        kernel
            .iter()
            .enumerate()
            .map(|(k, weight)| weight * at((centre + k).saturating_sub(radius).min(count - 1)))
            .sum()
    };
    let index = (0..plane.len()).into_par_iter();
    let rows: Plane = index.clone().map(|i| sum(across, i % width, width, &|x| plane[i - i % width + x])).collect();
    index.map(|i| sum(down, i / width, height, &|y| rows[y * width + i % width])).collect()
}

#[cfg(test)]
mod tests {
    use super::super::testing::Planes;
    use super::*;
    use crate::ToneMap;

    const PLAIN: Display = Display { exposure_ev: 0.0, tonemap: ToneMap::None };

    #[test]
    fn equal_pictures_do_not_differ() {
        let a = Planes::new(30, 20, |x, y| [x as f32 / 30.0, y as f32 / 20.0, 0.5]);
        assert_eq!(mean_flip(&a.picture(), &a.picture(), &PLAIN), 0.0);
    }

    #[test]
    fn inverse_matrix_is_one() {
        for rgb in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.2, 0.3, 0.9]] {
            let white = white();
            let xyz: [f64; 3] = std::array::from_fn(|k| dot(TO_XYZ[k], rgb) / white[k]);
            let back = display_light([116.0 * xyz[1] - 16.0, 500.0 * (xyz[0] - xyz[1]), 200.0 * (xyz[1] - xyz[2])]);
            for (found, expected) in back.into_iter().zip(rgb) {
                assert!((found - expected).abs() < 1e-14);
            }
        }
    }

    fn of_bytes(width: usize, height: usize, bytes: impl Fn(usize, usize) -> [usize; 3]) -> Planes {
        Planes::new(width, height, |x, y| bytes(x, y).map(|byte| srgb_to_linear((byte % 256) as f64 / 255.0) as f32))
    }

    fn pattern(x: usize, y: usize) -> [usize; 3] {
        [(5 * x + 2 * y) % 256, (3 * x * y / 16) % 256, 40 + (x / 8 + y / 8) % 2 * 120]
    }

    fn spotted(x: usize, y: usize, added: [usize; 3]) -> [usize; 3] {
        let (dx, dy) = (x.abs_diff(40), y.abs_diff(30));
        let base = pattern(x, y);
        if dx * dx + dy * dy < 200 { std::array::from_fn(|c| base[c] + added[c]) } else { base }
    }

    // Expected values: the authors' own evaluator, version 1.7, at the same pixels a degree.

    #[test]
    fn patterns_match_the_authors_evaluator() {
        let base = of_bytes(96, 64, pattern);
        let raised = of_bytes(96, 64, |x, y| spotted(x, y, [60; 3]));
        let tinted = of_bytes(96, 64, |x, y| spotted(x, y, [25, 50, 75]));
        let map = flip(&base.picture(), &raised.picture(), &PLAIN);
        for (x, y, expected) in
            [(0, 0, 0.0), (40, 30, 0.981_327), (54, 30, 0.648_186), (50, 40, 0.448_669), (95, 63, 0.0)]
        {
            assert!((map[y * 96 + x] - expected).abs() < 2e-4, "{x},{y}: {}", map[y * 96 + x]);
        }
        assert!((mean_flip(&base.picture(), &raised.picture(), &PLAIN) - 0.110_654).abs() < 2e-5);
        assert!((mean_flip(&base.picture(), &tinted.picture(), &PLAIN) - 0.106_212).abs() < 2e-5);
    }

    #[test]
    fn flat_pictures_and_a_point_match_the_authors_evaluator() {
        let flat = |rgb: [usize; 3]| of_bytes(32, 32, move |_, _| rgb);
        let mean = |a: &Planes, b: &Planes| mean_flip(&a.picture(), &b.picture(), &PLAIN);
        let black = flat([0; 3]);
        assert!((mean(&black, &flat([255; 3])) - 0.967_395).abs() < 2e-5);
        assert!((mean(&flat([0, 255, 0]), &flat([0, 0, 255])) - 1.0).abs() < 2e-5);
        let point = of_bytes(32, 32, |x, y| if (x, y) == (16, 16) { [255; 3] } else { [0; 3] });
        assert!((mean(&black, &point) - 0.013_973_9).abs() < 2e-5);
    }
}
