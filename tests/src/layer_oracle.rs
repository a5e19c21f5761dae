//! Thin films, sheen and clear coats in f64, from the extensions' texts: KHR_materials_iridescence,
//! _sheen and _clearcoat.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, dvec3};

use crate::bsdf::Material;
use crate::bsdf_oracle::{f64s, ggx_d, ggx_g2, lobes};

/// Reflectance of the material's film over a base of this reflectance, in air.
pub(crate) fn film_reflectance(m: &Material, cos_1: f64, base_f0: DVec3) -> DVec3 {
    let (ior, thickness) = (f64::from(m.film_ior), f64::from(m.film_thickness));
    let schlick = |r0: f64, cosine: f64| r0 + (1.0 - r0) * (1.0 - cosine).powi(5);
    let normal = |a: f64, b: f64| ((a - b) / (a + b)).powi(2);
    let sin2 = (1.0 - cos_1 * cos_1) / (ior * ior);
    let cos_2 = (1.0 - sin2).sqrt();
    let r12 = schlick(normal(ior, 1.0), cos_1);
    let t121 = 1.0 - r12;
    let path = 2.0 * ior * thickness * cos_2;
    let mut terms = [DVec3::ZERO; 3];
    let mut shift = DVec3::ZERO;
    for c in 0..3 {
        let root = base_f0[c].clamp(0.0, 0.9999).sqrt();
        let base = (1.0 + root) / (1.0 - root);
        shift[c] = PI + if base < ior { PI } else { 0.0 };
        let r23 = schlick(normal(base, ior), cos_2);
        let r123 = (r12 * r23).clamp(1e-5, 0.9999);
        let rs = t121 * t121 * r23 / (1.0 - r123);
        terms[0][c] = r12 + rs;
        terms[1][c] = (rs - t121) * r123.sqrt();
        terms[2][c] = (rs - t121) * r123;
    }
    let sum =
        terms[0] + terms[1] * 2.0 * sensitivity(path, shift) + terms[2] * 2.0 * sensitivity(2.0 * path, 2.0 * shift);
    sum.clamp(DVec3::ZERO, DVec3::ONE)
}

fn sensitivity(path: f64, shift: DVec3) -> DVec3 {
    let phase = TAU * path * 1e-9;
    let gaussian = |value: f64, position: f64, variance: f64, shift: f64| {
        value * (TAU * variance).sqrt() * (position * phase + shift).cos() * (-phase * phase * variance).exp()
            / 1.0685e-7
    };
    let x = gaussian(5.4856e-13, 1.6810e6, 4.3278e9, shift.x) + gaussian(9.7470e-14, 2.2399e6, 4.5282e9, shift.x);
    let y = gaussian(4.4201e-13, 1.7953e6, 9.3046e9, shift.y);
    let z = gaussian(5.2481e-13, 2.2084e6, 6.6121e9, shift.z);
    dvec3(
        3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
        -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
        0.0556434 * x - 0.2040259 * y + 1.0572252 * z,
    )
}

/// D·V of white fibres.
fn sheen(alpha: f64, o: DVec3, i: DVec3) -> f64 {
    let (o_z, i_z) = (o.z.max(1e-3), i.z.max(1e-3));
    let cos_h = (o + i).normalize().z;
    let d = (2.0 + 1.0 / alpha) * (1.0 - cos_h * cos_h).powf(0.5 / alpha) / TAU;
    d / (4.0 * o_z * i_z * (1.0 + sheen_lambda(o_z, alpha) + sheen_lambda(i_z, alpha)))
}

fn sheen_lambda(cosine: f64, alpha: f64) -> f64 {
    let l = |x: f64| {
        let one_minus = (1.0 - alpha) * (1.0 - alpha);
        let mix = |a: f64, b: f64| a * (1.0 - one_minus) + b * one_minus;
        let a = mix(21.5473, 25.3245);
        let b = mix(3.82987, 3.32435);
        let c = mix(0.19823, 0.16801);
        let d = mix(-1.97760, -1.27393);
        let e = mix(-4.32054, -4.85967);
        a / (1.0 + b * x.powf(c)) + d * x + e
    };
    if cosine < 0.5 { l(cosine).exp() } else { (2.0 * l(0.5) - l(1.0 - cosine)).exp() }
}

