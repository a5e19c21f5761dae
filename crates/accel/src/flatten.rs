//! From binary trees, opened to four children per node ([`crate::collapse`]), to the items that a
//! kernel reads.

use glam::Vec3;

use crate::{
    Bounds, TriangleSource,
    bounds::bounds_of,
    collapse::Opening,
    forest::Forest,
    item::{Item, Kind},
    pairing::ALONE,
    placement::{Placed, Soup},
    records::rows,
    tree::Tree,
};

/// A flattened forest.
#[derive(Default)]
pub(crate) struct Flat {
    pub(crate) items: Vec<Item>,
    /// By prim id.
    pub(crate) triangles: Vec<TriangleSource>,
    /// Σ area × items read over the top-level tree, over the area of its bounds.
    pub(crate) sah: f64,
    /// Maximum number of entries on the traversal stack.
    pub(crate) depth: u32,
}

pub(crate) fn flatten(placed: &Placed, forest: &Forest) -> Flat {
    let mut out = Flat::default();
    let leaves: usize = placed.meshes.iter().map(|soup| soup.pairs.len()).sum::<usize>() + placed.world.pairs.len();
    out.items.reserve(leaves + leaves / 2 + 2 * forest.placements.len() + 2);

    let roots = |items: &mut Vec<Item>| {
        let root = items.len() as u32;
        items.push(Item::default());
        root
    };
    let top = {
        let root = roots(&mut out.items);
        let placement = |k: u32| {
            let p = &placed.placements[forest.placements[k as usize].0];
            // The root item of the mesh is not known yet: its number is a placeholder until it is.
            Item::instance(&rows(&p.to_object), p.mesh as u32, k)
        };
        let mut writer = Writer::new(&mut out, &forest.top, &placed.world, &placement);
        writer.root(root);
        let area = f64::from(forest.bounds().half_area());
        let (cost, depth) = (writer.cost, writer.depth);
        out.sah = if area > 0.0 { cost / area } else { 0.0 };
        depth
    };
    let top_end = out.items.len();
    let mut inner = 0;
    let mut root_of = Vec::new();
    for (tree, soup) in forest.meshes.iter().zip(&placed.meshes) {
        root_of.push(out.items.len() as u32);
        if !tree.nodes.is_empty() {
            let root = roots(&mut out.items);
            let mut writer = Writer::new(&mut out, tree, soup, &|_| Item::default());
            writer.root(root);
            // One to spare.
            inner = inner.max(writer.depth + 1);
        }
    }
    for item in &mut out.items[..top_end] {
        if item.kind() == Kind::Instance {
            item.0[13] = root_of[item.0[13] as usize];
        }
    }
    out.depth = top + inner;
    out
}

struct Writer<'a> {
    out: &'a mut Flat,
    tree: &'a Tree,
    soup: &'a Soup,
    placement: &'a dyn Fn(u32) -> Item,
    opening: Opening,
    cost: f64,
    /// Maximum number of nodes on a path.
    depth: u32,
}

impl<'a> Writer<'a> {
    fn new(out: &'a mut Flat, tree: &'a Tree, soup: &'a Soup, placement: &'a dyn Fn(u32) -> Item) -> Self {
        Self { out, tree, soup, placement, opening: Opening::plan(&tree.nodes), cost: 0.0, depth: 1 }
    }

    fn root(&mut self, slot: u32) {
        match self.tree.nodes.first().map(|n| n.is_leaf()) {
            None => self.out.items[slot as usize] = Item::node(&[], 0),
            Some(true) => self.group(slot, &[0], 1),
            Some(false) => self.node(slot, 0, 1),
        }
    }

    fn bounds(&self, index: u32) -> Bounds {
        bounds_of(&self.tree.nodes[index as usize])
    }

    fn node(&mut self, slot: u32, index: u32, depth: u32) {
        let mut children = Vec::with_capacity(4);
        self.opening.children(&self.tree.nodes, index, &mut children);
        self.cost += f64::from(self.bounds(index).half_area());
        self.group(slot, &children, depth);
    }

    /// Writes a node at `slot` and its children behind everything written so far.
    fn group(&mut self, slot: u32, children: &[u32], depth: u32) {
        self.depth = self.depth.max(depth);
        let base = self.out.items.len() as u32;
        let boxes: Vec<Bounds> = children.iter().map(|&c| self.bounds(c)).collect();
        self.out.items[slot as usize] = Item::node(&boxes, base);
        self.out.items.resize(base as usize + children.len(), Item::default());
        // Leaves first, so that prim ids ascend along the stream.
        for (item, &child) in (base..).zip(children) {
            let node = self.tree.nodes[child as usize];
            if node.is_leaf() {
                self.cost += f64::from(bounds_of(&node).half_area());
                self.out.items[item as usize] = self.leaf(node.first_index);
            }
        }
        for (item, &child) in (base..).zip(children) {
            if !self.tree.nodes[child as usize].is_leaf() {
                self.node(item, child, depth + 1);
            }
        }
    }

    fn leaf(&mut self, index: u32) -> Item {
        if let Some(k) = index.checked_sub(self.soup.pairs.len() as u32) {
            return (self.placement)(k);
        }
        let [a, b] = self.soup.pairs[index as usize];
        let of = |t: u32| (self.soup.triangles[t as usize].0, self.soup.sources[t as usize]);
        let (mut va, mut source) = of(a);
        if b == ALONE {
            let prim = self.prim(source);
            return Item::pair([va[0], va[1], va[2], va[2]], [prim; 2]);
        }
        let (mut vb, mut other) = of(b);
        // Turn both until the common edge is A's second, v1 to v2, and B's second backwards.
        let ends = |v: &[Vec3; 3], k: usize| [v[(k + 1) % 3], v[(k + 2) % 3]];
        let turn = (0..9).find(|k| {
            let [p, q] = ends(&va, k / 3);
            ends(&vb, k % 3) == [q, p]
        });
        // Pairs are made along such an edge, so one is always found.
        let turn = turn.unwrap_or(0);
        va.rotate_left(turn / 3);
        source.corners.rotate_left(turn / 3);
        vb.rotate_left(turn % 3);
        other.corners.rotate_left(turn % 3);
        let prims = [self.prim(source), self.prim(other)];
        Item::pair([va[0], va[1], va[2], vb[0]], prims)
    }

    fn prim(&mut self, source: TriangleSource) -> u32 {
        self.out.triangles.push(source);
        self.out.triangles.len() as u32 - 1
    }
}
