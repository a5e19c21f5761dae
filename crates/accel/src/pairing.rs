//! Triangles that share an edge, two to a leaf.

use glam::Vec3;
use rayon::prelude::*;

use crate::triangle::Triangle;

/// Second place of a leaf with one triangle.
pub(crate) const ALONE: u32 = u32::MAX;
/// Two triangles are kept together when the area of the box around both is at most this times the
/// sum of theirs: testing both whenever the ray hits the common box then costs no more than testing
/// each when the ray hits its own box.
const MAX_AREA_GROWTH: f32 = 1.1;

/// Triangles compared around one edge; a sound mesh has two.
const MAX_TRIANGLES_PER_EDGE: usize = 16;

/// For each vertex the first one at the same position, so that faces split by normals or UVs are
/// still joined.
pub(crate) fn welded(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 makes −0 into 0.
    let bits = |p: Vec3| (p + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<([u32; 3], u32)> = positions.par_iter().enumerate().map(|(i, &p)| (bits(p), i as u32)).collect();
    order.par_sort_unstable();
    let mut out = vec![0; positions.len()];
    let mut first = (0, [0; 3]);
    for (k, &(key, i)) in order.iter().enumerate() {
        if k == 0 || key != first.1 {
            first = (i, key);
        }
        out[i as usize] = first.0;
    }
    out
}

/// Leaves over `triangles`, whose corners are the vertices `corners`: pairs that run along a common
/// edge in opposite directions, chosen greedily by the least common box, and the remaining
/// triangles, with [`ALONE`].
pub(crate) fn pairs(triangles: &[Triangle], corners: &[[u32; 3]], vertices: usize) -> Vec<[u32; 2]> {
    // Edges sorted into buckets by their lesser vertex: (greater vertex, triangle × 2 + direction).
    let mut starts = vec![0u32; vertices + 1];
    let edges = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    for t in corners {
        for [a, b] in edges(t) {
            starts[a.min(b) as usize] += 1;
        }
    }
    let mut sum = 0;
    for start in &mut starts {
        sum += *start;
        *start = sum;
    }
    let mut bucketed = vec![(0u32, 0u32); 3 * corners.len()];
    for (i, t) in corners.iter().enumerate() {
        for [a, b] in edges(t) {
            let at = &mut starts[a.min(b) as usize];
            *at -= 1;
            bucketed[*at as usize] = (a.max(b), (i as u32) << 1 | u32::from(a < b));
        }
    }
    // Each bucket in order, so that an edge is found by bisection however many triangles share a
    // vertex.
    for span in starts.windows(2) {
        bucketed[span[0] as usize..span[1] as usize].sort_unstable();
    }

    let mut free = vec![true; triangles.len()];
    let mut leaves = Vec::with_capacity(triangles.len() / 2 + 1);
    for (i, t) in corners.iter().enumerate() {
        if !std::mem::take(&mut free[i]) {
            continue;
        }
        let mine = triangles[i].tight();
        let mut best = (f32::INFINITY, ALONE);
        for [a, b] in edges(t) {
            let low = a.min(b) as usize;
            let bucket = &bucketed[starts[low] as usize..starts[low + 1] as usize];
            let first = bucket.partition_point(|half| half.0 < a.max(b));
            for &(_, half) in bucket[first..].iter().take_while(|half| half.0 == a.max(b)).take(MAX_TRIANGLES_PER_EDGE)
            {
                let j = half >> 1;
                if (half & 1 == 1) != (a < b) && free[j as usize] {
                    let theirs = triangles[j as usize].tight();
                    let area = mine.union(theirs).half_area();
                    if area < best.0 && area <= MAX_AREA_GROWTH * (mine.half_area() + theirs.half_area()) {
                        best = (area, j);
                    }
                }
            }
        }
        if best.1 != ALONE {
            free[best.1 as usize] = false;
        }
        leaves.push([i as u32, best.1]);
    }
    leaves
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let positions = (0..n + 1).flat_map(|k| [Vec3::new(k as f32, 0.0, 0.0), Vec3::new(k as f32, 1.0, 0.3)]);
        let quads = (0..n).flat_map(|k| [[2 * k, 2 * k + 2, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 1]]);
        (positions.collect(), quads.collect())
    }

    fn leaves(positions: &[Vec3], indices: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let triangles: Vec<Triangle> =
            indices.iter().map(|t| Triangle::new(t.map(|i| positions[i as usize])).unwrap()).collect();
        let weld = welded(positions);
        let corners: Vec<[u32; 3]> = indices.iter().map(|t| t.map(|i| weld[i as usize])).collect();
        pairs(&triangles, &corners, positions.len())
    }

    #[test]
    fn quads_become_pairs_also_where_vertices_are_split() {
        let (positions, indices) = strip(50);
        let split: Vec<Vec3> = indices.iter().flatten().map(|&i| positions[i as usize]).collect();
        let loose: Vec<[u32; 3]> = (0..100).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        for found in [leaves(&positions, &indices), leaves(&split, &loose)] {
            assert!(found.iter().enumerate().all(|(k, l)| *l == [2 * k as u32, 2 * k as u32 + 1]), "{found:?}");
        }
    }

    #[test]
    fn each_triangle_is_in_one_leaf_and_windings_must_agree() {
        let (positions, mut indices) = strip(9);
        indices.swap(3, 12);
        for t in indices.iter_mut().step_by(2) {
            t.swap(0, 1);
        }
        let found = leaves(&positions, &indices);
        let mut hits: Vec<u32> = found.iter().flatten().copied().filter(|&t| t != ALONE).collect();
        hits.sort_unstable();
        assert_eq!(hits, (0..18).collect::<Vec<_>>());
        for [a, b] in found.into_iter().filter(|l| l[1] != ALONE) {
            let edges = |t: [u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
            let shared = edges(indices[a as usize]).iter().any(|&[p, q]| edges(indices[b as usize]).contains(&[q, p]));
            assert!(shared, "{a} and {b}");
        }
    }
}
