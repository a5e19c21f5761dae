//! The traversal probe: rays in, hits of the shipped traversal on the device out.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, Vec3};
use surelight_accel::{BuildOptions, Hit, NO_INSTANCE, Ray, oracle::Oracle, oracle::Verdict};
use surelight_prepare::{Prepared, Settings};
use surelight_render::run_probe;
use surelight_scene::{Camera, ClipRange, Instance, Mesh, Projection, Scene};

use crate::render::device;

/// Farther than anything.
pub const FAR: f32 = 3.0e38;

/// `ProbeRays` of shaders/probe/traversal.wesl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ProbeRays {
    /// Of the shadow ray.
    pub shadow_origin: [f32; 3],
    /// Its end; 0 for no shadow ray.
    pub shadow_t_max: f32,
    /// Its direction.
    pub shadow_direction: [f32; 3],
    /// The random number for partial coverage.
    pub coverage_seed: u32,
    /// Of the closest-hit ray.
    pub origin: [f32; 3],
    /// Its end; 0 for no ray.
    pub t_max: f32,
    /// Its direction.
    pub direction: [f32; 3],
    unused: u32,
}

impl ProbeRays {
    /// No shadow ray, and the closest hit of a ray without end.
    pub fn closest(ray: &Ray) -> Self {
        Self { origin: ray.origin.to_array(), direction: ray.direction.to_array(), t_max: FAR, ..Self::zeroed() }
    }

    /// With a shadow ray up to `t_max` before it.
    #[must_use]
    pub fn with_shadow(self, ray: &Ray, t_max: f32) -> Self {
        Self {
            shadow_origin: ray.origin.to_array(),
            shadow_direction: ray.direction.to_array(),
            shadow_t_max: t_max,
            ..self
        }
    }
}

/// `ProbeHit` of shaders/probe/traversal.wesl.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ProbeHit {
    /// Distance in lengths of the direction.
    pub t: f32,
    b1: f32,
    b2: f32,
    item: u32,
    prim: u32,
    instance: u32,
    occluded: u32,
    complete: u32,
}

impl ProbeHit {
    /// The closest hit.
    pub fn hit(&self) -> Option<Hit> {
        let Self { t, b1, b2, prim, instance, item, .. } = *self;
        (prim != u32::MAX).then_some(Hit { t, b1, b2, prim, instance, item })
    }

    /// Whether the traversal ended.
    pub fn is_complete(&self) -> bool {
        self.complete == 1
    }

    /// Whether anything occludes the shadow ray.
    pub fn occluded(&self) -> bool {
        self.occluded != 0
    }
}

/// A scene of placed meshes, in one material, prepared for a camera at the origin.
pub fn prepare(meshes: Vec<Mesh>, placements: &[(usize, DAffine3)], build: BuildOptions) -> (Scene, Prepared) {
    let scene = Scene {
        meshes,
        instances: placements.iter().map(|&(mesh, to_world)| Instance { mesh, to_world }).collect(),
        materials: vec![crate::scenes::lambert([0.5; 3])],
        ..Scene::default()
    };
    let projection = Projection::Perspective { yfov: 1.0, aspect: None };
    let camera = Camera { name: String::new(), to_world: DAffine3::IDENTITY, projection, clip: ClipRange::NONE };
    let settings = Settings { build, ..Settings::new(8, 8) };
    let prepared = Prepared::new(&scene, &camera, &settings).unwrap_or_else(|e| panic!("{e}"));
    (scene, prepared)
}

/// One mesh where it is.
pub fn lone(mesh: Mesh, build: BuildOptions) -> (Scene, Prepared) {
    prepare(vec![mesh], &[(0, DAffine3::IDENTITY)], build)
}

/// Traverses on the device; some rays may have been cut short.
pub fn try_traverse(prepared: &Prepared, rays: &[ProbeRays]) -> Vec<ProbeHit> {
    run_probe(device(), prepared, "package::probe::traversal", "probe_traversal", rays, rays.len())
        .unwrap_or_else(|e| panic!("{e}"))
}

/// Traverses on the device. Every traversal must end.
pub fn traverse(prepared: &Prepared, rays: &[ProbeRays]) -> Vec<ProbeHit> {
    let found = try_traverse(prepared, rays);
    assert!(found.iter().all(ProbeHit::is_complete), "a traversal was cut short");
    found
}

/// How the device's answers compare with f64.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    /// Rays that hit something.
    pub hits: usize,
    /// Answers that differ within the error band.
    pub ties: usize,
}

/// Holds every answer against brute force in f64; a shadow ray along each must say the same as the
/// closest hit.
pub fn compare_with_oracle(name: &str, scene: &Scene, prepared: &Prepared, rays: &[Ray]) -> Tally {
    let oracle = Oracle::new(scene, DVec3::ZERO);
    let queries: Vec<_> = rays.iter().map(|ray| ProbeRays::closest(ray).with_shadow(ray, FAR)).collect();
    let mut tally = Tally::default();
    for (ray, found) in rays.iter().zip(traverse(prepared, &queries)) {
        let hit = found.hit();
        match oracle.judge(&prepared.accel, ray, hit.as_ref()) {
            Verdict::Same => (),
            Verdict::Tie => tally.ties += 1,
            Verdict::Wrong(why) => panic!("{name}: {ray:?}: {why}"),
        }
        assert_eq!(hit.is_some(), found.occluded(), "{name}: a shadow ray disagrees: {ray:?} {found:?}");
        tally.hits += usize::from(hit.is_some());
    }
    println!("{name}: {} rays, {tally:?}", rays.len());
    tally
}

/// Whether a hit is on a mesh placed as an instance.
pub fn on_instance(hit: &Hit) -> bool {
    hit.instance != NO_INSTANCE
}

/// A point of a triangle of a mesh.
pub fn point_of(mesh: &Mesh, triangle: usize, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = mesh.triangles[triangle].map(|i| mesh.positions[i as usize]);
    a + (b - a) * u + (c - a) * v
}
