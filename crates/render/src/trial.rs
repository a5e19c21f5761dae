//! The best integrator for a scene, by short, interleaved trials of each.

use surelight_film::Film;

use surelight_prepare::{Integrator, luminance};

use crate::noise;

/// The result of an integrator's trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The integrator.
    pub integrator: Integrator,
    /// Variance of a sample relative to its pixel's squared mean, averaged over pixels, in
    /// luminance.
    pub variance: f64,
    /// Seconds per sample of a pixel.
    pub seconds: f64,
    /// 1/(variance · seconds): accuracy per second.
    pub efficiency: f64,
    /// Relative standard error of the efficiency, from its spread over rounds.
    pub error: f64,
}

/// Evaluates the trials of integrators from the films of their rounds and from each round's seconds
/// per sample of a pixel. All films show one view and have batches of one sample.
pub fn judge_trials(integrators: &[Integrator], films: &[Vec<Film>], seconds: &[Vec<f64>]) -> Vec<Trial> {
    let weights = weights(films);
    (0..integrators.len()).map(|i| judge(integrators[i], &films[i], &seconds[i], &weights)).collect()
}

/// For each pixel, 1/(mean² + floor), from the samples of all integrators together.
fn weights(films: &[Vec<Film>]) -> Vec<f64> {
    let all: Vec<&Film> = films.iter().flatten().collect();
    let Some(first) = all.first() else { return Vec::new() };
    let means: Vec<f64> = (0..first.pixels().len())
        .map(|p| all.iter().map(|film| luminance(film.mean(p).map(|c| c as f32))).sum::<f64>() / all.len() as f64)
        .collect();
    noise::weights(&means)
}

fn judge(integrator: Integrator, films: &[Film], seconds: &[f64], weights: &[f64]) -> Trial {
    let variance_of = |film: &Film| {
        let relative = |p: usize| noise::variance(film, p) * film.samples(p) as f64 * weights[p];
        (0..weights.len()).map(relative).sum::<f64>() / weights.len().max(1) as f64
    };
    let variances: Vec<f64> = films.iter().map(variance_of).collect();
    let rounds = variances.len() as f64;
    let mean = |values: &[f64]| values.iter().sum::<f64>() / rounds;
    let (variance, seconds_per_sample) = (mean(&variances), mean(seconds));
    let costs: Vec<f64> = variances.iter().zip(seconds).map(|(v, s)| v * s).collect();
    let cost = mean(&costs);
    let spread = costs.iter().map(|c| (c - cost).powi(2)).sum::<f64>() / (rounds - 1.0) / rounds;
    let cost = cost.max(f64::MIN_POSITIVE);
    Trial { integrator, variance, seconds: seconds_per_sample, efficiency: 1.0 / cost, error: spread.sqrt() / cost }
}

/// The index of the most efficient trial; that of `usual`, unless it is significantly worse.
pub fn best_trial(trials: &[Trial], usual: Integrator) -> Option<usize> {
    let best = (0..trials.len()).max_by(|&a, &b| trials[a].efficiency.total_cmp(&trials[b].efficiency))?;
    let Some(usual) = trials.iter().position(|t| t.integrator == usual) else { return Some(best) };
    // Two standard errors of the logarithm of their ratio.
    let apart = (trials[best].efficiency / trials[usual].efficiency).ln();
    let doubt = 2.0 * trials[best].error.hypot(trials[usual].error);
    Some(if apart > doubt { best } else { usual })
}

#[cfg(test)]
mod tests {
    use super::*;
    use surelight_film::BatchSum;

    fn trial(integrator: Integrator, efficiency: f64, error: f64) -> Trial {
        Trial { integrator, variance: 1.0, seconds: 1.0 / efficiency, efficiency, error }
    }

    #[test]
    fn the_usual_one_stays_unless_another_is_surely_better() {
        let mis = trial(Integrator::Mis, 10.0, 0.05);
        for (efficiency, error, best) in [(20.0, 0.05, 1), (10.5, 0.05, 0), (20.0, 0.5, 0), (5.0, 0.01, 0)] {
            assert_eq!(best_trial(&[mis, trial(Integrator::Area, efficiency, error)], Integrator::Mis), Some(best));
        }
        assert_eq!(best_trial(&[trial(Integrator::Area, 1.0, 0.1)], Integrator::Mis), Some(0));
        assert_eq!(best_trial(&[], Integrator::Mis), None);
    }

    #[test]
    fn efficiency_is_that_of_its_definition() {
        // Single samples 0 and 2: mean 1, variance 2 between two of them, in each of two rounds of
        // 1 and 3 seconds.
        let film = || {
            let mut film = Film::new(1, 1);
            for value in [0.0, 2.0] {
                film.add_batch(1, &[0], &[BatchSum::constant(1, [value; 3])]).unwrap();
            }
            film
        };
        let films = [film(), film()];
        let weights = weights(&[films.to_vec()]);
        assert!((weights[0] - 1.0 / 1.01).abs() < 1e-6);
        let trial = judge(Integrator::Mis, &films, &[1.0, 3.0], &weights);
        assert!((trial.variance * 1.01 - 2.0).abs() < 1e-5, "{trial:?}");
        assert!((trial.efficiency * trial.variance * 2.0 - 1.0).abs() < 1e-9);
        assert!((trial.error - 0.5).abs() < 1e-9);
    }
}
