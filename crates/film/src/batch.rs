//! What the device tells of one batch of a pixel's samples, in 16 bytes.

use bytemuck::{Pod, Zeroable};

use crate::luminance;

/// Sum of a batch's samples, and how they were spread.
///
/// The fourth word holds the largest luminance of a sample and the sum of squared luminances, each as the upper half of an f32
/// (8 bits of precision: enough to judge a tail by). The device never writes 0 there, so that a batch that is missing shows.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct BatchSum {
    /// Sum of radiance, linear Rec. 709.
    pub sum: [f32; 3],
    /// Upper halves of [`Self::largest`] and [`Self::squares`].
    pub tail: u32,
}

/// The upper half of an f32, rounded to nearest. Twin of `tail_word` in `shaders/kernel/state.wesl`.
fn upper_half(x: f32) -> u32 {
    (x.to_bits() + 0x8000) >> 16
}

impl BatchSum {
    /// From the sum, the largest luminance of a sample and the sum of squared luminances.
    pub fn new(sum: [f32; 3], largest: f32, squares: f32) -> Self {
        Self { sum, tail: upper_half(largest.max(f32::MIN_POSITIVE)) << 16 | upper_half(squares) }
    }

    /// A batch of `samples` samples that all have the same radiance.
    pub fn constant(samples: u32, radiance: [f32; 3]) -> Self {
        let (n, y) = (samples as f32, luminance(radiance.map(f64::from)) as f32);
        Self::new(radiance.map(|c| n * c), y, n * y * y)
    }

    /// Whether the device wrote it.
    pub fn is_written(&self) -> bool {
        self.tail != 0
    }

    /// Largest luminance of a sample, to 0.4 %.
    pub fn largest(&self) -> f32 {
        let largest = f32::from_bits(self.tail & 0xffff_0000);
        if largest > f32::MIN_POSITIVE { largest } else { 0.0 }
    }

    /// Sum of squared luminances of the samples, to 0.4 %; infinite where it exceeds the range.
    pub fn squares(&self) -> f32 {
        f32::from_bits(self.tail << 16)
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
            assert!((batch.largest() - largest).abs() <= 0.004 * largest + f32::MIN_POSITIVE, "{batch:?}");
            assert!(batch.squares() == squares || (batch.squares() / squares - 1.0).abs() <= 0.004, "{batch:?}");
        }
        assert!(!BatchSum::default().is_written());
    }
}
