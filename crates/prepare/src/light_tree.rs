//! A tree over emissive triangles, by which the kernel chooses one in proportion to its estimated
//! contribution at a point.
//!
//! After Conty Estevez & Kulla 2018, "Importance sampling of many lights with adaptive tree
//! splitting" (without the splitting): a light is chosen by descending from the root, at each node
//! by the contributions of its children. Two things differ. Nodes have four children, whose records
//! are adjacent: half the depth, and each choice is better informed. And a child's contribution is
//! not bounded but estimated, from the mean and the spread of the positions and normals of its
//! lights. An estimate is closer than a bound where it matters, at the top of the tree, whose nodes
//! are large and surround the receivers; and since it is never 0, no light is ever left out.
//! `shaders/light/tree.wesl` descends the tree.

use glam::{DVec3, Vec3};

use crate::shared::{LIGHT_LEAF, LightNode, LightPath};

/// Children of a node.
const WIDTH: usize = 4;

/// Most levels of the tree: two bits each of [`LightPath::trail`].
const MAX_DEPTH: u32 = 32;

/// Parts of an axis between which lights are split.
const BUCKETS: usize = 16;

/// A light of the tree.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TreeLight {
    /// World, relative to the scene's origin.
    pub(crate) corners: [DVec3; 3],
    /// With a fourth corner opposite the first; else a triangle.
    pub(crate) parallelogram: bool,
    /// Unit; none where both sides shine.
    pub(crate) normal: Option<DVec3>,
    /// Watts, or anything in proportion; at least 0. A light without power is never chosen.
    pub(crate) power: f64,
}

/// The tree: the children of each node adjacent, those of the root first.
#[derive(Clone, Debug, Default)]
pub(crate) struct LightTree {
    pub(crate) nodes: Vec<LightNode>,
    /// One a light; its trail has meaning only where the light has power.
    pub(crate) paths: Vec<LightPath>,
    /// Levels below the root.
    pub(crate) depth: u32,
}

impl LightTree {
    /// None where no light has power.
    pub(crate) fn new(lights: &[TreeLight]) -> Option<Self> {
        let total: f64 = lights.iter().map(|light| light.power).sum();
        let mut items: Vec<SplitLight> = (0..)
            .zip(lights)
            .filter(|(_, l)| l.power > 0.0)
            .map(|(i, l)| SplitLight::new(i, l, l.power / total))
            .collect();
        if items.is_empty() {
            return None;
        }
        let paths = lights.iter().map(|l| LightPath { inverse_area: l.inverse_area(), ..LightPath::default() });
        let mut builder = Builder { scale: 1.0, tree: Self { paths: paths.collect(), ..Self::default() } };
        // The kernel divides powers by squared distances. In units of the lights' own spread these
        // stay within f32.
        builder.scale = Sums::of(&items).variance().max(1e-30);
        builder.node(&mut items, 0, NodePosition { own: None, trail: [0; 2], level: 0 });
        Some(builder.tree)
    }
}

impl TreeLight {
    fn inverse_area(&self) -> f32 {
        let [a, b, c] = self.corners;
        let corners = if self.parallelogram { 1.0 } else { 2.0 };
        (corners / (b - a).cross(c - a).length()).min(f64::from(f32::MAX)) as f32
    }
}

/// A light, for splitting.
#[derive(Clone, Copy)]
struct SplitLight {
    light: u32,
    center: Vec3,
    sums: Sums,
}

impl SplitLight {
    fn new(light: u32, of: &TreeLight, power: f64) -> Self {
        let [a, b, c] = of.corners;
        let (center, spread) = if of.parallelogram {
            (0.5 * (b + c), ((b - a).length_squared() + (c - a).length_squared()) / 12.0)
        } else {
            let center = (a + b + c) / 3.0;
            (center, [a, b, c].iter().map(|p| (p - center).length_squared()).sum::<f64>() / 12.0)
        };
        let sums = Sums {
            power,
            normals: of.normal.unwrap_or(DVec3::ZERO) * power,
            places: center * power,
            squares: (center.length_squared() + spread) * power,
        };
        Self { light, center: center.as_vec3(), sums }
    }
}

/// Sums over lights, weighted by their powers.
#[derive(Clone, Copy, Default)]
struct Sums {
    power: f64,
    normals: DVec3,
    places: DVec3,
    squares: f64,
}

impl Sums {
    fn of(items: &[SplitLight]) -> Self {
        items.iter().fold(Self::default(), |sums, item| sums.with(&item.sums))
    }

    fn with(&self, other: &Self) -> Self {
        Self {
            power: self.power + other.power,
            normals: self.normals + other.normals,
            places: self.places + other.places,
            squares: self.squares + other.squares,
        }
    }

    /// Mean squared distance from the mean place.
    fn variance(&self) -> f64 {
        (self.squares / self.power - (self.places / self.power).length_squared()).max(0.0)
    }

