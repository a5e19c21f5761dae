//! How paths are sampled: `--integrator`, `--directions`, `--sampler`, and the bias that follows.

use clap::{Args, ValueEnum};
use surelight_film::settings as record;
use surelight_prepare as prepare;
use surelight_scene::Scene;

use crate::options::heading;

/// The estimator of the rendering equation and the source of its random numbers.
#[derive(Clone, Debug, Args)]
pub(crate) struct MethodArgs {
    /// Integrator (how paths are sampled)
    #[arg(long, value_enum, default_value_t = Integrator::Auto)]
    pub(crate) integrator: Integrator,

    /// How `--integrator hemisphere` samples directions [default: bsdf]
    #[arg(long, value_enum, help_heading = heading::SAMPLING)]
    pub(crate) directions: Option<Directions>,

    /// Sampler (the point set behind all random numbers)
    #[arg(long, value_enum, default_value_t = Sampler::Sobol, help_heading = heading::SAMPLING)]
    pub(crate) sampler: Sampler,
}

/// Names of the integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Integrator {
    /// Directions over the hemisphere; misses point, spot and directional lights
    Hemisphere,
    /// Points on lights (next-event estimation)
    Area,
    /// Both, combined by multiple importance sampling (MIS)
    Mis,
    /// MIS, and caustics of mirrors and smooth glass by light tracing
    Caustics,
    /// `caustics` where the scene needs it, else `mis`; the summary says why
    Auto,
    /// Whitted's ray tracing: mirrors, clear glass, one shadow ray per light; biased
    Whitted,
}

/// Names of the direction samplings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Directions {
    /// Uniform over the hemisphere
    Uniform,
    /// Proportional to the cosine
    Cosine,
    /// Proportional to the BSDF
    Bsdf,
}

/// Names of the samplers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Sampler {
    /// Independent random numbers
    Independent,
    /// Jittered samples, one per cell of a grid
    Stratified,
    /// Owen-scrambled Sobol points (low discrepancy)
    Sobol,
}

impl Integrator {
    /// As files record it. `Auto` is never recorded: the scene has decided by then.
    pub(crate) fn recorded(self) -> record::Integrator {
        match self {
            Self::Hemisphere => record::Integrator::Hemisphere,
            Self::Area => record::Integrator::Area,
            Self::Mis | Self::Auto => record::Integrator::Mis,
            Self::Caustics => record::Integrator::Caustics,
            Self::Whitted => record::Integrator::Whitted,
        }
    }
}

impl From<record::Integrator> for Integrator {
    fn from(integrator: record::Integrator) -> Self {
        match integrator {
            record::Integrator::Hemisphere => Self::Hemisphere,
            record::Integrator::Area => Self::Area,
            record::Integrator::Mis => Self::Mis,
            record::Integrator::Caustics => Self::Caustics,
            record::Integrator::Whitted => Self::Whitted,
        }
    }
}

impl Directions {
    /// As files record them.
    pub(crate) fn recorded(self) -> record::Directions {
        match self {
            Self::Uniform => record::Directions::Uniform,
            Self::Cosine => record::Directions::Cosine,
            Self::Bsdf => record::Directions::Bsdf,
        }
    }
}

impl Sampler {
    /// As files record it.
    pub(crate) fn recorded(self) -> record::Sampler {
        match self {
            Self::Independent => record::Sampler::Independent,
            Self::Stratified => record::Sampler::Stratified,
            Self::Sobol => record::Sampler::Sobol,
        }
    }
}

