//! The image as totals of batches.

use rayon::prelude::*;

use crate::{BatchSum, FilmError, PixelMoments};

/// What the first hit of each pixel shows, for denoisers and compositing. One entry a pixel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Features {
    /// Albedo of the surface, linear Rec. 709.
    pub albedo: Vec<[f32; 3]>,
    /// Shading normal in world space; zero where nothing is hit.
    pub normal: Vec<[f32; 3]>,
    /// Distance along the ray in metres; zero where nothing is hit.
    pub depth: Vec<f32>,
}

/// An image whose every pixel holds mean, variance of the mean and sample count.
#[derive(Debug, Clone)]
pub struct Film {
    width: u32,
    height: u32,
    pixels: Vec<PixelMoments>,
    features: Option<Features>,
    refused: u64,
    /// Scratch of `add_batch`: the lane that holds each pixel.
    lane_of_pixel: Vec<u32>,
}

/// Entry of `pixel_of_lane` and `lane_of_pixel` that names nothing.
const NONE: u32 = u32::MAX;

impl Film {
    /// An empty film. A pixel takes 188 bytes.
    pub fn new(width: u32, height: u32) -> Self {
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            pixels: vec![PixelMoments::default(); count],
            features: None,
            refused: 0,
            lane_of_pixel: vec![NONE; count],
        }
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Adds one batch: an independent estimate of some pixels, of `samples` samples each.
    ///
    /// `pixel_of_lane` names the pixel of each lane (`u32::MAX`: none), and `sums` holds what
    /// the lane's samples add up to. Each pixel may appear once.
    /// Returns the number of lanes refused because a sum was not finite; they count in [`Self::refused`].
    ///
    /// # Errors
    /// Where the batch does not fit the film. The film is then unchanged.
    pub fn add_batch(&mut self, samples: u32, pixel_of_lane: &[u32], sums: &[BatchSum]) -> Result<u64, FilmError> {
        if samples == 0 {
            return Err(FilmError::NoSamples);
        }
        if pixel_of_lane.len() != sums.len() {
            return Err(FilmError::LaneCount { lanes: pixel_of_lane.len(), sums: sums.len() });
        }
        // Turning the table round makes the pass over pixels parallel without any sharing.
        self.lane_of_pixel.fill(NONE);
        let pixels = self.pixels.len();
        for (lane, &pixel) in pixel_of_lane.iter().enumerate() {
            if pixel == NONE {
                continue;
            }
            let entry =
                self.lane_of_pixel.get_mut(pixel as usize).ok_or(FilmError::PixelOutOfRange { lane, pixel, pixels })?;
            if *entry != NONE {
                return Err(FilmError::PixelTwice { pixel });
            }
            *entry = lane as u32;
        }
        let refused = self
            .pixels
            .par_iter_mut()
            .zip(&self.lane_of_pixel)
            .with_min_len(4096)
            .map(|(moments, &lane)| {
                if lane == NONE {
                    return 0;
                }
                u64::from(!moments.add_batch(samples, &sums[lane as usize]))
            })
            .sum();
        self.refused += refused;
        Ok(refused)
    }

