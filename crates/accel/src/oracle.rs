//! Brute force in f64 over a scene, for tests: shares no code with the trees and their items.
//!
//! Two answers to the same ray can both be right when it grazes an edge or hits two surfaces at
//! almost the same distance. [`Oracle::judge`] therefore compares an answer with an error band:
//! right, wrong or undecided.

use glam::{DVec3, Vec3};
use surelight_scene::Scene;

use crate::{Accel, Hit, NO_INSTANCE, Ray};

/// Every placed triangle of a scene, in f64 camera space.
pub struct Oracle {
    triangles: Vec<PlacedTriangle>,
}

struct PlacedTriangle {
    corners: [DVec3; 3],
    instance: u32,
    mesh: u32,
    /// Vertex indices as the mesh has them.
    vertices: [u32; 3],
}

/// The intersection of a ray with the plane of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance in multiples of the direction.
    pub t: f64,
    /// Barycentric weights of the second and third corner, in the mesh's order.
    pub b: [f64; 2],
    /// Index into [`Scene::instances`].
    pub instance: u32,
    /// Index into [`Scene::meshes`].
    pub mesh: u32,
    /// Vertex indices, in the mesh's order.
    pub vertices: [u32; 3],
    /// By how much `t` may be off when the triangle is tested in f32.
    pub t_band: f64,
    /// Smallest barycentric weight over its possible error in f32: above 1 surely inside, below −1
    /// surely outside.
    pub inside: f64,
}

/// The verdict on an answer.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The same triangle as in f64, or none both times.
    Same,
    /// Another answer, but within the error band: a grazed edge or two surfaces at almost one
    /// distance.
    Tie,
    /// Wrong, with the reason.
    Wrong(String),
}

impl Oracle {
    /// Places every triangle whose corners are finite, relative to `origin`.
    pub fn new(scene: &Scene, origin: DVec3) -> Self {
        let mut triangles = Vec::new();
        for (i, instance) in scene.instances.iter().enumerate() {
            let mesh = &scene.meshes[instance.mesh];
            for &vertices in &mesh.triangles {
                let corners = vertices
                    .map(|v| instance.to_world.transform_point3(mesh.positions[v as usize].as_dvec3()) - origin);
                if corners.iter().all(|c| c.is_finite()) {
                    triangles.push(PlacedTriangle {
                        corners,
                        instance: i as u32,
                        mesh: instance.mesh as u32,
                        vertices,
                    });
                }
            }
        }
        Self { triangles }
    }

    /// Triangles that are tested.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Each crossing with a plane that comes within the error band of its triangle, unsorted.
    pub fn crossings(&self, ray: &Ray) -> Vec<Crossing> {
        self.triangles.iter().filter_map(|t| t.cross(ray)).filter(|c| c.inside >= -1.0).collect()
    }

    /// The nearest hit in f64 with `t_min` < t < `t_max`.
    pub fn intersect(&self, ray: &Ray) -> Option<Crossing> {
        let within = |c: &Crossing| c.t > f64::from(ray.t_min) && c.t < f64::from(ray.t_max) && c.inside >= 0.0;
        self.crossings(ray).into_iter().filter(within).min_by(|a, b| a.t.total_cmp(&b.t))
    }

    /// Compares the answer of a traversal with f64.
    pub fn judge(&self, accel: &Accel, ray: &Ray, answer: Option<&Hit>) -> Verdict {
        let crossings = self.crossings(ray);
        let (t_min, t_max) = (f64::from(ray.t_min), f64::from(ray.t_max));
        let sure = |c: &&Crossing| c.inside > 1.0 && c.t > t_min + c.t_band && c.t < t_max - c.t_band;
        let nearest = self.intersect(ray);
        let Some(hit) = answer else {
            return match (crossings.iter().find(sure), nearest) {
                (Some(c), _) => Verdict::Wrong(format!("nothing found, but {c:?}")),
                (None, Some(_)) => Verdict::Tie,
                (None, None) => Verdict::Same,
            };
        };
        let source = accel.triangles[hit.prim as usize];
        let instance = match hit.instance {
            NO_INSTANCE => source.instance,
            k => accel.instances[k as usize].scene_instance,
        };
        let named = |c: &&Crossing| {
            let mut given = c.vertices;
            let mut found = source.corners;
            given.sort_unstable();
            found.sort_unstable();
            c.instance == instance && c.mesh == source.mesh && given == found
        };
        let t = f64::from(hit.t);
        // A mesh may hold a triangle twice: either copy is right.
        let Some(claimed) = crossings.iter().filter(named).min_by(|a, b| (a.t - t).abs().total_cmp(&(b.t - t).abs()))
        else {
            return Verdict::Wrong(format!("{hit:?} lies outside its triangle"));
        };
        if (claimed.t - t).abs() > claimed.t_band {
            return Verdict::Wrong(format!("{hit:?} is too far from {claimed:?}"));
        }
        if let Some(c) = crossings.iter().filter(sure).find(|c| c.t + c.t_band < t - claimed.t_band) {
            return Verdict::Wrong(format!("{hit:?} is behind {c:?}"));
        }
        match nearest {
            Some(c) if c == *claimed => Verdict::Same,
            _ => Verdict::Tie,
        }
    }
}

impl PlacedTriangle {
    fn cross(&self, ray: &Ray) -> Option<Crossing> {
        let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let [v0, v1, v2] = self.corners;
        let (e1, e2) = (v1 - v0, v2 - v0);
        let n = e1.cross(e2);
        let area = n.length();
        let cosine = d.dot(n);
        if area == 0.0 || cosine == 0.0 {
            return None;
        }
        let t = (v0 - o).dot(n) / cosine;
        if !t.is_finite() {
            return None;
        }
        // Weights as ratios of areas around the crossing; no part of Möller and Trumbore's order of
        // operations.
        let p = o + d * t;
        let b1 = (p - v0).cross(e2).dot(n) / (area * area);
        let b2 = e1.cross(p - v0).dot(n) / (area * area);
        let least = b1.min(b2).min(1.0 - b1 - b2);

        // In f32 each coordinate of the corners and of the ray is off by some u of its size; the
        // test multiplies that by how slanted the ray is and by how thin the triangle is.
        let u = 1.0 / (1 << 24) as f64;
        let size = |v: DVec3| v.abs().max_element();
        let reach = size(o) + size(d) * t.abs() + size(v0).max(size(v1)).max(size(v2));
        let slant = d.length() * area / cosine.abs();
        let (a, b) = (e1.length(), e2.length());
        let thin = a * b / area;
        let off = 64.0 * u * reach * slant;
        let t_band = off * thin / d.length();
        // Heights over the three edges turn a distance into a weight.
        let height = area / a.max(b).max((v2 - v1).length());
        Some(Crossing {
            t,
            b: [b1, b2],
            instance: self.instance,
            mesh: self.mesh,
            vertices: self.vertices,
            t_band,
            inside: least / (off * thin / height + 8.0 * u),
        })
    }
}

/// A ray of camera space that is exact in f32: where tests start from.
pub fn ray_towards(origin: Vec3, target: Vec3) -> Ray {
    Ray::new(origin, target - origin)
}
