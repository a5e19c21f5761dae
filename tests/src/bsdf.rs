//! The BSDF probe: materials and directions in, evaluations and samples out.

use bytemuck::{Pod, Zeroable};
use surelight_render::Features;

use crate::probe::{Probe, features};

/// `ProbeMaterial` of shaders/probe/bsdf.wesl: a material seen from a direction.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Material {
    /// Linear base colour.
    pub base_color: [f32; 3],
    /// roughness².
    pub alpha: f32,
    /// Dielectric reflectance at normal incidence, with its strength and colour.
    pub f0: [f32; 3],
    /// Dielectric reflectance at grazing incidence.
    pub f90: f32,
    /// Towards the viewer, in the frame of the normal.
    pub wo: [f32; 3],
    /// 0 … 1.
    pub metallic: f32,
    /// 0 … 1.
    pub transmission: f32,
    /// Index beyond the surface over that on wo's side; 1 for a thin wall.
    pub eta: f32,
    /// Index of the material.
    pub ior: f32,
    /// 1 for a thin wall.
    pub thin: f32,
}

/// What [`BsdfProbe::eval`] returns.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Eval {
    /// f·|cosθi|, without delta lobes.
    pub value: [f32; 3],
    /// Solid angle.
    pub pdf: f32,
    /// The albedo layer's estimate.
    pub albedo: [f32; 3],
    /// 1 when every lobe is a delta.
    pub is_delta: f32,
}

/// What [`BsdfProbe::sample`] returns.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Sample {
    /// Sampled direction.
    pub wi: [f32; 3],
    /// Solid angle; 0 for a delta lobe.
    pub pdf: f32,
    /// f·|cosθi| / pdf.
    pub weight: [f32; 3],
    flags: f32,
}

impl Sample {
    /// Whether the sample counts; otherwise it is worth 0.
    pub fn is_valid(&self) -> bool {
        self.flags as u32 & 1 != 0
    }

    /// Whether it comes from a delta lobe.
    pub fn is_delta(&self) -> bool {
        self.flags as u32 & 2 != 0
    }
}

impl Material {
    /// A white Lambertian surface (as KHR_materials_specular with strength 0), seen at `degrees` from the normal.
    pub fn lambert(degrees: f64) -> Self {
        let (s, c) = degrees.to_radians().sin_cos();
        Self {
            base_color: [1.0; 3],
            alpha: 1.0,
            f0: [0.0; 3],
            f90: 0.0,
            // Off the x axis, so that nothing is right by symmetry alone.
            wo: [(s * 0.8) as f32, (s * 0.6) as f32, c as f32],
            metallic: 0.0,
            transmission: 0.0,
            eta: 1.5,
            ior: 1.5,
            thin: 0.0,
        }
    }

    /// glTF's default dielectric: index 1.5, base colour white.
    pub fn dielectric(alpha: f32, degrees: f64) -> Self {
        Self { alpha, f0: [0.04; 3], f90: 1.0, ..Self::lambert(degrees) }
    }

    /// A metal whose reflectance is 1.
    pub fn metal(alpha: f32, degrees: f64) -> Self {
        Self { metallic: 1.0, ..Self::dielectric(alpha, degrees) }
    }

    /// Clear glass of index 1.5 seen from outside.
    pub fn glass(alpha: f32, degrees: f64) -> Self {
        Self { transmission: 1.0, ..Self::dielectric(alpha, degrees) }
    }

    /// Clear glass of index 1.5 seen from within.
    pub fn glass_within(alpha: f32, degrees: f64) -> Self {
        Self { eta: 1.0 / 1.5, ..Self::glass(alpha, degrees) }
    }

    /// A thin wall of glass.
    pub fn thin(alpha: f32, degrees: f64) -> Self {
        Self { eta: 1.0, thin: 1.0, ..Self::glass(alpha, degrees) }
    }

