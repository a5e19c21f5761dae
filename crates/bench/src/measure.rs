//! Errors of a film: the real ones, against the reference, and its own estimate of them.
//!
//! The reference is noisy, too. Where its variance is known it is taken off: E(x − r)² = Var x +
//! bias² + Var r, so the remainder is the error that the picture would have against a perfect
//! reference, without bias.

use surelight_estimate::student_t_quantile;
use surelight_film::{
    Display, Film,
    compare::{Picture, mean_flip},
};

/// The part of the squared mean radiance that is added to a pixel's own square in relative errors:
/// dark pixels do not rule them.
pub const EPSILON: f64 = 0.01;

/// Confidence of the intervals whose coverage is measured.
pub const CONFIDENCE: f64 = 0.95;

/// The picture against which errors are measured. Planes are red, green, blue.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Pixels per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Mean radiance.
    pub rgb: [Vec<f32>; 3],
    /// Variance of the mean; `None` where it is unknown, and then taken as 0.
    pub variance: Option<[Vec<f32>; 3]>,
    /// Whether the pixels of each 2×2 square used one another's paths.
    pub reuses_paths: bool,
}

/// A film compared with a reference; the fields are those of [`crate::data::Row`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Mean over pixels and channels.
    pub mean: f64,
    /// Standard error of that mean.
    pub mean_se: Option<f64>,
    /// Relative error of that mean.
    pub mean_error: f64,
    /// Mean square error, less the reference's.
    pub mse: f64,
    /// Relative mean square error, less the reference's.
    pub rel_mse: f64,
    /// The film's own estimate of `rel_mse`.
    pub predicted_rel_mse: Option<f64>,
    /// Fraction of the intervals that contain the reference.
    pub coverage: Option<f64>,
}

/// A reference's own error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OwnError {
    /// Mean over pixels and channels.
    pub mean: f64,
    /// Standard error of that mean.
    pub mean_se: Option<f64>,
    /// Relative mean square error.
    pub rel_mse: Option<f64>,
}

/// Mean and variance of the mean of each channel.
struct Pixel {
    mean: [f64; 3],
    variance: Option<[f64; 3]>,
}

impl Reference {
    /// The mean of a film, whose pixels are independent, as a reference, with its variance.
    pub fn of(film: &Film) -> Self {
        let plane = |c: usize| film.pixels().iter().map(|p| p.mean()[c] as f32).collect();
        let known = film.pixels().iter().all(|p| p.variance_of_mean().is_some());
        let variance =
            |c: usize| film.pixels().iter().map(|p| p.variance_of_mean().map_or(0.0, |v| v[c]) as f32).collect();
        Self {
            width: film.width() as usize,
            height: film.height() as usize,
            rgb: [plane(0), plane(1), plane(2)],
            variance: known.then(|| [variance(0), variance(1), variance(2)]),
            reuses_paths: false,
        }
    }

    /// The reference as a [`Picture`].
    pub fn picture(&self) -> Picture<'_> {
        Picture {
            width: self.width,
            height: self.height,
            rgb: self.rgb.each_ref().map(Vec::as_slice),
            variance: self.variance.as_ref().map(|v| v.each_ref().map(Vec::as_slice)),
            tail: None,
            dof: f64::INFINITY,
            squares: None,
        }
    }

    fn pixel(&self, i: usize) -> Pixel {
        Pixel {
            mean: std::array::from_fn(|c| f64::from(self.rgb[c][i])),
            variance: self.variance.as_ref().map(|v| std::array::from_fn(|c| f64::from(v[c][i]))),
        }
    }

    /// Whether a pixel can be used: its values are finite.
    fn usable(&self, i: usize) -> bool {
        let pixel = self.pixel(i);
        pixel.mean.iter().chain(pixel.variance.iter().flatten()).all(|x| x.is_finite())
    }

    /// Mean radiance over usable pixels and channels.
    pub fn mean(&self) -> f64 {
        let usable = (0..self.rgb[0].len()).filter(|&i| self.usable(i));
        let (sum, count) =
            usable.fold((0.0, 0usize), |(sum, n), i| (sum + self.pixel(i).mean.iter().sum::<f64>(), n + 3));
        sum / count.max(1) as f64
    }

    /// ε of relative errors.
    fn floor(&self) -> f64 {
        (EPSILON * self.mean().powi(2)).max(f64::MIN_POSITIVE)
    }

    /// Its own error.
    pub fn own_error(&self) -> OwnError {
        let floor = self.floor();
        let mut sums = Sums::of(self, self.reuses_paths);
        for i in (0..self.rgb[0].len()).filter(|&i| self.usable(i)) {
            let r = self.pixel(i);
            sums.add(i, &r, &r, 0.0, floor);
        }
        let n = sums.count.max(1) as f64;
        let known = self.variance.is_some();
        OwnError {
            mean: sums.mean / n,
            mean_se: known.then(|| sums.mean_variance().sqrt() / n),
            rel_mse: known.then(|| sums.predicted / n),
        }
    }
}