    /// Adds the batches of another part of the same render. Features are taken where this film has none.
    ///
    /// # Errors
    /// Where the sizes differ. The film is then unchanged.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(FilmError::Size { what: "other", found: other.pixels.len(), expected: self.pixels.len() });
        }
        self.pixels.par_iter_mut().zip(&other.pixels).for_each(|(mine, theirs)| mine.merge(theirs));
        self.refused += other.refused;
        if self.features.is_none() {
            self.features.clone_from(&other.features);
        }
        Ok(())
    }

    /// Sets albedo, normal and depth of the first hits.
    ///
    /// # Errors
    /// Where an image has another number of pixels than the film.
    pub fn set_features(&mut self, features: Features) -> Result<(), FilmError> {
        let expected = self.pixels.len();
        let sizes =
            [("albedo", features.albedo.len()), ("normal", features.normal.len()), ("depth", features.depth.len())];
        if let Some((what, found)) = sizes.into_iter().find(|&(_, found)| found != expected) {
            return Err(FilmError::Size { what, found, expected });
        }
        self.features = Some(features);
        Ok(())
    }

    /// The features, where set.
    pub fn features(&self) -> Option<&Features> {
        self.features.as_ref()
    }

    /// Totals of all pixels, row 0 at the top.
    pub fn pixels(&self) -> &[PixelMoments] {
        &self.pixels
    }

    /// Mean radiance of pixel `i`. Panics where there is no such pixel, like indexing a slice.
    pub fn mean(&self, i: usize) -> [f64; 3] {
        self.pixels[i].mean()
    }

    /// Variance of the mean of pixel `i`, `None` below two batches. Panics where there is no such pixel.
    pub fn variance_of_mean(&self, i: usize) -> Option<[f64; 3]> {
        self.pixels[i].variance_of_mean()
    }

    /// Samples of pixel `i`. Panics where there is no such pixel.
    pub fn samples(&self, i: usize) -> u64 {
        self.pixels[i].samples()
    }

    /// Degrees of freedom of the variance of pixel `i`: batches − 1 for equal batches.
    /// Panics where there is no such pixel.
    pub fn degrees_of_freedom(&self, i: usize) -> f64 {
        self.pixels[i].degrees_of_freedom()
    }

    /// Batches of single pixels refused because they were not finite.
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_reach_their_pixels() {
        let mut film = Film::new(2, 2);
        let sums: Vec<_> = (0..5).map(|i| BatchSum::constant(4, [i as f32, 1.0, 2.0])).collect();
        assert_eq!(film.add_batch(4, &[3, u32::MAX, 0, 1, 2], &sums), Ok(0));
        let red: Vec<_> = (0..4).map(|i| film.mean(i)[0]).collect();
        assert_eq!(red, [2.0, 3.0, 4.0, 0.0]);
        assert_eq!(film.samples(0), 4);
    }

    #[test]
    fn bad_batches_leave_the_film_as_it_was() {
        let mut film = Film::new(2, 1);
        let sum = BatchSum::constant(1, [1.0; 3]);
        assert_eq!(film.add_batch(0, &[], &[]), Err(FilmError::NoSamples));
        assert_eq!(film.add_batch(1, &[0], &[]), Err(FilmError::LaneCount { lanes: 1, sums: 0 }));
        assert_eq!(film.add_batch(1, &[1, 1], &[sum; 2]), Err(FilmError::PixelTwice { pixel: 1 }));
        assert_eq!(
            film.add_batch(1, &[0, 2], &[sum; 2]),
            Err(FilmError::PixelOutOfRange { lane: 1, pixel: 2, pixels: 2 })
        );
        assert_eq!(film.samples(0) + film.samples(1), 0);
    }

    #[test]
    fn a_bad_lane_is_counted_and_its_neighbour_unharmed() {
        let mut film = Film::new(2, 1);
        assert_eq!(film.add_batch(1, &[0, 1], &[f32::NAN, 1.0].map(|c| BatchSum::constant(1, [c; 3]))), Ok(1));
        assert_eq!(film.refused(), 1);
        assert_eq!((film.samples(0), film.samples(1)), (0, 1));
        assert_eq!(film.mean(1), [1.0; 3]);
    }

    #[test]
    fn features_must_fit() {
        let mut film = Film::new(2, 1);
        let features = Features { albedo: vec![[0.5; 3]; 2], normal: vec![[0.0, 1.0, 0.0]; 2], depth: vec![1.0] };
        assert!(film.set_features(features).is_err());
        assert!(film.features().is_none());
    }

    #[test]
    fn merge_needs_the_same_size() {
        let mut film = Film::new(2, 1);
        assert!(film.merge(&Film::new(1, 2)).is_err());
        let mut other = Film::new(2, 1);
        other.add_batch(2, &[0], &[BatchSum::constant(2, [2.0; 3])]).unwrap();
        film.merge(&other).unwrap();
        assert_eq!(film.mean(0), [2.0; 3]);
    }
}
