//! Reproducible randomness for the generated scenes: SplitMix64 and a lattice noise built on it.
//!
//! Not for estimators: the renderer has its own samplers.

use glam::DVec3;

/// The SplitMix64 generator (Steele, Lea, Flood, "Fast Splittable Pseudorandom Number Generators",
/// OOPSLA 2014).
pub(crate) struct SplitMix(u64);

impl SplitMix {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// Uniform in [0, 1), 53 bits.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [lo, hi).
    pub(crate) fn range(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform in the cube [−1, 1)³.
    pub(crate) fn cube(&mut self) -> DVec3 {
        DVec3::new(self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0))
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Smooth noise in [−1, 1]: values at integer points, joined by a quintic in each direction.
pub(crate) fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let value = |dx: i64, dy: i64, dz: i64| {
        let [x, y, z] = [cell.x as i64 + dx, cell.y as i64 + dy, cell.z as i64 + dz];
        let key = [x, y, z].iter().fold(0u64, |h, &k| mix(h ^ (k as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        (key >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let lerp = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let along_x = |dy, dz| lerp(value(0, dy, dz), value(1, dy, dz), w.x);
    let along_y = |dz| lerp(along_x(0, dz), along_x(1, dz), w.y);
    lerp(along_y(0), along_y(1), w.z)
}

/// Sum of `octaves` of noise, each at twice the frequency and half the height; within [−2, 2].
pub(crate) fn fractal_noise(p: DVec3, octaves: i32) -> f64 {
    (0..octaves).map(|k| noise(p * 2f64.powi(k) + DVec3::splat(17.0 * f64::from(k))) * 0.5f64.powi(k)).sum()
}
