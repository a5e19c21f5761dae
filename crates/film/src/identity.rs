//! Whether two parts belong to one render: then, and only then, they may be joined or resumed.

use std::fmt::Display;

use serde::Serialize;

use crate::settings::{Camera, Environment, Lens};
use crate::{Metadata, Precision, RenderSettings};

/// The properties that two renders must have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compatibility {
    /// Every bit: parts join as if rendered in one go.
    Bits,
    /// The estimator: means and error bars hold. Adapter, driver and kernel may differ.
    Estimator,
    /// All but when the render stops: one extends the other with more samples.
    Plan,
}

/// A property that distinguishes renders, with its name.
type IdentityField = (&'static str, fn(&Metadata) -> String);

/// The first property in which two renders differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Difference {
    /// The property: an option's name, or in words.
    pub what: String,
    /// The value in the first, as it was set.
    pub first: String,
    /// The value in the second.
    pub second: String,
}

/// The first difference by which two parts are not of one render, as far as `required` demands: of
/// scene, settings, seed, planned samples, program, kernel, device and driver. Their place in the
/// image and the samples they hold may differ.
pub fn difference(first: &Metadata, second: &Metadata, required: Compatibility) -> Option<Difference> {
    let differing =
        |what: &str, a: String, b: String| (a != b).then(|| Difference { what: what.into(), first: a, second: b });
    let texts: [IdentityField; 3] = [
        ("the version of Surelight", |m| m.version.clone()),
        ("the version of the settings", |m| or_not_set(m.settings.as_ref().map(|settings| settings.version))),
        ("the scene (by its hash)", |m| m.scene_hash.clone()),
    ];
    let numbers = || {
        let planned = |m: &Metadata| m.part.as_ref().and_then(|part| part.planned_samples);
        let spp = |m: &Metadata| or_not_set(planned(m));
        let seed = differing("--seed", first.seed.to_string(), second.seed.to_string());
        if required == Compatibility::Plan {
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
    let device: [IdentityField; 3] = [
        ("the device", |m| m.device.clone()),
        ("the driver", |m| m.driver.clone()),
        ("the list of adapters", |m| m.mixed.join(", ")),
    ];
    let kernel: [IdentityField; 1] =
        [("the kernel (by its hash)", |m| m.part.as_ref().map_or_else(String::new, |part| part.kernel.clone()))];
    let list = |of: &[IdentityField]| of.iter().find_map(|(what, value)| differing(what, value(first), value(second)));
    let settings = || settings(first.settings.as_ref()?, second.settings.as_ref()?, required);
    let estimator = list(&texts).or_else(settings).or_else(numbers);
    match required {
        Compatibility::Bits => estimator.or_else(|| list(&device)).or_else(|| list(&kernel)),
        Compatibility::Estimator => estimator,
        Compatibility::Plan => estimator.or_else(|| list(&device)),
    }
}

/// A setting that identifies a render.
struct Setting {
    /// The option that sets it, or words where several do.
    name: &'static str,
    /// Its value; equal settings have equal values.
    value: String,
    /// Whether it follows from when the render stops.
    is_stopping: bool,
}

/// All settings but the names of files: the hash of the scene covers the contents of the files, and
/// their place does not matter. The patterns name every field, so that a new one does not compile
/// until it is listed here.
fn table(settings: &RenderSettings) -> [Setting; 22] {
    let RenderSettings {
        version: _, // compared before
        scene: _,
        size: [width, height],
        camera,
        unclipped,
        lens,
        environment,
        max_bounces,
        integrator,
        directions,
        sampler,
        one_sequence,
        path_reuse,
        adaptive,
        transparent,
        multiple_scattering,
        max_radiance,
        precision,
    } = settings;
    let (aperture, focus) = lens.map(|Lens { aperture, focus }| (aperture, focus)).unzip();
    let (map, rotation, scale, sky) = match environment {
        Environment::Scene => (None, None, None, None),
        Environment::Uniform { radiance: [r, g, b] } => (None, None, None, Some(format!("{r},{g},{b}"))),
        Environment::Map { file: _, rotation, scale } => (Some("set"), Some(rotation), Some(scale), None),
    };
    let (error, confidence, bound) = match precision {
        None => (None, None, None),
        Some(Precision { error, confidence, bound }) => (Some(error), Some(confidence), Some(word(bound))),
    };
    let of = |name, value| Setting { name, value, is_stopping: false };
    let stopping = |name, value| Setting { name, value, is_stopping: true };
    let flag = |on: &bool| or_not_set(on.then_some(true));
    let switch = |on: bool| if on { "on" } else { "off" }.to_owned();
    let sequences = if *one_sequence { "one per pixel" } else { "one per batch" };
    [
        of("--size", format!("{width}x{height}")),
        of(CAMERA, camera_text(camera)),
        of("--clip", switch(!unclipped)),
        of("--aperture", or_not_set(aperture)),
        of("--focus", or_not_set(focus)),
        of("--env", or_not_set(map)),
        of("--env-rotate", or_not_set(rotation)),
        of("--env-scale", or_not_set(scale)),
        of("--sky", or_not_set(sky)),
        of("--max-bounces", max_bounces.map_or_else(|| "unlimited".to_owned(), |n| n.to_string())),
        of("--integrator", word(integrator)),
        of("--directions", or_not_set(directions.as_ref().map(word))),
        of("--sampler", word(sampler)),
        stopping("the number of scrambles", sequences.to_owned()), // --one-scramble, or few samples
        of("--shared-paths", switch(*path_reuse)),
        of("--adaptive", flag(adaptive)),
        of("--transparent", flag(transparent)),
        of("--multiple-scattering", flag(multiple_scattering)),
        of("--max-radiance", or_not_set(*max_radiance)),
        stopping("--error", or_not_set(error)),
        stopping("--confidence", or_not_set(confidence)),
        stopping("--bound", or_not_set(bound)),
    ]
}

/// A property that several options set, with a value too long for a sentence.
const CAMERA: &str = "the camera";

/// The camera's record; its pattern names every field.
fn camera_text(Camera { name, to_world, projection }: &Camera) -> String {
    serde_json::json!([name, to_world, projection]).to_string()
}

fn or_not_set(value: Option<impl Display>) -> String {
    value.map_or_else(|| "not set".to_owned(), |value| value.to_string())
}

/// The word by which the record names a value.
fn word(value: &impl Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// The first setting that differs.
fn settings(first: &RenderSettings, second: &RenderSettings, required: Compatibility) -> Option<Difference> {
    let compared = |setting: &Setting| !(setting.is_stopping && required == Compatibility::Plan);
    let mut pairs = table(first).into_iter().zip(table(second)).filter(|(setting, _)| compared(setting));
    let (first, second) = pairs.find(|(first, second)| first.value != second.value)?;
    let (first, second, what) = match first.name {
        CAMERA => ("one".to_owned(), "another".to_owned(), CAMERA),
        name => (first.value, second.value, name),
    };
    Some(Difference { what: what.to_owned(), first, second })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{Directions, Integrator, Projection, Sampler};
    use crate::{Bound, RenderPart};

    fn metadata(settings: RenderSettings) -> Metadata {
        Metadata { settings: Some(settings), part: Some(RenderPart::default()), ..Metadata::default() }
    }

    /// The differences both ways, the second the mirror image of the first.
    fn found(first: &Metadata, second: &Metadata, required: Compatibility) -> Option<Difference> {
        let found = difference(first, second, required);
        let back = difference(second, first, required);
        let mirrored = |d: Difference| match d.what.as_str() {
            CAMERA => d, // one and another, either way
            _ => Difference { first: d.second, second: d.first, what: d.what },
        };
        assert_eq!(back.map(mirrored), found);
        found
    }

    #[test]
    fn everything_that_shapes_the_bits_is_compared() {
        let metadata = metadata(RenderSettings::default());
        type Change = fn(&mut Metadata);
        let changes: [(&str, Change); 11] = [
            ("version of Surelight", |m| m.version = "9".into()),
            ("version of the settings", |m| m.settings.as_mut().unwrap().version = 0),
            ("version of the settings", |m| m.settings = None),
            ("scene", |m| m.scene_hash = "f".into()),
            ("--seed", |m| m.seed = 1),
            ("--spp", |m| m.part.as_mut().unwrap().planned_samples = Some(3)),
            ("device", |m| m.device = "GPU".into()),
            ("driver", |m| m.driver = "9".into()),
            ("adapters", |m| m.mixed = vec!["a".into(), "b".into()]),
            ("extended", |m| m.extended_from = vec![64]),
            ("kernel", |m| m.part.as_mut().unwrap().kernel = "f".into()),
        ];
        for (what, change) in changes {
            let mut other = metadata.clone();
            change(&mut other);
            let difference = found(&metadata, &other, Compatibility::Bits).unwrap();
            assert!(difference.what.contains(what), "{difference:?}");
            let hardware = ["device", "driver", "adapters", "kernel"].contains(&what);
            assert_eq!(found(&metadata, &other, Compatibility::Estimator).is_none(), hardware, "{what}");
            let plan = ["--spp", "extended", "kernel"].contains(&what);
            assert_eq!(found(&metadata, &other, Compatibility::Plan).is_none(), plan, "{what}");
        }
    }

    #[test]
    fn every_setting_is_compared() {
        let settings = RenderSettings {
            lens: Some(Lens { aperture: 0.1, focus: 2.0 }),
            environment: Environment::Map { file: "sky.hdr".into(), rotation: 0.0, scale: 1.0 },
            precision: Some(Precision { error: 0.02, confidence: 0.95, bound: Bound::Clt }),
            ..RenderSettings::default()
        };
        type Change = fn(&mut RenderSettings);
        let map = |rotation, scale| Environment::Map { file: "sky.hdr".into(), rotation, scale };
        let environments =
            [map(90.0, 1.0), map(0.0, 2.0), Environment::Scene, Environment::Uniform { radiance: [1.0, 0.5, 0.0] }];
        let whats = ["--env-rotate is 0, 90", "--env-scale is 1, 2", "--env is set, not set", "--env is set, not set"];
        let environments = environments.map(|environment| RenderSettings { environment, ..settings.clone() });
        let environments = whats.into_iter().zip(environments);
        let changes: [(&str, Change); 24] = [
            ("--size is 0x0, 1x0", |s| s.size[0] = 1),
            ("--size is 0x0, 0x1", |s| s.size[1] = 1),
            ("the camera is one, another", |s| s.camera.name = "a".into()),
            ("the camera is one, another", |s| s.camera.to_world[11] = f64::MIN_POSITIVE),
            ("the camera is one, another", |s| {
                s.camera.projection = Projection::Perspective { yfov: 1.0, aspect: None };
            }),
            ("the camera is one, another", |s| {
                s.camera.projection = Projection::Orthographic { xmag: 1.0, ymag: 1.0 };
            }),
            ("--clip is on, off", |s| s.unclipped = true),
            ("--aperture is 0.1, not set", |s| s.lens = None),
            ("--aperture is 0.1, 0.2", |s| s.lens.as_mut().unwrap().aperture = 0.2),
            ("--focus is 2, 3", |s| s.lens.as_mut().unwrap().focus = 3.0),
            ("--max-bounces is unlimited, 2", |s| s.max_bounces = Some(2)),
            ("--integrator is mis, caustics", |s| s.integrator = Integrator::Caustics),
            ("--directions is not set, bsdf", |s| s.directions = Some(Directions::Bsdf)),
            ("--sampler is sobol, stratified", |s| s.sampler = Sampler::Stratified),
            ("the number of scrambles is one per batch, one per pixel", |s| s.one_sequence = true),
            ("--shared-paths is off, on", |s| s.path_reuse = true),
            ("--adaptive is not set, true", |s| s.adaptive = true),
            ("--transparent is not set, true", |s| s.transparent = true),
            ("--multiple-scattering is not set, true", |s| s.multiple_scattering = true),
            ("--max-radiance is not set, 0.3", |s| s.max_radiance = Some(0.3)),
            ("--error is 0.02, not set", |s| s.precision = None),
            ("--error is 0.02, 0.03", |s| s.precision.as_mut().unwrap().error = 0.03),
            ("--confidence is 0.95, 0.99", |s| s.precision.as_mut().unwrap().confidence = 0.99),
            ("--bound is clt, chebyshev", |s| s.precision.as_mut().unwrap().bound = Bound::Chebyshev),
        ];
        let changed = changes.into_iter().map(|(what, change)| {
            let mut changed = settings.clone();
            change(&mut changed);
            (what, changed)
        });
        let mut names = Vec::new();
        for (what, changed) in changed.chain(environments) {
            let [first, second] = [&settings, &changed].map(|settings| metadata(settings.clone()));
            let Difference { what: name, first: a, second: b } = found(&first, &second, Compatibility::Bits).unwrap();
            assert_eq!(format!("{name} is {a}, {b}"), what);
            let stopping = ["--error", "--confidence", "--bound", "the number of scrambles"].contains(&name.as_str());
            assert_eq!(found(&first, &second, Compatibility::Plan).is_none(), stopping, "{what}");
            names.push(name);
        }
        let sky = |x: f32| {
            metadata(RenderSettings {
                environment: Environment::Uniform { radiance: [1.0, x, 0.0] },
                ..settings.clone()
            })
        };
        let Difference { what, first, second } = found(&sky(0.5), &sky(0.25), Compatibility::Bits).unwrap();
        assert_eq!((what.as_str(), first.as_str(), second.as_str()), ("--sky", "1,0.5,0", "1,0.25,0"));
        names.push(what);
        for Setting { name, .. } in table(&settings) {
            assert!(names.iter().any(|changed| changed == name), "no change of {name} is tested");
        }
    }

    #[test]
    fn place_samples_and_file_names_do_not_matter() {
        let of = |folder: &str| {
            let environment = Environment::Map { file: format!("{folder}/sky.hdr"), rotation: 0.0, scale: 1.0 };
            metadata(RenderSettings { scene: format!("{folder}/box.glb"), environment, ..RenderSettings::default() })
        };
        let other = Metadata { sample_range: [3, 4], crop: Some([0, 0, 1, 1]), ..of("b") };
        assert_eq!(difference(&of("a"), &other, Compatibility::Bits), None);
    }
}
