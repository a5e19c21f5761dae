//! Binary trees over boxes, built by obvhs and checked before anything relies on them.
//!
//! obvhs clusters neighbours along a Morton curve (PLOC, Meister and Bittner 2018) and then moves subtrees where they
//! cost less (parallel reinsertion, Meister and Bittner 2018). Two things have to be kept from it:
//!
//! - Runs of boxes along the curve whose pairwise cost is monotone (identical triangles, concentric ones, an evenly spaced
//!   row) merge one pair a round: quadratic time and a depth that grows with the run. Such runs, and boxes that share a
//!   Morton cell in bulk, are found first, built top-down, and take part in clustering as one box each.
//! - A tree deeper than the kernel's stack is thrown away and rebuilt with a bounded depth.

use std::ops::Range;

use glam::Vec3A;
use obvhs::{
    aabb::Aabb,
    bvh2::{node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision, morton::morton_encode_u64},
};
use rayon::prelude::*;

use crate::{Quality, topdown};

/// A run of this many boxes costs the clustering builder some 10 ms; longer ones are taken out.
const RUN_LIMIT: usize = 1024;
/// Below this extent box areas underflow, which leaves the clustering builder nothing to compare.
const LEAST_EXTENT: f32 = 1e-15;
/// The clustering builder needs more rounds than this only where it degenerates; its optimiser's stack allows for it.
const MOST_ROUNDS: usize = 96;

/// A binary tree: node 0 is the root; a leaf (`prim_count` 1) names its primitive in `first_index`, an inner node its
/// first child, whose sibling follows it.
#[derive(Clone, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Bvh2Node>,
}

impl Tree {
    /// Most inner nodes on a path from the root to a leaf; 0 for a single leaf or no node.
    pub(crate) fn depth(&self) -> u32 {
        let mut deepest = 0;
        let mut work = if self.nodes.is_empty() { vec![] } else { vec![(0u32, 0u32)] };
        while let Some((i, depth)) = work.pop() {
            deepest = deepest.max(depth);
            let node = &self.nodes[i as usize];
            if !node.is_leaf() {
                work.push((node.first_index, depth + 1));
                work.push((node.first_index + 1, depth + 1));
            }
        }
        deepest
    }
}

/// Builds over `boxes`; box k belongs to primitive `indices[k]`, so that a primitive may have several boxes.
///
/// No path of the result holds more than `levels` inner nodes, as long as `levels` ≥ log2 of the number of boxes.
pub(crate) fn build(boxes: &[Aabb], indices: &[u32], quality: Quality, levels: u32) -> Tree {
    if boxes.is_empty() {
        return Tree::default();
    }
    let tree = clustered(boxes, indices, quality);
    match tree {
        Some(tree) if tree.depth() <= levels => tree,
        _ => bounded(boxes, indices, levels),
    }
}

fn bounded(boxes: &[Aabb], indices: &[u32], levels: u32) -> Tree {
    let mut slots: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![Bvh2Node::default()];
    nodes[0] = topdown::build(boxes, &mut slots, levels, &mut nodes);
    for node in &mut nodes {
        if node.is_leaf() {
            node.first_index = indices[node.first_index as usize];
        }
    }
    Tree { nodes }
}

