//! Merges vertices at equal positions, and finds connected sets.

use glam::Vec3;
use rayon::prelude::*;

/// For each vertex the first one, in an arbitrary order, at its position.
pub(super) fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 turns −0 into 0. Bits, since NaN is not equal to itself.
    let bits = |p: &Vec3| (*p + 0.0).to_array().map(f32::to_bits);
    let mut keys: Vec<([u32; 3], u32)> = positions.iter().map(bits).zip(0..).collect();
    keys.par_sort_unstable();
    let mut welded = vec![0; positions.len()];
    for equal in keys.chunk_by(|a, b| a.0 == b.0) {
        for (_, vertex) in equal {
            welded[*vertex as usize] = equal[0].1;
        }
    }
    welded
}

/// Disjoint sets of numbers below a count.
pub(super) struct Sets(Vec<u32>);

impl Sets {
    /// Each number in a separate set.
    pub(super) fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The representative of the set of `of`.
    pub(super) fn root(&mut self, of: u32) -> u32 {
        let mut at = of;
        while self.0[at as usize] != at {
            let up = self.0[self.0[at as usize] as usize];
            self.0[at as usize] = up;
            at = up;
        }
        at
    }

    /// Joins the sets of `a` and `b`.
    pub(super) fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller number represents both, so that the order of joins does not matter.
        self.0[a.max(b) as usize] = a.min(b);
    }
}
