//! Tracing until error bars are narrow enough, without fooling oneself.
//!
//! Who looks at an error bar again and again and stops when it pleases, stops when it happens to be too narrow. Here the number of
//! samples does not depend on those that count:
//!
//! - a *pilot* of 64 samples a pixel tells how many are needed, and is thrown away;
//! - that many are traced, 256 at least, and looked at: once, and nearly at the confidence asked for;
//! - where the pilot was too hopeful, the number is doubled as often as it takes. Look k has
//!   the confidence 1 − α_k with Σ α_k ≤ α: 4/5 of α for the first, 1/5 · 2^(1−k) of it for each further one. By the union bound the promise holds at
//!   whichever look it ends (Bonferroni; the spending of α as in group-sequential tests, Lan & DeMets 1983).

use surelight_film::{Film, Precision};

use surelight_prepare::Batches;

use crate::{
    error::RenderError,
    progression::{Outcome, Progression, Watch},
};

/// Samples a pixel after which even a picture that is not precise enough ends, unless the goal names another number.
const MOST_SPP: u32 = 1 << 16;

/// Fewer are never believed: a pixel whose light comes one time in a hundred must have been hit.
const LEAST_SPP: u32 = 256;

/// Batches of the pilot, and the samples of each.
const PILOT: [u32; 2] = [16, 4];

/// The pilot's batches have numbers that no render comes to, so its samples are others.
const PILOT_BATCH: u32 = 1 << 31;

/// Of the time there is, what the pilot may take.
const PILOT_TIME: f64 = 0.125;

/// On what the pilot says, since it may be wrong by chance.
const MARGIN: f64 = 1.1;

/// Of all that may go wrong, the share that look `k` (from 0) may.
fn spent(k: i32) -> f64 {
    if k == 0 { 0.8 } else { 0.2 * 0.5f64.powi(k) }
}

/// Traces until the precision is reached or `most_spp`, time or the observer end it.
pub(crate) fn render(
    progression: &mut Progression<'_, '_, '_>,
    film: &mut Film,
    precision: &Precision,
    most_spp: Option<u32>,
    observer: &mut Watch<'_>,
) -> Result<Outcome, RenderError> {
    let most = most_spp.unwrap_or(MOST_SPP);
    let found = match progression.found {
        Some(found) => found,
        None => {
            let Some(wanted) = pilot(progression, film, precision, observer)? else {
                // Interrupted before there was anything: one sample a pixel is better than no picture.
                progression.plan = Batches { planned: Some(1) };
                progression.advance(film, Some(1), &mut |_| true)?;
                return Ok(Outcome::Interrupted);
            };
            let first = (wanted.max(f64::from(LEAST_SPP)) as u32).min(most);
            // Sixteen batches at least in the time there is, and whole ones only: short ones make intervals wider.
            let affordable = progression.affordable_spp().map_or(first, |spp| first.min(spp));
            let full = Batches { planned: Some(affordable) }.full(0);
            [affordable, first.div_ceil(full).saturating_mul(full)]
        }
    };
    progression.found = Some(found);
    progression.plan = Batches { planned: Some(found[0]) };
    let first = found[1].min(most);
    let mut until = first;
    for look in 0.. {
        // An earlier run has looked here before it went on, and was not content.
        if progression.spp > until && until < most {
            until = first.saturating_mul(1 << (look + 1).min(31)).min(most);
            continue;
        }
        if let Some(outcome) = progression.advance(film, Some(until), observer)? {
            return Ok(outcome);
        }
        let here = Precision { confidence: 1.0 - (1.0 - precision.confidence) * spent(look), ..*precision };
        let reach = here.reach(film, &film.certify());
        if here.is_reached(&reach) {
            return Ok(Outcome::Done);
        }
        if until >= most {
            break;
        }
        until = first.saturating_mul(1 << (look + 1).min(31)).min(most);
    }
    Ok(Outcome::SamplesUp)
}

/// Samples a pixel that the precision will take; `None` where the observer stopped it.
fn pilot(
    progression: &mut Progression<'_, '_, '_>,
    film: &Film,
    precision: &Precision,
    observer: &mut Watch<'_>,
) -> Result<Option<f64>, RenderError> {
    let [batches, samples] = PILOT;
    let mut found = Film::of_window(film.window());
    if let Some(features) = film.features() {
        // Which pixels light can reach.
        found.set_features(features.clone())?;
    }
    let standing = progression.standing();
    (progression.pilot, progression.batch, progression.spp) = (true, PILOT_BATCH, 0);
    progression.plan = Batches { planned: Some(batches) };
    // Single samples first: by their time the rest is chosen.
    let mut outcome = progression.advance(&mut found, Some(2), observer)?;
    let began = progression.started.elapsed().as_secs_f64() / 2.0;
    let affordable = progression.seconds_left().map_or(f64::INFINITY, |left| PILOT_TIME * left / began.max(1e-6));
    let each = samples.min((affordable / f64::from(batches)) as u32).max(1);
    if outcome.is_none() {
        progression.plan = Batches { planned: Some(batches * each) };
        outcome = progression.advance(&mut found, Some(batches * each), observer)?;
    }
    let spp = progression.spp;
    (progression.pilot, progression.batch, progression.spp) = (false, standing.batch, standing.next);
    match outcome {
        Some(Outcome::Interrupted) => Ok(None),
        _ => {
            let narrowed = precision.half_width(&found, &found.reachable()) / precision.error;
            Ok(Some(MARGIN * f64::from(spp) * narrowed * narrowed))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_looks_together_spend_no_more_than_there_is() {
        let all: f64 = (0..60).map(spent).sum();
        assert!(all <= 1.0 && all > 0.999, "{all}");
    }
}
