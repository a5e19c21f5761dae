//! The parts of a kernel that a scene needs, and no more.

use surelight_scene::{AlphaMode, Camera, Environment, Material, Projection, Scene};

use crate::{
    error::PrepareError,
    kernel_key::{CameraModel, EnvironmentKind, Estimator, KernelKey, Part, Parts, PointSet},
    lights::LightKinds,
    lobes::{
        has_alpha_volume, has_diffuse_transmission, has_facets, has_film, has_sheen, is_anisotropic, is_coated,
        is_dispersive, is_glossy, is_pane, transmits,
    },
    materials::PreparedMaterial,
    settings::{Integrator, Settings},
    slots::Slot,
};

/// Features of a scene, from its lights, trees and tables.
pub(crate) struct SceneFeatures {
    pub(crate) lights: LightKinds,
    pub(crate) environment_map: bool,
    pub(crate) instances: bool,
    /// Whether the camera's near or far plane cuts something off.
    pub(crate) clipped: bool,
    /// Whether volumes overlap.
    pub(crate) nested: bool,
}

/// The key that the scene needs, and no more. Path reuse and light tracing are decided later.
pub(crate) fn decide(
    scene: &Scene,
    camera: &Camera,
    settings: &Settings,
    materials: &[&PreparedMaterial],
    found: &SceneFeatures,
) -> Result<KernelKey, PrepareError> {
    let any = |test: &dyn Fn(&Material) -> bool| materials.iter().any(|m| test(&m.material));
    let placed = || scene.instances.iter().map(|i| &scene.meshes[i.mesh]);
    let absorbs = |m: &Material| {
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
        (any(&has_diffuse_transmission), Part::DiffuseTransmission),
        (any(&is_anisotropic), Part::Anisotropy),
        (any(&has_film), Part::Iridescence),
        (any(&has_sheen), Part::Sheen),
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
        _ if found.environment_map => EnvironmentKind::Map,
        Some(Environment::Uniform(radiance)) if radiance.iter().any(|&c| c > 0.0) => EnvironmentKind::Uniform,
        _ => EnvironmentKind::Black,
    };
    let points = PointSet::new(settings.sampler, settings.one_scramble);
    Ok(KernelKey::new(method, points, camera, surroundings, parts)?)
}

/// Whether light may go straight through some of the surface.
pub(crate) fn is_smooth_pane(m: &PreparedMaterial) -> bool {
    is_pane(&m.material, m.material.roughness < 0.0101 || m.has(Slot::MetallicRoughness))
}

/// Whether α can fall below the kernel's ALPHA_SMOOTH = 1e-4, where lobes are deltas.
pub(crate) fn may_be_smooth(m: &PreparedMaterial) -> bool {
    let coat = &m.material.clearcoat;
    has_facets(&m.material) && (m.material.roughness < 0.0101 || m.has(Slot::MetallicRoughness))
        || is_coated(&m.material) && (coat.roughness < 0.0101 || m.has(Slot::ClearcoatRoughness))
}
