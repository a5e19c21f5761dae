//! Several scenes in one report, kept on disk while it grows.

use std::path::Path;

use surelight_render::Device;

use crate::{
    conditions::Conditions,
    data::{Data, SCHEMA, SceneData},
    error::BenchError,
    overlay::doubts,
    plan::Plan,
    race::{Status, race},
    report::{read_data, write_data, write_report},
    tracer::Subject,
};

/// Progress of a campaign: index of the scene, number of scenes, and the progress of the race.
pub type WatchAll<'w> = dyn FnMut(&str, usize, &Status) -> bool + 'w;

/// Races on every scene and writes the report to `folder`. With `resume`, what an interrupted
/// campaign left there is continued. Returns the data and whether everything was measured; where
/// `watch` stopped it, the report holds what there is.
///
/// # Errors
/// Where a device or a disk fails, where `resume` finds a report of another campaign, and where it
/// is stopped before the first measurement.
pub fn campaign(
    device: &Device,
    subjects: &[Subject],
    plan: &Plan,
    folder: &Path,
    resume: bool,
    note: &str,
    watch: &mut WatchAll<'_>,
) -> Result<(Data, bool), BenchError> {
    std::fs::create_dir_all(folder)
        .map_err(|e| BenchError::file(folder, format!("cannot be made: {}", surelight_film::io_cause(&e))))?;
    let mut earlier = Vec::new();
    let mut conditions = Conditions::now(&device.info, note);
    let mut resumed = None;
    if resume {
        let data = read_data(&folder.join("data.json"))?;
        for scene in data.scenes {
            check(&scene, subjects, plan, folder)?;
            earlier.push(scene);
        }
        resumed = another(&data.conditions, &conditions, folder)?;
        conditions = data.conditions;
    }
    let mut data = Data { schema: SCHEMA, conditions, scenes: Vec::new() };
    let mut complete = true;
    for (number, subject) in subjects.iter().enumerate() {
        let mut scene = earlier.iter().find(|s| s.name == subject.name).cloned();
        if let Some(scene) = &mut scene {
            scene.repeats = scene.repeats.max(plan.repeats);
            if scene.is_all() {
                data.scenes.push(scene.clone());
                continue;
            }
            scene.warnings.extend(resumed.iter().filter(|w| !scene.warnings.contains(w)).cloned().collect::<Vec<_>>());
        }
        let before = data.clone();
        let rest: Vec<SceneData> = earlier.iter().filter(|s| s.name != subject.name).cloned().collect();
        let mut save = |scene: &SceneData| {
            let mut data = before.clone();
            data.scenes.push(scene.clone());
            // Keeps later scenes as they are, for the next resumption.
            data.scenes.extend(rest.iter().filter(|s| !before.scenes.iter().any(|b| b.name == s.name)).cloned());
            write_data(folder, &data)
        };
        let mut watch_one = |status: &Status| watch(&subject.name, number, status);
        complete = race(device, subject, plan, &folder.join(&subject.name), &mut scene, &mut save, &mut watch_one)?;
        data.scenes.extend(scene.filter(|s| !s.rows.is_empty()));
        if !complete {
            let kept = earlier.iter().filter(|s| !data.scenes.iter().any(|d| d.name == s.name)).cloned();
            data.scenes.extend(kept.collect::<Vec<_>>());
            break;
        }
    }
    if data.scenes.is_empty() {
        return Err(BenchError::Interrupted);
    }
    for scene in &mut data.scenes {
        for doubt in doubts(&plan.peers, scene) {
            if !scene.warnings.contains(&doubt) {
                scene.warnings.push(doubt);
            }
        }
    }
    write_report(folder, &data, &plan.peers)?;
    Ok((data, complete))
}

/// The warning where a race continues with another version. An error on another device: times of
/// two devices cannot be combined.
fn another(then: &Conditions, now: &Conditions, folder: &Path) -> Result<Option<String>, BenchError> {
    if (&then.device, &then.cpu) != (&now.device, &now.cpu) {
        let cause = format!("cannot be resumed: it was begun on {} ({})", then.device, then.cpu);
        return Err(BenchError::file(folder, cause));
    }
    let build = |c: &Conditions| format!("{} {}", c.version, c.commit);
    let same = build(then) == build(now);
    Ok((!same).then(|| format!("begun with version {}, resumed with {}", build(then).trim(), build(now).trim())))
}

/// Whether a race that was interrupted can be continued.
fn check(scene: &SceneData, subjects: &[Subject], plan: &Plan, folder: &Path) -> Result<(), BenchError> {
    let wrong = |cause: &str| {
        let cause = format!("cannot be resumed: \"{}\" was raced {cause}", scene.name);
        Err(BenchError::file(folder, cause))
    };
    let Some(subject) = subjects.iter().find(|s| s.name == scene.name) else {
        return wrong("too, and is not requested now");
    };
    if subject.hash != scene.hash {
        return wrong("with another content");
    }
    if [subject.settings.width, subject.settings.height] != [scene.width, scene.height] {
        return wrong(&format!("with {}x{} pixels", scene.width, scene.height));
    }
    if !plan.methods.iter().map(crate::Method::name).eq(scene.methods.iter().map(|m| m.name.clone())) {
        let names: Vec<_> = scene.methods.iter().map(|m| m.name.as_str()).collect();
        return wrong(&format!("with other methods: {}", names.join(", ")));
    }
    Ok(())
}
