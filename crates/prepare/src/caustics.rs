//! Inputs of light tracing: the targets of particles, the choice of lights, and whether particles
//! are possible at all.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use surelight_accel::{Accel, Ray};
use surelight_scene::{Camera, LightKind, Projection, Scene};

use super::{
    alias::alias_table,
    casters::Ball,
    environment::EnvironmentTable,
    lights::{Lights, light_word},
    lobes::transmits,
    luminance,
    surface::Surface,
};
use crate::shared::{AreaLight, LIGHT_KIND_ENVIRONMENT, LIGHT_KIND_PUNCTUAL, LightEntry};

/// Where particles go, and how their light is added up.
pub(crate) struct Caustics {
    /// As centres and radii, camera space; the last is the ball around the whole scene.
    pub(crate) casters: Vec<[f32; 4]>,
    /// Lights, by about how much each sends to the casters.
    pub(crate) table: Vec<LightEntry>,
    /// The contribution of a particle of the usual flux to a pixel's sample at the casters'
    /// distance.
    pub(crate) usual: f64,
    /// Samples of all pixels for which one particle per pixel is sent: few particles where they
    /// contribute little.
    pub(crate) samples_per_particle: u32,
}

/// Why there is nothing to trace from the lights.
pub(super) const NOTHING_SMOOTH: &str = "no surface is smooth glass or a mirror";

/// Surfaces that a ray from a point may pass before it is abandoned.
const MAX_PASSED: u32 = 64;

/// Below this share of the light, a fourth of the usual number of particles is sent.
const SMALL_SHARE: f64 = 0.01;

impl Caustics {
    /// The inputs of light tracing, or the reason why light tracing is impossible or has no effect.
    ///
    /// `balls`: around all surfaces that may scatter by a delta. `volume`: whether some medium
    /// absorbs. `share`: of the light that surfaces scatter, the part by way of delta lobes.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn new(
        scene: &Scene,
        camera: &Camera,
        accel: &Accel,
        lights: &Lights,
        environment: Option<(&EnvironmentTable, f64)>,
        balls: &[Ball],
        volume: bool,
        share: f64,
    ) -> Result<Self, &'static str> {
        if balls.is_empty() {
            return Err(NOTHING_SMOOTH);
        }
        if volume && in_medium(scene, accel) {
            return Err("the camera is inside an absorbing medium");
        }
        let mut powers = Vec::new();
        let mut which = Vec::new();
        for (i, light) in lights.area.iter().enumerate() {
            powers.push(area_power(scene, light, balls));
            which.push(i as u32);
        }
        for (i, light) in scene_lights(scene).enumerate() {
            powers.push(punctual_power(light, accel.origin, balls));
            which.push(light_word(LIGHT_KIND_PUNCTUAL, i as u32));
        }
        let discs: f64 = balls.iter().map(|b| PI * b.radius * b.radius).sum();
        if let Some((table, factor)) = environment.filter(|(table, _)| table.source_pdf.is_finite()) {
            powers.push(table.total * factor * discs);
            which.push(light_word(LIGHT_KIND_ENVIRONMENT, 0));
        }
        let total: f64 = powers.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return Err("the scene has no light to trace from");
        }
        let slots = alias_table(&powers);
        let entry = |i: usize| LightEntry {
            threshold: slots[i].threshold,
            alias_entry: slots[i].alias,
            probability: (powers[i] / total) as f32,
            light: which[i],
        };
        let table = (0..powers.len()).map(entry).collect();
        let (low, high) = (accel.bounds.lo.as_dvec3(), accel.bounds.hi.as_dvec3());
        let whole = Ball { center: (low + high) * 0.5, radius: 0.5 * (high - low).length() };
        let record = |b: &Ball| [b.center.x as f32, b.center.y as f32, b.center.z as f32, b.radius as f32];
        let usual = total / spread(camera, balls);
        let samples_per_particle = if share < SMALL_SHARE { 16 } else { 4 };
        Ok(Self { casters: balls.iter().chain([&whole]).map(record).collect(), table, usual, samples_per_particle })
    }

    /// Casters, without the ball around the scene.
    pub(crate) fn count(&self) -> u32 {
        self.casters.len() as u32 - 1
    }
}

