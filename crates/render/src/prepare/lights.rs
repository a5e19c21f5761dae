//! Everything that light sampling can choose from, and with which probability.
//!
//! An alias table over all lights; where there are many emissive triangles they are one entry of it, and a tree
//! chooses among them by where light is asked for.

use std::{collections::HashMap, f64::consts::PI};

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec2};
use surelight_accel::Accel;
use surelight_scene::{LightKind, Material, Mesh, Scene};

use super::{
    Integrator,
    alias::alias_table,
    blueprint::placed_triangles,
    light_tree::{LightTree, TreeLight},
    luminance,
    textures::lookup_linear_rgb,
};

/// Twin of `LightEntry` in `shaders/light/light.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct LightEntry {
    pub(crate) threshold: f32,
    pub(crate) alias_entry: u32,
    pub(crate) probability: f32,
    pub(crate) light: u32,
}

/// Twin of `AreaLight` in `shaders/light/area.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct AreaLight {
    pub(crate) v0: [f32; 3],
    pub(crate) prim: u32,
    pub(crate) e1: [f32; 3],
    pub(crate) material: u32,
    pub(crate) e2: [f32; 3],
    pub(crate) weight: f32,
}

/// Twin of `PunctualLight` in `shaders/light/punctual.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct PunctualLight {
    pub(crate) position: [f32; 3],
    pub(crate) kind: u32,
    pub(crate) intensity: [f32; 3],
    pub(crate) angle_scale: f32,
    pub(crate) direction: [f32; 3],
    pub(crate) angle_offset: f32,
}

pub(super) const KIND_PUNCTUAL: u32 = 1 << 30;
pub(super) const KIND_ENVIRONMENT: u32 = 2 << 30;

/// Fewer emissive triangles than these are chosen by the alias table.
const LEAST_FOR_TREE: usize = 3;

/// Stands for no light.
const NONE: u32 = u32::MAX;

/// The lights of a scene, each with its power as weight.
#[derive(Default)]
pub(crate) struct Lights {
    pub(crate) table: Vec<LightEntry>,
    pub(crate) area: Vec<AreaLight>,
    pub(crate) punctual: Vec<PunctualLight>,
    /// Over the emissive triangles, where they are many.
    pub(crate) tree: Option<LightTree>,
    /// By prim: an emitting triangle's weight per area (0 for all others); empty when nothing emits.
    triangle_weights: Vec<f32>,
    /// By prim: its number among `area`, which for triangles of instanced meshes counts from the instance's first.
    triangle_lights: Vec<u32>,
    /// By instance of the BVH: its first light.
    pub(crate) instance_lights: Vec<u32>,
    /// Without a tree, a triangle's weight times this is its area pdf. With one, the probability that a triangle is chosen at all.
    pub(crate) density: f32,
    pub(crate) environment_probability: f32,
}

/// Which kinds of lights a scene has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightKinds {
    pub(crate) any: bool,
    pub(crate) area: bool,
    pub(crate) tree: bool,
    pub(crate) punctual: bool,
}

impl LightKinds {
    /// As far as it can be seen without looking at triangles. `sky`: whether an environment map is sampled.
    pub(crate) fn expected(scene: &Scene, integrator: Integrator, sky: bool) -> Self {
        if matches!(integrator, Integrator::Hemisphere(_)) {
            return Self { any: false, area: false, tree: false, punctual: false };
        }
        let [_, emissive] = placed_triangles(scene);
        let area = emissive > 0;
        let punctual = scene.lights.iter().any(|light| punctual(light, DVec3::ZERO, 1.0).1 > 0.0);
        let tree = emissive >= LEAST_FOR_TREE as u64 && integrator != Integrator::Whitted;
        Self { any: area || punctual || sky, area, tree, punctual }
    }
}

impl Lights {
    pub(crate) fn kinds(&self) -> LightKinds {
        LightKinds {
            any: !self.table.is_empty(),
            area: !self.area.is_empty(),
            tree: self.tree.is_some(),
            punctual: !self.punctual.is_empty(),
        }
    }

