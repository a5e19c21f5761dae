//! The light probes: random numbers in, samples of lights out.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use surelight_prepare::Prepared;
use surelight_render::run_probe;

use crate::{random::Random, render::device};

/// `ProbeLightQuery` of shaders/probe/light.wesl.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Query {
    /// The receiving point, or the direction to evaluate.
    pub position: [f32; 3],
    /// 32 uniform bits.
    pub choice: u32,
    /// Uniform in [0, 1).
    pub u: [f32; 2],
    /// Number of the light whose probability is queried.
    pub light: u32,
    /// 1: light from behind the surface contributes, too.
    pub both_sides: u32,
    /// Of the receiving surface, unit; only a light tree uses it.
    pub normal: [f32; 3],
    /// α of its microfacets.
    pub alpha: f32,
    /// Unit, towards the viewer.
    pub viewer: [f32; 3],
    /// The share of its microfacets in all scattering.
    pub share: f32,
}

impl Query {
    /// For a direction.
    pub fn towards(direction: DVec3) -> Self {
        Self { position: direction.as_vec3().to_array(), ..Self::default() }
    }

    /// With these random numbers.
    pub fn with(position: [f32; 3], choice: u32, u: [f32; 2]) -> Self {
        Self { position, choice, u, normal: [0.0, 0.0, 1.0], viewer: [0.0, 0.0, 1.0], ..Self::default() }
    }
}

/// `ProbeLight` of shaders/probe/light.wesl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Sample {
    /// Unit.
    pub direction: [f32; 3],
    /// Solid angle.
    pub pdf: f32,
    /// Arriving; divided by the pdf for samples of the light table.
    pub radiance: [f32; 3],
    /// To the light.
    pub distance: f32,
    /// A point on the light.
    pub target: [f32; 3],
    /// The light pdf for a direction of BSDF sampling.
    pub other_pdf: f32,
}

impl Sample {
    /// The direction in f64.
    pub fn direction(&self) -> DVec3 {
        DVec3::from(self.direction.map(f64::from))
    }
}

/// Runs an entry point of shaders/probe/light.wesl.
pub fn probe(prepared: &Prepared, entry: &str, queries: &[Query]) -> Vec<Sample> {
    run_probe(device(), prepared, "package::probe::light", entry, queries, queries.len())
        .unwrap_or_else(|e| panic!("{e}"))
}

/// `n` queries with random numbers, at one position.
pub fn random_queries(position: [f32; 3], n: usize, seed: u64) -> Vec<Query> {
    let mut random = Random::new(seed);
    (0..n).map(|_| Query::with(position, (random.bits() >> 32) as u32, [random.unit(), random.unit()])).collect()
}
