//! KHR_materials_volume requires closed meshes, and files have open ones.
//!
//! A path that enters a medium through a sheet and never leaves it carries the wrong radiance: a
//! crossing scales radiance by the square of the index, and only the crossing back undoes it. Open
//! parts of a mesh therefore become thin-walled. A part is a set of triangles connected by edges,
//! with vertices at equal positions merged, across all primitives of a glTF mesh with a volume.

mod boundary;
mod sets;

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use self::sets::Sets;
use super::warnings::{Warnings, count_of};
use crate::{Material, Mesh, Scene};

/// Share of a part's surface that openings may take before the part becomes thin-walled. A path
/// inside leaves through an opening with about that probability, and is wrong then by the square of
/// the index, 2.25 for glass: at 2 % of the surface that is an error of some 2 %, less than the
/// error of losing refraction. Missing triangles and cracks of a fine mesh stay below; the open
/// side of a box is 20 %.
const MAX_OPENING: f64 = 0.02;

/// Openings up to this share are rounding, such as that of a vertex on the edge of a larger
/// triangle (a T-junction).
const ROUNDING: f64 = 1e-4;

/// A part whose volume is below this share of its area to the power 3/2 is flat: a sheet that is
/// there twice, front and back.
const FLAT: f64 = 1e-9;

/// Where the primitives of a glTF mesh are in the scene.
pub(super) struct Shape<'a> {
    /// glTF mesh.
    pub(super) mesh: usize,
    /// Indices into [`Scene::meshes`].
    pub(super) parts: &'a mut Vec<usize>,
}

/// Makes the open parts of meshes with a volume thin-walled, and warns of them.
pub(super) fn make_thin(scene: &mut Scene, shapes: &mut [Shape], warnings: &mut Warnings) {
    let groups = groups(scene, shapes);
    let meshes = &scene.meshes;
    let findings: Vec<Findings> = groups.par_iter().map(|group| examine(meshes, &group.meshes)).collect();
    let mut thin = vec![false; scene.meshes.len()];
    // The mesh that takes the open triangles of another.
    let mut split_off = BTreeMap::new();
    for (group, findings) in groups.iter().zip(findings) {
        findings.warn(scene, group, warnings);
        for (&index, open) in group.meshes.iter().zip(&findings.open) {
            if !open.contains(&Some(true)) {
                continue;
            }
            if !open.contains(&Some(false)) {
                thin[index] = true;
                continue;
            }
            let mesh = &scene.meshes[index];
            let pieces = [true, false].map(|wanted| subset(mesh, |i| (open[i] == Some(true)) == wanted));
            let [open, closed] = pieces;
            scene.meshes[index] = closed;
            split_off.insert(index, scene.meshes.len());
            scene.meshes.push(open);
            thin.push(true);
        }
    }
    for shape in shapes {
        let more: Vec<usize> = shape.parts.iter().filter_map(|part| split_off.get(part).copied()).collect();
        shape.parts.extend(more);
    }
    thin_materials(scene, &thin);
}

/// Gives these meshes materials without a volume: clones, or the materials themselves where no
/// other mesh has them.
fn thin_materials(scene: &mut Scene, thin: &[bool]) {
    let mut shared = vec![false; scene.materials.len()];
    for (mesh, _) in scene.meshes.iter().zip(thin).filter(|(_, thin)| !**thin) {
        shared[mesh.material] = true;
    }
    let mut clones = BTreeMap::new();
    for (mesh, _) in scene.meshes.iter_mut().zip(thin).filter(|(_, thin)| **thin) {
        let material = mesh.material;
        if shared[material] {
            mesh.material = *clones.entry(material).or_insert_with(|| {
                scene.materials.push(Material { volume: None, ..scene.materials[material].clone() });
                scene.materials.len() - 1
            });
        } else {
            scene.materials[material].volume = None;
        }
    }
}

/// Whether a surface of this material bounds a medium that light gets into.
fn encloses(m: &Material) -> bool {
    m.volume.is_some() && !m.unlit && (m.transmission > 0.0 || m.diffuse_transmission.factor > 0.0)
}

/// Meshes that are to be closed together.
struct Group {
    /// glTF mesh, the first if several share a primitive.
    gltf: usize,
    /// Indices into [`Scene::meshes`].
    meshes: Vec<usize>,
}

/// The meshes with a volume of each glTF mesh. glTF meshes that share one are one group, so that
/// each mesh is examined once.
fn groups(scene: &Scene, shapes: &[Shape]) -> Vec<Group> {
    let encloses: Vec<bool> = scene.materials.iter().map(encloses).collect();
    let encloses = |&&mesh: &&usize| encloses[scene.meshes[mesh].material];
    let mut sets = Sets::new(scene.meshes.len());
    for shape in shapes.iter() {
        let mut with_volume = shape.parts.iter().filter(encloses);
        let Some(&first) = with_volume.next() else { continue };
        with_volume.for_each(|&mesh| sets.join(first as u32, mesh as u32));
    }
    let mut groups: BTreeMap<u32, Group> = BTreeMap::new();
    let mut seen = vec![false; scene.meshes.len()];
    for shape in shapes.iter() {
        for &mesh in shape.parts.iter().filter(encloses) {
            let group = groups.entry(sets.root(mesh as u32)).or_insert(Group { gltf: shape.mesh, meshes: Vec::new() });
            if !std::mem::replace(&mut seen[mesh], true) {
                group.meshes.push(mesh);
            }
        }
    }
    groups.into_values().collect()
}

