//! Tracing until error bars are narrow enough, with a valid confidence.
//!
//! A render that checks its error bar after every sample stops when the error bar happens to be too
//! narrow (optional stopping). Here the number of samples does not depend on the samples in the
//! film:
//!
//! - a *pilot* of 64 samples per pixel estimates how many are needed, and is discarded;
//! - that many are traced, 256 at least, and checked once, at nearly the requested confidence;
//! - where the pilot was too optimistic, the number is doubled as often as necessary. Check k has
//!   the confidence 1 − α_k with Σ α_k ≤ α: 4/5 of α for the first, 1/5 · 2^(1−k) of it for each
//!   further one. By the union bound the confidence holds at whichever check it ends (Bonferroni;
//!   the spending of α as in group-sequential tests, Lan & DeMets 1983).

use surelight_film::{Film, Precision};
use surelight_prepare::Batches;

use crate::{
    error::RenderError,
    pacing::{Outcome, Progression, Watch},
    sampling::Position,
};

/// Default maximum of samples per pixel: an image that is not precise enough by then ends, too.
const MAX_SPP: u32 = 1 << 16;

/// Samples per pixel before the first check: enough that a pixel where one path in a hundred finds
/// light has found some.
const MIN_SPP: u32 = 256;

/// Batches of the pilot, and the samples of each.
const PILOT: [u32; 2] = [16, 4];

/// The first batch of the pilot: a number that no render reaches, so that its samples are
/// independent of the film's.
const PILOT_BATCH: u32 = 1 << 31;

/// The maximum fraction of the remaining time that the pilot may take.
const PILOT_TIME_SHARE: f64 = 0.125;

/// Safety factor on the pilot's noisy estimate.
const MARGIN: f64 = 1.1;

/// The share of α that check `k` (from 0) spends.
fn spent(k: i32) -> f64 {
    if k == 0 { 0.8 } else { 0.2 * 0.5f64.powi(k) }
}

/// Traces until the precision is reached or `max_spp`, time or the observer end it.
pub(crate) fn render(
    progression: &mut Progression<'_, '_, '_>,
    film: &mut Film,
    precision: &Precision,
    max_spp: Option<u32>,
    observer: &mut Watch<'_>,
) -> Result<Outcome, RenderError> {
    let max = max_spp.unwrap_or(MAX_SPP);
    let found = match progression.pacing.found {
        Some(found) => found,
        None => {
            let Some(needed) = pilot(progression, film, precision, observer)? else {
                // Interrupted before the first sample: one sample per pixel is better than no
                // image.
                progression.plan = Batches { planned: Some(1) };
                progression.advance(film, Some(1), &mut |_| true)?;
                return Ok(Outcome::Interrupted);
            };
            let first = (needed.max(f64::from(MIN_SPP)) as u32).min(max);
            // At least sixteen batches in the remaining time, and complete ones only: short ones
            // widen intervals.
            let affordable = progression.pacing.affordable_spp().map_or(first, |spp| first.min(spp));
            let full = Batches { planned: Some(affordable) }.full(0);
            [affordable, first.div_ceil(full).saturating_mul(full)]
        }
    };
    progression.pacing.found = Some(found);
    progression.plan = Batches { planned: Some(found[0]) };
    let first = found[1].min(max);
    let mut until = first;
    for check in 0.. {
        // An earlier run has checked here and continued.
        if progression.position.sample > until && until < max {
            until = first.saturating_mul(1 << (check + 1).min(31)).min(max);
            continue;
        }
        if let Some(outcome) = progression.advance(film, Some(until), observer)? {
            return Ok(outcome);
        }
        let here = Precision { confidence: 1.0 - (1.0 - precision.confidence) * spent(check), ..*precision };
        let reach = here.reach(film, &film.certify());
        if here.is_reached(&reach) {
            return Ok(Outcome::Done);
        }
        if until >= max {
            break;
        }
        until = first.saturating_mul(1 << (check + 1).min(31)).min(max);
    }
    Ok(Outcome::SamplesUp)
}

/// Samples per pixel that the precision needs; `None` where the observer stopped it.
fn pilot(
    progression: &mut Progression<'_, '_, '_>,
    film: &Film,
    precision: &Precision,
    observer: &mut Watch<'_>,
) -> Result<Option<f64>, RenderError> {
    let [batches, samples] = PILOT;
    let mut found = Film::of_window(film.window());
    if let Some(features) = film.features() {
        // Determines the pixels that light can reach.
        found.set_features(features.clone())?;
    }
    let position = progression.position;
    progression.pacing.is_pilot = true;
    progression.position = Position { sample: 0, batch: PILOT_BATCH };
    progression.plan = Batches { planned: Some(batches) };
    // Single samples first: their time determines the size of the other batches.
    let mut outcome = progression.advance(&mut found, Some(2), observer)?;
    let began = progression.pacing.started.elapsed().as_secs_f64() / 2.0;
    let affordable =
        progression.pacing.seconds_left().map_or(f64::INFINITY, |left| PILOT_TIME_SHARE * left / began.max(1e-6));
    let each = samples.min((affordable / f64::from(batches)) as u32).max(1);
    if outcome.is_none() {
        progression.plan = Batches { planned: Some(batches * each) };
        outcome = progression.advance(&mut found, Some(batches * each), observer)?;
    }
    let spp = progression.position.sample;
    progression.pacing.is_pilot = false;
    progression.position = position;
    match outcome {
        Some(Outcome::Interrupted) => Ok(None),
        _ => {
            let reachable = found.reachable();
            let narrowed = precision.half_width(&found, &reachable, &reachable) / precision.error;
            Ok(Some(MARGIN * f64::from(spp) * narrowed * narrowed))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_checks_together_spend_no_more_than_alpha() {
        let all: f64 = (0..60).map(spent).sum();
        assert!(all <= 1.0 && all > 0.999, "{all}");
    }
}
