//! Sums of batches of one pixel, wide enough that neither their order nor their number matters.
//!
//! A batch b is an independent estimate from n_b samples, with sum s_b. From
//! N = Σ n_b, R = Σ n_b², S = Σ s_b, P = Σ n_b s_b and Q = Σ s_b², with m = S/N,
//!
//! - the mean is m, and
//! - the variance *of the mean* is estimated by
//!   Σ (s_b − n_b m)² / N² / (1 − R/N²) = (Q − 2 m P + m² R) / N² / (1 − R/N²).
//!
//! Where batches differ in length only, so that Var[s_b] = n_b σ², the expectation of the numerator
//! is σ² N (1 − R/N²), and the estimate is unbiased for σ²/N. For equal batches it is the
//! usual variance of B batch means over B.
//!
//! The subtraction cancels: at a relative spread of 1e-8 an f64 sum of squares has nothing left.
//! Sums are therefore double-double (about 106 bits), where batch sums, being f32, square exactly.

use crate::{BatchSum, DoubleDouble};

/// Spread of batch means, relative to their mean and squared, below which it is taken as zero.
///
/// f32 batch sums that are not all equal differ by 2⁻²⁴ at least: a relative variance of 2⁻⁴⁸/B.
/// What remains of equal batches after the cancellation is below 2⁻¹⁰⁰.
const NO_SPREAD: f64 = 1.0 / (1u128 << 80) as f64;

/// Totals of the batches of one pixel, all three channels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PixelMoments {
    samples: u64,
    samples_squared: u64,
    sum: [DoubleDouble; 3],
    weighted_sum: [DoubleDouble; 3],
    square_sum: [DoubleDouble; 3],
    largest: f32,
    squares: DoubleDouble,
}

/// 32-bit words of [`PixelMoments::word`].
pub(crate) const WORDS: usize = 45;

impl PixelMoments {
    /// All statistics of the pixel, as [`WORDS`] words: both counts, S, P and Q of red, green and
    /// blue, the largest sample and the squares. Doubles come as their bits, the lower word first.
    pub(crate) fn word(&self, index: usize) -> u32 {
        let half = |bits: u64, part: usize| if part.is_multiple_of(2) { bits as u32 } else { (bits >> 32) as u32 };
        let double = |sum: DoubleDouble, part: usize| half(sum.words()[part / 2 % 2].to_bits(), part);
        match index {
            0..2 => half(self.samples, index),
            2..4 => half(self.samples_squared, index),
            4..40 => {
                let (channel, part) = ((index - 4) / 12, (index - 4) % 12);
                let sums = [&self.sum, &self.weighted_sum, &self.square_sum];
                double(sums[part / 4][channel], part % 4)
            }
            40..44 => double(self.squares, index - 40),
            _ => self.largest.to_bits(),
        }
    }

    /// The inverse of [`Self::word`], bit for bit.
    pub(crate) fn from_words(word: impl Fn(usize) -> u32) -> Self {
        let long = |at: usize| u64::from(word(at)) | u64::from(word(at + 1)) << 32;
        let double = |at: usize| DoubleDouble { hi: f64::from_bits(long(at)), lo: f64::from_bits(long(at + 2)) };
        let sums = |first: usize| std::array::from_fn(|channel| double(4 + 12 * channel + 4 * first));
        Self {
            samples: long(0),
            samples_squared: long(2),
            sum: sums(0),
            weighted_sum: sums(1),
            square_sum: sums(2),
            squares: double(40),
            largest: f32::from_bits(word(44)),
        }
    }

    /// Totals that reproduce those of an image file: `samples`, the number of equal batches
    /// (`batches`), mean, variance of the mean (`None`: unknown), largest sample and sum of
    /// squares.
    ///
    /// Σ n_b (s_b − n_b m) is not kept, and is set to zero: its value for equal batches, and its
    /// expectation for others. A batch added later shifts the mean by δ; the sum of squares about
    /// the new mean then lacks 2 δ Σ n_b (s_b − n_b m).
    pub(crate) fn from_estimate(
        samples: u64,
        batches: f64,
        mean: [f32; 3],
        variance: Option<[f32; 3]>,
        [largest, squares]: [f32; 2],
    ) -> Self {
        let n = samples as f64;
        let batches = if variance.is_some() { batches.max(1.0) } else { 1.0 };
        let r = (n * n / batches).round();
        let mut totals = Self {
            samples,
            samples_squared: r as u64,
            largest,
            squares: DoubleDouble { hi: squares.into(), lo: 0.0 },
            ..Self::default()
        };
        totals.sum = mean.map(|mean| DoubleDouble { hi: mean.into(), lo: 0.0 }.times_f64(n));
        let spread = totals.spread_left();
        for channel in 0..3 {
            // As `variance_of_mean` computes it, so that no spread comes back as none.
            let m = if samples == 0 { DoubleDouble::default() } else { totals.sum[channel].over_f64(n) };
            totals.weighted_sum[channel] = m.times_f64(r);
            let mut square_sum = m.times(m).times_f64(r);
            if let (Some(variance), Some(spread)) = (variance, spread) {
                square_sum.add_f64(f64::from(variance[channel]) * spread * n * n);
            }
            totals.square_sum[channel] = square_sum;
        }
        totals
    }

