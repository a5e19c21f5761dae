//! Regression test of two versions by their reports: whether the new one is slower, less accurate,
//! or has another picture.
//!
//! Every method in both reports is compared with itself, at the largest number of samples that both
//! have. *Speed* compares the seconds of a sample, *error* the relative mean square error
//! at equal samples, *picture* the mean radiance, for which no reference is needed. A loss is
//! called only where it exceeds the tolerance by more than the spread of repeats explains: the
//! probability of any false alarm in the whole comparison is kept below 5 %, by Šidák's correction
//! over all its tests. Spreads of time are pooled over the methods of a scene, which the same
//! machine shakes alike.

mod shift;
mod text;

use serde::Serialize;
use surelight_estimate::{Moments, sidak_level};

use self::shift::{Shift, mean_shift, shift};
use crate::{
    analysis::Interval,
    data::{Clock, Data, Row, SceneData},
    error::BenchError,
    report::text::factor,
};

/// Probability of any false alarm in a comparison: a third of it for each kind of test.
const ALPHA: f64 = 0.05;

/// Tolerances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tolerance {
    /// Relative increase of time or error that is tolerated: machines differ from day to day.
    pub ratio: f64,
    /// Relative difference of the mean radiance that is tolerated: rounding.
    pub mean: f64,
}

impl Default for Tolerance {
    fn default() -> Self {
        Self { ratio: 0.05, mean: 1e-6 }
    }
}

/// A method in two versions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodChange {
    /// Scene.
    pub scene: String,
    /// Method.
    pub method: String,
    /// Samples per pixel at which they are compared.
    pub spp: u32,
    /// New seconds over old, with a 95 % interval.
    pub time: Interval,
    /// New mean square error over old, with its interval; `None` where one is below the reference's
    /// noise.
    pub error: Option<Interval>,
    /// Relative difference of the mean radiance, with its interval; `None` where its error is
    /// unknown.
    pub mean: Option<Interval>,
    /// Losses beyond the tolerance and chance.
    pub losses: Vec<String>,
}

/// The result of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Every method that both have.
    pub methods: Vec<MethodChange>,
    /// Notes about differences that limit the comparison.
    pub notes: Vec<String>,
    /// The tolerances.
    pub tolerance: Tolerance,
}

impl Comparison {
    /// Whether anything was lost.
    pub fn is_loss(&self) -> bool {
        self.methods.iter().any(|m| !m.losses.is_empty())
    }
}

/// The figures of a method in both versions.
struct Pair<'a> {
    scene: &'a SceneData,
    method: usize,
    spp: u32,
    time: [Moments; 2],
    error: [Moments; 2],
    rows: [Vec<&'a Row>; 2],
}

/// Compares `new` with `old`.
///
/// # Errors
/// Where the reports have no method on the same scene in common.
pub fn compare(old: &Data, new: &Data, tolerance: Tolerance) -> Result<Comparison, BenchError> {
    let mut notes = Vec::new();
    let mut pairs = Vec::new();
    for scene in &new.scenes {
        match old.scenes.iter().find(|s| s.name == scene.name) {
            None => notes.push(format!("{} is not in the old report", scene.name)),
            Some(before) if [before.width, before.height] != [scene.width, scene.height] => {
                notes.push(format!("{} was {}x{} pixels", scene.name, before.width, before.height));
            }
            Some(before) => {
                if before.hash != scene.hash {
                    // A version that reads more of a file has another hash of it, so this is only a
                    // note.
                    notes.push(format!(
                        "{} is another scene than in the old report, or is read differently",
                        scene.name
                    ));
                }
                pairs.push(of_scene(before, scene));
            }
        }
    }
    if old.conditions.device != new.conditions.device || old.conditions.cpu != new.conditions.cpu {
        notes.push(format!(
            "the old report is of another machine ({}, {}): times are not comparable",
            old.conditions.device, old.conditions.cpu
        ));
    }
    let count: usize = pairs.iter().map(Vec::len).sum();
    if count == 0 {
        return Err(BenchError::Compare(format!("no method was raced on the same scene ({})", notes.join("; "))));
    }
    let level = sidak_level(sidak_level(ALPHA, 3), count);
    let methods = pairs.iter().flat_map(|of_scene| judge(of_scene, level, tolerance)).collect();
    Ok(Comparison { methods, notes, tolerance })
}

