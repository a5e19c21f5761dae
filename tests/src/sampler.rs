//! The sampler probe: which number of which sample of which pixel in, the number out.

use bytemuck::{Pod, Zeroable};

use crate::probe::{Probe, key};

/// `ProbePoint` of shaders/probe/sampler.wesl.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Query {
    /// Number in the picture.
    pub pixel: u32,
    /// Batch.
    pub replicate: u32,
    /// Within the batch.
    pub index: u32,
    /// Samples of the batch.
    pub count: u32,
    /// Of the picture.
    pub seed: u32,
    /// Pair of dimensions.
    pub pair: u32,
    /// Made a number in [0, 1) by themselves.
    pub bits: u32,
    /// Fills the record.
    pub unused: u32,
}

/// The kernel's answer to a query.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Point {
    /// Fractions of 2^32.
    pub bits: [u32; 2],
    /// The number outside the sequences.
    pub single: f32,
    /// Of [`Query::bits`].
    pub unit: f32,
}

impl Point {
    /// The point in [0, 1)².
    pub fn unit_square(&self) -> [f64; 2] {
        self.bits.map(|b| f64::from(b) / 4_294_967_296.0)
    }
}

/// Parts that choose each sampler, with its name.
pub const SAMPLERS: [(&str, &[&str]); 3] =
    [("Sobol", &[]), ("independent", &["sampler_independent"]), ("stratified", &["sampler_stratified"])];

/// Queries the sampler that these parts choose.
pub fn sample(names: &[&str], queries: &[Query]) -> Vec<Point> {
    let probe = Probe::new("package::probe::sampler", "probe_sampler", &key(names), &[]);
    let chunks = queries.chunks(1 << 20);
    chunks.flat_map(|chunk| probe.run::<Point>(&[bytemuck::cast_slice(chunk)], chunk.len(), chunk.len())).collect()
}
