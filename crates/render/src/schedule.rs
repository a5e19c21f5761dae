//! How work is cut for a device: which path kernel, how many lanes at once; and what is counted of it.

use surelight_prepare::KernelKey;

use crate::device::Device;

/// Entry point of both path kernels.
pub(crate) const PATH_ENTRY: &str = "trace_paths";

/// Lanes traced at once. GPUs need many. CPU drivers need few: the more there are, the fewer samples each has in a dispatch of
/// a given length, and the more often their states are read and written.
const CPU_LANES_A_THREAD: u32 = 1 << 11;
const GPU_LANES: u32 = 1 << 20;

/// What has been done so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Rays walked: camera, bounce and shadow rays.
    pub rays: u64,
    /// Samples finished: each is one path from the camera.
    pub paths: u64,
    /// Particles sent from lights that have come to their end.
    pub particles: u64,
    /// Samples that were not finite, left out of the sums.
    pub dropped: u64,
    /// Rays whose walk was cut short at 32,768 steps, their samples incomplete.
    pub truncated: u64,
    /// Seconds of dispatches, waiting included.
    pub trace_seconds: f64,
    /// Seconds of dispatches by the device's own clock; those of waiting where it has none ([`crate::AdapterInfo::timestamps`]).
    pub device_seconds: f64,
    /// Seconds of bringing sums from the device.
    pub read_seconds: f64,
    /// Seconds of adding them to the film.
    pub film_seconds: f64,
    /// Dispatches.
    pub dispatches: u64,
}

/// Asked between dispatches: whether to go on.
pub type Observer<'a> = dyn FnMut(&Counts) -> bool + 'a;

/// Pixels along a side of the square that a lane works on.
pub(crate) fn side(key: &KernelKey) -> u32 {
    if key.reuses_paths() { 2 } else { 1 }
}

/// Lanes that are traced at once unless somebody chooses.
pub(crate) fn usual_lanes(device: &Device) -> u32 {
    if device.info.is_cpu { CPU_LANES_A_THREAD.saturating_mul(cpu_threads()) } else { GPU_LANES }
}

/// Threads of a CPU driver: it makes one for each core.
pub(crate) fn cpu_threads() -> u32 {
    std::thread::available_parallelism().map_or(1, |n| n.get() as u32)
}