/// Methods of a scene that both versions have.
fn of_scene<'a>(old: &'a SceneData, new: &'a SceneData) -> Vec<Pair<'a>> {
    let mut pairs = Vec::new();
    for (method, data) in new.methods.iter().enumerate() {
        let Some(before) = old.methods.iter().position(|m| m.name == data.name) else { continue };
        let both = data.checkpoints.iter().filter(|n| old.methods[before].checkpoints.contains(n));
        let reached = |&&spp: &&u32| {
            new.rows_of(method).filter(|r| r.spp == spp).count() >= 2
                && old.rows_of(before).filter(|r| r.spp == spp).count() >= 2
        };
        let Some(&spp) = both.filter(reached).max() else { continue };
        let at = |scene: &'a SceneData, method: usize| -> Vec<&'a Row> {
            scene.rows_of(method).filter(|r| r.spp == spp).collect()
        };
        let rows = [at(old, before), at(new, method)];
        // Times of different clocks cannot be compared.
        let clock: Clock = new.clock;
        let time = rows.each_ref().map(|rows| rows.iter().map(|r| r.seconds(clock).max(1e-9).ln()).collect());
        let error = rows
            .each_ref()
            .map(|rows| rows.iter().filter(|r| r.rel_mse > 0.0).map(|r| r.rel_mse.ln()).collect::<Moments>());
        pairs.push(Pair { scene: new, method, spp, time, error, rows });
    }
    pairs
}

