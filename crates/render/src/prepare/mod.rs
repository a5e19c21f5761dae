//! A scene made ready for the device: BVH, lights, textures, records, and the features that its kernel needs.

mod alias;
mod attributes;
mod blueprint;
mod casters;
mod caustics;
mod clip;
mod emitters;
mod environment;
mod instances;
mod interreflection;
mod light_flow;
mod light_tree;
mod lights;
mod lobes;
mod materials;
mod media;
mod microfacets;
mod octahedral;
mod parallelograms;
mod settings;
mod sheen;
mod slots;
mod textures;
mod unreachable;
mod view;

use std::{borrow::Cow, collections::BTreeSet};

use surelight_accel::{Accel, Item, item::Kind};
use surelight_scene::{AlphaMode, Camera, Environment, Projection, Scene};

use self::{
    attributes::AttributeLayout,
    blueprint::Room,
    caustics::{Caustics, NOTHING_SMOOTH},
    clip::Planes,
    environment::EnvironmentTable,
    light_flow::{FlowInput, LightFlow},
    lights::{LightKinds, Lights},
    lobes::{
        has_alpha_volume, has_facets, has_film, is_anisotropic, is_coated, is_dispersive, is_fibrous, is_glossy,
        is_pane, sends_through, transmits,
    },
    materials::PreparedMaterial,
    slots::Slot,
    textures::Textures,
    unreachable::Eye,
};
use crate::{
    compose::Constant,
    error::RenderError,
    kernel_key::{CameraModel, Estimator, KernelKey, Part, Parts, Points, Surroundings},
    reflect::RecordLayout,
};

pub(crate) use self::microfacets::facet_albedos;
pub use self::settings::{Directions, Integrator, Sampler, Settings, SharedPaths};
pub use self::{
    blueprint::Blueprint, clip::Cut, materials::material_fields, sheen::sheen_albedos, unreachable::Unreachable,
};
pub(crate) use self::{
    instances::InstanceRows,
    light_tree::{LightNode, LightPath},
    lights::{AreaLight, LightEntry, PunctualLight},
    textures::TextureUse,
    view::View,
};

/// A scene seen by a camera, ready to be uploaded.
pub struct Prepared {
    /// The BVH and what was skipped on the way.
    pub accel: Accel,
    /// What the kernel will contain ([`Part::ItemsImage`] is left to the device).
    key: KernelKey,
    /// Light that the estimator cannot connect paths to.
    pub unreachable: Vec<Unreachable>,
    /// What the camera's clipping planes cut off the picture.
    pub cut: Cut,
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
    room: Room,
}

impl Prepared {
    /// Builds the BVH around the camera (so that scenes far from the origin keep their precision) and everything else.
    pub fn new(scene: &Scene, camera: &Camera, settings: &Settings) -> Result<Self, RenderError> {
        Ok(Self::with_work(scene, camera, settings, |_| ())?.0)
    }

