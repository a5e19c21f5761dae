//! Light that no point on it can be connected to: what shines through smooth glass or by mirrors alone.
//!
//! Estimators connect a path to a light at a vertex that scatters. From a light whose rays first meet a mirror or smooth glass no
//! vertex is ever connected, and what comes of it must be found by a direction that happens to meet the light. A light without
//! extent is never met: its caustics are missing from the picture, whatever the number of samples. An emitter that stands
//! behind glass on all sides is met by chance: the picture is right in the limit, and its error bars are not to be believed
//! before chance has done its work.
//!
//! Where light is traced from the lights (`Integrator::Caustics`), it reaches what the camera sees directly; what is missing or met by chance
//! alone is light that comes so and is then seen by a mirror or through glass.
//!
//! How much that is, is found by rays from the light, on the host: the share of them whose first hit is a mirror or smooth glass,
//! weighted by how much of the light goes on from there without being scattered. Materials are judged by their factors: what
//! textures take away is not looked up. 4,096 rays of a low-discrepancy set know a share to some 0.1 %.

use std::f64::consts::TAU;
use std::fmt::{self, Display};

use glam::{DVec2, DVec3, Vec3};
use surelight_accel::{Accel, Ray};
use surelight_scene::{AlphaMode, Camera, Light, LightKind, Material, Projection, Scene};

use super::clip::Planes;
use super::lights::AreaLight;
use super::lobes::{has_facets, is_coated};
use super::view::View;

/// Rays from a light without extent, and from all emitters together.
const RAYS: u32 = 4096;
/// Lights beyond which each has fewer rays.
const MANY: usize = 256;
/// Shares below this are not told.
const LEAST_SHARE: f64 = 0.01;
/// Emitters of whose light this much is found by chance alone are told.
const MOST_BY_CHANCE: f64 = 0.9;
/// Roughness below which lobes are deltas: α < 1e-4.
const SMOOTH: f32 = 0.01;
/// Surfaces without cover that a ray may pass.
const MOST_PASSED: u32 = 64;

