//! `surelight integrate`: Monte Carlo, quasi-Monte Carlo and quadrature side by side on a formula,
//! on the device.

mod args;
mod chart;
mod report;

use std::time::Instant;

use surelight_estimate::{Moments, Rule, pareto_k, student_t_half_width};
use surelight_prepare::Sampler;
use surelight_render::{Device, Formula, Integrand};

pub(crate) use self::args::IntegrateArgs;
use self::chart::Series;
use self::report::{Report, Row};
use crate::error::Error;
use crate::{console, render};

/// Independent sets of points: the error bar is that of their mean, whatever the sampler.
const REPLICATES: u32 = 32;

/// Evaluations of a grid at most: its values are weighted on the host one by one.
const MAX_GRID_EVALUATIONS: u64 = 1 << 26;

/// Points of a Gauss–Legendre rule on an axis at most: finding its nodes takes time with their
/// square.
const MAX_GAUSS_POINTS: usize = 4096;

/// The formula is f32: closer agreement than this share of the value means nothing.
const F32_NOISE: f64 = 1e-6;

const SAMPLERS: [(Sampler, &str); 3] = [
    (Sampler::Independent, "Monte Carlo, independent"),
    (Sampler::Stratified, "Monte Carlo, stratified"),
    (Sampler::Sobol, "quasi-Monte Carlo, Sobol"),
];

const RULES: [(Rule, &str); 3] =
    [(Rule::Midpoint, "midpoint"), (Rule::Simpson, "Simpson"), (Rule::GaussLegendre, "Gauss-Legendre")];

/// Integrates as the options say and prints the comparison.
pub(crate) fn run(args: &IntegrateArgs) -> Result<(), Error> {
    let bounds = &args.over.0;
    let formula = Formula::new(&args.formula, bounds.len())?;
    args.output.as_deref().map(surelight_film::check_writable).transpose()?;
    let device = Device::new(&render::adapter_choice(args.adapter.as_ref()))?;
    let max_grid_points =
        RULES.iter().filter_map(|&(rule, _)| max_grid_points(rule, args.samples, bounds.len())).max().unwrap_or(1);
    let integrand = Integrand::new(&device, &formula, bounds, max_grid_points * bounds.len())?;
    let mut work = Integration { args, integrand, notes: Vec::new(), replicate: 0 };

    let mut methods = Vec::new();
    for (sampler, name) in SAMPLERS {
        methods.push(work.sample(sampler, name)?);
    }
    for (rule, name) in RULES {
        methods.push(work.quadrature(rule, name)?);
    }
    let mut notes = work.notes;
    notes.extend(disagreements(&methods));
    let mut report = Report {
        formula: args.formula.clone(),
        over: bounds.clone(),
        adapter: device.info.name.clone(),
        precision: "f32 evaluation, f64 sums",
        confidence: args.confidence,
        seed: args.seed,
        exact: args.exact,
        methods,
        chart: None,
        notes,
    };
    if let Some(path) = &args.output {
        let series: Vec<_> =
            report.methods.iter().map(|r| Series { name: r.method, points: r.convergence.clone() }).collect();
        let error = match args.exact {
            Some(_) => "standard error (sampling), true error (quadrature)",
            None => "standard error (sampling), change to the next finer grid (quadrature)",
        };
        let svg = chart::draw(&format!("∫ {}", args.formula), error, &series);
        surelight_film::write_file(path, svg.as_bytes())?;
        report.chart = Some(path.display().to_string());
    }
    let text = if args.json {
        serde_json::to_string(&report).map_err(|e| Error::Print(e.into()))? + "\n"
    } else {
        report.to_string()
    };
    console::result(&text)
}

/// An integration under way.
struct Integration<'a> {
    args: &'a IntegrateArgs,
    integrand: Integrand<'a>,
    notes: Vec<String>,
    /// Number of the next replicate: none is used twice.
    replicate: u32,
}

