//! The primitives of the trees, from a scene: triangles in camera space, and meshes placed as
//! instances.

use glam::{DAffine3, DVec3, Vec3};
use rayon::prelude::*;
use surelight_scene::{Instance, Mesh, Scene};

use crate::{
    BuildOptions, Instancing, NO_INSTANCE, Skipped, TriangleSource, pairing,
    triangle::{COORDINATE_LIMIT, Defect, Triangle},
};

/// A mesh with fewer triangles is copied: entering an instance costs about as much as traversing a
/// tree of this size.
const MIN_TRIANGLES: usize = 64;
/// A mesh whose copies have fewer triangles is copied: they fit in a cache anyway.
const MIN_COPIED_TRIANGLES: usize = 4096;
/// All meshes are copied where the copies together have fewer triangles: 50 MiB and half a second
/// of building, after which each traversal step is cheaper by a sixth, since it never enters an
/// instance (docs/performance.md).
const MIN_TOTAL_TRIANGLES: usize = 1 << 20;
/// Placements that blow rounding errors up by more than this are copied in f64 instead.
const MAX_CONDITION: f64 = 1e4;

/// Triangles that were found sound, and where each came from.
#[derive(Default)]
pub(crate) struct Soup {
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) sources: Vec<TriangleSource>,
    /// Leaves of one or two triangles.
    pub(crate) pairs: Vec<[u32; 2]>,
    pub(crate) skipped: Skipped,
}

impl Soup {
    fn pair(&mut self, welded: &[u32]) {
        let corners: Vec<[u32; 3]> = self.sources.iter().map(|s| s.corners.map(|i| welded[i as usize])).collect();
        self.pairs = pairing::pairs(&self.triangles, &corners, welded.len());
    }

    fn append(&mut self, mut other: Soup) {
        let first = self.triangles.len() as u32;
        let shift = |i: u32| if i == pairing::ALONE { i } else { i + first };
        self.pairs.extend(other.pairs.iter().map(|p| p.map(shift)));
        self.triangles.append(&mut other.triangles);
        self.sources.append(&mut other.sources);
        self.skipped += other.skipped;
    }

    fn gather(mesh: &Mesh, positions: &[Vec3], flip: bool, source: impl Fn([u32; 3]) -> TriangleSource + Sync) -> Self {
        mesh.triangles
            .par_chunks(1 << 14)
            .map(|chunk| {
                let mut soup = Soup::default();
                soup.triangles.reserve(chunk.len());
                soup.sources.reserve(chunk.len());
                for &[a, b, c] in chunk {
                    let corners = if flip { [a, c, b] } else { [a, b, c] };
                    match Triangle::new(corners.map(|i| positions[i as usize])) {
                        Ok(triangle) => {
                            soup.triangles.push(triangle);
                            soup.sources.push(source(corners));
                        }
                        Err(Defect::NonFinite) => soup.skipped.non_finite += 1,
                        Err(Defect::ZeroArea) => soup.skipped.zero_area += 1,
                    }
                }
                soup
            })
            .collect::<Vec<_>>()
            .into_iter()
            .fold(Soup::default(), |mut all, part| {
                if all.triangles.is_empty() && all.skipped == Skipped::default() {
                    return part;
                }
                all.append(part);
                all
            })
    }
}

/// A mesh placed as an instance.
pub(crate) struct Placement {
    pub(crate) scene_instance: u32,
    /// Index into [`Placed::meshes`].
    pub(crate) mesh: usize,
    /// Object to camera space.
    pub(crate) to_world: DAffine3,
    pub(crate) to_object: DAffine3,
}

/// A scene sorted into copied triangles and instances.
pub(crate) struct Placed {
    pub(crate) world: Soup,
    /// Meshes in object space, for those that are placed as instances.
    pub(crate) meshes: Vec<Soup>,
    pub(crate) placements: Vec<Placement>,
}

/// How often each mesh is placed.
fn uses(scene: &Scene) -> Vec<usize> {
    let mut uses = vec![0usize; scene.meshes.len()];
    for instance in &scene.instances {
        if let Some(uses) = uses.get_mut(instance.mesh) {
            *uses += 1;
        }
    }
    uses
}

/// Whether each mesh is placed as instances, wherever its placement can be inverted.
fn meshes_to_instance(scene: &Scene, options: &BuildOptions) -> Vec<bool> {
    let uses = uses(scene);
    let copies = |k: usize| scene.meshes[k].triangles.len().saturating_mul(uses[k]);
    let is_candidate = |k: usize| {
        uses[k] >= 2 && scene.meshes[k].triangles.len() >= MIN_TRIANGLES && copies(k) >= MIN_COPIED_TRIANGLES
    };
    let all = 0..scene.meshes.len();
    match options.instancing {
        Instancing::Auto => {
            let total = all.clone().filter(|&k| is_candidate(k)).map(copies).fold(0, usize::saturating_add);
            all.map(|k| total >= MIN_TOTAL_TRIANGLES && is_candidate(k)).collect()
        }
        Instancing::Never => vec![false; all.len()],
        Instancing::Always => all.map(|k| uses[k] > 0 && copies(k) > 0).collect(),
    }
}

