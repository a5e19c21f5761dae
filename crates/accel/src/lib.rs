//! Bounding volume hierarchies over a [`surelight_scene::Scene`], as the items that the kernel
//! reads.
//!
//! [`Accel::build`] validates the scene, decides which meshes are placed as instances and which are
//! copied, has obvhs build binary trees, joins their nodes to nodes of up to four children and
//! writes these as one stream of 64-byte items ([`item`] has the format, word by word).
//! [`Accel::intersect`] traverses the same items on the CPU, operation by operation as the kernel
//! does; [`oracle`] answers the same questions by brute force in f64 from the scene alone.
//!
//! ```
//! use glam::Vec3;
//! use surelight_accel::{Accel, BuildOptions, Ray};
//!
//! let scene = surelight_scenes::cornell_box::cornell_box();
//! let camera = scene.cameras[0].to_world;
//! let accel = Accel::build(&scene, camera.translation, &BuildOptions::default())?;
//! // Along the camera's axis: the box is in front.
//! let forward = -camera.matrix3.z_axis.as_vec3();
//! let hit = accel.intersect(&Ray::new(Vec3::ZERO, forward)).expect("a wall");
//! assert!(hit.t > 0.5);
//! # Ok::<(), surelight_accel::AccelError>(())
//! ```
//!
//! # Camera space
//! Positions are made relative to an origin, the camera, in f64 and only then rounded to f32:
//! geometry near the camera is exact to the last bits however far from the world's origin it is.
//!
//! # Why no hit is lost
//! Let u = 2⁻²⁴. A leaf's box holds the triangle's corners grown by a few u of the edges and of the
//! distance from the camera (see `triangle.rs`), rounded outward; boxes of inner nodes are unions
//! of these by min and max, which do not round, and the planes that a node stores lie outside of
//! its children's boxes. A ray that hits the triangle therefore hits each box on its path in exact
//! arithmetic: on every axis some t lies in the slab's interval. A slab test that computes t =
//! (plane − o) · r, with r the reciprocal of the direction, makes a subtraction, a reciprocal and a
//! product, (1 ± u)³ in all, so that the exact order near ≤ far can turn over by at most the factor
//! (1 + 2γ₃), γ₃ = 3u / (1 − 3u) (Ize, "Robust BVH ray traversal", 2013). GPU reciprocals are good
//! to 2.5 ulp = 5u, which makes that (1 + 2γ₇) < 1 + 15u. Planes on a node's grid add 3u on either
//! side ([`item`]). [`item::SLAB_PADDING`] = 1 + 32u covers all of it: multiply the far distance by
//! it. Form (p − o) · r for the grid's origin p, not p · r − o · r: the latter's error grows with
//! |o| / |p − o|.
//!
//! Direction components below [`MIN_DIRECTION`] are replaced by it, sign kept, before the
//! reciprocal is taken: no ∞ and no 0 · ∞ = NaN then arises, and a ray that runs exactly in a box's
//! plane stays in the box, for boxes have no face that touches their triangle.
//!
//! In the leaf, triangles that share an edge decide by the same numbers on which side of it the ray
//! passes; [`item`] has the argument. A closed mesh has no cracks.
//!
//! Boxes of instances have one more margin: the ray is rounded when it is transformed to object
//! space, by about u times
//! |M| |M⁻¹| (|o| + |translation|) in camera space.

pub mod item;
pub mod oracle;

mod accel;
mod bounds;
mod collapse;
mod error;
mod flatten;
mod forest;
mod options;
mod pairing;
mod placement;
mod records;
mod runs;
mod topdown;
mod traversal;
mod tree;
mod triangle;

pub use accel::{Accel, Statistics};
pub use bounds::Bounds;
pub use error::AccelError;
pub use item::Item;
pub use options::{BuildOptions, Instancing, Quality};
pub use placement::expects_instances;
pub use records::{InstanceRecord, Skipped, TriangleSource};
pub use traversal::{Hit, MIN_DIRECTION, Ray, safe_reciprocal};
pub use tree::MAX_STACK_DEPTH;
pub use triangle::COORDINATE_LIMIT;

/// [`TriangleSource::instance`] of a triangle whose mesh is placed as instances.
pub const NO_INSTANCE: u32 = u32::MAX;
