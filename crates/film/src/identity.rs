//! Whether two parts belong to one render: then, and only then, they may be joined or gone on with.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::Metadata;

/// Settings that name files. What the files hold is in the scene's hash; where they lie does not matter.
const PLACES: [&str; 2] = ["scene", "env"];

/// Something that renders are told apart by, with what it is called.
type Trait = (&'static str, fn(&Metadata) -> String);

/// The first thing that tells two renders apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// What differs: an option's name, or in words.
    pub what: String,
    /// The value in the first, as it was set.
    pub first: String,
    /// The value in the second.
    pub second: String,
}

/// What tells two parts apart, if anything, by which they cannot be of one render: scene, settings, seed, planned samples, program,
/// kernel, device and driver. Where they lie in the image, and which samples they hold, is another matter.
pub fn difference(first: &Metadata, second: &Metadata) -> Option<Difference> {
    let differing =
        |what: &str, a: String, b: String| (a != b).then(|| Difference { what: what.into(), first: a, second: b });
    let texts: [Trait; 2] =
        [("the version of Surelight", |m| m.version.clone()), ("the scene (by its hash)", |m| m.scene_hash.clone())];
    let numbers = || {
        let planned = |m: &Metadata| m.part.as_ref().and_then(|part| part.planned_samples);
        let spp = |m: &Metadata| planned(m).map_or("not set".into(), |spp| spp.to_string());
        differing("--seed", first.seed.to_string(), second.seed.to_string())
            .or_else(|| differing("--spp", spp(first), spp(second)))
    };
    let device: [Trait; 3] = [
        ("the device", |m| m.device.clone()),
        ("the driver", |m| m.driver.clone()),
        ("the kernel (by its hash)", |m| m.part.as_ref().map_or_else(String::new, |part| part.kernel.clone())),
    ];
    let list = |of: &[Trait]| of.iter().find_map(|(what, value)| differing(what, value(first), value(second)));
    list(&texts).or_else(|| settings(first, second)).or_else(numbers).or_else(|| list(&device))
}

fn settings(first: &Metadata, second: &Metadata) -> Option<Difference> {
    let names: BTreeSet<&String> = first.settings.keys().chain(second.settings.keys()).collect();
    let name = names
        .into_iter()
        .find(|name| !PLACES.contains(&name.as_str()) && first.settings.get(*name) != second.settings.get(*name))?;
    let text = |value: Option<&Value>| match value {
        None => "not set".to_owned(),
        Some(Value::String(text)) => text.clone(),
        Some(Value::Object(_)) => "set".to_owned(), // too long for a sentence
        Some(value) => value.to_string(),
    };
    let what = match name.as_str() {
        "width" | "height" => format!("the image's {name}"),
        "camera" => "the camera".to_owned(), // set by several options
        "scrambles" => "the number of scrambles".to_owned(), // --one-scramble, or few samples
        name => format!("--{name}"),
    };
    match (text(first.settings.get(name)), text(second.settings.get(name))) {
        (a, b) if a == b => Some(Difference { what, first: "one".into(), second: "another".into() }),
        (a, b) => Some(Difference { what, first: a, second: b }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Part;

    #[test]
    fn everything_that_shapes_the_bits_is_looked_at() {
        let mut metadata = Metadata { part: Some(Part::default()), ..Metadata::default() };
        metadata.settings.insert("sampler".into(), "sobol".into());
        type Change = fn(&mut Metadata);
        let changes: [(&str, Change); 9] = [
            ("version", |m| m.version = "9".into()),
            ("scene", |m| m.scene_hash = "f".into()),
            ("--seed", |m| m.seed = 1),
            ("--spp", |m| m.part.as_mut().unwrap().planned_samples = Some(3)),
            ("device", |m| m.device = "GPU".into()),
            ("driver", |m| m.driver = "9".into()),
            ("kernel", |m| m.part.as_mut().unwrap().kernel = "f".into()),
            ("--sampler", |m| m.settings["sampler"] = "stratified".into()),
            ("--max-radiance", |m| _ = m.settings.insert("max-radiance".into(), 9.into())),
        ];
        for (what, change) in changes {
            let mut other = metadata.clone();
            change(&mut other);
            let found = difference(&metadata, &other).unwrap();
            assert!(found.what.contains(what), "{found:?}");
            assert_eq!(difference(&other, &metadata).map(|d| (d.second, d.first)), Some((found.first, found.second)));
        }
    }

    #[test]
    fn place_samples_and_file_names_do_not_matter() {
        let mut metadata = Metadata::default();
        metadata.settings.insert("scene".into(), "a/box.glb".into());
        let mut other = Metadata { sample_range: [3, 4], crop: Some([0, 0, 1, 1]), ..Metadata::default() };
        other.settings.insert("scene".into(), "b/box.glb".into());
        other.settings.insert("env".into(), "b/sky.hdr".into());
        assert_eq!(difference(&metadata, &other), None);
    }
}