/// Lights without extent that shine, in the order of their records.
fn scene_lights(scene: &Scene) -> impl Iterator<Item = &surelight_scene::Light> {
    scene.lights.iter().filter(|light| luminance(light.intensity) > 0.0)
}

/// Area of the picture at the distance of the casters, m².
fn spread(camera: &Camera, balls: &[Ball]) -> f64 {
    match camera.projection {
        Projection::Orthographic { xmag, ymag } => 4.0 * xmag * ymag,
        Projection::Perspective { yfov, .. } => {
            // The middle, on a logarithmic scale, between the nearest and the farthest; the shape
            // of the picture has little effect.
            let distances = || balls.iter().map(|b| b.center.length().max(b.radius));
            let (near, far) = (distances().fold(f64::INFINITY, f64::min), distances().fold(0.0, f64::max));
            4.0 * (0.5 * yfov).tan().powi(2) * near * far
        }
    }
}

/// 1 − cos of the cone that a ball subtends; 2 from within.
pub(super) fn cone_height(ball: &Ball, from: DVec3) -> f64 {
    let s2 = ball.radius * ball.radius / (ball.center - from).length_squared();
    if s2 < 1.0 { s2 / (1.0 + (1.0 - s2).sqrt()) } else { 2.0 }
}

/// About the flux from an area light to the casters.
fn area_power(scene: &Scene, light: &AreaLight, balls: &[Ball]) -> f64 {
    let [a, e1, e2] = [light.v0, light.e1, light.e2].map(|v| Vec3::from(v).as_dvec3());
    let across = e1.cross(e2);
    // Not the light's weight: half of that goes to each emitter alike.
    let material = &scene.materials[light.material()];
    let (double_sided, sides) = (material.double_sided, if material.double_sided { 2.0 } else { 1.0 });
    if light.weight <= 0.0 {
        return 0.0;
    }
    let middle = a + (e1 + e2) * if light.is_parallelogram() { 0.5 } else { 1.0 / 3.0 };
    let Some(normal) = across.try_normalize() else { return 0.0 };
    let shines = |b: &&Ball| double_sided || (b.center - middle).dot(normal) > -b.radius - e1.length() - e2.length();
    let heights: f64 = balls.iter().filter(shines).map(|b| cone_height(b, middle)).sum();
    // A texture may leave less of it; any positive share will do.
    luminance(material.emissive).max(1e-30) * sides * light.area() * PI * heights.min(1.0)
}

/// About the flux from a light without extent to the casters.
fn punctual_power(light: &surelight_scene::Light, origin: DVec3, balls: &[Ball]) -> f64 {
    let brightness = luminance(light.intensity);
    let heights = |position: DVec3, most: f64| -> f64 {
        2.0 * PI * balls.iter().map(|b| cone_height(b, position - origin)).sum::<f64>().min(most)
    };
    match light.kind {
        LightKind::Point { position } => brightness * heights(position, 2.0),
        LightKind::Spot { position, outer, .. } => brightness * heights(position, 1.0 - f64::from(outer).cos()),
        LightKind::Directional { .. } => brightness * balls.iter().map(|b| PI * b.radius * b.radius).sum::<f64>(),
    }
}

/// Whether the camera is inside a medium: whether most of three rays hit the first surface of one
/// from within.
fn in_medium(scene: &Scene, accel: &Accel) -> bool {
    let directions = [Vec3::new(0.61, 0.53, 0.59), Vec3::new(-0.57, 0.49, -0.66), Vec3::new(0.31, -0.81, -0.5)];
    directions.into_iter().filter(|&d| starts_inside(scene, accel, d.normalize())).count() >= 2
}

fn starts_inside(scene: &Scene, accel: &Accel, direction: Vec3) -> bool {
    let mut ray = Ray::new(Vec3::ZERO, direction);
    for _ in 0..MAX_PASSED {
        let Some(hit) = accel.intersect(&ray) else { return false };
        let surface = Surface::at(scene, accel, &hit);
        if surface.material.volume.is_some() && transmits(surface.material) {
            return surface.front.dot(direction.as_dvec3()) > 0.0;
        }
        ray.t_min = hit.t * (1.0 + 1e-5);
    }
    false
}
