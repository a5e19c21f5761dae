//! Compares two pictures: metrics of their distance, and a statistical verdict where both have
//! error estimates.
//!
//! A metric cannot separate noise from bias; [`Verdict`] can. FLIP is for people: it hides bias.

mod evidence;
mod flip;
mod heat;
mod metrics;
mod verdict;

pub use flip::{flip, mean_flip};
pub use heat::{heat_color, heat_map};
pub use metrics::Metrics;
pub use verdict::{Outcome, Tile, Verdict};

use crate::{Display, ExrImage, Metadata};

/// Two pictures that cannot be compared.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CompareError {
    /// Different sizes.
    #[error("the images differ in size: {}x{} and {}x{} pixels", a[0], a[1], b[0], b[1])]
    Size {
        /// Width and height of the first.
        a: [usize; 2],
        /// Width and height of the second.
        b: [usize; 2],
    },
    /// Different places in the picture, as of two crops.
    #[error("the images show different parts of the picture: they begin at {},{} and {},{}", a[0], a[1], b[0], b[1])]
    Position {
        /// First pixel of the first.
        a: [i32; 2],
        /// First pixel of the second.
        b: [i32; 2],
    },
    /// No channels that are a picture.
    #[error("{0} has no R, G, B channels that are clearly the picture")]
    NoPicture(&'static str),
    /// Nothing to compare.
    #[error("no pixel has a finite value in both images")]
    NoPixels,
}

/// A picture with, perhaps, the variance of each pixel's mean. Planes are red, green, blue, row 0
/// at the top.
#[derive(Debug, Clone, Copy)]
pub struct Picture<'a> {
    /// Pixels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Mean radiance, linear Rec. 709.
    pub rgb: [&'a [f32]; 3],
    /// Variance of the mean (radiance squared); infinite where unknown.
    pub variance: Option<[&'a [f32]; 3]>,
    /// Share of a pixel's squared deviations that its largest sample makes, 0 to 1
    /// ([`crate::Certificate`]); `None` where it is not known.
    pub tail: Option<&'a [f32]>,
    /// Degrees of freedom of the variances; infinite where they are well known.
    pub dof: f64,
    /// Where the pixels of each 2×2 square share paths, so that their errors depend on one another:
    /// the place of the first pixel in its square.
    pub squares: Option<[usize; 2]>,
}

impl<'a> Picture<'a> {
    /// The picture of an EXR. Its variance is the file's own `Variance` layer, with one degree of
    /// freedom less than the batches of its metadata; else that of `variance`, a file whose picture
    /// is the variance, taken as exact.
    ///
    /// # Errors
    /// Where a file holds no picture, or the variance has another size.
    pub fn of(image: &'a ExrImage, variance: Option<&'a ExrImage>) -> Result<Self, CompareError> {
        let rgb = image.rgb("").ok_or(CompareError::NoPicture("the image"))?;
        let (width, height) = (image.width, image.height);
        let metadata = image.surelight_metadata();
        let shares = metadata.as_ref().is_some_and(Metadata::reuses_paths);
        let squares = shares.then(|| image.position.map(|at| at.rem_euclid(2) as usize));
        if let Some(file) = variance {
            if (file.width, file.height) != (width, height) {
                return Err(CompareError::Size { a: [width, height], b: [file.width, file.height] });
            }
            let variance = file.rgb("").ok_or(CompareError::NoPicture("the variance"))?;
            return Ok(Self { width, height, rgb, variance: Some(variance), tail: None, dof: f64::INFINITY, squares });
        }
        let batches = metadata.map_or(0, |metadata| metadata.batches);
        // Another program's layer of that name may hold anything, such as the variance of one
        // sample.
        let variance = image.rgb("Variance").filter(|_| batches >= 2);
        let tail = variance.and_then(|_| image.channels.get("Tail.K")).map(Vec::as_slice);
        Ok(Self { width, height, rgb, variance, tail, dof: f64::from(batches) - 1.0, squares })
    }

    fn pixel(&self, i: usize) -> [f64; 3] {
        self.rgb.map(|plane| f64::from(plane[i]))
    }

    fn pixel_variance(&self, i: usize) -> Option<[f64; 3]> {
        self.variance.map(|planes| planes.map(|plane| f64::from(plane[i])))
    }

    /// By how much one sample may change the sum of some pixels, which share paths if any do.
    ///
    /// With squared deviations D of a pixel's n samples, the largest of them is √(tail · D) from
    /// the mean, and changes it by √(tail · D)/n: by √tail standard errors of the mean.
    fn jump_of_sum(&self, channel: usize, pixels: &[usize]) -> f64 {
        let (Some(tail), Some(variance)) = (self.tail, self.variance) else {
            return 0.0;
        };
        let jumps = pixels.iter().map(|&i| {
            // A share that is none may be any.
            let tail = if (0.0..=1.0).contains(&tail[i]) { tail[i] } else { 1.0 };
            (f64::from(tail) * f64::from(variance[channel][i])).sqrt()
        });
        if self.squares.is_some() { jumps.sum() } else { jumps.fold(0.0, f64::max) }
    }
}

/// Differences of this many units in the last place of an f32 are rounding, not bias.
const ULPS: f64 = 4.0;

/// The part of a − b that rounding to f32 cannot explain, with its sign.
fn beyond_rounding(a: f64, b: f64) -> f64 {
    let difference = a - b;
    if !difference.is_finite() {
        return difference;
    }
    let rounding = ULPS * f64::from(f32::EPSILON) * a.abs().max(b.abs());
    (difference.abs() - rounding).max(0.0).copysign(difference)
}

/// How to compare.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompareOptions {
    /// Probability of calling equal pictures different.
    pub alpha: f64,
    /// Side of the tiles that are tested on their own, in pixels.
    pub tile: usize,
    /// The display mapping of the pictures for FLIP.
    pub display: Display,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { alpha: 0.01, tile: 16, display: Display::default() }
    }
}

