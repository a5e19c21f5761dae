//! Case 8: a sample that is not finite is left out and counted, and touches nothing else.

use surelight_film::Film;
use surelight_prepare::Settings;
use surelight_render::{Counts, Renderer};
use surelight_scenes::torture::numeric;
use surelight_tests::render::{all, bits, device, prepare};

const SIZE: [u32; 2] = [24, 24];
const SAMPLES: u32 = 64;

/// The picture of a mirror of this radiance, and the dropped samples.
fn picture(radiance: f32) -> (Film, Counts) {
    let prepared = prepare(&numeric::nan_quarantine(radiance), &Settings::new(SIZE[0], SIZE[1]));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = Film::new(SIZE[0], SIZE[1]);
    renderer.trace(&mut film, 0, 2, SAMPLES, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    (film, renderer.counts)
}

#[test]
fn nan_quarantine() {
    let (clean, counts) = picture(0.0);
    assert_eq!(counts.dropped, 0);
    // Samples that hit the mirror, where the clean picture is black.
    let lost = |i: usize| (1.0 - clean.mean(i)[2] / f64::from(numeric::QUARANTINE_WALL[2])) * clean.samples(i) as f64;
    let hits: f64 = all(&clean).map(lost).sum();
    let cut = all(&clean).filter(|&i| lost(i) > 0.0 && lost(i) < clean.samples(i) as f64).count();
    println!("{hits} samples hit the mirror; it cuts through {cut} pixels");
    assert!(hits.fract() == 0.0 && hits > 1000.0 && cut > 10);
    for radiance in [3e38, f32::INFINITY, f32::NAN] {
        let (film, counts) = picture(radiance);
        assert_eq!(counts.dropped as f64, hits, "samples were dropped for a radiance of {radiance}");
        assert_eq!((counts.truncated, film.refused()), (0, 0));
        let differ = bits(&film).iter().zip(bits(&clean)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differ, 0, "a radiance of {radiance} spoils pixels");
    }
}