/// Judges the methods of a scene, each test at `level`.
fn judge(pairs: &[Pair], level: f64, tolerance: Tolerance) -> Vec<MethodChange> {
    // One variance of times for the whole scene.
    let freedom: f64 = pairs.iter().flat_map(|p| &p.time).map(|m| m.count() as f64 - 1.0).sum();
    let squares: f64 = pairs.iter().flat_map(|p| &p.time).map(|m| (m.count() as f64 - 1.0) * m.variance()).sum();
    let spread = squares / freedom;
    let one = |pair: &Pair| {
        let [old, new] = &pair.time;
        let time = Shift {
            value: new.mean() - old.mean(),
            se: (spread * (1.0 / old.count() as f64 + 1.0 / new.count() as f64)).sqrt(),
            dof: freedom,
        };
        let error = shift(&pair.error);
        let mean = mean_shift(&pair.rows);
        let mut losses = Vec::new();
        let limit = (1.0 + tolerance.ratio).ln();
        let ratio = |shift: &Shift| shift.interval(f64::exp);
        if time.exceeds(limit, level) {
            losses.push(format!("slower: a sample takes {}", factor(&ratio(&time))));
        }
        if let Some(error) = error.as_ref().filter(|error| error.exceeds(limit, level)) {
            losses.push(format!("less accurate: the mean square error is {}", factor(&ratio(error))));
        }
        if let Some(mean) = mean.as_ref().filter(|mean| mean.differs(tolerance.mean, level)) {
            losses.push(format!("another picture: its mean differs by {:+.3} %", 100.0 * mean.value));
        }
        MethodChange {
            scene: pair.scene.name.clone(),
            method: pair.scene.methods[pair.method].name.clone(),
            spp: pair.spp,
            time: ratio(&time),
            error: error.as_ref().map(ratio),
            mean: mean.as_ref().map(|mean| mean.interval(|x| x)),
            losses,
        }
    };
    pairs.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{conditions::Conditions, data::SCHEMA, testing::synthetic};

    /// Six methods, four repeats, times and errors that scatter by 3 %.
    fn version(seed: u64, slowness: f64, bias: f64) -> Data {
        let slow = [1.0, 1.5, 2.0, 3.0, 4.0, 5.0].map(|s| s * slowness);
        Data { schema: SCHEMA, conditions: Conditions::default(), scenes: vec![synthetic(seed, &slow, 0.03, bias)] }
    }

    fn losses(seed: u64, slowness: f64, bias: f64) -> Vec<String> {
        let (old, new) = (version(2 * seed, 1.0, 0.0), version(2 * seed + 1, slowness, bias));
        let comparison = compare(&old, &new, Tolerance::default()).unwrap();
        comparison.methods.into_iter().flat_map(|m| m.losses).collect()
    }

    #[test]
    fn equal_versions_pass() {
        // α = 5 % for a whole comparison: at most 2 alarms in 50, also without tolerance, where the
        // probability is α.
        let alarms = (0..50).filter(|&seed| !losses(seed, 1.0, 0.0).is_empty()).count();
        assert!(alarms <= 2, "{alarms}");
        let strict = Tolerance { ratio: 0.0, mean: 0.0 };
        let alarms = (0..50)
            .filter(|&seed| {
                compare(&version(2 * seed, 1.0, 0.0), &version(2 * seed + 1, 1.0, 0.0), strict).unwrap().is_loss()
            })
            .count();
        assert!(alarms <= 6, "{alarms}"); // 2.5 expected; at most 6 in 99 % of cases
    }

    #[test]
    fn a_slowdown_of_a_fifth_is_caught() {
        // 2.1 % standard error of a ratio: 20 % are 6.3 of them beyond the tolerated 5 %, and 3.2
        // are needed.
        let caught = (0..50).filter(|&seed| losses(seed, 1.2, 0.0).iter().any(|l| l.starts_with("slower"))).count();
        assert_eq!(caught, 50);
        // In one method alone, too.
        let mut new = version(101, 1.0, 0.0);
        for row in new.scenes[0].rows.iter_mut().filter(|r| r.method == 3) {
            row.wall_seconds *= 1.2;
        }
        let found = compare(&version(100, 1.0, 0.0), &new, Tolerance::default()).unwrap();
        let slow: Vec<_> = found.methods.iter().filter(|m| !m.losses.is_empty()).map(|m| m.method.as_str()).collect();
        assert_eq!(slow, ["method3/sobol"]);
        assert!(found.is_loss() && found.to_string().contains("LOSS slower"));
    }

    #[test]
    fn a_bias_of_one_percent_is_caught() {
        // Standard error of the difference 0.9·10⁻⁴.
        for bias in [0.01, -0.01] {
            let caught = (0..50)
                .filter(|&seed| losses(seed, 1.0, bias).iter().any(|l| l.starts_with("another picture")))
                .count();
            assert_eq!(caught, 50);
        }
    }

    #[test]
    fn more_noise_is_caught_and_less_is_none() {
        for (factor, lost) in [(1.6, true), (0.6, false)] {
            let mut new = version(9, 1.0, 0.0);
            new.scenes[0].rows.iter_mut().for_each(|r| r.rel_mse *= factor);
            let found = compare(&version(8, 1.0, 0.0), &new, Tolerance::default()).unwrap();
            assert_eq!(found.methods.iter().any(|m| m.losses.iter().any(|l| l.starts_with("less accurate"))), lost);
        }
    }

    #[test]
    fn incomparable_runs_are_reported() {
        let old = version(1, 1.0, 0.0);
        let mut new = version(2, 1.0, 0.0);
        new.scenes[0].hash = "other".into();
        assert!(compare(&old, &new, Tolerance::default()).unwrap().notes[0].contains("another scene"));
        new.scenes[0].width = 65;
        let error = compare(&old, &new, Tolerance::default()).unwrap_err().to_string();
        assert!(error.contains("synthetic was 64x64 pixels"), "{error}");
        let mut elsewhere = version(3, 1.0, 0.0);
        elsewhere.conditions.cpu = "another".into();
        assert!(compare(&old, &elsewhere, Tolerance::default()).unwrap().notes[0].contains("another machine"));
    }
}
