//! Everything that light sampling can choose from, and with which probability.
//!
//! An alias table over all lights; where there are many emissive triangles they are one entry of
//! it, and a tree chooses among them by the receiving point.

use std::{
    collections::{BTreeMap, HashMap},
    f64::consts::PI,
};

use glam::DVec3;
use surelight_accel::Accel;
use surelight_scene::{LightKind, Material, Mesh, Scene};

use crate::shared::{
    AreaLight, LIGHT_KIND_ENVIRONMENT, LIGHT_KIND_PUNCTUAL, LIGHT_KIND_SHIFT, LightEntry, MIRRORED, PARALLELOGRAM,
    PunctualLight,
};

use super::{
    Integrator,
    alias::alias_table,
    blueprint::placed_triangles,
    emitters::{Emitter, emitters, pieces},
    light_tree::{LightTree, TreeLight},
    luminance,
};

/// Fewer area lights than these are chosen by the alias table.
const MIN_TREE_LIGHTS: usize = 2;

/// Means no light.
const NONE: u32 = u32::MAX;

/// A light as entries of the light table name it.
pub(crate) fn light_word(kind: u32, index: u32) -> u32 {
    kind << LIGHT_KIND_SHIFT | index
}

/// The lights of a scene, each with its power as weight.
#[derive(Default)]
pub(crate) struct Lights {
    pub(crate) table: Vec<LightEntry>,
    pub(crate) area: Vec<AreaLight>,
    pub(crate) punctual: Vec<PunctualLight>,
    /// Over the area lights, where there are several.
    pub(crate) tree: Option<LightTree>,
    /// By prim: its number among `area`, which for triangles of instanced meshes counts from the
    /// instance's first. Empty when nothing emits.
    triangle_lights: Vec<u32>,
    /// Prims of parallelograms: that of the record, and the other.
    pairs: Vec<[usize; 2]>,
    /// By instance of the BVH: its first light.
    pub(crate) instance_lights: Vec<u32>,
    /// An area light's weight times this is its mean pdf per area; with a tree, given that the tree
    /// chooses it.
    pub(crate) density: f32,
    pub(crate) environment_probability: f32,
}

/// The kinds of lights of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LightKinds {
    pub(crate) any: bool,
    pub(crate) area: bool,
    pub(crate) tree: bool,
    pub(crate) punctual: bool,
}

