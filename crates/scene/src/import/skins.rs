//! Skins: joint transforms, and their effect on a vertex.

use glam::{DAffine3, DMat3, DMat4, DVec3, Vec3, Vec4};
use serde::Deserialize;

use super::accessor::{Accessors, Component};
use super::document::{Document, Int, get, parse_raw};
use super::error::{Fault, Result};
use super::nodes::WorldTransforms;
use super::warnings::Warnings;
use crate::Mesh;

/// A skin of the JSON.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SkinJson {
    inverse_bind_matrices: Option<Int>,
    joints: Vec<Int>,
}

/// A skin with the world transforms of its joints.
#[derive(Debug)]
pub(crate) struct Skin {
    /// Bind space to world, less `anchor`: one per joint.
    joints: Vec<DAffine3>,
    /// Where the skin is. Vertices are stored as f32 relative to it, so that a figure far from the
    /// origin keeps its shape.
    pub(crate) anchor: DVec3,
}

/// The file's skins.
pub(crate) fn read(document: &Document) -> Result<Vec<SkinJson>> {
    match document.skins.as_deref().map(parse_raw) {
        None => Ok(Vec::new()),
        Some(Ok(skins)) => Ok(skins),
        Some(Err(e)) => Err(Fault::invalid("skins in its JSON", format!("cannot be read: {e}"))),
    }
}

/// Poses skin `index` for the object `user`.
pub(crate) fn pose(
    accessors: &Accessors,
    skins: &[SkinJson],
    index: usize,
    worlds: &WorldTransforms,
    user: &str,
    warnings: &mut Warnings,
) -> Result<Skin> {
    let json = get(skins, Int(index as u64), "skin", user)?;
    let place = format!("skin {index}");
    let mut at = Vec::with_capacity(json.joints.len());
    for joint in &json.joints {
        let world = worlds.of(joint.index());
        at.push(world.ok_or_else(|| Fault::no_such(&place, "node", joint.index(), accessors.document.nodes.len()))?);
    }
    if at.is_empty() {
        return Err(Fault::invalid(place, "has no joints"));
    }
    let mut inverse = vec![DAffine3::IDENTITY; at.len()];
    if let Some(matrices) = json.inverse_bind_matrices {
        let of = accessors.any(matrices, &format!("inverseBindMatrices of {place}"))?;
        if of.width != 16 || of.component != Component::F32 || of.count < at.len() {
            let cause = format!("has inverseBindMatrices that are not {} MAT4 of floats", at.len());
            return Err(Fault::invalid(place, cause));
        }
        let pick: Vec<u32> = (0..at.len() as u32).collect();
        let read = accessors.floats::<16>(&of, Some(&pick)).map_err(|f| f.used_by(&place))?;
        for (inverse, m) in inverse.iter_mut().zip(read) {
            let m = DMat4::from_cols_array(&m.map(f64::from));
            *inverse = DAffine3::from_mat3_translation(DMat3::from_mat4(m), m.w_axis.truncate());
        }
    }
    let anchor = at.iter().map(|joint| joint.translation).find(|t| t.is_finite()).unwrap_or(DVec3::ZERO);
    let mut joints: Vec<DAffine3> = at
        .into_iter()
        .zip(inverse)
        .map(|(joint, inverse)| DAffine3::from_translation(-anchor) * joint * inverse)
        .collect();
    for (joint, number) in joints.iter_mut().zip(&json.joints) {
        if !joint.is_finite() {
            warnings.push(format!("Joint {} of {place} has a transform that is not finite; it is left out.", number.0));
            *joint = DAffine3::IDENTITY;
        }
    }
    Ok(Skin { joints, anchor })
}

/// The joints that move a vertex, and their weights: up to four per set.
#[derive(Debug)]
pub(crate) struct Influences {
    pub(crate) joints: Vec<[f32; 4]>,
    pub(crate) weights: Vec<[f32; 4]>,
}

impl Skin {
    /// Moves a mesh. Fails when a vertex names a joint that the skin lacks.
    pub(crate) fn apply(
        &self,
        mesh: &mut Mesh,
        sets: &[Influences],
        place: &str,
        warnings: &mut Warnings,
    ) -> Result<()> {
        let mut unheld = 0_usize;
        for vertex in 0..mesh.positions.len() {
            let mut sum = 0.0_f64;
            let mut blend = DAffine3::from_mat3_translation(DMat3::ZERO, DVec3::ZERO);
            for set in sets {
                for (&joint, &weight) in set.joints[vertex].iter().zip(&set.weights[vertex]) {
                    // NaN is not above anything.
                    if !(weight > 0.0 && weight.is_finite()) {
                        continue;
                    }
                    let Some(matrix) = self.joints.get(joint as usize) else {
                        let cause =
                            format!("has a vertex held by joint {joint}, but its skin has {}", self.joints.len());
                        return Err(Fault::invalid(place, cause));
                    };
                    let weight = f64::from(weight);
                    sum += weight;
                    blend.matrix3 += matrix.matrix3 * weight;
                    blend.translation += matrix.translation * weight;
                }
            }
            if sum == 0.0 {
                unheld += 1;
                blend = self.joints[0];
                sum = 1.0;
            }
            // Weights that do not sum to 1 are common: rounded to bytes, or cut to four.
            let blend = DAffine3::from_mat3_translation(blend.matrix3 * (1.0 / sum), blend.translation / sum);
            mesh.positions[vertex] = blend.transform_point3(mesh.positions[vertex].as_dvec3()).as_vec3();
            if let Some(normals) = &mut mesh.normals {
                normals[vertex] = turn_normal(&blend.matrix3, normals[vertex]);
            }
            if let Some(tangents) = &mut mesh.tangents {
                let moved = blend.matrix3 * tangents[vertex].truncate().as_dvec3();
                let sign = if blend.matrix3.determinant() < 0.0 { -tangents[vertex].w } else { tangents[vertex].w };
                tangents[vertex] = direction(moved, tangents[vertex].truncate()).extend(sign);
            }
        }
        if unheld > 0 {
            let vertices = super::warnings::count_of(unheld, "vertex");
            warnings.push(format!("{vertices} of {place} held by no joint; the first joint moves them."));
        }
        Ok(())
    }
}

/// A normal under a linear map: by the matrix of cofactors, which exists for flattening maps too.
fn turn_normal(m: &DMat3, normal: Vec3) -> Vec3 {
    let n = normal.as_dvec3();
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis];
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    direction((y.cross(z) * n.x + z.cross(x) * n.y + x.cross(y) * n.z) * sign, normal)
}

fn direction(v: DVec3, otherwise: Vec3) -> Vec3 {
    if v.is_finite() { v.try_normalize().map_or(otherwise, |v| v.as_vec3()) } else { otherwise }
}

/// Adds the morph targets' differences, times their weights.
pub(crate) fn morph(base: &mut [Vec3], differences: &[[f32; 3]], weight: f32) {
    for (base, &difference) in base.iter_mut().zip(differences) {
        *base += Vec3::from(difference) * weight;
    }
}

/// The same for tangents, whose signs stay.
pub(crate) fn morph_tangents(base: &mut [Vec4], differences: &[[f32; 3]], weight: f32) {
    for (base, &difference) in base.iter_mut().zip(differences) {
        *base += (Vec3::from(difference) * weight).extend(0.0);
    }
}
