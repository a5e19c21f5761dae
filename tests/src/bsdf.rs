//! The BSDF probe: materials and directions in, evaluations and samples out.

use bytemuck::{Pod, Zeroable};
use surelight_prepare::{KernelKey, Part, sheen_albedos};

use crate::probe::{Probe, key};

/// `ProbeMaterial` of shaders/probe/bsdf.wesl: a material viewed from a direction.
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
    /// Colour of the Lambertian base's diffuse transmission.
    pub through_color: [f32; 3],
    /// Its share.
    pub diffuse_transmission: f32,
    /// Black: no sheen.
    pub sheen_color: [f32; 3],
    /// Sheen roughness².
    pub sheen_alpha: f32,
    /// Unit.
    pub coat_normal: [f32; 3],
    /// 0 … 1.
    pub coat: f32,
    /// Coat roughness².
    pub coat_alpha: f32,
    /// Strength of the thin film.
    pub film: f32,
    /// Its index.
    pub film_ior: f32,
    /// Nanometres.
    pub film_thickness: f32,
    /// α along x; `alpha` is then that along y.
    pub alpha_along: f32,
    /// How far the indices of red and blue are from `ior`.
    pub ior_spread: f32,
    /// Fills the record.
    pub unused: [f32; 2],
    /// Probabilities of red, green and blue where refraction must choose.
    pub channels: [f32; 3],
    /// Fills the record.
    pub rest: f32,
}

/// The result of [`BsdfProbe::eval`].
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

/// The result of [`BsdfProbe::sample`].
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
    /// Whether the sample is valid; otherwise its weight is 0.
    pub fn is_valid(&self) -> bool {
        self.flags as u32 & 1 != 0
    }

    /// Whether it comes from a delta lobe.
    pub fn is_delta(&self) -> bool {
        self.flags as u32 & 2 != 0
    }
}

impl Material {
    /// A white Lambertian surface (as KHR_materials_specular with strength 0), viewed at `degrees`
    /// from the normal.
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
            through_color: [1.0; 3],
            diffuse_transmission: 0.0,
            sheen_color: [0.0; 3],
            sheen_alpha: 0.25,
            coat_normal: [0.0, 0.0, 1.0],
            coat: 0.0,
            coat_alpha: 0.01,
            film: 0.0,
            film_ior: 1.3,
            film_thickness: 400.0,
            alpha_along: 1.0,
            ior_spread: 0.0,
            unused: [0.0; 2],
            channels: [0.5, 0.3, 0.2],
            rest: 0.0,
        }
    }

    /// glTF's default dielectric: index 1.5, base colour white.
    pub fn dielectric(alpha: f32, degrees: f64) -> Self {
        Self { alpha, alpha_along: alpha, f0: [0.04; 3], f90: 1.0, ..Self::lambert(degrees) }
    }

    /// A metal whose reflectance is 1.
    pub fn metal(alpha: f32, degrees: f64) -> Self {
        Self { metallic: 1.0, ..Self::dielectric(alpha, degrees) }
    }

    /// Clear glass of index 1.5 viewed from outside.
    pub fn glass(alpha: f32, degrees: f64) -> Self {
        Self { transmission: 1.0, ..Self::dielectric(alpha, degrees) }
    }

    /// Clear glass of index 1.5 viewed from within.
    pub fn glass_within(alpha: f32, degrees: f64) -> Self {
        Self { eta: 1.0 / 1.5, ..Self::glass(alpha, degrees) }
    }

    /// A thin wall of glass.
    pub fn thin(alpha: f32, degrees: f64) -> Self {
        Self { eta: 1.0, thin: 1.0, ..Self::glass(alpha, degrees) }
    }

    /// Something of everything: partly metal, partly transmitting, coloured, with a tinted and
    /// weakened reflection.
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

    /// The same under a clear coat of this α, whose normal leans a little.
    pub fn coated(self, alpha: f32) -> Self {
        let lean = (1.0_f32 - 0.1 * 0.1 - 0.2 * 0.2).sqrt();
        Self { coat: 0.8, coat_alpha: alpha, coat_normal: [0.1, -0.2, lean], ..self }
    }

    /// The same under reddish sheen.
    pub fn with_sheen(self, alpha: f32) -> Self {
        Self { sheen_color: [0.9, 0.6, 0.3], sheen_alpha: alpha, ..self }
    }

    /// The same with a thin film.
    pub fn filmed(self, thickness: f32) -> Self {
        Self { film: 0.9, film_thickness: thickness, ..self }
    }

    /// The same with facets that are rougher along x.
    pub fn brushed(self, alpha_along: f32) -> Self {
        Self { alpha_along, ..self }
    }

    /// The same with indices that differ by colour.
    pub fn dispersive(self, ior_spread: f32) -> Self {
        Self { ior_spread, ..self }
    }

    /// The index beyond the surface of a channel.
    pub fn eta_of(&self, channel: usize) -> f32 {
        let ior = self.ior + self.ior_spread * [-1.0, 0.0, 1.0][channel];
        match (self.thin != 0.0, self.eta >= 1.0) {
            (true, _) => 1.0,
            (_, true) => ior,
            _ => 1.0 / ior,
        }
    }

    /// The same, sending a share of its Lambertian part to the other side.
    pub fn translucent(self, share: f32) -> Self {
        Self { diffuse_transmission: share, through_color: [0.2, 0.5, 0.9], ..self }
    }

    /// The key of a kernel for this material alone.
    pub fn key(&self) -> KernelKey {
        let mut names = Vec::new();
        let conditions = [
            ("ggx", self.f90 > 0.0 || self.metallic > 0.0 || self.has_layers()),
            ("metal", self.metallic > 0.0),
            ("transmission", self.transmission > 0.0 || self.diffuse_transmission > 0.0),
            ("delta_lobes", self.alpha < 1e-4 || self.coat > 0.0 && self.coat_alpha < 1e-4),
            ("dispersion", self.ior_spread > 0.0),
            ("diffuse_transmission", self.diffuse_transmission > 0.0),
            ("anisotropy", self.is_brushed()),
            ("iridescence", self.film > 0.0),
            ("sheen", self.has_sheen()),
            ("clearcoat", self.coat > 0.0),
        ];
        names.extend(conditions.iter().filter(|(_, on)| *on).map(|(name, _)| *name));
        key(&names)
    }

    fn has_sheen(&self) -> bool {
        self.sheen_color.iter().any(|&c| c > 0.0)
    }

    fn is_brushed(&self) -> bool {
        self.alpha_along != self.alpha
    }

    fn has_layers(&self) -> bool {
        self.has_sheen() || self.coat > 0.0 || self.film > 0.0 || self.diffuse_transmission > 0.0
    }
}