/// The word that a value is chosen with.
pub(crate) fn word(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl MethodArgs {
    /// The error in the combination, if any.
    pub(crate) fn conflict(&self) -> Option<&'static str> {
        (self.directions.is_some() && self.integrator != Integrator::Hemisphere).then_some(
            "the argument '--directions' needs '--integrator hemisphere': the others choose directions themselves",
        )
    }

    /// As the renderer calls it.
    pub(crate) fn integrator(&self) -> prepare::Integrator {
        match self.integrator {
            Integrator::Hemisphere => prepare::Integrator::Hemisphere(match self.directions {
                Some(Directions::Uniform) => prepare::Directions::Uniform,
                Some(Directions::Cosine) => prepare::Directions::Cosine,
                Some(Directions::Bsdf) | None => prepare::Directions::Bsdf,
            }),
            Integrator::Area => prepare::Integrator::Area,
            Integrator::Mis => prepare::Integrator::Mis,
            Integrator::Auto => prepare::Integrator::Auto,
            Integrator::Caustics => prepare::Integrator::Caustics,
            Integrator::Whitted => prepare::Integrator::Whitted,
        }
    }

    /// The same with another integrator.
    pub(crate) fn with(&self, integrator: prepare::Integrator) -> Self {
        let integrator = match integrator {
            prepare::Integrator::Hemisphere(_) => Integrator::Hemisphere,
            prepare::Integrator::Area => Integrator::Area,
            prepare::Integrator::Mis => Integrator::Mis,
            prepare::Integrator::Caustics => Integrator::Caustics,
            prepare::Integrator::Auto => Integrator::Auto,
            prepare::Integrator::Whitted => Integrator::Whitted,
        };
        Self { integrator, ..self.clone() }
    }

    /// As the renderer calls it.
    pub(crate) fn sampler(&self) -> prepare::Sampler {
        match self.sampler {
            Sampler::Independent => prepare::Sampler::Independent,
            Sampler::Stratified => prepare::Sampler::Stratified,
            Sampler::Sobol => prepare::Sampler::Sobol,
        }
    }

    /// The direction sampling in force; `None` where the integrator chooses directions itself.
    pub(crate) fn directions_in_force(&self) -> Option<Directions> {
        (self.integrator == Integrator::Hemisphere).then(|| self.directions.unwrap_or(Directions::Bsdf))
    }

    /// The integrator as an entry of the list of biased options, where it does not tend to the true
    /// radiance of this scene.
    pub(crate) fn bias(&self, scene: &Scene) -> Option<String> {
        if self.integrator().is_biased() {
            return Some(format!("integrator {}", word(self.integrator)));
        }
        let missed = self.missed_lights(scene);
        (missed > 0).then(|| format!("integrator {} (misses {missed} lights without extent)", word(self.integrator)))
    }

    /// A warning where the integrator cannot find some of the scene's lights.
    pub(crate) fn warning(&self, scene: &Scene) -> Option<String> {
        let missed = self.missed_lights(scene);
        if missed == 0 {
            return None;
        }
        let what = if missed == 1 {
            "the one point, spot or directional light".to_owned()
        } else {
            format!("the {missed} point, spot and directional lights")
        };
        let rest = if surface_light(scene) {
            "their light is missing"
        } else {
            "there is no other light, so the picture is black"
        };
        let rest = if missed == 1 { rest.replace("their", "its") } else { rest.to_owned() };
        Some(format!(
            "the hemisphere integrator cannot find {what}, which no direction hits by chance: {rest} (--integrator area, mis or caustics finds them)"
        ))
    }

    fn missed_lights(&self, scene: &Scene) -> usize {
        if self.integrator == Integrator::Hemisphere { scene.lights.len() } else { 0 }
    }
}

/// Whether there is light that a direction can hit: an emitter, or an environment that is not
/// black.
fn surface_light(scene: &Scene) -> bool {
    use surelight_scene::Environment;
    let environment = match &scene.environment {
        Some(Environment::Uniform(radiance)) => radiance.iter().any(|&c| c > 0.0),
        Some(Environment::Map { .. }) => true,
        None => false,
    };
    environment || scene.instances.iter().any(|i| scene.materials[scene.meshes[i.mesh].material].is_emissive())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use surelight_film as film;
    use surelight_scene::{Environment, Light, LightKind};

    use super::*;
    use crate::stopping::Bound;

    fn method(integrator: Integrator, directions: Option<Directions>) -> MethodArgs {
        MethodArgs { integrator, directions, sampler: Sampler::Sobol }
    }

    #[test]
    fn lights_that_no_direction_hits_are_reported() {
        let light =
            Light { name: String::new(), kind: LightKind::Point { position: DVec3::ZERO }, intensity: [1.0; 3] };
        let mut scene = Scene { lights: vec![light], ..Scene::default() };
        let hemisphere = method(Integrator::Hemisphere, None);
        assert!(hemisphere.warning(&scene).unwrap().contains("black"));
        assert!(hemisphere.bias(&scene).unwrap().contains("misses 1"));
        scene.environment = Some(Environment::Uniform([1.0; 3]));
        assert!(hemisphere.warning(&scene).unwrap().contains("its light is missing"));
        for other in [Integrator::Area, Integrator::Mis, Integrator::Caustics] {
            assert_eq!((method(other, None).warning(&scene), method(other, None).bias(&scene)), (None, None));
        }
        scene.lights.clear();
        assert_eq!((hemisphere.warning(&scene), hemisphere.bias(&scene)), (None, None));
    }

    /// Messages about files then name values as the user types them.
    #[test]
    fn words_of_files_are_those_of_the_options() {
        for &integrator in Integrator::value_variants() {
            if integrator != Integrator::Auto {
                assert_eq!(serde_json::json!(integrator.recorded()), word(integrator));
                assert_eq!(Integrator::from(integrator.recorded()), integrator);
            }
        }
        for &directions in Directions::value_variants() {
            assert_eq!(serde_json::json!(directions.recorded()), word(directions));
        }
        for &sampler in Sampler::value_variants() {
            assert_eq!(serde_json::json!(sampler.recorded()), word(sampler));
        }
        for (bound, option) in [(film::Bound::Clt, Bound::Clt), (film::Bound::Chebyshev, Bound::Chebyshev)] {
            assert_eq!(serde_json::json!(bound), word(option));
        }
    }

    #[test]
    fn whitted_is_always_biased() {
        assert_eq!(method(Integrator::Whitted, None).bias(&Scene::default()).as_deref(), Some("integrator whitted"));
    }

    #[test]
    fn directions_belong_to_the_hemisphere_form() {
        for integrator in Integrator::value_variants() {
            let wrong = method(*integrator, Some(Directions::Cosine)).conflict().is_some();
            assert_eq!(wrong, *integrator != Integrator::Hemisphere);
            assert!(method(*integrator, None).conflict().is_none());
        }
        let uniform = method(Integrator::Hemisphere, Some(Directions::Uniform)).integrator();
        assert_eq!(uniform, prepare::Integrator::Hemisphere(prepare::Directions::Uniform));
    }
}
