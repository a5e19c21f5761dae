//! The totals of pixels as channels of whole numbers.

use rayon::prelude::*;

use crate::PixelMoments;
use crate::moments::WORDS;

/// The channel of a word of the moments.
pub(crate) fn word_name(word: usize) -> String {
    format!("{PREFIX}{word:02}")
}

/// What the names of channels begin with that are no picture.
pub(crate) const PREFIX: &str = "Moments.";

/// Pixels that are hashed in one go.
const CHUNK: usize = 4096;

/// Hash of all totals and of what samples they hold, by which damage is found out; not for security.
pub(crate) fn checksum(pixels: &[PixelMoments], samples: [u64; 2]) -> String {
    // Fowler–Noll–Vo's xor and multiply over words, with a shift that lets high bits reach low ones.
    let step = |hash: u64, word: u64| {
        let hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        hash ^ hash >> 29
    };
    let of = |pixels: &[PixelMoments]| {
        let words = pixels.iter().flat_map(|pixel| (0..WORDS).map(|i| pixel.word(i)));
        words.fold(0xcbf2_9ce4_8422_2325, |hash, word| step(hash, word.into()))
    };
    let hashes: Vec<u64> = pixels.par_chunks(CHUNK).map(of).collect();
    format!("{:016x}", hashes.into_iter().chain(samples).fold(pixels.len() as u64, step))
}
