//! The race: every method in turn, repeat after repeat, so that drift of the machine favours none.

mod repeats;

use std::path::Path;
use std::time::Instant;

use surelight_film::{Display, write_png};
use surelight_render::Device;

use crate::{
    data::{MethodData, SceneData},
    error::BenchError,
    method::Method,
    plan::{Budget, MAX_SAMPLES, Plan, REFERENCE_SHARE, checkpoints},
    reference::{self, Made},
    tracer::{Setup, Subject, Tracers},
    traversal,
    trial::{Trials, try_out},
};

/// Progress of a race.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The current work.
    pub stage: String,
    /// The finished part of the whole work, 0 to 1.
    pub share: f64,
    /// Seconds since the beginning of the race.
    pub seconds: f64,
}

/// Called with the progress at intervals; returns whether to continue.
pub type Watch<'w> = dyn FnMut(&Status) -> bool + 'w;

/// Races the methods on a scene. Adds each measurement to `data` and calls `save`; does not repeat
/// those of an interrupted race. Returns false where `watch` stopped it.
///
/// # Errors
/// Where a device, a scene or a disk fails.
pub fn race(
    device: &Device,
    subject: &Subject,
    plan: &Plan,
    folder: &Path,
    data: &mut Option<SceneData>,
    save: &mut dyn FnMut(&SceneData) -> Result<(), BenchError>,
    watch: &mut Watch<'_>,
) -> Result<bool, BenchError> {
    std::fs::create_dir_all(folder)
        .map_err(|e| BenchError::file(folder, format!("cannot be made: {}", surelight_film::io_cause(&e))))?;
    let mut race = Race {
        subject,
        plan,
        folder,
        tracers: Tracers::new(device, subject),
        started: Instant::now(),
        work: Work::default(),
        watch,
    };
    let Some(setups) = race.set_up()? else { return Ok(false) };
    let Some(trials) = race.try_out()? else { return Ok(false) };
    let lengths = plan.lengths(&trials.costs[..plan.methods.len()], race.started.elapsed().as_secs_f64());
    let Some(made) = race.reference(&trials, &lengths, data.as_ref())? else { return Ok(false) };
    let scene = data.get_or_insert_with(|| race.begin(&setups, &lengths, &made));
    if !race.measure_all(scene, &made.reference, save)? {
        return Ok(false);
    }
    race.traversal(device, scene, save)
}

/// The work in seconds, as far as it is known in advance.
#[derive(Default)]
struct Work {
    done: f64,
    all: f64,
}

struct Race<'a, 'w> {
    subject: &'a Subject,
    plan: &'a Plan,
    folder: &'a Path,
    tracers: Tracers<'a>,
    started: Instant,
    work: Work,
    watch: &'a mut Watch<'w>,
}

impl Race<'_, '_> {
    fn report(&mut self, stage: String, more: f64) -> bool {
        let share = if self.work.all > 0.0 { ((self.work.done + more) / self.work.all).clamp(0.0, 1.0) } else { 0.0 };
        (self.watch)(&Status { stage, share, seconds: self.started.elapsed().as_secs_f64() })
    }

    /// Makes every renderer once.
    fn set_up(&mut self) -> Result<Option<Vec<Setup>>, BenchError> {
        let mut setups = Vec::new();
        for method in &self.plan.methods {
            if !self.report(format!("compiling {}", method.name()), 0.0) {
                return Ok(None);
            }
            setups.push(self.tracers.set_up(method)?);
        }
        Ok(Some(setups))
    }

    /// The cost of a sample of each method, and which shall make the reference.
    fn try_out(&mut self) -> Result<Option<Trials>, BenchError> {
        let mut methods = self.plan.methods.clone();
        // The default is tried even where it is not raced: the reference may need it.
        if self.plan.reference.is_none() && !methods.contains(&Method::DEFAULT) {
            methods.push(Method::DEFAULT);
        }
        let Self { tracers, watch, started, subject, plan, .. } = self;
        let mut report = |method: &Method| {
            let stage = format!("trying out {}", method.name());
            watch(&Status { stage, share: 0.0, seconds: started.elapsed().as_secs_f64() })
        };
        Ok(try_out(tracers, subject, &methods, plan.clock, &mut report)?)
    }

