//! The 64-byte items that the kernel reads, word by word.
//!
//! One stream holds three kinds; word 15 tells them apart. Numbers are f32 bit patterns unless said otherwise, item
//! references are u32 indices into the stream.
//!
//! | word | node (tag 0) | triangle (tag 1) | instance (tag 2) |
//! |---|---|---|---|
//! | 0–2 | box 0, least | v0 | row x of world → object: three of the matrix … |
//! | 3 | u32: item of child 0 | u32: prim id | … and the translation |
//! | 4–6 | box 0, greatest | e1 = v1 − v0 | row y |
//! | 7 | u32: item of child 1 | slack of b1 | translation y |
//! | 8–10 | box 1, least | e2 = v2 − v0 | row z |
//! | 11 | 0 | slack of b2 | translation z |
//! | 12 | box 1, greatest x | slack of the determinant | u32: root item of the mesh's tree |
//! | 13 | box 1, greatest y | 0 | u32: index into [`crate::Accel::instances`] |
//! | 14 | box 1, greatest z | 0 | 0 |
//! | 15 | 0 | 1 \| more << 2 | 2 \| more << 2 |
//!
//! `more` says that the next item of the stream belongs to the same leaf. Item 0 is the root and always a node; so is the
//! root of each mesh's tree. A child that is missing (a tree of one leaf) has [`crate::Bounds::NEVER_HIT`] as its box and
//! the other child's item; should a ray without sense (t in the 1e30s) enter it, the walk still ends. The root of an
//! empty scene has two such children and a triangle of zeros behind it.
//!
//! # Slack: why no ray slips between two triangles
//! The hit test computes, with s = o − v0, U = s·(d × e2), V = d·(s × e1) and the determinant D = e1·(d × e2), and hits
//! where b1 = U/D ≥ 0, b2 = V/D ≥ 0 and b1 + b2 ≤ 1. In f32, u = 2⁻²⁴ and |·|∞ the greatest component, U is off by less
//! than 13u |s|∞ |d| |e2|: u for s, 2u for each component of the cross product against Σᵢ(|dⱼeₖ| + |dₖeⱼ|) ≤ 2 |d||e|, 3u for
//! the dot product, and u for e2 itself, which stands for v2 − v0. Likewise V with e1, and D by 11u |d| |e1| |e2|. Two
//! triangles that share an edge round it differently, so a strict test leaves a crack as wide as that. The item holds
//!
//! - slack of b1 = 16u |e2|, slack of b2 = 16u |e1|, slack of the determinant = 16u |e1| |e2|, and the test is
//! - b1 ≥ −slack1 · |s|∞ · |d| / |D|, b2 ≥ −slack2 · |s|∞ · |d| / |D| and
//!   b1 + b2 ≤ 1 + 2⁻²² + ((slack1 + slack2) · |s|∞ + slack_det) · |d| / |D|.
//!
//! So every ray that meets a triangle in exact arithmetic hits it, save where D vanishes in its own rounding (seen edge
//! on, where its neighbours take over); what is accepted beyond an edge lies within some 30u of the distance from it.

use glam::Vec3;

use crate::{Bounds, triangle::Triangle};

/// Word 15 of a node.
pub const TAG_NODE: u32 = 0;
/// Word 15 of a triangle, low two bits.
pub const TAG_TRIANGLE: u32 = 1;
/// Word 15 of an instance, low two bits.
pub const TAG_INSTANCE: u32 = 2;
/// Set in word 15 when the next item belongs to the same leaf.
pub const MORE: u32 = 1 << 2;
/// Most items in a stream: references have 28 bits to spare four for tags in packed forms. 16 GiB.
pub const MAX_ITEMS: u64 = 1 << 28;

/// One item: 16 words, 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(16))]
pub struct Item(pub [u32; 16]);

impl Item {
    pub(crate) fn node(boxes: [Bounds; 2], refs: [u32; 2]) -> Self {
        let mut w = [0; 16];
        for (k, b) in boxes.iter().enumerate() {
            put(&mut w, 8 * k, b.lo);
            put(&mut w, 8 * k + 4, b.hi);
        }
        w[3] = refs[0];
        w[7] = refs[1];
        w[15] = TAG_NODE;
        Self(w)
    }

    pub(crate) fn triangle(t: &Triangle, prim: u32, more: bool) -> Self {
        let mut w = [0; 16];
        let [e1, e2] = t.edges();
        put(&mut w, 0, t.0[0]);
        put(&mut w, 4, e1);
        put(&mut w, 8, e2);
        let slack = 16.0 / (1 << 24) as f32;
        let (a, b) = (e1.length(), e2.length());
        w[3] = prim;
        w[7] = (slack * b).to_bits();
        w[11] = (slack * a).to_bits();
        w[12] = (slack * a * b).to_bits();
        w[15] = TAG_TRIANGLE | if more { MORE } else { 0 };
        Self(w)
    }

    /// A triangle without area, which no ray hits.
    pub(crate) fn null() -> Self {
        let mut w = [0; 16];
        w[15] = TAG_TRIANGLE;
        Self(w)
    }

    pub(crate) fn instance(to_object: &[f32; 12], root: u32, instance: u32) -> Self {
        let mut w = [0; 16];
        for (word, value) in w.iter_mut().zip(to_object) {
            *word = value.to_bits();
        }
        w[12] = root;
        w[13] = instance;
        w[15] = TAG_INSTANCE;
        Self(w)
    }

    /// [`TAG_NODE`], [`TAG_TRIANGLE`] or [`TAG_INSTANCE`].
    pub fn tag(&self) -> u32 {
        self.0[15] & 3
    }

    /// Whether the next item belongs to the same leaf.
    pub fn more(&self) -> bool {
        self.0[15] & MORE != 0
    }

    /// Three words as a vector.
    pub fn vec3(&self, word: usize) -> Vec3 {
        Vec3::new(self.float(word), self.float(word + 1), self.float(word + 2))
    }

    /// One word as f32.
    pub fn float(&self, word: usize) -> f32 {
        f32::from_bits(self.0[word])
    }

    /// The box of a node's child, `k` = 0 or 1.
    pub fn child_bounds(&self, k: usize) -> Bounds {
        Bounds { lo: self.vec3(8 * k), hi: self.vec3(8 * k + 4) }
    }

    /// The item of a node's child, `k` = 0 or 1.
    pub fn child(&self, k: usize) -> u32 {
        self.0[3 + 4 * k]
    }
}

fn put(w: &mut [u32; 16], at: usize, v: Vec3) {
    w[at] = v.x.to_bits();
    w[at + 1] = v.y.to_bits();
    w[at + 2] = v.z.to_bits();
}
