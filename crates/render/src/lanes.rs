//! The number of pixels in flight on a device.

use surelight_prepare::KernelKey;

use crate::device::Device;

/// Lanes traced at once. GPUs need many. CPU drivers need few: with more lanes, each finishes fewer
/// samples in a dispatch of a given duration, and states are read and written more often.
const CPU_LANES_PER_THREAD: u32 = 1 << 11;
const GPU_LANES: u32 = 1 << 20;

/// Pixels along a side of the square that a lane works on.
pub(crate) fn pixels_per_side(key: &KernelKey) -> u32 {
    if key.reuses_paths() { 2 } else { 1 }
}

/// Default number of lanes traced at once; measurements can choose another.
pub(crate) fn default_lanes(device: &Device) -> u32 {
    if device.info.is_cpu { CPU_LANES_PER_THREAD.saturating_mul(driver_threads(device)) } else { GPU_LANES }
}

/// Threads of a CPU driver, which has one per core; 1 for a GPU.
pub(crate) fn driver_threads(device: &Device) -> u32 {
    if device.info.is_cpu { std::thread::available_parallelism().map_or(1, |n| n.get() as u32) } else { 1 }
}