    /// `environment`: ∫ luminance dω of the environment map, when there is one.
    pub(crate) fn new(scene: &Scene, accel: &Accel, integrator: Integrator, environment: Option<f64>) -> Self {
        let mut lights = Self::default();
        if matches!(integrator, Integrator::Hemisphere(_)) {
            return lights;
        }
        let mut powers = Vec::new();
        let mut which = Vec::new();
        lights.add_triangles(scene, accel, &mut powers);
        // Whitted sends its shadow rays to the middles of triangles: few, or it is of no use.
        if powers.len() >= LEAST_FOR_TREE && integrator != Integrator::Whitted {
            lights.tree = lights.tree(scene, &powers);
        }
        which.extend(0..powers.len() as u32);
        // A disc as large as the scene catches what comes from far away.
        let radius = 0.5 * (accel.bounds.hi - accel.bounds.lo).as_dvec3().length();
        let catch = if radius.is_finite() { PI * radius * radius } else { 1.0 };
        for light in &scene.lights {
            let (record, power) = punctual(light, accel.origin, catch);
            if power > 0.0 {
                which.push(KIND_PUNCTUAL | lights.punctual.len() as u32);
                powers.push(power);
                lights.punctual.push(record);
            }
        }
        if let Some(integral) = environment {
            which.push(KIND_ENVIRONMENT);
            powers.push(integral * catch);
        }
        let total: f64 = powers.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return Self { triangle_weights: lights.triangle_weights, ..Self::default() };
        }
        lights.share_among_emitters(accel, &mut powers, total);
        let total: f64 = powers.iter().sum();
        lights.density = (PI / total) as f32;
        if lights.tree.is_some() {
            // The triangles become one entry, the first.
            let all: f64 = powers.drain(..lights.area.len()).sum();
            powers.insert(0, all);
            which.drain(1..lights.area.len());
            lights.density = (all / total) as f32;
        }
        if environment.is_some() {
            lights.environment_probability = (powers[powers.len() - 1] / total) as f32;
        }
        let slots = alias_table(&powers);
        lights.table = (0..powers.len())
            .map(|i| LightEntry {
                threshold: slots[i].threshold,
                alias_entry: slots[i].alias,
                probability: (powers[i] / total) as f32,
                light: which[i],
            })
            .collect();
        lights
    }

    /// Half of the choice goes by power, half to each emitter alike: a mesh, a punctual light, the environment. Power alone
    /// starves a small lamp that stands close to what it lights, and the error bars of that place with it.
    fn share_among_emitters(&mut self, accel: &Accel, powers: &mut [f64], total: f64) {
        let mesh_of = |light: &AreaLight| accel.triangles[light.prim as usize].mesh;
        let mut by_mesh: HashMap<u32, f64> = HashMap::new();
        for (light, power) in self.area.iter().zip(powers.iter()) {
            *by_mesh.entry(mesh_of(light)).or_default() += power;
        }
        let emitters = (by_mesh.len() + powers.len() - self.area.len()) as f64;
        let factor = |emitter: f64| if emitter > 0.0 { 0.5 + 0.5 * total / (emitters * emitter) } else { 0.0 };
        for (prim, weight) in self.triangle_weights.iter_mut().enumerate() {
            if let Some(&power) = by_mesh.get(&accel.triangles[prim].mesh) {
                *weight *= factor(power) as f32;
            }
        }
        // A triangle's weight and its power must keep in step to the last bit of f32: they are the same pdf.
        for (i, power) in powers.iter_mut().enumerate() {
            *power *= match self.area.get_mut(i) {
                Some(light) => {
                    let f = factor(by_mesh[&mesh_of(light)]) as f32;
                    light.weight *= f;
                    f64::from(f)
                }
                None => factor(*power),
            };
        }
    }

    /// The emissive triangles as the kernel reads them.
    pub(crate) fn area_records(&self) -> Vec<AreaLight> {
        let mut records = self.area.clone();
        for (light, path) in records.iter_mut().zip(self.tree.iter().flat_map(|tree| &tree.paths)) {
            light.weight = path.inverse_area;
        }
        records
    }

    /// What the attributes of a triangle say of it as a light: with a tree its number, else its weight.
    pub(crate) fn triangle_words(&self) -> Vec<u32> {
        match &self.tree {
            Some(_) => self.triangle_lights.clone(),
            None => self.triangle_weights.iter().map(|w| w.to_bits()).collect(),
        }
    }

    fn tree(&self, scene: &Scene, powers: &[f64]) -> Option<LightTree> {
        let tree_light = |(light, &power): (&AreaLight, &f64)| {
            let [a, e1, e2] = [light.v0, light.e1, light.e2].map(|v| DVec3::from(v.map(f64::from)));
            let normal = (!scene.materials[light.material as usize].double_sided).then(|| e1.cross(e2).normalize());
            TreeLight { corners: [a, a + e1, a + e2], normal, power }
        };
        LightTree::new(&self.area.iter().zip(powers).map(tree_light).collect::<Vec<_>>())
    }

    fn add_triangles(&mut self, scene: &Scene, accel: &Accel, powers: &mut Vec<f64>) {
        let emits = |mesh: u32| scene.materials[scene.meshes[mesh as usize].material].is_emissive();
        if !accel.triangles.iter().any(|t| emits(t.mesh)) {
            return;
        }
        self.triangle_weights = accel
            .triangles
            .iter()
            .map(|t| {
                let mesh = &scene.meshes[t.mesh as usize];
                if emits(t.mesh) {
                    triangle_weight(scene, mesh, &scene.materials[mesh.material], t.corners)
                } else {
                    0.0
                }
            })
            .collect();
        // Triangles that stand in the world, then those of meshes that are placed several times.
        self.triangle_lights = vec![NONE; accel.triangles.len()];
        let mut shared: HashMap<u32, Vec<usize>> = HashMap::new();
        for (prim, source) in accel.triangles.iter().enumerate() {
            if self.triangle_weights[prim] <= 0.0 {
                continue;
            }
            if source.instance == NONE {
                let of_mesh = shared.entry(source.mesh).or_default();
                self.triangle_lights[prim] = of_mesh.len() as u32;
                of_mesh.push(prim);
            } else if self.add_triangle(scene, accel, prim, source.instance as usize, powers) {
                self.triangle_lights[prim] = self.area.len() as u32 - 1;
            }
        }
        for record in &accel.instances {
            self.instance_lights.push(self.area.len() as u32);
            let mesh = scene.instances[record.scene_instance as usize].mesh as u32;
            for &prim in shared.get(&mesh).into_iter().flatten() {
                if !self.add_triangle(scene, accel, prim, record.scene_instance as usize, powers) {
                    // Those after it keep their places.
                    self.area.push(AreaLight::default());
                    powers.push(0.0);
                }
            }
        }
    }

    /// Returns whether it has an area.
    fn add_triangle(
        &mut self,
        scene: &Scene,
        accel: &Accel,
        prim: usize,
        instance: usize,
        powers: &mut Vec<f64>,
    ) -> bool {
        let source = &accel.triangles[prim];
        let mesh = &scene.meshes[source.mesh as usize];
        let to_world = scene.instances[instance].to_world;
        let [a, b, c] = source.corners.map(|i| {
            let p = to_world.transform_point3(mesh.positions[i as usize].as_dvec3());
            (p - accel.origin).as_vec3()
        });
        let (e1, mut e2) = (b - a, c - a);
        let (mut e1, weight) = (e1, self.triangle_weights[prim]);
        // Corners of shared meshes are in object order: a mirroring instance turns them over.
        if source.instance == u32::MAX && to_world.matrix3.determinant() < 0.0 {
            std::mem::swap(&mut e1, &mut e2);
        }
        let area = 0.5 * e1.as_dvec3().cross(e2.as_dvec3()).length();
        if !(area > 0.0 && area.is_finite()) {
            return false;
        }
        powers.push(PI * f64::from(weight) * area);
        self.area.push(AreaLight {
            v0: a.to_array(),
            prim: prim as u32,
            e1: e1.to_array(),
            material: mesh.material as u32,
            e2: e2.to_array(),
            weight,
        });
        true
    }
}

