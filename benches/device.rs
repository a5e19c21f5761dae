//! Upload, traversal and samplers on the device: `cargo bench --bench device`.
//!
//! Seconds are those of the device's own clock where it has one. Figures depend on the machine and
//! its load; compare them within one run.

#![allow(missing_docs, reason = "criterion_group! makes a public function without any")]

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use surelight_film::Film;
use surelight_prepare::{Instrument, Sampler, Settings};
use surelight_render::{Formula, Integrand, Renderer, instrument};
use surelight_scene::Scene;
use surelight_scenes::{cornell_box, probes};
use surelight_tests::render::{device, prepare};

const SIZE: u32 = 128;

fn scenes() -> [(&'static str, Scene); 2] {
    [("cornell-box", cornell_box::cornell_box()), ("terrain-100k", probes::terrain(224))]
}

fn renderer(prepared: &surelight_prepare::Prepared) -> Renderer<'static> {
    Renderer::new(device(), prepared).unwrap_or_else(|e| panic!("{e}"))
}

fn uploading(c: &mut Criterion) {
    println!("conditions: {}, {}", device().info.name, device().info.driver);
    let mut group = c.benchmark_group("upload");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(2));
    for (name, scene) in scenes() {
        let prepared = prepare(&scene, &Settings::new(SIZE, SIZE));
        group.throughput(Throughput::Elements(prepared.accel.triangles.len() as u64));
        group.bench_function(BenchmarkId::from_parameter(name), |b| {
            b.iter_custom(|n| (0..n).map(|_| Duration::from_secs_f64(renderer(&prepared).upload_seconds)).sum());
        });
    }
    group.finish();
}

/// The time of a traversal: the additional time of more traversals of the same rays.
fn walking(c: &mut Criterion) {
    const MORE: u32 = 4;
    let mut group = c.benchmark_group("walk");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for (name, scene) in scenes() {
        let mut prepared = prepare(&scene, &Settings::new(SIZE, SIZE));
        prepared = prepared.instrumented(Instrument::RepeatedTraversal);
        let mut renderer = renderer(&prepared);
        let mut batch = 0;
        let mut traced = |walks: u32| {
            instrument::set_traversals_per_ray(&mut renderer, walks);
            let before = renderer.counts;
            renderer.trace(&mut Film::new(SIZE, SIZE), batch, 1, 1, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
            batch += 1;
            let seconds = renderer.counts.device_seconds - before.device_seconds;
            (seconds, renderer.counts.rays - before.rays)
        };
        let (_, rays) = traced(1);
        group.throughput(Throughput::Elements(rays));
        group.bench_function(BenchmarkId::new("rays of a sample per pixel", name), |b| {
            b.iter_custom(|n| {
                let longer: f64 = (0..n).map(|_| traced(1 + MORE).0 - traced(1).0).sum();
                Duration::from_secs_f64((longer / f64::from(MORE)).max(1e-9))
            });
        });
    }
    group.finish();
}

/// Points of each sampler, summed up by a kernel that does little else.
fn sampling(c: &mut Criterion) {
    const REPLICATES: u32 = 16;
    const SAMPLES: u32 = 1 << 14;
    let formula = Formula::new("x + y", 2).unwrap_or_else(|e| panic!("{e}"));
    let mut group = c.benchmark_group("sampler");
    group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(u64::from(REPLICATES) * u64::from(SAMPLES)));
    for (name, sampler) in
        [("independent", Sampler::Independent), ("stratified", Sampler::Stratified), ("sobol", Sampler::Sobol)]
    {
        let mut integrand =
            Integrand::new(device(), &formula, &[[0.0, 1.0]; 2], 64).unwrap_or_else(|e| panic!("{name}: {e}"));
        group.bench_function(BenchmarkId::new("points", name), |b| {
            b.iter_custom(|n| {
                let started = Instant::now();
                for k in 0..n as u32 {
                    integrand.sample(sampler, REPLICATES, SAMPLES, k, 0).unwrap_or_else(|e| panic!("{name}: {e}"));
                }
                started.elapsed()
            });
        });
    }
    group.finish();
}

criterion_group!(benches, uploading, walking, sampling);
criterion_main!(benches);
