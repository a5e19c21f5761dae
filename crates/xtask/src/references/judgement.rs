//! Whether a render agrees with a reference.

use surelight_estimate::{Estimate, student_t_quantile, welch_test};
use surelight_film::ExrImage;

/// Independent batches in a render whose file does not say: the command line's default.
const DEFAULT_BATCHES: u32 = 16;
const CONFIDENCE: f64 = 0.999;
const SHARE_INSIDE: f64 = 0.988;
const MEAN_TOLERANCE: f64 = 0.002;
const MEAN_ERRORS: f64 = 3.0;
const ULPS: f64 = 4.0;

/// Result of a comparison; arrays are red, green, blue.
#[derive(Debug)]
pub(super) struct Outcome {
    /// Difference of the image means relative to the reference's.
    mean: [f64; 3],
    /// The limit on that.
    allowed: [f64; 3],
    /// Whether it is no more, judged without the division: a black reference allows its standard
    /// errors only.
    mean_agrees: [bool; 3],
    /// Share of pixels inside the bound.
    inside: [f64; 3],
    /// Share of pixels inside it in all three channels.
    inside_all: f64,
    /// Mean over lit pixels of the standard error relative to the reference: how sharp the
    /// comparison is.
    pixel_error: f64,
}

impl Outcome {
    pub(super) fn passes(&self) -> bool {
        (0..3).all(|channel| self.mean_agrees[channel] && self.inside[channel] >= SHARE_INSIDE)
    }
}

impl std::fmt::Display for Outcome {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let percent = |x: f64| 100.0 * x;
        let [r, g, b] = self.mean.map(percent);
        write!(
            f,
            "{r:>+8.3} {g:>+8.3} {b:>+7.3} | {:>9.3} {:>8.3} {:>8.3} {:>9.3}  {}",
            percent(self.allowed.into_iter().fold(f64::INFINITY, f64::min)),
            percent(self.inside.into_iter().fold(f64::INFINITY, f64::min)),
            percent(self.inside_all),
            percent(self.pixel_error),
            if self.passes() { "pass" } else { "FAIL" }
        )
    }
}

pub(super) fn compare(ours: &ExrImage, reference: &ExrImage, variance: Option<&ExrImage>) -> Result<Outcome, String> {
    let size = (reference.width, reference.height);
    for image in [Some(ours), variance].into_iter().flatten() {
        if (image.width, image.height) != size {
            return Err(format!("sizes differ: {}x{} and {}x{}", image.width, image.height, size.0, size.1));
        }
    }
    let mean = ours.rgb("").ok_or("the render has no R, G, B")?;
    let spread = ours.rgb("Variance").ok_or("the render has no Variance layer")?;
    let truth = reference.rgb("").ok_or("the reference has no R, G, B")?;
    let truth_spread = match variance {
        Some(image) => Some(image.rgb("").ok_or("the reference's variance has no R, G, B")?),
        None => None,
    };
    let batches = ours.surelight_metadata().map_or(DEFAULT_BATCHES, |metadata| metadata.batches);
    if batches < 2 {
        return Err(format!("the render says that its variance is made of {batches} batches"));
    }
    let dof = f64::from(batches) - 1.0;
    let level = student_t_quantile(0.5 + 0.5 * CONFIDENCE, dof);

    let pixels = size.0 * size.1;
    let mut outside = vec![false; pixels];
    let mut outcome = Outcome {
        mean: [0.0; 3],
        allowed: [0.0; 3],
        mean_agrees: [false; 3],
        inside: [0.0; 3],
        inside_all: 0.0,
        pixel_error: 0.0,
    };
    let mut lit = 0usize;
    for channel in 0..3 {
        let (mut difference, mut total, mut variances, mut inside) = (0.0, 0.0, 0.0, 0usize);
        for (i, outside) in outside.iter_mut().enumerate() {
            let a = Estimate { mean: mean[channel][i].into(), variance: spread[channel][i].into(), dof };
            let known = truth_spread.map_or(0.0, |spread| f64::from(spread[channel][i]));
            let b = Estimate { mean: truth[channel][i].into(), variance: known, dof: f64::INFINITY };
            difference += a.mean - b.mean;
            total += b.mean;
            variances += a.variance + b.variance;
            if is_inside(&a, &b, level) {
                inside += 1;
            } else {
                *outside = true;
            }
            if b.mean > 0.0 {
                lit += 1;
                outcome.pixel_error += (a.variance + b.variance).sqrt() / b.mean;
            }
        }
        let allowed = MEAN_TOLERANCE * total.abs() + MEAN_ERRORS * variances.sqrt();
        outcome.mean_agrees[channel] = difference.abs() <= allowed;
        outcome.mean[channel] = if difference == 0.0 { 0.0 } else { difference / total };
        outcome.allowed[channel] = if allowed == 0.0 { 0.0 } else { allowed / total };
        outcome.inside[channel] = inside as f64 / pixels as f64;
    }
    outcome.pixel_error /= lit.max(1) as f64;
    outcome.inside_all = outside.iter().filter(|outside| !**outside).count() as f64 / pixels as f64;
    Ok(outcome)
}