    /// Likewise, with something to do while the BVH is built, told what the kernel will most probably be made from:
    /// [`crate::Ahead::compile`].
    pub fn with_work<T>(
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        work: impl FnOnce(&Blueprint) -> T,
    ) -> Result<(Self, T), RenderError> {
        // What follows indexes without checks.
        scene.validate()?;
        let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
        // Trees and tables know nothing of each other, and are made side by side.
        let (accel, tables, cut, work) = std::thread::scope(|scope| {
            let accel = scope.spawn(|| Accel::build(scene, camera.to_world.translation, &settings.build));
            let compensated = matches!(settings.integrator, Integrator::Mis | Integrator::Caustics | Integrator::Auto);
            let tables = Tables::new(scene, &used, compensated);
            let cut = Cut::find(scene, camera, settings);
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
        let found = Found {
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
            may_share_paths(&settings, &key)
                && match settings.shared_paths {
                    SharedPaths::Off => false,
                    SharedPaths::Auto => {
                        interreflection::share(scene, &accel, camera, &view, &planes) >= least_interreflection(&key)
                    }
                    SharedPaths::On => true,
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
                let eye = caustics.is_some().then(|| Eye::new(camera, &view, planes));
                unreachable::find(scene, &accel, &flow, eye.as_ref())
            }
        };
        let key = if caustics.is_some() {
            key.by(Estimator::LightTracing)?
        } else if shares(integrator) {
            key.by(Estimator::PathReuse)?
        } else {
            key
        };
        let layout = AttributeLayout::of(scene, &key);
        let attributes = layout.pack(scene, &accel, &key, &lights.triangle_words());
        let light_levels = lights.tree.as_ref().map_or(0, |tree| tree.depth);
        // One more than the walk needs, since it writes the next entry whether or not it is kept.
        let room = Room::likely(scene).for_depths(accel.stack_depth + 2, light_levels);
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

    /// What the path kernel is made from.
    pub fn blueprint(&self) -> Blueprint {
        let constants = path_constants(self.room, &self.layout, self.environment.as_ref(), &self.planes);
        Blueprint { key: self.key, constants }
    }

    /// What the kernel will contain; the device adds [`Part::ItemsImage`].
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

    /// The BVH's items. Those of triangles that are panes have a bit for each of the two in word 14.
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

/// What measurements and tests add to a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Instrument {
    /// Rays are traversed several times ([`crate::Renderer::set_walks`]).
    RepeatedTraversal,
    /// Paths end at the bounce limit alone.
    NoRoulette,
}

/// Constants that the path kernel is specialised with.
fn path_constants(
    room: Room,
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

/// What is made of a scene without its trees.
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

    /// What the scene's kernel will be made from, unless a tree is uncommonly deep or something in the scene cannot be seen.
    fn blueprint(
        &self,
        scene: &Scene,
        camera: &Camera,
        settings: &Settings,
        used: &BTreeSet<usize>,
        cut: Cut,
    ) -> Result<Blueprint, RenderError> {
        let scale = match &scene.environment {
            Some(Environment::Map { scale, .. }) => f64::from(*scale),
            _ => 0.0,
        };
        let sky = sampled_sky(self.environment.as_ref(), settings, scale).is_some();
        let lights = LightKinds::expected(scene, settings.integrator, sky);
        let used_materials: Vec<&PreparedMaterial> = used.iter().map(|&i| &self.materials[i]).collect();
        let found = Found {
            lights,
            environment_map: self.environment.is_some(),
            instances: surelight_accel::expects_instances(scene, &settings.build),
            clipped: cut.any(),
            nested: self.nested,
        };
        let key = decide(scene, camera, settings, &used_materials, &found)?;
        // Not so where nothing smooth can be seen, say, or the camera is inside glass. Panes alone seldom reflect light onto surfaces.
        let bends = |m: &&PreparedMaterial| may_be_smooth(m) && !is_smooth_pane(m);
        let traced = match settings.integrator {
            Integrator::Caustics => key.has(Part::DeltaLobes),
            Integrator::Auto => used_materials.iter().any(bends),
            _ => false,
        } && key.has(Part::LightSampling)
            && refusal(settings, &key, cut).is_none();
        // How much light surfaces send one another is known with the trees; where none is glossy, sharing is cheap and likely.
        let integrator = match settings.integrator {
            Integrator::Auto if traced => Integrator::Caustics,
            Integrator::Auto => Integrator::Mis,
            other => other,
        };
        let shared = may_share_paths(&Settings { integrator, ..settings.clone() }, &key)
            && (settings.shared_paths == SharedPaths::On
                || settings.shared_paths == SharedPaths::Auto && !key.has(Part::Ggx));
        let key = if traced {
            key.by(Estimator::LightTracing)?
        } else if shared {
            key.by(Estimator::PathReuse)?
        } else {
            key
        };
        let layout = AttributeLayout::of(scene, &key);
        let constants =
            path_constants(Room::likely(scene), &layout, self.environment.as_ref(), &Planes::new(camera, cut));
        Ok(Blueprint { key, constants })
    }
}

/// ∫ luminance dω of an environment map that directions are sampled from.
fn sampled_sky(environment: Option<&EnvironmentTable>, settings: &Settings, scale: f64) -> Option<f64> {
    // Whitted sends shadow rays to lights with a middle; an environment has none.
    let sampled = environment.filter(|_| settings.integrator != Integrator::Whitted);
    sampled.map(|e| e.total * scale).filter(|&e| e > 0.0)
}

/// What lights, trees and tables say of a scene.
struct Found {
    lights: LightKinds,
    environment_map: bool,
    instances: bool,
    /// Whether the camera's near or far plane cuts something off.
    clipped: bool,
    /// Whether volumes overlap.
    nested: bool,
}

/// What the scene needs, and no more. Reuse of paths and light tracing are decided later.
fn decide(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    materials: &[&PreparedMaterial],
    found: &Found,
) -> Result<KernelKey, RenderError> {
    let any = |test: &dyn Fn(&surelight_scene::Material) -> bool| materials.iter().any(|m| test(&m.material));
    let placed = || scene.instances.iter().map(|i| &scene.meshes[i.mesh]);
    let absorbs = |m: &surelight_scene::Material| {
        m.volume.is_some_and(|v| v.attenuation_distance.is_finite() && v.attenuation_color.iter().any(|&c| c < 1.0))
    };
    let whitted = settings.integrator == Integrator::Whitted;
    // Paths of no bounce sample no light.
    let sampled = |kind: bool| kind && settings.max_bounces != Some(0);
    let glossy = any(&is_glossy);
    let needs = [
        (found.instances, Part::Instances),
        (placed().any(|m| m.normals.is_some()), Part::VertexNormals),
        (placed().any(|m| m.colors.is_some()), Part::VertexColors),
        (any(&|m| m.alpha_mode != AlphaMode::Opaque), Part::Alpha),
        (glossy, Part::Ggx),
        (any(&|m| !m.unlit && m.metallic > 0.0), Part::Metal),
        // Whitted takes all that is nearly smooth for a mirror.
        (materials.iter().any(|m| may_be_smooth(m)) || whitted && glossy, Part::DeltaLobes),
        (any(&transmits), Part::Transmission),
        (any(&is_dispersive), Part::Dispersion),
        (any(&sends_through), Part::DiffuseTransmission),
        (any(&is_anisotropic), Part::Anisotropy),
        (any(&has_film), Part::Iridescence),
        (any(&is_fibrous), Part::Sheen),
        (any(&is_coated), Part::Clearcoat),
        (any(&|m| transmits(m) && absorbs(m)), Part::Volume),
        (found.nested, Part::Nested),
        (any(&has_alpha_volume), Part::VolumeAlpha),
        (!whitted && materials.iter().any(|m| is_smooth_pane(m)), Part::Panes),
        (any(&|m| m.unlit), Part::Unlit),
        (any(&|m| m.is_emissive()), Part::Emission),
        (sampled(found.lights.any), Part::LightSampling),
        (sampled(found.lights.area), Part::AreaLights),
        (sampled(found.lights.tree), Part::LightTree),
        (sampled(found.lights.punctual), Part::PunctualLights),
        (found.clipped, Part::CameraClip),
        (settings.multiple_scattering && glossy, Part::MultipleScattering),
        (settings.max_radiance.is_some(), Part::ClampRadiance),
        (settings.adaptive, Part::Adaptive),
        (settings.transparent, Part::Transparent),
    ];
    let slots = Slot::ALL.into_iter().map(|slot| (materials.iter().any(|m| m.has(slot)), slot.part()));
    let parts: Parts = needs.into_iter().chain(slots).filter(|(needed, _)| *needed).map(|(_, part)| part).collect();
    let method = match settings.integrator {
        Integrator::Hemisphere(directions) => Estimator::Hemisphere(directions),
        Integrator::Area => Estimator::Area,
        Integrator::Whitted => Estimator::Whitted,
        Integrator::Mis | Integrator::Caustics | Integrator::Auto => Estimator::Mis,
    };
    let has_aperture = settings.aperture.is_some_and(|aperture| aperture > 0.0);
    let camera = match camera.projection {
        _ if settings.receiver => CameraModel::Receiver,
        Projection::Orthographic { .. } => CameraModel::Orthographic,
        Projection::Perspective { .. } if has_aperture => CameraModel::ThinLens,
        Projection::Perspective { .. } => CameraModel::Pinhole,
    };
    let surroundings = match &scene.environment {
        _ if found.environment_map => Surroundings::Map,
        Some(Environment::Uniform(radiance)) if radiance.iter().any(|&c| c > 0.0) => Surroundings::Uniform,
        _ => Surroundings::Black,
    };
    let points = Points::new(settings.sampler, settings.one_scramble);
    Ok(KernelKey::new(method, points, camera, surroundings, parts)?)
}

/// Of the light that surfaces scatter, the share that may be missing before [`Integrator::Auto`] traces it from the lights.
const MAX_MISSING: f64 = 1e-3;

/// Shares below this are none.
const MIN_DELTA_SHARE: f64 = 1e-4;

/// From this relative variance per sample on, tracing light from the lights pays for itself (docs/performance.md), and from the second
/// where neighbours would share paths instead.
const MIN_CHANCE_NOISE: [f64; 2] = [0.5, 1.5];

/// What [`Integrator::Auto`] stands for, and why. `shares`: whether neighbours would share paths without particles.
fn choose(flow: &LightFlow, refused: Option<&'static str>, shares: impl FnOnce() -> bool) -> (Integrator, String) {
    let percent = |share: f64| format!("{:.*} %", usize::from(share < 0.1), 100.0 * share);
    let share = percent(flow.delta_share);
    if refused == Some(NOTHING_SMOOTH) {
        return (Integrator::Mis, NOTHING_SMOOTH.into());
    }
    if let Some(why) = refused {
        let share = if flow.delta_share > 0.0 {
            format!("{share} of the light on surfaces comes by mirrors or smooth glass, but ")
        } else {
            String::new()
        };
        return (Integrator::Mis, format!("{share}{why}"));
    }
    if flow.missing_share >= MAX_MISSING {
        let missing = percent(flow.missing_share);
        let why =
            format!("{missing} of the light on surfaces comes by mirrors or smooth glass from lights without extent");
        return (Integrator::Caustics, why);
    }
    let noise = flow.chance_noise;
    if flow.delta_share < MIN_DELTA_SHARE {
        return (Integrator::Mis, "hardly any light comes to surfaces by mirrors or smooth glass".into());
    }
    if noise < MIN_CHANCE_NOISE[0] || noise < MIN_CHANCE_NOISE[1] && shares() {
        let why =
            format!("{share} of the light on surfaces comes by mirrors or smooth glass, and is easily found by chance");
        return (Integrator::Mis, why);
    }
    (
        Integrator::Caustics,
        format!("{share} of the light on surfaces comes by mirrors or smooth glass, and is hardly found by chance"),
    )
}

/// Why light cannot be traced from the lights, whatever the scene holds.
fn refusal(settings: &Settings, key: &KernelKey, cut: Cut) -> Option<&'static str> {
    if key.has(Part::Volume) && cut.medium {
        return Some("the camera's near plane cuts an absorbing medium");
    }
    let short = settings.max_bounces.is_some_and(|most| most < 2);
    key.objection(Estimator::LightTracing).or(short.then_some("paths are too short for it"))
}

/// Whether some surface of a scene may be so smooth that [`Integrator::Caustics`] differs from [`Integrator::Mis`].
pub fn may_have_caustics(scene: &Scene) -> bool {
    let mut textures = Textures::default();
    let smooth = |m: &surelight_scene::Material| may_be_smooth(&PreparedMaterial::new(scene, m, &mut textures));
    let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
    used.into_iter().map(|i| &scene.materials[i]).any(smooth)
}

/// Whether there is something that neighbours can share, and nothing that keeps them from it.
fn may_share_paths(settings: &Settings, key: &KernelKey) -> bool {
    let light = [Part::LightSampling, Part::Emission, Part::EnvironmentUniform, Part::EnvironmentMap];
    settings.integrator == Integrator::Mis
        && light.into_iter().any(|part| key.has(part))
        && settings.max_bounces.is_none_or(|most| most > 1)
        && key.objection(Estimator::PathReuse).is_none()
}

/// From here on [`SharedPaths::Auto`] has paths shared (docs/performance.md). Where surfaces are glossy, sharing costs more.
fn least_interreflection(key: &KernelKey) -> f64 {
    if key.has(Part::Ggx) { 0.6 } else { 0.35 }
}

/// Whether light may go straight through some of the surface.
fn is_smooth_pane(m: &PreparedMaterial) -> bool {
    is_pane(&m.material, m.material.roughness < 0.0101 || m.has(Slot::MetallicRoughness))
}

/// Whether α can fall below the kernel's ALPHA_SMOOTH = 1e-4, where lobes are deltas.
fn may_be_smooth(m: &PreparedMaterial) -> bool {
    let coat = &m.material.clearcoat;
    has_facets(&m.material) && (m.material.roughness < 0.0101 || m.has(Slot::MetallicRoughness))
        || is_coated(&m.material) && (coat.roughness < 0.0101 || m.has(Slot::ClearcoatRoughness))
}

/// Rec. 709 luminance.
pub(crate) fn luminance(c: [f32; 3]) -> f64 {
    0.2126 * f64::from(c[0]) + 0.7152 * f64::from(c[1]) + 0.0722 * f64::from(c[2])
}
