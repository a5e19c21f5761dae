//! Whether two parts belong to one render: then, and only then, they may be joined or gone on with.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::Metadata;

/// Settings that name files. What the files hold is in the scene's hash; where they lie does not matter.
const PLACES: [&str; 2] = ["scene", "env"];

/// Settings that follow from when a render stops.
const STOPPING: [&str; 4] = ["error", "confidence", "bound", "scrambles"];

/// What two renders must have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sameness {
    /// Every bit: parts join as if rendered in one go.
    Bits,
    /// The estimator: means and error bars hold. Adapter, driver and kernel may differ.
    Estimator,
    /// All but when the render stops: one extends the other with more samples.
    Plan,
}

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

/// The first difference by which two parts are not of one render, as far as `sameness` demands: of
/// scene, settings, seed, planned samples, program, kernel, device and driver. Their place in the
/// image and the samples they hold may differ.
pub fn difference(first: &Metadata, second: &Metadata, sameness: Sameness) -> Option<Difference> {
    let differing =
        |what: &str, a: String, b: String| (a != b).then(|| Difference { what: what.into(), first: a, second: b });
    let texts: [Trait; 2] =
        [("the version of Surelight", |m| m.version.clone()), ("the scene (by its hash)", |m| m.scene_hash.clone())];
    let numbers = || {
        let planned = |m: &Metadata| m.part.as_ref().and_then(|part| part.planned_samples);
        let spp = |m: &Metadata| planned(m).map_or("not set".into(), |spp| spp.to_string());
        let seed = differing("--seed", first.seed.to_string(), second.seed.to_string());
        if sameness == Sameness::Plan {
            return seed;
        }
        // Extended renders have batches of other sizes than those planned for all of their samples.
        let extended = |m: &Metadata| match m.extended_from.as_slice() {
            [] => "not extended".to_owned(),
            at => format!("at {at:?}"),
        };
        seed.or_else(|| differing("--spp", spp(first), spp(second))).or_else(|| {
            differing("the number of samples from which --resume extended it", extended(first), extended(second))
        })
    };
    let device: [Trait; 3] = [
        ("the device", |m| m.device.clone()),
        ("the driver", |m| m.driver.clone()),
        ("the list of adapters", |m| m.mixed.join(", ")),
    ];
    let kernel: [Trait; 1] =
        [("the kernel (by its hash)", |m| m.part.as_ref().map_or_else(String::new, |part| part.kernel.clone()))];
    let list = |of: &[Trait]| of.iter().find_map(|(what, value)| differing(what, value(first), value(second)));
    let excluded: &[&str] = if sameness == Sameness::Plan { &STOPPING } else { &[] };
    let estimator = list(&texts).or_else(|| settings(first, second, excluded)).or_else(numbers);
    match sameness {
        Sameness::Bits => estimator.or_else(|| list(&device)).or_else(|| list(&kernel)),
        Sameness::Estimator => estimator,
        Sameness::Plan => estimator.or_else(|| list(&device)),
    }
}

fn settings(first: &Metadata, second: &Metadata, excluded: &[&str]) -> Option<Difference> {
    let names: BTreeSet<&String> = first.settings.keys().chain(second.settings.keys()).collect();
    let name = names.into_iter().find(|name| {
        let counts = !PLACES.contains(&name.as_str()) && !excluded.contains(&name.as_str());
        counts && first.settings.get(*name) != second.settings.get(*name)
    })?;
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
        let changes: [(&str, Change); 11] = [
            ("version", |m| m.version = "9".into()),
            ("scene", |m| m.scene_hash = "f".into()),
            ("--seed", |m| m.seed = 1),
            ("--spp", |m| m.part.as_mut().unwrap().planned_samples = Some(3)),
            ("device", |m| m.device = "GPU".into()),
            ("driver", |m| m.driver = "9".into()),
            ("adapters", |m| m.mixed = vec!["a".into(), "b".into()]),
            ("extended", |m| m.extended_from = vec![64]),
            ("kernel", |m| m.part.as_mut().unwrap().kernel = "f".into()),
            ("--sampler", |m| m.settings["sampler"] = "stratified".into()),
            ("--max-radiance", |m| _ = m.settings.insert("max-radiance".into(), 9.into())),
        ];
        for (what, change) in changes {
            let mut other = metadata.clone();
            change(&mut other);
            let found = difference(&metadata, &other, Sameness::Bits).unwrap();
            assert!(found.what.contains(what), "{found:?}");
            let back = difference(&other, &metadata, Sameness::Bits).map(|d| (d.second, d.first));
            assert_eq!(back, Some((found.first, found.second)));
            let hardware = ["device", "driver", "adapters", "kernel"].contains(&what);
            assert_eq!(difference(&metadata, &other, Sameness::Estimator).is_none(), hardware, "{what}");
            let plan = ["--spp", "extended", "kernel"].contains(&what);
            assert_eq!(difference(&metadata, &other, Sameness::Plan).is_none(), plan, "{what}");
        }
    }

    #[test]
    fn place_samples_and_file_names_do_not_matter() {
        let mut metadata = Metadata::default();
        metadata.settings.insert("scene".into(), "a/box.glb".into());
        let mut other = Metadata { sample_range: [3, 4], crop: Some([0, 0, 1, 1]), ..Metadata::default() };
        other.settings.insert("scene".into(), "b/box.glb".into());
        other.settings.insert("env".into(), "b/sky.hdr".into());
        assert_eq!(difference(&metadata, &other, Sameness::Bits), None);
    }
}
