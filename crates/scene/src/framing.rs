//! The bounds of a scene, and a camera that shows all of it.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use crate::{Camera, ClipRange, Mesh, Projection, Scene};

/// Full vertical field of view of the camera that frames a scene, radians.
const YFOV: f64 = 0.7;

/// With more placed vertices than this, boxes of meshes are transformed in place of vertices.
const MAX_VERTICES: usize = 50_000_000;

/// Corners beyond this are treated as not finite: a frame around them would overflow.
const FARTHEST: f64 = 1e100;

impl Scene {
    /// The box around all placed triangles, lower and upper corner; `None` when no corner of one is
    /// finite.
    ///
    /// Corners that are not finite are left out. The box is exact up to 50 million placed vertices,
    /// and beyond that holds the boxes of the placed meshes.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let points: Vec<Vec<DVec3>> = self.meshes.par_iter().map(corners_of).collect();
        let placed: usize = self.instances.iter().map(|i| points[i.mesh].len()).fold(0, usize::saturating_add);
        let points = if placed <= MAX_VERTICES {
            points
        } else {
            points.into_iter().map(|p| bounds(p.into_iter()).map_or(Vec::new(), box_corners)).collect()
        };
        let boxes: Vec<_> = self
            .instances
            .par_iter()
            .filter_map(|i| bounds(points[i.mesh].iter().map(|&p| i.to_world.transform_point3(p))))
            .collect();
        bounds(boxes.into_iter().flat_map(|(low, high)| [low, high]))
    }

    /// A camera that shows the whole model from the front (+Z), a little from the right and from
    /// above, for an image of this width over height. An empty scene gets a view of the unit cube
    /// around the origin.
    pub fn frame_camera(&self, aspect: f64) -> Camera {
        let aspect = if aspect.is_finite() && aspect > 0.0 { aspect } else { 1.0 };
        let (low, high) = self.bounds().unwrap_or((DVec3::splat(-0.5), DVec3::splat(0.5)));
        let center = low + (high - low) * 0.5;
        let backward = DVec3::new(0.45, 0.35, 1.0).normalize();
        let right = DVec3::Y.cross(backward).normalize();
        let up = backward.cross(right);

        // Each corner of the box must lie inside the four planes of the view; the farthest demand
        // wins.
        let slope_y = (YFOV * 0.5).tan();
        let slope_x = slope_y * aspect;
        let distance = box_corners((low, high))
            .into_iter()
            .map(|corner| {
                let p = corner - center;
                p.dot(backward) + (p.dot(right).abs() / slope_x).max(p.dot(up).abs() / slope_y)
            })
            .fold(0.0, f64::max);
        // A margin around, and a finite extent when the scene is a point.
        let distance = if distance > 0.0 { distance * 1.05 } else { 1.0 };
        Camera {
            name: String::new(),
            to_world: DAffine3::from_mat3_translation(
                DMat3::from_cols(right, up, backward),
                center + backward * distance,
            ),
            projection: Projection::Perspective { yfov: YFOV, aspect: None },
            clip: ClipRange::NONE,
        }
    }
}

/// Vertices that a triangle uses.
fn corners_of(mesh: &Mesh) -> Vec<DVec3> {
    let mut used = vec![false; mesh.positions.len()];
    for &index in mesh.triangles.iter().flatten() {
        used[index as usize] = true;
    }
    mesh.positions.iter().zip(used).filter(|(_, used)| *used).map(|(p, _)| p.as_dvec3()).collect()
}

fn bounds(points: impl Iterator<Item = DVec3>) -> Option<(DVec3, DVec3)> {
    points.filter(|p| p.abs().cmplt(DVec3::splat(FARTHEST)).all()).fold(None, |sum, p| match sum {
        None => Some((p, p)),
        Some((low, high)) => Some((low.min(p), high.max(p))),
    })
}

fn box_corners((low, high): (DVec3, DVec3)) -> Vec<DVec3> {
    (0..8)
        .map(|i| {
            let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
        })
        .collect()
}
