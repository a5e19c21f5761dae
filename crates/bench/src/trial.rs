//! Short trials before the race: the cost of a sample of each method, and which method without bias
//! is to make the reference.

use std::time::Instant;

use surelight_film::Film;
use surelight_prepare::{Integrator, Sampler};
use surelight_render::{RenderError, Trial, best_trial, judge_trials};

use crate::{
    data::Clock,
    method::Method,
    plan::Cost,
    tracer::{Run, Subject, Tracers},
};

/// Rounds, in each of which every method runs once.
const ROUNDS: usize = 4;

/// Approximate seconds of a method's rounds together.
const SECONDS: f64 = 0.8;

/// Minimum and maximum samples of a round: variances need two.
const SAMPLES: [f64; 2] = [2.0, 16.0];

/// The stream of batches of the trials.
const STREAM: u32 = u16::MAX as u32;

/// Factor by which the tails of a method may be heavier than those of the default before its
/// efficiency is not trusted: a method that has not found its bright paths yet appears better than
/// it is.
const HEAVIER: f64 = 1.1;

/// The result of a trial.
struct Tried {
    cost: Cost,
    films: Vec<Film>,
    /// Seconds per sample of a pixel, for each round.
    seconds: Vec<f64>,
}

/// The costs of methods, in their order, and the method for the reference with the reason for it.
pub(crate) struct Trials {
    pub(crate) costs: Vec<Cost>,
    pub(crate) reference: Method,
    pub(crate) reason: String,
}

/// Runs the trials, which also warm up the methods; `None` where `report` stopped them.
pub(crate) fn try_out(
    tracers: &mut Tracers<'_>,
    subject: &Subject,
    methods: &[Method],
    clock: Clock,
    report: &mut dyn FnMut(&Method) -> bool,
) -> Result<Option<Trials>, RenderError> {
    let mut tried: Vec<Tried> = Vec::new();
    let mut samples = Vec::new();
    let mut runs = Vec::new();
    for method in methods {
        if !report(method) {
            return Ok(None);
        }
        let renderer = tracers.of(method)?;
        let mut run = Run::new(&method.settings(&subject.settings), STREAM, renderer);
        run.grow_to(renderer, 1, Some(1), &mut || true)?;
        let [least, most] = SAMPLES;
        samples.push((SECONDS / ROUNDS as f64 / run.wall_seconds().max(1e-4)).clamp(least, most) as u32);
        runs.push(run);
        tried.push(Tried { cost: Cost { clock: 0.0, wall: 0.0 }, films: Vec::new(), seconds: Vec::new() });
    }
    let first: Vec<[f64; 2]> = runs.iter().map(|run| [run.wall_seconds(), run.seconds(clock)]).collect();
    for round in 0..ROUNDS {
        for (i, method) in methods.iter().enumerate() {
            // Where a sample takes long, one round must suffice.
            if round > 0 && first[i][0] * f64::from(samples[i]) > SECONDS {
                continue;
            }
            if !report(method) {
                return Ok(None);
            }
            let renderer = tracers.of(method)?;
            let run = &mut runs[i];
            run.film = Film::new(subject.settings.width, subject.settings.height);
            let began = Instant::now();
            run.grow_to(renderer, run.spp() + samples[i], Some(1), &mut || true)?;
            let pixels = run.film.pixels().len() as f64;
            tried[i].seconds.push(began.elapsed().as_secs_f64() / f64::from(samples[i]) / pixels);
            tried[i].films.push(run.film.clone());
        }
    }
    for ((tried, run), first) in tried.iter_mut().zip(&runs).zip(&first) {
        let count = f64::from(run.spp() - 1);
        let wall = (run.wall_seconds() - first[0]) / count;
        let clocked = (run.seconds(clock) - first[1]) / count;
        tried.cost = Cost { clock: clocked.max(0.1 * wall).max(1e-7), wall: wall.max(1e-7) };
    }
    let (reference, reason) = choose(subject, methods, &tried);
    Ok(Some(Trials { costs: tried.iter().map(|t| t.cost).collect(), reference, reason }))
}

/// The integrators without bias among the methods, each with the method that tried it, Sobol's if
/// there is one. The reference's pixels are independent, so methods with path reuse are excluded.
fn candidates(subject: &Subject, methods: &[Method]) -> Vec<(Integrator, usize)> {
    let mut found: Vec<(Integrator, usize)> = Vec::new();
    for (i, method) in methods.iter().enumerate().filter(|(_, m)| !m.shared_paths && m.bias(&subject.scene).is_none()) {
        match found.iter_mut().find(|(integrator, _)| *integrator == method.integrator) {
            Some(known) if method.sampler == Sampler::Sobol => known.1 = i,
            Some(_) => {}
            None => found.push((method.integrator, i)),
        }
    }
    found
}

/// The most efficient method without bias; the default, which finds light in every way that the
/// others do, unless another is significantly better.
fn choose(subject: &Subject, methods: &[Method], tried: &[Tried]) -> (Method, String) {
    let usual = Method::DEFAULT.integrator;
    let enough = |&(_, i): &(Integrator, usize)| tried[i].films.len() == ROUNDS;
    let candidates: Vec<_> = candidates(subject, methods).into_iter().filter(enough).collect();
    let Some(own) = candidates.iter().position(|c| c.0 == usual) else {
        return (Method::DEFAULT, "it finds light in every way that others do".into());
    };
    let tails: Vec<f64> = candidates.iter().map(|&(_, i)| heaviness(&tried[i].films)).collect();
    let believed: Vec<usize> = (0..candidates.len()).filter(|&c| tails[c] <= HEAVIER * tails[own]).collect();
    let integrators: Vec<Integrator> = believed.iter().map(|&c| candidates[c].0).collect();
    let films: Vec<Vec<Film>> = believed.iter().map(|&c| tried[candidates[c].1].films.clone()).collect();
    let seconds: Vec<Vec<f64>> = believed.iter().map(|&c| tried[candidates[c].1].seconds.clone()).collect();
    let trials = judge_trials(&integrators, &films, &seconds);
    let best = best_trial(&trials, usual).map_or(usual, |b| integrators[b]);
    let method = Method { integrator: best, ..Method::DEFAULT };
    (method, reason(best, usual, &trials, candidates.len() - believed.len()))
}

