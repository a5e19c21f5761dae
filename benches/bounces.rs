//! Traversal of bounce rays on the device: `cargo bench --bench bounces [-- FOLDER [SCENE…]]`.
//!
//! Rays leave the first hits of a picture's camera rays in directions distributed by the cosine, in
//! order of blocks of 8×8 pixels. Each lane traces one. All rays are traced, one after the other,
//! and again, four times; the time of as many rays of no length is subtracted, so that traversal
//! remains. With `FOLDER`, triangles and rays are written there as `NAME.rays`, for
//! `benches/embree.c`, which finds the same hits with Embree.

use std::{io::Write, path::Path, time::Instant};

use glam::{Vec3, vec3};
use surelight_accel::{BuildOptions, Instancing, Ray, TriangleSource};
use surelight_bench::{
    conditions::{cpu_seconds, threads},
    paths::median,
};
use surelight_prepare::{Prepared, Settings};
use surelight_render::{Checks, Probe};
use surelight_scene::{Environment, LoadOptions, Scene};
use surelight_scenes::probes;
use surelight_tests::{
    render::device,
    traversal::{ProbeHit, ProbeRays},
};

const SIZE: u32 = 512;
/// As many as in `embree.c`.
const REPEATS: usize = 4;
const ROUNDS: usize = 5;

