//! Light that no connection to a point on it finds: light through smooth glass or by mirrors alone.
//!
//! Estimators connect a path to a light at a vertex that scatters. For a light whose rays first hit
//! a mirror or smooth glass no vertex is ever connected, and its light must be found by a direction
//! that happens to hit it. A light without extent is never hit: its caustics are missing from the
//! picture, whatever the number of samples. An emitter behind glass on all sides is hit by chance:
//! the picture is right in the limit, and its error bars are unreliable before there are enough
//! hits.
//!
//! Where light is traced from the lights (`Integrator::Caustics`), it reaches directly visible
//! surfaces; only such light that is then seen in a mirror or through glass is missing or hit by
//! chance alone.
//!
//! How much that is, [`LightFlow`] finds by rays from the lights.

use std::f64::consts::TAU;
use std::fmt::{self, Display};

use glam::{DVec2, DVec3, Vec3};
use surelight_accel::{Accel, Ray};
use surelight_scene::{AlphaMode, Camera, Material, Projection, Scene};

use super::clip::Planes;
use super::light_flow::LightFlow;
use super::lobes::{has_facets, is_coated, is_pane};
use super::shared::View;
use super::surface::Surface;

/// Rays through the picture.
const RAYS: u32 = 4096;
/// Shares below this are not reported.
const MIN_SHARE: f64 = 0.01;
/// Emitters are reported from this share of light found by chance alone.
const MAX_CHANCE_SHARE: f64 = 0.9;
/// Roughness below which lobes are deltas: α < 1e-4.
const SMOOTH: f32 = 0.01;
/// Surfaces without cover that a ray may pass.
const MAX_PASSED: u32 = 64;

/// Light that estimators cannot connect.
#[derive(Clone, Debug, PartialEq)]
pub enum Unreachable {
    /// Lights without extent: their light is missing from the picture.
    Missing {
        /// Names of the lights, or their numbers in the scene.
        lights: Vec<String>,
        /// Of all light that surfaces scatter, the share that is missing.
        share: f64,
    },
    /// Lights without extent, where light is traced from them: their caustics in mirrors and behind
    /// glass are missing.
    SeenBehind {
        /// Names of the lights, or their numbers in the scene.
        lights: Vec<String>,
        /// Share of the picture that shows mirrors and glass.
        share: f64,
    },
    /// Emitters behind glass: their light is found by chance.
    ByChance {
        /// Share of the light of all emitters.
        share: f64,
    },
}

impl Unreachable {
    /// Whether the expected picture lacks something.
    pub fn is_bias(&self) -> bool {
        matches!(self, Self::Missing { .. } | Self::SeenBehind { .. })
    }
}

impl Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { lights, share } => {
                write!(
                    f,
                    "missing light: {} of what lights the scene comes from {} through smooth glass or by mirrors, where no path \
                     from the camera finds a light without extent",
                    Percent(*share),
                    Names(lights)
                )
            }
            Self::SeenBehind { lights, share } => write!(
                f,
                "missing light: what comes from {} through smooth glass or by mirrors is missing where it is seen through glass or in \
                 mirrors again, which are {} of the picture",
                Names(lights),
                Percent(*share)
            ),
            Self::ByChance { share } => write!(
                f,
                "{} of the light of all emitters goes through smooth glass or by mirrors first, where it is found by chance alone: expect \
                 heavy tails, and pixels that are black only so far",
                Percent(*share)
            ),
        }
    }
}

/// The first few of some names.
struct Names<'a>(&'a [String]);

impl Display for Names<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let more = self.0.len().saturating_sub(3);
        f.write_str(&self.0[..self.0.len() - more].join(", "))?;
        if more > 0 { write!(f, " and {more} more") } else { Ok(()) }
    }
}

struct Percent(f64);

impl Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.*} %", usize::from(self.0 < 0.1), 100.0 * self.0)
    }
}

