//! The trees of a scene before they are flattened: one at the top, one for each mesh that is placed as instances.

use glam::{DMat3, DVec3, Vec3A};
use obvhs::{aabb::Aabb, splits::split_aabbs_preset};
use rayon::prelude::*;

use crate::{
    AccelError, Bounds, BuildOptions, Layout, MOST_STACK, Quality,
    bounds::bounds_of,
    item,
    placement::{Placed, Placement, Soup},
    tree::{self, Effort, Tree},
    wide,
};

/// Depth that either tree is cut to when the two together are too deep for the stack: 30 + 1 + 30 ≤ 62, and 2^30 leaves
/// are more than can be numbered.
const BOUNDED_LEVELS: u32 = 30;
/// Boxes of a mesh's tree that an instance's box is fitted to.
const FITTED_BOXES: usize = 64;

pub(crate) struct Forest {
    /// Primitives are the leaves of the world's soup by index, then the placements: `leaves + k` is `placements[k]`.
    pub(crate) top: Tree,
    /// One for each mesh that is placed as instances; empty where no triangle of it is sound.
    pub(crate) meshes: Vec<Tree>,
    /// Index into [`Placed::placements`] and box in camera space; without the placements of empty meshes.
    pub(crate) placements: Vec<(usize, Bounds)>,
    depth: u32,
}

impl Forest {
    pub(crate) fn build(placed: &Placed, options: &BuildOptions) -> Result<Self, AccelError> {
        let quality = options.quality;
        let mesh_shapes: Vec<Shapes> = placed
            .meshes
            .par_iter()
            .map(|soup| {
                let reach = soup.triangles.par_iter().map(|t| t.tight().reach()).reduce(|| 0.0, f32::max);
                Shapes::of(soup, quality, reach)
            })
            .collect();
        let mut shapes = Shapes::of(&placed.world, quality, 0.0);
        // A tree of n leaves has n − 1 nodes, or one where n is 1; an empty scene has one.
        let leaves = |s: &Shapes| s.boxes.len() as u64;
        let total = mesh_shapes.iter().map(leaves).sum::<u64>() + leaves(&shapes) + placed.placements.len() as u64;
        let effort = Effort { quality, layout: options.layout, scene: total as usize };
        let limit = match options.layout {
            Layout::Binary => item::MAX_ITEMS,
            Layout::Wide => wide::MAX_ITEMS,
        };
        refuse_excess(2 * total + 1, limit)?;

        let mut meshes: Vec<Tree> =
            mesh_shapes.par_iter().map(|s| tree::build(&s.boxes, &s.indices, effort, MOST_STACK)).collect();
        let placements = fit_placements(placed, &meshes, &shapes);
        shapes.boxes.extend(placements.iter().map(|p| p.1.to_aabb()));
        let first = placed.world.leaves() as u32;
        shapes.indices.extend((0..placements.len() as u32).map(|k| first + k));
        let mut top = tree::build(&shapes.boxes, &shapes.indices, effort, MOST_STACK);

        // Even a tree of one leaf gets a root node.
        let inner = |meshes: &[Tree]| meshes.iter().map(Tree::depth).max().map_or(0, |d| d.max(1) + 1);
        if top.depth() + inner(&meshes) > MOST_STACK {
            for (mesh, s) in meshes.iter_mut().zip(&mesh_shapes) {
                if mesh.depth() > BOUNDED_LEVELS {
                    *mesh = tree::build(&s.boxes, &s.indices, effort, BOUNDED_LEVELS);
                }
            }
        }
        if top.depth() + inner(&meshes) > MOST_STACK {
            top = tree::build(&shapes.boxes, &shapes.indices, effort, BOUNDED_LEVELS);
        }
        let depth = top.depth().max(1) + inner(&meshes);
        Ok(Self { top, meshes, placements, depth })
    }

    /// Most entries on the stack of a walk through both levels.
    pub(crate) fn stack_depth(&self) -> u32 {
        self.depth
    }

    pub(crate) fn bounds(&self) -> Bounds {
        self.top.nodes.first().map_or(Bounds::EMPTY, bounds_of)
    }
}

/// What a tree is built over: box k belongs to primitive `indices[k]`.
struct Shapes {
    boxes: Vec<Aabb>,
    indices: Vec<u32>,
}

impl Shapes {
    fn of(soup: &Soup, quality: Quality, mesh_reach: f32) -> Self {
        let mut indices: Vec<u32> = (0..soup.leaves() as u32).collect();
        if !soup.pairs.is_empty() {
            let bounds = |i: u32| soup.triangles.get(i as usize).map_or(Bounds::EMPTY, |t| t.bounds(mesh_reach));
            let boxes = soup.pairs.par_iter().map(|&[a, b]| bounds(a).union(bounds(b)).to_aabb()).collect();
            return Self { boxes, indices };
        }
        if quality != Quality::Slow || soup.triangles.is_empty() {
            let boxes = soup.triangles.par_iter().map(|t| t.bounds(mesh_reach).to_aabb()).collect();
            return Self { boxes, indices };
        }
        let mut boxes: Vec<Aabb> = soup.triangles.par_iter().map(|t| t.tight().to_aabb()).collect();
        let triangles: Vec<obvhs::triangle::Triangle> = soup
            .triangles
            .par_iter()
            .map(|t| {
                let [v0, v1, v2] = t.0.map(Vec3A::from);
                obvhs::triangle::Triangle { v0, v1, v2 }
            })
            .collect();
        let areas = || boxes.iter().map(Aabb::half_area);
        let mean = (areas().map(f64::from).sum::<f64>() / boxes.len() as f64) as f32;
        let largest = areas().fold(0.0, f32::max);
        split_aabbs_preset(&mut boxes, &mut indices, &triangles, mean, largest);
        // A cut is computed in f32, off by some 2^-22 of an edge: twice the usual margin holds that too.
        boxes.par_iter_mut().zip(&indices).for_each(|(b, &i)| {
            let triangle = &soup.triangles[i as usize];
            let margin = 2.0 * triangle.margin(triangle.tight().reach().max(mesh_reach));
            *b = Bounds { lo: b.min.into(), hi: b.max.into() }.padded(margin).to_aabb();
        });
        Self { boxes, indices }
    }
}

fn refuse_excess(needed: u64, limit: u64) -> Result<(), AccelError> {
    if needed > limit {
        return Err(AccelError::TooManyItems { needed, limit });
    }
    Ok(())
}

fn fit_placements(placed: &Placed, meshes: &[Tree], world: &Shapes) -> Vec<(usize, Bounds)> {
    let cuts: Vec<Vec<Bounds>> = meshes.iter().map(cut).collect();
    // Rays start anywhere in the scene or at the camera, so first see how far that reaches.
    let loose = |p: &Placement| {
        cuts[p.mesh].first().map_or(0.0, |&first| {
            let all = cuts[p.mesh].iter().fold(first, |acc, &b| acc.union(b));
            all.transformed(&p.to_world, DVec3::ZERO).reach()
        })
    };
    let total = world.boxes.par_iter().copied().reduce(Aabb::empty, |a, b| a.union(&b));
    let own = if world.boxes.is_empty() { 0.0 } else { total.min.abs().max(total.max.abs()).max_element() };
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

/// How far, in camera space, a ray can be moved by bringing it to object space in f32: each of its two ends is within
/// 3 `reach` of the camera and is multiplied and summed with four roundings.
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
        assert_eq!(error, AccelError::TooManyItems { needed: (1 << 28) + 1, limit: 1 << 28 });
        assert!(error.to_string().contains("268435457") && error.to_string().contains("17 GiB"), "{error}");
    }
}
