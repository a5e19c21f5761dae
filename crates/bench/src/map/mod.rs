//! The failure map: the strengths of each method, and the scenes where it fails.
//!
//! Scenes that are each built around one difficulty, most with a closed form, are rendered by every
//! estimator with the same number of samples. A cell of the map says what came of it ([`Verdict`]).
//! A method that fails and says so is worth more than one that fails quietly, so both are
//! distinguished: the statements of a picture (that its method is biased, that light is missing,
//! that pixels are not certified) and the truth (a z test against the closed form, or Welch's
//! against a long render).

mod cases;
mod chart;
mod page;

use std::ops::ControlFlow;
use surelight_estimate::{Estimate, sidak_level, welch_test};
use surelight_film::{Film, FilmError};
use surelight_prepare::{Integrator, Prepared, Settings};
use surelight_render::{
    BatchSizes, Counts, Device, End, FinishedPass, NextPass, PassVisitor, Position, Renderer, Schedule, sample,
};
use surelight_scene::Scene;

use crate::error::BenchError;

pub use page::write;

/// Pixels on a side.
const SIDE: u32 = 32;
/// Batches of a render: an error bar needs 16.
const BATCHES: u32 = 16;
/// Level of all tests of a map together.
const ALPHA: f64 = 0.01;
/// Minimum fraction of certified pixels of a picture that is trusted.
const BELIEVED: f64 = 0.9;
/// Costs up to this factor above the minimum are taken as equal to it.
const AS_GOOD: f64 = 2.0;

/// The columns: the estimators of the lecture.
pub const METHODS: [(&str, Integrator); 5] = [
    ("hemisphere", Integrator::Hemisphere(surelight_prepare::Directions::Bsdf)),
    ("area", Integrator::Area),
    ("mis", Integrator::Mis),
    ("caustics", Integrator::Caustics),
    ("whitted", Integrator::Whitted),
];

/// The statements of a picture about light that cannot be connected.
const MISSING: &str = "light is missing";
const CHANCE: &str = "light by chance";

/// The truth about a scene's picture.
enum Truth {
    /// The exact mean over the picture.
    Mean(f64),
    /// The mean of this method's picture with this many times the samples.
    Long(Integrator, u32),
}

/// A row: a scene with one difficulty.
struct Case {
    /// Stem of its picture.
    name: &'static str,
    /// Its title in the chart.
    title: &'static str,
    build: fn() -> Scene,
    truth: fn() -> Truth,
    /// Samples per pixel in a batch.
    samples: u32,
    /// Exposure of its picture, in stops.
    exposure: f64,
    /// A paragraph that explains the results.
    why: &'static str,
}

/// The verdict on a method and a scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// No bias is detected, error bars are trusted, and the cost is about the minimum.
    Certified,
    /// The same at this many times the minimum cost: rays to the same error.
    Noisy(f64),
    /// The render reports that it is not to be trusted.
    Flagged(String),
    /// The mean has this relative error; and whether the render reports its bias.
    Wrong(f64, bool),
}

/// A cell of the map.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The verdict.
    pub verdict: Verdict,
    /// Mean of the picture over the truth, less 1; its standard error.
    pub deviation: [f64; 2],
    /// Fraction of the pixels that are certified.
    pub certified: f64,
    /// Relative variance of a sample times rays per path.
    pub cost: f64,
    film: Film,
}

/// A row of the map.
pub struct Row {
    case: &'static Case,
    cells: Vec<Cell>,
}

/// The map.
pub struct Map {
    /// Name of the adapter.
    pub device: String,
    rows: Vec<Row>,
}

impl Map {
    /// Renders every case by every method. `watch` receives the title of each case before it
    /// begins; false stops.
    ///
    /// # Errors
    /// Where the device fails, or `watch` stops it.
    pub fn measure(device: &Device, watch: &mut dyn FnMut(&str) -> bool) -> Result<Self, BenchError> {
        let mut rows = Vec::new();
        for (number, case) in (0..).zip(cases::CASES) {
            if !watch(case.title) {
                return Err(BenchError::Interrupted);
            }
            rows.push(Row::measure(device, case, number)?);
        }
        Ok(Self { device: device.info.name.clone(), rows })
    }

    /// Cells with an unreported error, as row and column.
    pub fn silent(&self) -> Vec<(&'static str, &'static str)> {
        let cells =
            self.rows.iter().flat_map(|row| row.cells.iter().zip(METHODS).map(|(cell, m)| (row.case.title, m.0, cell)));
        cells.filter(|(_, _, cell)| matches!(cell.verdict, Verdict::Wrong(_, false))).map(|(a, b, _)| (a, b)).collect()
    }
}

/// A picture, with its statement about missing light.
struct Picture {
    film: Film,
    /// Mean over pixels, in green.
    mean: Estimate,
    rays_per_path: f64,
    /// Light that it says is missing, or found by chance.
    stated: Option<&'static str>,
}

