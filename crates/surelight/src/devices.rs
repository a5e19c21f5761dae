//! `surelight devices`: adapters, drivers, limits.

use std::fmt::Write as _;

use serde_json::json;
use surelight_render::{Device, RenderError};

use crate::console;
use crate::error::Error;
use crate::options::DevicesArgs;

/// Lists the adapters of this machine, with their numbers for `--adapter`, the best first.
pub(crate) fn run(args: &DevicesArgs) -> Result<(), Error> {
    let adapters = Device::list();
    if args.json {
        let list: Vec<_> = adapters
            .iter()
            .enumerate()
            .map(|(index, a)| {
                json!({
                    "index": index, "name": a.name, "driver": a.driver, "backend": a.backend, "kind": a.kind,
                    "software": a.is_cpu, "max_binding_bytes": a.max_binding, "max_image_side": a.max_image_side,
                })
            })
            .collect();
        return console::result(&format!("{:#}\n", json!(list)));
    }
    if adapters.is_empty() {
        return Err(RenderError::NoAdapter.into());
    }
    let mut text = String::new();
    for (index, adapter) in adapters.iter().enumerate() {
        let software = if adapter.is_cpu { ", software" } else { "" };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{index}  {}", adapter.name);
        let _ = writeln!(text, "   {} ({}{software})", adapter.backend, adapter.kind);
        let _ = writeln!(text, "   driver {}", adapter.driver);
        let _ = writeln!(
            text,
            "   up to {} MiB a buffer binding, {} texels a side of an image",
            adapter.max_binding >> 20,
            adapter.max_image_side
        );
    }
    console::result(&text)
}
