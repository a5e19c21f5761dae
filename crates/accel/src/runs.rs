//! Boxes that a clustering builder would merge one pair a round.

use std::ops::Range;

use glam::Vec3A;
use obvhs::{aabb::Aabb, ploc::morton::morton_encode_u64};
use rayon::prelude::*;

/// A run of this many boxes costs the clustering builder some 10 ms; longer ones are taken out.
const RUN_LIMIT: usize = 1024;

/// Box slots in Morton order, and the ranges of that order which the clustering builder would choke
/// on.
pub(crate) fn degenerate_runs(boxes: &[Aabb], total: &Aabb) -> (Vec<u32>, Vec<Range<usize>>) {
    if boxes.len() <= RUN_LIMIT {
        return (Vec::new(), Vec::new());
    }
    let extent = total.diagonal().max(Vec3A::splat(f32::MIN_POSITIVE));
    let cells = ((1 << 21) - 1) as f32;
    let mut keys: Vec<(u64, u32)> = boxes
        .par_iter()
        .enumerate()
        .map(|(i, b)| {
            let p = ((b.center() - total.min) / extent).clamp(Vec3A::ZERO, Vec3A::ONE) * cells;
            (morton_encode_u64(p.x as u32, p.y as u32, p.z as u32), i as u32)
        })
        .collect();
    keys.par_sort_unstable();

    let mut found: Vec<Range<usize>> = Vec::new();
    let mut add = |run: Range<usize>| {
        if run.len() > RUN_LIMIT {
            found.push(run);
        }
    };
    let cost = |i: usize| {
        let (a, b) = (&boxes[keys[i].1 as usize], &boxes[keys[i + 1].1 as usize]);
        a.union(b).half_area()
    };
    // Where the current stretch of equal keys, of rising and of falling costs began.
    let (mut same, mut rising, mut falling) = (0, 0, 0);
    let mut last = cost(0);
    for i in 1..keys.len() {
        let end = i + 1 == keys.len();
        let c = if end { f32::NAN } else { cost(i) };
        for (begin, goes_on) in
            [(&mut same, !end && keys[i].0 == keys[i - 1].0), (&mut rising, c >= last), (&mut falling, c <= last)]
        {
            if !goes_on {
                add(*begin..i + usize::from(end));
                *begin = i;
            }
        }
        last = c;
    }
    // The three kinds overlap: join those that touch.
    found.sort_unstable_by_key(|run| run.start);
    let mut runs: Vec<Range<usize>> = Vec::new();
    for run in found {
        match runs.last_mut() {
            Some(last) if last.end >= run.start => last.end = last.end.max(run.end),
            _ => runs.push(run),
        }
    }
    let order = if runs.is_empty() { Vec::new() } else { keys.iter().map(|k| k.1).collect() };
    (order, runs)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(x: f32, size: f32) -> Aabb {
        Aabb::new(Vec3A::new(x, 0.0, 0.0), Vec3A::new(x + size, size, size))
    }

    #[test]
    fn runs_are_found_and_nothing_else() {
        let total = |boxes: &[Aabb]| boxes.iter().fold(Aabb::empty(), |a, b| a.union(b));
        let row: Vec<Aabb> = (0..5000).map(|k| cube(k as f32, 1.0)).collect();
        let (order, runs) = degenerate_runs(&row, &total(&row));
        assert!(order.len() == 5000 && runs.len() == 1 && runs[0] == (0..5000), "{runs:?}");
        // Hashed offsets: no order along the curve.
        let noise: Vec<Aabb> = (0..5000u32).map(|k| cube((k.wrapping_mul(2_654_435_761) >> 8) as f32, 9.0)).collect();
        assert_eq!(degenerate_runs(&noise, &total(&noise)).1, []);
        let mut both = noise.clone();
        both.extend(std::iter::repeat_n(cube(1e6, 1.0), 3000));
        let (order, runs) = degenerate_runs(&both, &total(&both));
        assert_eq!(runs.len(), 1);
        let taken = &order[runs[0].clone()];
        assert!(taken.iter().filter(|&&i| i >= 5000).count() == 3000 && taken.len() < 3100, "{runs:?}");
    }
}
