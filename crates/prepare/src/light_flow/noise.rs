//! How noisy it is to find the photons' light by chance.

use std::f64::consts::PI;

use glam::Vec3;
use surelight_accel::Ray;
use surelight_scene::Projection;

use super::{FlowInput, Photon};

/// Photons at whose places irradiance is estimated.
const MAX_PLACES: usize = 512;
/// Photons that an estimate of irradiance is made from.
const NEIGHBOURS: usize = 12;
/// Relative variances per sample are capped here; lights without extent reach it.
const MAX_NOISE: f64 = 1e6;
/// Of the light that a typical pixel reflects, the share that came from other surfaces.
const INDIRECT_SHARE: f64 = 0.3;

/// Mean over the picture of the relative variance that light by deltas has when it is found by
/// chance.
pub(super) fn chance_noise(input: &FlowInput, direct: &[Photon], by_deltas: &[Photon], delta_share: f64) -> f64 {
    if by_deltas.is_empty() {
        return 0.0;
    }
    let stride = by_deltas.len().div_ceil(MAX_PLACES);
    let mut noise = 0.0;
    let (mut inverse_chance, mut flux) = (0.0, 0.0);
    for photon in by_deltas.iter().step_by(stride) {
        flux += photon.flux;
        inverse_chance += photon.flux * (1.0 / photon.chance.max(1.0 / MAX_NOISE));
        let importance = importance(input, photon);
        if importance <= 0.0 {
            continue;
        }
        let [c, d] = [by_deltas, direct].map(|photons| irradiance(photons, photon));
        if c > 0.0 {
            let share = c / (c + d);
            let variance = (share * share / photon.chance.max(1e-12)).min(MAX_NOISE);
            noise += stride as f64 * photon.flux / c * importance * variance;
        }
    }
    // Light that surfaces send on to all others carries the noise with it.
    let mean_inverse = if flux > 0.0 { inverse_chance / flux } else { 0.0 };
    noise + (INDIRECT_SHARE * delta_share).powi(2) * mean_inverse
}

/// Share of the picture per area of the surface where a photon landed, 1/m²; 0 where the camera
/// does not see it.
fn importance(input: &FlowInput, photon: &Photon) -> f64 {
    let view = input.view;
    let [origin, forward, right, up] =
        [view.origin, view.forward, view.right, view.up].map(|v| Vec3::from(v).as_dvec3());
    let to_point = photon.position - origin;
    let depth = to_point.dot(forward);
    let orthographic = matches!(input.camera.projection, Projection::Orthographic { .. });
    let across = if orthographic { to_point } else { to_point / depth.max(1e-30) };
    let ndc = [across.dot(right) / right.length_squared(), across.dot(up) / up.length_squared()];
    if depth <= 0.0 || ndc.iter().any(|c| c.abs() > 1.0) {
        return 0.0;
    }
    let area = 4.0 * right.length() * up.length();
    let distance = if orthographic { depth } else { to_point.length() };
    let direction = if orthographic { forward } else { to_point / distance };
    // Surfaces before the near plane hide nothing.
    let start = input.planes.start(photon.position - direction * distance, direction);
    let left = (photon.position - start).dot(direction);
    let hit = input.accel.intersect(&Ray::new(start.as_vec3(), direction.as_vec3()));
    if left <= 0.0 || hit.is_some_and(|hit| f64::from(hit.t) < left * (1.0 - 1e-4)) {
        return 0.0;
    }
    let cosine = photon.normal.dot(direction).abs();
    if orthographic {
        cosine / area
    } else {
        let forward_cosine = depth / distance;
        cosine / (area * forward_cosine.powi(3) * distance * distance)
    }
}

/// Irradiance by the photons around one of them that landed on the same side.
fn irradiance(photons: &[Photon], at: &Photon) -> f64 {
    let mut nearest: Vec<(f64, f64)> = photons
        .iter()
        .filter(|p| p.normal.dot(at.normal) > 0.7)
        .map(|p| (p.position.distance_squared(at.position), p.flux))
        .collect();
    let k = NEIGHBOURS.min(nearest.len());
    if k == 0 {
        return 0.0;
    }
    nearest.select_nth_unstable_by(k - 1, |a, b| a.0.total_cmp(&b.0));
    let squared = nearest[k - 1].0;
    let flux: f64 = nearest[..k].iter().map(|(_, flux)| flux).sum();
    if squared > 0.0 { flux / (PI * squared) } else { 0.0 }
}
