//! Everything with a surface: which meshes and materials the placed nodes need, read in parallel
//! and joined.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DAffine3;
use rayon::prelude::*;

use super::accessor::Accessors;
use super::animation::Poses;
use super::document::Document;
use super::draco;
use super::error::{Fault, Result};
use super::images::{self, Sources};
use super::instancing;
use super::material_draft::MaterialDraft;
use super::materials;
use super::nodes::{self, PlacedNode, WorldTransforms};
use super::open_volumes::{self, Shape};
use super::primitives::{Deformation, Plan};
use super::skins::{self, Skin};
use super::textures::{self, Binder};
use super::variants;
use super::warnings::Warnings;
use crate::{Instance, Scene};

/// Meshes, materials, textures and instances of the placed nodes.
pub(crate) fn read(
    scene: &mut Scene,
    accessors: &Accessors,
    sources: Sources,
    placed: &[PlacedNode],
    poses: &Poses,
    warnings: &mut Warnings,
) -> Result<()> {
    let document = accessors.document;
    let variant = variants::choose(document, sources.options.variant.as_deref())?;
    let posed_meshes = posed_meshes(document, placed, poses)?;
    let skins = skins(accessors, &posed_meshes, poses, warnings)?;
    let mut plans = Vec::new();
    // The plans of a posed glTF mesh. Primitives with the same accessors and material are read
    // once, whatever mesh they are in: some exporters repeat a mesh for every place.
    let mut plans_of: HashMap<&PosedMesh, Vec<usize>> = HashMap::new();
    let mut known = HashMap::new();
    for posed in posed_meshes.values().collect::<BTreeSet<_>>() {
        let mesh = posed.mesh;
        for (index, json) in document.meshes[mesh].primitives.iter().enumerate() {
            let Some(plan) = Plan::new(accessors, mesh, index, warnings)? else { continue };
            let place = format!("mesh {mesh}, primitive {index}");
            let material = variants::material(json, variant, &place, warnings);
            let material = materials::index_of(document, material, &place, warnings);
            let draco = json.extensions.has(draco::NAME).then_some((mesh, index));
            let targets = (!posed.weights.is_empty()).then_some(&json.targets);
            let key =
                (&json.attributes, json.indices, json.mode, material, draco, (targets, &posed.weights, posed.skin));
            let plan_index = *known.entry(key).or_insert(plans.len());
            if plan_index == plans.len() {
                plans.push(Job { posed, material, plan });
            }
            plans_of.entry(posed).or_default().push(plan_index);
        }
    }

    // Materials in use, in the file's order; the default one, if needed, last.
    let mut slots: BTreeMap<usize, usize> = plans.iter().filter_map(|job| Some((job.material?, 0))).collect();
    let mut drafts = Vec::new();
    for (&index, slot) in &mut slots {
        *slot = drafts.len();
        drafts.push(materials::read(document, index, warnings));
    }
    let default_slot = drafts.len();
    if plans.iter().any(|job| job.material.is_none()) {
        drafts.push(MaterialDraft::default());
    }
    let slot_of = |material: Option<usize>| material.and_then(|m| slots.get(&m).copied()).unwrap_or(default_slot);

    check_geometry_size(&plans, &drafts, slot_of, accessors, sources)?;
    let wanted = textures::images_of(document, drafts.iter().flat_map(MaterialDraft::lookups));
    let (decoded, meshes) = rayon::join(
        || images::decode_all(sources, &wanted),
        || {
            plans
                .par_iter()
                .map(|job| {
                    let slot = slot_of(job.material);
                    let weights: Vec<f32> = job.posed.weights.iter().map(|&bits| f64::from_bits(bits) as f32).collect();
                    let skin = job.posed.skin.and_then(|skin| skins.get(&skin));
                    job.plan.read(accessors, &drafts[slot], slot, &Deformation { weights: &weights, skin })
                })
                .collect::<Vec<_>>()
        },
    );

    let mut mesh_of_plan = Vec::with_capacity(plans.len());
    for (job, mesh) in plans.iter().zip(meshes) {
        let (mut mesh, said) = mesh?;
        warnings.append(said);
        if mesh.triangles.is_empty() {
            mesh_of_plan.push(None);
            continue;
        }
        mesh.name = document.meshes[job.posed.mesh].name.clone().unwrap_or_default();
        mesh_of_plan.push(Some(scene.meshes.len()));
        scene.meshes.push(mesh);
    }
    let mut parts: BTreeMap<&PosedMesh, Vec<usize>> = plans_of
        .into_iter()
        .map(|(posed, plans)| (posed, plans.into_iter().filter_map(|plan| mesh_of_plan[plan]).collect()))
        .collect();
    let mut binder = Binder::new(document, &decoded);
    scene.materials = drafts.into_iter().map(|draft| draft.bind(&mut binder)).collect();
    scene.textures = binder.textures;
    warnings.append(binder.warnings);
    let mut made = binder.made;
    warnings.append(decoded.warnings);
    scene.images = decoded.images;
    scene.images.append(&mut made);
    let mut shapes: Vec<Shape> = parts.iter_mut().map(|(posed, parts)| Shape { mesh: posed.mesh, parts }).collect();
    open_volumes::make_thin(scene, &mut shapes, warnings);
    scene.instances =
        instances(accessors, placed, &posed_meshes, &skins, &parts, sources.options.max_instances, warnings)?;
    if scene.instances.is_empty() {
        warnings.push("The scene shows no triangles.");
    }
    Ok(())
}

