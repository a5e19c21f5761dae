//! Photons travel: by delta lobes and through panes, until they land on a surface that scatters.

use std::f64::consts::PI;

use glam::DVec3;
use surelight_accel::Ray;
use surelight_scene::{AlphaMode, Material};

use super::{FlowInput, Photon, emission::Emission};
use crate::{
    lobes::{has_facets, is_coated, is_pane, mean_albedo},
    surface::Surface,
};

/// Events that a ray may have before it is given up.
const MAX_EVENTS: u32 = 32;
/// Surfaces without cover, and panes, that a ray may pass.
const MAX_PASSED: u32 = 64;
/// After so many surfaces half of the rays end at each further one (Russian roulette).
const SURE_SURFACES: u32 = 4;
/// Roughness below which lobes are deltas: α < 1e-4.
const SMOOTH: f32 = 0.01;

/// Follows a ray until it lands on a surface that scatters; `None` where it does not. `aimed`: it
/// lands after a delta event alone; otherwise with no event at all.
pub(super) fn follow(input: &FlowInput, emission: &Emission, aimed: bool, u: f64) -> Option<Photon> {
    let Emission { mut origin, mut direction, mut flux, extent, distant } = *emission;
    let (mut u, mut length, mut lobes) = (u, 0.0, 1.0);
    let (mut events, mut passed) = (0, 0);
    while events <= MAX_EVENTS && passed <= MAX_PASSED {
        if events + passed >= SURE_SURFACES {
            if u < 0.5 {
                return None;
            }
            u = 2.0 * u - 1.0;
            flux *= 2.0;
        }
        let hit = input.accel.intersect(&Ray::new(origin.as_vec3(), direction.as_vec3()))?;
        let t = f64::from(hit.t);
        length += t;
        let at = origin + direction * t;
        let surface = Facing::new(Surface::at(input.scene, input.accel, &hit), direction);
        let material = surface.material;
        if material.alpha_mode != AlphaMode::Opaque {
            passed += 1;
            origin = at + direction * input.offset(at);
            continue;
        }
        let cosine = surface.normal.dot(-direction).clamp(0.0, 1.0);
        let delta = Delta::of(material, cosine, surface.front);
        let is_pane = is_pane(material, material.roughness < SMOOTH);
        let scattered = (1.0 - delta.total()).max(0.0) * delta.rest * mean_albedo(material);
        let through = if is_pane { delta.transmitted } else { 0.0 };
        // Light that ends here, passes straight through, or continues by a delta lobe; aimed rays
        // land after a delta alone, and others have none.
        let land = if aimed == (events > 0) { scattered } else { 0.0 };
        let bounce = if aimed && events < MAX_EVENTS { delta.reflected + delta.transmitted - through } else { 0.0 };
        let (event, probability) = choose_event([land, through, bounce], &mut u)?;
        flux /= probability;
        if event == 0 {
            let solid_angle = if distant { extent } else { extent / (length * length) };
            let chance = (surface.geometric.dot(-direction).abs() / PI * solid_angle * lobes).min(1.0);
            let flux = flux * scattered;
            return Some(Photon { position: at, normal: surface.geometric, flux, chance });
        }
        if event == 1 {
            flux *= through;
            passed += 1;
        } else {
            let shares = [delta.reflected, delta.transmitted - through];
            let (lobe, probability) = choose_event(shares, &mut u)?;
            flux *= shares[lobe] / probability;
            lobes *= shares[lobe] / delta.total();
            events += 1;
            direction = if lobe == 0 {
                direction - surface.normal * (2.0 * direction.dot(surface.normal))
            } else {
                refract(direction, surface.normal, delta.eta)?
            };
        }
        // To the side that it leaves for.
        let side = if direction.dot(surface.geometric) > 0.0 { 1.0 } else { -1.0 };
        origin = at + surface.geometric * (side * input.offset(at));
    }
    None
}

/// A surface from the side of a ray that hits it.
struct Facing<'a> {
    material: &'a Material,
    /// For shading, on the ray's side.
    normal: DVec3,
    geometric: DVec3,
    front: bool,
}