/// Whether a build will most probably place some mesh as instances, predicted without building:
/// wrong where none of its placements can be inverted, or none of its triangles is sound.
pub fn expects_instances(scene: &Scene, options: &BuildOptions) -> bool {
    meshes_to_instance(scene, options).contains(&true)
}

pub(crate) fn place(scene: &Scene, origin: DVec3, options: &BuildOptions) -> Placed {
    let to_camera = |instance: &Instance| DAffine3 {
        matrix3: instance.to_world.matrix3,
        translation: instance.to_world.translation - origin,
    };

    let uses = uses(scene);
    let meshes_to_instance = meshes_to_instance(scene, options);
    let reach: Vec<f64> = scene
        .meshes
        .iter()
        .zip(&meshes_to_instance)
        .map(|(mesh, &meshes_to_instance)| if meshes_to_instance { reach(mesh) } else { 0.0 })
        .collect();

    let mut slot_of = vec![None; scene.meshes.len()];
    let mut mesh_of_slot = Vec::new();
    let mut placements = Vec::new();
    let mut copied = Vec::new();
    for (i, instance) in scene.instances.iter().enumerate() {
        let to_world = to_camera(instance);
        let inverse = if meshes_to_instance[instance.mesh] { invert(&to_world, reach[instance.mesh]) } else { None };
        match inverse {
            Some(to_object) => {
                let mesh = *slot_of[instance.mesh].get_or_insert_with(|| {
                    mesh_of_slot.push(instance.mesh);
                    mesh_of_slot.len() - 1
                });
                placements.push(Placement { scene_instance: i as u32, mesh, to_world, to_object });
            }
            None => copied.push((i as u32, instance.mesh, to_world)),
        }
    }

    let welded: Vec<Vec<u32>> = scene
        .meshes
        .par_iter()
        .zip(&uses)
        .map(|(mesh, &uses)| if uses > 0 { pairing::welded(&mesh.positions) } else { Vec::new() })
        .collect();
    let meshes = mesh_of_slot
        .par_iter()
        .map(|&m| {
            let mesh = &scene.meshes[m];
            let mut soup = Soup::gather(mesh, &mesh.positions, false, |corners| TriangleSource {
                mesh: m as u32,
                corners,
                instance: NO_INSTANCE,
            });
            soup.pair(&welded[m]);
            soup
        })
        .collect();
    let parts: Vec<Soup> = copied
        .par_iter()
        .map(|&(instance, m, to_world)| {
            let mesh = &scene.meshes[m];
            let positions: Vec<Vec3> = mesh
                .positions
                .par_iter()
                .with_min_len(1 << 12)
                .map(|p| to_world.transform_point3(p.as_dvec3()).as_vec3())
                .collect();
            let flip = to_world.matrix3.determinant() < 0.0;
            let mut soup =
                Soup::gather(mesh, &positions, flip, |corners| TriangleSource { mesh: m as u32, corners, instance });
            soup.pair(&welded[m]);
            soup
        })
        .collect();
    let mut world = Soup::default();
    let total = parts.iter().map(|p| p.triangles.len()).sum();
    world.triangles.reserve(total);
    world.sources.reserve(total);
    parts.into_iter().for_each(|part| world.append(part));
    Placed { world, meshes, placements }
}

/// Greatest absolute coordinate of a mesh, not counting those that are too large for any triangle.
fn reach(mesh: &Mesh) -> f64 {
    let size = |p: &Vec3| p.abs().to_array().into_iter().filter(|x| *x <= COORDINATE_LIMIT).fold(0.0, f32::max);
    f64::from(mesh.positions.par_iter().map(size).reduce(|| 0.0, f32::max))
}

/// The inverse, where placing by it is as good as copying: finite and well conditioned, in range
/// for f32, and with all of the mesh (`reach` from its origin) well inside [`COORDINATE_LIMIT`].
fn invert(to_world: &DAffine3, reach: f64) -> Option<DAffine3> {
    let m = to_world.matrix3;
    if !to_world.is_finite() || m.determinant() == 0.0 {
        return None;
    }
    let inverse = to_world.inverse();
    let norm = |m: glam::DMat3| m.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
    // Frobenius norms: at least the condition number, at most three times it.
    let condition = norm(m) * norm(inverse.matrix3);
    let fits = |a: &DAffine3| a.is_finite() && a.to_cols_array().iter().all(|x| x.abs() < 1e12);
    let placed = norm(m) * reach * 2.0 + to_world.translation.abs().max_element();
    (condition <= MAX_CONDITION && placed < 0.1 * f64::from(COORDINATE_LIMIT) && fits(&inverse) && fits(to_world))
        .then_some(inverse)
}
