//! The measurements.

use std::time::{Duration, Instant};

use surelight_film::Film;
use surelight_prepare::{Instrument, Prepared, Settings};
use surelight_render::{Device, Renderer, instrument};
use surelight_scene::{Camera, Environment, LoadOptions, Scene};
use surelight_scenes::{cornell_box, many_lights, probes};

use crate::{
    Plan,
    report::{Row, row},
};

/// A scene and the view of it.
pub(crate) struct Subject {
    name: String,
    scene: Scene,
    camera: Camera,
}

/// One step: rows of a table.
type Work = fn(&Plan, &Device, &[Subject]) -> Result<Vec<Row>, String>;

/// In order of priority.
pub(crate) const ALL: [(&str, Work); 6] = [
    ("path tracing", tracing),
    ("walks alone", walking),
    ("scene in buffers or in images", arrays),
    ("lanes at once", lanes),
    ("length of dispatches", dispatches),
    ("layouts of the tree", layouts),
];

pub(crate) fn adapters() -> Vec<Row> {
    let row = |a: surelight_render::AdapterInfo| {
        row! {
            "adapter": a.name, "driver": a.driver, "backend": a.backend, "kind": a.kind,
            "binding MiB": a.max_binding >> 20, "image side": a.max_image_side, "timestamps": a.timestamps,
        }
    };
    Device::list().into_iter().map(row).collect()
}

/// The Cornell box, a terrain of a million triangles, many lights, and the files.
pub(crate) fn load(plan: &Plan, subjects: &mut Vec<Subject>) -> Vec<Row> {
    let side = if plan.small { 71 } else { 707 };
    let mut scenes = vec![
        ("cornell-box".to_owned(), Ok(cornell_box::cornell_box())),
        (format!("terrain, {} triangles", 2 * side * side), Ok(probes::terrain(side))),
        ("many-lights".to_owned(), Ok(many_lights::many_lights())),
    ];
    for file in &plan.files {
        let name = file.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        scenes.push((name, surelight_scene::load(file, &LoadOptions::default()).map_err(|e| e.to_string())));
    }
    let mut rows = Vec::new();
    for (name, scene) in scenes {
        match scene {
            Err(error) => rows.push(row! {"scene": name, "error": error}),
            Ok(mut scene) => {
                if !scene.has_light() {
                    scene.environment = Some(Environment::Uniform([1.0; 3]));
                }
                let aspect = f64::from(plan.size[0]) / f64::from(plan.size[1]);
                let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(aspect));
                rows.push(row! {"scene": &name, "triangles": scene.triangle_count(), "textures": scene.images.len()});
                subjects.push(Subject { name, scene, camera });
            }
        }
    }
    rows
}

impl Subject {
    fn prepare(&self, plan: &Plan) -> Result<Prepared, String> {
        let settings = Settings::new(plan.size[0], plan.size[1]);
        Prepared::new(&self.scene, &self.camera, &settings).map_err(|e| e.to_string())
    }
}

/// Rows of all subjects; one that fails gets a row that says so.
fn each(subjects: &[Subject], mut work: impl FnMut(&Subject) -> Result<Vec<Row>, String>) -> Vec<Row> {
    subjects
        .iter()
        .flat_map(|subject| work(subject).unwrap_or_else(|error| vec![row! {"scene": subject.name, "error": error}]))
        .collect()
}

/// Figures of a render of about `plan.seconds`.
struct Figures {
    paths: f64,
    rays: f64,
    wall: f64,
    device: f64,
    dispatches: u64,
}

/// Renders a sample to warm up and to time it, then as many as fit.
fn measure(plan: &Plan, renderer: &mut Renderer<'_>) -> Result<Figures, String> {
    let mut film = Film::new(plan.size[0], plan.size[1]);
    let mut traced = |batch: u32, samples: u32| {
        let (before, started) = (renderer.counts, Instant::now());
        renderer.trace(&mut film, batch, 1, samples, &mut |_| true).map_err(|e| e.to_string())?;
        let now = renderer.counts;
        Ok::<_, String>(Figures {
            paths: (now.paths - before.paths) as f64,
            rays: (now.rays - before.rays) as f64,
            wall: started.elapsed().as_secs_f64(),
            device: now.device_seconds - before.device_seconds,
            dispatches: now.dispatches - before.dispatches,
        })
    };
    traced(0, 1)?;
    let once = traced(1, 2)?.wall / 2.0;
    traced(2, (plan.seconds / once.max(1e-4)).clamp(1.0, 4096.0) as u32)
}

