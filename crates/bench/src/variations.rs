//! The methods of a race: every combination of the options' values.

use surelight_prepare::{Directions, Integrator, Sampler};

use crate::method::Method;

/// The methods of a race: every combination of the options' values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variations {
    integrators: Option<Vec<Family>>,
    samplers: Option<Vec<Sampler>>,
    directions: Option<Vec<Directions>>,
    max_bounces: Option<Vec<Option<u32>>>,
    max_radiance: Option<Vec<Option<f32>>>,
    one_scramble: Option<Vec<bool>>,
    shared_paths: Option<Vec<bool>>,
}

/// An integrator without its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Family {
    Hemisphere,
    Area,
    Mis,
    Caustics,
    /// Choices of the scene.
    Auto,
    Whitted,
}

impl Variations {
    /// Adds the values of a switch, such as `max-bounces=4,8,unlimited`.
    ///
    /// # Errors
    /// A sentence where there is no such option or value, or the option was given before.
    pub fn add(&mut self, text: &str) -> Result<(), String> {
        let (name, values) =
            text.split_once('=').ok_or("expected an option and its values, such as max-bounces=4,8")?;
        let twice = match name {
            "integrator" => set(&mut self.integrators, values, family)?,
            "sampler" => set(&mut self.samplers, values, sampler)?,
            "directions" => set(&mut self.directions, values, directions)?,
            "max-bounces" => set(&mut self.max_bounces, values, bounces)?,
            "max-radiance" => set(&mut self.max_radiance, values, radiance)?,
            "scrambles" => set(&mut self.one_scramble, values, scrambles)?,
            "shared-paths" => set(&mut self.shared_paths, values, sharing)?,
            _ => {
                return Err(format!(
                    "there is no option \"{name}\" to vary: integrator, sampler, scrambles, shared-paths, directions, max-bounces or max-radiance"
                ));
            }
        };
        if twice { Err(format!("{name} is varied twice; give all its values at once")) } else { Ok(()) }
    }

    /// Whether integrators are given.
    pub fn names_integrators(&self) -> bool {
        self.integrators.is_some()
    }

    /// The methods, without duplicates. A quick race omits samplers that are already compared with
    /// another integrator.
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
                    for method in self.switched(Method { integrator, sampler, ..Method::DEFAULT }) {
                        if !methods.contains(&method) {
                            methods.push(method);
                        }
                    }
                }
            }
        }
        methods
    }

    /// An integrator and a sampler with every combination of the other options.
    fn switched(&self, plain: Method) -> Vec<Method> {
        let mut methods = Vec::new();
        for &max_bounces in self.max_bounces.as_deref().unwrap_or(&[None]) {
            for &max_radiance in self.max_radiance.as_deref().unwrap_or(&[None]) {
                for &one_scramble in self.one_scramble.as_deref().unwrap_or(&[false]) {
                    for &shared_paths in self.shared_paths.as_deref().unwrap_or(&[false]) {
                        // Other samplers have no sequence, other integrators no path reuse.
                        let one_scramble = one_scramble && plain.sampler == Sampler::Sobol;
                        let shared_paths = shared_paths && plain.integrator == Integrator::Mis;
                        methods.push(Method { max_bounces, max_radiance, one_scramble, shared_paths, ..plain });
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
            Family::Auto => vec![Integrator::Auto],
            Family::Whitted => vec![Integrator::Whitted],
            Family::Hemisphere => {
                let directions = self.directions.as_deref().unwrap_or(&[Directions::Bsdf]);
                directions.iter().map(|&d| Integrator::Hemisphere(d)).collect()
            }
        }
    }
}

/// Reads a list of values; returns whether there already was one.
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
        "auto" => Ok(Family::Auto),
        "whitted" => Ok(Family::Whitted),
        _ => Err("an integrator: hemisphere, area, mis, caustics, auto or whitted"),
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

fn sharing(word: &str) -> Result<bool, &'static str> {
    match word {
        "on" => Ok(true),
        "off" => Ok(false),
        _ => Err("a way to share paths: on or off"),
    }
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
    fn paths_are_shared_under_mis_alone() {
        let names = varied(&["integrator=mis,area", "sampler=sobol", "shared-paths=off,on"]);
        assert_eq!(names, ["mis/sobol", "mis/sobol, shared paths", "area/sobol"]);
    }

    #[test]
    fn slips_of_the_finger_are_reported() {
        for (wrong, word) in [
            ("bounces=4", "there is no option"),
            ("max-bounces", "expected an option"),
            ("max-bounces=few", "\"few\" is not a number"),
            ("sampler=sobol,halton", "\"halton\" is not a sampler"),
            ("max-radiance=-1", "is not a radiance"),
            ("scrambles=16", "\"16\" is not a number of scrambles"),
            ("shared-paths=auto", "\"auto\" is not a way to share paths"),
        ] {
            assert!(Variations::default().add(wrong).unwrap_err().contains(word), "{wrong}");
        }
        let mut twice = Variations::default();
        twice.add("sampler=sobol").unwrap();
        assert!(twice.add("sampler=independent").unwrap_err().contains("twice"));
    }
}