/// Luminance of a triangle's mean emission, both sides counted where both emit.
fn triangle_weight(scene: &Scene, mesh: &Mesh, material: &Material, corners: [u32; 3]) -> f32 {
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    let mean = match &material.emissive_texture {
        None => [1.0; 3],
        Some(texture) => {
            let uvs = corners.map(|c| mesh.uvs.get(texture.uv_set as usize).map_or(Vec2::ZERO, |u| u[c as usize]));
            mean_texture(scene, texture, uvs)
        }
    };
    let radiance = [0, 1, 2].map(|c| material.emissive[c] * mean[c]);
    (sides * luminance(radiance)) as f32
}

/// Mean of a texture over a triangle of UVs, by a grid fine enough to meet each texel of small ones.
fn mean_texture(scene: &Scene, texture: &surelight_scene::TextureRef, uvs: [Vec2; 3]) -> [f32; 3] {
    let image = &scene.images[scene.textures[texture.texture].image];
    let size = Vec2::new(image.width as f32, image.height as f32);
    let extent = ((uvs[1] - uvs[0]) * size).length().max(((uvs[2] - uvs[0]) * size).length());
    let n = (extent.min(64.0) as usize).clamp(4, 64);
    let mut sum = [0.0f64; 3];
    let mut count = 0.0;
    for i in 0..n {
        for j in 0..n - i {
            let (b1, b2) = ((i as f32 + 1.0 / 3.0) / n as f32, (j as f32 + 1.0 / 3.0) / n as f32);
            let uv = uvs[0] + b1 * (uvs[1] - uvs[0]) + b2 * (uvs[2] - uvs[0]);
            let value = lookup_linear_rgb(scene, texture, uv);
            for c in 0..3 {
                sum[c] += f64::from(value[c]);
            }
            count += 1.0;
        }
    }
    sum.map(|s| (s / count) as f32)
}

/// A punctual light's record and its power.
fn punctual(light: &surelight_scene::Light, origin: DVec3, catch: f64) -> (PunctualLight, f64) {
    let brightness = luminance(light.intensity);
    let mut record = PunctualLight { intensity: light.intensity, ..Default::default() };
    let relative = |p: DVec3| (p - origin).as_vec3().to_array();
    let power = match light.kind {
        LightKind::Point { position } => {
            record.position = relative(position);
            4.0 * PI * brightness
        }
        LightKind::Spot { position, direction, inner, outer } => {
            record.kind = 1;
            record.position = relative(position);
            record.direction = direction.as_vec3().to_array();
            // KHR_lights_punctual, "Inner and outer cone angles".
            record.angle_scale = 1.0 / (inner.cos() - outer.cos()).max(0.001);
            record.angle_offset = -outer.cos() * record.angle_scale;
            2.0 * PI * (1.0 - f64::from(outer).cos()) * brightness
        }
        LightKind::Directional { direction } => {
            record.kind = 2;
            record.position = (-direction).as_vec3().to_array();
            catch * brightness
        }
    };
    (record, power)
}
