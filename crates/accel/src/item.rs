//! The 64-byte items that the kernel reads, word by word.
//!
//! Nodes hold up to four children with boxes of 8 bits per plane; leaves hold two triangles along a
//! common edge. A traversal reads words 0 to 11 alone: three loads of 16 bytes. Word 11
//! distinguishes the kinds: in a leaf it is the coordinate of a vertex and finite; exponent bits
//! all ones mean a node (sign 0) or an instance (sign 1).
//!
//! | word | node | leaf: a pair of triangles | instance |
//! |---|---|---|---|
//! | 0–2 | f32 grid origin p | f32 v0 | f32 row x of world → object |
//! | 3 | exponents: x \| y << 8 \| z << 16 | v1 x | its translation x |
//! | 4 | u32: item of child 0 | v1 y | row y |
//! | 5 | least x of children 0–3, a byte each, child 0 lowest | v1 z | row y |
//! | 6 | least y | v2 x | row y |
//! | 7 | least z | v2 y | translation y |
//! | 8 | greatest x | v2 z | row z |
//! | 9 | greatest y | v3 x | row z |
//! | 10 | greatest z | v3 y | row z |
//! | 11 | 0x7f80_0000 \| number of children, 0–4 | v3 z | 0xff80_0000 |
//! | 12 | 0 | u32: prim id of triangle A | translation z |
//! | 13 | 0 | u32: prim id of triangle B | u32: root item of the mesh's tree |
//! | 14 | 0 | 0 | u32: index into [`crate::Accel::instances`] |
//! | 15 | 0 | 0 | 0 |
//!
//! # Nodes
//! Children are consecutive items: child c is item `word 4 + c`. Item 0 is a node; so is the root
//! of each mesh's tree. On each axis the step is the f32 whose bits are `exponent << 23`, the
//! exponent being *masked to its 8 bits first*: bits of a neighbour shifted into the sign turn
//! boxes inside out. A plane is at p + byte · step. With r the reciprocal of the direction
//! ([`crate::safe_reciprocal`]), per ray and node m = step · r and n = (p − o) · r, per plane t =
//! byte · m + n. The near plane of an axis is `least` where r's sign bit is 0 and `greatest` where
//! it is 1; a child is entered when max(near x, y, z, t_min) ≤ min(far x, y, z) · [`SLAB_PADDING`]
//! and ≤ t_max, and its number is below the count (bytes of absent children are no protection: far
//! away a whole grid rounds to one t).
//!
//! # Why no hit is lost
//! Let u = 2⁻²⁴. p and the bytes are such that each plane clears the child's box by [`GUARD`]
//! steps. In f32 n is off by 2u |p − o| |r|, byte · m by u of itself, their sum by u of itself. As
//! |p − o| ≤ |plane − o| + 255 steps, that is at most 3u of t, which [`SLAB_PADDING`] covers
//! together with the reciprocal (see the crate's documentation), and 3u · 255 steps < 5e-5 steps,
//! which [`GUARD`] = 2⁻¹² covers.
//!
//! # Leaves
//! Triangle A is v0, v1, v2 and triangle B is v3, v2, v1, in the order of
//! [`crate::TriangleSource::corners`]; their common edge is v1–v2. A triangle alone has v3 = v2 and
//! one prim id twice. Vertices are exact, not v0 plus edges, so that triangles which share a vertex
//! hold the same bits. The hit test is that of Woop, Benthin and Wald, "Watertight ray/triangle
//! intersection" (JCGT 2013): each vertex is transformed to a space where the ray is the z axis,
//! (x, y, z) = ((v − o)·X, (v − o)·Y, (v − o)·Z), and the signs of xᵢyⱼ − xⱼyᵢ decide. Rounding
//! happens once per vertex, the same for every triangle around it; a computed difference of two
//! products never has the wrong sign, only perhaps the value 0, which is inside for both
//! neighbours. So there are no cracks, at edges or at vertices.
//!
//! # Stack
//! One entry per node: `first child item << 6 | s0 | s1 << 2 | s2 << 4`, children still to be
//! visited in order; the last number is repeated to fill up, so (a, b, b) is a then b. To take one:
//! visit s0; if s1 = s0 the entry is done, else it becomes (s1, s2, s2). On entering an instance
//! the traversal records the stack height: back at that height it continues in world space. Items
//! stay below 2²⁶ − 1.

