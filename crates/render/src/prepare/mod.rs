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

use std::collections::BTreeSet;

use surelight_accel::{Accel, BuildOptions, Layout};
use surelight_scene::{AlphaMode, Camera, Environment, Projection, Scene};

use self::{
    attributes::AttributeLayout,
    blueprint::Room,
    caustics::Caustics,
    clip::Planes,
    environment::EnvironmentTable,
    lights::{LightKinds, Lights},
    lobes::{
        has_facets, has_film, is_anisotropic, is_coated, is_dispersive, is_fibrous, is_glossy, sends_through, transmits,
    },
    materials::PreparedMaterial,
    slots::Slot,
    textures::Textures,
    unreachable::Eye,
};
use crate::{compose::Constant, error::RenderError, features::Features, reflect::RecordLayout};

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
    /// What the kernel will contain (`items_image` is left to the device).
    pub features: Features,
    /// Light that the estimator cannot connect paths to.
    pub unreachable: Vec<Unreachable>,
    /// What the camera's clipping planes cut off the picture.
    pub cut: Cut,
    /// Why no light is traced from the lights, where it was asked for ([`Integrator::Caustics`]).
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
        // The kernel reads one layout only.
        let build = BuildOptions { layout: Layout::Wide, ..settings.build };
        let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
        // Trees and tables know nothing of each other, and are made side by side.
        let (accel, tables, cut, work) = std::thread::scope(|scope| {
            let accel = scope.spawn(|| Accel::build(scene, camera.to_world.translation, &build));
            let compensated = matches!(settings.integrator, Integrator::Mis | Integrator::Caustics);
            let tables = Tables::new(scene, &used, compensated);
            let cut = Cut::find(scene, camera, settings);
            let work = work(&tables.blueprint(scene, camera, settings, &used, cut));
            (accel.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)), tables, cut, work)
        });
        let accel = accel?;
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
        let mut features = decide(scene, camera, settings, &used_materials, lights.kinds(), environment.is_some());
        features.instances = !accel.instances.is_empty();
        features.camera_clip = cut.any();
        let planes = Planes::new(camera, cut);
        features.nested = nested;
        features.volume |= nested;
        let (caustics, no_caustics) = if settings.integrator == Integrator::Caustics {
            let sky = environment.as_ref().map(|table| (table, factor));
            match refusal(settings, &features, cut) {
                None => Caustics::new(scene, camera, &accel, &lights, sky, &smooth, features.volume),
                Some(why) => Err(why),
            }
            .map_or_else(|why| (None, Some(why)), |caustics| (Some(caustics), None))
        } else {
            (None, None)
        };
        features.caustics = caustics.is_some();
        // Without light sampling nothing is connected at all, which is told of the method.
        let unreachable = match settings.integrator {
            Integrator::Hemisphere(_) => Vec::new(),
            _ => {
                let eye = caustics.is_some().then(|| Eye::new(camera, &view, planes));
                unreachable::find(scene, &accel, &lights.area, scene.environment.is_some(), eye.as_ref())
            }
        };
        features.shared_paths = may_share_paths(settings, &features)
            && match settings.shared_paths {
                SharedPaths::Off => false,
                SharedPaths::Auto => {
                    interreflection::share(scene, &accel, camera, &view, &planes) >= least_interreflection(&features)
                }
                SharedPaths::On => true,
            };
        let layout = AttributeLayout::of(scene, &features);
        let attributes = layout.pack(scene, &accel, &features, &lights.triangle_words());
        let light_levels = lights.tree.as_ref().map_or(0, |tree| tree.depth);
        // One more than the walk needs, since it writes the next entry whether or not it is kept.
        let room = Room::likely(scene).for_depths(accel.stack_depth + 2, light_levels);
        let prepared = Self {
            accel,
            features,
            unreachable,
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
            room,
        };
        Ok((prepared, work))
    }

    /// What the path kernel is made from.
    pub fn blueprint(&self) -> Blueprint {
        let constants = path_constants(self.room, &self.layout, self.environment.as_ref(), &self.planes);
        Blueprint { features: self.features, constants }
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

    pub(crate) fn material_records(&self, layout: &RecordLayout) -> Vec<u8> {
        materials::write(&self.materials, layout)
    }
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
    ) -> Blueprint {
        let scale = match &scene.environment {
            Some(Environment::Map { scale, .. }) => f64::from(*scale),
            _ => 0.0,
        };
        let sky = sampled_sky(self.environment.as_ref(), settings, scale).is_some();
        let lights = LightKinds::expected(scene, settings.integrator, sky);
        let used_materials: Vec<&PreparedMaterial> = used.iter().map(|&i| &self.materials[i]).collect();
        let mut features = decide(scene, camera, settings, &used_materials, lights, self.environment.is_some());
        features.instances = surelight_accel::expects_instances(scene, &settings.build);
        features.camera_clip = cut.any();
        features.nested = self.nested;
        features.volume |= self.nested;
        // Not so where nothing smooth can be seen, say, or the camera is inside glass.
        let traced = settings.integrator == Integrator::Caustics && features.delta_lobes && features.light_sampling;
        features.caustics = traced && refusal(settings, &features, cut).is_none();
        // How much light surfaces send one another is known with the trees; where none is glossy, sharing is cheap and likely.
        features.shared_paths = may_share_paths(settings, &features)
            && (settings.shared_paths == SharedPaths::On
                || settings.shared_paths == SharedPaths::Auto && !features.ggx);
        let layout = AttributeLayout::of(scene, &features);
        let constants =
            path_constants(Room::likely(scene), &layout, self.environment.as_ref(), &Planes::new(camera, cut));
        Blueprint { features, constants }
    }
}

