//! The totals of pixels as channels of whole numbers.

use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

use crate::moments::WORDS;
use crate::{DoubleDouble, Film, PixelMoments};

/// The channel of a word of the moments.
pub(crate) fn word_name(word: usize) -> String {
    format!("{PREFIX}{word:02}")
}

/// Prefixes of channel names that are no picture.
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

/// Hash of all totals and of their sample ranges, which detects damage; not for security.
pub(crate) fn checksum(film: &Film, samples: [u64; 2]) -> String {
    let pixels = film.pixels();
    let mut hashes: Vec<u64> =
        pixels.par_chunks(CHUNK).map(|pixels| hash::<_, WORDS>(pixels, PixelMoments::word)).collect();
    if let Some(sums) = film.coverage_sums() {
        let of_sums = |sums: &[DoubleDouble]| hash::<_, COVERAGE_WORDS>(sums, |&sum, i| coverage_word(sum, i));
        hashes.par_extend(sums.par_chunks(CHUNK).map(of_sums));
    }
    let mut whole = Xxh3::new();
    for number in [pixels.len() as u64].into_iter().chain(hashes).chain(samples) {
        whole.update(&number.to_le_bytes());
    }
    format!("{:016x}", whole.digest())
}

/// XXH3 over little-endian words, `N` per item.
fn hash<T, const N: usize>(things: &[T], word: impl Fn(&T, usize) -> u32) -> u64 {
    let mut hash = Xxh3::new();
    for thing in things {
        let words: [u32; N] = std::array::from_fn(|i| word(thing, i).to_le());
        hash.update(bytemuck::cast_slice(&words));
    }
    hash.digest()
}