    /// Adds a batch of `samples` samples.
    ///
    /// Returns false, and adds nothing, where a sum is not finite: one bad batch must not spoil the
    /// pixel permanently. The caller counts these batches.
    #[must_use]
    pub fn add_batch(&mut self, samples: u32, batch: &BatchSum) -> bool {
        if !batch.is_finite() {
            return false;
        }
        let sums = batch.sum;
        let n = f64::from(samples);
        self.samples += u64::from(samples);
        self.samples_squared += u64::from(samples) * u64::from(samples);
        for (channel, sum) in sums.into_iter().enumerate() {
            let s = f64::from(sum);
            // n·s and s² are exact: 24 + 32 bits may exceed 53 only beyond 2²⁹ samples per batch.
            self.sum[channel].add_f64(s);
            self.weighted_sum[channel].add_f64(n * s);
            self.square_sum[channel].add_f64(s * s);
        }
        self.largest = self.largest.max(batch.largest());
        self.add_squares(DoubleDouble { hi: batch.squares().into(), lo: 0.0 });
        true
    }

    /// Adds the batches of another part of the same render.
    pub fn merge(&mut self, other: &Self) {
        self.samples += other.samples;
        self.samples_squared += other.samples_squared;
        for channel in 0..3 {
            self.sum[channel].add(other.sum[channel]);
            self.weighted_sum[channel].add(other.weighted_sum[channel]);
            self.square_sum[channel].add(other.square_sum[channel]);
        }
        self.largest = self.largest.max(other.largest);
        self.add_squares(other.squares);
    }

    /// Squares that exceed the range of f32 become infinite, and remain so.
    fn add_squares(&mut self, squares: DoubleDouble) {
        if self.squares.hi.is_finite() && squares.hi.is_finite() {
            self.squares.add(squares);
        } else {
            self.squares = DoubleDouble { hi: f64::INFINITY, lo: 0.0 };
        }
    }

    /// Samples so far, N.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Largest luminance of a sample.
    pub fn largest(&self) -> f64 {
        self.largest.into()
    }

    /// Sum of squared luminances of the samples.
    pub fn squares(&self) -> f64 {
        self.squares.to_f64()
    }

    /// Mean radiance per channel; zero before the first batch.
    pub fn mean(&self) -> [f64; 3] {
        if self.samples == 0 {
            return [0.0; 3];
        }
        self.sum.map(|sum| sum.over_f64(self.samples as f64).to_f64())
    }

    /// Variance of the mean per channel (radiance squared); `None` below two batches, where it is
    /// unknown.
    pub fn variance_of_mean(&self) -> Option<[f64; 3]> {
        let spread = self.spread_left()?;
        let n = self.samples as f64;
        let r = self.samples_squared as f64;
        Some(std::array::from_fn(|channel| {
            let m = self.sum[channel].over_f64(n);
            let m2r = m.times(m).times_f64(r);
            let mut numerator = self.square_sum[channel];
            numerator.add(m.times(self.weighted_sum[channel]).times_f64(2.0).negated());
            numerator.add(m2r);
            let numerator = numerator.to_f64();
            if numerator <= NO_SPREAD * m2r.to_f64() { 0.0 } else { numerator / (n * n) / spread }
        }))
    }

    /// Degrees of freedom of [`Self::variance_of_mean`]: N²/R − 1, which is B − 1 for B equal
    /// batches and less for unequal ones. Zero below two batches.
    pub fn degrees_of_freedom(&self) -> f64 {
        match self.spread_left() {
            Some(_) => {
                let n = self.samples as f64;
                n * n / self.samples_squared as f64 - 1.0
            }
            None => 0.0,
        }
    }

