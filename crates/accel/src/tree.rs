//! Binary trees over boxes, built by obvhs and checked before anything relies on them.
//!
//! obvhs clusters neighbours along a Morton curve (PLOC, Meister and Bittner 2018) and then moves
//! subtrees where they cost less (parallel reinsertion, Meister and Bittner 2018). Two things have
//! to be kept from it:
//!
//! - Runs of boxes along the curve whose pairwise cost is monotone (identical triangles, concentric
//!   ones, an evenly spaced row) merge one pair per round: quadratic time and a depth that grows
//!   with the run. Such runs, and boxes that share a Morton cell in bulk, are found first
//!   ([`crate::runs`]), built top-down, and are one box each in clustering.
//! - A tree deeper than the kernel's stack is thrown away and rebuilt with a bounded depth.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node, reinsertion::ReinsertionOptimizer},
    ploc::{PlocBuilder, PlocSearchDistance, SortPrecision},
};
use rayon::prelude::*;

use crate::{Quality, collapse::Opening, runs::degenerate_runs, topdown};

/// The largest number of stack entries that a traversal needs.
pub const MAX_STACK_DEPTH: u32 = 62;

/// Below this extent box areas underflow, which leaves the clustering builder nothing to compare.
const MIN_EXTENT: f32 = 1e-15;
/// The clustering builder needs more rounds than this only where it degenerates; its optimiser's
/// stack allows for it.
const MAX_ROUNDS: usize = 96;

/// Up to so many boxes a top-down tree is built as well, optimised alike, and the cheaper one is
/// kept.
const RIVALLED: usize = 1 << 14;
/// Up to so many boxes every search distance of the clustering builder is tried too.
const EXHAUSTED: usize = 512;
/// Depth of a top-down tree before it is optimised.
const RIVAL_LEVELS: u32 = 40;

/// A binary tree: node 0 is the root; a leaf (`prim_count` 1) names its primitive in `first_index`,
/// an inner node its first child, whose sibling follows it.
#[derive(Clone, Default)]
pub(crate) struct Tree {
    pub(crate) nodes: Vec<Bvh2Node>,
}

impl Tree {
    /// Maximum number of inner nodes on a path from the root to a leaf; 0 for a single leaf or no
    /// node.
    pub(crate) fn depth(&self) -> u32 {
        depth(&self.nodes)
    }
}

/// How much work goes into a tree.
#[derive(Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) quality: Quality,
    /// Boxes of all the scene's trees together.
    pub(crate) scene: usize,
}

impl Effort {
    fn precision(self) -> SortPrecision {
        if self.quality == Quality::Slow { SortPrecision::U128 } else { SortPrecision::U64 }
    }

    /// Search distance, and rounds in which only neighbours are compared.
    fn clustering(self) -> (PlocSearchDistance, usize) {
        match self.quality {
            Quality::Fast => (PlocSearchDistance::Low, 2),
            Quality::Medium => (PlocSearchDistance::Medium, 3),
            Quality::Slow => (PlocSearchDistance::High, 2),
        }
    }

    /// Passes of reinsertion, as many as are usual or a multiple of that.
    fn optimise(self, bvh: &mut Bvh2, times: usize) {
        let (share, passes) = match self.quality {
            Quality::Fast => (0.02, 1),
            Quality::Medium => (0.05, 2),
            Quality::Slow => (0.4, 2),
        };
        // Smaller scenes get the effort of a million boxes: they are rendered as long as large
        // ones, and their trees become 5 to 20 % cheaper.
        let share = (share * 1e6 / self.scene.max(1) as f32).clamp(share, 1.0);
        let passes = passes * times;
        let mut optimiser = ReinsertionOptimizer::default();
        for _ in 0..passes {
            optimiser.run(bvh, share, None);
        }
    }

    /// Items that a ray through the root reads, times the root's area.
    fn cost(nodes: &[Bvh2Node]) -> f64 {
        if depth(nodes) > MAX_STACK_DEPTH {
            return f64::INFINITY;
        }
        Opening::plan(nodes).cost
    }
}

/// Maximum number of inner nodes on a path from node 0 to a leaf.
fn depth(nodes: &[Bvh2Node]) -> u32 {
    let mut deepest = 0;
    let mut work = if nodes.is_empty() { vec![] } else { vec![(0u32, 0u32)] };
    while let Some((i, depth)) = work.pop() {
        deepest = deepest.max(depth);
        let node = &nodes[i as usize];
        if !node.is_leaf() {
            work.push((node.first_index, depth + 1));
            work.push((node.first_index + 1, depth + 1));
        }
    }
    deepest
}

/// Builds over `boxes`: box k is that of primitive k.
///
/// No path of the result holds more than `levels` inner nodes, as long as `levels` ≥ log2 of the
/// number of boxes.
pub(crate) fn build(boxes: &[Aabb], effort: Effort, levels: u32) -> Tree {
    if boxes.is_empty() {
        return Tree::default();
    }
    let nodes = match clustered(boxes, effort) {
        Some(nodes) if depth(&nodes) <= levels => nodes,
        _ => from_top(boxes, (0..boxes.len() as u32).collect(), levels),
    };
    Tree { nodes }
}

fn from_top(boxes: &[Aabb], mut slots: Vec<u32>, levels: u32) -> Vec<Bvh2Node> {
    let mut nodes = vec![Bvh2Node::default()];
    nodes[0] = topdown::build(boxes, &mut slots, levels, &mut nodes);
    nodes
}

