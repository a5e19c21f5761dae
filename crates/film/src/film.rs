//! The image as totals of batches.

use rayon::prelude::*;

use crate::{BatchSum, DoubleDouble, FilmError, PixelMoments};

/// Features of the first hit of each pixel, for denoisers and compositing. One entry per pixel.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Features {
    /// Albedo of the surface, linear Rec. 709.
    pub albedo: Vec<[f32; 3]>,
    /// Shading normal in world space; zero where nothing is hit.
    pub normal: Vec<[f32; 3]>,
    /// Distance along the ray in metres; zero where nothing is hit.
    pub depth: Vec<f32>,
}

/// A rectangle of pixels within an image: all of it, or a crop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// Pixels a row and rows of the whole image.
    pub whole: [u32; 2],
    /// The position of the rectangle's first pixel in it.
    pub corner: [u32; 2],
    /// Pixels a row and rows of the rectangle.
    pub size: [u32; 2],
}

impl Window {
    /// All of an image.
    pub fn all(width: u32, height: u32) -> Self {
        Self { whole: [width, height], corner: [0; 2], size: [width, height] }
    }

    /// The rectangle x0, y0, x1, y1 of an image, x1 and y1 outside; `None` where it is empty or
    /// reaches beyond.
    pub fn crop(whole: [u32; 2], [x0, y0, x1, y1]: [u32; 4]) -> Option<Self> {
        let inside = x0 < x1 && y0 < y1 && x1 <= whole[0] && y1 <= whole[1];
        inside.then(|| Self { whole, corner: [x0, y0], size: [x1 - x0, y1 - y0] })
    }

    /// Whether it is the whole image.
    pub fn is_all(&self) -> bool {
        self.size == self.whole
    }

    /// The rectangle as x0, y0, x1, y1, with x1 and y1 outside.
    pub fn edges(&self) -> [u32; 4] {
        let [[x, y], [width, height]] = [self.corner, self.size];
        [x, y, x + width, y + height]
    }

    /// Pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.size[0]) * u64::from(self.size[1])
    }

    /// Whether another rectangle of the same image lies within.
    pub fn contains(&self, other: &Self) -> bool {
        let ([x0, y0, x1, y1], [u0, v0, u1, v1]) = (self.edges(), other.edges());
        self.whole == other.whole && x0 <= u0 && y0 <= v0 && u1 <= x1 && v1 <= y1
    }
}

/// An image, or a crop of one, whose every pixel holds mean, variance of the mean and sample count.
#[derive(Debug, Clone)]
pub struct Film {
    window: Window,
    pixels: Vec<PixelMoments>,
    /// Sum of the coverage of each pixel's samples, where it is counted.
    coverage: Option<Vec<DoubleDouble>>,
    features: Option<Features>,
    refused: u64,
    /// Scratch of `add_batch`: the lane that holds each pixel.
    lane_of_pixel: Vec<u32>,
}

/// Entry of `pixel_of_lane` and `lane_of_pixel` that names nothing.
const NONE: u32 = u32::MAX;

impl Film {
    /// An empty film. A pixel takes 188 bytes, 16 more with coverage.
    pub fn new(width: u32, height: u32) -> Self {
        Self::of_window(Window::all(width, height))
    }

    /// An empty film of a crop. Its pixels are counted within the crop.
    pub fn of_window(window: Window) -> Self {
        let count = window.size[0] as usize * window.size[1] as usize;
        Self {
            window,
            pixels: vec![PixelMoments::default(); count],
            coverage: None,
            features: None,
            refused: 0,
            lane_of_pixel: vec![NONE; count],
        }
    }

    /// Pixels a row.
    pub fn width(&self) -> u32 {
        self.window.size[0]
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.window.size[1]
    }

    /// Which part of the image it is.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Adds one batch: an independent estimate of some pixels, of `samples` samples each.
    ///
    /// `pixel_of_lane` names the pixel of each lane (`u32::MAX`: none), and `sums` holds the sum of
    /// the lane's samples. Each pixel may appear once. Returns the number of lanes refused because
    /// a sum was not finite; they are added to [`Self::refused`].
    ///
    /// # Errors
    /// Where the batch does not fit the film. The film is then unchanged.
    pub fn add_batch(&mut self, samples: u32, pixel_of_lane: &[u32], sums: &[BatchSum]) -> Result<u64, FilmError> {
        if samples == 0 {
            return Err(FilmError::NoSamples);
        }
        self.add_uneven_batch(|_, _| samples, pixel_of_lane, sums)
    }

