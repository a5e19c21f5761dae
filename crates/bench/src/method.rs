//! What is raced: a method is an integrator, a sampler and the switches that change what a path may do.

use serde::{Deserialize, Serialize};
use surelight_render::{Directions, Integrator, Sampler, Settings};
use surelight_scene::Scene;

/// One way of estimating the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// How paths are sampled.
    pub integrator: Integrator,
    /// Where their random numbers come from.
    pub sampler: Sampler,
    /// Scattering events that a path may have; `None`: no limit.
    pub max_bounces: Option<u32>,
    /// Clamp of a sample's components; `None`: none.
    pub max_radiance: Option<f32>,
    /// Whether all Sobol points of a pixel are of one sequence, instead of a scramble a batch.
    pub one_scramble: bool,
}

/// The same in words, as the reports keep it.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct MethodWords {
    /// `hemisphere`, `area`, `mis`, `caustics` or `whitted`.
    pub integrator: String,
    /// `uniform`, `cosine` or `bsdf`, where the integrator samples directions alone.
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
}

impl Method {
    /// The product's default: light sampling and BSDF sampling joined, Sobol points, nothing that biases.
    pub const DEFAULT: Self = Self {
        integrator: Integrator::Mis,
        sampler: Sampler::Sobol,
        max_bounces: None,
        max_radiance: None,
        one_scramble: false,
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
        if let Some(n) = self.max_bounces {
            name += &format!(" ≤ {n} bounce{}", if n == 1 { "" } else { "s" });
        }
        if let Some(x) = self.max_radiance {
            name += &format!(" clamped at {x}");
        }
        name
    }

    /// What makes its expected picture another than the true one; `None` where it is the true one.
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

    /// The method that is worth a try beside all others where there are mirrors or smooth glass.
    pub const CAUSTICS: Self = Self { integrator: Integrator::Caustics, ..Self::DEFAULT };

    /// The settings that render it.
    pub fn settings(&self, base: &Settings) -> Settings {
        Settings {
            integrator: self.integrator,
            sampler: self.sampler,
            max_bounces: self.max_bounces,
            max_radiance: self.max_radiance,
            one_scramble: self.one_scramble,
            ..base.clone()
        }
    }
}

/// Which methods are raced: every combination of what each switch may be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variations {
    integrators: Option<Vec<Family>>,
    samplers: Option<Vec<Sampler>>,
    directions: Option<Vec<Directions>>,
    max_bounces: Option<Vec<Option<u32>>>,
    max_radiance: Option<Vec<Option<f32>>>,
    one_scramble: Option<Vec<bool>>,
}

/// An integrator without its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    Hemisphere,
    Area,
    Mis,
    Caustics,
    Whitted,
}

impl Variations {
    /// Adds what a switch may be, such as `max-bounces=4,8,unlimited`.
    ///
    /// # Errors
    /// A sentence where there is no such switch or value, or the switch was given before.
    pub fn add(&mut self, text: &str) -> Result<(), String> {
        let (name, values) = text.split_once('=').ok_or("expected a switch and its values, such as max-bounces=4,8")?;
        let twice = match name {
            "integrator" => set(&mut self.integrators, values, family)?,
            "sampler" => set(&mut self.samplers, values, sampler)?,
            "directions" => set(&mut self.directions, values, directions)?,
            "max-bounces" => set(&mut self.max_bounces, values, bounces)?,
            "max-radiance" => set(&mut self.max_radiance, values, radiance)?,
            "scrambles" => set(&mut self.one_scramble, values, scrambles)?,
            _ => {
                return Err(format!(
                    "there is no switch \"{name}\" to vary: integrator, sampler, scrambles, directions, max-bounces or max-radiance"
                ));
            }
        };
        if twice { Err(format!("{name} is varied twice; give all its values at once")) } else { Ok(()) }
    }

    /// Whether integrators were chosen.
    pub fn names_integrators(&self) -> bool {
        self.integrators.is_some()
    }

    /// The methods, without doubles. A quick race leaves out samplers that only repeat what another integrator shows.
    pub fn methods(&self, quick: bool) -> Vec<Method> {
        use Family as F;
        let all = [Sampler::Sobol, Sampler::Stratified, Sampler::Independent];
        let samplers = |family: F| match &self.samplers {
            Some(given) => given.clone(),
            None if family == F::Mis || !quick => all.to_vec(),
            None => vec![Sampler::Sobol],
        };
        let mut methods = Vec::new();
        for &family in self.integrators.as_deref().unwrap_or(&[F::Mis, F::Area, F::Hemisphere, F::Whitted]) {
            for sampler in samplers(family) {
                for integrator in self.integrators_of(family) {
                    for &max_bounces in self.max_bounces.as_deref().unwrap_or(&[None]) {
                        for &max_radiance in self.max_radiance.as_deref().unwrap_or(&[None]) {
                            for &one_scramble in self.one_scramble.as_deref().unwrap_or(&[false]) {
                                // Other samplers have no sequence.
                                let one_scramble = one_scramble && sampler == Sampler::Sobol;
                                let method = Method { integrator, sampler, max_bounces, max_radiance, one_scramble };
                                if !methods.contains(&method) {
                                    methods.push(method);
                                }
                            }
                        }
                    }
                }
            }
        }
        methods
    }

