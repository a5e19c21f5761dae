use std::{
    ops::AddAssign,
    time::{Duration, Instant},
};

use glam::{DAffine3, DVec3};
use surelight_scene::Scene;

use crate::{
    AccelError, Bounds, Item,
    flatten::{binary, wide},
    forest::Forest,
    placement::{self, Placement},
};

/// How much time goes into the trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Least build time.
    Fast,
    /// A little more build time for most of the quality.
    #[default]
    Medium,
    /// Several times the build time; large triangles are split, in the binary layout only.
    Slow,
}

/// Which meshes are placed as instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Instancing {
    /// A mesh of at least 64 triangles placed at least twice, whose copies would come to 4096 triangles or more. A
    /// placement whose matrix is singular or whose condition number is above some 1e4 is copied all the same.
    #[default]
    Auto,
    /// None: everything is copied.
    Never,
    /// All that can be inverted; for tests.
    Always,
}

/// Which format the items have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Two boxes a node, one triangle an item: [`crate::item`].
    #[default]
    Binary,
    /// Four boxes a node in 8 bits a side, two triangles an item: [`crate::wide`].
    Wide,
}

/// Choices of [`Accel::build`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BuildOptions {
    /// How much time goes into the trees.
    pub quality: Quality,
    /// Which meshes are placed as instances.
    pub instancing: Instancing,
    /// Which format the items have.
    pub layout: Layout,
}

/// Where a triangle of the item stream comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TriangleSource {
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Vertex indices in the order of the item: b1 belongs to `corners[1]`, b2 to `corners[2]`. Copies under a negative
    /// determinant have their last two swapped, so that e1 × e2 points to glTF's front.
    pub corners: [u32; 3],
    /// Index into [`Scene::instances`], or [`crate::NO_INSTANCE`] when the mesh is placed as instances.
    pub instance: u32,
}

/// A mesh placed as an instance.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct InstanceRecord {
    /// Index into [`Scene::instances`].
    pub scene_instance: u32,
    /// Object to camera space: three rows of x, y, z and translation.
    pub to_world: [f32; 12],
    /// Camera to object space, inverted in f64. Its transpose takes e1 × e2 to the side that is glTF's front, whatever
    /// the sign of the determinant.
    pub to_object: [f32; 12],
}

/// Triangles left out, counted once for each placement that is copied and once for a mesh that is placed as instances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Skipped {
    /// With a coordinate that is NaN, ∞ or beyond [`crate::COORDINATE_LIMIT`] once in camera space and f32.
    pub non_finite: u64,
    /// With parallel or vanishing edges, in f32.
    pub zero_area: u64,
}

impl AddAssign for Skipped {
    fn add_assign(&mut self, other: Self) {
        self.non_finite += other.non_finite;
        self.zero_area += other.zero_area;
    }
}

/// What a build came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Cost of the top-level tree by the surface area heuristic, in items read by a ray that enters its bounds; an
    /// instance counts as one.
    pub sah: f64,
    /// Time spent checking and placing triangles.
    pub place: Duration,
    /// Time spent building trees.
    pub build: Duration,
    /// Time spent flattening them.
    pub flatten: Duration,
}

/// Trees over a scene, flattened for the kernel.
#[derive(Clone, Debug)]
pub struct Accel {
    /// Which format the items have.
    pub layout: Layout,
    /// The stream; see [`crate::item`] and [`crate::wide`]. Item 0 is the root.
    pub items: Vec<Item>,
    /// By prim id. Ids ascend along the stream.
    pub triangles: Vec<TriangleSource>,
    /// By instance index; empty when everything is copied.
    pub instances: Vec<InstanceRecord>,
    /// Most entries that a walk pushes which keeps one a node, plus one to mark the way out of an instance. At most
    /// [`crate::MOST_STACK`].
    pub stack_depth: u32,
    /// Around everything that can be hit, in camera space; empty when nothing can.
    pub bounds: Bounds,
    /// Triangles left out.
    pub skipped: Skipped,
    /// The world position that is 0 in camera space.
    pub origin: DVec3,
    /// Figures of the build.
    pub statistics: Statistics,
}

impl Accel {
    /// Builds for a camera at `origin`.
    ///
    /// Never panics, whatever the scene holds; refuses what cannot be indexed. Runs on rayon's threads.
    pub fn build(scene: &Scene, origin: DVec3, options: &BuildOptions) -> Result<Self, AccelError> {
        let start = Instant::now();
        placement::check(scene)?;
        let placed = placement::place(scene, origin, options);
        let skipped = placed.meshes.iter().fold(placed.world.skipped, |mut all, mesh| {
            all += mesh.skipped;
            all
        });
        let placed_at = Instant::now();

        let forest = Forest::build(&placed, options)?;
        let built_at = Instant::now();

        let flat = match options.layout {
            Layout::Binary => binary::flatten(&placed, &forest),
            Layout::Wide => wide::flatten(&placed, &forest),
        };
        let statistics = Statistics {
            sah: flat.sah,
            place: placed_at - start,
            build: built_at - placed_at,
            flatten: built_at.elapsed(),
        };
        let instances = forest.placements.iter().map(|&(k, _)| record(&placed.placements[k])).collect();
        Ok(Self {
            items: flat.items,
            triangles: flat.triangles,
            instances,
            stack_depth: flat.depth,
            layout: options.layout,
            bounds: forest.bounds(),
            skipped,
            origin,
            statistics,
        })
    }
}

fn record(p: &Placement) -> InstanceRecord {
    InstanceRecord { scene_instance: p.scene_instance, to_world: rows(&p.to_world), to_object: rows(&p.to_object) }
}

pub(crate) fn rows(a: &DAffine3) -> [f32; 12] {
    let m = a.matrix3.transpose();
    let t = a.translation;
    let mut out = [0.0; 12];
    for (k, (row, shift)) in [(m.x_axis, t.x), (m.y_axis, t.y), (m.z_axis, t.z)].into_iter().enumerate() {
        out[4 * k..4 * k + 4].copy_from_slice(&[row.x as f32, row.y as f32, row.z as f32, shift as f32]);
    }
    out
}
