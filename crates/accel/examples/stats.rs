//! Prints statistics of a scene's acceleration structure: `cargo run --release -p surelight-accel
//! --example stats -- scene.glb [fast|medium|slow] [auto|never]`

use std::{error::Error, path::PathBuf, time::Instant};

use surelight_accel::{Accel, BuildOptions, Instancing, Quality, item::Kind};
use surelight_scene::{LoadOptions, load};

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = BuildOptions::default();
    let mut path = None;
    for argument in std::env::args().skip(1) {
        match argument.as_str() {
            "fast" => options.quality = Quality::Fast,
            "medium" => options.quality = Quality::Medium,
            "slow" => options.quality = Quality::Slow,
            "auto" => options.instancing = Instancing::Auto,
            "never" => options.instancing = Instancing::Never,
            _ => path = Some(PathBuf::from(argument)),
        }
    }
    let path = path.ok_or("name a .glb or .gltf file")?;
    let start = Instant::now();
    let scene = load(&path, &LoadOptions::default())?;
    let loaded = start.elapsed();
    let origin = scene.cameras.first().map_or(glam::DVec3::ZERO, |c| c.to_world.translation);
    let accel = Accel::build(&scene, origin, &options)?;

    let placed = scene.triangle_count();
    let stored = accel.triangles.len();
    let bytes = size_of_val(&accel.items[..]) + size_of_val(&accel.triangles[..]) + size_of_val(&accel.instances[..]);
    let s = accel.statistics;
    println!("{}: {options:?}", path.display());
    println!("triangles        {placed} as placed, {stored} stored, {:?}", accel.skipped);
    println!("instances        {} of {}", accel.instances.len(), scene.instances.len());
    let mut kinds = [0; 3];
    for item in &accel.items {
        kinds[match item.kind() {
            Kind::Node(_) => 0,
            Kind::Pair => 1,
            Kind::Instance => 2,
        }] += 1;
    }
    println!("items            {} (nodes, leaf items, instances: {kinds:?})", accel.items.len());
    println!(
        "bytes            {bytes} in all, {:.1} a stored triangle, {:.1} a placed one",
        bytes as f64 / stored.max(1) as f64,
        bytes as f64 / placed.max(1) as f64
    );
    println!("stack depth      {}", accel.stack_depth);
    println!("SAH, top level   {:.2} items", s.sah);
    println!(
        "seconds          load {:.3}, place {:.3}, build {:.3}, flatten {:.3}",
        loaded.as_secs_f64(),
        s.place.as_secs_f64(),
        s.build.as_secs_f64(),
        s.flatten.as_secs_f64()
    );
    Ok(())
}
