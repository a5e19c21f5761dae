//! The progressive loop: traces until a goal is met.

use std::time::Duration;

use surelight_film::{Film, Precision};

use surelight_prepare::Batches;

use crate::{
    error::RenderError,
    precise,
    progression::{CheckpointSink, Outcome, Progression, Watch},
    renderer::Renderer,
    resume::ResumeState,
};

/// When a render is done; whichever comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Goal {
    /// Samples a pixel; beside a precision, the most that it may take.
    pub spp: Option<u32>,
    /// Of these, the one before which a part of the render ends; without it, all are traced.
    pub end: Option<u32>,
    /// Tracing time.
    pub time: Option<Duration>,
    /// How narrow error bars must be.
    pub precision: Option<Precision>,
}

/// Traces until the goal is met, passing by `observer` between dispatches; it returns whether to go on.
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

/// Likewise, from the position `standing` of another run, whose film it was; the bits are those of a single
/// run. `standing` is updated, also on errors: it always describes the film.
///
/// `keeper` is handed the film now and then, to save it.
pub fn render_from(
    renderer: &mut Renderer<'_>,
    film: &mut Film,
    goal: &Goal,
    standing: &mut ResumeState,
    observer: &mut Watch<'_>,
    keeper: Option<CheckpointSink<'_>>,
) -> Result<Outcome, RenderError> {
    let mut progression = Progression::new(renderer, goal.time, *standing, keeper);
    let outcome = trace(&mut progression, film, goal, observer);
    *standing = progression.standing();
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
            // Without another goal, the end of the time is the goal.
            Some(Outcome::TimeUp) if goal.spp.is_none() => Outcome::Done,
            Some(outcome) => outcome,
            None => Outcome::Done,
        })
    }
}