use glam::{DVec3, Vec3};

use crate::Bounds;

/// Word 11 of a node, without the count.
pub const NODE_MARK: u32 = 0x7f80_0000;
/// Word 11 of an instance.
pub const INSTANCE_MARK: u32 = 0xff80_0000;
/// Sign and exponent of word 11.
pub const MARK_BITS: u32 = 0xff80_0000;
/// The largest number of items in a stream: stack entries have 26 bits for an item. 4 GiB.
pub const MAX_ITEMS: u64 = (1 << 26) - 1;
/// Steps by which each plane of a node clears the box of its child.
pub const GUARD: f64 = 1.0 / 4096.0;
/// Factor on the far distance of a slab test, 1 + 2^-19.
pub const SLAB_PADDING: f32 = 1.0 + 1.0 / (1 << 19) as f32;

/// One item: 16 words, 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct Item(pub [u32; 16]);

/// The kind of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A node with this many children.
    Node(u32),
    /// A pair of triangles.
    Pair,
    /// A mesh placed as an instance.
    Instance,
}

impl Item {
    /// A node around up to four boxes; its children are the items from `base`.
    pub(crate) fn node(children: &[Bounds], base: u32) -> Self {
        let mut w = [0; 16];
        w[11] = NODE_MARK | children.len() as u32;
        w[4] = base;
        if children.is_empty() {
            return Self(w);
        }
        for axis in 0..3 {
            let mut spans = [[0.0; 2]; 4];
            for (span, b) in spans.iter_mut().zip(children) {
                *span = [b.lo[axis], b.hi[axis]];
            }
            let fit = Axis::fit(&spans[..children.len()]);
            w[axis] = fit.origin.to_bits();
            w[3] |= fit.exponent << (8 * axis);
            w[5 + axis] = u32::from_le_bytes(fit.planes.map(|p| p[0]));
            w[8 + axis] = u32::from_le_bytes(fit.planes.map(|p| p[1]));
        }
        Self(w)
    }

    /// Vertices v0 to v3 and the ids of the two triangles.
    pub(crate) fn pair(vertices: [Vec3; 4], prims: [u32; 2]) -> Self {
        let mut w = [0; 16];
        for (k, v) in vertices.iter().enumerate() {
            for axis in 0..3 {
                w[3 * k + axis] = v[axis].to_bits();
            }
        }
        w[12] = prims[0];
        w[13] = prims[1];
        Self(w)
    }

    /// The instance `index` of the mesh whose tree has its root at item `root`.
    pub(crate) fn instance(to_object: &[f32; 12], root: u32, index: u32) -> Self {
        let mut w = [0; 16];
        for (word, value) in w.iter_mut().zip(to_object) {
            *word = value.to_bits();
        }
        w[12] = w[11];
        w[11] = INSTANCE_MARK;
        w[13] = root;
        w[14] = index;
        Self(w)
    }

    /// The kind, by word 11.
    pub fn kind(&self) -> Kind {
        match self.0[11] & MARK_BITS {
            NODE_MARK => Kind::Node(self.0[11] & 7),
            INSTANCE_MARK => Kind::Instance,
            _ => Kind::Pair,
        }
    }

    /// Three words as a vector.
    pub fn vec3(&self, word: usize) -> Vec3 {
        Vec3::new(self.float(word), self.float(word + 1), self.float(word + 2))
    }

    /// One word as f32.
    pub fn float(&self, word: usize) -> f32 {
        f32::from_bits(self.0[word])
    }

