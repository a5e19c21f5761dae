//! Decisions on the method by the scene: [`Integrator::Auto`], light tracing, reuse of paths.

use std::collections::BTreeSet;

use surelight_scene::Scene;

use crate::{
    caustics::NOTHING_SMOOTH,
    clip::ActiveClipPlanes,
    kernel_key::{Estimator, KernelKey, Part},
    light_flow::LightFlow,
    materials::PreparedMaterial,
    needs::may_be_smooth,
    settings::{Integrator, Settings},
    textures::Textures,
};

/// Of the light that surfaces scatter, the share that may be missing before [`Integrator::Auto`]
/// traces it from the lights.
pub(crate) const MAX_MISSING: f64 = 1e-3;

/// Shares below this are none.
pub(crate) const MIN_DELTA_SHARE: f64 = 1e-4;

/// From this relative variance per sample on, tracing light from the lights pays for itself
/// (docs/performance.md), and from the second where neighbours would share paths instead.
pub(crate) const MIN_CHANCE_NOISE: [f64; 2] = [0.5, 1.5];

/// The integrator that [`Integrator::Auto`] chooses, and why. `shares`: whether neighbours would
/// reuse paths without particles.
pub(crate) fn choose(
    flow: &LightFlow,
    refused: Option<&'static str>,
    shares: impl FnOnce() -> bool,
) -> (Integrator, String) {
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
pub(crate) fn refusal(settings: &Settings, key: &KernelKey, cut: ActiveClipPlanes) -> Option<&'static str> {
    if key.has(Part::Volume) && cut.medium {
        return Some("the camera's near plane cuts an absorbing medium");
    }
    let short = settings.max_bounces.is_some_and(|most| most < 2);
    key.objection(Estimator::LightTracing).or(short.then_some("paths are too short for it"))
}

/// Whether some surface of a scene may be so smooth that [`Integrator::Caustics`] differs from
/// [`Integrator::Mis`].
pub fn may_have_caustics(scene: &Scene) -> bool {
    let mut textures = Textures::default();
    let smooth = |m: &surelight_scene::Material| may_be_smooth(&PreparedMaterial::new(scene, m, &mut textures));
    let used: BTreeSet<usize> = scene.instances.iter().map(|i| scene.meshes[i.mesh].material).collect();
    used.into_iter().map(|i| &scene.materials[i]).any(smooth)
}

/// Whether there is something that neighbours can share, and nothing that keeps them from it.
pub(crate) fn may_reuse_paths(settings: &Settings, key: &KernelKey) -> bool {
    let light = [Part::LightSampling, Part::Emission, Part::EnvironmentUniform, Part::EnvironmentMap];
    settings.integrator == Integrator::Mis
        && light.into_iter().any(|part| key.has(part))
        && settings.max_bounces.is_none_or(|most| most > 1)
        && key.objection(Estimator::PathReuse).is_none()
}

/// From here on [`PathReuse::Auto`] has paths shared (docs/performance.md). Where surfaces are
/// glossy, sharing costs more.
pub(crate) fn min_interreflection_share(key: &KernelKey) -> f64 {
    if key.has(Part::Ggx) { 0.6 } else { 0.35 }
}