    /// The reference: a given image, one from an interrupted race, or a render.
    fn reference(
        &mut self,
        trials: &Trials,
        lengths: &[u32],
        earlier: Option<&SceneData>,
    ) -> Result<Option<Made>, BenchError> {
        let (plan, costs) = (self.plan, &trials.costs);
        let settings = &self.subject.settings;
        let size = [settings.width, settings.height];
        let all: f64 = costs.iter().zip(lengths).map(|(cost, &n)| cost.wall * f64::from(n)).sum();
        self.work.all = all * f64::from(plan.repeats);
        if let Some(path) = &plan.reference {
            return reference::load(path, size).map(Some);
        }
        let kept = self.folder.join("reference.exr");
        if let Some(earlier) = earlier {
            let mut made = reference::load(&kept, size)?;
            made.data = earlier.reference.clone();
            return Ok(Some(made));
        }
        let method = trials.reference;
        let known = plan.methods.iter().position(|m| *m == method);
        // The cost of another sampler is taken from the same integrator, or from the default, which
        // is tried last.
        let alike = || plan.methods.iter().position(|m| m.integrator == method.integrator && !m.shared_paths);
        let per_sample = costs[known.or_else(alike).unwrap_or(costs.len() - 1)].wall;
        let longest = lengths.iter().copied().max().unwrap_or(1);
        let samples = match plan.budget {
            Budget::Samples(n) => 8.0 * f64::from(n),
            _ => (REFERENCE_SHARE * self.work.all / per_sample).max(4.0 * known.map_or(0.0, |i| f64::from(lengths[i]))),
        };
        let samples = samples.max(64.0).min(64.0 * f64::from(longest).max(4.0)).min(MAX_SAMPLES) as u32;
        self.work.all += f64::from(samples) * per_sample;
        let (name, clock) = (method.name(), plan.clock);
        let settings = method.settings(settings);
        self.tracers.of(&method)?;
        let Self { tracers, watch, work, started, .. } = self;
        let renderer = tracers.of(&method)?;
        let made = reference::render(renderer, &settings, &name, samples, clock, &mut |spp| {
            let stage = format!("reference by {name}, {spp} of {samples} samples per pixel");
            let share = f64::from(spp) * per_sample / work.all;
            watch(&Status { stage, share, seconds: started.elapsed().as_secs_f64() })
        })?;
        self.work.done += f64::from(samples) * per_sample;
        let mut made = made;
        if let Some(Made { film: Some(film), data, .. }) = &mut made {
            data.reason.clone_from(&trials.reason);
            reference::save(&kept, film, data, &self.subject.hash)?;
            let display = self.display();
            write_png(&self.folder.join("reference.png"), film, &display)?;
        }
        Ok(made)
    }

    fn display(&self) -> Display {
        Display { exposure_ev: self.plan.exposure, ..Display::default() }
    }

    /// A report without rows.
    fn begin(&self, setups: &[Setup], lengths: &[u32], made: &Made) -> SceneData {
        let Subject { name, file, hash, scene, settings, load_seconds, warnings, .. } = self.subject;
        let methods = self.plan.methods.iter().zip(setups).zip(lengths);
        let in_vain =
            self.plan.methods.iter().zip(setups).filter(|(method, setup)| method.shared_paths && !setup.reuses_paths);
        let share_nothing: Vec<_> =
            in_vain.map(|(method, _)| format!("{}: path reuse has no effect on this scene", method.name())).collect();
        SceneData {
            name: name.clone(),
            file: file.clone(),
            hash: hash.clone(),
            width: settings.width,
            height: settings.height,
            triangles: setups.iter().map(|s| s.triangles).max().unwrap_or(0),
            repeats: self.plan.repeats,
            seconds_a_method: match self.plan.budget {
                Budget::Seconds(s) => Some(s),
                _ => None,
            },
            clock: self.plan.clock,
            load_seconds: *load_seconds,
            reference: made.data.clone(),
            methods: methods
                .map(|((method, setup), &length)| MethodData {
                    name: method.name(),
                    words: method.words(),
                    biased: method.bias(scene),
                    checkpoints: checkpoints(length),
                    prepare_seconds: setup.prepare_seconds,
                    compile_seconds: setup.compile_seconds,
                    device_bytes: setup.device_bytes,
                })
                .collect(),
            walk: None,
            rows: Vec::new(),
            warnings: [warnings.as_slice(), &share_nothing].concat(),
        }
    }

    /// The fraction of the time that traversal takes, by the default method where it is raced.
    fn traversal(
        &mut self,
        device: &Device,
        scene: &mut SceneData,
        save: &mut dyn FnMut(&SceneData) -> Result<(), BenchError>,
    ) -> Result<bool, BenchError> {
        // Only kernels without path reuse can traverse their rays twice.
        let mut measurable = self.plan.methods.iter().filter(|m| !m.shared_paths);
        let first = measurable.clone().next();
        let Some(method) = measurable.find(|m| **m == Method::DEFAULT).or(first).filter(|_| scene.walk.is_none())
        else {
            return Ok(true);
        };
        let Self { watch, started, subject, plan, .. } = self;
        let mut go_on = || {
            let stage = format!("share of traversal in {}", method.name());
            watch(&Status { stage, share: 1.0, seconds: started.elapsed().as_secs_f64() })
        };
        scene.walk = traversal::measure(device, subject, method, plan.clock, &mut go_on)?;
        save(scene)?;
        Ok(scene.walk.is_some())
    }
}
