//! Every kernel that can be put together is valid: naga accepts each feature with what it implies, every pair, what shipped
//! scenes need, and everything at once. And what a scene lacks is not in its kernel.

use surelight_render::{Features, compose, path_kernel};
use surelight_tests::features::{constants, everything, names, set, shipped};

/// Root modules of the kernels of these features.
fn kernels(features: &Features) -> [&'static str; 2] {
    [path_kernel(features).0, "package::kernel::features"]
}

/// The light tracing kernel, which sees through a camera.
const EMIT: &str = "package::kernel::emit";

/// Composes and validates the first `count` kernels, and that of light tracing where it belongs; the error says which features.
fn check(count: usize, features: &Features) -> Result<(), String> {
    let emit = (features.caustics && !features.receiver).then_some(EMIT);
    for root in kernels(features).into_iter().take(count).chain(emit) {
        compose(root, features, constants()).map_err(|e| {
            let on: Vec<_> = features.list().into_iter().filter(|f| f.1).map(|f| f.0).collect();
            format!("{root} with {on:?}: {e}")
        })?;
    }
    Ok(())
}

fn check_all(kernels: usize, sets: impl Iterator<Item = Features>) -> usize {
    let results: Vec<_> = sets.map(|set| check(kernels, &set)).collect();
    let failures: Vec<_> = results.iter().filter_map(|r| r.as_ref().err()).collect();
    assert!(failures.is_empty(), "{} of {} do not compose, the first: {}", failures.len(), results.len(), failures[0]);
    results.len()
}

#[test]
fn nothing_and_each_feature_by_itself() {
    let names = names();
    let sets =
        std::iter::once(Features::default()).chain(names.iter().map(|n| set(&[n]).expect("one excludes nothing")));
    println!("{} sets of features", check_all(2, sets));
}

#[test]
fn each_pair() {
    let names = names();
    let pairs = (0..names.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    // The path kernel has all that the other has.
    let count = check_all(1, pairs.filter_map(|(i, j)| set(&[names[i], names[j]])));
    println!("{count} pairs");
    assert!(count > 300);
}

#[test]
fn everything_at_once() {
    println!("{} sets of features", check_all(2, everything().into_iter()));
}

/// What each binding is for: a kernel has it when one of these features is on, and only then.
const BINDINGS: [(&str, &[&str]); 9] = [
    ("sheen_albedos", &["sheen"]),
    ("texture_uses", &["textures"]),
    ("texels", &["textures"]),
    ("light_table", &["light_sampling"]),
    ("area_lights", &["area_lights"]),
    ("light_nodes", &["light_tree"]),
    ("punctual_lights", &["punctual_lights"]),
    ("environment_texels", &["environment_map"]),
    ("instances", &["instances"]),
];

/// Words that only a kernel with the feature may hold: in functions, records and variables.
const ABSENT: [(&[&str], &str); 10] = [
    (&["media"], "nested"),
    (&["light_tree"], "light_tree"),
    (&["etas", "ior_spread"], "dispersion"),
    (&["sheen"], "sheen"),
    (&["coat"], "clearcoat"),
    (&["film"], "iridescence"),
    (&["anisotropy", "Grain"], "anisotropy"),
    (&["through_color"], "diffuse_transmission"),
    (&["refract", "transmitted"], "transmission"),
    (&["clip_ray", "near_distance"], "camera_clip"),
];

#[test]
fn shipped_scenes_have_what_they_need_and_no_more() {
    let sets = shipped();
    assert!(sets.len() > 10, "the scenes hardly differ");
    for (features, scenes) in &sets {
        check(2, features).unwrap_or_else(|e| panic!("{scenes:?}: {e}"));
        let shader = compose(kernels(features)[0], features, constants()).expect("it has just been composed");
        for (binding, needs) in BINDINGS {
            let wanted = features.list().iter().any(|&(name, on, _)| on && needs.contains(&name));
            let found = shader.module.global_variables.iter().any(|(_, g)| g.name.as_deref() == Some(binding));
            assert_eq!(found, wanted, "binding {binding} of {scenes:?}");
        }
        for (words, feature) in ABSENT {
            let on = features.list().iter().any(|&(name, on, _)| on && name == feature);
            let found = words.iter().find(|word| shader.wgsl.contains(*word));
            assert!(on || found.is_none(), "{found:?} in the kernel of {scenes:?}, which has no {feature}");
            // The words are right: a kernel with the feature has them.
            assert!(!on || found.is_some(), "no word of {feature} in the kernel of {scenes:?}");
        }
    }
    println!("{} sets of features in all", sets.len());
}

/// The checks above can fail.
#[test]
fn what_is_wrong_does_not_compose() {
    assert!(compose("package::kernel::no_such_module", &Features::default(), constants()).is_err());
    assert!(compose(kernels(&Features::default())[0], &Features::default(), &[]).is_err(), "a constant is missing");
    // A texture without the module that looks it up.
    let torn = Features { base_color_texture: true, ..Features::default() };
    assert!(compose(kernels(&torn)[0], &torn, constants()).is_err());
}
