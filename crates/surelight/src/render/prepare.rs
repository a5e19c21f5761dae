//! The host's work before that of the device: scene, light, camera, settings.

use std::path::{Path, PathBuf};

use surelight_prepare::{Blueprint, Integrator, Prepared, Settings};
use surelight_render::{AdapterChoice, Device, PrecompiledKernel};
use surelight_scene::{Environment, Scene};

use crate::camera::{self, View};
use crate::error::Error;
use crate::options::{PathReuse, RenderArgs};
use crate::parse::{OutputPath, Selector};
use crate::{fingerprint, light, output};

/// A scene with its light, and the view of it.
pub(super) struct Loaded {
    pub(super) scene: Scene,
    pub(super) scene_hash: String,
    pub(super) view: View,
    /// Warnings of the files, then decisions that no option requested.
    pub(super) warnings: Vec<String>,
    /// Light that no path finds.
    pub(super) missing: Vec<String>,
}

impl Loaded {
    /// Reads the scene and its environment, and chooses the camera.
    pub(super) fn new(args: &RenderArgs, outputs: &[OutputPath]) -> Result<Self, Error> {
        let options = args.file.load_options();
        let mut scene = args.scene.load(&options)?;
        output::check(outputs, &args.scene.file().map_or_else(Vec::new, |path| image_files(path, &scene)))?;
        let view = camera::choose(&scene, args.scene.name(), &args.camera, args.size)?;
        let light_note = light::set(&mut scene, &args.light)?;
        let mut warnings = std::mem::take(&mut scene.warnings);
        warnings.extend(view.note.clone());
        warnings.extend(light_note);
        Ok(Self { scene_hash: fingerprint::of(&scene), scene, view, warnings, missing: Vec::new() })
    }

    /// Radiance of a uniform sky, requested or not.
    pub(super) fn sky(&self) -> Option<[f32; 3]> {
        match self.scene.environment {
            Some(Environment::Uniform(radiance)) => Some(radiance),
            _ => None,
        }
    }

    /// Builds the BVH, the lights and the textures, and compiles the kernel meanwhile.
    pub(super) fn prepare(
        &mut self,
        device: &Device,
        settings: &Settings,
    ) -> Result<(Prepared, PrecompiledKernel), Error> {
        let compile = |blueprint: &Blueprint| PrecompiledKernel::compile(device, blueprint);
        let (prepared, precompiled) = Prepared::with_work(&self.scene, &self.view.camera, settings, compile)?;
        let (broken, flat) = (prepared.accel.skipped.non_finite, prepared.accel.skipped.zero_area);
        if flat > 0 && flat + broken >= self.scene.triangle_count() as u64 {
            self.warnings.push("no triangle has an area: the picture shows the surroundings alone".into());
        }
        if broken > 0 {
            self.warnings.push(format!("{broken} triangles were left out because a corner of each is not finite"));
        }
        self.warnings.extend(camera::clipping_warning(&self.view.camera, prepared.cut));
        if let Some(why) = prepared.no_caustics {
            self.warnings.push(format!("light tracing is off because {why}: the picture is that of --integrator mis"));
        }
        for light in &prepared.unreachable {
            // Where the scene decides, or light is traced already, there is nothing else to try.
            let remedy = if prepared.choice.is_none() && prepared.integrator != Integrator::Caustics {
                " (--integrator auto finds it)"
            } else {
                ""
            };
            let text = format!("{light}{remedy}");
            if light.is_bias() {
                self.missing.push(text);
            } else {
                self.warnings.push(text);
            }
        }
        Ok((prepared, precompiled?))
    }
}

/// The adapter that `--adapter` means.
pub(crate) fn adapter_choice(adapter: Option<&Selector>) -> AdapterChoice {
    match adapter {
        None => AdapterChoice::Best,
        Some(wanted) => match wanted.index() {
            Some(index) => AdapterChoice::Index(index),
            None => AdapterChoice::Name(wanted.0.clone()),
        },
    }
}

/// The settings of the options, without an integrator that is still to be chosen.
pub(super) fn settings(args: &RenderArgs, view: &View) -> Settings {
    Settings {
        max_bounces: args.max_bounces.0,
        integrator: args.method.integrator(),
        sampler: args.method.sampler(),
        one_scramble: args.is_one_sequence(),
        path_reuse: match args.shared_paths {
            PathReuse::Auto if is_preview(args, view) => surelight_prepare::PathReuse::Off,
            PathReuse::Auto => surelight_prepare::PathReuse::Auto,
            PathReuse::On => surelight_prepare::PathReuse::On,
            PathReuse::Off => surelight_prepare::PathReuse::Off,
        },
        adaptive: args.adaptive,
        transparent: args.transparent,
        seed: args.seed,
        aperture: view.lens.map(|lens| lens.aperture),
        focus: view.lens.map(|lens| lens.focus),
        max_radiance: args.max_radiance,
        multiple_scattering: args.multiple_scattering,
        ..Settings::new(view.size.width, view.size.height)
    }
}

/// Whether so few paths are planned that those which pixels share would not make up for their
/// larger kernel, which takes half a second longer to compile (docs/performance.md).
fn is_preview(args: &RenderArgs, view: &View) -> bool {
    const MIN_PATHS: u64 = 1 << 18;
    let pixels = u64::from(view.size.width) * u64::from(view.size.height);
    args.planned().is_some_and(|spp| pixels * u64::from(spp) < MIN_PATHS)
}

/// Files of the scene that an output of the same name would destroy.
fn image_files(path: &Path, scene: &Scene) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    scene.images.iter().map(|image| folder.join(&image.name)).filter(|file| file.is_file()).collect()
}
