//! Everything with a surface: which meshes and materials the placed nodes need, read in parallel and joined.

use std::collections::{BTreeMap, HashMap, HashSet};

use rayon::prelude::*;

use super::accessor::Accessors;
use super::document::Document;
use super::error::{Fault, Result};
use super::images::{self, Sources};
use super::materials::{self, Draft};
use super::nodes::{self, Placed};
use super::primitives::Plan;
use super::textures::{self, Binder};
use super::warnings::Warnings;
use crate::{Instance, Scene};

/// Meshes, materials, textures and instances of the placed nodes.
pub(crate) fn read(
    scene: &mut Scene,
    accessors: &Accessors,
    sources: Sources,
    placed: &[Placed],
    warnings: &mut Warnings,
) -> Result<()> {
    let document = accessors.document;
    let used = used_meshes(document, placed, warnings)?;
    let mut plans = Vec::new();
    // Which plans make up a glTF mesh. Primitives with the same accessors and material are read once, whatever mesh they
    // are in: some exporters write a mesh anew for every place.
    let mut plans_of: HashMap<usize, Vec<usize>> = HashMap::new();
    let mut known = HashMap::new();
    for &mesh in &used {
        for (index, json) in document.meshes[mesh].primitives.iter().enumerate() {
            let Some(plan) = Plan::new(accessors, mesh, index, warnings)? else { continue };
            let place = format!("mesh {mesh}, primitive {index}");
            let material = materials::index_of(document, json.material, &place, warnings);
            let key = (&json.attributes, json.indices, json.mode, material);
            let plan_index = *known.entry(key).or_insert(plans.len());
            if plan_index == plans.len() {
                plans.push((mesh, material, plan));
            }
            plans_of.entry(mesh).or_default().push(plan_index);
        }
    }

    // Materials in use, in the file's order; the default one, if needed, last.
    let mut slots: BTreeMap<usize, usize> = plans.iter().filter_map(|&(_, m, _)| Some((m?, 0))).collect();
    let mut drafts = Vec::new();
    for (&index, slot) in &mut slots {
        *slot = drafts.len();
        drafts.push(materials::read(document, index, warnings));
    }
    let default_slot = drafts.len();
    if plans.iter().any(|(_, material, _)| material.is_none()) {
        drafts.push(Draft::default());
    }
    let slot_of = |material: Option<usize>| material.and_then(|m| slots.get(&m).copied()).unwrap_or(default_slot);

    check_geometry_size(&plans, &drafts, slot_of, accessors, sources)?;
    let wanted = textures::images_of(document, drafts.iter().flat_map(Draft::lookups));
    let (decoded, meshes) = rayon::join(
        || images::decode_all(sources, &wanted),
        || {
            plans
                .par_iter()
                .map(|(_, material, plan)| {
                    let slot = slot_of(*material);
                    plan.read(accessors, &drafts[slot], slot)
                })
                .collect::<Vec<_>>()
        },
    );

    let mut mesh_of_plan = Vec::with_capacity(plans.len());
    for (&(index, _, _), mesh) in plans.iter().zip(meshes) {
        let (mut mesh, said) = mesh?;
        warnings.append(said);
        if mesh.triangles.is_empty() {
            mesh_of_plan.push(None);
            continue;
        }
        mesh.name = document.meshes[index].name.clone().unwrap_or_default();
        mesh_of_plan.push(Some(scene.meshes.len()));
        scene.meshes.push(mesh);
    }
    let parts = plans_of
        .into_iter()
        .map(|(mesh, plans)| (mesh, plans.into_iter().filter_map(|plan| mesh_of_plan[plan]).collect()))
        .collect();
    let mut binder = Binder::new(document, &decoded);
    scene.materials = drafts.into_iter().map(|draft| draft.bind(&mut binder)).collect();
    scene.textures = binder.textures;
    warnings.append(binder.warnings);
    warnings.append(decoded.warnings);
    scene.images = decoded.images;
    scene.instances = instances(document, placed, &parts, sources.options.max_instances, warnings)?;
    if scene.instances.is_empty() {
        warnings.push("The scene shows no triangles.");
    }
    Ok(())
}

/// Meshes that a placed node shows, in the file's order; warns of what is not posed.
fn used_meshes(document: &Document, placed: &[Placed], warnings: &mut Warnings) -> Result<Vec<usize>> {
    let mut used = HashSet::new();
    for placed in placed {
        let Some(mesh) = nodes::mesh_of(document, placed.node)? else { continue };
        let node = &document.nodes[placed.node];
        if node.skin.is_some() {
            warnings.push("Skins are not posed: skinned meshes stand where their nodes are.");
        }
        let json = &document.meshes[mesh];
        let morphed = node.weights.iter().chain(&json.weights).any(|&w| w != 0.0);
        if morphed && json.primitives.iter().any(|p| !p.targets.is_empty()) {
            warnings.push("Morph targets are not followed: their meshes have their base shape.");
        }
        used.insert(mesh);
    }
    let mut used: Vec<usize> = used.into_iter().collect();
    used.sort_unstable();
    Ok(used)
}

/// Refuses files that would grow far beyond their own size.
fn check_geometry_size(
    plans: &[(usize, Option<usize>, Plan)],
    drafts: &[Draft],
    slot_of: impl Fn(Option<usize>) -> usize,
    accessors: &Accessors,
    sources: Sources,
) -> Result<()> {
    let asked = plans
        .iter()
        .fold(0_u64, |sum, (_, material, plan)| sum.saturating_add(plan.bytes(&drafts[slot_of(*material)])));
    let allowed = sources.options.max_geometry_bytes.max(accessors.buffers.stated_bytes().saturating_mul(8));
    if asked > allowed {
        let cause = format!("would take {asked} bytes of memory, and {allowed} are allowed");
        return Err(Fault::too_large("its geometry", cause));
    }
    Ok(())
}

/// One instance for each mesh (a glTF primitive) of each placed node.
fn instances(
    document: &Document,
    placed: &[Placed],
    parts: &HashMap<usize, Vec<usize>>,
    most: usize,
    warnings: &mut Warnings,
) -> Result<Vec<Instance>> {
    let mut instances = Vec::new();
    for placed in placed {
        let Some(parts) = nodes::mesh_of(document, placed.node)?.and_then(|mesh| parts.get(&mesh)) else { continue };
        if !nodes::drawable(placed, warnings) {
            continue;
        }
        if instances.len() + parts.len() > most {
            return Err(Fault::too_large("its nodes", format!("place more than {most} mesh primitives")));
        }
        instances.extend(parts.iter().map(|&mesh| Instance { mesh, to_world: placed.to_world }));
    }
    Ok(instances)
}