    fn integrators_of(&self, family: Family) -> Vec<Integrator> {
        match family {
            Family::Area => vec![Integrator::Area],
            Family::Mis => vec![Integrator::Mis],
            Family::Caustics => vec![Integrator::Caustics],
            Family::Whitted => vec![Integrator::Whitted],
            Family::Hemisphere => {
                let directions = self.directions.as_deref().unwrap_or(&[Directions::Bsdf]);
                directions.iter().map(|&d| Integrator::Hemisphere(d)).collect()
            }
        }
    }
}

/// Reads a list of values; returns whether there was one already.
fn set<T>(
    slot: &mut Option<Vec<T>>,
    text: &str,
    read: impl Fn(&str) -> Result<T, &'static str>,
) -> Result<bool, String> {
    let values = text.split(',').map(|word| read(word.trim()).map_err(|wanted| format!("\"{word}\" is not {wanted}")));
    Ok(slot.replace(values.collect::<Result<_, _>>()?).is_some())
}

fn family(word: &str) -> Result<Family, &'static str> {
    match word {
        "hemisphere" => Ok(Family::Hemisphere),
        "area" => Ok(Family::Area),
        "mis" => Ok(Family::Mis),
        "caustics" => Ok(Family::Caustics),
        "whitted" => Ok(Family::Whitted),
        _ => Err("an integrator: hemisphere, area, mis, caustics or whitted"),
    }
}

fn sampler(word: &str) -> Result<Sampler, &'static str> {
    match word {
        "independent" => Ok(Sampler::Independent),
        "stratified" => Ok(Sampler::Stratified),
        "sobol" => Ok(Sampler::Sobol),
        _ => Err("a sampler: independent, stratified or sobol"),
    }
}

fn scrambles(word: &str) -> Result<bool, &'static str> {
    match word {
        "one" => Ok(true),
        "many" => Ok(false),
        _ => Err("a number of scrambles: one or many"),
    }
}

/// What reports of versions before this switch had.
fn many() -> String {
    "many".into()
}

fn directions(word: &str) -> Result<Directions, &'static str> {
    match word {
        "uniform" => Ok(Directions::Uniform),
        "cosine" => Ok(Directions::Cosine),
        "bsdf" => Ok(Directions::Bsdf),
        _ => Err("a way to sample directions: uniform, cosine or bsdf"),
    }
}

fn bounces(word: &str) -> Result<Option<u32>, &'static str> {
    match word {
        "unlimited" => Ok(None),
        _ => word.parse().map(Some).map_err(|_| "a number of bounces, such as 8, or unlimited"),
    }
}

fn radiance(word: &str) -> Result<Option<f32>, &'static str> {
    match word {
        "none" => Ok(None),
        _ => match word.parse::<f32>() {
            Ok(x) if x > 0.0 && x.is_finite() => Ok(Some(x)),
            _ => Err("a radiance above zero, or none"),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn varied(switches: &[&str]) -> Vec<String> {
        let mut variations = Variations::default();
        switches.iter().for_each(|s| variations.add(s).unwrap());
        variations.methods(false).iter().map(Method::name).collect()
    }

    #[test]
    fn all_pairs_by_default_and_fewer_in_a_hurry() {
        assert_eq!(varied(&[]).len(), 12);
        let quick = Variations::default().methods(true);
        assert_eq!(quick.len(), 6);
        assert!(quick.contains(&Method::DEFAULT));
    }

    #[test]
    fn switches_multiply() {
        let names = varied(&[
            "integrator=mis,hemisphere",
            "sampler=sobol",
            "directions=cosine,bsdf",
            "max-bounces=4,unlimited",
        ]);
        assert_eq!(
            names,
            [
                "mis/sobol ≤ 4 bounces",
                "mis/sobol",
                "hemisphere-cosine/sobol ≤ 4 bounces",
                "hemisphere-cosine/sobol",
                "hemisphere/sobol ≤ 4 bounces",
                "hemisphere/sobol"
            ]
        );
    }

    #[test]
    fn scrambles_are_sobols_alone() {
        let names = varied(&["integrator=mis", "sampler=sobol,independent", "scrambles=one,many"]);
        assert_eq!(names, ["mis/sobol, one scramble", "mis/sobol", "mis/independent"]);
    }

    #[test]
    fn slips_of_the_finger_are_told() {
        for (wrong, word) in [
            ("bounces=4", "there is no switch"),
            ("max-bounces", "expected a switch"),
            ("max-bounces=few", "\"few\" is not a number"),
            ("sampler=sobol,halton", "\"halton\" is not a sampler"),
            ("max-radiance=-1", "is not a radiance"),
            ("scrambles=16", "\"16\" is not a number of scrambles"),
        ] {
            assert!(Variations::default().add(wrong).unwrap_err().contains(word), "{wrong}");
        }
        let mut twice = Variations::default();
        twice.add("sampler=sobol").unwrap();
        assert!(twice.add("sampler=independent").unwrap_err().contains("twice"));
    }

    #[test]
    fn what_biases_is_known() {
        let scene = Scene::default();
        assert_eq!(Method::DEFAULT.bias(&scene), None);
        assert!(Method { integrator: Integrator::Whitted, ..Method::DEFAULT }.bias(&scene).is_some());
        assert!(Method { max_bounces: Some(4), ..Method::DEFAULT }.bias(&scene).unwrap().contains("4 bounces"));
        assert!(Method { max_radiance: Some(9.0), ..Method::DEFAULT }.bias(&scene).is_some());
    }
}