fn reason(best: Integrator, usual: Integrator, trials: &[Trial], unbelieved: usize) -> String {
    let efficiency = |wanted: Integrator| trials.iter().find(|t| t.integrator == wanted).map(|t| t.efficiency);
    let mut text = match (efficiency(best), efficiency(usual)) {
        (Some(a), Some(b)) if best != usual => {
            format!("{:.1} times as efficient as the default in a trial of the methods without bias", a / b)
        }
        _ if trials.len() + unbelieved > 1 => {
            "the default, since a trial of the methods without bias found none surely better".into()
        }
        _ => "the only method without bias here".into(),
    };
    if unbelieved > 0 {
        text += &format!("; {unbelieved} with heavier tails not counted");
    }
    text
}

/// Mean over pixels of the share of a single sample in the squared deviations, all rounds together:
/// 1 where one sample decides everything.
fn heaviness(films: &[Film]) -> f64 {
    let Some((first, rest)) = films.split_first() else { return 1.0 };
    let mut all = first.clone();
    for film in rest {
        // Rounds are of one view, so their films can always be merged.
        if all.merge(film).is_err() {
            return 1.0;
        }
    }
    let tail = all.certify().tail;
    tail.iter().map(|&t| f64::from(t)).sum::<f64>() / tail.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use surelight_film::BatchSum;
    use surelight_prepare::Settings;
    use surelight_scene::Scene;

    use super::*;
    use crate::testing::normals;

    fn subject() -> Subject {
        Subject {
            name: "s".into(),
            file: "s.glb".into(),
            hash: String::new(),
            scene: Scene::default(),
            camera: Scene::default().frame_camera(1.0),
            settings: Settings::new(16, 16),
            load_seconds: 0.0,
            warnings: Vec::new(),
        }
    }

    /// Four rounds of 16 batches whose samples are 1 ± noise, but one in `rare` is as bright as
    /// that many.
    fn tried(seed: u64, noise: f64, seconds: f64, rare: u64) -> Tried {
        let mut normal = normals(seed);
        let lanes: Vec<u32> = (0..256).collect();
        let mut count = seed;
        let films = (0..ROUNDS).map(|_| {
            let mut film = Film::new(16, 16);
            for _ in 0..16 {
                let sums: Vec<_> = lanes
                    .iter()
                    .map(|_| {
                        count = count.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                        let bright = rare > 0 && (count >> 33).is_multiple_of(rare);
                        let value = (1.0 + noise * normal()).max(0.0) + if bright { rare as f64 } else { 0.0 };
                        BatchSum::constant(1, [value as f32; 3])
                    })
                    .collect();
                film.add_batch(1, &lanes, &sums).unwrap();
            }
            film
        });
        let films = films.collect();
        Tried {
            cost: Cost { clock: 1.0, wall: 1.0 },
            films,
            seconds: vec![seconds, 1.02 * seconds, seconds, 0.98 * seconds],
        }
    }

    const AREA: Method = Method { integrator: Integrator::Area, ..Method::DEFAULT };

    #[test]
    fn a_clearly_better_method_makes_the_reference() {
        let methods = [Method::DEFAULT, AREA];
        let (method, reason) = choose(&subject(), &methods, &[tried(1, 0.3, 1.0, 0), tried(2, 0.3, 0.5, 0)]);
        assert_eq!(method, AREA);
        assert!(
            reason.starts_with("2.0 times as efficient") || reason.starts_with("1.9") || reason.starts_with("2.1"),
            "{reason}"
        );
        let (method, reason) = choose(&subject(), &methods, &[tried(1, 0.3, 1.0, 0), tried(2, 0.3, 1.0, 0)]);
        assert_eq!(method, Method::DEFAULT);
        assert!(reason.starts_with("the default"), "{reason}");
    }

    #[test]
    fn luck_is_not_taken_for_efficiency() {
        // One sample in 10,000 is bright: one pixel in 150 has found one, and the others have none.
        let (method, reason) =
            choose(&subject(), &[Method::DEFAULT, AREA], &[tried(1, 0.3, 1.0, 0), tried(2, 0.1, 1.0, 10_000)]);
        assert_eq!((method, reason.contains("heavier tails")), (Method::DEFAULT, true), "{reason}");
    }

    #[test]
    fn biased_methods_and_lone_ones_make_none() {
        let whitted = Method { integrator: Integrator::Whitted, ..Method::DEFAULT };
        let bounded = Method { max_bounces: Some(3), ..AREA };
        let all = [tried(1, 0.3, 1.0, 0), tried(2, 0.1, 0.1, 0), tried(3, 0.1, 0.1, 0)];
        assert_eq!(choose(&subject(), &[Method::DEFAULT, whitted, bounded], &all).0, Method::DEFAULT);
        assert_eq!(choose(&subject(), &[AREA], &all[..1]).0, Method::DEFAULT);
    }
}