    /// Something of everything: partly metal, partly transmitting, coloured, with a tinted and weakened reflection.
    pub fn medley(alpha: f32, degrees: f64) -> Self {
        Self {
            base_color: [0.9, 0.5, 0.1],
            f0: [0.05, 0.02, 0.01],
            f90: 0.8,
            metallic: 0.3,
            transmission: 0.6,
            ..Self::dielectric(alpha, degrees)
        }
    }

    /// The features that a kernel for this material alone has.
    pub fn features(&self) -> Features {
        let mut names = Vec::new();
        let conditions = [
            ("ggx", self.f90 > 0.0 || self.metallic > 0.0),
            ("metal", self.metallic > 0.0),
            ("transmission", self.transmission > 0.0),
            ("delta_lobes", self.alpha < 1e-4),
        ];
        names.extend(conditions.iter().filter(|(_, on)| *on).map(|(name, _)| *name));
        features(&names)
    }
}

/// Both entry points of shaders/probe/bsdf.wesl, for one set of features.
pub struct BsdfProbe {
    eval: Probe,
    sample: Probe,
}

impl BsdfProbe {
    /// Compiles for these features.
    pub fn new(features: &Features) -> Self {
        let probe = |entry| Probe::new("package::probe::bsdf", entry, features, &[]);
        Self { eval: probe("probe_eval"), sample: probe("probe_sample") }
    }

    /// For everything that a scene may have.
    pub fn full() -> Self {
        Self::new(&features(&["ggx", "metal", "transmission", "delta_lobes"]))
    }

    /// Evaluates one material towards each direction.
    pub fn eval(&self, material: &Material, directions: &[[f32; 3]]) -> Vec<Eval> {
        run(&self.eval, std::slice::from_ref(material), directions, |_| 0)
    }

    /// Evaluates the i-th material towards the i-th direction.
    pub fn eval_each(&self, materials: &[Material], directions: &[[f32; 3]]) -> Vec<Eval> {
        run(&self.eval, materials, directions, |i| i)
    }

    /// Samples one material with each (u_lobe, u).
    pub fn sample(&self, material: &Material, u: &[[f32; 3]]) -> Vec<Sample> {
        run(&self.sample, std::slice::from_ref(material), u, |_| 0)
    }
}

fn run<T: Pod>(probe: &Probe, materials: &[Material], triples: &[[f32; 3]], index: impl Fn(usize) -> usize) -> Vec<T> {
    let mut results = Vec::with_capacity(triples.len());
    for (chunk, start) in triples.chunks(1 << 20).zip((0..).step_by(1 << 20)) {
        let queries: Vec<[f32; 4]> =
            chunk.iter().zip(start..).map(|(&[x, y, z], i)| [x, y, z, index(i) as f32]).collect();
        let inputs = [bytemuck::cast_slice(materials), bytemuck::cast_slice(&queries)];
        results.extend(probe.run::<T>(&inputs, chunk.len(), chunk.len()));
    }
    results
}

/// Uniform numbers in [0, 1) on a 24-bit grid, as the kernels make them, from SplitMix64 (Steele, Lea & Flood 2014).
pub fn uniforms(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 40) as f32 / 16_777_216.0
    };
    (0..count).map(|_| [next(), next(), next()]).collect()
}

/// The direction at (φ, cosθ), uniform over the sphere when both are.
pub fn direction(phi: f64, cosine: f64) -> [f32; 3] {
    let s = (1.0 - cosine * cosine).max(0.0).sqrt();
    [(s * phi.cos()) as f32, (s * phi.sin()) as f32, cosine as f32]
}

/// Directions spread uniformly over the whole sphere.
pub fn sphere_directions(count: usize, seed: u64) -> Vec<[f32; 3]> {
    let tau = std::f64::consts::TAU;
    uniforms(count, seed).iter().map(|u| direction(tau * f64::from(u[0]), 1.0 - 2.0 * f64::from(u[1]))).collect()
}
