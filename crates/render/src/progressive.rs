//! The progressive loop: traces until a goal is met.

use std::time::Duration;

use surelight_film::{Film, Precision};

use crate::{
    batches::Batches,
    error::RenderError,
    precise,
    progression::{Outcome, Progression, Watch},
    renderer::Renderer,
};

/// When a render is done; whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Samples a pixel; beside a precision, the most that it may take.
    pub spp: Option<u32>,
    /// Tracing time.
    pub time: Option<Duration>,
    /// How narrow error bars must be.
    pub precision: Option<Precision>,
}

/// Traces until the goal is met, passing by `observer` between dispatches; it returns whether to go on.
///
/// With a precision, `film` must be empty: how many samples are taken must not depend on those already there.
pub fn render(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    goal: &Goal,
    observer: &mut Watch<'_>,
) -> Result<Outcome, RenderError> {
    let mut progression = Progression::new(renderer, goal.time);
    if let Some(precision) = &goal.precision {
        return precise::render(&mut progression, film, precision, goal.spp, observer);
    }
    progression.plan = Batches { planned: goal.spp };
    match progression.advance(film, goal.spp, observer)? {
        // Where nothing but time was asked for, its end is the goal.
        Some(Outcome::TimeUp) if goal.spp.is_none() => Ok(Outcome::Done),
        Some(outcome) => Ok(outcome),
        None => Ok(Outcome::Done),
    }
}