#[derive(Default)]
struct Sums {
    /// Pixels per row.
    width: usize,
    /// Pixels along a side of the squares that are independent of one another.
    side: usize,
    /// Sum of standard deviations in each of these squares.
    deviations: Vec<f64>,
    count: usize,
    mean: f64,
    reference: f64,
    square: f64,
    relative: f64,
    predicted: f64,
    intervals: usize,
    held: usize,
}

impl Sums {
    fn of(picture: &Reference, reuses_paths: bool) -> Self {
        let (width, side) = (picture.width, if reuses_paths { 2 } else { 1 });
        let deviations = vec![0.0; width.div_ceil(side) * picture.height.div_ceil(side)];
        Self { width, side, deviations, ..Self::default() }
    }

    fn add(&mut self, i: usize, x: &Pixel, r: &Pixel, t: f64, floor: f64) {
        self.count += 3;
        let mut deviations = 0.0;
        for c in 0..3 {
            let (d, vr) = (x.mean[c] - r.mean[c], r.variance.map_or(0.0, |v| v[c]));
            let weight = 1.0 / (r.mean[c] * r.mean[c] + floor);
            self.mean += x.mean[c];
            self.reference += r.mean[c];
            self.square += d * d - vr;
            self.relative += (d * d - vr) * weight;
            if let Some(v) = x.variance {
                self.predicted += v[c] * weight;
                deviations += v[c].sqrt();
                // A channel without variance has no interval.
                if v[c] > 0.0 {
                    self.intervals += 1;
                    self.held += usize::from(d.abs() <= t * (v[c] + vr).sqrt());
                }
            }
        }
        let square = i / self.width / self.side * self.width.div_ceil(self.side) + i % self.width / self.side;
        self.deviations[square] += deviations;
    }

    /// Upper bound on the variance of the sum of means: values that share paths, such as channels,
    /// are taken as fully correlated, all others are independent.
    fn mean_variance(&self) -> f64 {
        self.deviations.iter().map(|d| d * d).sum()
    }
}

/// Compares a film with the reference. Both must have the same size. `reuses_paths`: the film's
/// pixels of each 2×2 square reused one another's paths.
pub fn measure(film: &Film, reference: &Reference, reuses_paths: bool) -> Errors {
    let floor = reference.floor();
    let dof = film.degrees_of_freedom(0);
    let known = dof > 0.0;
    let t = if known { student_t_quantile(0.5 + 0.5 * CONFIDENCE, dof) } else { 0.0 };
    let mut sums = Sums::of(reference, reuses_paths);
    for i in (0..film.pixels().len()).filter(|&i| reference.usable(i)) {
        let x = Pixel { mean: film.mean(i), variance: film.variance_of_mean(i) };
        sums.add(i, &x, &reference.pixel(i), t, floor);
    }
    let n = sums.count.max(1) as f64;
    let difference = sums.mean - sums.reference;
    Errors {
        mean: sums.mean / n,
        mean_se: known.then(|| sums.mean_variance().sqrt() / n),
        mean_error: if difference == 0.0 { 0.0 } else { difference / sums.reference },
        mse: sums.square / n,
        rel_mse: sums.relative / n,
        predicted_rel_mse: known.then(|| sums.predicted / n),
        coverage: (sums.intervals > 0).then(|| sums.held as f64 / sums.intervals as f64),
    }
}