/// The parts that a group's triangles form.
#[derive(Default)]
struct Findings {
    /// For each mesh and triangle whether it belongs to an open part; `None` where it has no area.
    open: Vec<Vec<Option<bool>>>,
    /// Parts.
    parts: usize,
    /// Parts that are open.
    thin: usize,
    /// Parts with openings that are too small to make them thin-walled.
    leaky: usize,
}

impl Findings {
    fn warn(&self, scene: &Scene, group: &Group, warnings: &mut Warnings) {
        let name = group.meshes.first().map_or("", |&mesh| scene.meshes[mesh].name.as_str());
        let name = if name.is_empty() { String::new() } else { format!(" ({name:?})") };
        let mut warn = |parts: usize, but: &str, result: &str| {
            if parts > 0 {
                let of = count_of(self.parts, "part");
                warnings.push(format!(
                    "Mesh {}{name} has a volume (KHR_materials_volume), but {but} in {parts} of {of}, {result}: close the \
                     mesh, or take the volume from its material.",
                    group.gltf,
                ));
            }
        };
        warn(self.thin, "is not closed", "which is drawn thin-walled");
        warn(self.leaky, "has small holes", "where light is wrong");
    }
}

/// Measures of a part.
#[derive(Clone, Copy, Default)]
struct Part {
    area: f64,
    /// Six times the signed volume.
    volume: f64,
    /// Area of its openings.
    opening: f64,
}

impl Part {
    /// `None` for a part of no area.
    fn is_open(&self) -> Option<bool> {
        let flat = self.volume.abs() <= 6.0 * FLAT * self.area * self.area.sqrt();
        (self.area > 0.0).then_some(flat || self.opening > MAX_OPENING * self.area)
    }
}

/// Finds the open parts of meshes that are one in space.
fn examine(meshes: &[Mesh], group: &[usize]) -> Findings {
    let meshes = || group.iter().map(|&mesh| &meshes[mesh]);
    let positions: Vec<_> = meshes().flat_map(|mesh| &mesh.positions).copied().collect();
    let count = meshes().map(|mesh| mesh.triangles.len()).sum();
    if u32::try_from(positions.len().max(count)).is_err() {
        return Findings { open: vec![Vec::new(); group.len()], ..Findings::default() };
    }
    let welded = sets::weld(&positions);
    let at = |vertex: u32| positions[vertex as usize].as_dvec3();

    // The triangles of all meshes by their welded vertices; `None` where the BVH drops them too.
    let mut corners_of: Vec<Option<[u32; 3]>> = Vec::with_capacity(count);
    let mut first = 0;
    for mesh in meshes() {
        corners_of.extend(mesh.triangles.iter().map(|triangle| {
            let corners = triangle.map(|vertex| welded[first + vertex as usize]);
            let [a, b, c] = corners;
            let proper = a != b && b != c && c != a && corners.iter().all(|&v| at(v).is_finite());
            proper.then_some(corners)
        }));
        first += mesh.positions.len();
    }
    let triangles = || (0..).zip(&corners_of).filter_map(|(triangle, corners)| Some((triangle, (*corners)?)));

    let mut sets = Sets::new(count);
    let openings = boundary::openings(&positions, triangles(), &mut sets);
    let mut parts = vec![Part::default(); count];
    for (triangle, corners) in triangles() {
        let root = sets.root(triangle);
        // Relative to a vertex of the part, where rounding is smallest. A root is a triangle of the
        // part.
        let near = corners_of[root as usize].map_or(DVec3::ZERO, |[near, ..]| at(near));
        let [a, b, c] = corners.map(|vertex| at(vertex) - near);
        let part = &mut parts[root as usize];
        part.area += 0.5 * (b - a).cross(c - a).length();
        part.volume += a.dot(b.cross(c));
    }
    for opening in openings {
        parts[sets.root(opening.triangle) as usize].opening += opening.area;
    }

    let mut findings = Findings::default();
    for part in &parts {
        let Some(open) = part.is_open() else { continue };
        findings.parts += 1;
        findings.thin += usize::from(open);
        findings.leaky += usize::from(!open && part.opening > ROUNDING * part.area);
    }
    let mut verdicts = (0..count as u32).map(|triangle| parts[sets.root(triangle) as usize].is_open());
    findings.open = meshes().map(|mesh| verdicts.by_ref().take(mesh.triangles.len()).collect()).collect();
    findings
}

/// A mesh of some of another's triangles, with the vertices that they use.
fn subset(mesh: &Mesh, keep: impl Fn(usize) -> bool) -> Mesh {
    let mut triangles: Vec<[u32; 3]> =
        mesh.triangles.iter().enumerate().filter(|(i, _)| keep(*i)).map(|(_, triangle)| *triangle).collect();
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut used = Vec::new();
    for vertex in triangles.iter_mut().flatten() {
        let number = &mut number[*vertex as usize];
        if *number == u32::MAX {
            *number = used.len() as u32;
            used.push(*vertex as usize);
        }
        *vertex = *number;
    }
    fn pick<T: Copy>(all: &[T], used: &[usize]) -> Vec<T> {
        used.iter().map(|&i| all[i]).collect()
    }
    Mesh {
        name: mesh.name.clone(),
        positions: pick(&mesh.positions, &used),
        triangles,
        normals: mesh.normals.as_deref().map(|all| pick(all, &used)),
        tangents: mesh.tangents.as_deref().map(|all| pick(all, &used)),
        uvs: mesh.uvs.iter().map(|all| pick(all, &used)).collect(),
        colors: mesh.colors.as_deref().map(|all| pick(all, &used)),
        material: mesh.material,
    }
}