    /// How much is lost by not telling these lights apart: their power, times the variance of their
    /// places, times the solid angle that they shine into (Conty Estevez & Kulla 2018, section 4.4)
    /// as a multiple of one light's. That goes from 1 to 4 as the mean of their normals gets
    /// shorter, about as here where normals fill a cone, whose mean has the length (1 + cos θ) / 2.
    fn cost(&self) -> f64 {
        let mean = (self.normals.length() / self.power).min(1.0);
        self.power * self.variance() * (4.0 - 3.0 * mean * mean * mean)
    }
}

/// The position of a node in the tree.
#[derive(Clone, Copy)]
struct NodePosition {
    /// Its own record; the root has none.
    own: Option<usize>,
    trail: [u32; 2],
    level: u32,
}

struct Builder {
    scale: f64,
    tree: LightTree,
}

impl Builder {
    /// Writes the children of a node, and theirs. `splits`: those above it.
    fn node(&mut self, items: &mut [SplitLight], splits: u32, place: NodePosition) {
        self.tree.depth = self.tree.depth.max(place.level + 1);
        let base = self.tree.nodes.len();
        self.tree.nodes.resize(base + WIDTH, LightNode::default());
        if let Some(own) = place.own {
            self.tree.nodes[own].link = base as u32;
        }
        for (k, (splits, part)) in parts(items, splits).into_iter().enumerate() {
            let mut trail = place.trail;
            trail[(place.level / 16) as usize] |= (k as u32) << (2 * (place.level % 16));
            self.tree.nodes[base + k] = self.record(&Sums::of(part));
            if let [only] = part {
                self.tree.nodes[base + k].link = LIGHT_LEAF | only.light;
                self.tree.paths[only.light as usize].trail = trail;
            } else {
                self.node(part, splits, NodePosition { own: Some(base + k), trail, level: place.level + 1 });
            }
        }
    }

    fn record(&self, sums: &Sums) -> LightNode {
        let normal = (sums.normals / sums.power).clamp_length_max(1.0);
        let snorm = |v: f64| u32::from((v * 32767.0).round() as i16 as u16);
        LightNode {
            center: (sums.places / sums.power).as_vec3().to_array(),
            variance: sums.variance().clamp(1e-30, 1e30) as f32,
            normal_xy: snorm(normal.x) | snorm(normal.y) << 16,
            normal_z: normal.z as f32,
            power: (sums.power * self.scale).clamp(1e-30, 1e30) as f32,
            link: 0,
        }
    }
}

/// Up to four parts of a node, each with the splits above it: the costliest is split first.
fn parts(items: &mut [SplitLight], splits: u32) -> Vec<(u32, &mut [SplitLight])> {
    let mut parts = vec![(splits, items)];
    let mut costs = vec![0.0f64];
    while parts.len() < WIDTH {
        let Some(k) = (0..parts.len()).filter(|&k| parts[k].1.len() > 1).max_by(|&a, &b| costs[a].total_cmp(&costs[b]))
        else {
            break;
        };
        let (splits, whole) = parts.swap_remove(k);
        costs.swap_remove(k);
        let middle = split(whole, splits);
        let (left, right) = whole.split_at_mut(middle);
        for part in [left, right] {
            costs.push(Sums::of(part).cost());
            parts.push((splits + 1, part));
        }
    }
    parts
}

/// Reorders lights into two parts, and returns where the second begins.
fn split(items: &mut [SplitLight], splits: u32) -> usize {
    let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for item in items.iter() {
        (low, high) = (low.min(item.center), high.max(item.center));
    }
    let extent = high - low;
    let halvings = items.len().next_power_of_two().trailing_zeros();
    let found = if splits + halvings < MAX_DEPTH { best_split(items, low, extent) } else { None };
    if let Some((axis, bucket)) = found {
        let mut middle = 0;
        for k in 0..items.len() {
            if bucket_of(items[k].center[axis], low[axis], extent[axis]) < bucket {
                items.swap(k, middle);
                middle += 1;
            }
        }
        return middle;
    }
    // All in one place, or so many levels down that only halving is sure to end.
    let axis = (0..3).max_by(|&a, &b| extent[a].total_cmp(&extent[b])).unwrap_or(0);
    let middle = items.len() / 2;
    items.select_nth_unstable_by(middle, |a, b| a.center[axis].total_cmp(&b.center[axis]).then(a.light.cmp(&b.light)));
    middle
}

/// Axis and first bucket of the second part; none where all centres are in one place.
fn best_split(items: &[SplitLight], low: Vec3, extent: Vec3) -> Option<(usize, usize)> {
    let mut best: Option<(f64, usize, usize)> = None;
    for axis in 0..3 {
        if !(extent[axis] > 0.0 && extent[axis].is_finite()) {
            continue;
        }
        let mut buckets = [Sums::default(); BUCKETS];
        for item in items {
            let bucket = &mut buckets[bucket_of(item.center[axis], low[axis], extent[axis])];
            *bucket = bucket.with(&item.sums);
        }
        let mut after = [Sums::default(); BUCKETS + 1];
        for k in (0..BUCKETS).rev() {
            after[k] = after[k + 1].with(&buckets[k]);
        }
        let mut before = Sums::default();
        for k in 1..BUCKETS {
            before = before.with(&buckets[k - 1]);
            if before.power > 0.0 && after[k].power > 0.0 {
                let cost = before.cost() + after[k].cost();
                if best.is_none_or(|(least, ..)| cost < least) {
                    best = Some((cost, axis, k));
                }
            }
        }
    }
    best.map(|(_, axis, k)| (axis, k))
}

