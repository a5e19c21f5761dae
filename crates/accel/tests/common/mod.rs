//! Scenes and rays for the tests, from fixed seeds.
#![allow(dead_code)] // each test file uses some of it

use glam::{DAffine3, DQuat, DVec3, EulerRot, Vec3};
use surelight_accel::{Accel, BuildOptions, Ray, oracle::Oracle, oracle::Verdict};
use surelight_scene::{Instance, Material, Mesh, Scene};

/// A small generator, so that seeds always mean the same (PCG-XSH-RR; O'Neill 2014).
pub(crate) struct Rng(u64);

impl Rng {
    pub(crate) fn new(seed: u64) -> Self {
        let mut rng = Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        rng.bits();
        rng
    }

    pub(crate) fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((((old >> 18) ^ old) >> 27) as u32).rotate_right((old >> 59) as u32)
    }

    /// In [0, 1).
    pub(crate) fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 / (1 << 24) as f32
    }

    pub(crate) fn index(&mut self, n: usize) -> usize {
        ((self.bits() as u64 * n as u64) >> 32) as usize
    }

    /// In [−1, 1)³.
    pub(crate) fn cube(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }

    pub(crate) fn turn(&mut self) -> DQuat {
        let a = self.cube().as_dvec3() * std::f64::consts::PI;
        DQuat::from_euler(EulerRot::XYZ, a.x, a.y, a.z)
    }
}

/// `n` triangles of about `size` with separate corners, in [−1, 1]³.
pub(crate) fn soup(rng: &mut Rng, n: usize, size: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..n as u32 {
        let c = rng.cube();
        mesh.positions.extend([c + rng.cube() * size, c + rng.cube() * size, c + rng.cube() * size]);
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh
}

/// A closed sphere of radius 1 about 0, counter-clockwise from outside.
pub(crate) fn sphere(rings: u32, sectors: u32) -> Mesh {
    let mut mesh = Mesh::default();
    mesh.positions.push(Vec3::Y);
    for r in 1..rings {
        let polar = std::f64::consts::PI * r as f64 / rings as f64;
        for s in 0..sectors {
            let around = std::f64::consts::TAU * s as f64 / sectors as f64;
            let p = DVec3::new(polar.sin() * around.sin(), polar.cos(), polar.sin() * around.cos());
            mesh.positions.push(p.as_vec3());
        }
    }
    mesh.positions.push(-Vec3::Y);
    let at = |r: u32, s: u32| 1 + (r - 1) * sectors + s % sectors;
    let last = mesh.positions.len() as u32 - 1;
    for s in 0..sectors {
        mesh.triangles.push([0, at(1, s), at(1, s + 1)]);
        for r in 1..rings - 1 {
            mesh.triangles.push([at(r, s), at(r + 1, s), at(r + 1, s + 1)]);
            mesh.triangles.push([at(r, s), at(r + 1, s + 1), at(r, s + 1)]);
        }
        mesh.triangles.push([at(rings - 1, s), last, at(rings - 1, s + 1)]);
    }
    mesh
}

pub(crate) fn scene(meshes: Vec<Mesh>, placements: &[(usize, DAffine3)]) -> Scene {
    Scene {
        instances: placements.iter().map(|&(mesh, to_world)| Instance { mesh, to_world }).collect(),
        meshes,
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

/// One mesh where it is.
pub(crate) fn lone(mesh: Mesh) -> Scene {
    scene(vec![mesh], &[(0, DAffine3::IDENTITY)])
}

pub(crate) fn build(scene: &Scene, options: &BuildOptions) -> Accel {
    Accel::build(scene, DVec3::ZERO, options).expect("the scene can be built")
}

/// Rays between random points of the box of half-width `reach` around `center`.
pub(crate) fn rays(rng: &mut Rng, n: usize, center: Vec3, reach: f32) -> Vec<Ray> {
    (0..n)
        .map(|_| {
            let (a, b) = (center + rng.cube() * reach, center + rng.cube() * reach);
            Ray::new(a, (b - a).normalize())
        })
        .collect()
}

/// How the answers of a traversal compare with f64.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) hits: usize,
    pub(crate) same: usize,
    pub(crate) ties: usize,
}

/// Panics at the first wrong answer; checks `occluded` too.
pub(crate) fn hold_against(oracle: &Oracle, accel: &Accel, rays: &[Ray]) -> Tally {
    let mut tally = Tally::default();
    for ray in rays {
        let hit = accel.intersect(ray);
        match oracle.judge(accel, ray, hit.as_ref()) {
            Verdict::Same => tally.same += 1,
            Verdict::Tie => tally.ties += 1,
            Verdict::Wrong(why) => panic!("{ray:?}: {why}"),
        }
        tally.hits += usize::from(hit.is_some());
        assert_eq!(hit.is_some(), accel.occluded(ray), "occlusion differs: {ray:?}");
    }
    tally
}
