//! From a glTF file to pixels: `cargo run --release --example minimal -p surelight-render --
//! scene.glb`

use std::{error::Error, path::Path};

use surelight_film::{Display, Film, Metadata, write_exr, write_png};
use surelight_prepare::{Integrator, Prepared, Settings};
use surelight_render::{AdapterChoice, Device, Goal, Renderer, render};
use surelight_scene::{Environment, LoadOptions};

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: minimal SCENE [SPP]")?;
    let spp = std::env::args().nth(2).map_or(Ok(64), |n| n.parse())?;
    let mut scene = surelight_scene::load(Path::new(&path), &LoadOptions::default())?;
    if !scene.has_light() {
        scene.environment = Some(Environment::Uniform([1.0; 3]));
    }
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
    let settings = Settings { integrator: Integrator::Auto, ..Settings::new(256, 256) };
    let prepared = Prepared::new(&scene, &camera, &settings)?;

    let device = Device::new(&AdapterChoice::Best)?;
    let mut renderer = Renderer::new(&device, &prepared)?;
    let mut film = Film::new(settings.width, settings.height);
    let goal = Goal { spp: Some(spp), ..Goal::default() };
    render(&mut renderer, &mut film, &goal, &mut |_| true)?;
    renderer.trace_features(&mut film)?;

    write_png(Path::new("minimal.png"), &film, &Display::default())?;
    write_exr(Path::new("minimal.exr"), &film, &Metadata::default())?;
    let counts = renderer.counts;
    println!("{} paths in {:.1} s on {}", counts.paths, counts.trace_seconds, device.info.name);
    Ok(())
}
