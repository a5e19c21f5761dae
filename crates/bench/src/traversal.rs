//! The fraction of the device's time that traversal of the BVH takes.
//!
//! The kernel is a single one, and no clock can be read within it. But it can traverse every ray
//! twice: the image stays the same, and the additional time is that of traversal. The rest is
//! shading, sampling, and saving states between dispatches.

use surelight_prepare::{Instrument, Prepared};
use surelight_render::{Device, RenderError, Renderer, instrument};

use crate::{
    analysis::Interval,
    data::{Clock, WalkData},
    method::Method,
    tracer::{Run, Subject},
};

/// Pairs of measurements, with one traversal and with two.
const ROUNDS: u32 = 5;

/// Approximate seconds of a measurement.
const SECONDS: f64 = 0.3;

/// The stream of batches of these runs.
const STREAM: u32 = u16::MAX as u32 - 1;

/// Measures the fraction for a method; `None` where `go_on` stopped it.
pub(crate) fn measure(
    device: &Device,
    subject: &Subject,
    method: &Method,
    clock: Clock,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Option<WalkData>, RenderError> {
    let settings = method.settings(&subject.settings);
    let prepared = Prepared::new(&subject.scene, &subject.camera, &settings)?;
    let prepared = prepared.instrumented(Instrument::RepeatedTraversal);
    let mut renderer = Renderer::new(device, &prepared)?;
    let mut run = Run::new(&settings, STREAM, &renderer);
    run.grow_to(&mut renderer, 1, Some(1), go_on)?;
    let samples = (SECONDS / run.wall_seconds().max(1e-4)).clamp(1.0, 256.0) as u32;
    let mut shares = Vec::new();
    for _ in 0..ROUNDS {
        let mut seconds = [0.0; 2];
        for traversals in [1, 2] {
            instrument::set_traversals_per_ray(&mut renderer, traversals);
            let before = run.seconds(clock);
            if !run.grow_to(&mut renderer, run.spp() + samples, Some(samples.min(16)), go_on)? {
                return Ok(None);
            }
            seconds[traversals as usize - 1] = run.seconds(clock) - before;
        }
        shares.push(seconds[1] / seconds[0].max(1e-9) - 1.0);
    }
    let share = Interval::of(&shares);
    Ok(share.map(|share| WalkData { method: method.name(), share: share.value, low: share.low, high: share.high }))
}
