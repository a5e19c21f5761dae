//! A top-down builder with a depth that is bounded beforehand: binned SAH while levels are to
//! spare, halves otherwise.
//!
//! It replaces the clustering builder where that one would degenerate (see [`crate::tree`]). The
//! binned surface area heuristic is that of Wald, "On fast construction of SAH-based bounding
//! volume hierarchies" (2007).

use obvhs::{aabb::Aabb, bvh2::node::Bvh2Node};

const BINS: usize = 16;

/// Levels of inner nodes that `count` leaves need at least.
pub(crate) fn levels_needed(count: usize) -> u32 {
    count.max(1).next_power_of_two().trailing_zeros()
}

/// Appends a tree over `prims` (indices into `boxes`, not empty) to `nodes` and returns its root,
/// which is not itself appended: the caller puts it where it belongs. No path holds more than
/// `max(levels, levels_needed)` inner nodes.
pub(crate) fn build(boxes: &[Aabb], prims: &mut [u32], levels: u32, nodes: &mut Vec<Bvh2Node>) -> Bvh2Node {
    let mut root = leaf(boxes, prims[0]);
    // (where the node goes; None: the root), range of prims, levels left below and with this node
    let mut work = vec![(None, 0, prims.len(), levels.max(levels_needed(prims.len())))];
    while let Some((slot, start, end, levels)) = work.pop() {
        let node = if end - start == 1 {
            leaf(boxes, prims[start])
        } else {
            let part = &mut prims[start..end];
            let bounds = part.iter().fold(Aabb::empty(), |b, &p| b.union(&boxes[p as usize]));
            let left = if levels <= levels_needed(part.len()) { halve(boxes, part) } else { split(boxes, part) };
            let first = nodes.len();
            nodes.resize(first + 2, Bvh2Node::default());
            work.push((Some(first), start, start + left, levels - 1));
            work.push((Some(first + 1), start + left, end, levels - 1));
            Bvh2Node::new(bounds, 0, first as u32)
        };
        match slot {
            Some(i) => nodes[i] = node,
            None => root = node,
        }
    }
    root
}

fn leaf(boxes: &[Aabb], prim: u32) -> Bvh2Node {
    Bvh2Node::new(boxes[prim as usize], 1, prim)
}

/// Twice the centroid; the factor does not matter for order.
fn center(b: &Aabb, axis: usize) -> f32 {
    b.min[axis] + b.max[axis]
}

fn centers(boxes: &[Aabb], prims: &[u32]) -> Aabb {
    prims.iter().fold(Aabb::empty(), |mut acc, &p| {
        let b = &boxes[p as usize];
        *acc.extend(b.min + b.max)
    })
}

/// Two halves by count: along the widest axis of the centroids, or by size when they all coincide.
fn halve(boxes: &[Aabb], prims: &mut [u32]) -> usize {
    let middle = prims.len() / 2;
    let spread = centers(boxes, prims);
    let axis = spread.largest_axis();
    if spread.diagonal()[axis] > 0.0 {
        prims.select_nth_unstable_by(middle, |&a, &b| {
            center(&boxes[a as usize], axis).total_cmp(&center(&boxes[b as usize], axis)).then(a.cmp(&b))
        });
    } else {
        prims.select_nth_unstable_by(middle, |&a, &b| {
            boxes[a as usize].half_area().total_cmp(&boxes[b as usize].half_area()).then(a.cmp(&b))
        });
    }
    middle
}

/// The best of 15 planes per axis by count × area; halves when none separates.
fn split(boxes: &[Aabb], prims: &mut [u32]) -> usize {
    if prims.len() < 4 {
        return halve(boxes, prims);
    }
    let spread = centers(boxes, prims);
    let extent = spread.diagonal();
    let bin = |b: &Aabb, axis: usize| {
        let x = (center(b, axis) - spread.min[axis]) / extent[axis] * BINS as f32;
        (x as usize).min(BINS - 1)
    };
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        if extent[axis] <= 0.0 {
            continue;
        }
        let mut bins = [(Aabb::empty(), 0usize); BINS];
        for &p in prims.iter() {
            let b = &boxes[p as usize];
            let slot = &mut bins[bin(b, axis)];
            *slot = (slot.0.union(b), slot.1 + 1);
        }
        let mut right = [0.0; BINS];
        let mut acc = (Aabb::empty(), 0usize);
        for k in (1..BINS).rev() {
            acc = (acc.0.union(&bins[k].0), acc.1 + bins[k].1);
            right[k] = if acc.1 == 0 { f32::INFINITY } else { acc.0.half_area() * acc.1 as f32 };
        }
        let mut acc = (Aabb::empty(), 0usize);
        for k in 1..BINS {
            acc = (acc.0.union(&bins[k - 1].0), acc.1 + bins[k - 1].1);
            if acc.1 > 0 {
                let cost = acc.0.half_area() * acc.1 as f32 + right[k];
                if cost < best.0 {
                    best = (cost, axis, k);
                }
            }
        }
    }
    if best.0 == f32::INFINITY {
        return halve(boxes, prims);
    }
    let (_, axis, plane) = best;
    let mut left = 0;
    for i in 0..prims.len() {
        if bin(&boxes[prims[i] as usize], axis) < plane {
            prims.swap(left, i);
            left += 1;
        }
    }
    left
}
