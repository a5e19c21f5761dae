//! `--integrator auto`: tries the unbiased integrators and takes the most efficient one.

use surelight_render::{
    Device, Integrator, Prepared, Settings, Trial, Unreachable, best_trial, may_have_caustics, try_integrators,
};

use crate::error::Error;
use crate::method::MethodArgs;
use crate::summary::Tried;

use super::prepare::Loaded;

/// The method in force, and what was tried to find it: nothing, where the user chose.
pub(super) fn choose(
    method: &MethodArgs,
    device: &Device,
    loaded: &Loaded,
    settings: &Settings,
) -> Result<(MethodArgs, Vec<Tried>), Error> {
    if !method.is_auto() {
        return Ok((method.clone(), Vec::new()));
    }
    let mut candidates = vec![Integrator::Mis, Integrator::Area];
    let hemisphere = method.with(Integrator::default_hemisphere());
    if hemisphere.bias(&loaded.scene).is_none() {
        candidates.push(Integrator::default_hemisphere());
    }
    let missing = if may_have_caustics(&loaded.scene) {
        let prepared = |integrator| {
            let settings = Settings { integrator, ..settings.clone() };
            Prepared::new(&loaded.scene, &loaded.view.camera, &settings)
        };
        if prepared(Integrator::Caustics)?.no_caustics.is_none() {
            candidates.push(Integrator::Caustics);
        }
        prepared(Integrator::Mis)?.unreachable.iter().any(Unreachable::is_bias)
    } else {
        false
    };
    let trials = try_integrators(device, &loaded.scene, &loaded.view.camera, settings, &candidates)?;
    // What finds light that the others miss is no less efficient for it.
    let traced = candidates.iter().position(|&c| c == Integrator::Caustics).filter(|_| missing);
    let best = traced.or_else(|| best_trial(&trials, Integrator::Mis)).unwrap_or(0);
    let usual = trials[0].efficiency;
    let tell = |(i, trial): (usize, &Trial)| Tried {
        integrator: MethodArgs::with(method, trial.integrator).word(),
        efficiency: trial.efficiency / usual,
        efficiency_error: trial.error * trial.efficiency / usual,
        variance: trial.variance,
        seconds: trial.seconds,
        chosen: i == best,
    };
    let tried = trials.iter().enumerate().map(tell).collect();
    Ok((MethodArgs::with(method, trials[best].integrator), tried))
}