/// A mesh with the skin and weights of a node. Nodes with equal ones share their triangles.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct PosedMesh {
    /// glTF mesh.
    mesh: usize,
    /// glTF skin that moves it.
    skin: Option<usize>,
    /// Bits of the weights of its morph targets; empty when none has any weight.
    weights: Vec<u64>,
}

/// A primitive to read.
struct Job<'a> {
    posed: &'a PosedMesh,
    material: Option<usize>,
    plan: Plan<'a>,
}

/// The posed mesh of each placed node that has a mesh and is visible.
fn posed_meshes(document: &Document, placed: &[PlacedNode], poses: &Poses) -> Result<BTreeMap<usize, PosedMesh>> {
    let mut posed_meshes = BTreeMap::new();
    for placed in placed.iter().filter(|placed| placed.visible) {
        let Some(mesh) = nodes::mesh_of(document, placed.node)? else { continue };
        let node = &document.nodes[placed.node];
        let json = &document.meshes[mesh];
        let held = json.primitives.iter().any(|p| p.attributes.contains_key("JOINTS_0"));
        let targets = json.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0);
        let animated = poses.get(&placed.node).and_then(|pose| pose.weights.as_ref());
        let weights = animated.unwrap_or(if node.weights.is_empty() { &json.weights } else { &node.weights });
        // A weight that is no number moves nothing.
        let mut weights: Vec<u64> =
            weights.iter().take(targets).map(|w| if w.is_finite() { w.to_bits() } else { 0 }).collect();
        while weights.last().is_some_and(|&bits| f64::from_bits(bits) == 0.0) {
            weights.pop();
        }
        let skin = node.skin.filter(|_| held).map(|skin| skin.index());
        posed_meshes.insert(placed.node, PosedMesh { mesh, skin, weights });
    }
    Ok(posed_meshes)
}

/// The skins of these meshes, posed.
fn skins(
    accessors: &Accessors,
    posed_meshes: &BTreeMap<usize, PosedMesh>,
    poses: &Poses,
    warnings: &mut Warnings,
) -> Result<HashMap<usize, Skin>> {
    let mut posed = HashMap::new();
    let users: BTreeMap<usize, usize> =
        posed_meshes.iter().filter_map(|(&node, posed)| Some((posed.skin?, node))).collect();
    if users.is_empty() {
        return Ok(posed);
    }
    let worlds = WorldTransforms::new(accessors.document, poses);
    let skins = skins::read(accessors.document)?;
    for (skin, node) in users {
        posed.insert(skin, skins::pose(accessors, &skins, skin, &worlds, &format!("node {node}"), warnings)?);
    }
    Ok(posed)
}

/// Refuses files that would grow far beyond their own size.
fn check_geometry_size(
    plans: &[Job],
    drafts: &[MaterialDraft],
    slot_of: impl Fn(Option<usize>) -> usize,
    accessors: &Accessors,
    sources: Sources,
) -> Result<()> {
    let bytes_requested =
        plans.iter().fold(0_u64, |sum, job| sum.saturating_add(job.plan.bytes(&drafts[slot_of(job.material)])));
    let allowed = sources.options.max_geometry_bytes.max(accessors.buffers.bytes().saturating_mul(8));
    if bytes_requested > allowed {
        let cause = format!("would take {bytes_requested} bytes of memory, and {allowed} are allowed");
        return Err(Fault::too_large("its geometry", cause));
    }
    Ok(())
}

/// One instance for each mesh (a glTF primitive) of each placed node.
fn instances(
    accessors: &Accessors,
    placed: &[PlacedNode],
    posed_meshes: &BTreeMap<usize, PosedMesh>,
    skins: &HashMap<usize, Skin>,
    parts: &BTreeMap<&PosedMesh, Vec<usize>>,
    most: usize,
    warnings: &mut Warnings,
) -> Result<Vec<Instance>> {
    let mut instances = Vec::new();
    for placed in placed {
        let Some(posed) = posed_meshes.get(&placed.node) else { continue };
        let Some(parts) = parts.get(posed) else { continue };
        // Joints alone say where a skin is, and not the node that has it.
        let placed = match posed.skin.and_then(|skin| skins.get(&skin)) {
            Some(skin) => &PlacedNode { to_world: DAffine3::from_translation(skin.anchor), ..*placed },
            None => placed,
        };
        let left = most.saturating_sub(instances.len()) / parts.len().max(1);
        let copies = instancing::transforms(accessors, placed.node, left)?.unwrap_or_else(|| vec![DAffine3::IDENTITY]);
        if copies.len() > left {
            return Err(Fault::too_large("its nodes", format!("place more than {most} mesh primitives")));
        }
        for copy in copies {
            let placed = PlacedNode { to_world: placed.to_world * copy, ..*placed };
            if nodes::drawable(&placed, warnings) {
                instances.extend(parts.iter().map(|&mesh| Instance { mesh, to_world: placed.to_world }));
            }
        }
    }
    Ok(instances)
}
