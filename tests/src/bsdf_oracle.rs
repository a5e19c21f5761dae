//! The material's BSDF in f64, written from the specifications' formulas rather than from the
//! shader, and its albedo by quadrature.
//!
//! glTF 2.0 appendix B; KHR_materials_specular, _ior, _transmission, _anisotropy,
//! _diffuse_transmission; Walter et al. 2007 for rough refraction. Smith's masking is written with
//! Λ and tangents, Fresnel's equations with both angles, refraction with both indices.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};

use crate::bsdf::Material;
use crate::layer_oracle::film_reflectance;

/// The lobes' values, each f·|cosθi| in radiance, delta lobes left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lobes {
    /// Lambertian base.
    pub diffuse: DVec3,
    /// Microfacet reflection.
    pub reflected: DVec3,
    /// Transmission, smaller by 1/eta² into a solid.
    pub transmitted: DVec3,
}

impl Lobes {
    /// Sum of the lobes.
    pub fn sum(&self) -> DVec3 {
        self.diffuse + self.reflected + self.transmitted
    }
}

pub(crate) fn f64s(v: [f32; 3]) -> DVec3 {
    v.map(f64::from).into()
}

/// Unpolarised Fresnel reflectance by Snell's law; 1 under total internal reflection.
pub fn fresnel_exact(cos_o: f64, eta: f64) -> f64 {
    let sin_t = (1.0 - cos_o * cos_o).max(0.0).sqrt() / eta;
    if sin_t >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let s = (cos_o - eta * cos_t) / (cos_o + eta * cos_t);
    let p = (eta * cos_o - cos_t) / (eta * cos_o + cos_t);
    (s * s + p * p) / 2.0
}

/// Reflection and transmission of light at a facet.
struct Shares {
    reflected: DVec3,
    diffuse: DVec3,
    through: DVec3,
    transmitted: DVec3,
}

/// The reflectance of a facet at this cosine, and the factors of diffuse base, diffuse transmission
/// and transmission.
fn shares(m: &Material, cosine: f64) -> Shares {
    let (f0, f90, base) = (f64s(m.f0), f64::from(m.f90), f64s(m.base_color));
    let schlick = (1.0 - cosine).max(0.0).powi(5);
    let (mut weight, mut total) = (schlick, false);
    if m.transmission > 0.0 {
        let eta = f64::from(if m.thin != 0.0 { m.ior } else { m.eta });
        let normal = fresnel_exact(1.0, eta);
        weight = (fresnel_exact(cosine, eta) - normal) / (1.0 - normal);
        total = 1.0 - cosine * cosine >= eta * eta;
    }
    let film = f64::from(m.film);
    let mut dielectric = (f0 + (DVec3::splat(f90) - f0) * weight).max(DVec3::ZERO);
    let mut metal = base + (DVec3::ONE - base) * schlick;
    if film > 0.0 {
        let within = m.transmission > 0.0 && m.thin == 0.0 && m.eta < 1.0;
        let in_air =
            if within { (1.0 - (1.0 - cosine * cosine) / f64::from(m.eta).powi(2)).max(0.0).sqrt() } else { cosine };
        dielectric = dielectric.lerp(film_reflectance(m, in_air, f0), film);
        metal = metal.lerp(film_reflectance(m, cosine, base), film);
    }
    if total {
        dielectric = DVec3::ONE;
    }
    let (metallic, transmission) = (f64::from(m.metallic), f64::from(m.transmission));
    let below = (1.0 - dielectric.max_element()) * (1.0 - metallic);
    let across = f64::from(m.diffuse_transmission);
    Shares {
        reflected: dielectric.lerp(metal, metallic),
        diffuse: base * below * (1.0 - transmission) * (1.0 - across),
        through: f64s(m.through_color) * below * (1.0 - transmission) * across,
        transmitted: base * below * transmission,
    }
}

/// α along x and y.
fn alphas(m: &Material) -> [f64; 2] {
    [f64::from(m.alpha_along), f64::from(m.alpha)]
}

/// tan²θ · α² in the azimuth of a direction.
fn slope([x, y]: [f64; 2], w: DVec3) -> f64 {
    ((w.x * x).powi(2) + (w.y * y).powi(2)) / (w.z * w.z)
}

pub(crate) fn ggx_d([x, y]: [f64; 2], h: DVec3) -> f64 {
    let cos2 = h.z * h.z;
    let tan2 = ((h.x / x).powi(2) + (h.y / y).powi(2)) / cos2;
    1.0 / (PI * x * y * cos2 * cos2 * (1.0 + tan2).powi(2))
}

/// Height-correlated masking and shadowing.
pub(crate) fn ggx_g2(alpha: [f64; 2], o: DVec3, i: DVec3) -> f64 {
    let lambda = |w: DVec3| ((1.0 + slope(alpha, w)).sqrt() - 1.0) / 2.0;
    1.0 / (1.0 + lambda(o) + lambda(i))
}

