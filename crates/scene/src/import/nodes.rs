//! The node hierarchy: checked to be a forest, then traversed without recursion, in f64.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};
use serde::Deserialize;

use super::animation::{Pose, Poses};
use super::document::{Document, Int, Node};
use super::error::{Fault, Result};
use super::warnings::Warnings;

/// A node of the chosen scene and its transform.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedNode {
    /// glTF node index.
    pub(crate) node: usize,
    /// Node to world.
    pub(crate) to_world: DAffine3,
    /// Whether its meshes and lights are visible; cameras always are (KHR_node_visibility).
    pub(crate) visible: bool,
}

const VISIBILITY: &str = "KHR_node_visibility";

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "default_true")]
    visible: bool,
}

fn default_true() -> bool {
    true
}

/// All nodes of the chosen scene that carry something, in the order of their indices.
///
/// The scene is `wanted`, else the file's default, else its first, else all nodes without a parent.
pub(crate) fn place(
    document: &Document,
    wanted: Option<usize>,
    poses: &Poses,
    warnings: &mut Warnings,
) -> Result<Vec<PlacedNode>> {
    let parents = parents(document)?;
    let roots = roots(document, wanted, &parents, warnings)?;
    let mut placed = Vec::new();
    let mut stack: Vec<_> = roots.iter().rev().map(|&root| (root, DAffine3::IDENTITY, true)).collect();
    // Every node has at most one parent and roots have none, so nothing is visited twice and the
    // traversal ends.
    while let Some((index, parent, shown)) = stack.pop() {
        let node = &document.nodes[index];
        let to_world = parent * local(node, index, poses.get(&index), warnings);
        let visible = shown && is_visible(node, index, warnings);
        if node.mesh.is_some() || node.camera.is_some() || !node.extensions.is_empty() {
            placed.push(PlacedNode { node: index, to_world, visible });
        }
        stack.extend(node.children.iter().rev().map(|child| (child.index(), to_world, visible)));
    }
    placed.sort_unstable_by_key(|p| p.node);
    Ok(placed)
}

/// The world transform of every node, in the chosen scene or not: joints may be anywhere.
#[derive(Debug)]
pub(crate) struct WorldTransforms(Vec<DAffine3>);

impl WorldTransforms {
    /// The hierarchy must have been found to be a forest by [`place`].
    pub(crate) fn new(document: &Document, poses: &Poses) -> Self {
        let nodes = &document.nodes;
        let mut is_child = vec![false; nodes.len()];
        for child in nodes.iter().flat_map(|node| &node.children) {
            if let Some(flag) = is_child.get_mut(child.index()) {
                *flag = true;
            }
        }
        let mut worlds = vec![DAffine3::IDENTITY; nodes.len()];
        let mut stack: Vec<usize> = (0..nodes.len()).filter(|&i| !is_child[i]).collect();
        // Defects were reported when the nodes were placed, or are of nodes that are not shown.
        let mut untold = Warnings::default();
        while let Some(index) = stack.pop() {
            let node = &nodes[index];
            // A child's entry holds its parent's transform until its own turn.
            worlds[index] *= local(node, index, poses.get(&index), &mut untold);
            for child in node.children.iter().map(|child| child.index()) {
                worlds[child] = worlds[index];
                stack.push(child);
            }
        }
        Self(worlds)
    }

    /// Node to world; `None` when there is no such node.
    pub(crate) fn of(&self, node: usize) -> Option<DAffine3> {
        self.0.get(node).copied()
    }
}

/// The parent of each node; refuses two parents, children that do not exist, and cycles.
fn parents(document: &Document) -> Result<Vec<Option<u32>>> {
    let nodes = &document.nodes;
    let mut parents: Vec<Option<u32>> = vec![None; nodes.len()];
    for (index, node) in nodes.iter().enumerate() {
        for child in &node.children {
            let place = || format!("node {index}");
            let Some(parent) = parents.get_mut(child.index()) else {
                return Err(Fault::no_such(place(), "node", child.index(), nodes.len()));
            };
            if child.index() == index {
                return Err(Fault::invalid(place(), "is its own child"));
            }
            match *parent {
                Some(other) if other as usize == index => {
                    return Err(Fault::invalid(place(), format!("names node {} twice as a child", child.index())));
                }
                Some(other) => {
                    let cause = format!("is a child of both node {other} and node {index}");
                    return Err(Fault::invalid(format!("node {}", child.index()), cause));
                }
                None => *parent = Some(index as u32),
            }
        }
    }
    // With one parent each, whatever no root reaches is on a cycle or hangs from one.
    let mut reached = vec![false; nodes.len()];
    let mut stack: Vec<usize> = (0..nodes.len()).filter(|&i| parents[i].is_none()).collect();
    while let Some(index) = stack.pop() {
        reached[index] = true;
        stack.extend(nodes[index].children.iter().map(|c| c.index()));
    }
    match reached.iter().position(|&reached| !reached) {
        Some(index) => Err(Fault::invalid(format!("node {index}"), "is below itself: the node hierarchy has a cycle")),
        None => Ok(parents),
    }
}

