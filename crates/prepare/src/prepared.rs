//! A scene made ready for a device: BVH, lights, textures, records, and the key of its kernel.

use std::{borrow::Cow, collections::BTreeSet};

use surelight_accel::{Accel, Item, item::Kind};
use surelight_scene::{Camera, Environment, Scene};

use crate::{
    attributes::AttributeLayout,
    blueprint::{Blueprint, StackReserve},
    casters,
    caustics::Caustics,
    choice::{choose, may_reuse_paths, min_interreflection_share, refusal},
    clip::{ActiveClipPlanes, Planes},
    compose::Constant,
    environment::EnvironmentTable,
    error::PrepareError,
    interreflection,
    kernel_key::{Estimator, KernelKey, Part},
    light_flow::{FlowInput, LightFlow},
    lights::{LightKinds, Lights},
    luminance::luminance,
    materials::{self, PreparedMaterial},
    media,
    needs::{SceneFeatures, decide, is_smooth_pane, may_be_smooth},
    reflect::RecordLayout,
    settings::{Integrator, PathReuse, Settings},
    shared::View,
    textures::Textures,
    unreachable::{self, CameraRays, Unreachable},
};

/// A scene with a camera, ready to be uploaded.
pub struct Prepared {
    /// The BVH and the counts of skipped triangles.
    pub accel: Accel,
    /// The parts of the kernel ([`Part::ItemsImage`] is decided by the device).
    key: KernelKey,
    /// Light that the estimator cannot connect paths to.
    pub unreachable: Vec<Unreachable>,
    /// The clipping planes that remove surfaces.
    pub cut: ActiveClipPlanes,
    /// The integrator: where [`Integrator::Auto`] is set, the one that it chose.
    pub integrator: Integrator,
    /// Why [`Integrator::Auto`] chose it.
    pub choice: Option<String>,
    /// Why no light is traced from the lights, where it is requested ([`Integrator::Caustics`]).
    pub no_caustics: Option<&'static str>,
    pub(crate) caustics: Option<Caustics>,
    pub(crate) view: View,
    planes: Planes,
    pub(crate) layout: AttributeLayout,
    pub(crate) attributes: Vec<u32>,
    pub(crate) materials: Vec<PreparedMaterial>,
    pub(crate) textures: Textures,
    pub(crate) lights: Lights,
    pub(crate) environment: Option<EnvironmentTable>,
    /// By mesh, its material.
    mesh_materials: Vec<usize>,
    room: StackReserve,
}

