//! How light reaches the surfaces of a scene: directly, or first by mirrors and smooth glass.
//!
//! Next-event estimation connects a path to a light at a vertex that scatters. Light whose first
//! event is a delta lobe (a mirror, smooth glass) is connected by no vertex: a sampled direction
//! must happen to find its source, and a light without extent is never found. This module estimates
//! how much light that is, and how noisy finding it by chance is, with some ten thousand rays from
//! the lights, on the host. [`Integrator::Auto`](super::Integrator::Auto) decides by it, and the
//! summary reports the light that stays missing.
//!
//! Rays from the lights are photons ([`emission`]). Some are emitted in all directions and land on
//! the first surface that scatters. Others are aimed at the surfaces with delta lobes and follow
//! these until they land ([`follow`]). The photons around a point estimate the irradiance there
//! that comes directly, D, and by deltas, C (Jensen 1996, "Global illumination using photon maps":
//! k nearest neighbours). A path tracer that finds the latter with probability p per sample has the
//! relative variance (C / (C + D))² / p from it; the mean of that over the image is
//! [`LightFlow::chance_noise`] ([`noise`]).
//!
//! Straight transmission through panes is no event: shadow rays pass them. Materials are judged by
//! their factors, and surfaces with alpha as if they were not there.

mod emission;
mod follow;
mod noise;

use glam::DVec3;
use surelight_accel::Accel;
use surelight_scene::{Camera, Scene};

use self::emission::{Source, Sources};
use super::{casters::Ball, clip::Planes, environment::EnvironmentTable, shared::AreaLight, shared::View};

/// Photons emitted in all directions, and photons aimed at surfaces with delta lobes.
const DIRECT_RAYS: u32 = 4096;
const AIMED_RAYS: u32 = 8192;

/// How light reaches the surfaces of a scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct LightFlow {
    /// Of the light that surfaces scatter, the share that comes by mirrors and smooth glass first:
    /// 0 to 1.
    pub(crate) delta_share: f64,
    /// Of the same, the share that comes so from lights without extent, which no direction finds.
    pub(crate) missing_share: f64,
    /// Of what emitters send, the share that comes so; 0 without emitters.
    pub(crate) emitter_delta_share: f64,
    /// Scene lights without extent of which at least a hundredth comes so.
    pub(crate) missing_lights: Vec<usize>,
    /// Mean over the image's pixels of the relative variance per sample of light that is found by
    /// chance.
    pub(crate) chance_noise: f64,
}

/// Inputs of the analysis.
pub(super) struct FlowInput<'a> {
    pub(super) scene: &'a Scene,
    pub(super) accel: &'a Accel,
    pub(super) camera: &'a Camera,
    pub(super) view: &'a View,
    pub(super) planes: &'a Planes,
    /// Emissive triangles and parallelograms, camera space.
    pub(super) area: &'a [AreaLight],
    /// The environment map and the factor on it.
    pub(super) sky: Option<(&'a EnvironmentTable, f64)>,
    /// Radiance of a uniform environment, luminance.
    pub(super) uniform_sky: f64,
    /// Balls around every surface that may have a delta lobe, camera space.
    pub(super) balls: &'a [Ball],
}

impl FlowInput<'_> {
    /// The ball around the scene: its middle and radius.
    fn ball(&self) -> (DVec3, f64) {
        let (low, high) = (self.accel.bounds.lo.as_dvec3(), self.accel.bounds.hi.as_dvec3());
        ((low + high) * 0.5, 0.5 * (high - low).length())
    }

    /// How far a ray's origin is moved off a surface.
    fn offset(&self, at: DVec3) -> f64 {
        1e-5 * (at.abs().max_element() + 1e-3 * self.ball().1)
    }
}