/// Whether a node shows, as far as it says itself.
fn is_visible(node: &Node, index: usize, warnings: &mut Warnings) -> bool {
    match node.extensions.parse::<Visibility>(VISIBILITY) {
        None => true,
        Some(Ok(json)) => json.visible,
        Some(Err(e)) => {
            warnings.push(format!("Whether node {index} is visible cannot be read ({e}); it is shown."));
            true
        }
    }
}

/// The scene that is shown: the requested one, the default one, the first; the number may name
/// none.
pub(crate) fn chosen(document: &Document, wanted: Option<usize>) -> Option<usize> {
    let first = (!document.scenes.is_empty()).then_some(0);
    wanted.or(document.scene.map(Int::index)).or(first)
}

fn roots(
    document: &Document,
    wanted: Option<usize>,
    parents: &[Option<u32>],
    warnings: &mut Warnings,
) -> Result<Vec<usize>> {
    let scenes = &document.scenes;
    let Some(chosen) = chosen(document, wanted) else {
        if !document.nodes.is_empty() {
            warnings.push("The file has no scene; all its nodes are shown.");
        }
        return Ok((0..document.nodes.len()).filter(|&i| parents[i].is_none()).collect());
    };
    if chosen >= scenes.len() {
        let place = if wanted.is_some() { "the choice of a scene" } else { "the default scene" };
        return Err(Fault::no_such(place, "scene", chosen, scenes.len()));
    }
    let place = format!("scene {chosen}");
    let mut seen = std::collections::HashSet::new();
    let mut roots = Vec::new();
    for root in scenes[chosen].nodes.iter().map(|root| root.index()) {
        match parents.get(root) {
            None => return Err(Fault::no_such(place, "node", root, document.nodes.len())),
            Some(Some(parent)) => {
                let cause = format!("has node {root} as a root, but that is a child of node {parent}");
                return Err(Fault::invalid(place, cause));
            }
            Some(None) if !seen.insert(root) => {
                return Err(Fault::invalid(place, format!("names node {root} twice")));
            }
            Some(None) => roots.push(root),
        }
    }
    Ok(roots)
}

/// A node's own transform.
fn local(node: &Node, index: usize, pose: Option<&Pose>, warnings: &mut Warnings) -> DAffine3 {
    let moved = |pose: &&Pose| pose.translation.is_some() || pose.rotation.is_some() || pose.scale.is_some();
    let pose = pose.filter(moved);
    // A node that is animated has no matrix, or should not have: the animated properties replace
    // it.
    if let (Some(m), None) = (&node.matrix, pose) {
        let m = DMat4::from_cols_array(m);
        if m.row(3) != glam::DVec4::W {
            warnings.push(format!("The matrix of node {index} is not affine; its last row is ignored."));
        }
        return DAffine3::from_mat3_translation(DMat3::from_mat4(m), m.w_axis.truncate());
    }
    let rotation = match pose.and_then(|p| p.rotation).or(node.rotation).map(DQuat::from_array) {
        None => DQuat::IDENTITY,
        Some(q) => {
            let length = q.length();
            if (length - 1.0).abs() > 1e-2 && pose.is_none() {
                warnings.push(format!("The rotation of node {index} is no unit quaternion; it is normalised."));
            }
            if length > 0.0 && length.is_finite() { q / length } else { DQuat::IDENTITY }
        }
    };
    let scale = pose.and_then(|p| p.scale).or(node.scale).map_or(DVec3::ONE, DVec3::from_array);
    let translation = pose.and_then(|p| p.translation).or(node.translation).map_or(DVec3::ZERO, DVec3::from_array);
    DAffine3::from_scale_rotation_translation(scale, rotation, translation)
}

/// The name of a node, or of its mesh, camera or light, or nothing.
pub(crate) fn name_of(node: &Node, own: Option<&String>) -> String {
    node.name.as_ref().or(own).cloned().unwrap_or_default()
}

/// Whether a placement can show anything: finite, and not shrunk to a point.
pub(crate) fn drawable(placed: &PlacedNode, warnings: &mut Warnings) -> bool {
    if !placed.to_world.is_finite() {
        warnings.push(format!("Node {} is not shown: its transform is not finite.", placed.node));
        return false;
    }
    placed.to_world.matrix3 != DMat3::ZERO
}

/// The index of a node's mesh, checked.
pub(crate) fn mesh_of(document: &Document, index: usize) -> Result<Option<usize>> {
    let Some(mesh) = document.nodes[index].mesh.map(Int::index) else {
        return Ok(None);
    };
    if mesh >= document.meshes.len() {
        return Err(Fault::no_such(format!("node {index}"), "mesh", mesh, document.meshes.len()));
    }
    Ok(Some(mesh))
}
