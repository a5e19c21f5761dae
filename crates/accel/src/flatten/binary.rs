//! The plain format of [`crate::item`]: two children's boxes in a node, leaves of up to two triangles, depth first.

use crate::{
    Bounds, Item,
    bounds::bounds_of,
    flatten::Flat,
    forest::Forest,
    item::MORE,
    placement::{Placed, Soup},
    records::rows,
    tree::Tree,
};

pub(crate) fn flatten(placed: &Placed, forest: &Forest) -> Flat {
    let mut out = Flat { depth: forest.stack_depth(), ..Flat::default() };
    let leaves: usize = placed.meshes.iter().map(|s| s.triangles.len()).sum();
    out.items.reserve(2 * (leaves + placed.world.triangles.len() + forest.placements.len()) + 1);
    out.triangles.reserve(leaves + placed.world.triangles.len());

    let placements = |k: u32| {
        let (slot, _) = forest.placements[k as usize];
        let p = &placed.placements[slot];
        // The root item of the mesh is not known yet: its number stands in until it is.
        Item::instance(&rows(&p.to_object), p.mesh as u32, k)
    };
    let top_end = {
        let mut writer = Writer::new(&mut out, &forest.top, &placed.world, &placements);
        writer.root();
        let area = f64::from(forest.bounds().half_area());
        let cost = writer.cost;
        out.sah = if area > 0.0 { cost / area } else { 0.0 };
        out.items.len()
    };

    let roots: Vec<u32> = forest
        .meshes
        .iter()
        .zip(&placed.meshes)
        .map(|(tree, soup)| {
            let root = out.items.len() as u32;
            if !tree.nodes.is_empty() {
                Writer::new(&mut out, tree, soup, &|_| Item::default()).root();
            }
            root
        })
        .collect();
    for item in &mut out.items[..top_end] {
        if item.tag() == crate::item::TAG_INSTANCE {
            item.0[12] = roots[item.0[12] as usize];
        }
    }
    out
}

/// What becomes of a subtree.
enum Leaf {
    One(u32),
    Two(u32, u32),
}

struct Writer<'a> {
    out: &'a mut Flat,
    tree: &'a Tree,
    soup: &'a Soup,
    /// Prim id by triangle of the soup, once given.
    ids: Vec<u32>,
    placement: &'a dyn Fn(u32) -> Item,
    /// Σ area × items read.
    cost: f64,
}

impl<'a> Writer<'a> {
    fn new(out: &'a mut Flat, tree: &'a Tree, soup: &'a Soup, placement: &'a dyn Fn(u32) -> Item) -> Self {
        Self { out, tree, soup, ids: vec![u32::MAX; soup.triangles.len()], placement, cost: 0.0 }
    }

    /// Writes the tree; its root becomes a node even when the tree is a single leaf or nothing.
    fn root(&mut self) {
        let root = self.out.items.len() as u32;
        let single = if self.tree.nodes.is_empty() { None } else { self.leaf(0) };
        if self.tree.nodes.is_empty() {
            self.out.items.push(Item::node([Bounds::NEVER_HIT; 2], [root + 1; 2]));
            self.out.items.push(Item::null());
        } else if let Some(leaf) = single {
            let bounds = bounds_of(&self.tree.nodes[0]);
            self.cost += f64::from(bounds.half_area());
            self.out.items.push(Item::node([bounds, Bounds::NEVER_HIT], [root + 1; 2]));
            self.write_leaf(leaf, bounds);
        } else {
            self.subtree(0);
        }
    }

    /// Recursion goes as deep as the tree, which is bounded by the kernel's stack.
    fn subtree(&mut self, index: u32) -> u32 {
        let at = self.out.items.len() as u32;
        let node = self.tree.nodes[index as usize];
        let bounds = bounds_of(&node);
        if let Some(leaf) = self.leaf(index) {
            self.write_leaf(leaf, bounds);
            return at;
        }
        self.cost += f64::from(bounds.half_area());
        self.out.items.push(Item::default());
        let children = [node.first_index, node.first_index + 1];
        let boxes = children.map(|c| bounds_of(&self.tree.nodes[c as usize]));
        let refs = children.map(|c| self.subtree(c));
        self.out.items[at as usize] = Item::node(boxes, refs);
        at
    }

    /// Whether a subtree becomes a leaf: a single primitive, or two triangles for which testing both costs no more than
    /// reading a node to choose between them: 2 A ≤ A + A₀ + A₁.
    fn leaf(&self, index: u32) -> Option<Leaf> {
        let node = &self.tree.nodes[index as usize];
        if node.is_leaf() {
            return Some(Leaf::One(node.first_index));
        }
        let [a, b] = [0, 1].map(|k| &self.tree.nodes[(node.first_index + k) as usize]);
        let triangles = self.soup.triangles.len() as u32;
        if !a.is_leaf() || !b.is_leaf() || a.first_index >= triangles || b.first_index >= triangles {
            return None;
        }
        if a.first_index == b.first_index {
            return Some(Leaf::One(a.first_index));
        }
        let area = |n| bounds_of(n).half_area();
        (area(node) <= area(a) + area(b)).then_some(Leaf::Two(a.first_index, b.first_index))
    }

    fn write_leaf(&mut self, leaf: Leaf, bounds: Bounds) {
        let area = f64::from(bounds.half_area());
        match leaf {
            Leaf::One(p) => match p.checked_sub(self.soup.triangles.len() as u32) {
                None => self.triangle(p, 0),
                Some(k) => self.out.items.push((self.placement)(k)),
            },
            Leaf::Two(p, q) => {
                self.triangle(p, MORE);
                self.triangle(q, 0);
                self.cost += area;
            }
        }
        self.cost += area;
    }

    fn triangle(&mut self, p: u32, more: u32) {
        let id = &mut self.ids[p as usize];
        if *id == u32::MAX {
            *id = self.out.triangles.len() as u32;
            self.out.triangles.push(self.soup.sources[p as usize]);
        }
        let item = Item::triangle(&self.soup.triangles[p as usize], *id, more != 0);
        self.out.items.push(item);
    }
}
