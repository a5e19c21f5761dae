//! Records that host and kernels exchange about a pass.

pub(crate) use surelight_prepare::shared::{Control, EmissionPass, FeaturePixel, Pass, WORKGROUP_LANES as GROUP};

/// Whole batches of samples of every pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BatchRange {
    /// Number of the first batch; with one sequence, number of its first sample.
    pub(crate) first: u32,
    /// Batches.
    pub(crate) batches: u32,
    /// Samples per pixel in each.
    pub(crate) samples: u32,
}

/// A pass that starts no sample. Drivers compile at the first dispatch.
pub(crate) fn warm_up(threads: u32) -> Pass {
    Pass { size: [8, 8], samples: 1, lanes: GROUP * threads, threads, restart: 1, walks: 1, ..Pass::default() }
}

// The film and the kernel have the same record of a batch.
const _: () = {
    use std::mem::offset_of;
    use surelight_film::BatchSum;
    use surelight_prepare::shared::BatchRecord;
    assert!(size_of::<BatchSum>() == size_of::<BatchRecord>());
    assert!(offset_of!(BatchSum, tail) == offset_of!(BatchRecord, tail));
};