fn main() {
    let mut words = std::env::args().skip(1).filter(|a| !a.starts_with('-'));
    let folder = words.next();
    let mut scenes: Vec<Scene> = words
        .map(|file| surelight_scene::load(Path::new(&file), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")))
        .collect();
    if scenes.is_empty() {
        let named = |name: &str, scene| Scene { name: name.into(), ..scene };
        scenes.push(named("terrain-100k", probes::terrain(224)));
        scenes.push(named("terrain-1m", probes::terrain(707)));
        scenes.push(named("soup-100k", probes::soup(100_000, 1)));
    }
    let info = &device().info;
    println!("adapter {}, {}; {} threads; medians of {ROUNDS} rounds", info.name, info.driver, threads());
    println!("| scene | triangles | rays | items a ray | hit | Mrays/s | Mrays a processor second |");
    println!("|---|---|---|---|---|---|---|");
    for mut scene in scenes {
        scene.environment.get_or_insert(Environment::Uniform([1.0; 3]));
        measure(&scene, folder.as_deref().map(Path::new));
    }
}

fn measure(scene: &Scene, folder: Option<&Path>) {
    let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
    // All triangles in the world, as Embree gets them.
    let build = BuildOptions { instancing: Instancing::Never, ..BuildOptions::default() };
    let settings = Settings { build, ..Settings::new(SIZE, SIZE) };
    let prepared = Prepared::new(scene, &camera, &settings).unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    let corners = |source: &TriangleSource| {
        let to_world = scene.instances[source.instance as usize].to_world;
        let mesh = &scene.meshes[source.mesh as usize];
        source.corners.map(|c| {
            (to_world.transform_point3(mesh.positions[c as usize].as_dvec3()) - prepared.accel.origin).as_vec3()
        })
    };
    let rays = bounces(&prepared, camera.to_world.matrix3.as_mat3(), &corners);
    let items: u64 = rays.iter().map(|r| u64::from(prepared.accel.intersect_counted(r).1)).sum();
    let asking = |share: f32| -> Vec<ProbeRays> {
        let mut all: Vec<ProbeRays> = rays.iter().map(ProbeRays::closest).collect();
        all.iter_mut().for_each(|r| r.t_max *= share);
        all.repeat(REPEATS)
    };
    let [all, none] = [asking(1.0), asking(0.0)];
    let entry = ["package::probe::traversal", "probe_traversal"];
    let probe = Probe::new::<ProbeRays, ProbeHit>(device(), &prepared, entry, &all, all.len(), Checks::Trusted)
        .unwrap_or_else(|e| panic!("{}: {e}", scene.name));
    let run = || {
        let (cpu, wall) = (cpu_seconds().unwrap_or(f64::NAN), Instant::now());
        let found: Vec<ProbeHit> = probe.run().unwrap_or_else(|e| panic!("{}: {e}", scene.name));
        (wall.elapsed().as_secs_f64(), cpu_seconds().unwrap_or(f64::NAN) - cpu, found)
    };
    let timed = |queries: &[ProbeRays]| {
        probe.ask(queries);
        run(); // the first run uploads the queries
        run()
    };
    let hits = timed(&all).2;
    let mut seconds = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        let (without, with) = (timed(&none), timed(&all));
        seconds[0].push(with.0 - without.0);
        seconds[1].push(with.1 - without.1);
    }
    let count = rays.len() as f64;
    let rate = |seconds: &[f64]| REPEATS as f64 * count / median(seconds) * 1e-6;
    println!(
        "| {} | {} | {} | {:.1} | {:.1} % | {:.2} | {:.3} |",
        scene.name,
        prepared.accel.triangles.len(),
        rays.len(),
        items as f64 / count,
        100.0 * hits.iter().take(rays.len()).filter(|h| h.hit().is_some()).count() as f64 / count,
        rate(&seconds[0]),
        rate(&seconds[1]),
    );
    if let Some(folder) = folder {
        let path = folder.join(format!("{}.rays", scene.name));
        let written = write(&path, &prepared, &corners, &rays, &hits);
        println!("written: {}: {written:?}", path.display());
    }
}

/// From each first hit a ray into the hemisphere on the camera's side of its triangle.
fn bounces(prepared: &Prepared, axes: glam::Mat3, corners: &dyn Fn(&TriangleSource) -> [Vec3; 3]) -> Vec<Ray> {
    let mut seed = 1u32;
    let mut unit = || {
        seed ^= seed << 13;
        seed ^= seed >> 17;
        seed ^= seed << 5;
        (seed >> 8) as f32 / (1 << 24) as f32
    };
    let mut rays = Vec::new();
    for k in 0..SIZE * SIZE {
        let (block, local) = (k / 64, k % 64);
        let x = (block % (SIZE / 8)) * 8 + local % 8;
        let y = (block / (SIZE / 8)) * 8 + local / 8;
        let at = [x, y].map(|p| (p as f32 + 0.5) / SIZE as f32 - 0.5);
        let camera = Ray::new(Vec3::ZERO, (axes * vec3(0.8 * at[0], -0.8 * at[1], -1.0)).normalize());
        let Some(hit) = prepared.accel.intersect(&camera) else { continue };
        let [a, b, c] = corners(&prepared.accel.triangles[hit.prim as usize]);
        let n = (b - a).cross(c - a).normalize();
        let n = if n.dot(camera.direction) > 0.0 { -n } else { n };
        let (z, angle) = (2.0 * unit() - 1.0, std::f32::consts::TAU * unit());
        let r = (1.0 - z * z).max(0.0).sqrt();
        let p = camera.direction * hit.t;
        let direction = n * 1.001 + vec3(r * angle.cos(), r * angle.sin(), z);
        rays.push(Ray::new(p + n * 1e-5 * (1.0 + p.abs().max_element()), direction.normalize()));
    }
    rays
}

/// Triangles and rays, little-endian: two counts (u32), nine floats per triangle, then for each ray
/// its origin, its direction and the distance that was found here (negative for none).
fn write(
    path: &Path,
    prepared: &Prepared,
    corners: &dyn Fn(&TriangleSource) -> [Vec3; 3],
    rays: &[Ray],
    found: &[ProbeHit],
) -> std::io::Result<()> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    for count in [prepared.accel.triangles.len(), rays.len()] {
        out.write_all(&(count as u32).to_le_bytes())?;
    }
    let mut floats = |values: &[f32]| values.iter().try_for_each(|v| out.write_all(&v.to_le_bytes()));
    for source in &prepared.accel.triangles {
        corners(source).iter().try_for_each(|v| floats(&v.to_array()))?;
    }
    for (ray, found) in rays.iter().zip(found) {
        floats(&ray.origin.to_array())?;
        floats(&ray.direction.to_array())?;
        floats(&[found.hit().map_or(-1.0, |hit| hit.t)])?;
    }
    out.flush()
}
