//! Loads a scene and lists its contents: `cargo run --release --example load -p surelight-scene --
//! scene.glb`

use std::path::Path;
use std::time::Instant;

use surelight_scene::{LoadError, LoadOptions, load};

fn main() -> Result<(), LoadError> {
    for argument in std::env::args().skip(1) {
        let start = Instant::now();
        let scene = load(Path::new(&argument), &LoadOptions::default())?;
        println!("{} loaded in {:.0} ms", scene.name, start.elapsed().as_secs_f64() * 1e3);
        println!(
            "  {} triangles in {} instances of {} meshes",
            scene.triangle_count(),
            scene.instances.len(),
            scene.meshes.len()
        );
        println!(
            "  {} materials, {} textures, {} images",
            scene.materials.len(),
            scene.textures.len(),
            scene.images.len()
        );
        println!("  {} cameras, {} punctual lights", scene.cameras.len(), scene.lights.len());
        if let Some((low, high)) = scene.bounds() {
            println!("  from {low:.3} to {high:.3}");
        }
        for extension in &scene.extensions {
            println!("  {} is {}", extension.name, if extension.honoured { "honoured" } else { "ignored" });
        }
        for warning in &scene.warnings {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