    /// Like [`Self::add_batch`], with different numbers of samples per pixel, as a function of the
    /// position (x, y) in the whole image. A pixel with 0 samples is unchanged. Of each pixel,
    /// means and variances hold if its batches are independent estimates, whatever its numbers are.
    ///
    /// # Errors
    /// Where the batch does not fit the film. The film is then unchanged.
    pub fn add_uneven_batch(
        &mut self,
        samples: impl Fn(u32, u32) -> u32 + Sync,
        pixel_of_lane: &[u32],
        sums: &[BatchSum],
    ) -> Result<u64, FilmError> {
        self.add(samples, pixel_of_lane, sums, None)
    }

    /// Like [`Self::add_uneven_batch`], with the sum of the coverage of each lane's samples: 0 to
    /// their number. From then on the film has coverage ([`Self::coverage`]), and its radiance is
    /// premultiplied by it.
    ///
    /// # Errors
    /// Where the batch does not fit the film. The film is then unchanged.
    pub fn add_covered_batch(
        &mut self,
        samples: impl Fn(u32, u32) -> u32 + Sync,
        pixel_of_lane: &[u32],
        sums: &[BatchSum],
        coverage: &[f32],
    ) -> Result<u64, FilmError> {
        self.add(samples, pixel_of_lane, sums, Some(coverage))
    }