/// Parts of metals, dielectrics and glass.
const BASE: [&str; 4] = ["ggx", "metal", "transmission", "delta_lobes"];

/// Parts of layers and lobes that extensions add.
const LAYERS: [&str; 6] = ["dispersion", "diffuse_transmission", "anisotropy", "iridescence", "sheen", "clearcoat"];

/// Where `shaders/bsdf/sheen.wesl` binds its table.
const SHEEN_BINDING: u32 = 12;

/// Both entry points of shaders/probe/bsdf.wesl, for one key.
pub struct BsdfProbe {
    eval: Entry,
    sample: Entry,
}

/// An entry point, and whether it reads the table of the sheen's albedos.
struct Entry {
    probe: Probe,
    sheen: bool,
}

impl BsdfProbe {
    /// Compiles for this key.
    pub fn new(key: &KernelKey) -> Self {
        let probe =
            |entry| Entry { probe: Probe::new("package::probe::bsdf", entry, key, &[]), sheen: key.has(Part::Sheen) };
        Self { eval: probe("probe_eval"), sample: probe("probe_sample") }
    }

    /// For everything that a base may have.
    pub fn full() -> Self {
        Self::new(&key(&BASE))
    }

    /// For everything that a material may have.
    pub fn layered() -> Self {
        Self::new(&key(&[&BASE[..], &LAYERS[..]].concat()))
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

fn run<T: Pod>(entry: &Entry, materials: &[Material], triples: &[[f32; 3]], index: impl Fn(usize) -> usize) -> Vec<T> {
    let mut results = Vec::with_capacity(triples.len());
    for (chunk, start) in triples.chunks(1 << 20).zip((0..).step_by(1 << 20)) {
        let queries: Vec<[f32; 4]> =
            chunk.iter().zip(start..).map(|(&[x, y, z], i)| [x, y, z, index(i) as f32]).collect();
        let inputs = [bytemuck::cast_slice(materials), bytemuck::cast_slice(&queries)];
        let table = (SHEEN_BINDING, bytemuck::cast_slice(sheen_albedos()));
        let more = if entry.sheen { std::slice::from_ref(&table) } else { &[] };
        results.extend(entry.probe.run_with::<T>(&inputs, more, chunk.len(), chunk.len()));
    }
    results
}

/// Uniform numbers in [0, 1) on a 24-bit grid, as the kernels make them, from SplitMix64 (Steele,
/// Lea & Flood 2014).
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