impl<'a> Facing<'a> {
    fn new(surface: Surface<'a>, direction: DVec3) -> Self {
        let normal = surface.front.normalize_or_zero();
        let front = normal.dot(direction) < 0.0;
        let side = if front { 1.0 } else { -1.0 };
        let geometric = normal * side;
        // A shading normal that faces away from the viewer or from its surface is of no use.
        let is_usable = |normal: &DVec3| normal.dot(geometric) > 0.0 && normal.dot(direction) < 0.0;
        let shading = surface.shading_normal().map(|normal| normal * side).filter(is_usable);
        Self { material: surface.material, normal: shading.unwrap_or(geometric), geometric, front }
    }
}

/// Chooses an event by its share: its index, and the probability. Events of weak shares have a
/// fifth at least, so that they are chosen. `u` is uniform in [0, 1), and is again afterwards.
fn choose_event<const N: usize>(shares: [f64; N], u: &mut f64) -> Option<(usize, f64)> {
    let total: f64 = shares.iter().sum();
    let chances = shares.map(|share| if share > 0.0 { (share / total).max(0.2) } else { 0.0 });
    let sum: f64 = chances.iter().sum();
    let mut below = 0.0;
    for (event, chance) in chances.into_iter().enumerate() {
        let p = chance / sum;
        if p > 0.0 && *u < below + p {
            *u = ((*u - below) / p).clamp(0.0, 1.0 - 1e-12);
            return Some((event, p));
        }
        below += p;
    }
    None
}

/// Shares of a surface's delta lobes, by its factors.
struct Delta {
    reflected: f64,
    transmitted: f64,
    /// Index beyond over that on the ray's side; 1 for thin walls.
    eta: f64,
    /// Of what no delta takes, the share that is scattered: smooth metal and glass absorb it.
    rest: f64,
}

impl Delta {
    fn of(m: &Material, cosine: f64, front: bool) -> Self {
        let brightest = |c: &[f32]| f64::from(c.iter().copied().fold(0.0, f32::max));
        let mut delta = Self { reflected: 0.0, transmitted: 0.0, eta: 1.0, rest: 1.0 };
        if has_facets(m) && m.roughness < SMOOTH {
            let ior = if m.ior == 0.0 { 1e6 } else { f64::from(m.ior) };
            let (metallic, transmission) = (f64::from(m.metallic), f64::from(m.transmission));
            // What transmits has the exact reflectance, everything else Schlick's.
            let bends = m.volume.is_some() && transmission > 0.0;
            if bends {
                delta.eta = if front { ior } else { 1.0 / ior };
            }
            let fresnel = if transmission > 0.0 {
                fresnel(cosine, if bends { delta.eta } else { ior })
            } else {
                let f0 = ((ior - 1.0) / (ior + 1.0)).powi(2);
                f0 + (1.0 - f0) * (1.0 - cosine).powi(5)
            };
            let strength = if fresnel < 1.0 { f64::from(m.specular) } else { 1.0 };
            let dielectric = fresnel * strength;
            let colour = brightest(&m.base_color[..3]);
            delta.reflected = metallic * colour + (1.0 - metallic) * dielectric;
            delta.rest = (1.0 - metallic) * (1.0 - transmission);
            delta.transmitted = (1.0 - metallic) * (1.0 - dielectric) * transmission * colour;
        }
        if is_coated(m) && m.clearcoat.roughness < SMOOTH {
            let coat = f64::from(m.clearcoat.factor) * (0.04 + 0.96 * (1.0 - cosine).powi(5));
            delta.reflected = coat + (1.0 - coat) * delta.reflected;
            delta.transmitted *= 1.0 - coat;
        }
        delta
    }

    fn total(&self) -> f64 {
        self.reflected + self.transmitted
    }
}

/// Reflectance of a dielectric interface.
fn fresnel(cosine: f64, eta: f64) -> f64 {
    let g2 = eta * eta - 1.0 + cosine * cosine;
    if g2 <= 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    let a = (g - cosine) / (g + cosine);
    let b = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    0.5 * a * a * (1.0 + b * b)
}

/// A direction bent at an interface; `None` for total reflection.
fn refract(direction: DVec3, normal: DVec3, eta: f64) -> Option<DVec3> {
    let cosine = -direction.dot(normal);
    let g2 = eta * eta - 1.0 + cosine * cosine;
    (g2 > 0.0).then(|| ((direction + normal * (cosine - g2.sqrt())) / eta).normalize())
}
