//! Records that host and kernels exchange about a pass.

use bytemuck::{Pod, Zeroable};

/// Pixels of a workgroup: 8 × 8.
pub(crate) const GROUP: u32 = 64;

/// As `Pass` in `shaders/kernel/lanes.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Pass {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) first_batch: u32,
    pub(crate) batches: u32,
    pub(crate) samples: u32,
    pub(crate) budget: u32,
    pub(crate) lanes: u32,
    pub(crate) threads: u32,
    pub(crate) restart: u32,
    pub(crate) walks: u32,
}

impl Pass {
    /// A pass that starts no sample. Drivers compile at the first dispatch.
    pub(crate) fn warm_up(threads: u32) -> Self {
        Self { size: [8, 8], samples: 1, lanes: GROUP * threads, threads, restart: 1, walks: 1, ..Self::default() }
    }
}

/// As `EmissionPass` in `shaders/kernel/emit.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct EmissionPass {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) replicate: u32,
    pub(crate) sequence: u32,
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) length: u32,
    pub(crate) budget: u32,
    pub(crate) lanes: u32,
    pub(crate) restart: u32,
    pub(crate) worth: f32,
    pub(crate) quantum: f32,
    pub(crate) square_quantum: f32,
    pub(crate) unused: u32,
}

/// As `Control` in `shaders/kernel/lanes.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub(crate) struct Control {
    pub(crate) workgroups: u32,
    pub(crate) unfinished: u32,
    pub(crate) rays: u32,
    pub(crate) paths: u32,
    pub(crate) dropped: u32,
    pub(crate) truncated: u32,
}

/// As `Feature` in `shaders/kernel/features.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct FeaturePixel {
    pub(crate) albedo: [f32; 3],
    pub(crate) depth: f32,
    pub(crate) normal: [f32; 3],
    pub(crate) unused: f32,
}

/// Whole batches of samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BatchRange {
    /// Number of the first batch; with one sequence, of its first sample.
    pub(crate) first: u32,
    /// Batches.
    pub(crate) batches: u32,
    /// Samples per pixel in each.
    pub(crate) samples: u32,
}
