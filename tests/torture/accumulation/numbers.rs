//! Cases 42 and 43: random numbers that do not repeat, and are independent of one another.

use std::collections::HashMap;

use surelight_estimate::{normal_quantile, sidak_level};
use surelight_tests::render::ALPHA;
use surelight_tests::sampler::{Point, Query, SAMPLERS, sample};

/// Samples of a batch.
const COUNT: u32 = 4096;

/// Points of one pixel around each place where a counter could wrap: sample numbers 2^24 and 2^32
/// in batches of 4096, batch numbers 2^24 and 2^32, indices 2^24 and 2^32 within a batch.
fn windows() -> Vec<Query> {
    let batches = [0, 1, (1 << 12) - 1, 1 << 12, (1 << 20) - 1, 1 << 20, (1 << 24) - 1, 1 << 24, u32::MAX];
    let whole = batches.into_iter().flat_map(|replicate| {
        (0..COUNT).map(move |index| Query { replicate, index, count: COUNT, ..Query::default() })
    });
    whole.collect()
}

/// Indices of one long sequence, around 2^24 and up to 2^32.
fn long_windows() -> Vec<Query> {
    let starts = [0, (1 << 24) - 2048, u32::MAX - 4095];
    let long = starts.into_iter().flat_map(|start| (0..COUNT).map(move |k| start + k));
    long.map(|index| Query { index, count: COUNT, ..Query::default() }).collect()
}

/// How often a point of the unit square comes again.
fn repeats(points: &[Point]) -> usize {
    let mut seen: HashMap<[u32; 2], usize> = HashMap::new();
    points.iter().for_each(|p| *seen.entry(p.bits).or_default() += 1);
    seen.values().map(|n| n - 1).sum()
}

#[test]
fn index_wrap() {
    for (name, features) in SAMPLERS {
        // Strata are those of one batch, so a stratified sequence has no more points than its
        // batch.
        let mut sets = vec![("batches", windows())];
        if name != "stratified" {
            sets.push(("a long sequence", long_windows()));
        }
        for (what, queries) in sets {
            let found = repeats(&sample(features, &queries));
            // The independent sampler's two coordinates come from one hash of 32 bits, so that of n
            // points some n²/2^33 coincide by chance: 0.16 of 36,864. More than 2 would be detected
            // one time in a thousand.
            println!("{name}, {what}: {found} of {} points recur", queries.len());
            assert!(found <= 2, "{name}, {what}: {found} of {} points recur", queries.len());
        }
    }
}

/// From a sample to an adjacent one.
type Shift = fn(Query) -> Query;

/// Pearson's correlation.
fn pearson(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        ab += (x - ma) * (y - mb);
        aa += (x - ma) * (x - ma);
        bb += (y - mb) * (y - mb);
    }
    ab / (aa * bb).sqrt()
}

/// Number by number, over many pixels: one sample's coordinates against the next pixel's, row's,
/// batch's and seed's, and against all its other dimensions. Pixels are independent, so a
/// correlation of n of them has the standard error n^−½.
#[test]
fn correlation() {
    const PIXELS: u32 = 1 << 15;
    const PAIRS: u32 = 8;
    let shifted: [(&str, Shift); 5] = [
        ("the same sample", |q| q),
        ("the next pixel", |q| Query { pixel: q.pixel + 1, ..q }),
        ("the next row", |q| Query { pixel: q.pixel + 1920, ..q }),
        ("the next batch", |q| Query { replicate: q.replicate + 1, ..q }),
        ("the next seed", |q| Query { seed: q.seed + 1, ..q }),
    ];
    for (name, features) in SAMPLERS {
        // Columns: coordinates, pair by pair.
        let columns = |shift: Shift| -> Vec<Vec<f64>> {
            let query = |pair| move |pixel| shift(Query { pixel, pair, index: 5, count: 64, ..Query::default() });
            let queries: Vec<_> = (0..PAIRS).flat_map(|pair| (0..PIXELS).map(query(pair))).collect();
            let points = sample(features, &queries);
            let of = |pair: &[Point], axis: usize| pair.iter().map(|p| p.unit_square()[axis]).collect();
            points.chunks(PIXELS as usize).flat_map(|pair| [of(pair, 0), of(pair, 1)]).collect()
        };
        let own = columns(shifted[0].1);
        let mut found: Vec<(f64, String)> = Vec::new();
        for (k, (what, shift)) in shifted.iter().enumerate() {
            let other = if k == 0 { own.clone() } else { columns(*shift) };
            for (i, a) in own.iter().enumerate() {
                for (j, b) in other.iter().enumerate().filter(|(j, _)| k > 0 || *j > i) {
                    found.push((pearson(a, b), format!("{what}, dimensions {i} and {j}")));
                }
            }
        }
        let error = f64::from(PIXELS).powf(-0.5);
        let bound = normal_quantile(1.0 - sidak_level(ALPHA, found.len()) / 2.0) * error;
        let (worst, place) = found.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).expect("there are some");
        println!(
            "{name}: {} correlations, {worst:+.4} at most ({place}), bound {bound:.4}; {:.4} would be detected",
            found.len(),
            bound + 1.2816 * error
        );
        assert!(worst.abs() < bound, "{name}: {place} are correlated by {worst:+.4}");
        let rms = (found.iter().map(|f| f.0 * f.0).sum::<f64>() / found.len() as f64).sqrt() / error;
        assert!((rms - 1.0).abs() < 0.15, "{name}: correlations are {rms:.2} times those of chance");
    }
}