fn bucket_of(center: f32, low: f32, extent: f32) -> usize {
    (((center - low) / extent * BUCKETS as f32) as usize).min(BUCKETS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of different power about a spiral, every seventh shining to both sides, every
    /// ninth black.
    fn spiral(count: usize) -> Vec<TreeLight> {
        let light = |i: usize| {
            let t = i as f64 * 0.37;
            let at = DVec3::new(t.cos() * (1.0 + t), 0.3 * t, t.sin() * t);
            let (e1, e2) = (DVec3::new(0.1, 0.02 * t.sin(), 0.0), DVec3::new(0.0, 0.1, 0.05 * t.cos()));
            let normal = (!i.is_multiple_of(7)).then(|| e1.cross(e2).normalize());
            let power = if i.is_multiple_of(9) { 0.0 } else { 1.0 + (3.0 * t).sin().powi(2) * 100.0 };
            TreeLight { corners: [at, at + e1, at + e2], parallelogram: false, normal, power }
        };
        (0..count).map(light).collect()
    }

    /// Follows each light's trail to its leaf; every node that is not empty must be on some way.
    fn check(lights: &[TreeLight]) -> LightTree {
        let tree = LightTree::new(lights).expect("some light has power");
        let mut visits = vec![false; tree.nodes.len()];
        for (i, (light, path)) in lights.iter().zip(&tree.paths).enumerate() {
            if light.power == 0.0 {
                continue;
            }
            let (mut base, mut level) = (0u32, 0);
            while base & LIGHT_LEAF == 0 {
                let child = path.trail[level / 16] >> (2 * (level % 16)) & 3;
                let at = (base + child) as usize;
                visits[at] = true;
                assert!(tree.nodes[at].power > 0.0, "light {i} cannot be reached");
                base = tree.nodes[at].link;
                level += 1;
                assert!(level <= tree.depth as usize && level <= MAX_DEPTH as usize, "light {i} lies too deep");
            }
            assert_eq!(base & !LIGHT_LEAF, i as u32);
        }
        for (node, visits) in tree.nodes.iter().zip(visits) {
            assert_eq!(node.power > 0.0, visits, "{node:?}");
        }
        tree
    }

    #[test]
    fn trails_lead_to_their_lights() {
        for count in [2, 3, 5, 16, 17, 1000] {
            check(&spiral(count));
        }
    }

    #[test]
    fn nodes_hold_the_means_of_their_lights() {
        let lights = spiral(500);
        let tree = check(&lights);
        let total: f64 = lights.iter().map(|l| l.power).sum();
        let mean =
            |value: &dyn Fn(&TreeLight) -> DVec3| lights.iter().map(|l| value(l) * l.power / total).sum::<DVec3>();
        let center = mean(&|l| l.corners.iter().sum::<DVec3>() / 3.0);
        let normal = mean(&|l| l.normal.unwrap_or(DVec3::ZERO));
        let shares: f32 = tree.nodes[..WIDTH].iter().map(|n| n.power).sum();
        let of_children = |value: &dyn Fn(&LightNode) -> Vec3| {
            tree.nodes[..WIDTH].iter().map(|n| value(n) * (n.power / shares)).sum::<Vec3>().as_dvec3()
        };
        assert!((of_children(&|n| Vec3::from(n.center)) - center).length() < 1e-3);
        let decoded = |n: &LightNode| {
            let part = |bits: u32| f32::from(bits as u16 as i16) / 32767.0;
            Vec3::new(part(n.normal_xy), part(n.normal_xy >> 16), n.normal_z)
        };
        assert!((of_children(&decoded) - normal).length() < 1e-3);
        // A leaf's spread is that of its triangle: (a² + b² + c²) / 36 of its sides.
        let leaf = tree.nodes.iter().find(|n| n.link & LIGHT_LEAF != 0).expect("there are lights");
        let [a, b, c] = lights[(leaf.link & !LIGHT_LEAF) as usize].corners;
        let exact = [a - b, b - c, c - a].map(DVec3::length_squared).iter().sum::<f64>() / 36.0;
        assert!((f64::from(leaf.variance) / exact - 1.0).abs() < 1e-6);
    }

    /// No order of splits is deeper than trails reach: lights in one place, or each twice as far
    /// away as the one before.
    #[test]
    fn depth_is_bounded() {
        check(&vec![spiral(2)[1]; 5000]);
        let far = |i: i32| {
            let mut light = spiral(2)[1];
            light.corners = light.corners.map(|p| p + DVec3::X * 2f64.powi(i % 60));
            light
        };
        check(&(0..3000).map(far).collect::<Vec<_>>());
    }

    #[test]
    fn darkness_has_no_tree() {
        assert!(LightTree::new(&[]).is_none());
        assert!(LightTree::new(&[TreeLight { power: 0.0, ..spiral(2)[1] }]).is_none());
    }
}
