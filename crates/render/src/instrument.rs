//! For measurements and tests: choices of how a renderer works, none of which changes the image.

use std::time::Duration;

use surelight_prepare::Prepared;

use crate::{
    device::Device,
    error::RenderError,
    kernel::Checks,
    renderer::{Options, Renderer},
};

/// A renderer whose kernels check accesses to memory, or do not.
pub fn with_checks<'a>(device: &'a Device, prepared: &Prepared, checks: Checks) -> Result<Renderer<'a>, RenderError> {
    Renderer::with_options(device, prepared, Options { checks, ..Options::default() })
}

/// A renderer that traces about so many lanes at once: a row of 8×8 blocks at least.
pub fn with_lanes<'a>(device: &'a Device, prepared: &Prepared, lanes: u32) -> Result<Renderer<'a>, RenderError> {
    Renderer::with_options(device, prepared, Options { lanes: Some(lanes), ..Options::default() })
}

/// Traverses every ray so many times from here on, where the kernel was made with
/// [`surelight_prepare::Instrument::RepeatedTraversal`]. The additional time is that of traversal.
pub fn set_traversals_per_ray(renderer: &mut Renderer<'_>, count: u32) {
    renderer.accumulator.traversals_per_ray = count.max(1);
}

/// How long a dispatch should last, at least and at most, as far as the remaining work and the
/// limit on a lane's iterations allow.
pub fn set_dispatch_durations(renderer: &mut Renderer<'_>, min: Duration, max: Duration) {
    renderer.accumulator.set_dispatch_durations(min, max);
}
