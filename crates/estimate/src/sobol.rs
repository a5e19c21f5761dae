//! Owen-scrambled Sobol points in two dimensions: the CPU counterpart of `shaders/core/sampler`.
//!
//! A pair of dimensions is a (0, 2)-sequence in base 2: of any aligned run of 2^m points, exactly
//! one falls into each dyadic cell of area 2^−m, whatever its shape. Owen scrambling keeps that and
//! makes each point uniform, so that the mean is unbiased. More dimensions are padded by
//! independently shuffled and scrambled pairs (Burley, "Practical hash-based Owen scrambling", JCGT
//! 9(4) (2020), sections 3–5).

/// PCG's output permutation over one step of a linear congruential generator (Jarzynski & Olano,
/// "Hash functions for GPU rendering", JCGT 9(3) (2020), "pcg").
pub fn hash_u32(v: u32) -> u32 {
    let state = v.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// A hash of two words; not symmetric.
pub fn hash_combine(a: u32, b: u32) -> u32 {
    hash_u32(a ^ b.wrapping_mul(0x9e37_79b9).wrapping_add(0x7f4a_7c15))
}

/// A number in [0, 1) from the top 24 bits: never 1, unlike rounding all 32 to f32.
pub fn unit_from_bits(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1u32 << 24) as f32
}

/// Nested uniform (Owen) scrambling of a *bit-reversed* number: a bit is flipped by a hash of the
/// bits below it, so here of the digits before it (Laine & Karras, "Stratified sampling for
/// stochastic transparency", EGSR 2011, with the constants of Vegdahl, "Building a better LK hash",
/// 2021).
fn owen_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Second dimension of Sobol's sequence, bit-reversed: Pascal's triangle modulo 2 times the index.
/// By Lucas' theorem an entry is one where the row's bits contain the column's, so the product is a
/// sum over supersets: five xor-shifts (Ahmed, "An implementation algorithm of 2D Sobol sequence
/// fast, elegant, and compact", EGSR 2024).
fn second_reversed(index: u32) -> u32 {
    let mut v = index;
    v ^= (v >> 16) & 0x0000_ffff;
    v ^= (v >> 8) & 0x00ff_00ff;
    v ^= (v >> 4) & 0x0f0f_0f0f;
    v ^= (v >> 2) & 0x3333_3333;
    v ^ (v >> 1) & 0x5555_5555
}

/// Sobol's first two dimensions, not scrambled, as binary fractions of 2³².
pub fn sobol_2d_plain(index: u32) -> [u32; 2] {
    [index.reverse_bits(), second_reversed(index).reverse_bits()]
}

/// Point `index` of the shuffled and scrambled (0, 2)-sequence that `seed` names, as binary
/// fractions of 2³².
///
/// Shuffling the index by an Owen scramble keeps aligned blocks of 2^m points together, so every
/// aligned block is still a net.
pub fn sobol_2d(index: u32, seed: u32) -> [u32; 2] {
    let shuffled = owen_reversed(index.reverse_bits(), seed).reverse_bits();
    [
        owen_reversed(shuffled, hash_u32(seed ^ 0x68bc_21eb)).reverse_bits(),
        owen_reversed(second_reversed(shuffled), hash_u32(seed ^ 0x02e5_be93)).reverse_bits(),
    ]
}

