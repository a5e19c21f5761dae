//! How many pixels a device works on at once.

use surelight_prepare::KernelKey;

use crate::device::Device;

/// Lanes traced at once. GPUs need many. CPU drivers need few: the more there are, the fewer
/// samples each has in a dispatch of a given length, and the more often their states are read and
/// written.
const CPU_LANES_PER_THREAD: u32 = 1 << 11;
const GPU_LANES: u32 = 1 << 20;

/// Pixels along a side of the square that a lane works on.
pub(crate) fn pixels_per_side(key: &KernelKey) -> u32 {
    if key.reuses_paths() { 2 } else { 1 }
}

/// Lanes that are traced at once unless a measurement chooses others.
pub(crate) fn default_lanes(device: &Device) -> u32 {
    if device.info.is_cpu { CPU_LANES_PER_THREAD.saturating_mul(driver_threads(device)) } else { GPU_LANES }
}

/// Threads of a CPU driver, which makes one for each core; 1 for a GPU.
pub(crate) fn driver_threads(device: &Device) -> u32 {
    if device.info.is_cpu { std::thread::available_parallelism().map_or(1, |n| n.get() as u32) } else { 1 }
}
