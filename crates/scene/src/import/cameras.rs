//! Cameras on nodes.

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DAffine3, DMat3};

use super::document::{CameraJson, Document, get};
use super::error::Result;
use super::nodes::{PlacedNode, name_of};
use super::warnings::Warnings;
use crate::{Camera, ClipRange, Projection};

/// Cameras of the placed nodes, in the order of the nodes.
pub(crate) fn read(document: &Document, placed: &[PlacedNode], warnings: &mut Warnings) -> Result<Vec<Camera>> {
    let mut cameras = Vec::new();
    for placed in placed {
        let node = &document.nodes[placed.node];
        let Some(index) = node.camera else { continue };
        let json = get(&document.cameras, index, "camera", &format!("node {}", placed.node))?;
        let place = format!("camera {}", index.index());
        let Some(to_world) = orthonormal(&placed.to_world) else {
            warnings.push(format!("The {place} of node {} is left out: its transform is singular.", placed.node));
            continue;
        };
        match projection(json, &place, warnings) {
            Some(projection) => {
                let clip = clip_range(json, &place, warnings);
                cameras.push(Camera { name: name_of(node, json.name.as_ref()), to_world, projection, clip });
            }
            None => warnings.push(format!("The {place} is left out: it is neither perspective nor orthographic.")),
        }
    }
    Ok(cameras)
}

/// Takes scale, shear and mirroring out: the view direction stays exact, up as near as it can be.
fn orthonormal(node: &DAffine3) -> Option<DAffine3> {
    let z = node.matrix3.z_axis.try_normalize()?;
    let y = (node.matrix3.y_axis - z * z.dot(node.matrix3.y_axis)).try_normalize()?;
    let to_world = DAffine3::from_mat3_translation(DMat3::from_cols(y.cross(z), y, z), node.translation);
    to_world.is_finite().then_some(to_world)
}

fn projection(json: &CameraJson, place: &str, warnings: &mut Warnings) -> Option<Projection> {
    match (json.kind.as_deref(), &json.perspective, &json.orthographic) {
        (Some("perspective") | None, Some(p), _) => {
            let mut yfov = p.yfov;
            if !(yfov > 1e-6 && yfov < PI - 1e-6) {
                warnings.push(format!("The {place} has a yfov of {yfov}; 45° are used."));
                yfov = FRAC_PI_4;
            }
            let aspect = p.aspect_ratio.filter(|&a| a > 1e-6 && a < 1e6);
            if aspect.is_none() && p.aspect_ratio.is_some() {
                warnings.push(format!("The {place} has an unusable aspect ratio; it is ignored."));
            }
            Some(Projection::Perspective { yfov, aspect })
        }
        (Some("orthographic") | None, _, Some(o)) => {
            let mut magnitude = |value: f64, name: &str| {
                let size = value.abs();
                if size > 1e-12 && size < 1e12 {
                    return size;
                }
                warnings.push(format!("The {place} has {name} {value}; 1 is used."));
                1.0
            };
            Some(Projection::Orthographic { xmag: magnitude(o.xmag, "xmag"), ymag: magnitude(o.ymag, "ymag") })
        }
        _ => None,
    }
}

/// The planes of the projection that is used. Values that no projection can have clip nothing.
fn clip_range(json: &CameraJson, place: &str, warnings: &mut Warnings) -> ClipRange {
    let is_orthographic = json.kind.as_deref() == Some("orthographic");
    let (near, far) = match (&json.perspective, &json.orthographic) {
        (Some(p), _) if !is_orthographic => (p.znear, p.zfar),
        (_, Some(o)) => (o.znear, o.zfar),
        _ => (None, None),
    };
    let (near, far) = (near.unwrap_or(0.0), far.unwrap_or(f64::INFINITY));
    ClipRange::new(near, far).unwrap_or_else(|| {
        warnings.push(format!(
            "The {place} has a znear of {near} and a zfar of {far}, which are no range of depths; nothing is clipped."
        ));
        ClipRange::NONE
    })
}