impl Integration<'_> {
    fn sample(&mut self, sampler: Sampler, name: &'static str) -> Result<Row, Error> {
        let samples = (self.args.samples / u64::from(REPLICATES)) as u32;
        let mut convergence = Vec::new();
        if self.args.output.is_some() {
            for n in (0..).map(|k| 1u32 << k).take_while(|&n| n < samples) {
                convergence.push(self.level(sampler, n)?);
            }
        }
        let started = Instant::now();
        let found = self.integrand.sample(sampler, REPLICATES, samples, self.replicate, self.args.seed)?;
        let seconds = started.elapsed().as_secs_f64();
        self.replicate += REPLICATES;
        let moments: Moments = found.replicates.iter().copied().collect();
        let error = moments.variance_of_mean().sqrt();
        if self.args.output.is_some() {
            convergence.push((found.evaluations as f64, error));
        }
        self.count_lost(name, found.non_finite, found.evaluations);
        if sampler == Sampler::Independent {
            self.judge_tail(found.chunks);
        }
        Ok(Row {
            method: name,
            estimate: Some(moments.mean()),
            half_width: Some(student_t_half_width(self.args.confidence, error, f64::from(REPLICATES - 1))),
            replicates: Some(REPLICATES),
            change: None,
            true_error: self.args.exact.map(|exact| (moments.mean() - exact).abs()),
            evaluations: found.evaluations,
            seconds,
            non_finite: found.non_finite,
            convergence,
        })
    }

    /// Evaluations and standard error with so many samples a replicate.
    fn level(&mut self, sampler: Sampler, samples: u32) -> Result<(f64, f64), Error> {
        let found = self.integrand.sample(sampler, REPLICATES, samples, self.replicate, self.args.seed)?;
        self.replicate += REPLICATES;
        let moments: Moments = found.replicates.into_iter().collect();
        Ok((found.evaluations as f64, moments.variance_of_mean().sqrt()))
    }

    fn quadrature(&mut self, rule: Rule, name: &'static str) -> Result<Row, Error> {
        let dimensions = self.args.over.0.len();
        let mut row = Row {
            method: name,
            estimate: None,
            half_width: None,
            replicates: None,
            change: None,
            true_error: None,
            evaluations: 0,
            seconds: 0.0,
            non_finite: 0,
            convergence: Vec::new(),
        };
        let Some(points) = max_grid_points(rule, self.args.samples, dimensions) else { return Ok(row) };
        let started = Instant::now();
        let Ok(grid) = self.integrand.grid(rule, points)? else { return Ok(row) };
        row.seconds = started.elapsed().as_secs_f64();
        if let Some(coarser) = points_for_rule(rule, points / 2).filter(|&c| c < points)
            && let Ok(coarse) = self.integrand.grid(rule, coarser)?
        {
            row.change = Some((grid.estimate - coarse.estimate).abs());
        }
        if self.args.output.is_some() {
            row.convergence = self.refinements(rule, points)?;
        }
        self.count_lost(name, grid.non_finite, grid.evaluations);
        row.estimate = Some(grid.estimate);
        row.true_error = self.args.exact.map(|exact| (grid.estimate - exact).abs());
        row.evaluations = grid.evaluations;
        row.non_finite = grid.non_finite;
        Ok(row)
    }

    /// Evaluations and error of ever finer grids: against the truth where it is known, else against
    /// the next finer grid.
    fn refinements(&mut self, rule: Rule, max_grid_points: usize) -> Result<Vec<(f64, f64)>, Error> {
        let mut found: Vec<(f64, f64)> = Vec::new();
        let ladder = std::iter::successors(Some(1), |&points: &usize| Some(points + (points / 2).max(1)));
        for points in ladder.take_while(|&points| points < max_grid_points).chain([max_grid_points]) {
            if let Some(points) = points_for_rule(rule, points)
                && let Ok(grid) = self.integrand.grid(rule, points)?
                && found.last().is_none_or(|last| last.0 < grid.evaluations as f64)
            {
                found.push((grid.evaluations as f64, grid.estimate));
            }
        }
        if let Some(exact) = self.args.exact {
            return Ok(found.into_iter().map(|(n, estimate)| (n, (estimate - exact).abs())).collect());
        }
        Ok(found.windows(2).map(|pair| (pair[0].0, (pair[1].1 - pair[0].1).abs())).collect())
    }

    fn count_lost(&mut self, name: &str, lost: u64, of: u64) {
        if lost > 0 {
            let hint = match self.args.formula.contains("pow") {
                true => " (pow of a negative number is one cause: write x*x instead of pow(x,2))",
                false => "",
            };
            self.notes.push(format!(
                "{name}: {lost} of {of} values were not finite and were counted as 0, so the integral may be wrong{hint}"
            ));
        }
    }

    /// Whether the tail of the values is light enough for the error bars; by the means of 64
    /// independent samples, on both sides.
    fn judge_tail(&mut self, mut chunks: Vec<f64>) {
        let upper = pareto_k(&mut chunks);
        chunks.iter_mut().for_each(|x| *x = -*x);
        let worst = [upper, pareto_k(&mut chunks)].into_iter().flatten().find(|fit| !fit.reliable());
        if let Some(fit) = worst {
            self.notes.push(format!(
                "the values have a heavy tail (Pareto k = {:.2}, above {:.2}): the variance may be infinite and no error bar here can be trusted",
                fit.k, fit.limit
            ));
        }
    }
}

