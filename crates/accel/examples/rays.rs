//! Traces camera rays and two diffuse bounces of them on one thread and prints items per ray and
//! rays per second: `cargo run --release -p surelight-accel --example rays -- scene.glb
//! [fast|medium|slow] [auto|never]`; instead of a file `terrain:N` (2 N² triangles) or `soup:N`.
//!
//! Compare trees by items per ray; the speed is that of the CPU implementation, not of a kernel.

use std::{error::Error, path::PathBuf, time::Instant};

use glam::{Vec3, vec3};
use surelight_accel::{Accel, BuildOptions, Hit, Instancing, NO_INSTANCE, Quality, Ray};
use surelight_scene::{LoadOptions, Scene, load};
use surelight_scenes::probes;

const SIZE: usize = 512;

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
    let path = path.ok_or("name a .glb or .gltf file, or terrain:N or soup:N")?;
    let scene = match path.to_str().and_then(|text| text.split_once(':')) {
        Some(("terrain", side)) => probes::terrain(side.parse()?),
        Some(("soup", triangles)) => probes::soup(triangles.parse()?, 1),
        _ => load(&path, &LoadOptions::default())?,
    };
    let origin = scene.cameras.first().map_or(glam::DVec3::ZERO, |c| c.to_world.translation);
    let accel = Accel::build(&scene, origin, &options)?;
    let s = accel.statistics;
    println!("{} {options:?}: SAH {:.2}, depth {}", path.display(), s.sah, accel.stack_depth);
    println!("placed in {:.2?}, built in {:.2?}, flattened in {:.2?}", s.place, s.build, s.flatten);

    let mut rays = camera_rays(&scene, &accel);
    let mut seed = 1u32;
    for bounce in 0..3 {
        let start = Instant::now();
        let answers: Vec<(Option<Hit>, u32)> = rays.iter().map(|r| accel.intersect_counted(r)).collect();
        let seconds = start.elapsed().as_secs_f64();
        let items: u64 = answers.iter().map(|a| u64::from(a.1)).sum();
        let hits = answers.iter().filter(|a| a.0.is_some()).count();
        println!(
            "bounce {bounce}: {} rays, {:.1} % hit, {:.1} items a ray, {:.2} Mrays/s",
            rays.len(),
            100.0 * hits as f64 / rays.len() as f64,
            items as f64 / rays.len() as f64,
            rays.len() as f64 / seconds * 1e-6
        );
        rays = rays.iter().zip(&answers).filter_map(|(r, a)| a.0.map(|h| bounced(&accel, r, &h, &mut seed))).collect();
        if rays.is_empty() {
            break;
        }
    }
    Ok(())
}

fn camera_rays(scene: &Scene, accel: &Accel) -> Vec<Ray> {
    let middle = (accel.bounds.lo + accel.bounds.hi) * 0.5;
    let radius = (accel.bounds.hi - accel.bounds.lo).length() * 0.5;
    let (eye, right, up, forward) = match scene.cameras.first() {
        Some(c) => {
            let m = c.to_world.matrix3;
            (Vec3::ZERO, m.x_axis.as_vec3(), m.y_axis.as_vec3(), -m.z_axis.as_vec3())
        }
        None => (middle + vec3(0.5, 0.5, 2.0) * radius, Vec3::X, Vec3::Y, vec3(-0.5, -0.5, -2.0).normalize()),
    };
    (0..SIZE * SIZE)
        .map(|k| {
            let x = ((k % SIZE) as f32 + 0.5) / SIZE as f32 - 0.5;
            let y = 0.5 - ((k / SIZE) as f32 + 0.5) / SIZE as f32;
            Ray::new(eye, (forward + right * x * 0.8 + up * y * 0.8).normalize())
        })
        .collect()
}

/// A cosine-distributed direction about the normal on the ray's side.
fn bounced(accel: &Accel, ray: &Ray, hit: &Hit, seed: &mut u32) -> Ray {
    let [a, b, c] = accel.items[hit.item as usize].corners(hit.prim);
    let n = (b - a).cross(c - a);
    let n = match accel.instances.get(hit.instance as usize) {
        Some(record) if hit.instance != NO_INSTANCE => {
            let m = &record.to_object;
            (0..3).map(|k| vec3(m[4 * k], m[4 * k + 1], m[4 * k + 2]) * n[k]).sum()
        }
        _ => n,
    }
    .normalize();
    let n = if n.dot(ray.direction) > 0.0 { -n } else { n };
    let mut unit = || {
        *seed ^= *seed << 13;
        *seed ^= *seed >> 17;
        *seed ^= *seed << 5;
        (*seed >> 8) as f32 / (1 << 24) as f32
    };
    let (z, a) = (2.0 * unit() - 1.0, std::f32::consts::TAU * unit());
    let r = (1.0 - z * z).max(0.0).sqrt();
    let p = ray.origin + ray.direction * hit.t;
    Ray::new(p + n * 1e-5 * (1.0 + p.abs().max_element()), (n * 1.001 + vec3(r * a.cos(), r * a.sin(), z)).normalize())
}
