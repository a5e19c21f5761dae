//! Every kernel composes and validates, for features one by one and all together.

use surelight_render::{Constant, Features, compose};

fn constants() -> Vec<Constant> {
    ["STACK_SIZE", "ATTRIBUTE_STRIDE", "ATTRIBUTE_LIGHT", "ATTRIBUTE_NORMALS", "ATTRIBUTE_TANGENTS", "ATTRIBUTE_COLORS", "ATTRIBUTE_UVS"]
        .into_iter()
        .map(|name| Constant { name, value: 32 })
        .collect()
}

#[test]
fn quick() {
    for on in [&[][..], &["emission", "light_sampling", "area_lights"], &["ggx", "environment_uniform"]] {
        let mut f = Features::default();
        for name in on {
            assert!(f.set(name, true));
        }
        for root in ["package::kernel::path", "package::kernel::features"] {
            let c = compose(root, &f, &constants()).unwrap_or_else(|e| panic!("{on:?}: {e}"));
            println!("{on:?} {root}: {} bytes", c.wgsl.len());
        }
    }
    let mut f = Features::default();
    for (name, ..) in Features::default().list() {
        f.set(name, name != "environment_uniform" && name != "orthographic");
    }
    compose("package::kernel::path", &f, &constants()).unwrap_or_else(|e| panic!("all: {e}"));
}
