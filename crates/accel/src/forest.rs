//! The trees of a scene before they are flattened: one at the top, one for each mesh that is placed
//! as instances.

use glam::{DMat3, DVec3};
use obvhs::aabb::Aabb;
use rayon::prelude::*;

use crate::{
    AccelError, Bounds, BuildOptions, MAX_STACK_DEPTH,
    bounds::bounds_of,
    item,
    placement::{Placed, Placement, Soup},
    tree::{self, Effort, Tree},
};

/// Depth that either tree is cut to when the two together are too deep for the stack: 30 + 1 + 30 ≤
/// 62, and 2^30 leaves are more than can be numbered.
const BOUNDED_LEVELS: u32 = 30;
/// Boxes of a mesh's tree that an instance's box is fitted to.
const FITTED_BOXES: usize = 64;

pub(crate) struct Forest {
    /// Primitives are the leaves of the world's soup by index, then the placements: `leaves + k` is
    /// `placements[k]`.
    pub(crate) top: Tree,
    /// One for each mesh that is placed as instances; empty where no triangle of it is sound.
    pub(crate) meshes: Vec<Tree>,
    /// Index into [`Placed::placements`] and box in camera space; without the placements of empty
    /// meshes.
    pub(crate) placements: Vec<(usize, Bounds)>,
}

impl Forest {
    pub(crate) fn build(placed: &Placed, options: &BuildOptions) -> Result<Self, AccelError> {
        let mesh_boxes: Vec<Vec<Aabb>> = placed
            .meshes
            .par_iter()
            .map(|soup| {
                let reach = soup.triangles.par_iter().map(|t| t.tight().reach()).reduce(|| 0.0, f32::max);
                leaf_boxes(soup, reach)
            })
            .collect();
        let mut boxes = leaf_boxes(&placed.world, 0.0);
        // A tree of n leaves has n − 1 nodes, or one where n is 1; an empty scene has one.
        let total = mesh_boxes.iter().map(Vec::len).sum::<usize>() + boxes.len() + placed.placements.len();
        let effort = Effort { quality: options.quality, scene: total };
        refuse_excess(2 * total as u64 + 1, item::MAX_ITEMS)?;

        let mut meshes: Vec<Tree> =
            mesh_boxes.par_iter().map(|boxes| tree::build(boxes, effort, MAX_STACK_DEPTH)).collect();
        let placements = fit_placements(placed, &meshes, &boxes);
        boxes.extend(placements.iter().map(|p| p.1.to_aabb()));
        let mut top = tree::build(&boxes, effort, MAX_STACK_DEPTH);

        // Even a tree of one leaf gets a root node.
        let inner = |meshes: &[Tree]| meshes.iter().map(Tree::depth).max().map_or(0, |d| d.max(1) + 1);
        if top.depth() + inner(&meshes) > MAX_STACK_DEPTH {
            for (mesh, boxes) in meshes.iter_mut().zip(&mesh_boxes) {
                if mesh.depth() > BOUNDED_LEVELS {
                    *mesh = tree::build(boxes, effort, BOUNDED_LEVELS);
                }
            }
        }
        if top.depth() + inner(&meshes) > MAX_STACK_DEPTH {
            top = tree::build(&boxes, effort, BOUNDED_LEVELS);
        }
        Ok(Self { top, meshes, placements })
    }

    pub(crate) fn bounds(&self) -> Bounds {
        self.top.nodes.first().map_or(Bounds::EMPTY, bounds_of)
    }
}

/// Boxes of a soup's leaves, which a tree is built over; `mesh_reach` as in
/// [`crate::triangle::Triangle::bounds`].
fn leaf_boxes(soup: &Soup, mesh_reach: f32) -> Vec<Aabb> {
    let bounds = |i: u32| soup.triangles.get(i as usize).map_or(Bounds::EMPTY, |t| t.bounds(mesh_reach));
    soup.pairs.par_iter().map(|&[a, b]| bounds(a).union(bounds(b)).to_aabb()).collect()
}

fn refuse_excess(needed: u64, limit: u64) -> Result<(), AccelError> {
    if needed > limit {
        return Err(AccelError::TooManyItems { needed, limit });
    }
    Ok(())
}

fn fit_placements(placed: &Placed, meshes: &[Tree], world: &[Aabb]) -> Vec<(usize, Bounds)> {
    let cuts: Vec<Vec<Bounds>> = meshes.iter().map(cut).collect();
    // Rays start anywhere in the scene or at the camera, so first see how far that reaches.
    let loose = |p: &Placement| {
        cuts[p.mesh].first().map_or(0.0, |&first| {
            let all = cuts[p.mesh].iter().fold(first, |acc, &b| acc.union(b));
            all.transformed(&p.to_world, DVec3::ZERO).reach()
        })
    };
    let total = world.par_iter().copied().reduce(Aabb::empty, |a, b| a.union(&b));
    let own = if world.is_empty() { 0.0 } else { total.min.abs().max(total.max.abs()).max_element() };
    let reach = placed.placements.par_iter().map(loose).reduce(|| own, f32::max) as f64;
    placed
        .placements
        .par_iter()
        .enumerate()
        .filter(|(_, p)| !cuts[p.mesh].is_empty())
        .map(|(k, p)| {
            let margin = rounding(p, reach);
            let bounds =
                cuts[p.mesh].iter().map(|b| b.transformed(&p.to_world, margin)).fold(Bounds::EMPTY, Bounds::union);
            (k, bounds)
        })
        .collect()
}

/// How far, in camera space, a ray can be moved by bringing it to object space in f32: each of its
/// two ends is within 3 `reach` of the camera and is multiplied and summed with four roundings.
fn rounding(p: &Placement, reach: f64) -> DVec3 {
    let abs = |m: DMat3| DMat3::from_cols(m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    let ends = DVec3::splat(3.0 * reach) + p.to_world.translation.abs();
    abs(p.to_world.matrix3) * (abs(p.to_object.matrix3) * ends) * (8.0 / (1u32 << 24) as f64)
}

/// Boxes near the top of a tree that together hold all of it.
fn cut(tree: &Tree) -> Vec<Bounds> {
    let mut level: Vec<u32> = if tree.nodes.is_empty() { vec![] } else { vec![0] };
    while level.len() * 2 <= FITTED_BOXES {
        let next: Vec<u32> = level
            .iter()
            .flat_map(|&i| {
                let node = &tree.nodes[i as usize];
                let (first, count) = if node.is_leaf() { (i, 1) } else { (node.first_index, 2) };
                first..first + count
            })
            .collect();
        if next.len() == level.len() {
            break;
        }
        level = next;
    }
    level.iter().map(|&i| bounds_of(&tree.nodes[i as usize])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_many_items_are_refused_with_figures() {
        let limit = item::MAX_ITEMS;
        assert_eq!(refuse_excess(limit, limit), Ok(()));
        let error = refuse_excess(limit + 1, limit).unwrap_err();
        assert_eq!(error, AccelError::TooManyItems { needed: 1 << 26, limit: (1 << 26) - 1 });
        assert!(error.to_string().contains("67108864") && error.to_string().contains("4 GiB"), "{error}");
    }
}
