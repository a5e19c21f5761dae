//! The surface where a ray of the host hits the scene.

use glam::{DAffine3, DMat3, DVec3};
use surelight_accel::{Accel, Hit, NO_INSTANCE};
use surelight_scene::{Material, Mesh, Scene};

/// A triangle's material and normals at a point.
pub(super) struct Surface<'a> {
    pub(super) material_index: usize,
    pub(super) material: &'a Material,
    /// Normal of the front; its length is twice the triangle's area.
    pub(super) front: DVec3,
    mesh: &'a Mesh,
    corners: [usize; 3],
    to_world: DAffine3,
    barycentrics: [f64; 2],
}

impl<'a> Surface<'a> {
    /// The surface at a hit.
    pub(super) fn at(scene: &'a Scene, accel: &Accel, hit: &Hit) -> Self {
        let source = &accel.triangles[hit.prim as usize];
        let instance = if hit.instance == NO_INSTANCE {
            source.instance
        } else {
            accel.instances[hit.instance as usize].scene_instance
        };
        let to_world = scene.instances[instance as usize].to_world;
        let mesh = &scene.meshes[source.mesh as usize];
        let corners = source.corners.map(|i| i as usize);
        let [a, b, c] = corners.map(|i| to_world.transform_point3(mesh.positions[i].as_dvec3()));
        // Corners of copies are in the order of the world already.
        let mirrored = source.instance == NO_INSTANCE && to_world.matrix3.determinant() < 0.0;
        Self {
            material_index: mesh.material,
            material: &scene.materials[mesh.material],
            front: (b - a).cross(c - a) * if mirrored { -1.0 } else { 1.0 },
            mesh,
            corners,
            to_world,
            barycentrics: [hit.b1, hit.b2].map(f64::from),
        }
    }

    /// The interpolated normal of the front, a unit vector; `None` where the mesh has none.
    pub(super) fn shading_normal(&self) -> Option<DVec3> {
        let normals = self.mesh.normals.as_ref()?;
        let normal_matrix: DMat3 = self.to_world.matrix3.inverse().transpose();
        let [b1, b2] = self.barycentrics;
        let [a, b, c] = self.corners.map(|i| normals[i].as_dvec3());
        (normal_matrix * (a * (1.0 - b1 - b2) + b * b1 + c * b2)).try_normalize()
    }
}