/// Result of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// How far apart the pictures are.
    pub metrics: Metrics,
    /// Mean LDR-FLIP of the displayed pictures, 0 to 1.
    pub flip: f64,
    /// Whether they differ by more than their errors explain; `None` where one has no error
    /// estimate.
    pub verdict: Option<Verdict>,
    /// Pixels left out because a value or variance is not finite.
    pub skipped: usize,
}

/// Compares picture `a` with picture `b`, the reference: relative figures are relative to `b`.
///
/// # Errors
/// Where the pictures differ in size or have no finite pixel in common.
pub fn compare(a: &Picture, b: &Picture, options: &CompareOptions) -> Result<Comparison, CompareError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(CompareError::Size { a: [a.width, a.height], b: [b.width, b.height] });
    }
    let finite = |values: Option<[f64; 3]>| values.is_none_or(|v| v.iter().all(|x| x.is_finite()));
    let usable: Vec<bool> = (0..a.width * a.height)
        .map(|i| {
            finite(Some(a.pixel(i)))
                && finite(Some(b.pixel(i)))
                && finite(a.pixel_variance(i))
                && finite(b.pixel_variance(i))
        })
        .collect();
    let skipped = usable.iter().filter(|usable| !**usable).count();
    let metrics = metrics::measure(a, b, &usable).ok_or(CompareError::NoPixels)?;
    let verdict = verdict::judge(a, b, &usable, options);
    Ok(Comparison { metrics, flip: mean_flip(a, b, &options.display), verdict, skipped })
}

/// Compares two EXR files already read: see [`Picture::of`] and [`compare`].
///
/// # Errors
/// As those two, and where the files hold different parts of a picture.
pub fn compare_exr(a: &ExrImage, b: &ExrImage, options: &CompareOptions) -> Result<Comparison, CompareError> {
    if a.position != b.position {
        return Err(CompareError::Position { a: a.position, b: b.position });
    }
    compare(&Picture::of(a, None)?, &Picture::of(b, None)?, options)
}

#[cfg(test)]
pub(crate) mod testing {
    use super::Picture;
    use crate::{BatchSum, Film};

    /// Planes of a picture made by a test.
    pub(crate) struct Planes {
        pub(crate) width: usize,
        pub(crate) rgb: [Vec<f32>; 3],
        pub(crate) variance: Option<[Vec<f32>; 3]>,
        pub(crate) tail: Option<Vec<f32>>,
        pub(crate) squares: Option<[usize; 2]>,
    }