/// Light that estimators cannot connect.
#[derive(Clone, Debug, PartialEq)]
pub enum Unreachable {
    /// Lights without extent: their light is missing from the picture.
    Missing {
        /// Names of the lights, or their numbers in the scene.
        lights: Vec<String>,
        /// Share of what they send onto surfaces.
        share: f64,
    },
    /// Lights without extent, where light is traced from them: what is missing is their caustics in mirrors and behind glass.
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
                    "unreachable: {} of the light of {} goes through smooth glass or by mirrors, where no path finds a light \
                     without extent, and is missing",
                    Percent(*share),
                    Names(lights)
                )
            }
            Self::SeenBehind { lights, share } => write!(
                f,
                "unreachable: light of {} that goes through smooth glass or by mirrors is missing where it is seen through glass or in mirrors again, \
                 which are {} of the picture",
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

/// Looks at every light of the scene; nothing where no surface is smooth. `area`: the emitting triangles, in camera space; `eye`: the
/// camera's, where light is traced from the lights.
pub(super) fn find(
    scene: &Scene,
    accel: &Accel,
    area: &[AreaLight],
    environment: bool,
    eye: Option<&Eye>,
) -> Vec<Unreachable> {
    let specular: Vec<f64> = scene.materials.iter().map(specular_share).collect();
    let used = |i: usize| scene.instances.iter().any(|placed| scene.meshes[placed.mesh].material == i);
    if !(0..specular.len()).any(|i| specular[i] > 0.0 && used(i)) {
        return Vec::new();
    }
    let walk = Walk { scene, accel, specular };
    let mut found = Vec::new();
    let (mut lights, mut missing, mut all) = (Vec::new(), 0.0, 0.0);
    let rays = RAYS / scene.lights.len().div_ceil(MANY).max(1) as u32;
    for (number, light) in scene.lights.iter().enumerate() {
        let (specular, met) = walk.punctual(light, rays.max(64));
        if met > 0.0 && specular / met >= LEAST_SHARE {
            lights.push(if light.name.is_empty() { format!("light {number}") } else { format!("'{}'", light.name) });
        }
        let power = super::luminance(light.intensity);
        missing += power * specular;
        all += power * met;
    }
    if let Some(eye) = eye {
        let share = walk.seen(eye);
        if !lights.is_empty() && share >= LEAST_SHARE {
            found.push(Unreachable::SeenBehind { lights, share });
        }
        // Pixels that are met by chance are not certified; the picture as a whole is not chance's.
        return found;
    }
    if !lights.is_empty() {
        found.push(Unreachable::Missing { lights, share: missing / all });
    }
    // Under an environment an emitter is not all there is, and what is met by chance is seldom dark.
    if !environment && !area.is_empty() {
        let share = walk.emitters(area);
        if share >= MOST_BY_CHANCE {
            found.push(Unreachable::ByChance { share });
        }
    }
    found
}

/// How much of the light that a surface gets goes on without being scattered; 0 where nothing about it is smooth.
fn specular_share(m: &Material) -> f64 {
    let greatest = |c: &[f32]| f64::from(c.iter().copied().fold(0.0, f32::max));
    let base = if has_facets(m) && m.roughness < SMOOTH {
        let (metallic, transmission) = (f64::from(m.metallic), f64::from(m.transmission));
        let reflected = f64::from(((m.ior - 1.0) / (m.ior + 1.0)).powi(2) * m.specular);
        let colour = greatest(&m.base_color[..3]);
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
pub(super) fn about(axis: DVec3, cosine: f64, turn: f64) -> DVec3 {
    let (x, y) = axis.any_orthonormal_pair();
    let (sin, cos) = (TAU * turn).sin_cos();
    axis * cosine + (x * cos + y * sin) * (1.0 - cosine * cosine).max(0.0).sqrt()
}

/// Rays of the picture's middle, right and upper edge, camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Eye {
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    orthographic: bool,
    planes: Planes,
}

impl Eye {
    pub(super) fn new(camera: &Camera, view: &View, planes: Planes) -> Self {
        let [origin, forward, right, up] =
            [view.origin, view.forward, view.right, view.up].map(|v| Vec3::from(v).as_dvec3());
        let orthographic = matches!(camera.projection, Projection::Orthographic { .. });
        Self { origin, forward, right, up, orthographic, planes }
    }
}

struct Walk<'a> {
    scene: &'a Scene,
    accel: &'a Accel,
    specular: Vec<f64>,
}

impl Walk<'_> {
    /// What the first surface on a ray that covers anything does; `None` where there is none. Camera space.
    fn first(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let mut ray = Ray::new(origin.as_vec3(), direction.as_vec3());
        for _ in 0..MOST_PASSED {
            let hit = self.accel.intersect(&ray)?;
            let source = &self.accel.triangles[hit.prim as usize];
            let material = self.scene.meshes[source.mesh as usize].material;
            if self.scene.materials[material].alpha_mode == AlphaMode::Opaque {
                return Some(self.specular[material]);
            }
            // Cover is not looked up: what is behind counts.
            ray.t_min = hit.t * (1.0 + 1e-5);
        }
        None
    }

    /// Of the picture, the share that shows what goes on without being scattered.
    fn seen(&self, eye: &Eye) -> f64 {
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

    /// Of a light's rays, the share that goes on without being scattered, and the share that meets anything.
    fn punctual(&self, light: &Light, rays: u32) -> (f64, f64) {
        let origin = self.accel.origin;
        let bounds = self.accel.bounds;
        let (low, high) = (bounds.lo.as_dvec3(), bounds.hi.as_dvec3());
        let (middle, radius) = ((low + high) * 0.5, 0.5 * (high - low).length());
        if !radius.is_finite() {
            return (0.0, 0.0);
        }
        let (mut specular, mut met) = (0.0, 0.0);
        for i in 0..rays {
            let u = point(i, rays);
            let (from, towards, weight) = match light.kind {
                LightKind::Point { position } => (position - origin, about(DVec3::Y, 1.0 - 2.0 * u.x, u.y), 1.0),
                LightKind::Spot { position, direction, inner, outer } => {
                    let (inner, outer) = (f64::from(inner).cos(), f64::from(outer).cos());
                    let cosine = 1.0 - u.x * (1.0 - outer);
                    let fade = ((cosine - outer) / (inner - outer).max(1e-3)).clamp(0.0, 1.0);
                    (position - origin, about(direction, cosine, u.y), fade * fade)
                }
                LightKind::Directional { direction } => {
                    let (x, y) = direction.any_orthonormal_pair();
                    let (r, (sin, cos)) = (radius * u.x.sqrt(), (TAU * u.y).sin_cos());
                    (middle + (x * cos + y * sin) * r - direction * 2.0 * radius, direction, 1.0)
                }
            };
            if let Some(share) = self.first(from, towards) {
                specular += weight * share;
                met += weight;
            }
        }
        (specular / f64::from(rays), met / f64::from(rays))
    }

    /// Of the light that emitters send onto surfaces, the share that goes on without being scattered.
    fn emitters(&self, area: &[AreaLight]) -> f64 {
        let power = |l: &AreaLight| f64::from(l.weight) * l.area();
        let total: f64 = area.iter().map(power).sum();
        if !(total > 0.0 && total.is_finite()) {
            return 0.0;
        }
        // Rays at even steps through the power, in the order of the triangles.
        let (mut specular, mut met, mut passed, mut k) = (0.0, 0.0, 0.0, 0);
        for i in 0..RAYS {
            let u = point(i, RAYS);
            while k + 1 < area.len() && passed + power(&area[k]) < u.x * total {
                passed += power(&area[k]);
                k += 1;
            }
            let light = &area[k];
            // Two more even numbers, for the point.
            let v = DVec2::new(
                (f64::from(i) * 0.754_877_666_246_693).fract(),
                (f64::from(i) * 0.569_840_290_998_053).fract(),
            );
            let v = if v.x + v.y > 1.0 && !light.is_parallelogram() { DVec2::ONE - v } else { v };
            let edges = [light.e1, light.e2].map(|e| Vec3::from(e).as_dvec3());
            let Some(normal) = edges[0].cross(edges[1]).try_normalize() else { continue };
            let at = Vec3::from(light.v0).as_dvec3() + edges[0] * v.x + edges[1] * v.y;
            let cosine = (f64::from(i) * 0.437_283_934_0).fract().sqrt();
            let direction = about(normal, cosine, u.y);
            let step = 1e-5 * (at.abs().max_element() + edges[0].length());
            if let Some(share) = self.first(at + normal * step, direction) {
                specular += share;
                met += 1.0;
            }
        }
        if met > 0.0 { specular / met } else { 0.0 }
    }
}