    /// The corners of a pair's triangle with this prim id, in the order of
    /// [`crate::TriangleSource::corners`].
    pub fn corners(&self, prim: u32) -> [Vec3; 3] {
        if self.0[12] == prim { [0, 3, 6] } else { [9, 6, 3] }.map(|word| self.vec3(word))
    }

    /// Length of a node's grid step on each axis.
    pub fn step(&self) -> Vec3 {
        let exponents = self.0[3];
        Vec3::from_array([0, 8, 16].map(|shift| f32::from_bits((exponents >> shift & 0xff) << 23)))
    }

    /// The planes of a node's child `c` in f64, where they are exact.
    pub fn child_planes(&self, c: usize) -> [DVec3; 2] {
        let origin = self.vec3(0).as_dvec3();
        let byte = |word: usize| f64::from(self.0[word].to_le_bytes()[c]);
        [5, 8].map(|w| origin + DVec3::new(byte(w), byte(w + 1), byte(w + 2)) * self.step().as_dvec3())
    }
}

/// Grid origin, biased exponent of the step, and each child's planes, on one axis.
struct Axis {
    origin: f32,
    exponent: u32,
    planes: [[u8; 2]; 4],
}

impl Axis {
    /// `spans`: least and greatest coordinate of each child.
    fn fit(spans: &[[f32; 2]]) -> Self {
        let least = spans.iter().fold(f32::MAX, |m, s| m.min(s[0]));
        let greatest = spans.iter().fold(f32::MIN, |m, s| m.max(s[1]));
        // A step far below the spacing of f32 around the box would leave no room for the guard, not
        // even in f64.
        let spacing = f64::from(least.abs().max(greatest.abs())) / (1 << 24) as f64;
        let extent = (f64::from(greatest) - f64::from(least)).max(spacing);
        // The least step that could do, then larger ones until rounding the origin down leaves
        // room.
        let mut exponent = ((extent / 255.0).log2().ceil().max(-126.0) as i32 + 127).clamp(1, 253) as u32;
        loop {
            let step = f64::from(f32::from_bits(exponent << 23));
            let origin = round_down(f64::from(least) - GUARD * step);
            let cells = |x: f32| (f64::from(x) - f64::from(origin)) / step;
            // Coordinates end at 1e18, so the largest exponent always fits.
            if cells(greatest) + GUARD <= 255.0 || exponent == 253 {
                let mut planes = [[255, 0]; 4];
                for (plane, span) in planes.iter_mut().zip(spans) {
                    *plane = [(cells(span[0]) - GUARD).floor() as u8, (cells(span[1]) + GUARD).ceil() as u8];
                }
                return Self { origin, exponent, planes };
            }
            exponent += 1;
        }
    }
}