/// A photon where it lands.
#[derive(Clone, Copy)]
struct Photon {
    position: DVec3,
    /// Unit vector, on the side that the photon came from.
    normal: DVec3,
    /// Luminous flux that is scattered here.
    flux: f64,
    /// Probability that a direction sampled here, by the cosine, finds the light along the photon's
    /// way.
    chance: f64,
}

/// Points that fill the unit cube evenly: a Kronecker sequence by powers of the root of x⁷ = x + 1
/// (Roberts 2018).
fn point(i: u32) -> [f64; 6] {
    const STEPS: [f64; 6] = [
        0.889_733_744_947_8,
        0.791_626_136_877_0,
        0.704_336_487_395_9,
        0.626_671_938_640_6,
        0.557_571_179_849_4,
        0.496_089_894_085_9,
    ];
    STEPS.map(|step| (0.5 + f64::from(i + 1) * step).fract())
}

impl LightFlow {
    /// Sends the photons. Without balls there are no deltas, and nothing is sent.
    pub(super) fn new(input: &FlowInput) -> Self {
        if input.balls.is_empty() || !input.accel.bounds.lo.is_finite() || !input.accel.bounds.hi.is_finite() {
            return Self::default();
        }
        Self::measure(input)
    }

    /// Sends everything and adds it up.
    fn measure(input: &FlowInput) -> Self {
        let sources = Sources::new(input);
        let (direct_powers, aimed_powers) = (sources.powers(), sources.aimed_powers());
        let lights = input.scene.lights.len();
        let (mut by_light, mut of_light) = (vec![0.0; lights], vec![0.0; lights]);
        let (mut direct, mut emitters) = (Vec::new(), [0.0; 2]);
        for i in 0..DIRECT_RAYS {
            let mut u = point(i);
            let Some((k, p)) = emission::choose(&direct_powers, f64::from(i) / f64::from(DIRECT_RAYS)) else { break };
            let Some(mut emission) = sources.emit(k, u) else { continue };
            emission.flux /= p * f64::from(DIRECT_RAYS);
            u[5] = (u[5] + u[0]).fract();
            if let Some(photon) = follow::follow(input, &emission, false, u[5]) {
                match sources.kind(k) {
                    Source::Area(_) => emitters[0] += photon.flux,
                    Source::Light(light, _) => of_light[light] += photon.flux,
                    Source::Sky | Source::UniformSky => {}
                }
                direct.push(photon);
            }
        }
        let (mut by_deltas, mut missing) = (Vec::new(), 0.0);
        for i in 0..AIMED_RAYS {
            let u = point(i);
            let Some((k, p)) = emission::choose(&aimed_powers, f64::from(i) / f64::from(AIMED_RAYS)) else { break };
            let Some(mut emission) = sources.aim(k, u) else { continue };
            emission.flux /= p * f64::from(AIMED_RAYS);
            if let Some(photon) = follow::follow(input, &emission, true, (u[5] + u[0]).fract()) {
                match sources.kind(k) {
                    Source::Area(_) => emitters[1] += photon.flux,
                    Source::Light(light, _) => {
                        missing += photon.flux;
                        by_light[light] += photon.flux;
                    }
                    Source::Sky | Source::UniformSky => {}
                }
                by_deltas.push(photon);
            }
        }
        let total = |photons: &[Photon]| photons.iter().map(|photon| photon.flux).sum::<f64>();
        let (direct_total, delta_total) = (total(&direct), total(&by_deltas));
        let share = |part: f64, all: f64| if part > 0.0 { part / all } else { 0.0 };
        let delta_share = share(delta_total, direct_total + delta_total);
        Self {
            delta_share,
            missing_share: share(missing, direct_total + delta_total),
            emitter_delta_share: share(emitters[1], emitters[0] + emitters[1]),
            missing_lights: (0..lights).filter(|&i| share(by_light[i], by_light[i] + of_light[i]) >= 0.01).collect(),
            chance_noise: noise::chance_noise(input, &direct, &by_deltas, delta_share),
        }
    }
}
