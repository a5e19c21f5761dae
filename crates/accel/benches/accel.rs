//! Building, flattening and traversing trees on the CPU: `cargo bench -p surelight-accel`.
//!
//! Building uses all cores, traversal one. Figures depend on the machine and its load; compare them
//! within one run.

#![allow(missing_docs, reason = "criterion_group! makes a public function without any")]

use std::{hint::black_box, time::Duration};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec3, Vec3};
use surelight_accel::{Accel, BuildOptions, Quality, Ray, Statistics};
use surelight_scene::Scene;
use surelight_scenes::probes;

/// Rays of one measurement of traversal.
const RAYS: usize = 1 << 12;

fn scenes() -> [(&'static str, Scene); 2] {
    [("terrain-100k", probes::terrain(224)), ("soup-100k", probes::soup(100_000, 1))]
}

fn build(scene: &Scene, quality: Quality) -> Accel {
    let options = BuildOptions { quality, ..BuildOptions::default() };
    Accel::build(scene, DVec3::ZERO, &options).expect("procedural scenes can be built")
}

/// Total seconds of one stage of the builds.
fn stage(scene: &Scene, quality: Quality, builds: u64, of: fn(&Statistics) -> Duration) -> Duration {
    (0..builds).map(|_| of(&build(scene, quality).statistics)).sum()
}

fn building(c: &mut Criterion) {
    println!("conditions: {} threads", std::thread::available_parallelism().map_or(1, |n| n.get()));
    let mut group = c.benchmark_group("build");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    for (name, scene) in scenes() {
        group.throughput(Throughput::Elements(scene.meshes.iter().map(|m| m.triangles.len() as u64).sum()));
        for quality in [Quality::Fast, Quality::Medium] {
            group.bench_function(BenchmarkId::new(format!("trees, {quality:?}"), name), |b| {
                b.iter_custom(|n| stage(&scene, quality, n, |s| s.build));
            });
        }
        group.bench_function(BenchmarkId::new("flatten", name), |b| {
            b.iter_custom(|n| stage(&scene, Quality::Fast, n, |s| s.flatten));
        });
    }
    group.finish();
}

/// From a shell around the scene to points within: spread as bounce rays are, from a fixed seed.
fn rays(accel: &Accel) -> Vec<Ray> {
    let mut state = 1u32;
    let mut unit = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let (lo, size) = (accel.bounds.lo, accel.bounds.hi - accel.bounds.lo);
    let mut point = || lo + size * Vec3::new(unit(), unit(), unit());
    (0..RAYS)
        .map(|_| {
            let (from, to) = (point(), point());
            Ray::new(from, (to - from).normalize_or(Vec3::X))
        })
        .collect()
}

fn walking(c: &mut Criterion) {
    let mut group = c.benchmark_group("walk");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(RAYS as u64));
    for (name, scene) in scenes() {
        let accel = build(&scene, Quality::Medium);
        let rays = rays(&accel);
        let items: u64 = rays.iter().map(|r| u64::from(accel.intersect_counted(r).1)).sum();
        println!("{name}: {:.1} items a ray", items as f64 / RAYS as f64);
        group.bench_function(BenchmarkId::new("closest hit", name), |b| {
            b.iter(|| rays.iter().filter(|r| accel.intersect(black_box(r)).is_some()).count());
        });
        group.bench_function(BenchmarkId::new("any hit", name), |b| {
            b.iter(|| rays.iter().filter(|r| accel.occluded(black_box(r))).count());
        });
    }
    group.finish();
}

criterion_group!(benches, building, walking);
criterion_main!(benches);
