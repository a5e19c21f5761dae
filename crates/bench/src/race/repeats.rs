//! The repeats of a race: every method in turn, checkpoint after checkpoint.

use surelight_film::{Film, write_png};

use super::{Race, Status};
use crate::{
    data::{Row, SceneData, slug},
    error::BenchError,
    measure::{Reference, flip, measure},
    pictures,
    plan::Budget,
    tracer::Run,
};

/// Minimum number of repeats for bands and intervals.
const MIN_REPEATS: u32 = 2;

/// The fraction of a scene's time after which no further repeat begins: at the speed of the trials,
/// at most a third of the race remains at that point.
const LATE: f64 = 0.8;

impl Race<'_, '_> {
    /// Runs all repeats of all methods that are not measured yet.
    pub(super) fn measure_all(
        &mut self,
        scene: &mut SceneData,
        reference: &Reference,
        save: &mut dyn FnMut(&SceneData) -> Result<(), BenchError>,
    ) -> Result<bool, BenchError> {
        let count = self.plan.methods.len();
        for repeat in 0..self.plan.repeats {
            if repeat >= MIN_REPEATS && self.is_late() && (0..count).all(|m| !scene.is_complete(m, repeat)) {
                scene.warnings.push(format!(
                    "{repeat} repeats instead of {}: the machine has become slower since the trials",
                    scene.repeats
                ));
                scene.repeats = repeat;
                break;
            }
            for turn in 0..count {
                // Each repeat begins with another method, and every second one is in reverse order.
                let turn = if repeat % 2 == 0 { turn } else { count - 1 - turn };
                let index = (turn + repeat as usize / 2) % count;
                if scene.is_complete(index, repeat) {
                    continue;
                }
                // An interrupted repeat is measured again, with the same samples.
                scene.rows.retain(|row| (row.method, row.repeat) != (index, repeat));
                let went_on = self.measure_one(scene, reference, index, repeat)?;
                save(scene)?;
                if !went_on {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Whether the time for the whole scene, where it is limited, does not suffice for another
    /// repeat.
    fn is_late(&self) -> bool {
        let Budget::Total(seconds) = self.plan.budget else { return false };
        self.started.elapsed().as_secs_f64() > LATE * seconds
    }

    /// Runs one repeat of one method, checkpoint after checkpoint.
    fn measure_one(
        &mut self,
        scene: &mut SceneData,
        reference: &Reference,
        index: usize,
        repeat: u32,
    ) -> Result<bool, BenchError> {
        let method = self.plan.methods[index];
        let settings = method.settings(&self.subject.settings);
        let display = self.display();
        let checkpoints = scene.methods[index].checkpoints.clone();
        let work = self.work_left(scene);
        let stage = format!("{}, repeat {} of {}", method.name(), repeat + 1, self.plan.repeats);
        let mut run = {
            let renderer = self.tracers.of(&method)?;
            Run::new(&settings, 1 + repeat, renderer)
        };
        for (place, &spp) in checkpoints.iter().enumerate() {
            let Self { tracers, watch, started, .. } = self;
            let status = Status { stage: stage.clone(), share: work, seconds: 0.0 };
            let mut go_on = || watch(&Status { seconds: started.elapsed().as_secs_f64(), ..status.clone() });
            if !run.grow_to(tracers.of(&method)?, spp, None, &mut go_on)? {
                return Ok(false);
            }
            let last = place + 1 == checkpoints.len();
            let flip = (repeat == 0).then(|| flip(&run.film, reference, &display));
            scene.rows.push(row(index, repeat, &run, reference, flip));
            if last && repeat == 0 {
                self.pictures(&run.film, reference, &method.name())?;
            }
        }
        Ok(true)
    }

    /// The finished fraction of the work, by the checkpoints measured.
    fn work_left(&self, scene: &SceneData) -> f64 {
        let runs = scene.methods.len() * scene.repeats as usize;
        let done = (0..scene.methods.len())
            .map(|m| (0..scene.repeats).filter(|&r| scene.is_complete(m, r)).count())
            .sum::<usize>();
        let reference = if self.work.all > 0.0 { self.work.done / self.work.all } else { 0.0 };
        reference + (1.0 - reference) * done as f64 / runs.max(1) as f64
    }

    /// Writes the picture of a method and the map of its errors.
    fn pictures(&self, film: &Film, reference: &Reference, name: &str) -> Result<(), BenchError> {
        let name = slug(name);
        write_png(&self.folder.join(format!("{name}.png")), film, &self.display())?;
        pictures::error_map(&self.folder.join(format!("{name}-error.png")), film, reference)
    }
}

/// The row of the checkpoint that a run has reached.
fn row(method: usize, repeat: u32, run: &Run, reference: &Reference, flip: Option<f64>) -> Row {
    let errors = measure(&run.film, reference, run.reuses_paths);
    Row {
        method,
        repeat,
        spp: run.spp(),
        batches: run.batches(),
        rays: run.counts.rays,
        paths: run.counts.paths,
        device_seconds: run.counts.device_seconds,
        dispatch_seconds: Some(run.counts.trace_seconds),
        read_seconds: Some(run.counts.read_seconds),
        film_seconds: Some(run.counts.film_seconds),
        wall_seconds: run.wall_seconds(),
        cpu_seconds: run.cpu_seconds(),
        mean: errors.mean,
        mean_se: errors.mean_se,
        mean_error: errors.mean_error,
        mse: errors.mse,
        rel_mse: errors.rel_mse,
        predicted_rel_mse: errors.predicted_rel_mse,
        coverage: errors.coverage,
        uncertified: (run.batches() > 1).then(|| 1.0 - run.film.certify().share()),
        flip,
        dropped: run.counts.dropped,
        truncated: run.counts.truncated,
    }
}