/// Points per axis that a rule can take: Simpson's are odd and at least 3.
fn points_for_rule(rule: Rule, points: usize) -> Option<usize> {
    let points = if rule == Rule::Simpson && points.is_multiple_of(2) { points.saturating_sub(1) } else { points };
    (points >= if rule == Rule::Simpson { 3 } else { 1 }).then_some(points)
}

/// Most points an axis with which a grid stays within so many evaluations.
fn max_grid_points(rule: Rule, samples: u64, dimensions: usize) -> Option<usize> {
    let most = samples.min(MAX_GRID_EVALUATIONS);
    let fits = |points: u64| points.checked_pow(dimensions as u32).is_some_and(|total| total <= most);
    let mut points = (most as f64).powf(1.0 / dimensions as f64) as u64;
    while fits(points + 1) {
        points += 1;
    }
    while !fits(points) {
        points -= 1;
    }
    let limit = if rule == Rule::GaussLegendre { MAX_GAUSS_POINTS } else { 1 << 22 };
    points_for_rule(rule, (points as usize).min(limit))
}

/// Quadrature rules whose result the sampling with the narrowest interval contradicts.
fn disagreements(methods: &[Row]) -> Vec<String> {
    let sampled = methods.iter().filter_map(|row| Some((row, row.estimate?, row.half_width?)));
    let Some((best, value, half)) = sampled.min_by(|a, b| a.2.total_cmp(&b.2)) else { return Vec::new() };
    let slack = 3.0 * half + F32_NOISE * value.abs();
    methods
        .iter()
        .filter(|row| row.half_width.is_none())
        .filter_map(|row| Some((row, row.estimate?)))
        .filter(|(_, estimate)| (estimate - value).abs() > slack)
        .map(|(row, estimate)| {
            format!(
                "{} is off by about {:.1e}, far outside the interval of {}: at {} evaluations quadrature fails here",
                row.method,
                (estimate - value).abs(),
                best.method,
                row.evaluations
            )
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_fit_the_evaluations() {
        assert_eq!(max_grid_points(Rule::Midpoint, 1 << 20, 2), Some(1024));
        assert_eq!(max_grid_points(Rule::Midpoint, 1000, 3), Some(10));
        assert_eq!(max_grid_points(Rule::Midpoint, 999, 3), Some(9));
        assert_eq!(max_grid_points(Rule::Simpson, 1 << 20, 6), Some(9));
        assert_eq!(max_grid_points(Rule::Simpson, 32, 4), None);
        assert_eq!(max_grid_points(Rule::Midpoint, 32, 10), Some(1));
        assert_eq!(max_grid_points(Rule::GaussLegendre, 1 << 20, 1), Some(MAX_GAUSS_POINTS));
    }
}
