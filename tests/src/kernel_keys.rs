//! Kernel keys: those that make sense, and those that shipped scenes need.

use std::{collections::BTreeMap, path::Path, sync::OnceLock};

use surelight_prepare::{
    CameraModel, Constant, Directions, EnvironmentKind, Estimator, Integrator, KernelKey, KeyError, Origin, Part,
    Parts, PathReuse, PointSet, Prepared, Row, Sampler, Settings, TABLE,
};
use surelight_scene::{Camera, ClipRange, LoadOptions, Scene};

use crate::{render::prepare, scenes};

/// A key with these parts, all that they need, and the first of those that they need one of.
///
/// # Errors
/// Where they exclude one another.
pub fn key_of(names: &[&str]) -> Result<KernelKey, KeyError> {
    let mut names = names.to_vec();
    loop {
        match KernelKey::from_names(&names) {
            Err(KeyError::Lacks { part }) => {
                let row = TABLE.iter().find(|row| row.name == part).expect("it is a row of the table");
                names.push(TABLE[row.needs_one_of[0] as usize].name);
            }
            other => return other,
        }
    }
}

/// Keys with as many parts as can be together: each choice has its turn, and is combined with most
/// of the others.
pub fn everything() -> Vec<KernelKey> {
    fn turn<T: Copy>(all: &[T], k: usize) -> T {
        all[k % all.len()]
    }
    let turns = 3 * Estimator::ALL.len();
    let fullest = |k: usize| {
        let round = k / Estimator::ALL.len();
        let key = |parts| {
            KernelKey::new(
                turn(&Estimator::ALL, k),
                turn(&PointSet::ALL, k + round),
                turn(&CameraModel::ALL, k + 2 * round),
                turn(&EnvironmentKind::ALL, k),
                parts,
            )
        };
        // A part follows one of its alternative requirements.
        let order = [Part::PunctualLights, Part::BaseColorTexture].into_iter().chain(TABLE.iter().map(|row| row.part));
        let others = order.filter(|part| !Parts::CHOICES.has(*part));
        let parts = others.fold(
            Parts::default(),
            |parts, part| {
                if key(parts.with(part)).is_ok() { parts.with(part) } else { parts }
            },
        );
        key(parts).ok()
    };
    let keys: Vec<_> = (0..turns).filter_map(fullest).collect();
    assert!(keys.len() > 2 * Estimator::ALL.len(), "only {} choices can be together", keys.len());
    keys
}

/// Whether the device, the settings or a choice adds the part to a kernel, and not the scene.
pub fn is_chosen_elsewhere(row: &Row) -> bool {
    matches!(row.origin, Origin::Settings | Origin::Device)
        || Parts::CHOICES.has(row.part)
        || row.part == Part::CameraClip
}

/// Constants that a kernel of any key composes with.
pub fn constants() -> &'static [Constant] {
    static CONSTANTS: OnceLock<Vec<Constant>> = OnceLock::new();
    CONSTANTS.get_or_init(|| prepare(&surelight_scenes::probes::two_triangles(), &Settings::new(8, 8)).constants())
}

/// The scenes below a folder of assets/, by name.
fn scenes_in(folder: &str) -> Vec<Scene> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../assets")).join(folder);
    let mut files: Vec<_> = std::fs::read_dir(&folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("assets/ can be listed").path())
        .filter(|path| path.extension().is_some_and(|e| e == "glb" || e == "gltf"))
        .collect();
    files.sort();
    assert!(files.len() > 5, "{} is empty", folder.display());
    let load = |path: &std::path::PathBuf| {
        surelight_scene::load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
    };
    files.iter().map(load).collect()
}

/// The scenes of assets/, the torture list's included.
pub fn asset_scenes() -> Vec<Scene> {
    [scenes_in(""), scenes_in("torture")].concat()
}

/// The scenes of assets/, the procedural ones and the general one, by name.
pub fn shipped_scenes() -> Vec<Scene> {
    let mut scenes = scenes_in("");
    scenes.extend(surelight_scenes::GALLERY.iter().map(|entry| (entry.build)()));
    scenes.extend(scenes::probes());
    scenes.push(scenes::with_everything(surelight_scenes::cornell_box::cornell_box()));
    scenes
}

/// The keys of shipped scenes, each with the scenes and settings that need it.
pub fn shipped() -> Vec<(KernelKey, Vec<String>)> {
    let mut keys: BTreeMap<Vec<&str>, (KernelKey, Vec<String>)> = BTreeMap::new();
    for scene in shipped_scenes() {
        let plain = Settings::new(8, 8);
        let settings = [
            ("", plain.clone()),
            (" --max-bounces 0", Settings { max_bounces: Some(0), ..plain.clone() }),
            (" --aperture --max-radiance", Settings { aperture: Some(0.1), max_radiance: Some(1.0), ..plain.clone() }),
            (
                " --integrator hemisphere",
                Settings { integrator: Integrator::Hemisphere(Directions::Cosine), ..plain.clone() },
            ),
            (" --integrator area", Settings { integrator: Integrator::Area, ..plain.clone() }),
            (" --integrator caustics", Settings { integrator: Integrator::Caustics, ..plain.clone() }),
            (" --integrator whitted", Settings { integrator: Integrator::Whitted, ..plain.clone() }),
            (" --sampler stratified", Settings { sampler: Sampler::Stratified, ..plain.clone() }),
            (" --shared-paths on", Settings { path_reuse: PathReuse::On, ..plain }),
        ];
        let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
        // A slab that cuts something of most scenes.
        let reach = scene.bounds().map_or(1.0, |(low, high)| {
            let eye = camera.to_world.translation;
            (low - eye).abs().max((high - eye).abs()).length()
        });
        let clipped = Camera { clip: ClipRange { near: 0.25 * reach, far: 0.5 * reach }, ..camera.clone() };
        let views = settings.map(|(options, settings)| (options, settings, &camera));
        let views = views.into_iter().chain([
            (" with clipping planes", Settings::new(8, 8), &clipped),
            (
                " with clipping planes --shared-paths on",
                Settings { path_reuse: PathReuse::On, ..Settings::new(8, 8) },
                &clipped,
            ),
        ]);
        for (options, settings, camera) in views {
            let prepared = Prepared::new(&scene, camera, &settings).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
            for items_image in [false, true] {
                let key = prepared.key().on_images(items_image);
                let names = key.rows().map(|row| row.name).collect();
                keys.entry(names).or_insert((key, Vec::new())).1.push(format!("{}{options}", scene.name));
            }
        }
    }
    keys.into_values().collect()
}
