//! The device's record of one batch of a pixel's samples, in 16 bytes.

use bytemuck::{Pod, Zeroable};

use crate::luminance;

/// Sum of a batch's samples, and their spread.
///
/// The fourth word holds the upper bits of two f32: 20 of the largest luminance of a sample
/// (rounded to 1/8192 of itself), 12 of the sum of squared luminances (to 1/32). That is enough to
/// judge a tail by. The device never writes 0 there, so that a missing batch is detected.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct BatchSum {
    /// Sum of radiance, linear Rec. 709.
    pub sum: [f32; 3],
    /// Upper bits of [`Self::largest`] and [`Self::squares`].
    pub tail: u32,
}

/// Bits that are left of an f32 without sign when its last `dropped` − 1 are rounded away.
fn upper_bits(x: f32, dropped: u32) -> u32 {
    (x.to_bits() + (1 << (dropped - 1))) >> dropped
}

impl BatchSum {
    /// From the sum, the largest luminance of a sample and the sum of squared luminances.
    pub fn new(sum: [f32; 3], largest: f32, squares: f32) -> Self {
        // Counterpart of `tail_word` in shaders/kernel/samples.wesl.
        Self { sum, tail: upper_bits(largest.max(f32::MIN_POSITIVE), 11) << 12 | upper_bits(squares, 19) }
    }

    /// A batch of `samples` samples that all have the same radiance.
    pub fn constant(samples: u32, radiance: [f32; 3]) -> Self {
        let (n, y) = (samples as f32, luminance(radiance.map(f64::from)) as f32);
        Self::new(radiance.map(|c| n * c), y, n * y * y)
    }

    /// The same batch with the contributions of particles from the lights to the pixel: their sum,
    /// the luminance of the largest and the sum of squared luminances, each as a part of one
    /// sample.
    pub fn with_particles(&self, sum: [f64; 3], largest: f32, squares: f64) -> Self {
        let both = [0, 1, 2].map(|c| (f64::from(self.sum[c]) + sum[c]) as f32);
        Self::new(both, self.largest().max(largest), (f64::from(self.squares()) + squares) as f32)
    }

    /// Whether a film accepts it: a sum that is not finite would spoil a pixel permanently.
    pub(crate) fn is_finite(&self) -> bool {
        self.sum.iter().all(|sum| sum.is_finite())
    }

    /// Whether the device wrote it.
    pub fn is_written(&self) -> bool {
        self.tail != 0
    }

    /// Largest luminance of a sample.
    pub fn largest(&self) -> f32 {
        let largest = f32::from_bits(self.tail >> 12 << 11);
        if largest > f32::MIN_POSITIVE { largest } else { 0.0 }
    }

    /// Sum of squared luminances of the samples; infinite where it exceeds the range.
    pub fn squares(&self) -> f32 {
        f32::from_bits(self.tail << 20 >> 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_keep_what_a_tail_needs() {
        for (largest, squares) in [(0.0f32, 0.0f32), (1.0, 3.0), (1e-20, 1e-38), (3e30, f32::INFINITY), (0.2, 1e7)] {
            let batch = BatchSum::new([1.0, 2.0, 3.0], largest, squares);
            assert!(batch.is_written());
            assert!((batch.largest() - largest).abs() <= largest / 8192.0 + f32::MIN_POSITIVE, "{batch:?}");
            assert!(batch.squares() == squares || (batch.squares() / squares - 1.0).abs() <= 1.0 / 32.0, "{batch:?}");
        }
        assert!(!BatchSum::default().is_written());
    }
}
