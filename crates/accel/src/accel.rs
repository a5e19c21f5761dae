use std::time::{Duration, Instant};

use glam::DVec3;
use surelight_scene::Scene;

use crate::{
    AccelError, Bounds, BuildOptions, Item, flatten,
    forest::Forest,
    placement::{self, Placement},
    records::{InstanceRecord, Skipped, TriangleSource, rows},
};

/// Statistics of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Cost of the top-level tree by the surface area heuristic, in items read by a ray that enters
    /// its bounds; an instance counts as one.
    pub sah: f64,
    /// Time spent checking and placing triangles.
    pub place: Duration,
    /// Time spent building trees.
    pub build: Duration,
    /// Time spent flattening them.
    pub flatten: Duration,
}

/// BVHs over a scene, flattened for the kernel.
#[derive(Clone, Debug)]
pub struct Accel {
    /// The stream; see [`crate::item`]. Item 0 is the root.
    pub items: Vec<Item>,
    /// By prim id. Ids ascend along the stream.
    pub triangles: Vec<TriangleSource>,
    /// By instance index; empty when everything is copied.
    pub instances: Vec<InstanceRecord>,
    /// The largest number of entries on the traversal stack: one per node on the deepest path
    /// through both levels, and one to spare where there are instances. At most
    /// [`crate::MAX_STACK_DEPTH`].
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
    /// Never panics, whatever the scene holds. Runs on rayon's threads.
    ///
    /// # Errors
    /// Where [`Scene::validate`] refuses the scene, and where it is too large to be indexed.
    pub fn build(scene: &Scene, origin: DVec3, options: &BuildOptions) -> Result<Self, AccelError> {
        let start = Instant::now();
        scene.validate()?;
        let placed = placement::place(scene, origin, options);
        let skipped = placed.meshes.iter().fold(placed.world.skipped, |mut all, mesh| {
            all += mesh.skipped;
            all
        });
        let placed_at = Instant::now();

        let forest = Forest::build(&placed, options)?;
        let built_at = Instant::now();

        let flat = flatten::flatten(&placed, &forest);
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