/// obvhs's tree, or none where it is not to be used.
fn clustered(boxes: &[Aabb], indices: &[u32], quality: Quality) -> Option<Tree> {
    let total = boxes.par_iter().copied().reduce(Aabb::empty, |a, b| a.union(&b));
    if total.diagonal().max_element() <= LEAST_EXTENT {
        return None;
    }
    let (order, runs) = degenerate_runs(boxes, &total);
    let mut prims = Vec::new();
    let mut shapes = Vec::new();
    let (shapes, labels): (&[Aabb], Vec<u32>) = if runs.is_empty() {
        (boxes, (0..boxes.len() as u32).collect())
    } else {
        let mut next = 0;
        for (k, run) in runs.iter().enumerate() {
            prims.extend_from_slice(&order[next..run.start]);
            prims.push((boxes.len() + k) as u32);
            next = run.end;
        }
        prims.extend_from_slice(&order[next..]);
        shapes.extend(prims.iter().map(|&p| match (p as usize).checked_sub(boxes.len()) {
            None => boxes[p as usize],
            Some(k) => order[runs[k].clone()].iter().fold(Aabb::empty(), |acc, &slot| acc.union(&boxes[slot as usize])),
        }));
        (&shapes, prims)
    };

    let parameters = Parameters::of(quality);
    let mut bvh = PlocBuilder::with_capacity(shapes.len()).build(
        parameters.distance,
        shapes,
        labels,
        parameters.precision,
        parameters.threshold,
    );
    if bvh.max_depth > MOST_ROUNDS {
        return None;
    }
    let mut optimiser = ReinsertionOptimizer::default();
    for ratio in parameters.reinsertion {
        optimiser.run(&mut bvh, ratio, None);
    }

    let mut nodes = bvh.nodes;
    for i in 0..nodes.len() {
        if nodes[i].is_leaf()
            && let Some(k) = (nodes[i].first_index as usize).checked_sub(boxes.len())
        {
            let run = &runs[k];
            let mut slots = order[run.clone()].to_vec();
            let levels = topdown::levels_needed(run.len()) + 4;
            nodes[i] = topdown::build(boxes, &mut slots, levels, &mut nodes);
        }
    }
    for node in nodes.iter_mut().filter(|n| n.is_leaf()) {
        node.first_index = indices[node.first_index as usize];
    }
    Some(Tree { nodes })
}

struct Parameters {
    distance: PlocSearchDistance,
    threshold: usize,
    precision: SortPrecision,
    reinsertion: [f32; 2],
}

impl Parameters {
    fn of(quality: Quality) -> Self {
        let (distance, threshold, precision, reinsertion) = match quality {
            Quality::Fast => (PlocSearchDistance::Low, 2, SortPrecision::U64, [0.02, 0.0]),
            Quality::Medium => (PlocSearchDistance::Medium, 3, SortPrecision::U64, [0.05, 0.05]),
            Quality::Slow => (PlocSearchDistance::High, 2, SortPrecision::U128, [0.2, 0.4]),
        };
        Self { distance, threshold, precision, reinsertion }
    }
}

/// Box slots in Morton order, and the ranges of that order which the clustering builder would choke on.
fn degenerate_runs(boxes: &[Aabb], total: &Aabb) -> (Vec<u32>, Vec<Range<usize>>) {
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
    // The three kinds overlap: join what touches.
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

    /// Each primitive in one leaf; boxes around what is below them.
    fn check(tree: &Tree, boxes: &[Aabb]) {
        let mut met = vec![0; boxes.len()];
        for node in &tree.nodes {
            if node.is_leaf() {
                met[node.first_index as usize] += 1;
                assert_eq!(*node.aabb(), boxes[node.first_index as usize]);
            } else {
                for k in 0..2 {
                    let child = &tree.nodes[(node.first_index + k) as usize];
                    assert_eq!(node.aabb().union(child.aabb()), *node.aabb());
                }
            }
        }
        assert!(met.iter().all(|&m| m == 1));
        assert_eq!(tree.nodes.len(), 2 * boxes.len() - 1);
    }

    #[test]
    fn depth_keeps_to_what_is_asked() {
        // Sizes that double make clustering as lopsided as it gets.
        let lopsided: Vec<Aabb> =
            (0..120).map(|k| cube((k as f32).exp2() * 1e-18, (k as f32).exp2() * 1e-18)).collect();
        let row: Vec<Aabb> = (0..5000).map(|k| cube(k as f32, 1.0)).collect();
        let mut bounded = 0;
        for boxes in [&lopsided[..100], &row] {
            let indices: Vec<u32> = (0..boxes.len() as u32).collect();
            let free = build(boxes, &indices, Quality::Medium, 1000);
            check(&free, boxes);
            for levels in [topdown::levels_needed(boxes.len()), 14, 20, 62] {
                let tree = build(boxes, &indices, Quality::Medium, levels);
                check(&tree, boxes);
                assert!(tree.depth() <= levels, "{} of {levels}", tree.depth());
                bounded += u32::from(free.depth() > levels);
            }
        }
        assert!(bounded >= 2, "the bound never mattered");
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