/// Mean FLIP between a film and the reference as `display` shows them.
pub fn flip(film: &Film, reference: &Reference, display: &Display) -> f64 {
    mean_flip(&Reference::of(film).picture(), &reference.picture(), display)
}

#[cfg(test)]
mod tests {
    use surelight_film::BatchSum;

    use super::*;
    use crate::testing::normals;

    /// 64×64 pixels of value `truth`, 16 batches of deviation `noise`.
    fn film(seed: u64, truth: f64, noise: f64) -> Film {
        let mut normal = normals(seed);
        let mut film = Film::new(64, 64);
        let lanes: Vec<u32> = (0..4096).collect();
        for _ in 0..16 {
            let mut value = || BatchSum::constant(1, [(); 3].map(|()| (truth + noise * normal()) as f32));
            let sums: Vec<_> = lanes.iter().map(|_| value()).collect();
            film.add_batch(1, &lanes, &sums).unwrap();
        }
        film
    }

    #[test]
    fn the_references_own_noise_is_taken_off() {
        // Both have a variance of 0.16²·…/16 = 0.04² of the mean; the raw difference has twice as
        // much.
        let reference = Reference::of(&film(1, 2.0, 0.32));
        let errors = measure(&film(2, 2.0, 0.32), &reference, false);
        let expected: f64 = 0.08 * 0.08;
        assert!((errors.mse / expected - 1.0).abs() < 0.1, "{}", errors.mse);
        let relative = expected / (4.0 + 0.04);
        assert!((errors.rel_mse / relative - 1.0).abs() < 0.1, "{}", errors.rel_mse);
        assert!((errors.predicted_rel_mse.unwrap() / relative - 1.0).abs() < 0.05);
        assert!((reference.own_error().rel_mse.unwrap() / relative - 1.0).abs() < 0.05);
    }

    #[test]
    fn honest_intervals_cover_and_biased_ones_do_not() {
        let reference = Reference { variance: None, ..Reference::of(&film(1, 1.0, 0.0)) };
        let honest = measure(&film(3, 1.0, 0.1), &reference, false);
        // 12,288 intervals at 95 %: one standard error is 0.2 %.
        assert!((honest.coverage.unwrap() - 0.95).abs() < 0.008, "{honest:?}");
        let biased = measure(&film(4, 1.02, 0.1), &reference, false);
        assert!(biased.coverage.unwrap() < 0.92, "{biased:?}");
        assert!((biased.mean_error - 0.02).abs() < 4.0 * biased.mean_se.unwrap());
        assert!(biased.mean_error > 10.0 * biased.mean_se.unwrap());
    }

    #[test]
    fn path_reuse_may_correlate_errors() {
        let reference = Reference::of(&film(1, 1.0, 0.0));
        let film = film(3, 1.0, 0.1);
        let [apart, shared] = [false, true].map(|shares| measure(&film, &reference, shares).mean_se.unwrap());
        // Four equal deviations: 4² instead of 4 times 1².
        assert!((shared / apart - 2.0).abs() < 0.1, "{shared} against {apart}");
        let own = |reuses_paths| Reference { reuses_paths, ..Reference::of(&film) }.own_error().mean_se.unwrap();
        // Its variances are stored as f32.
        assert!((own(false) / apart - 1.0).abs() < 1e-6 && (own(true) / shared - 1.0).abs() < 1e-6);
    }

    #[test]
    fn pixels_that_are_not_finite_are_left_out() {
        let mut reference = Reference::of(&film(1, 1.0, 0.0));
        reference.rgb[1][7] = f32::NAN;
        let errors = measure(&film(1, 1.0, 0.0), &reference, false);
        assert_eq!((errors.mse, errors.mean), (0.0, 1.0));
    }

    #[test]
    fn a_black_reference_gives_numbers() {
        let black = Reference::of(&film(1, 0.0, 0.0));
        let errors = measure(&film(1, 0.0, 0.0), &black, false);
        assert_eq!((errors.mean_error, errors.rel_mse), (0.0, 0.0));
    }
}