impl LightKinds {
    /// As far as they are known without reading triangles. `sky`: whether an environment map is
    /// sampled.
    pub(crate) fn expected(scene: &Scene, integrator: Integrator, sky: bool) -> Self {
        if matches!(integrator, Integrator::Hemisphere(_)) {
            return Self { any: false, area: false, tree: false, punctual: false };
        }
        let [_, emissive] = placed_triangles(scene);
        let area = emissive > 0;
        let punctual = scene.lights.iter().any(|light| punctual(light, DVec3::ZERO, 1.0).1 > 0.0);
        let joined = || {
            let meshes = scene.instances.iter().filter_map(|instance| scene.meshes.get(instance.mesh));
            let mut emissive = meshes.filter(|m| scene.materials.get(m.material).is_some_and(Material::is_emissive));
            // Building the trees refuses indices that are out of range.
            let sound = |m: &&Mesh| m.triangles.iter().flatten().all(|&i| (i as usize) < m.positions.len());
            emissive
                .all(|m| m.triangles.len() == 2 && sound(&m) && pieces(scene, m, &m.triangles, integrator).len() == 1)
        };
        // Three triangles are two lights at least.
        let several = emissive > 2 || emissive == 2 && !joined();
        let tree = several && integrator != Integrator::Whitted;
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
        lights.add_triangles(scene, accel, integrator, &mut powers);
        // Whitted's shadow rays go to the middles of lights: they work for few lights only.
        if powers.len() >= MIN_TREE_LIGHTS && integrator != Integrator::Whitted {
            lights.tree = lights.tree(scene, &powers);
        }
        which.extend(0..powers.len() as u32);
        // A disc as large as the scene receives light from infinity.
        let radius = 0.5 * (accel.bounds.hi - accel.bounds.lo).as_dvec3().length();
        let catch = if radius.is_finite() { PI * radius * radius } else { 1.0 };
        for light in &scene.lights {
            let (record, power) = punctual(light, accel.origin, catch);
            if power > 0.0 {
                which.push(light_word(LIGHT_KIND_PUNCTUAL, lights.punctual.len() as u32));
                powers.push(power);
                lights.punctual.push(record);
            }
        }
        if let Some(integral) = environment {
            which.push(light_word(LIGHT_KIND_ENVIRONMENT, 0));
            powers.push(integral * catch);
        }
        let total: f64 = powers.iter().sum();
        if total.is_nan() || total <= 0.0 {
            return Self::default();
        }
        lights.share_among_emitters(accel, &mut powers, total);
        let total: f64 = powers.iter().sum();
        lights.density = (PI / total) as f32;
        if lights.tree.is_some() {
            // The area lights become one entry, the first.
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

    /// Half of the probability is by power, half equal for each emitter: a mesh, a punctual light,
    /// the environment. Power alone undersamples a small lamp close to a surface, and makes the
    /// error bars there unreliable.
    fn share_among_emitters(&mut self, accel: &Accel, powers: &mut [f64], total: f64) {
        let mesh_of = |light: &AreaLight| accel.triangles[light.prim as usize].mesh;
        let mut by_mesh: HashMap<u32, f64> = HashMap::new();
        for (light, power) in self.area.iter().zip(powers.iter()) {
            *by_mesh.entry(mesh_of(light)).or_default() += power;
        }
        let emitters = (by_mesh.len() + powers.len() - self.area.len()) as f64;
        let factor = |emitter: f64| if emitter > 0.0 { 0.5 + 0.5 * total / (emitters * emitter) } else { 0.0 };
        // A light's weight and its power must agree to the last bit of f32: they are the same pdf.
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

    /// The area lights as the kernel reads them.
    pub(crate) fn area_records(&self) -> Vec<AreaLight> {
        let mut records = self.area.clone();
        for (light, path) in records.iter_mut().zip(self.tree.iter().flat_map(|tree| &tree.paths)) {
            light.weight = path.inverse_area;
        }
        records
    }

    /// The entry of an emissive triangle in its attributes: with a tree its number, else its
    /// weight.
    pub(crate) fn triangle_words(&self) -> Vec<u32> {
        if self.tree.is_some() {
            return self.triangle_lights.clone();
        }
        let mut words = vec![0; self.triangle_lights.len()];
        for light in &self.area {
            words[light.prim as usize] = light.weight.to_bits();
        }
        for &[prim, other] in &self.pairs {
            words[other] = words[prim];
        }
        words
    }

    fn tree(&self, scene: &Scene, powers: &[f64]) -> Option<LightTree> {
        let tree_light = |(light, &power): (&AreaLight, &f64)| {
            let [a, e1, e2] = [light.v0, light.e1, light.e2].map(|v| DVec3::from(v.map(f64::from)));
            let material = &scene.materials[light.material()];
            let normal = (!material.double_sided).then(|| e1.cross(e2).normalize());
            TreeLight { corners: [a, a + e1, a + e2], parallelogram: light.is_parallelogram(), normal, power }
        };
        LightTree::new(&self.area.iter().zip(powers).map(tree_light).collect::<Vec<_>>())
    }

    fn add_triangles(&mut self, scene: &Scene, accel: &Accel, integrator: Integrator, powers: &mut Vec<f64>) {
        let emits = |mesh: u32| scene.materials[scene.meshes[mesh as usize].material].is_emissive();
        // Triangles in world space, by their meshes, then those of meshes that are instanced.
        let mut groups: BTreeMap<(u32, u32), Vec<usize>> = BTreeMap::new();
        for (prim, source) in accel.triangles.iter().enumerate().filter(|(_, t)| emits(t.mesh)) {
            groups.entry((source.instance, source.mesh)).or_default().push(prim);
        }
        if groups.is_empty() {
            return;
        }
        self.triangle_lights = vec![NONE; accel.triangles.len()];
        let mut shared: HashMap<u32, Vec<Emitter>> = HashMap::new();
        for ((instance, mesh), prims) in groups {
            let emitters = emitters(scene, accel, mesh, &prims, integrator);
            self.pairs.extend(emitters.iter().filter_map(|e| Some([e.prim, e.other?])));
            if instance != NONE {
                for emitter in &emitters {
                    if self.add_light(scene, accel, emitter, instance as usize, powers) {
                        let number = self.area.len() as u32 - 1;
                        emitter.prims().for_each(|prim| self.triangle_lights[prim] = number);
                    }
                }
                continue;
            }
            for (number, emitter) in (0..).zip(&emitters) {
                emitter.prims().for_each(|prim| self.triangle_lights[prim] = number);
            }
            shared.insert(mesh, emitters);
        }
        for record in &accel.instances {
            self.instance_lights.push(self.area.len() as u32);
            let mesh = scene.instances[record.scene_instance as usize].mesh as u32;
            for emitter in shared.get(&mesh).into_iter().flatten() {
                if !self.add_light(scene, accel, emitter, record.scene_instance as usize, powers) {
                    // Those after it keep their places.
                    self.area.push(AreaLight { prim: emitter.prim as u32, ..AreaLight::default() });
                    powers.push(0.0);
                }
            }
        }
    }

    /// Returns whether it has an area.
    fn add_light(
        &mut self,
        scene: &Scene,
        accel: &Accel,
        emitter: &Emitter,
        instance: usize,
        powers: &mut Vec<f64>,
    ) -> bool {
        let source = &accel.triangles[emitter.prim];
        let mesh = &scene.meshes[source.mesh as usize];
        let to_world = scene.instances[instance].to_world;
        let [a, b, c] = [0, 1, 2].map(|k| {
            let corner = source.corners[(emitter.corner + k) % 3];
            let p = to_world.transform_point3(mesh.positions[corner as usize].as_dvec3());
            (p - accel.origin).as_vec3()
        });
        let (mut e1, mut e2) = (b - a, c - a);
        // Corners of shared meshes are in object order: a mirroring instance turns them over.
        let mirrored = source.instance == NONE && to_world.matrix3.determinant() < 0.0;
        if mirrored {
            std::mem::swap(&mut e1, &mut e2);
        }
        let flags = if emitter.other.is_some() { PARALLELOGRAM } else { 0 } | if mirrored { MIRRORED } else { 0 };
        let light = AreaLight {
            v0: a.to_array(),
            prim: emitter.prim as u32,
            e1: e1.to_array(),
            shape: mesh.material as u32 | flags,
            e2: e2.to_array(),
            weight: emitter.weight,
        };
        let area = light.area();
        if !(area > 0.0 && area.is_finite()) {
            return false;
        }
        powers.push(PI * f64::from(emitter.weight) * area);
        self.area.push(light);
        true
    }
}

impl AreaLight {
    pub(super) fn material(&self) -> usize {
        (self.shape & !(PARALLELOGRAM | MIRRORED)) as usize
    }

    pub(super) fn is_parallelogram(&self) -> bool {
        self.shape & PARALLELOGRAM != 0
    }

    pub(super) fn area(&self) -> f64 {
        let [e1, e2] = [self.e1, self.e2].map(|v| DVec3::from(v.map(f64::from)));
        e1.cross(e2).length() * if self.is_parallelogram() { 1.0 } else { 0.5 }
    }
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
