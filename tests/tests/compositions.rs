//! Every kernel that can be put together is valid: naga accepts each part with its requirements,
//! every pair, the needs of shipped scenes, and as many parts as can be together. And features that
//! a scene lacks are not in its kernel.

use surelight_prepare::{KernelKey, Part, TABLE, compose, compose_modules, path_kernel, shader_modules};
use surelight_tests::kernel_keys::{constants, everything, key_of, shipped};

/// Root modules of the kernels of this key.
fn kernels(key: &KernelKey) -> [&'static str; 2] {
    [path_kernel(key).0, "package::kernel::first_hit"]
}

/// The light tracing kernel.
const EMIT: &str = "package::kernel::light_tracing";

/// Composes and validates the first `count` kernels, and that of light tracing where it belongs;
/// the error names the parts.
fn check(count: usize, key: &KernelKey) -> Result<(), String> {
    let emit = key.has(Part::Caustics).then_some(EMIT);
    for root in kernels(key).into_iter().take(count).chain(emit) {
        compose(root, key, constants()).map_err(|e| {
            let parts: Vec<_> = key.rows().map(|row| row.name).collect();
            format!("{root} with {parts:?}: {e}")
        })?;
    }
    Ok(())
}

fn check_all(kernels: usize, keys: impl Iterator<Item = KernelKey>) -> usize {
    let results: Vec<_> = keys.map(|key| check(kernels, &key)).collect();
    let failures: Vec<_> = results.iter().filter_map(|r| r.as_ref().err()).collect();
    assert!(failures.is_empty(), "{} of {} do not compose, the first: {}", failures.len(), results.len(), failures[0]);
    results.len()
}

#[test]
fn nothing_and_each_part_by_itself() {
    let of = |name| key_of(&[name]).unwrap_or_else(|e| panic!("{name}: {e}"));
    let keys = std::iter::once(KernelKey::default()).chain(TABLE.iter().map(|row| of(row.name)));
    println!("{} keys", check_all(2, keys));
}

#[test]
fn each_pair() {
    let pairs = (0..TABLE.len()).flat_map(|i| (0..i).map(move |j| [TABLE[i].name, TABLE[j].name]));
    // The path kernel has all that the other has.
    let count = check_all(1, pairs.filter_map(|pair| key_of(&pair).ok()));
    println!("{count} pairs");
    assert!(count > 300);
}

#[test]
fn everything_at_once() {
    println!("{} keys", check_all(2, everything().into_iter()));
}

/// The purpose of each binding: a kernel has it when it has one of these parts, and only then.
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

/// Words that only a kernel with the part may hold: in functions, records and variables.
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
    let keys = shipped();
    assert!(keys.len() > 10, "the scenes differ too little");
    for (key, scenes) in &keys {
        check(2, key).unwrap_or_else(|e| panic!("{scenes:?}: {e}"));
        let shader = compose(kernels(key)[0], key, constants()).expect("it has just been composed");
        for (binding, needs) in BINDINGS {
            let wanted = key.rows().any(|row| needs.contains(&row.name));
            let found = shader.module.global_variables.iter().any(|(_, g)| g.name.as_deref() == Some(binding));
            assert_eq!(found, wanted, "binding {binding} of {scenes:?}");
        }
        for (words, part) in ABSENT {
            let on = key.rows().any(|row| row.name == part);
            let found = words.iter().find(|word| shader.wgsl.contains(*word));
            assert!(on || found.is_none(), "{found:?} in the kernel of {scenes:?}, which has no {part}");
            // The words are right: a kernel with the part has them.
            assert!(!on || found.is_some(), "no word of {part} in the kernel of {scenes:?}");
        }
    }
    println!("{} keys in all", keys.len());
}

/// The checks above can fail.
#[test]
fn what_is_wrong_does_not_compose() {
    let key = KernelKey::default();
    assert!(compose("package::kernel::no_such_module", &key, constants()).is_err());
    assert!(compose(kernels(&key)[0], &key, &[]).is_err(), "a constant is missing");
    let textured = key_of(&["base_color_texture"]).expect("nothing excludes it");
    let modules = || shader_modules().iter().map(|&(path, source)| (path, source.to_owned()));
    let whole: Vec<_> = modules().collect();
    assert!(compose_modules(kernels(&textured)[0], &textured, constants(), &whole).is_ok());
    let torn: Vec<_> = modules().filter(|(path, _)| !path.ends_with("::textures")).collect();
    assert!(torn.len() + 1 == whole.len(), "no module of that name");
    assert!(compose_modules(kernels(&textured)[0], &textured, constants(), &torn).is_err());
}