fn tracing(plan: &Plan, device: &Device, subjects: &[Subject]) -> Result<Vec<Row>, String> {
    Ok(each(subjects, |subject| {
        let started = Instant::now();
        let prepared = subject.prepare(plan)?;
        let built = started.elapsed().as_secs_f64();
        let mut renderer = Renderer::new(device, &prepared).map_err(|e| e.to_string())?;
        let f = measure(plan, &mut renderer)?;
        let started = Instant::now();
        let mut film = Film::new(plan.size[0], plan.size[1]);
        renderer.trace_features(&mut film).map_err(|e| e.to_string())?;
        Ok(vec![row! {
            "scene": subject.name,
            "Mpaths/s": f.paths / f.device * 1e-6,
            "Mrays/s": f.rays / f.device * 1e-6,
            "rays a path": f.rays / f.paths,
            "Mpaths/s by the wall": f.paths / f.wall * 1e-6,
            "ms a dispatch": 1e3 * f.device / f.dispatches as f64,
            "built in s": built,
            "compiled in s": renderer.compile_seconds,
            "MiB": renderer.device_bytes as f64 / f64::from(1 << 20),
            "first-hit features in s": started.elapsed().as_secs_f64(),
            "dropped": renderer.counts.dropped,
            "cut short": renderer.counts.truncated,
        }])
    }))
}

/// By the time of three more traversals of every ray.
fn walking(plan: &Plan, device: &Device, subjects: &[Subject]) -> Result<Vec<Row>, String> {
    const WALKS: u32 = 4;
    Ok(each(subjects, |subject| {
        let mut prepared = subject.prepare(plan)?;
        prepared = prepared.instrumented(Instrument::RepeatedTraversal);
        let mut renderer = Renderer::new(device, &prepared).map_err(|e| e.to_string())?;
        let once = measure(plan, &mut renderer)?;
        instrument::set_traversals_per_ray(&mut renderer, WALKS);
        let often = measure(plan, &mut renderer)?;
        // Nanoseconds per ray, traversed once and several times.
        let [once, often] = [once, often].map(|f| 1e9 * f.device / f.rays);
        let walk = (often - once) / f64::from(WALKS - 1);
        Ok(vec![row! {"scene": subject.name, "Mrays/s": 1e3 / walk, "share of a path": walk / once}])
    }))
}

fn arrays(plan: &Plan, device: &Device, subjects: &[Subject]) -> Result<Vec<Row>, String> {
    let mut rows = Vec::new();
    for images in [false, true] {
        let other = Device::new(&plan.adapter).map_err(|e| e.to_string())?.with_images(images);
        if other.reads_images() != images {
            rows.push(row! {"scene": "all", "error": "a kernel of this adapter cannot have enough images"});
            continue;
        }
        rows.extend(each(subjects, |subject| {
            let mut renderer = Renderer::new(&other, &subject.prepare(plan)?).map_err(|e| e.to_string())?;
            let f = measure(plan, &mut renderer)?;
            Ok(vec![row! {
                "scene": subject.name,
                "arrays": if images { "images" } else { "buffers" },
                "usual": images == device.reads_images(),
                "Mpaths/s": f.paths / f.device * 1e-6,
            }])
        }));
    }
    Ok(rows)
}

fn lanes(plan: &Plan, device: &Device, subjects: &[Subject]) -> Result<Vec<Row>, String> {
    Ok(each(&subjects[..subjects.len().min(2)], |subject| {
        let prepared = subject.prepare(plan)?;
        let pixels = plan.size[0] * plan.size[1];
        let mut rows = Vec::new();
        let mut last = 0;
        for power in (12..=22).step_by(2) {
            let mut renderer =
                instrument::with_lanes(device, &prepared, 1 << power).map_err(|e| format!("2^{power} lanes: {e}"))?;
            if renderer.lanes() == last {
                continue;
            }
            last = renderer.lanes();
            let f = measure(plan, &mut renderer)?;
            rows.push(row! {
                "scene": subject.name, "lanes": last, "of pixels": f64::from(last) / f64::from(pixels),
                "Mpaths/s": f.paths / f.device * 1e-6, "ms a dispatch": 1e3 * f.device / f.dispatches as f64,
            });
        }
        Ok(rows)
    }))
}

fn dispatches(plan: &Plan, device: &Device, subjects: &[Subject]) -> Result<Vec<Row>, String> {
    Ok(each(&subjects[..subjects.len().min(2)], |subject| {
        let mut renderer = Renderer::new(device, &subject.prepare(plan)?).map_err(|e| e.to_string())?;
        let mut rows = Vec::new();
        for milliseconds in [5, 20, 50, 200, 1000] {
            instrument::set_dispatch_durations(
                &mut renderer,
                Duration::from_millis(milliseconds),
                Duration::from_millis(4 * milliseconds),
            );
            let f = measure(plan, &mut renderer)?;
            rows.push(row! {
                "scene": subject.name, "at least ms": milliseconds, "came to ms": 1e3 * f.device / f.dispatches as f64,
                "Mpaths/s": f.paths / f.device * 1e-6, "Mpaths/s by the wall": f.paths / f.wall * 1e-6,
            });
        }
        Ok(rows)
    }))
}

/// Nothing to measure: stated, so that nobody looks for it.
fn layouts(_: &Plan, _: &Device, _: &[Subject]) -> Result<Vec<Row>, String> {
    Ok(vec![
        row! {"layout": "wide: four children of 8 bits a side, leaves of two triangles", "note": "the only one that the kernel reads"},
    ])
}