/// Findings of the light-flow analysis about the lights. `eye`: the camera's rays, where light is
/// traced from the lights.
pub(super) fn find(scene: &Scene, accel: &Accel, flow: &LightFlow, eye: Option<&CameraRays>) -> Vec<Unreachable> {
    let name = |&i: &usize| {
        let name = &scene.lights[i].name;
        if name.is_empty() { format!("light {i}") } else { format!("'{name}'") }
    };
    let lights: Vec<String> = flow.missing_lights.iter().map(name).collect();
    let mut found = Vec::new();
    if let Some(eye) = eye {
        let specular = scene.materials.iter().map(specular_share).collect();
        let share = SpecularWalk { scene, accel, specular }.unscattered_share(eye);
        if !lights.is_empty() && share >= MIN_SHARE {
            found.push(Unreachable::SeenBehind { lights, share });
        }
        // Pixels hit by chance are not certified; the picture as a whole does not depend on chance.
        return found;
    }
    if !lights.is_empty() && flow.missing_share >= MIN_SHARE {
        found.push(Unreachable::Missing { lights, share: flow.missing_share });
    }
    // Under an environment an emitter is not the only light, and a pixel without a chance hit is
    // seldom dark.
    if scene.environment.is_none() && flow.emitter_delta_share >= MAX_CHANCE_SHARE {
        found.push(Unreachable::ByChance { share: flow.emitter_delta_share });
    }
    found
}

/// The share of a surface's incident light that continues unscattered, without the part that passes
/// straight through a pane, which light sampling finds, too; 0 where the surface has nothing
/// smooth.
fn specular_share(m: &Material) -> f64 {
    let greatest = |c: &[f32]| f64::from(c.iter().copied().fold(0.0, f32::max));
    let base = if has_facets(m) && m.roughness < SMOOTH {
        let (metallic, transmission) = (f64::from(m.metallic), f64::from(m.transmission));
        let reflected = f64::from(((m.ior - 1.0) / (m.ior + 1.0)).powi(2) * m.specular);
        let colour = greatest(&m.base_color[..3]);
        let transmission = if is_pane(m, true) { 0.0 } else { transmission };
        metallic * colour + (1.0 - metallic) * (reflected + (1.0 - reflected) * transmission * colour)
    } else {
        0.0
    };
    let coat = if is_coated(m) && m.clearcoat.roughness < SMOOTH { 0.04 * f64::from(m.clearcoat.factor) } else { 0.0 };
    coat + (1.0 - coat) * base
}

/// The i-th of n points that fill the unit square evenly (a lattice along the golden ratio).
pub(super) fn point(i: u32, n: u32) -> DVec2 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    DVec2::new((f64::from(i) + 0.5) / f64::from(n), (f64::from(i) * GOLDEN).fract())
}

/// A direction by its cosine and turn about an axis.
pub(super) fn direction_around(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * turn).sin_cos();
    axis * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// Rays of the picture's middle, right and upper edge, camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraRays {
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    orthographic: bool,
    planes: Planes,
}

impl CameraRays {
    pub(super) fn new(camera: &Camera, view: &View, planes: Planes) -> Self {
        let [origin, forward, right, up] =
            [view.origin, view.forward, view.right, view.up].map(|v| Vec3::from(v).as_dvec3());
        let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
        Self { origin, forward, right, up, orthographic, planes }
    }
}

struct SpecularWalk<'a> {
    scene: &'a Scene,
    accel: &'a Accel,
    specular: Vec<f64>,
}

impl SpecularWalk<'_> {
    /// The unscattered share at the first surface on a ray; `None` where there is none. Camera
    /// space.
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let mut ray = Ray::new(origin.as_vec3(), direction.as_vec3());
        for _ in 0..MAX_PASSED {
            let hit = self.accel.intersect(&ray)?;
            let surface = Surface::at(self.scene, self.accel, &hit);
            if surface.material.alpha_mode == AlphaMode::Opaque {
                return Some(self.specular[surface.material_index]);
            }
            // Alpha textures are not sampled: surfaces behind contribute.
            ray.t_min = hit.t * (1.0 + 1e-5);
        }
        None
    }

    /// The share of the picture in which light continues unscattered.
    fn unscattered_share(&self, eye: &CameraRays) -> f64 {
        let share = |i: u32| {
            let u = point(i, RAYS) * 2.0 - 1.0;
            let across = eye.right * u.x + eye.up * u.y;
            let (origin, direction) = if eye.orthographic {
                (eye.origin + across, eye.forward)
            } else {
                (eye.origin, (eye.forward + across).normalize())
            };
            self.first(eye.planes.start(origin, direction), direction)
        };
        (0..RAYS).filter_map(share).sum::<f64>() / f64::from(RAYS)
    }
}
