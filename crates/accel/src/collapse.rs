//! Which nodes of a binary tree stay when up to four children hang from one node.
//!
//! Chosen for the least Σ area over all ways to do it, by dynamic programming from the leaves up
//! (Wald, Benthin and Boulos 2008; Ylitie, Karras and Laine 2017, section 3): `cost(n, k)` is the
//! least cost of subtree n as at most k children of some node.

use obvhs::bvh2::node::Bvh2Node;

use crate::bounds::bounds_of;

/// How to open each node of a binary tree.
pub(crate) struct Opening {
    /// By node and number of parts less 1: parts of the left side, 0 for "as for one part less".
    ways: Vec<[u8; 4]>,
    /// Σ area of the nodes that stay and of the leaves: items read by a ray, times the area of the
    /// root.
    pub(crate) cost: f64,
}

impl Opening {
    /// For the tree of node 0. Recursion is as deep as the tree: bound its depth first.
    pub(crate) fn plan(nodes: &[Bvh2Node]) -> Self {
        let mut opening = Self { ways: vec![[0; 4]; nodes.len()], cost: 0.0 };
        if !nodes.is_empty() {
            opening.cost = f64::from(opening.visit(nodes, 0)[0]);
        }
        opening
    }

    /// Least costs of a subtree as 1, 2, 3 and 4 parts.
    fn visit(&mut self, nodes: &[Bvh2Node], index: u32) -> [f32; 4] {
        let node = nodes[index as usize];
        let area = bounds_of(&node).half_area();
        if node.is_leaf() {
            return [area; 4];
        }
        let (left, right) = (self.visit(nodes, node.first_index), self.visit(nodes, node.first_index + 1));
        let best = |parts: usize| {
            (1..parts)
                .map(|k| (left[k - 1] + right[parts - k - 1], k as u8))
                .fold((f32::INFINITY, 1), |a, b| if b.0 < a.0 { b } else { a })
        };
        let (opened, way) = best(4);
        let mut costs = [area + opened; 4];
        let mut ways = [way, 0, 0, 0];
        for parts in 2..=4 {
            let (cost, way) = best(parts);
            costs[parts - 1] = costs[parts - 2];
            if cost < costs[parts - 1] {
                costs[parts - 1] = cost;
                ways[parts - 1] = way;
            }
        }
        self.ways[index as usize] = ways;
        costs
    }

    /// Appends the children of an inner node, at most four.
    pub(crate) fn children(&self, nodes: &[Bvh2Node], index: u32, out: &mut Vec<u32>) {
        let first = nodes[index as usize].first_index;
        let way = usize::from(self.ways[index as usize][0]);
        self.parts(nodes, first, way, out);
        self.parts(nodes, first + 1, 4 - way, out);
    }

    fn parts(&self, nodes: &[Bvh2Node], index: u32, parts: usize, out: &mut Vec<u32>) {
        let node = &nodes[index as usize];
        let way = usize::from(self.ways[index as usize][parts - 1]);
        if node.is_leaf() || parts == 1 {
            out.push(index);
        } else if way == 0 {
            self.parts(nodes, index, parts - 1, out);
        } else {
            self.parts(nodes, node.first_index, way, out);
            self.parts(nodes, node.first_index + 1, parts - way, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3A;
    use obvhs::aabb::Aabb;

    /// The least cost by trying every set of nodes to keep.
    fn exhaustive(nodes: &[Bvh2Node]) -> f64 {
        let inner: Vec<usize> = (1..nodes.len()).filter(|&i| !nodes[i].is_leaf()).collect();
        let area = |i: usize| f64::from(nodes[i].aabb().half_area());
        let leaves: f64 = (0..nodes.len()).filter(|&i| nodes[i].is_leaf()).map(area).sum();
        fn width(nodes: &[Bvh2Node], kept: &[bool], i: usize) -> usize {
            (0..2)
                .map(|k| nodes[i].first_index as usize + k)
                .map(|c| if kept[c] { 1 } else { width(nodes, kept, c) })
                .sum()
        }
        (0..1u32 << inner.len())
            .filter_map(|mask| {
                let mut kept: Vec<bool> = nodes.iter().map(Bvh2Node::is_leaf).collect();
                kept[0] = true;
                inner.iter().enumerate().for_each(|(bit, &i)| kept[i] = mask >> bit & 1 == 1);
                let held: Vec<usize> = (0..nodes.len()).filter(|&i| kept[i] && !nodes[i].is_leaf()).collect();
                let fits = held.iter().all(|&i| width(nodes, &kept, i) <= 4);
                fits.then(|| leaves + held.into_iter().map(area).sum::<f64>())
            })
            .fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_plan_is_the_best_of_all() {
        for seed in 0..60u32 {
            let mut state = seed * 77 + 1;
            let mut next = || {
                state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
                (state >> 16) as f32 / 65536.0
            };
            let boxes: Vec<Aabb> = (0..2 + seed as usize % 11)
                .map(|_| {
                    let p = Vec3A::new(next(), next(), next()) * 9.0;
                    Aabb::new(p, p + Vec3A::new(next(), next(), next()))
                })
                .collect();
            let mut nodes = vec![Bvh2Node::default()];
            let mut prims: Vec<u32> = (0..boxes.len() as u32).collect();
            nodes[0] = crate::topdown::build(&boxes, &mut prims, 40, &mut nodes);
            let opening = Opening::plan(&nodes);
            let best = exhaustive(&nodes);
            assert!((opening.cost - best).abs() <= 1e-5 * best, "{seed}: {} against {best}", opening.cost);
            // The tree read off then has the planned cost.
            let (mut cost, mut work) = (0.0, vec![0u32]);
            while let Some(i) = work.pop() {
                cost += f64::from(nodes[i as usize].aabb().half_area());
                if !nodes[i as usize].is_leaf() {
                    let before = work.len();
                    opening.children(&nodes, i, &mut work);
                    assert!((2..=4).contains(&(work.len() - before)));
                }
            }
            assert!((cost - best).abs() <= 1e-5 * best, "{seed}: {cost} against {best}");
        }
    }
}