/// Whether two estimates of a pixel agree; `level` is the t quantile at the first one's own degrees
/// of freedom.
fn is_inside(a: &Estimate, b: &Estimate, level: f64) -> bool {
    let difference = (a.mean - b.mean).abs();
    let error = (a.variance + b.variance).sqrt();
    if !difference.is_finite() || !error.is_finite() {
        return false;
    }
    let rounding = ULPS * f64::from(f32::EPSILON) * a.mean.abs().max(b.mean.abs());
    if difference <= rounding {
        return true;
    }
    let beyond = difference - rounding;
    if b.variance == 0.0 {
        return beyond <= level * error;
    }
    let shifted = Estimate { mean: b.mean + beyond, ..*a };
    welch_test(&shifted, b).p >= 1.0 - CONFIDENCE
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 64;

    /// An image of mean 1 with batches of normal errors, plus its variance, as a render would have
    /// it.
    fn render(bias: f64, deviation: f64, seed: u64) -> ExrImage {
        let mut state = seed;
        let mut uniform = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) as f64 + 0.5) / (1u64 << 31) as f64
        };
        let mut normal = move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
        let mut image = ExrImage { width: SIDE, height: SIDE, ..ExrImage::default() };
        for channel in ["R", "G", "B"] {
            let (mut means, mut variances) = (Vec::new(), Vec::new());
            for _ in 0..SIDE * SIDE {
                let batches: Vec<f64> = (0..16).map(|_| 1.0 + bias + 4.0 * deviation * normal()).collect();
                let mean = batches.iter().sum::<f64>() / 16.0;
                means.push(mean as f32);
                variances.push((batches.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 15.0 / 16.0) as f32);
            }
            image.channels.insert(channel.into(), means);
            image.channels.insert(format!("Variance.{channel}"), variances);
        }
        image
    }

    fn flat(value: f32) -> ExrImage {
        let mut image = ExrImage { width: SIDE, height: SIDE, ..ExrImage::default() };
        for channel in ["R", "G", "B"] {
            image.channels.insert(channel.into(), vec![value; SIDE * SIDE]);
        }
        image
    }

    #[test]
    fn a_true_render_passes_at_the_stated_coverage() {
        let outcome = compare(&render(0.0, 0.01, 1), &flat(1.0), None).unwrap();
        assert!(outcome.passes());
        // 99.9 % of 3·4096 values: 4 standard errors are 0.11 %.
        let inside = outcome.inside.iter().sum::<f64>() / 3.0;
        assert!((inside - 0.999).abs() < 0.0012, "{inside}");
        assert!((outcome.pixel_error - 0.01).abs() < 0.0005);
    }

    #[test]
    fn a_bias_of_half_a_percent_fails_by_the_mean_alone() {
        let outcome = compare(&render(0.005, 0.02, 2), &flat(1.0), None).unwrap();
        assert!(outcome.inside.iter().all(|&inside| inside >= SHARE_INSIDE));
        assert!(!outcome.passes());
    }

    #[test]
    fn error_bars_half_too_small_fail_by_coverage_alone() {
        let mut image = render(0.0, 0.01, 3);
        for channel in ["Variance.R", "Variance.G", "Variance.B"] {
            image.channels.get_mut(channel).unwrap().iter_mut().for_each(|v| *v *= 0.25);
        }
        let outcome = compare(&image, &flat(1.0), None).unwrap();
        assert!(outcome.mean_agrees == [true; 3] && !outcome.passes());
    }

    #[test]
    fn light_where_the_reference_is_black_fails() {
        let mut ours = flat(1e-6);
        for channel in ["R", "G", "B"] {
            ours.channels.insert(format!("Variance.{channel}"), vec![0.0; SIDE * SIDE]);
        }
        assert!(!compare(&ours, &flat(0.0), None).unwrap().passes());
        assert!(compare(&ours, &flat(1e-6), None).unwrap().passes());
    }

    #[test]
    fn a_noisy_reference_needs_its_variance() {
        let (ours, mut reference) = (render(0.0, 0.01, 4), render(0.0, 0.02, 5));
        assert!(!compare(&ours, &reference, None).unwrap().passes());
        let outcome = compare(&ours, &reference, Some(&flat(0.0004))).unwrap();
        assert!(outcome.passes() && outcome.inside_all > 0.99, "{outcome}");
        reference.width = 1;
        assert!(compare(&ours, &reference, None).is_err());
    }

    #[test]
    fn exact_pixels_get_four_ulps_and_unknown_errors_nothing() {
        let exact = |mean: f32| Estimate::exact(f64::from(mean));
        let above = |n: u32| exact(f32::from_bits(1f32.to_bits() + n));
        assert!(is_inside(&exact(1.0), &exact(1.0), 4.0) && is_inside(&above(4), &exact(1.0), 4.0));
        assert!(!is_inside(&above(6), &exact(1.0), 4.0));
        let unknown = Estimate { mean: 1.0, variance: f64::INFINITY, dof: 15.0 };
        assert!(!is_inside(&unknown, &exact(1.0), 4.0));
        assert!(!is_inside(&Estimate { mean: f64::NAN, variance: 1.0, dof: 15.0 }, &exact(1.0), 4.0));
    }
}