/// Two coordinates in [0, 1) of a path: sample `index` of `replicate`, dimension pair `pair`, at
/// `pixel`.
pub fn sample_2d(pixel: u32, replicate: u32, index: u32, seed: u32, pair: u32) -> [f32; 2] {
    let key = hash_combine(hash_combine(hash_u32(pixel), replicate), seed);
    sobol_2d(index, hash_combine(key, pair)).map(unit_from_bits)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Moments, chi_squared_test, uniformity_test};

    /// Sobol's construction from direction numbers (Joe & Kuo 2008): dimension 1 is the identity,
    /// dimension 2 has the primitive polynomial x + 1 and m₁ = 1, so v₁ = ½ and v_{k+1} = v_k ⊕
    /// v_k/2.
    fn by_direction_numbers(index: u32) -> [u32; 2] {
        let (mut x, mut y) = (0u32, 0u32);
        let mut v = 1u32 << 31;
        for bit in 0..32 {
            if index >> bit & 1 == 1 {
                x ^= 1 << (31 - bit);
                y ^= v;
            }
            v ^= v >> 1;
        }
        [x, y]
    }

    #[test]
    fn plain_points_are_sobols() {
        for index in (0..4096).chain((0..4096).map(hash_u32)).chain([u32::MAX, 1 << 31]) {
            assert_eq!(sobol_2d_plain(index), by_direction_numbers(index), "{index}");
        }
        // The first points as every textbook lists them.
        let first = [0, 1, 2, 3].map(|i| sobol_2d_plain(i).map(|x| f64::from(x) / 4_294_967_296.0));
        assert_eq!(first, [[0.0, 0.0], [0.5, 0.5], [0.25, 0.75], [0.75, 0.25]]);
    }

    /// Whether 2^m points put one into each dyadic cell of area 2^−m of every shape.
    fn is_net(points: &[[u32; 2]]) -> bool {
        let m = points.len().ilog2();
        (0..=m).all(|a| {
            let b = m - a;
            let mut seen = vec![false; points.len()];
            points.iter().all(|&[x, y]| {
                let cell = ((u64::from(x) >> (32 - a)) << b | u64::from(y) >> (32 - b)) as usize;
                !std::mem::replace(&mut seen[cell], true)
            })
        })
    }

    #[test]
    fn every_aligned_block_is_a_net() {
        for seed in (0..64).map(hash_u32).chain([0, 1, u32::MAX]) {
            for (m, start) in [(0, 5), (3, 0), (5, 32), (8, 256 * 77), (12, 0), (6, u32::MAX - 63)] {
                let points: Vec<_> = (0..1u32 << m).map(|i| sobol_2d(start + i, seed)).collect();
                assert!(is_net(&points), "{seed} {m} {start}");
            }
        }
        // The check can fail: a block that is not aligned, and plain hashing.
        assert!(!(0..64).all(|seed| is_net(&(0..64).map(|i| sobol_2d(i + 13, hash_u32(seed))).collect::<Vec<_>>())));
        assert!(!is_net(&(0..64).map(|i| [hash_u32(i), hash_u32(i + 99)]).collect::<Vec<_>>()));
    }

    #[test]
    fn scrambling_is_a_bijection_that_keeps_prefixes() {
        // Reversed numbers that agree in their low k bits agree there after scrambling, and differ
        // where they first differ.
        for seed in (0..500).map(hash_u32) {
            for bit in 0..32 {
                let x = hash_u32(seed ^ bit);
                let (a, b) = (owen_reversed(x, seed), owen_reversed(x ^ 1 << bit, seed));
                assert_eq!((a ^ b).trailing_zeros(), bit);
            }
        }
    }

    #[test]
    fn each_point_is_uniform_over_scrambles() {
        // χ² over 16 × 16 cells of point 3 for 100,000 seeds, and every bit set half of the time:
        // α = 0.001 for each of six tests.
        for index in [0u32, 3, 12_345] {
            let mut counts = vec![0u64; 256];
            let mut ones = [0u64; 64];
            for seed in 0..100_000u32 {
                let [x, y] = sobol_2d(index, hash_combine(seed, 7));
                counts[(x >> 28 << 4 | y >> 28) as usize] += 1;
                let both = u64::from(x) << 32 | u64::from(y);
                for (bit, ones) in ones.iter_mut().enumerate() {
                    *ones += both >> bit & 1;
                }
            }
            let test = chi_squared_test(&counts, &[100_000.0 / 256.0; 256], 5.0).unwrap();
            assert!(test.p > 0.001, "{index}: {}", test.p);
            // √(100,000)/2 = 158; 64 bits at 4.3 standard errors: α = 0.001 by Šidák.
            assert!(ones.iter().all(|&n| n.abs_diff(50_000) < 690), "{index}");
        }
    }

    /// RMS error over 256 scrambles of the mean of a smooth function on the square.
    fn rms(points: u32) -> f64 {
        let errors: Moments = (0..256)
            .map(|seed| {
                let sum: f64 = (0..points)
                    .map(|i| {
                        let [x, y] = sobol_2d(i, hash_u32(seed)).map(|x| f64::from(unit_from_bits(x)));
                        (x * y).exp()
                    })
                    .sum();
                // ∫∫ e^{xy} = Σ 1/(k·k!) over k ≥ 1, shifted: 1.3179021514544038.
                (sum / f64::from(points) - 1.317_902_151_454_403_8).powi(2)
            })
            .collect();
        errors.mean().sqrt()
    }

    #[test]
    fn smooth_integrands_converge_fast_and_without_bias() {
        // Owen scrambling gives N^−1.5 up to logarithms for smooth functions; independent samples
        // N^−0.5.
        let slope = (rms(1024) / rms(16)).log2() / 6.0;
        assert!(slope < -1.3, "{slope}");
    }

    #[test]
    fn replicates_are_independent() {
        // Means of 16 points of f = x over replicates, as standardised by their own spread, are
        // uncorrelated between pairs of dimensions and between replicates: 1,000 products, 4
        // standard errors.
        let mean = |replicate: u32, pair: u32| {
            (0..16).map(|i| f64::from(sample_2d(5, replicate, i, 9, pair)[0])).sum::<f64>() / 16.0 - 0.5
        };
        let variance: Moments = (0..2000).map(|r| mean(r, 0)).collect();
        for (a, b) in [((0, 0), (0, 1)), ((0, 0), (1, 0))] {
            let products: Moments =
                (0..1000).map(|i| mean(2 * i + a.0, a.1) * mean(2 * i + b.0, b.1) / variance.variance()).collect();
            assert!(products.mean().abs() < 4.0 / 1000f64.sqrt(), "{}", products.mean());
        }
        // And a single coordinate over replicates is uniform.
        let first: Vec<f64> = (0..1000).map(|r| f64::from(sample_2d(5, r, 0, 9, 3)[1])).collect();
        assert!(uniformity_test(&first).p > 0.01);
    }

    #[test]
    fn units_stay_below_one() {
        assert_eq!(unit_from_bits(u32::MAX), 1.0 - f32::EPSILON / 2.0);
        assert_eq!(unit_from_bits(0), 0.0);
    }

    #[test]
    fn pcg_published_value() {
        // From the published constants, worked in wide integers: state = 42·747796405 + 2891336453
        // mod 2³².
        let state = ((42u64 * 747_796_405 + 2_891_336_453) % (1 << 32)) as u32;
        let word = (((state >> ((state >> 28) + 4)) ^ state) as u64 * 277_803_737 % (1 << 32)) as u32;
        assert_eq!(hash_u32(42), word >> 22 ^ word);
    }
}