/// The facet that takes o to i, and D-free values of reflection and transmission: multiply by D.
fn facet(m: &Material, o: DVec3, i: DVec3) -> Option<(DVec3, f64)> {
    let solid_transmission = i.z < 0.0 && m.thin == 0.0;
    if !solid_transmission {
        let mirror = dvec3(i.x, i.y, i.z.abs());
        let h = (o + mirror).normalize();
        return Some((h, ggx_g2(alphas(m), o, i) / (4.0 * o.z)));
    }
    // Indices on the sides of o and i; Walter et al. 2007, equations 16 and 21.
    let (eta_o, eta_i) = (1.0, f64::from(m.eta));
    let mut h = -(eta_o * o + eta_i * i).normalize();
    if h.z < 0.0 {
        h = -h;
    }
    let (oh, ih) = (o.dot(h), i.dot(h));
    if oh <= 0.0 || ih >= 0.0 {
        return None;
    }
    // Light comes along i and leaves along o; radiance shrinks with the solid angle: η_o² / (η_i
    // (i·h) + η_o (o·h))².
    let bend = eta_o * eta_o / (eta_i * ih + eta_o * oh).powi(2);
    Some((h, (oh * ih).abs() / o.z * bend * ggx_g2(alphas(m), o, i)))
}

/// The lobes of a material from its `wo` towards `wi`.
pub fn lobes(m: &Material, wi: DVec3) -> Lobes {
    let (o, i) = (f64s(m.wo).normalize(), wi.normalize());
    let exists = o.z > 0.0 && i.z != 0.0;
    let Some((h, factor)) = facet(m, o, i).filter(|_| exists) else {
        let diffuse = if exists && i.z < 0.0 { through(m, o, i) } else { DVec3::ZERO };
        return Lobes { diffuse, ..Lobes::default() };
    };
    let at = shares(m, o.dot(h));
    let microfacets = if m.alpha < 1e-4 { 0.0 } else { ggx_d(alphas(m), h) * factor };
    if i.z > 0.0 {
        return Lobes {
            diffuse: at.diffuse * i.z / PI,
            reflected: at.reflected * microfacets,
            transmitted: DVec3::ZERO,
        };
    }
    Lobes { diffuse: through(m, o, i), reflected: DVec3::ZERO, transmitted: at.transmitted * microfacets }
}

/// The Lambertian base's diffuse transmission, weighted as for the direction mirrored to this side.
fn through(m: &Material, o: DVec3, i: DVec3) -> DVec3 {
    let h = (o + dvec3(i.x, i.y, -i.z)).normalize();
    shares(m, o.dot(h)).through * -i.z / PI
}

fn reflect(o: DVec3, h: DVec3) -> DVec3 {
    2.0 * o.dot(h) * h - o
}

fn refract(o: DVec3, h: DVec3, eta: f64) -> Option<DVec3> {
    let c = o.dot(h);
    let sin2_t = (1.0 - c * c) / (eta * eta);
    (sin2_t < 1.0).then(|| (c / eta - (1.0 - sin2_t).sqrt()) * h - o / eta)
}

/// Integrals of the lobes over wi: the light that each scatters of a uniform radiance 1.
///
/// The base by the midpoint rule over the cosine-weighted hemisphere; the microfacet lobes over all
/// normals by D·cosθ, so that D cancels and any α is as easy. `n` points in each of two dimensions.
/// For isotropic facets, and without diffuse transmission.
pub fn albedo(m: &Material, n: usize) -> Lobes {
    let o = f64s(m.wo).normalize();
    let alpha = f64::from(m.alpha);
    let mut sum = Lobes::default();
    for a in 0..n {
        let t = (a as f64 + 0.5) / n as f64;
        // Normals in terms of 1 − (1 − t)², whose density 2(1 − t) tames the tail: the integrand
        // grows like 1/cosθ there.
        let density = 2.0 * (1.0 - t);
        let tan = alpha * (1.0 - (1.0 - t) * (1.0 - t)).sqrt() / (1.0 - t);
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        for b in 0..n {
            let (s, c) = (TAU * (b as f64 + 0.5) / n as f64).sin_cos();
            let base = dvec3(t.sqrt() * c, t.sqrt() * s, (1.0 - t).sqrt());
            sum.diffuse += lobes(m, base).diffuse * PI / base.z;

            let h = dvec3(tan * cos * c, tan * cos * s, cos);
            let oh = o.dot(h);
            if oh <= 0.0 {
                continue;
            }
            // Value without D, over the density of h without D, over the density of wi against that
            // of h.
            let Shares { reflected, transmitted, .. } = shares(m, oh);
            let weight = oh * density / cos;
            let mirror = reflect(o, h);
            if mirror.z > 0.0 {
                let g = ggx_g2([alpha; 2], o, mirror) / (4.0 * o.z);
                sum.reflected += reflected * g * 4.0 * weight;
                if m.thin != 0.0 {
                    sum.transmitted += transmitted * g * 4.0 * weight;
                }
            }
            let eta = f64::from(m.eta);
            if m.transmission > 0.0 && m.thin == 0.0 {
                let Some(i) = refract(o, h, eta).filter(|i| i.z < 0.0) else { continue };
                // The rest of Walter's formula over |i·h| η_i² / (η_i (i·h) + η_o (o·h))² is
                // 1/η_i².
                sum.transmitted += transmitted * ggx_g2([alpha; 2], o, i) * weight / (o.z * eta * eta);
            }
        }
    }
    let mean = 1.0 / (n * n) as f64;
    Lobes { diffuse: sum.diffuse * mean, reflected: sum.reflected * mean, transmitted: sum.transmitted * mean }
}