impl Prepared {
    /// Builds the BVH around the camera (so that scenes far from the origin keep their precision)
    /// and everything else.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Result<Self, PrepareError> {
        Ok(Self::with_work(scene, camera, settings, |_| ())?.0)
    }

    /// Like [`Self::new`], with a task to run while the BVH is built, which gets the predicted
    /// inputs of the kernel: `surelight_render::Ahead::compile`.
    pub fn with_work<T>(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        work: impl FnOnce(&Blueprint) -> T,
    ) -> Result<(Self, T), PrepareError> {
        // The code below indexes without checks.
        scene.validate()?;
        let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
        // Trees and tables are independent, and are made in parallel.
        let (accel, tables, cut, work) = std::thread::scope(|scope| {
            let accel = scope.spawn(|| Accel::build(scene, camera.to_world.translation, &settings.build));
            let compensated = matches!(settings.integrator, Integrator::Mis | Integrator::Caustics | Integrator::Auto);
            let tables = Tables::new(scene, &used, compensated);
            let cut = ActiveClipPlanes::find(scene, camera, settings);
            let work = tables.blueprint(scene, camera, settings, &used, cut).map(|blueprint| work(&blueprint));
            (accel.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), tables, cut, work)
        });
        let (accel, work) = (accel?, work?);
        let Tables { materials, textures, environment, nested } = tables;

        let mut view = View::new(camera, settings, accel.origin);
        match &scene.environment {
            Some(Environment::Map { map, rotation, scale }) => {
                view.environment = [*scale; 3];
                view.environment_rotation = rotation / std::f32::consts::TAU;
                view.environment_size = [map.width, map.height];
            }
            Some(Environment::Uniform(radiance)) => view.environment = *radiance,
            None => {}
        }
        let factor = f64::from(view.environment[0]);
        let sky = sampled_sky(environment.as_ref(), settings, factor);
        let lights = Lights::new(scene, &accel, settings.integrator, sky);
        view.light_density = lights.density;
        view.environment_probability = lights.environment_probability;
        view.light_count = lights.table.len() as u32;

        let smooth: Vec<bool> =
            (0..materials.len()).map(|i| used.contains(&i) && may_be_smooth(&materials[i])).collect();
        let used_materials: Vec<&PreparedMaterial> = used.iter().map(|&i| &materials[i]).collect();
        let planes = Planes::new(camera, cut);
        let found = SceneFeatures {
            lights: lights.kinds(),
            environment_map: environment.is_some(),
            instances: !accel.instances.is_empty(),
            clipped: cut.any(),
            nested,
        };
        let key = decide(scene, camera, settings, &used_materials, &found)?;
        let balls = casters::cover(casters::triangles(scene, accel.origin, &smooth));
        let flow = LightFlow::new(&FlowInput {
            scene,
            accel: &accel,
            camera,
            view: &view,
            planes: &planes,
            area: &lights.area,
            sky: environment.as_ref().map(|table| (table, factor)),
            uniform_sky: match &scene.environment {
                Some(Environment::Uniform(radiance)) => luminance(*radiance),
                _ => 0.0,
            },
            balls: &balls,
        });
        let mut caustics = None;
        let mut no_caustics = None;
        if matches!(settings.integrator, Integrator::Caustics | Integrator::Auto) {
            let sky = environment.as_ref().map(|table| (table, factor));
            let traced = match refusal(settings, &key, cut) {
                None => {
                    let volume = key.has(Part::Volume);
                    Caustics::new(scene, camera, &accel, &lights, sky, &balls, volume, flow.delta_share)
                }
                Some(why) => Err(why),
            };
            match traced {
                Ok(traced) => caustics = Some(traced),
                Err(why) => no_caustics = Some(why),
            }
        }
        let shares = |integrator| {
            let settings = Settings { integrator, ..settings.clone() };
            may_reuse_paths(&settings, &key)
                && match settings.path_reuse {
                    PathReuse::Off => false,
                    PathReuse::Auto => {
                        interreflection::share(scene, &accel, camera, &view, &planes) >= min_interreflection_share(&key)
                    }
                    PathReuse::On => true,
                }
        };
        let mut choice = None;
        let mut integrator = settings.integrator;
        if integrator == Integrator::Auto {
            let (chosen, why) = choose(&flow, no_caustics, || shares(Integrator::Mis));
            (integrator, choice) = (chosen, Some(why));
            caustics = caustics.filter(|_| chosen == Integrator::Caustics);
            no_caustics = None;
        }
        // Without light sampling nothing is connected at all, which is reported of the method.
        let unreachable = match integrator {
            Integrator::Hemisphere(_) => Vec::new(),
            _ => {
                let eye = caustics.is_some().then(|| CameraRays::new(camera, &view, planes));
                unreachable::find(scene, &accel, &flow, eye.as_ref())
            }
        };
        let key = if caustics.is_some() {
            key.with_estimator(Estimator::LightTracing)?
        } else if shares(integrator) {
            key.with_estimator(Estimator::PathReuse)?
        } else {
            key
        };
        let layout = AttributeLayout::of(scene, &key);
        let attributes = layout.pack(scene, &accel, &key, &lights.triangle_words());
        let light_levels = lights.tree.as_ref().map_or(0, |tree| tree.depth);
        // One more than the traversal needs, since it writes the next entry whether or not it is
        // kept.
        let room = StackReserve::likely(scene).for_depths(accel.stack_depth + 2, light_levels);
        let prepared = Self {
            accel,
            key,
            unreachable,
            integrator,
            choice,
            cut,
            no_caustics,
            caustics,
            view,
            planes,
            layout,
            attributes,
            materials,
            textures,
            lights,
            environment,
            mesh_materials: scene.meshes.iter().map(|mesh| mesh.material).collect(),
            room,
        };
        Ok((prepared, work))
    }

    /// The inputs of the path kernel.
    pub fn blueprint(&self) -> Blueprint {
        let constants = path_constants(self.room, &self.layout, self.environment.as_ref(), &self.planes);
        Blueprint { key: self.key, constants }
    }

    /// The parts of the kernel; the device adds [`Part::ItemsImage`].
    pub fn key(&self) -> KernelKey {
        self.key
    }

    /// The same with an instrument in the kernel, for measurements and tests.
    #[must_use]
    pub fn instrumented(self, instrument: Instrument) -> Self {
        let part = match instrument {
            Instrument::RepeatedTraversal => Part::RepeatWalk,
            Instrument::NoRoulette => Part::NoRoulette,
        };
        Self { key: self.key.instrumented(part), ..self }
    }

    /// Constants that kernels are specialised with.
    pub fn constants(&self) -> Vec<Constant> {
        let mut constants = path_constants(self.room, &self.layout, self.environment.as_ref(), &self.planes);
        // The light tracing kernel's own.
        let caustics = self.caustics.as_ref();
        constants.push(Constant { name: "CASTERS", value: caustics.map_or(1, Caustics::count) });
        constants.push(Constant { name: "EMITTERS", value: caustics.map_or(1, |c| c.table.len() as u32) });
        constants
    }

    /// The BVH's items. Those of triangles that are panes have a bit for each of the two in
    /// word 14.
    pub(crate) fn items(&self) -> Cow<'_, [Item]> {
        if !self.key.has(Part::Panes) {
            return Cow::Borrowed(&self.accel.items);
        }
        let panes: Vec<bool> = self.materials.iter().map(is_smooth_pane).collect();
        let is_pane = |prim: u32| {
            let mesh = self.accel.triangles[prim as usize].mesh;
            u32::from(panes[self.mesh_materials[mesh as usize]])
        };
        let mut items = self.accel.items.clone();
        for item in items.iter_mut().filter(|item| item.kind() == Kind::Pair) {
            item.0[14] = is_pane(item.0[12]) | is_pane(item.0[13]) << 1;
        }
        Cow::Owned(items)
    }

    pub(crate) fn material_records(&self, layout: &RecordLayout) -> Vec<u8> {
        materials::write(&self.materials, layout)
    }
}