    /// 1 − R/N², computed as (N² − R)/N² in integers, or `None` below two batches.
    fn spread_left(&self) -> Option<f64> {
        let n_squared = u128::from(self.samples) * u128::from(self.samples);
        let left = n_squared - u128::from(self.samples_squared).min(n_squared);
        (left > 0).then(|| left as f64 / n_squared as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn batches(seed: u64, count: usize, lengths: &[u32]) -> Vec<(u32, [f32; 3])> {
        let mut state = seed;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 40) as f32 / (1u32 << 24) as f32
        };
        (0..count)
            .map(|b| {
                let n = lengths[b % lengths.len()];
                (n, [1.0, 1e-6, 3e5].map(|scale| n as f32 * scale * (0.5 + uniform())))
            })
            .collect()
    }

    fn film_of(batches: &[(u32, [f32; 3])]) -> PixelMoments {
        let mut moments = PixelMoments::default();
        for &(n, sums) in batches {
            assert!(moments.add_batch(n, &BatchSum::new(sums, 0.0, 0.0)));
        }
        moments
    }

    /// The definition, term by term, in f64.
    fn by_definition(batches: &[(u32, [f32; 3])], channel: usize) -> (f64, f64) {
        let n: f64 = batches.iter().map(|b| f64::from(b.0)).sum();
        let mean = batches.iter().map(|b| f64::from(b.1[channel])).sum::<f64>() / n;
        let spread: f64 = batches.iter().map(|b| (f64::from(b.1[channel]) - f64::from(b.0) * mean).powi(2)).sum();
        let r: f64 = batches.iter().map(|b| f64::from(b.0).powi(2)).sum();
        (mean, spread / (n * n) / (1.0 - r / (n * n)))
    }