fn picture(
    device: &Device,
    scene: &Scene,
    integrator: Integrator,
    samples: u32,
    seed: u32,
) -> Result<Picture, BenchError> {
    let settings = Settings { integrator, seed, ..Settings::new(SIDE, SIDE) };
    let prepared = Prepared::new(scene, &scene.cameras[0], &settings)?;
    let stated = prepared.unreachable.first().map(|light| if light.is_bias() { MISSING } else { CHANCE });
    let mut renderer = Renderer::new(device, &prepared)?;
    let mut batches = Batched { film: Film::new(SIDE, SIDE), means: Vec::new() };
    let schedule = Schedule { sizes: BatchSizes::Equal(samples), end: Some(BATCHES * samples) };
    let mut film = Film::new(SIDE, SIDE);
    if let End::Stopped(error) = sample(&mut renderer, &mut film, schedule, &mut Position::default(), &mut batches)? {
        return Err(error.into());
    }
    let Batched { film, means } = batches;
    let rays_per_path = renderer.counts.rays as f64 / renderer.counts.paths.max(1) as f64;
    let mean = match integrator {
        // Pixels share particles; batches are independent.
        Integrator::Caustics => of_batches(&means),
        _ => pooled(&film),
    };
    Ok(Picture { film, mean, rays_per_path, stated })
}

/// A film, and the mean of each of its batches.
struct Batched {
    film: Film,
    means: Vec<f64>,
}

impl PassVisitor for Batched {
    type Stop = FilmError;

    fn before_pass(&mut self, _: &NextPass, _: &Counts) -> ControlFlow<FilmError, u32> {
        ControlFlow::Continue(1)
    }

    fn after_pass(&mut self, batch: &mut Film, _: &FinishedPass, _: &Counts) -> ControlFlow<FilmError> {
        self.means.push(pooled(batch).mean);
        match self.film.merge(&std::mem::replace(batch, Film::of_window(batch.window()))) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => ControlFlow::Break(error),
        }
    }
}

/// The mean of some independent estimates.
fn of_batches(means: &[f64]) -> Estimate {
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n;
    Estimate { mean, variance, dof: n - 1.0 }
}

/// Mean over pixels, in green.
fn pooled(film: &Film) -> Estimate {
    let n = film.pixels().len() as f64;
    let (mut mean, mut variance, mut dof) = (0.0, 0.0, 0.0);
    for i in 0..film.pixels().len() {
        mean += film.mean(i)[1] / n;
        variance += film.variance_of_mean(i).map_or(0.0, |v| v[1]) / (n * n);
        dof += film.degrees_of_freedom(i);
    }
    Estimate { mean, variance, dof }
}

impl Row {
    fn measure(device: &Device, case: &'static Case, number: u32) -> Result<Self, BenchError> {
        let scene = (case.build)();
        let long = |integrator, times: u32| {
            picture(device, &scene, integrator, times * case.samples, 1000 + number).map(|p| p.mean)
        };
        let truth = match (case.truth)() {
            Truth::Mean(mean) => Estimate::exact(mean),
            Truth::Long(integrator, times) => long(integrator, times)?,
        };
        let mut pictures = Vec::new();
        for (k, (_, integrator)) in (0..).zip(METHODS) {
            pictures.push(picture(device, &scene, integrator, case.samples, 10 * number + k)?);
        }
        let level = sidak_level(ALPHA, cases::CASES.len() * METHODS.len());
        let mut cells: Vec<Cell> = pictures
            .into_iter()
            .zip(METHODS)
            .map(|(p, (_, integrator))| judge(&scene, p, integrator, &truth, level))
            .collect();
        // The biased method has almost no noise, and is excluded from the minimum cost.
        let sound = cells.iter().zip(METHODS).filter(|(c, m)| c.verdict == Verdict::Certified && !m.1.is_biased());
        let sound = sound.map(|(c, _)| c.cost);
        let best = sound.fold(f64::INFINITY, f64::min);
        for cell in &mut cells {
            let times = cell.cost / best;
            if cell.verdict == Verdict::Certified && times > AS_GOOD {
                cell.verdict = Verdict::Noisy(times);
            }
        }
        Ok(Self { case, cells })
    }
}

/// The verdict before the comparison of costs.
fn judge(scene: &Scene, picture: Picture, integrator: Integrator, truth: &Estimate, level: f64) -> Cell {
    let Picture { film, mean, rays_per_path, stated } = picture;
    // Sums are f32, and closed forms are means over pixels by quadrature: 0.01 % cannot be
    // resolved.
    let blurred = Estimate { variance: mean.variance + (1e-4 * truth.mean).powi(2), ..mean };
    let test = welch_test(&blurred, truth);
    let deviation = [mean.mean / truth.mean - 1.0, test.standard_error / truth.mean];
    let certified = film.certify().share();
    let unfound = matches!(integrator, Integrator::Hemisphere(_)) && !scene.lights.is_empty();
    let off = test.p < level;
    let verdict = match stated {
        _ if unfound => Verdict::Flagged(MISSING.into()),
        Some(MISSING) => Verdict::Flagged(MISSING.into()),
        _ if integrator.is_biased() && off => Verdict::Wrong(deviation[0], true),
        Some(chance) if certified < BELIEVED => Verdict::Flagged(chance.into()),
        _ if certified < BELIEVED => Verdict::Flagged(format!("{:.0} % certified", 100.0 * certified)),
        _ if off => Verdict::Wrong(deviation[0], false),
        _ => Verdict::Certified,
    };
    let n = film.pixels().len();
    let sum = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>();
    let variance = sum(&|i| film.variance_of_mean(i).map_or(0.0, |v| v[1]) * film.samples(i) as f64);
    let squares = sum(&|i| film.mean(i)[1].powi(2));
    Cell { verdict, deviation, certified, cost: variance / squares.max(f64::MIN_POSITIVE) * rays_per_path, film }
}
