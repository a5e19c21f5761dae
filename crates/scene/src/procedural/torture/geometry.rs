//! Geometry that rays slip through, stick to or get lost in: cases 9 to 19.

use glam::DVec3;

use super::super::Entry;
use super::super::builder::{Builder, lambert};
use super::super::shapes::Shape;
use super::Case;
use crate::{Environment, Scene};

/// The group's cases.
pub const CASES: &[Case] = &[Case::generated(
    15,
    Entry {
        name: "same-centroid-1e6",
        shows: "A million concentric triangles, each a little larger than the one within, under a white sky.",
        known: "A ray meets the triangle that brute force in f64 finds. All centroids are one point, so that no plane \
                separates them and nothing but their number bounds the depth of a tree.",
        build: || same_centroid(1_000_000),
    },
)];

/// `n` triangles about the origin in one plane's three directions, from size 1 to 2.
pub fn same_centroid(n: u32) -> Scene {
    let mut b = Builder::new("same-centroid-1e6");
    let material = b.material(lambert("triangle", [0.5; 3]));
    let mut shape = Shape::default();
    for k in 0..n {
        let r = 1.0 + f64::from(k) / f64::from(n);
        shape.positions.extend([DVec3::new(r, 0.0, -r), DVec3::new(-r, r, 0.0), DVec3::new(0.0, -r, r)]);
        shape.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    b.add("triangles", shape, material);
    b.camera(DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, 40.0, 1.0);
    let mut scene = b.finish();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}