/// ∫ luminance dω of an environment map that directions are sampled from.
fn sampled_sky(environment: Option<&EnvironmentTable>, settings: &Settings, scale: f64) -> Option<f64> {
    // Whitted sends shadow rays to lights with a middle; an environment has none.
    let sampled = environment.filter(|_| settings.integrator != Integrator::Whitted);
    sampled.map(|e| e.total * scale).filter(|&e| e > 0.0)
}

/// Only what the scene needs.
fn decide(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    materials: &[&PreparedMaterial],
    lights: LightKinds,
    environment_map: bool,
) -> Features {
    let any = |test: &dyn Fn(&surelight_scene::Material) -> bool| materials.iter().any(|m| test(&m.material));
    let texture = |slot| materials.iter().any(|m| m.has(slot));
    let placed = || scene.instances.iter().map(|i| &scene.meshes[i.mesh]);
    let absorbs = |m: &surelight_scene::Material| {
        m.volume.is_some_and(|v| v.attenuation_distance.is_finite() && v.attenuation_color.iter().any(|&c| c < 1.0))
    };
    let emission = any(&|m| m.is_emissive());
    let mut features = Features {
        instances: false, // the BVH decides
        vertex_normals: placed().any(|m| m.normals.is_some()),
        vertex_colors: placed().any(|m| m.colors.is_some()),
        tangents: texture(Slot::Normal) || texture(Slot::ClearcoatNormal) || any(&is_anisotropic),
        textures: Slot::ALL.into_iter().any(texture),
        alpha: any(&|m| m.alpha_mode != AlphaMode::Opaque),
        ggx: any(&is_glossy),
        metal: any(&|m| !m.unlit && m.metallic > 0.0),
        // Whitted takes all that is nearly smooth for a mirror.
        delta_lobes: materials.iter().any(|m| may_be_smooth(m))
            || settings.integrator == Integrator::Whitted && any(&is_glossy),
        transmission: any(&transmits),
        dispersion: any(&is_dispersive),
        diffuse_transmission: any(&sends_through),
        anisotropy: any(&is_anisotropic),
        iridescence: any(&has_film),
        sheen: any(&is_fibrous),
        clearcoat: any(&is_coated),
        volume: any(&|m| transmits(m) && absorbs(m)),
        unlit: any(&|m| m.unlit),
        emission,
        light_sampling: lights.any && settings.max_bounces != Some(0),
        area_lights: lights.area && settings.max_bounces != Some(0),
        light_tree: lights.tree && settings.max_bounces != Some(0),
        punctual_lights: lights.punctual && settings.max_bounces != Some(0),
        environment_uniform: matches!(&scene.environment, Some(Environment::Uniform(c)) if c.iter().any(|&c| c > 0.0)),
        environment_map,
        orthographic: matches!(camera.projection, Projection::Orthographic { .. }),
        lens: settings.aperture.is_some_and(|a| a > 0.0) && matches!(camera.projection, Projection::Perspective { .. }),
        receiver: settings.receiver,
        multiple_scattering: settings.multiple_scattering && any(&is_glossy),
        clamp_radiance: settings.max_radiance.is_some(),
        hemisphere: matches!(settings.integrator, Integrator::Hemisphere(_)),
        area: settings.integrator == Integrator::Area,
        whitted: settings.integrator == Integrator::Whitted,
        directions_uniform: settings.integrator == Integrator::Hemisphere(Directions::Uniform),
        directions_cosine: settings.integrator == Integrator::Hemisphere(Directions::Cosine),
        sampler_independent: settings.sampler == Sampler::Independent,
        sampler_stratified: settings.sampler == Sampler::Stratified,
        adaptive: settings.adaptive,
        one_scramble: settings.one_scramble && settings.sampler == Sampler::Sobol,
        items_image: false, // the device decides
        repeat_walk: false, // measurements alone ask for it
        ..Features::default()
    };
    Slot::ALL.into_iter().filter(|&slot| texture(slot)).for_each(|slot| slot.enable(&mut features));
    features
}

/// Why light cannot be traced from the lights, whatever the scene holds.
fn refusal(settings: &Settings, features: &Features, cut: Cut) -> Option<&'static str> {
    if features.volume && cut.medium {
        Some("the camera's near plane cuts an absorbing medium")
    } else if settings.receiver {
        Some("a receiver is measured, which is no camera")
    } else if features.nested {
        Some("volumes overlap")
    } else if settings.max_bounces.is_some_and(|most| most < 2) {
        Some("paths are too short for it")
    } else {
        None
    }
}

/// Whether some surface of a scene may be so smooth that [`Integrator::Caustics`] differs from [`Integrator::Mis`].
pub fn may_have_caustics(scene: &Scene) -> bool {
    let mut textures = Textures::default();
    let smooth = |m: &surelight_scene::Material| may_be_smooth(&PreparedMaterial::new(scene, m, &mut textures));
    let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
    used.into_iter().map(|i| &scene.materials[i]).any(smooth)
}

/// Whether there is something that neighbours can share. Where the choice of a colour or of a medium hangs on the path's past, they cannot.
fn may_share_paths(settings: &Settings, features: &Features) -> bool {
    let light =
        features.light_sampling || features.emission || features.environment_uniform || features.environment_map;
    let bounces = settings.max_bounces.is_none_or(|most| most > 1);
    settings.integrator == Integrator::Mis
        && light
        && bounces
        && !features.receiver
        && !features.dispersion
        && !features.nested
}

/// From here on [`SharedPaths::Auto`] has paths shared (docs/performance.md). Where surfaces are glossy, sharing costs more.
fn least_interreflection(features: &Features) -> f64 {
    if features.ggx { 0.6 } else { 0.35 }
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