    #[test]
    fn unequal_batches_match_the_definition() {
        let batches = batches(7, 37, &[64, 4096, 1, 100]);
        let moments = film_of(&batches);
        let variance = moments.variance_of_mean().unwrap();
        for (channel, variance) in variance.into_iter().enumerate() {
            let (mean, expected) = by_definition(&batches, channel);
            assert!((moments.mean()[channel] / mean - 1.0).abs() < 1e-14);
            assert!((variance / expected - 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn equal_batches_give_the_variance_of_batch_means() {
        // Four batches of 8 samples with means 1, 2, 3, 4: s² = 5/3, so 5/12 for the mean of four.
        let moments = film_of(&[1.0f32, 2.0, 3.0, 4.0].map(|m| (8, [8.0 * m; 3])));
        assert_eq!(moments.mean(), [2.5; 3]);
        assert!((moments.variance_of_mean().unwrap()[0] - 5.0 / 12.0).abs() < 1e-15);
        assert_eq!(moments.degrees_of_freedom(), 3.0);
        assert_eq!(moments.samples(), 32);
    }

    #[test]
    fn one_batch_has_no_variance() {
        assert_eq!(film_of(&[(16, [1.0; 3])]).variance_of_mean(), None);
        assert_eq!(film_of(&[(16, [1.0; 3])]).degrees_of_freedom(), 0.0);
        assert_eq!(PixelMoments::default().variance_of_mean(), None);
    }

    #[test]
    fn equal_batches_have_exactly_no_variance() {
        for value in [0.1f32, 1.0 / 3.0, 7.77e-20, 1e30, 0.0] {
            let moments = film_of(&[(12, [value; 3]); 1000]);
            assert_eq!(moments.variance_of_mean(), Some([0.0; 3]), "{value}");
        }
    }

    #[test]
    fn one_ulp_between_batches_is_seen() {
        let a = 0.1f32;
        let b = f32::from_bits(a.to_bits() + 1);
        let moments = film_of(&[(12, [a; 3]), (12, [b; 3])]);
        let expected = ((f64::from(b) - f64::from(a)) / 24.0).powi(2);
        assert!((moments.variance_of_mean().unwrap()[0] / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn order_and_slicing_do_not_change_the_rounded_result() {
        for seed in 0..50 {
            let batches = batches(seed, 300, &[64, 64, 64, 17]);
            let whole = film_of(&batches);
            let mut reversed = batches.clone();
            reversed.reverse();
            let mut sliced = film_of(&batches[200..]);
            sliced.merge(&film_of(&batches[..77]));
            sliced.merge(&film_of(&batches[77..200]));
            for other in [film_of(&reversed), sliced] {
                assert_eq!(whole.mean().map(|x| x as f32), other.mean().map(|x| x as f32));
                assert_eq!(
                    whole.variance_of_mean().unwrap().map(|x| x as f32),
                    other.variance_of_mean().unwrap().map(|x| x as f32)
                );
            }
        }
    }

    #[test]
    fn words_restore_every_bit() {
        let mut moments = film_of(&batches(3, 100, &[64, 3]));
        assert!(moments.add_batch(5, &BatchSum::new([0.1, 1e-30, 7e20], 0.3, 1e-7)));
        let words: Vec<u32> = (0..WORDS).map(|i| moments.word(i)).collect();
        assert_eq!(PixelMoments::from_words(|i| words[i]), moments);
        // No word is read twice and none left out.
        for i in 0..WORDS {
            let other = PixelMoments::from_words(|j| words[j] ^ u32::from(i == j) << 5);
            let changed: Vec<_> = (0..WORDS).filter(|&j| other.word(j) != words[j]).collect();
            assert_eq!(changed, [i]);
        }
    }

    #[test]
    fn squares_do_not_depend_on_order_and_may_exceed_the_range() {
        let of = |squares: &[f32]| {
            let mut moments = PixelMoments::default();
            for &square in squares {
                assert!(moments.add_batch(1, &BatchSum::new([1.0; 3], 1.0, square)));
            }
            moments
        };
        // 2⁶⁰ apart: one double would have to round.
        let far = [1.0, 1.0 / (1u64 << 60) as f32, 1.0 / (1u64 << 60) as f32, 1e-12];
        let mut backwards = far;
        backwards.reverse();
        assert_eq!(of(&far).squares, of(&backwards).squares);
        assert_eq!(of(&[1.0, f32::INFINITY, 2.0]).squares(), f64::INFINITY);
        let mut merged = of(&[1.0]);
        merged.merge(&of(&[f32::INFINITY]));
        merged.merge(&of(&[1.0]));
        assert_eq!(merged.squares(), f64::INFINITY);
    }

    #[test]
    fn finished_files_extend_with_honest_error_bars() {
        let all = batches(11, 48, &[4]);
        let rebuilt = |moments: &PixelMoments| {
            let batches = moments.degrees_of_freedom() + 1.0;
            let variance = moments.variance_of_mean().map(|v| v.map(|v| v as f32));
            let tail = [moments.largest() as f32, moments.squares() as f32];
            PixelMoments::from_estimate(moments.samples(), batches, moments.mean().map(|m| m as f32), variance, tail)
        };
        let mut extended = rebuilt(&film_of(&all[..16]));
        extended.merge(&film_of(&all[16..]));
        let direct = film_of(&all);
        assert_eq!((extended.samples(), extended.degrees_of_freedom()), (192, direct.degrees_of_freedom()));
        let (found, expected) = (extended.variance_of_mean().unwrap(), direct.variance_of_mean().unwrap());
        for channel in 0..3 {
            assert!((extended.mean()[channel] / direct.mean()[channel] - 1.0).abs() < 1e-7);
            assert!((found[channel] / expected[channel] - 1.0).abs() < 0.02, "{found:?} {expected:?}");
        }
        // One batch has no variance, equal batches one of zero.
        assert_eq!(rebuilt(&film_of(&[(16, [1.0; 3])])).variance_of_mean(), None);
        assert_eq!(rebuilt(&film_of(&[(12, [0.1; 3]); 16])).variance_of_mean(), Some([0.0; 3]));
        assert_eq!(rebuilt(&PixelMoments::default()), PixelMoments::default());
    }

    #[test]
    fn sums_do_not_stagnate() {
        // 2²⁶ samples of one third: an f32 running sum stalls at half of it.
        let batch = 4096;
        let sum = (f64::from(batch) / 3.0) as f32;
        let moments = film_of(&vec![(batch, [sum; 3]); 1 << 14]);
        assert_eq!(moments.samples(), 1 << 26);
        assert!((moments.mean()[0] * f64::from(batch) / f64::from(sum) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_bad_batch_is_refused_whole() {
        let mut moments = film_of(&[(4, [1.0; 3])]);
        let before = moments;
        assert!(!moments.add_batch(4, &BatchSum::new([1.0, f32::NAN, 1.0], 1.0, 4.0)));
        assert!(!moments.add_batch(4, &BatchSum::new([1.0, 1.0, f32::INFINITY], 1.0, 4.0)));
        assert_eq!(moments, before);
    }

    #[test]
    fn words_round_trip() {
        let mut x = DoubleDouble::default();
        x.add_f64(1.0);
        x.add_f64(1e-25);
        assert_eq!(DoubleDouble::from_words(x.words()), x);
        assert_eq!(x.words(), [1.0, 1e-25]);
    }
}