/// A tree by way of obvhs, leaves naming boxes, or none where it is not to be used.
fn clustered(boxes: &[Aabb], effort: Effort) -> Option<Vec<Bvh2Node>> {
    let total = boxes.par_iter().copied().reduce(Aabb::empty, |a, b| a.union(&b));
    if total.diagonal().max_element() <= MIN_EXTENT {
        return None;
    }
    let (order, runs) = degenerate_runs(boxes, &total);
    if runs.is_empty() {
        return cheapest(boxes, effort);
    }
    // Each run is one box, after the boxes that are in none.
    let mut alone = Vec::new();
    let mut next = 0;
    for run in &runs {
        alone.extend_from_slice(&order[next..run.start]);
        next = run.end;
    }
    alone.extend_from_slice(&order[next..]);
    let mut shapes: Vec<Aabb> = alone.iter().map(|&slot| boxes[slot as usize]).collect();
    shapes.extend(
        runs.iter()
            .map(|run| order[run.clone()].iter().fold(Aabb::empty(), |acc, &slot| acc.union(&boxes[slot as usize]))),
    );
    let mut nodes = cheapest(&shapes, effort)?;
    for i in 0..nodes.len() {
        if nodes[i].is_leaf() {
            let shape = nodes[i].first_index as usize;
            match shape.checked_sub(alone.len()) {
                None => nodes[i].first_index = alone[shape],
                Some(k) => {
                    let mut slots = order[runs[k].clone()].to_vec();
                    let levels = topdown::levels_needed(slots.len()) + 4;
                    // Appended behind `i`'s end of the list, so never visited again here.
                    nodes[i] = topdown::build(boxes, &mut slots, levels, &mut nodes);
                }
            }
        }
    }
    Some(nodes)
}

/// The cheapest of the candidate trees; none when clustering degenerates.
fn cheapest(boxes: &[Aabb], effort: Effort) -> Option<Vec<Bvh2Node>> {
    let slots = || (0..boxes.len() as u32).collect::<Vec<u32>>();
    let usual = if boxes.len() <= RIVALLED { 2 } else { 1 };
    let cluster = |(distance, threshold), times| {
        let builder = &mut PlocBuilder::with_capacity(boxes.len());
        let mut bvh = builder.build(distance, boxes, slots(), effort.precision(), threshold);
        if bvh.max_depth > MAX_ROUNDS {
            return None;
        }
        effort.optimise(&mut bvh, times);
        Some(bvh.nodes)
    };
    let mut best = cluster(effort.clustering(), usual)?;
    let mut rivals = Vec::new();
    if boxes.len() <= RIVALLED {
        let nodes = from_top(boxes, slots(), RIVAL_LEVELS);
        let mut bvh = Bvh2 { nodes, primitive_indices: slots(), ..Bvh2::default() };
        effort.optimise(&mut bvh, usual);
        rivals.push(bvh.nodes);
    }
    if boxes.len() <= EXHAUSTED {
        use PlocSearchDistance::{High, Low, Medium, Minimum, VeryHigh, VeryLow};
        // Reinsertion lowers the cost of the binary tree; the one of four children per node made
        // from it may have been cheaper before.
        for times in [0, 1, usual] {
            let distances = [Minimum, VeryLow, Low, Medium, High, VeryHigh];
            rivals.extend(distances.into_iter().filter_map(|d| cluster((d, 0), times)));
        }
    }
    if !rivals.is_empty() {
        let mut least = Effort::cost(&best);
        for nodes in rivals {
            let cost = Effort::cost(&nodes);
            if cost < least {
                (best, least) = (nodes, cost);
            }
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;

    const MEDIUM: Effort = Effort { quality: Quality::Medium, scene: 1 << 20 };

    fn cube(x: f32, size: f32) -> Aabb {
        Aabb::new(Vec3A::new(x, 0.0, 0.0), Vec3A::new(x + size, size, size))
    }

    /// Each primitive is in one leaf; boxes contain everything below them.
    fn check(tree: &Tree, boxes: &[Aabb]) {
        let mut references = vec![0; boxes.len()];
        for node in &tree.nodes {
            if node.is_leaf() {
                references[node.first_index as usize] += 1;
                assert_eq!(*node.aabb(), boxes[node.first_index as usize]);
            } else {
                for k in 0..2 {
                    let child = &tree.nodes[(node.first_index + k) as usize];
                    assert_eq!(node.aabb().union(child.aabb()), *node.aabb());
                }
            }
        }
        assert!(references.iter().all(|&m| m == 1));
        assert_eq!(tree.nodes.len(), 2 * boxes.len() - 1);
    }

    #[test]
    fn depth_stays_within_the_limit() {
        // Sizes that double make clustering as lopsided as it gets.
        let lopsided: Vec<Aabb> =
            (0..120).map(|k| cube((k as f32).exp2() * 1e-18, (k as f32).exp2() * 1e-18)).collect();
        let row: Vec<Aabb> = (0..5000).map(|k| cube(k as f32, 1.0)).collect();
        let mut bounded = 0;
        for boxes in [&lopsided[..100], &row] {
            let free = build(boxes, MEDIUM, 1000);
            check(&free, boxes);
            for levels in [topdown::levels_needed(boxes.len()), 14, 20, 62] {
                let tree = build(boxes, MEDIUM, levels);
                check(&tree, boxes);
                assert!(tree.depth() <= levels, "{} of {levels}", tree.depth());
                bounded += u32::from(free.depth() > levels);
            }
        }
        assert!(bounded >= 2, "the bound never mattered");
    }
}