/// The directional albedo of white fibres, by the midpoint rule.
pub fn sheen_albedo(alpha: f64, cosine: f64, n: usize) -> f64 {
    let o = dvec3((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine.max(1e-3));
    let mut sum = 0.0;
    for a in 0..n {
        // cosθ = t², for the steepness at the horizon.
        let t = (a as f64 + 0.5) / n as f64;
        let (z, weight) = (t * t, 2.0 * t / n as f64);
        for b in 0..n {
            let (s, c) = (PI * (b as f64 + 0.5) / n as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            sum += weight * sheen(alpha, o, dvec3(r * c, r * s, z)) * z * TAU / n as f64;
        }
    }
    sum
}

/// Values of a material with its layers. The albedos that sheen needs are computed once.
pub struct Layered {
    material: Material,
    /// At equal steps of sqrt(cosθ).
    albedos: Vec<f64>,
}

impl Layered {
    /// For one material.
    pub fn new(material: &Material) -> Self {
        let with_sheen = material.sheen_color.iter().any(|&c| c > 0.0);
        let n = if with_sheen { 400 } else { 0 };
        let alpha = f64::from(material.sheen_alpha);
        let albedos = (0..n).map(|k| sheen_albedo(alpha, (f64::from(k) / 399.0).powi(2), 96)).collect();
        Self { material: *material, albedos }
    }

    fn albedo(&self, cosine: f64) -> f64 {
        let at = cosine.clamp(1e-3, 1.0).sqrt() * 399.0;
        let k = (at as usize).min(398);
        self.albedos[k] + (self.albedos[k + 1] - self.albedos[k]) * (at - k as f64)
    }

    /// f·|cosθi| towards `wi`, delta lobes left out.
    pub fn value(&self, wi: DVec3) -> DVec3 {
        if self.material.ior_spread == 0.0 {
            return self.value_of(&self.material, wi);
        }
        // Each channel by its own index.
        DVec3::from_array([0, 1, 2].map(|c| {
            let channel = Material { eta: self.material.eta_of(c), ior_spread: 0.0, ..self.material };
            self.value_of(&channel, wi)[c]
        }))
    }

    fn value_of(&self, m: &Material, wi: DVec3) -> DVec3 {
        let (o, i) = (f64s(m.wo).normalize(), wi.normalize());
        let mut value = lobes(m, i).sum();
        if !self.albedos.is_empty() {
            let color = f64s(m.sheen_color);
            let share = color.max_element() * self.albedo(o.z).max(self.albedo(i.z.abs()));
            let fibres = if i.z > 0.0 { sheen(f64::from(m.sheen_alpha), o, i) * i.z.max(1e-3) } else { 0.0 };
            value = value * (1.0 - share).max(0.0) + color * fibres / share.max(1.0);
        }
        if m.coat > 0.0 {
            let n = f64s(m.coat_normal).normalize();
            let x = n.any_orthonormal_vector();
            let y = n.cross(x);
            let turned = |w: DVec3| dvec3(w.dot(x), w.dot(y), w.dot(n));
            let (co, ci) = (turned(o), turned(i));
            let share = f64::from(m.coat) * (0.04 + 0.96 * (1.0 - co.z.abs()).powi(5));
            let alpha = [f64::from(m.coat_alpha); 2];
            let lit = co.z > 0.0 && ci.z > 0.0 && i.z > 0.0 && m.coat_alpha >= 1e-4;
            let lobe =
                if lit { ggx_d(alpha, (co + ci).normalize()) * ggx_g2(alpha, co, ci) / (4.0 * co.z) } else { 0.0 };
            value = value.lerp(DVec3::splat(lobe), share);
        }
        value
    }

    /// Uniform light scattered into the upper and the lower hemisphere, by the midpoint rule: for
    /// broad lobes.
    pub fn albedos(&self, n: usize) -> [DVec3; 2] {
        let mut sums = [DVec3::ZERO; 2];
        for a in 0..n {
            let t = (a as f64 + 0.5) / n as f64;
            let (z, weight) = (t * t, 2.0 * t / n as f64 * TAU / n as f64);
            let r = (1.0 - z * z).sqrt();
            for b in 0..n {
                let (s, c) = (TAU * (b as f64 + 0.5) / n as f64).sin_cos();
                sums[0] += self.value(dvec3(r * c, r * s, z)) * weight;
                sums[1] += self.value(dvec3(r * c, r * s, -z)) * weight;
            }
        }
        sums
    }
}
