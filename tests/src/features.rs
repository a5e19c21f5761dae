//! Feature sets: those that make sense, and those that shipped scenes need.

use std::{collections::BTreeMap, path::Path, sync::OnceLock};

use surelight_render::{Constant, Directions, Features, Integrator, Prepared, Sampler, Settings, SharedPaths};
use surelight_scene::{Camera, ClipRange, LoadOptions, Scene};
use surelight_scenes::{GALLERY, cornell_box, probes};

use crate::{render::prepare, scenes};

/// What a feature cannot be without, as the renderer decides it.
const IMPLIED: [(&str, &[&str]); 40] = [
    ("base_color_texture", &["textures"]),
    ("metallic_roughness_texture", &["textures", "ggx"]),
    ("normal_texture", &["textures", "tangents"]),
    ("emissive_texture", &["textures", "emission"]),
    ("specular_texture", &["textures", "ggx"]),
    ("specular_color_texture", &["textures", "ggx"]),
    ("transmission_texture", &["textures", "transmission", "ggx"]),
    ("textures", &["base_color_texture"]),
    ("metal", &["ggx"]),
    ("delta_lobes", &["ggx"]),
    ("transmission", &["ggx"]),
    ("volume", &["transmission", "ggx"]),
    ("nested", &["volume", "transmission", "ggx"]),
    ("volume_alpha", &["alpha", "transmission", "ggx"]),
    ("panes", &["delta_lobes", "transmission", "ggx"]),
    ("dispersion", &["transmission", "ggx"]),
    ("diffuse_transmission", &["transmission", "ggx"]),
    ("anisotropy", &["ggx", "tangents"]),
    ("iridescence", &["ggx"]),
    ("sheen", &["ggx"]),
    ("multiple_scattering", &["ggx"]),
    ("clearcoat", &["ggx"]),
    ("clearcoat_texture", &["clearcoat", "textures", "ggx"]),
    ("clearcoat_roughness_texture", &["clearcoat", "textures", "ggx"]),
    ("clearcoat_normal_texture", &["clearcoat", "textures", "tangents", "ggx"]),
    ("sheen_color_texture", &["sheen", "textures", "ggx"]),
    ("sheen_roughness_texture", &["sheen", "textures", "ggx"]),
    ("anisotropy_texture", &["anisotropy", "textures", "tangents", "ggx"]),
    ("iridescence_texture", &["iridescence", "textures", "ggx"]),
    ("iridescence_thickness_texture", &["iridescence", "textures", "ggx"]),
    ("diffuse_transmission_texture", &["diffuse_transmission", "transmission", "textures", "ggx"]),
    ("diffuse_transmission_color_texture", &["diffuse_transmission", "transmission", "textures", "ggx"]),
    ("area_lights", &["emission", "light_sampling"]),
    ("light_tree", &["area_lights", "emission", "light_sampling"]),
    ("punctual_lights", &["light_sampling"]),
    ("environment_map", &["light_sampling"]),
    ("light_sampling", &["punctual_lights"]),
    ("caustics", &["light_sampling", "punctual_lights", "delta_lobes", "ggx"]),
    ("directions_uniform", &["hemisphere"]),
    ("directions_cosine", &["hemisphere"]),
];

/// The hemisphere form samples no lights.
const UNSAMPLED: [&str; 4] = ["light_sampling", "area_lights", "light_tree", "punctual_lights"];

/// Alternatives: of each group a kernel has at most one. An empty string stands for none of them.
const ALTERNATIVES: [&[&str]; 5] = [
    &["environment_uniform", "environment_map"],
    &["orthographic", "lens", "receiver"],
    // Seven, so that each meets each of the others.
    &["", "hemisphere", "area", "whitted", "caustics", "shared_paths", ""],
    &["", "directions_uniform", "directions_cosine"],
    &["", "sampler_independent", "sampler_stratified", "one_scramble"],
];

/// Names of all features.
pub fn names() -> Vec<&'static str> {
    Features::default().list().into_iter().map(|(name, ..)| name).collect()
}

/// A set with these features and all that they imply; `None` when two of them exclude each other.
pub fn set(wanted: &[&str]) -> Option<Features> {
    let mut features = Features::default();
    for name in wanted {
        assert!(features.set(name, true), "no feature is called {name}");
        for (_, implied) in IMPLIED.iter().filter(|(of, _)| of == name) {
            implied.iter().for_each(|also| assert!(features.set(also, true), "no feature is called {also}"));
        }
    }
    if features.hemisphere {
        UNSAMPLED.iter().for_each(|name| assert!(features.set(name, false), "no feature is called {name}"));
    }
    // Whitted's few shadow rays need no tree.
    features.light_tree &= !features.whitted;
    let on = |name: &str| features.list().iter().any(|&(n, on, _)| n == name && on);
    ALTERNATIVES.iter().all(|group| group.iter().filter(|name| on(name)).count() <= 1).then_some(features)
}

/// Everything at once, as often as it takes for each alternative to have its turn.
pub fn everything() -> Vec<Features> {
    let turns = ALTERNATIVES.iter().map(|group| group.len()).max().unwrap_or(1);
    let turn = |k: usize| {
        let chosen: Vec<_> = ALTERNATIVES.iter().map(|group| group[k % group.len()]).collect();
        let others = |name: &&str| !ALTERNATIVES.iter().any(|group| group.contains(name));
        let mut wanted: Vec<_> = names().into_iter().filter(others).collect();
        wanted.extend(chosen.into_iter().filter(|name| !name.is_empty()));
        set(&wanted)
    };
    // Ways to sample directions go with one estimator alone.
    let sets: Vec<_> = (0..3 * turns).filter_map(turn).collect();
    assert!(sets.len() > turns, "too few sets have everything");
    sets
}

/// Features that a scene may lack in the general kernel: what the device or the settings choose instead.
pub fn chosen_elsewhere() -> Vec<&'static str> {
    let mut names: Vec<_> = ALTERNATIVES.iter().flat_map(|group| group.iter().copied()).collect();
    names.extend(["items_image", "multiple_scattering", "no_roulette", "repeat_walk", "adaptive", "camera_clip"]);
    names
}

/// Constants that a kernel of any features composes with.
pub fn constants() -> &'static [Constant] {
    static CONSTANTS: OnceLock<Vec<Constant>> = OnceLock::new();
    CONSTANTS.get_or_init(|| prepare(&probes::two_triangles(), &Settings::new(8, 8)).constants())
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
    scenes.extend(GALLERY.iter().map(|entry| (entry.build)()));
    scenes.extend(scenes::probes());
    scenes.push(scenes::with_everything(cornell_box::cornell_box()));
    scenes
}

/// The feature sets that shipped scenes need, each with the scenes and settings that need it.
pub fn shipped() -> Vec<(Features, Vec<String>)> {
    let mut sets: BTreeMap<Vec<bool>, (Features, Vec<String>)> = BTreeMap::new();
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
            (" --shared-paths on", Settings { shared_paths: SharedPaths::On, ..plain }),
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
                Settings { shared_paths: SharedPaths::On, ..Settings::new(8, 8) },
                &clipped,
            ),
        ]);
        for (options, settings, camera) in views {
            let prepared = Prepared::new(&scene, camera, &settings).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
            for items_image in [false, true] {
                let features = Features { items_image, ..prepared.features };
                let key = features.list().iter().map(|f| f.1).collect();
                sets.entry(key).or_insert((features, Vec::new())).1.push(format!("{}{options}", scene.name));
            }
        }
    }
    sets.into_values().collect()
}