    fn add(
        &mut self,
        samples: impl Fn(u32, u32) -> u32 + Sync,
        pixel_of_lane: &[u32],
        sums: &[BatchSum],
        coverage: Option<&[f32]>,
    ) -> Result<u64, FilmError> {
        for found in [sums.len(), coverage.map_or(sums.len(), <[f32]>::len)] {
            if pixel_of_lane.len() != found {
                return Err(FilmError::LaneCount { lanes: pixel_of_lane.len(), sums: found });
            }
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
        let Window { corner: [left, top], size: [width, _], .. } = self.window;
        let samples = |pixel: usize| samples(left + pixel as u32 % width, top + pixel as u32 / width);
        let is_good = |lane: usize| sums[lane].is_finite() && coverage.is_none_or(|covered| covered[lane].is_finite());
        if let Some(covered) = coverage {
            let totals = self.coverage.get_or_insert_with(|| vec![DoubleDouble::default(); pixels]);
            totals.par_iter_mut().zip(&self.lane_of_pixel).enumerate().with_min_len(4096).for_each(
                |(pixel, (total, &lane))| {
                    if lane != NONE && samples(pixel) > 0 && is_good(lane as usize) {
                        total.add_f64(covered[lane as usize].into());
                    }
                },
            );
        }
        let refused = self
            .pixels
            .par_iter_mut()
            .zip(&self.lane_of_pixel)
            .enumerate()
            .with_min_len(4096)
            .map(|(pixel, (moments, &lane))| {
                if lane == NONE {
                    return 0;
                }
                let (samples, lane) = (samples(pixel), lane as usize);
                u64::from(samples > 0 && !(is_good(lane) && moments.add_batch(samples, &sums[lane])))
            })
            .sum();
        self.refused += refused;
        Ok(refused)
    }

    /// Adds the batches of another part of the same render: of the same pixels or of a crop that
    /// lies within. Features are taken over where the other has some.
    ///
    /// # Errors
    /// Where the other does not lie within this film, which is then unchanged.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        if !self.window.contains(&other.window) {
            return Err(FilmError::Outside { inner: other.window.edges(), outer: self.window.edges() });
        }
        let (row, width) = (self.width() as usize, other.width() as usize);
        let [x, y] = [0, 1].map(|axis| (other.window.corner[axis] - self.window.corner[axis]) as usize);
        let rows = y * row..(y + other.height() as usize) * row;
        self.pixels[rows.clone()].par_chunks_mut(row.max(1)).zip(other.pixels.par_chunks(width.max(1))).for_each(
            |(mine, theirs)| mine[x..x + width].iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.merge(theirs)),
        );
        self.refused += other.refused;
        let count = self.pixels.len();
        if let Some(theirs) = &other.coverage {
            let mine = self.coverage.get_or_insert_with(|| vec![DoubleDouble::default(); count]);
            mine[rows.clone()].par_chunks_mut(row.max(1)).zip(theirs.par_chunks(width.max(1))).for_each(
                |(mine, theirs)| mine[x..x + width].iter_mut().zip(theirs).for_each(|(mine, theirs)| mine.add(*theirs)),
            );
        }
        if let Some(theirs) = &other.features {
            let mine = self.features.get_or_insert_with(|| Features {
                albedo: vec![[0.0; 3]; count],
                normal: vec![[0.0; 3]; count],
                depth: vec![0.0; count],
            });
            for (i, start) in rows.step_by(row.max(1)).enumerate() {
                let (to, from) = (start + x..start + x + width, i * width..(i + 1) * width);
                mine.albedo[to.clone()].copy_from_slice(&theirs.albedo[from.clone()]);
                mine.normal[to.clone()].copy_from_slice(&theirs.normal[from.clone()]);
                mine.depth[to].copy_from_slice(&theirs.depth[from]);
            }
        }
        Ok(())
    }

    /// A film from the totals of its pixels, as a file gives them back.
    pub(crate) fn from_pixels(window: Window, pixels: Vec<PixelMoments>, coverage: Option<Vec<DoubleDouble>>) -> Self {
        let lane_of_pixel = vec![NONE; pixels.len()];
        Self { window, pixels, coverage, features: None, refused: 0, lane_of_pixel }
    }

    /// Sums of the coverage of the pixels' samples, where it is counted.
    pub(crate) fn coverage_sums(&self) -> Option<&[DoubleDouble]> {
        self.coverage.as_deref()
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

    /// Whether coverage is counted: the environment does not show, and radiance is premultiplied.
    pub fn has_coverage(&self) -> bool {
        self.coverage.is_some()
    }

    /// Coverage of pixel `i`, 0 to 1: the share of its samples that hit something other than the
    /// environment, where that is recorded; 1 where it is not, since then the environment is part
    /// of the picture. Panics where there is no such pixel, like indexing a slice.
    pub fn coverage(&self, i: usize) -> f64 {
        let samples = self.pixels[i].samples();
        match &self.coverage {
            None => 1.0,
            Some(_) if samples == 0 => 0.0,
            Some(sums) => sums[i].over_f64(samples as f64).to_f64().clamp(0.0, 1.0),
        }
    }

    /// Mean radiance of pixel `i`. Panics where there is no such pixel, like indexing a slice.
    pub fn mean(&self, i: usize) -> [f64; 3] {
        self.pixels[i].mean()
    }

    /// Variance of the mean of pixel `i`, `None` below two batches. Panics where there is no such
    /// pixel.
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
    fn pixels_may_have_different_numbers_of_samples() {
        let mut film = Film::of_window(Window::crop([5, 4], [3, 1, 5, 3]).unwrap());
        let samples = |x: u32, y: u32| 2 * (x - 3) + 4 * (y - 1);
        let sums: Vec<_> = [0, 1, 2, 3].map(|i| BatchSum::constant(2 * i, [3.0; 3])).into();
        assert_eq!(film.add_uneven_batch(samples, &[0, 1, 2, 3], &sums), Ok(0));
        assert_eq!([0, 1, 2, 3].map(|i| film.samples(i)), [0, 2, 4, 6]);
        assert_eq!([1, 2, 3].map(|i| film.mean(i)[0]), [3.0; 3]);
        assert_eq!(
            film.add_uneven_batch(samples, &[0, 1], &[sums[0]; 1]),
            Err(FilmError::LaneCount { lanes: 2, sums: 1 })
        );
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
    fn merge_needs_a_part_of_the_same_image() {
        let mut film = Film::new(2, 1);
        assert!(film.merge(&Film::new(1, 2)).is_err());
        let mut other = Film::new(2, 1);
        other.add_batch(2, &[0], &[BatchSum::constant(2, [2.0; 3])]).unwrap();
        film.merge(&other).unwrap();
        assert_eq!(film.mean(0), [2.0; 3]);
    }

    #[test]
    fn crops_find_their_place() {
        let grey = |g: u32| BatchSum::constant(2, [g as f32; 3]);
        let whole = [4, 3];
        let mut film = Film::new(4, 3);
        for (edges, first) in [([0, 0, 4, 1], 0), ([0, 1, 1, 3], 10), ([1, 1, 4, 3], 20)] {
            let window = Window::crop(whole, edges).unwrap();
            let mut part = Film::of_window(window);
            let count = window.area() as u32;
            let lanes: Vec<u32> = (0..count).collect();
            let sums: Vec<_> = (0..count).map(|i| grey(first + i)).collect();
            part.add_batch(2, &lanes, &sums).unwrap();
            let depth: Vec<f32> = (0..count).map(|i| (first + i) as f32).collect();
            let zeros = vec![[0.0; 3]; count as usize];
            part.set_features(Features { albedo: zeros.clone(), normal: zeros, depth }).unwrap();
            film.merge(&part).unwrap();
        }
        let expected = [0.0, 1.0, 2.0, 3.0, 10.0, 20.0, 21.0, 22.0, 11.0, 23.0, 24.0, 25.0];
        let found: Vec<f64> = (0..12).map(|i| film.mean(i)[0]).collect();
        assert_eq!(found, expected);
        assert_eq!(film.features().unwrap().depth, expected.map(|x| x as f32));
    }

    #[test]
    fn crops_lie_within_their_image() {
        for wrong in [[0, 0, 0, 1], [2, 0, 1, 1], [0, 0, 4, 1], [0, 2, 1, 3], [0, 0, u32::MAX, 1]] {
            assert_eq!(Window::crop([3, 2], wrong), None, "{wrong:?}");
        }
        assert!(Window::crop([3, 2], [0, 0, 3, 2]).unwrap().is_all());
    }
}
