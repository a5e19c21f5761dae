//! The totals of pixels as channels of whole numbers.

use rayon::prelude::*;

use crate::moments::WORDS;
use crate::{DoubleDouble, Film};

/// The channel of a word of the moments.
pub(crate) fn word_name(word: usize) -> String {
    format!("{PREFIX}{word:02}")
}

/// What the names of channels begin with that are no picture.
pub(crate) const PREFIX: &str = "Moments.";

/// Words of a pixel's coverage. They are numbered from [`WORDS`] on.
pub(crate) const COVERAGE_WORDS: usize = 4;

/// A word of a pixel's coverage: bits of the double-double sum, the lower word of each double
/// first.
pub(crate) fn coverage_word(sum: DoubleDouble, word: usize) -> u32 {
    (sum.words()[word / 2].to_bits() >> (32 * (word % 2))) as u32
}

/// The inverse of [`coverage_word`], bit for bit.
pub(crate) fn coverage_of_words(words: [u32; COVERAGE_WORDS]) -> DoubleDouble {
    let double = |low: u32, high: u32| f64::from_bits(u64::from(high) << 32 | u64::from(low));
    DoubleDouble { hi: double(words[0], words[1]), lo: double(words[2], words[3]) }
}

/// Pixels that are hashed in one go.
const CHUNK: usize = 4096;

/// Hash of all totals and of what samples they hold, by which damage is found out; not for security.
pub(crate) fn checksum(film: &Film, samples: [u64; 2]) -> String {
    let pixels = film.pixels();
    // Fowler–Noll–Vo's xor and multiply over words, with a shift that lets high bits reach low ones.
    let step = |hash: u64, word: u64| {
        let hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        hash ^ hash >> 29
    };
    let hash =
        |words: &mut dyn Iterator<Item = u32>| words.fold(0xcbf2_9ce4_8422_2325, |hash, word| step(hash, word.into()));
    let mut hashes: Vec<u64> = pixels
        .par_chunks(CHUNK)
        .map(|pixels| hash(&mut pixels.iter().flat_map(|pixel| (0..WORDS).map(|i| pixel.word(i)))))
        .collect();
    if let Some(sums) = film.coverage_sums() {
        hashes.par_extend(sums.par_chunks(CHUNK).map(|sums| {
            hash(&mut sums.iter().flat_map(|&sum| (0..COVERAGE_WORDS).map(move |i| coverage_word(sum, i))))
        }));
    }
    format!("{:016x}", hashes.into_iter().chain(samples).fold(pixels.len() as u64, step))
}
