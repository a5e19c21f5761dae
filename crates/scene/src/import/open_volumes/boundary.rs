//! Openings: the areas that the boundary of a set of triangles surrounds.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::sets::Sets;

/// Boundary vertices nearer than this share of the largest coordinate are one: some 30 times the
/// rounding of f32, for exporters that place equal vertices by different sums.
const NEAR: f64 = 1.0 / (1 << 18) as f64;

/// The number of edges from a vertex that are compared, so that a vertex of a million edges takes
/// no more than linear time.
const MAX_WAYS: usize = 32;

/// An opening that boundary edges surround.
pub(super) struct Opening {
    /// A triangle at it.
    pub(super) triangle: u32,
    pub(super) area: f64,
}

/// Two vertices, in the direction in which a triangle has them.
#[derive(Clone, Copy)]
struct Edge {
    from: u32,
    to: u32,
    triangle: u32,
}

/// The openings of triangles, each its number and its corners. Joins the sets of triangles that
/// share an edge or an opening.
pub(super) fn openings(
    positions: &[Vec3],
    triangles: impl Iterator<Item = (u32, [u32; 3])>,
    sets: &mut Sets,
) -> Vec<Opening> {
    let sides =
        |(triangle, [a, b, c]): (u32, [u32; 3])| [[a, b], [b, c], [c, a]].map(|[from, to]| Edge { from, to, triangle });
    let edges = unmatched(triangles.flat_map(sides).collect(), sets);
    // From here on vertices are numbered along the boundary. Each begins an edge, since boundaries
    // are closed.
    let mut vertices: Vec<u32> = edges.iter().map(|edge| edge.from).collect();
    vertices.dedup();
    let at: Vec<DVec3> = vertices.iter().map(|&vertex| positions[vertex as usize].as_dvec3()).collect();
    let near = merge(&at);
    let place = |vertex: u32| near[vertices.partition_point(|&v| v < vertex)];
    let merged = edges.iter().map(|&edge| Edge { from: place(edge.from), to: place(edge.to), ..edge });
    let edges = unmatched(merged.filter(|edge| edge.from != edge.to).collect(), sets);
    walk(&at, edges, sets)
}

/// Edges without one in the opposite direction, by their beginnings. Joins triangles that share an
/// edge.
fn unmatched(mut edges: Vec<Edge>, sets: &mut Sets) -> Vec<Edge> {
    let ends = |edge: &Edge| (edge.from.min(edge.to), edge.from.max(edge.to));
    edges.par_sort_unstable_by_key(|edge| (ends(edge), edge.from, edge.triangle));
    let mut rest = Vec::new();
    for equal in edges.chunk_by(|a, b| ends(a) == ends(b)) {
        equal.iter().for_each(|edge| sets.join(equal[0].triangle, edge.triangle));
        let (forward, backward) = equal.split_at(equal.partition_point(|edge| edge.from < edge.to));
        let (more, less) = if forward.len() > backward.len() { (forward, backward) } else { (backward, forward) };
        rest.extend_from_slice(&more[less.len()..]);
    }
    rest.sort_unstable_by_key(|edge| (edge.from, edge.to, edge.triangle));
    rest
}

/// For each vertex the representative of all that are nearly at its position.
fn merge(at: &[DVec3]) -> Vec<u32> {
    let largest = at.iter().fold(0.0, |largest: f64, p| largest.max(p.abs().max_element()));
    let size = 2.0 * NEAR * largest;
    let mut sets = Sets::new(at.len());
    // Vertices no farther apart than half a cell share one in at least one of these grids.
    for shift in 0..8 {
        let shift = DVec3::from_array([0, 1, 2].map(|axis| if shift >> axis & 1 == 0 { 0.0 } else { 0.5 }));
        let cell = |p: &DVec3| (*p / size + shift).floor().as_ivec3().to_array();
        let mut cells: Vec<([i32; 3], u32)> = at.iter().map(cell).zip(0..).collect();
        cells.par_sort_unstable();
        for equal in cells.chunk_by(|a, b| a.0 == b.0) {
            equal.iter().for_each(|&(_, vertex)| sets.join(equal[0].1, vertex));
        }
    }
    (0..at.len() as u32).map(|vertex| sets.root(vertex)).collect()
}

/// Cuts boundaries into simple cycles. At each vertex the walk takes the sharpest turn, so that a
/// crack between two triangulations of one edge is a separate cycle of no area, and not a part of
/// the cycle around it.
fn walk(at: &[DVec3], mut edges: Vec<Edge>, sets: &mut Sets) -> Vec<Opening> {
    const NOWHERE: usize = usize::MAX;
    // Where the edges of each vertex begin and end that are still to be visited.
    let mut ways = vec![[0; 2]; at.len()];
    for (i, edge) in edges.iter().enumerate() {
        let [first, end] = &mut ways[edge.from as usize];
        if *end == 0 {
            *first = i;
        }
        *end = i + 1;
    }
    let mut openings = Vec::new();
    // Where vertices are on the path: that of an edge's beginning is the edge's place.
    let mut place = vec![NOWHERE; at.len()];
    let mut path: Vec<Edge> = Vec::new();
    for start in 0..at.len() as u32 {
        let mut vertex = start;
        loop {
            let [first, end] = ways[vertex as usize];
            let toward = |to: u32| (at[to as usize] - at[vertex as usize]).normalize_or_zero();
            let back = path.last().map_or(DVec3::ZERO, |edge| toward(edge.from));
            let sharpness = |i: &usize| toward(edges[*i].to).dot(back);
            let compared = end.saturating_sub(MAX_WAYS).max(first)..end;
            let Some(sharpest) = compared.max_by(|a, b| sharpness(a).total_cmp(&sharpness(b))) else { break };
            edges.swap(sharpest, end - 1);
            ways[vertex as usize][1] = end - 1;
            place[vertex as usize] = path.len();
            path.push(edges[end - 1]);
            vertex = edges[end - 1].to;
            let from = place[vertex as usize];
            if from == NOWHERE {
                continue;
            }
            let cycle = &path[from..];
            openings.push(Opening { triangle: cycle[0].triangle, area: surrounded(at, cycle) });
            cycle.iter().for_each(|edge| sets.join(cycle[0].triangle, edge.triangle));
            path.drain(from..).for_each(|edge| place[edge.from as usize] = NOWHERE);
        }
        // Boundaries are closed, so that every walk ends where it began.
        path.drain(..).for_each(|edge| place[edge.from as usize] = NOWHERE);
    }
    openings
}

/// Area of the cone from a cycle's middle: that of the polygon where it is flat and convex, and 0
/// for a crack. (The cycle's area vector would be 0 for the seam of a tennis ball, too.)
fn surrounded(at: &[DVec3], cycle: &[Edge]) -> f64 {
    let ends = |edge: &Edge| [edge.from, edge.to].map(|vertex| at[vertex as usize]);
    let middle = cycle.iter().map(|edge| ends(edge)[0]).sum::<DVec3>() / cycle.len() as f64;
    let sector = |edge| {
        let [a, b] = ends(edge);
        0.5 * (a - middle).cross(b - middle).length()
    };
    cycle.iter().map(sector).sum()
}
