//! The cost of a path: renderers traced in turn, so that a machine that drifts favours none.

use std::time::Instant;

use surelight_film::Film;
use surelight_render::{RenderError, Renderer};

use crate::conditions::{cpu_seconds, threads};

/// Nanoseconds per path, for each renderer and round, by the device's clock; with a software driver
/// by CPU seconds divided by the number of cores, which other work on the machine affects less. All
/// renderers must have `size` pixels. A round takes about `seconds` per renderer; one additional
/// round before them warms up.
///
/// # Errors
/// Where the device fails.
pub fn race_paths(
    renderers: &mut [Renderer<'_>],
    size: [u32; 2],
    rounds: u32,
    seconds: f64,
    software: bool,
) -> Result<Vec<Vec<f64>>, RenderError> {
    let mut times = vec![Vec::new(); renderers.len()];
    let mut samples = vec![1; renderers.len()];
    for round in 0..=rounds {
        for (i, renderer) in renderers.iter_mut().enumerate() {
            let mut film = Film::new(size[0], size[1]);
            let (counts, cpu, wall) = (renderer.counts, cpu_seconds(), Instant::now());
            renderer.trace(&mut film, round, 1, samples[i], &mut |_| true)?;
            let on_device = renderer.counts.device_seconds - counts.device_seconds;
            let spent = match (software, cpu, cpu_seconds()) {
                (true, Some(before), Some(after)) => (after - before) / threads() as f64,
                _ => on_device,
            };
            let paths = (renderer.counts.paths - counts.paths) as f64;
            if round == 0 {
                let share = seconds / wall.elapsed().as_secs_f64().max(1e-4);
                samples[i] = share.clamp(1.0, 1024.0) as u32;
            } else {
                times[i].push(1e9 * spent / paths);
            }
        }
    }
    Ok(times)
}

/// The median of some figures; NaN of none.
pub fn median(figures: &[f64]) -> f64 {
    let mut sorted = figures.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len();
    match n {
        0 => f64::NAN,
        _ => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_found() {
        assert_eq!((median(&[3.0, 1.0, 2.0]), median(&[4.0, 1.0, 2.0, 3.0])), (2.0, 2.5));
        assert!(median(&[]).is_nan());
    }
}
