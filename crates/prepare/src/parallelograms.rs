//! Pairs of triangles that form parallelograms: as one light they are sampled better than as two.

use std::collections::HashMap;

use glam::Vec3;

/// A triangle, or two that form a parallelogram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Facet {
    /// The triangle, by its place in the list.
    pub(super) triangle: usize,
    /// Which of its corners comes first: of a parallelogram the one that the other triangle lacks.
    pub(super) corner: usize,
    /// The triangle beyond the opposite edge.
    pub(super) other: Option<usize>,
}

/// How far a fourth corner may be from where a parallelogram has it: in roundings of the corners'
/// coordinates ...
const ROUNDINGS: f32 = 4.0 * f32::EPSILON;
/// ... and as a share of the shorter side. It is also the share of its light that could be sampled
/// twice or not at all.
const SHARE: f32 = 1e-5;

/// Triangles as they come, each alone.
pub(super) fn unpaired(count: usize) -> Vec<Facet> {
    (0..count).map(|triangle| Facet { triangle, corner: 0, other: None }).collect()
}

/// Joins triangles in pairs, those with the longest common edges first, which leaves a mesh of
/// rectangles as it was made. Both triangles of a pair face the same side. Pieces come in the order
/// of their first triangles.
pub(super) fn join(triangles: &[[Vec3; 3]]) -> Vec<Facet> {
    // −0 is 0.
    let bits = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let mut edges = HashMap::new();
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            edges.insert((bits(t[(k + 1) % 3]), bits(t[(k + 2) % 3])), (i, k));
        }
    }
    let mut pairs = Vec::new();
    for (i, t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|n| t[(k + n) % 3]);
            // The neighbour goes along the edge the other way.
            let Some(&(j, l)) = edges.get(&(bits(c), bits(b))) else { continue };
            let off = (triangles[j][l] - (b + c - a)).length();
            let size = [a, b, c].iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
            let side = (b - a).length().min((c - a).length());
            if i < j && off <= ROUNDINGS * size && off <= SHARE * side {
                pairs.push(((c - b).length(), i, k, j));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut pieces = unpaired(triangles.len());
    let mut taken = vec![false; triangles.len()];
    let mut joined = vec![false; triangles.len()];
    for (_, i, corner, j) in pairs {
        if !taken[i] && !taken[j] {
            (taken[i], taken[j], joined[j]) = (true, true, true);
            pieces[i] = Facet { triangle: i, corner, other: Some(j) };
        }
    }
    pieces.retain(|piece| !joined[piece.triangle]);
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: usize, y: usize) -> Vec3 {
        Vec3::new(0.1 * x as f32, 0.3 * y as f32, 0.7 - 0.2 * x as f32)
    }

    /// A grid of rectangles, each of two triangles whose first corners vary.
    fn grid(n: usize) -> Vec<[Vec3; 3]> {
        let cell = |k: usize| {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| corner(k % n + x, k / n + y));
            let mut pair = [[a, b, c], [a, c, d]];
            pair[0].rotate_left(k % 3);
            pair[1].rotate_left(k / 3 % 3);
            pair
        };
        (0..n * n).flat_map(cell).collect()
    }

    #[test]
    fn rectangles_of_a_grid_are_found() {
        let triangles = grid(7);
        let pieces = join(&triangles);
        assert_eq!(pieces.len(), 49);
        for (cell, piece) in pieces.iter().enumerate() {
            assert_eq!((piece.triangle, piece.other), (2 * cell, Some(2 * cell + 1)));
            let [a, b, c] = [0, 1, 2].map(|n| triangles[piece.triangle][(piece.corner + n) % 3]);
            let fourth = b + c - a;
            assert!(triangles[2 * cell + 1].iter().any(|p| (p - fourth).length() < 1e-6), "{piece:?}");
            assert!((b - a).dot(c - a).abs() < 1e-6, "{piece:?} is askew");
        }
    }

    #[test]
    fn others_stay_alone() {
        let [a, b, c, d] = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let bent = d + 1e-3 * Vec3::Z;
        let kite = d - 0.1 * Vec3::X;
        for pair in [[[a, b, c], [a, c, bent]], [[a, b, c], [a, c, kite]], [[a, b, c], [a, d, c]]] {
            assert_eq!(join(&pair), unpaired(2), "{pair:?}");
        }
        assert_eq!(join(&[[a, b, c], [a, c, d]]).len(), 1);
        assert!(join(&[]).is_empty());
    }
}
