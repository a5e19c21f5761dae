//! Options of a renderer for measurements and tests. None changes the image.

use std::time::Duration;

use surelight_prepare::Prepared;

use crate::{
    device::Device,
    error::RenderError,
    kernel::Checks,
    renderer::{Options, Renderer},
};

/// A renderer whose kernels have or lack bounds checks on memory accesses.
pub fn with_checks<'a>(device: &'a Device, prepared: &Prepared, checks: Checks) -> Result<Renderer<'a>, RenderError> {
    Renderer::with_options(device, prepared, Options { checks, ..Options::default() })
}

/// A renderer that traces about this many lanes at once, at least a row of 8×8 blocks.
pub fn with_lanes<'a>(device: &'a Device, prepared: &Prepared, lanes: u32) -> Result<Renderer<'a>, RenderError> {
    Renderer::with_options(device, prepared, Options { lanes: Some(lanes), ..Options::default() })
}

/// Sets how many times every ray is traversed from now on, where the kernel was made with
/// [`surelight_prepare::Instrument::RepeatedTraversal`]. The additional time is that of traversal.
pub fn set_traversals_per_ray(renderer: &mut Renderer<'_>, count: u32) {
    renderer.accumulator.traversals_per_ray = count.max(1);
}

/// Sets the target range for the duration of a dispatch, as far as the remaining work and the limit
/// on a lane's iterations allow.
pub fn set_dispatch_durations(renderer: &mut Renderer<'_>, min: Duration, max: Duration) {
    renderer.accumulator.set_dispatch_durations(min, max);
}