/// Additions to a kernel by measurements and tests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
    /// Rays are traversed several times (`surelight_render::instrument`).
    RepeatedTraversal,
    /// Paths end at the bounce limit alone.
    NoRoulette,
}

/// Constants that the path kernel is specialised with.
fn path_constants(
    room: StackReserve,
    layout: &AttributeLayout,
    environment: Option<&EnvironmentTable>,
    planes: &Planes,
) -> Vec<Constant> {
    let mut constants = room.constants(layout);
    let source_pdf = environment.map_or(f32::INFINITY, |table| table.source_pdf);
    constants.push(Constant { name: "SOURCE_PDF", value: source_pdf.to_bits() });
    let [near, far] = planes.bits();
    constants.push(Constant { name: "CLIP_NEAR", value: near });
    constants.push(Constant { name: "CLIP_FAR", value: far });
    constants
}

/// The part of a prepared scene that needs no trees.
struct Tables {
    materials: Vec<PreparedMaterial>,
    textures: Textures,
    environment: Option<EnvironmentTable>,
    /// Whether volumes overlap.
    nested: bool,
}

impl Tables {
    /// `compensated`: for multiple importance sampling.
    fn new(scene: &Scene, used: &BTreeSet<usize>, compensated: bool) -> Self {
        let mut textures = Textures::default();
        let unused = surelight_scene::Material { unlit: true, ..Default::default() };
        let of = |i: usize| if used.contains(&i) { &scene.materials[i] } else { &unused };
        let mut materials: Vec<_> =
            (0..scene.materials.len()).map(|i| PreparedMaterial::new(scene, of(i), &mut textures)).collect();
        let environment = match &scene.environment {
            Some(Environment::Map { map, .. }) => EnvironmentTable::new(map, compensated),
            _ => None,
        };
        let media = media::rank(scene);
        let nested = !media.is_empty();
        for (material, medium) in materials.iter_mut().zip(media) {
            material.medium = medium;
        }
        Self { materials, textures, environment, nested }
    }

    /// The predicted inputs of the scene's kernel: right unless a tree is uncommonly deep or part
    /// of the scene is invisible.
    fn blueprint(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        used: &BTreeSet<usize>,
        cut: ActiveClipPlanes,
    ) -> Result<Blueprint, PrepareError> {
        let scale = match &scene.environment {
            Some(Environment::Map { scale, .. }) => f64::from(*scale),
            _ => 0.0,
        };
        let sky = sampled_sky(self.environment.as_ref(), settings, scale).is_some();
        let lights = LightKinds::expected(scene, settings.integrator, sky);
        let used_materials: Vec<&PreparedMaterial> = used.iter().map(|&i| &self.materials[i]).collect();
        let found = SceneFeatures {
            lights,
            environment_map: self.environment.is_some(),
            instances: surelight_accel::expects_instances(scene, &settings.build),
            clipped: cut.any(),
            nested: self.nested,
        };
        let key = decide(scene, camera, settings, &used_materials, &found)?;
        // Wrong where nothing smooth is visible, say, or the camera is inside glass. Panes alone
        // seldom reflect light onto surfaces.
        let bends = |m: &&PreparedMaterial| may_be_smooth(m) && !is_smooth_pane(m);
        let traced = match settings.integrator {
            Integrator::Caustics => key.has(Part::DeltaLobes),
            Integrator::Auto => used_materials.iter().any(bends),
            _ => false,
        } && key.has(Part::LightSampling)
            && refusal(settings, &key, cut).is_none();
        // How much light surfaces send one another is known with the trees; where none is glossy,
        // sharing is cheap and likely.
        let integrator = match settings.integrator {
            Integrator::Auto if traced => Integrator::Caustics,
            Integrator::Auto => Integrator::Mis,
            other => other,
        };
        let shared = may_reuse_paths(&Settings { integrator, ..settings.clone() }, &key)
            && (settings.path_reuse == PathReuse::On || settings.path_reuse == PathReuse::Auto && !key.has(Part::Ggx));
        let key = if traced {
            key.with_estimator(Estimator::LightTracing)?
        } else if shared {
            key.with_estimator(Estimator::PathReuse)?
        } else {
            key
        };
        let layout = AttributeLayout::of(scene, &key);
        let constants =
            path_constants(StackReserve::likely(scene), &layout, self.environment.as_ref(), &Planes::new(camera, cut));
        Ok(Blueprint { key, constants })
    }
}

/// ∫ luminance dω of an environment map that directions are sampled from.
fn sampled_sky(environment: Option<&EnvironmentTable>, settings: &Settings, scale: f64) -> Option<f64> {
    // Whitted sends shadow rays to lights with a middle; an environment has none.
    let sampled = environment.filter(|_| settings.integrator != Integrator::Whitted);
    sampled.map(|e| e.total * scale).filter(|&e| e > 0.0)
}
