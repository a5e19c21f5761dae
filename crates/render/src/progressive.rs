//! Progressive rendering: traces until a goal is reached.

use std::time::Duration;

use surelight_film::{Film, Precision};
use surelight_prepare::Batches;

use crate::{
    error::RenderError,
    pacing::{CheckpointSink, Outcome, Progression, Watch},
    precise,
    renderer::Renderer,
    resume::ResumeState,
};

/// When a render ends: at whichever limit comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Samples per pixel; with a precision, the maximum.
    pub spp: Option<u32>,
    /// The sample before which a part of the render ends; `None`: all samples.
    pub end: Option<u32>,
    /// Time to trace for.
    pub time: Option<Duration>,
    /// The required precision of error bars.
    pub precision: Option<Precision>,
}

/// Traces until the goal is reached, and calls `observer` between dispatches, which returns whether
/// to continue.
///
/// `film` must be empty.
pub fn render(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    goal: &Goal,
    observer: &mut Watch<'_>,
) -> Result<Outcome, RenderError> {
    render_from(renderer, film, goal, &mut ResumeState::default(), observer, None)
}

/// As [`render`], from the state of an earlier run and its film; the result equals that of a single
/// run, bit for bit. `state` is updated, also on errors: it always describes the film.
///
/// `sink` receives the film at intervals, to save it.
pub fn render_from(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    goal: &Goal,
    state: &mut ResumeState,
    observer: &mut Watch<'_>,
    sink: Option<CheckpointSink<'_>>,
) -> Result<Outcome, RenderError> {
    let mut progression = Progression::new(renderer, goal.time, *state, sink);
    let outcome = trace(&mut progression, film, goal, observer);
    *state = progression.resume_state();
    outcome
}

fn trace(
    progression: &mut Progression<'_, '_, '_>,
    film: &mut Film,
    goal: &Goal,
    observer: &mut Watch<'_>,
) -> Result<Outcome, RenderError> {
    if let Some(precision) = &goal.precision {
        precise::render(progression, film, precision, goal.spp, observer)
    } else {
        progression.plan = Batches { planned: goal.spp };
        Ok(match progression.advance(film, goal.end.or(goal.spp), observer)? {
            // Without another goal, time is the goal.
            Some(Outcome::TimeUp) if goal.spp.is_none() => Outcome::Done,
            Some(outcome) => outcome,
            None => Outcome::Done,
        })
    }
}
