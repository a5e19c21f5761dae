//! The host's records have the layout that kernels read: every record's fields, offsets, sizes and
//! span, compared with those that naga finds in the composed shaders, for every key that ships.

use std::collections::{BTreeMap, BTreeSet};

use surelight_prepare::{KernelKey, Part, RecordLayout, compose, material_fields, path_kernel};
use surelight_render::host_layouts;
use surelight_tests::kernel_keys::{constants, everything, shipped};

/// Fields by name; the host's padding has no counterpart in WGSL.
fn fields(layout: &RecordLayout) -> BTreeMap<&str, (u32, u32)> {
    let of = |name: &String| (layout.offsets[name], layout.sizes[name]);
    layout.offsets.keys().filter(|n| !n.starts_with("pad")).map(|n| (n.as_str(), of(n))).collect()
}

/// Compares every record that a composition has; returns the records' names.
fn compare(key: &KernelKey, what: &str) -> BTreeSet<&'static str> {
    let mut found = BTreeSet::new();
    let emit = key.has(Part::Caustics).then_some("package::kernel::light_tracing");
    for root in [path_kernel(key).0, "package::kernel::first_hit"].into_iter().chain(emit) {
        let shader = compose(root, key, constants()).unwrap_or_else(|e| panic!("{what}: {e}"));
        for (name, host) in host_layouts() {
            let Some(device) = RecordLayout::of(&shader, name) else { continue };
            assert_eq!(fields(&host), fields(&device), "{name} in {root} of {what}");
            assert_eq!(host.span, device.span, "span of {name} in {root} of {what}");
            found.insert(name);
        }
        let written: BTreeMap<_, _> = material_fields().into_iter().collect();
        if let Some(material) = RecordLayout::of(&shader, "Material") {
            for (field, size) in &material.sizes {
                assert_eq!(written.get(field.as_str()), Some(size), "Material.{field} in {root} of {what}");
            }
        }
    }
    found
}

#[test]
fn in_every_kernel_that_ships() {
    for (key, scenes) in shipped() {
        compare(&key, &format!("{scenes:?}"));
    }
}

/// In the general kernels every record and every material field is there: a name on the host alone
/// is a typo.
#[test]
fn in_the_general_kernels() {
    let mut found = BTreeSet::new();
    let mut read = BTreeSet::new();
    for key in everything() {
        found.extend(compare(&key, "everything"));
        let shader = compose(path_kernel(&key).0, &key, constants()).unwrap_or_else(|e| panic!("{e}"));
        read.extend(RecordLayout::of(&shader, "Material").expect("kernels have materials").sizes.into_keys());
    }
    let missing: Vec<_> = host_layouts().into_iter().map(|l| l.0).filter(|name| !found.contains(name)).collect();
    assert!(missing.is_empty(), "no kernel has {missing:?}");
    let unread: Vec<_> = material_fields().into_iter().map(|f| f.0).filter(|name| !read.contains(*name)).collect();
    assert!(unread.is_empty(), "no kernel has the material fields {unread:?}");
}
