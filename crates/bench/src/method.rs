//! The methods of a race: a method is an integrator, a sampler and the switches that a path's
//! estimator depends on.

use serde::{Deserialize, Serialize};
use surelight_prepare::{Directions, Integrator, PathReuse, Sampler, Settings};
use surelight_scene::Scene;

/// One way of estimating the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// How paths are sampled.
    pub integrator: Integrator,
    /// Source of their random numbers.
    pub sampler: Sampler,
    /// Maximum number of scattering events of a path; `None`: no limit.
    pub max_bounces: Option<u32>,
    /// Clamp of a sample's components; `None`: none.
    pub max_radiance: Option<f32>,
    /// Whether all Sobol points of a pixel are of one sequence, instead of one scramble per batch.
    pub one_scramble: bool,
    /// Whether the pixels of each 2×2 square use one another's paths, where they can.
    pub shared_paths: bool,
}

/// The same in words, as stored in reports.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct MethodWords {
    /// `hemisphere`, `area`, `mis`, `caustics` or `whitted`.
    pub integrator: String,
    /// `uniform`, `cosine` or `bsdf`, where the integrator samples directions only.
    pub directions: Option<String>,
    /// `independent`, `stratified` or `sobol`.
    pub sampler: String,
    /// `unlimited` or a number.
    pub max_bounces: String,
    /// `none` or a radiance.
    pub max_radiance: String,
    /// `one` where all Sobol points of a pixel are of one sequence; else `many`.
    #[serde(default = "many")]
    pub scrambles: String,
    /// `on` where the pixels of each 2×2 square use one another's paths; else `off`.
    #[serde(default = "off")]
    pub shared_paths: String,
}

impl Method {
    /// Light sampling and BSDF sampling combined by MIS, Sobol points, no bias, no path reuse.
    pub const DEFAULT: Self = Self {
        integrator: Integrator::Mis,
        sampler: Sampler::Sobol,
        max_bounces: None,
        max_radiance: None,
        one_scramble: false,
        shared_paths: false,
    };

    /// Each part as a word.
    pub fn words(&self) -> MethodWords {
        let (integrator, directions) = match self.integrator {
            Integrator::Hemisphere(Directions::Uniform) => ("hemisphere", Some("uniform")),
            Integrator::Hemisphere(Directions::Cosine) => ("hemisphere", Some("cosine")),
            Integrator::Hemisphere(Directions::Bsdf) => ("hemisphere", Some("bsdf")),
            Integrator::Area => ("area", None),
            Integrator::Mis => ("mis", None),
            Integrator::Caustics => ("caustics", None),
            Integrator::Auto => ("auto", None),
            Integrator::Whitted => ("whitted", None),
        };
        let sampler = match self.sampler {
            Sampler::Independent => "independent",
            Sampler::Stratified => "stratified",
            Sampler::Sobol => "sobol",
        };
        MethodWords {
            integrator: integrator.into(),
            directions: directions.map(Into::into),
            sampler: sampler.into(),
            max_bounces: self.max_bounces.map_or("unlimited".into(), |n| n.to_string()),
            max_radiance: self.max_radiance.map_or("none".into(), |x| x.to_string()),
            scrambles: if self.one_scramble { "one" } else { "many" }.into(),
            shared_paths: if self.shared_paths { "on" } else { "off" }.into(),
        }
    }

    /// A short name, such as `mis/sobol` or `hemisphere-cosine/sobol ≤ 4 bounces`.
    pub fn name(&self) -> String {
        let words = self.words();
        let directions = words.directions.filter(|d| d != "bsdf").map_or(String::new(), |d| format!("-{d}"));
        let mut name = format!("{}{directions}/{}", words.integrator, words.sampler);
        if self.one_scramble {
            name += ", one scramble";
        }
        if self.shared_paths {
            name += ", shared paths";
        }
        if let Some(n) = self.max_bounces {
            name += &format!(" ≤ {n} bounce{}", if n == 1 { "" } else { "s" });
        }
        if let Some(x) = self.max_radiance {
            name += &format!(" clamped at {x}");
        }
        name
    }

    /// The reason for which its expected picture is not the true one; `None` where it is.
    pub fn bias(&self, scene: &Scene) -> Option<String> {
        let mut reasons = Vec::new();
        if self.integrator.is_biased() {
            reasons.push("whitted leaves out light between diffuse surfaces and the shape of lamps".to_owned());
        }
        if matches!(self.integrator, Integrator::Hemisphere(_)) && !scene.lights.is_empty() {
            reasons.push(format!("misses {} lights without extent", scene.lights.len()));
        }
        if let Some(n) = self.max_bounces {
            reasons.push(format!("leaves out light of more than {n} bounces"));
        }
        if let Some(x) = self.max_radiance {
            reasons.push(format!("clamps samples at {x}"));
        }
        (!reasons.is_empty()).then(|| reasons.join("; "))
    }

    /// The method for caustics, tried where there are mirrors or smooth glass.
    pub const CAUSTICS: Self = Self { integrator: Integrator::Caustics, ..Self::DEFAULT };

    /// The settings that render it.
    pub fn settings(&self, base: &Settings) -> Settings {
        Settings {
            integrator: self.integrator,
            sampler: self.sampler,
            max_bounces: self.max_bounces,
            max_radiance: self.max_radiance,
            one_scramble: self.one_scramble,
            path_reuse: if self.shared_paths { PathReuse::On } else { PathReuse::Off },
            ..base.clone()
        }
    }
}

/// The value of reports from before this option.
fn many() -> String {
    "many".into()
}

/// The value of reports from before path reuse.
fn off() -> String {
    "off".into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_biases_is_known() {
        let scene = Scene::default();
        assert_eq!(Method::DEFAULT.bias(&scene), None);
        assert!(Method { integrator: Integrator::Whitted, ..Method::DEFAULT }.bias(&scene).is_some());
        assert!(Method { max_bounces: Some(4), ..Method::DEFAULT }.bias(&scene).unwrap().contains("4 bounces"));
        assert!(Method { max_radiance: Some(9.0), ..Method::DEFAULT }.bias(&scene).is_some());
    }
}