    impl Planes {
        pub(crate) fn new(width: usize, height: usize, value: impl Fn(usize, usize) -> [f32; 3]) -> Self {
            let plane = |c: usize| (0..width * height).map(|i| value(i % width, i / width)[c]).collect();
            Self { width, rgb: [plane(0), plane(1), plane(2)], variance: None, tail: None, squares: None }
        }

        pub(crate) fn picture(&self) -> Picture<'_> {
            Picture {
                width: self.width,
                height: self.rgb[0].len() / self.width,
                rgb: self.rgb.each_ref().map(Vec::as_slice),
                variance: self.variance.as_ref().map(|planes| planes.each_ref().map(Vec::as_slice)),
                tail: self.tail.as_deref(),
                dof: 15.0,
                squares: self.squares,
            }
        }
    }

    /// Uniform numbers above 0 and below 1 from a seed.
    fn uniforms(seed: u64) -> impl FnMut() -> f64 {
        // SplitMix64; seeds are mixed first, or neighbouring ones would share their sequence but
        // for one number.
        let mix = |state: u64| {
            let z = (state ^ (state >> 30)).wrapping_mul(0xbf58476d1ce4e5b9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94d049bb133111eb);
            z ^ (z >> 31)
        };
        let mut state = mix(seed + 1);
        move || {
            state = state.wrapping_add(0x9e3779b97f4a7c15);
            ((mix(state) >> 12) as f64 + 0.5) / (1u64 << 52) as f64
        }
    }

    /// Standard normal numbers from a seed.
    pub(crate) fn normals(seed: u64) -> impl FnMut() -> f64 {
        let mut uniform = uniforms(seed);
        move || (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos()
    }

    /// A render of `truth` with 16 batches per pixel of relative deviation `noise` (of the mean).
    pub(crate) fn render(size: usize, seed: u64, noise: f64, truth: impl Fn(usize, usize) -> f64) -> Planes {
        let mut normal = normals(seed);
        let mut planes = Planes::new(size, size, |x, y| [truth(x, y) as f32; 3]);
        let mut variance = [(); 3].map(|()| vec![0.0; size * size]);
        for (values, variances) in planes.rgb.iter_mut().zip(&mut variance) {
            for (value, variance) in values.iter_mut().zip(variances) {
                let batches: Vec<f64> = (0..16).map(|_| f64::from(*value) * (1.0 + 4.0 * noise * normal())).collect();
                let mean = batches.iter().sum::<f64>() / 16.0;
                *value = mean as f32;
                *variance = (batches.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 240.0) as f32;
            }
        }
        planes.variance = Some(variance);
        planes
    }

    /// A film's picture, with its variances and tails.
    fn planes_of(film: &Film, size: usize) -> Planes {
        let value = |i: usize| film.mean(i).map(|x| x as f32);
        let mut planes = Planes::new(size, size, |x, y| value(y * size + x));
        let variance = |c: usize| (0..size * size).map(|i| film.variance_of_mean(i).unwrap()[c] as f32).collect();
        planes.variance = Some(std::array::from_fn(variance));
        planes.tail = Some(film.certify().tail);
        planes
    }

    /// How bright the events of [`rare`] are.
    #[derive(Clone, Copy)]
    pub(crate) enum Events {
        /// One like the other.
        Equal,
        /// By Pareto's law of this index: below 2 they have no variance.
        Pareto(f64),
    }

    /// A render of a grey picture of radiance 1 with 256 samples per pixel, a `share` of it from
    /// rare, bright samples: `events` in a tile of 256 pixels on average.
    pub(crate) fn rare(size: usize, seed: u64, share: f64, a_tile: f64, events: Events) -> Planes {
        const SAMPLES: f64 = 16.0;
        let mut normal = normals(seed);
        let mut uniform = uniforms(seed + (1 << 32));
        let each = share * 256.0 * 256.0 / a_tile;
        let per_batch = a_tile * SAMPLES / 256.0 / 256.0;
        let even = 1.0 - share;
        let lanes: Vec<u32> = (0..(size * size) as u32).collect();
        let mut film = Film::new(size as u32, size as u32);
        for _ in 0..16 {
            let batch = |_: &u32| {
                let mut sum = even * (SAMPLES + 0.1 * SAMPLES.sqrt() * normal());
                let mut squares = 1.01 * SAMPLES * even * even;
                let mut largest = 1.2 * even;
                let mut left = uniform();
                // Poisson: events while a product of uniform numbers stays above e^(−mean).
                while a_tile > 0.0 && left > (-per_batch).exp() {
                    let event = match events {
                        Events::Equal => each,
                        Events::Pareto(index) => each * (index - 1.0) / index * uniform().powf(-1.0 / index),
                    };
                    sum += event;
                    squares += (even + event).powi(2);
                    largest = largest.max(even + event);
                    left *= uniform();
                }
                BatchSum::new([sum as f32; 3], largest as f32, squares as f32)
            };
            let sums: Vec<BatchSum> = lanes.iter().map(batch).collect();
            film.add_batch(SAMPLES as u32, &lanes, &sums).unwrap();
        }
        planes_of(&film, size)
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{Planes, render};
    use super::*;
    use crate::{BatchSum, Film, Metadata};

    #[test]
    fn files_of_one_scene_agree_and_a_brighter_one_does_not() {
        let folder = tempfile::tempdir().unwrap();
        let image = |name: &str, seed: u64, gain: f64| {
            let mut normal = testing::normals(seed);
            let mut film = Film::new(32, 32);
            let lanes: Vec<u32> = (0..1024).collect();
            for _ in 0..16 {
                let sums: Vec<_> = (0..1024)
                    .map(|_| BatchSum::constant(8, [(); 3].map(|()| (gain * (1.0 + 0.2 * normal())) as f32)))
                    .collect();
                film.add_batch(8, &lanes, &sums).unwrap();
            }
            let path = folder.path().join(name);
            crate::write_exr(&path, &film, &Metadata { batches: 16, ..Metadata::default() }).unwrap();
            crate::read_exr(&path).unwrap()
        };
        let (a, b, brighter) = (image("a.exr", 1, 1.0), image("b.exr", 2, 1.0), image("c.exr", 3, 1.02));
        let options = CompareOptions::default();
        let same = compare_exr(&a, &b, &options).unwrap();
        assert!(!same.verdict.unwrap().differs() && same.skipped == 0);
        let other = compare_exr(&a, &brighter, &options).unwrap();
        assert!(other.verdict.unwrap().differs());
        assert!((other.metrics.mean_relative + 0.0196).abs() < 4.0 * other.metrics.mean_relative_error);
    }

    #[test]
    fn without_variance_there_is_no_verdict() {
        let flat = Planes::new(4, 4, |_, _| [1.0; 3]);
        let comparison = compare(&flat.picture(), &render(4, 1, 0.1, |_, _| 1.0).picture(), &CompareOptions::default());
        assert_eq!(comparison.unwrap().verdict, None);
    }

    #[test]
    fn another_programs_variance_layer_is_not_trusted() {
        let mut image = ExrImage { width: 1, height: 1, ..ExrImage::default() };
        for name in ["R", "G", "B", "Variance.R", "Variance.G", "Variance.B"] {
            image.channels.insert(name.into(), vec![1.0]);
        }
        assert!(Picture::of(&image, None).unwrap().variance.is_none());
        let given = Picture::of(&image, Some(&image)).unwrap();
        assert!(given.variance.is_some() && given.dof == f64::INFINITY);
        image.metadata = Some("{\"batches\":16}".into());
        assert_eq!(Picture::of(&image, None).unwrap().dof, 15.0);
    }

    #[test]
    fn mismatched_pictures_are_reported() {
        let (small, large) = (Planes::new(2, 2, |_, _| [1.0; 3]), Planes::new(4, 1, |_, _| [1.0; 3]));
        let options = CompareOptions::default();
        assert!(matches!(compare(&small.picture(), &large.picture(), &options), Err(CompareError::Size { .. })));
        let bad = Planes::new(2, 2, |_, _| [f32::NAN; 3]);
        assert_eq!(compare(&small.picture(), &bad.picture(), &options), Err(CompareError::NoPixels));
        let one = Planes::new(2, 2, |x, y| if x + y == 0 { [f32::INFINITY; 3] } else { [1.0; 3] });
        assert_eq!(compare(&small.picture(), &one.picture(), &options).unwrap().skipped, 1);
    }
}
