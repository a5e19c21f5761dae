//! EXT_mesh_gpu_instancing: a node's mesh, placed many times.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use serde::Deserialize;

use super::accessor::{Accessors, Component, Typed};
use super::document::Int;
use super::error::{Fault, Result};

pub(crate) const NAME: &str = "EXT_mesh_gpu_instancing";

#[derive(Deserialize)]
struct Json {
    #[serde(default)]
    attributes: BTreeMap<String, Int>,
}

/// Instance to node, one for each instance, in order; `None` when the node has no such extension.
/// More than `most` are refused before any is read. Attributes with other names (application data)
/// are ignored.
pub(crate) fn transforms(accessors: &Accessors, node: usize, most: usize) -> Result<Option<Vec<DAffine3>>> {
    let place = format!("node {node}");
    let Some(parsed) = accessors.document.nodes[node].extensions.parse::<Json>(NAME) else {
        return Ok(None);
    };
    let json = parsed.map_err(|e| Fault::invalid(&place, format!("has a broken {NAME}: {e}")))?;
    let mut count = None;
    let mut typed = [None; 3];
    for (slot, name) in typed.iter_mut().zip(["TRANSLATION", "ROTATION", "SCALE"]) {
        let Some(&index) = json.attributes.get(name) else { continue };
        let of = accessors.typed(index, &format!("{name} of the instances of {place}"))?;
        if let Some(count) = count
            && count != of.count
        {
            let cause = format!("has instances with {count} and {} elements", of.count);
            return Err(Fault::invalid(place, cause));
        }
        count = Some(of.count);
        *slot = Some(of);
    }
    let Some(count) = count else {
        return Err(Fault::invalid(place, format!("has {NAME} without TRANSLATION, ROTATION or SCALE")));
    };
    if count > most {
        return Err(Fault::too_large(place, format!("has {count} instances, and {most} more meshes can be placed")));
    }
    let translations = read(accessors, typed[0], &place, DVec3::ZERO, count, |v| DVec3::from(v.map(f64::from)))?;
    let rotations = read(accessors, typed[1], &place, DQuat::IDENTITY, count, |q| {
        let q = DQuat::from_array(q.map(f64::from));
        // Rounded to bytes or shorts, a unit quaternion is none any more.
        if q.is_finite() && q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY }
    })?;
    let scales = read(accessors, typed[2], &place, DVec3::ONE, count, |v| DVec3::from(v.map(f64::from)))?;
    Ok(Some(
        (0..count)
            .map(|i| DAffine3::from_scale_rotation_translation(scales[i], rotations[i], translations[i]))
            .collect(),
    ))
}

/// An attribute, or its default for all instances.
fn read<const N: usize, T: Copy>(
    accessors: &Accessors,
    of: Option<Typed>,
    place: &str,
    default: T,
    count: usize,
    convert: impl Fn([f32; N]) -> T,
) -> Result<Vec<T>> {
    let Some(of) = of else { return Ok(vec![default; count]) };
    let fraction = N == 4 && of.normalized && matches!(of.component, Component::I8 | Component::I16);
    if of.component != Component::F32 && !fraction {
        return Err(Fault::invalid(
            place,
            "has instances whose attributes are neither floats nor normalised rotations",
        ));
    }
    Ok(accessors.floats(&of, None).map_err(|f| f.used_by(place))?.into_iter().map(convert).collect())
}
