//! Adding batches to a film and judging its error: `cargo bench -p surelight-film`.

#![allow(missing_docs, reason = "criterion_group! makes a public function without any")]

use std::{hint::black_box, time::Duration};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use surelight_film::{BatchSum, Film};

const SIDE: u32 = 512;

fn batches(c: &mut Criterion) {
    println!("conditions: {} threads", std::thread::available_parallelism().map_or(1, |n| n.get()));
    let pixels: Vec<u32> = (0..SIDE * SIDE).collect();
    let batch = |k: u32| -> Vec<BatchSum> {
        let value = |p: u32| (p.wrapping_mul(747_796_405).wrapping_add(k) >> 8) as f32 / (1 << 24) as f32;
        pixels.iter().map(|&p| BatchSum::new([value(p), 1.0, 0.5], 1.0, 1.0)).collect()
    };
    let mut group = c.benchmark_group("film");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    let sums = batch(1);
    let mut film = Film::new(SIDE, SIDE);
    group.bench_function("add a batch", |b| b.iter(|| film.add_batch(4, &pixels, black_box(&sums)).expect("it fits")));
    let mut film = Film::new(SIDE, SIDE);
    for k in 0..16 {
        film.add_batch(4, &pixels, &batch(k)).expect("it fits");
    }
    group.bench_function("variance of every pixel", |b| {
        b.iter(|| (0..pixels.len()).filter_map(|i| film.variance_of_mean(i)).map(|v| v[1]).sum::<f64>());
    });
    group.finish();
}

criterion_group!(benches, batches);
criterion_main!(benches);