fn round_down(x: f64) -> f32 {
    let r = x as f32;
    if f64::from(r) > x { r.next_down() } else { r }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes of all sizes and places, from a fixed hash; every kind of exponent occurs.
    fn boxes(seed: u32) -> Vec<Bounds> {
        let mut state = seed.wrapping_mul(0x9e37_79b9) | 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
        };
        let scale = (next() * 55.0).exp2();
        let place = Vec3::new(next(), next(), next()) * scale * (next() * 20.0).exp2();
        let place = place.clamp(Vec3::splat(-9e17), Vec3::splat(9e17));
        (0..1 + seed % 4)
            .map(|_| {
                let a = place + Vec3::new(next(), next(), next()) * scale;
                let size = Vec3::new(next(), next(), next()).abs() * scale * (next() * 10.0 - 10.0).exp2();
                Bounds { lo: a, hi: a + size }
            })
            .collect()
    }

    #[test]
    fn planes_clear_their_boxes_by_the_guard_and_not_by_much_more() {
        let mut exponents = std::collections::HashSet::new();
        for seed in 0..20_000 {
            let children = boxes(seed);
            let item = Item::node(&children, 77);
            assert_eq!(item.kind(), Kind::Node(children.len() as u32));
            let s = item.step().as_dvec3();
            assert!(s.cmpgt(DVec3::ZERO).all() && s.is_finite(), "{s}");
            assert_eq!(item.0[3] >> 24, 0);
            exponents.extend([0, 8, 16].map(|k| item.0[3] >> k & 0xff));
            let extent = children.iter().fold(Bounds::EMPTY, |a, &b| a.union(b));
            for (c, b) in children.iter().enumerate() {
                let [lo, hi] = item.child_planes(c);
                // 0.99: the f64 here rounds too where p and the step are far apart.
                assert!((b.lo.as_dvec3() - lo).cmpge(s * GUARD * 0.99).all(), "{seed}: {lo} {b:?}");
                assert!((hi - b.hi.as_dvec3()).cmpge(s * GUARD * 0.99).all(), "{seed}: {hi} {b:?}");
                assert!((b.lo.as_dvec3() - lo).cmple(s * 1.01).all() && (hi - b.hi.as_dvec3()).cmple(s * 1.01).all());
                // The grid is no coarser than twice what extent and f32 ask for.
                let ulp = extent.lo.abs().max(extent.hi.abs()).as_dvec3() * 2.4e-7;
                let span = (extent.hi - extent.lo).as_dvec3();
                let ask = ((span + ulp) * (2.02 / 254.0)).max(DVec3::splat(2f64.powi(-126)));
                assert!(s.cmple(ask).all(), "{seed}: step {s}, extent {span}");
            }
        }
        assert!(exponents.len() > 100, "{} exponents", exponents.len());
    }

    #[test]
    fn slab_distances_in_f32_are_conservative() {
        // A ray aimed at a point of a child's box enters it by the arithmetic of the traversal.
        let mut tight = 0;
        for seed in 0..40_000 {
            let children = boxes(seed);
            let item = Item::node(&children, 0);
            let c = seed as usize % children.len();
            let b = children[c];
            // Corners and face points are the hard ones.
            let at = |bit: u32| [0.0, 1.0, 0.37][(seed >> bit) as usize % 3];
            let target = b.lo.as_dvec3() + (b.hi - b.lo).as_dvec3() * DVec3::new(at(2), at(4), at(6));
            let size = f64::from((b.hi - b.lo).max_element()).max(target.abs().max_element() * 1e-6);
            let away = DVec3::new(at(8) - 0.5, 0.4 - at(10), at(12) - 0.7) * size * 3f64.powi((seed % 30) as i32 - 10);
            let o = (target - away).as_vec3();
            let exact = target - o.as_dvec3();
            if !o.is_finite() || o.abs().max_element() > 1e18 || exact.length() == 0.0 {
                continue;
            }
            // Only rays whose f32 direction really hits the box are a test.
            let d = exact.normalize().as_vec3();
            let Some(reach) = exact_span(o, d, b) else { continue };
            let entered = crate::traversal::child_entries_for_tests(&item, o, d);
            assert!(entered[c].is_some(), "{seed}: {b:?} from {o} along {d}, span {reach:?}");
            tight += u32::from(reach[1] - reach[0] <= 1e-6 * reach[1]);
        }
        assert!(tight > 1000, "only {tight} grazing rays");
    }

    /// Where a ray is in a closed box, in f64 from the f32 ray; none when it misses.
    fn exact_span(o: Vec3, d: Vec3, b: Bounds) -> Option<[f64; 2]> {
        let mut span = [0.0f64, f64::INFINITY];
        for axis in 0..3 {
            let (o, d) = (f64::from(o[axis]), f64::from(d[axis]));
            let (lo, hi) = (f64::from(b.lo[axis]), f64::from(b.hi[axis]));
            if d == 0.0 {
                if o < lo || o > hi {
                    return None;
                }
            } else {
                let (t0, t1) = ((lo - o) / d, (hi - o) / d);
                span = [span[0].max(t0.min(t1)), span[1].min(t0.max(t1))];
            }
        }
        (span[0] <= span[1]).then_some(span)
    }
}
