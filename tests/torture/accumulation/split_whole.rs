//! Case 41: samples are a pure function of pixel, batch, index and seed: however a render is cut
//! into passes, dispatches and tiles, its bits are the same; with another seed they are not.

use surelight_film::{Film, Window};
use surelight_prepare::{Instrument, Prepared, Settings};
use surelight_render::{Renderer, instrument};
use surelight_scenes::torture;
use surelight_tests::render::{all, bits, device, prepare};

const SIZE: [u32; 2] = [48, 40];
const BATCHES: u32 = 12;

fn cornell(seed: u32) -> Prepared {
    prepare(&torture::scene("split-whole"), &Settings { seed, ..Settings::new(SIZE[0], SIZE[1]) })
}

/// Traces passes of so many batches, one after the other.
fn passes(renderer: &mut Renderer<'_>, sizes: &[u32]) -> Film {
    let mut film = Film::new(SIZE[0], SIZE[1]);
    let mut first = 0;
    for &batches in sizes {
        assert!(renderer.trace(&mut film, first, batches, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}")));
        first += batches;
    }
    assert_eq!(first, BATCHES);
    film
}

#[test]
fn split_whole() {
    let prepared = cornell(3);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let whole = passes(&mut renderer, &[BATCHES]);
    let lit = all(&whole).filter(|&i| whole.mean(i)[0] > 0.0).count();
    assert!(lit > whole.pixels().len() / 2, "only {lit} pixels are lit");
    for sizes in [&[1; BATCHES as usize][..], &[5, 7], &[1, 2, 4, 5], &[BATCHES]] {
        // The renderer's step budget has grown meanwhile: dispatches are cut elsewhere.
        assert!(bits(&passes(&mut renderer, sizes)) == bits(&whole), "passes of {sizes:?} batches differ");
    }
    let mut fresh = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    assert!(bits(&passes(&mut fresh, &[BATCHES])) == bits(&whole), "a second renderer differs");
}

/// Batches may come in any order: the film's totals are wide enough.
#[test]
fn split_whole_in_any_order() {
    let prepared = cornell(4);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut film = |order: &[u32]| {
        let mut film = Film::new(SIZE[0], SIZE[1]);
        for &batch in order {
            renderer.trace(&mut film, batch, 1, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        }
        all(&film).map(|i| film.mean(i).map(|v| v as f32)).collect::<Vec<_>>()
    };
    assert_eq!(film(&[0, 1, 2, 3, 4, 5]), film(&[3, 5, 1, 0, 4, 2]));
}

/// A pass that is stopped leaves nothing behind; done again it gives the same.
#[test]
fn split_whole_by_interruptions() {
    let prepared = cornell(5);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let whole = passes(&mut renderer, &[BATCHES]);
    let mut film = Film::new(SIZE[0], SIZE[1]);
    let mut fresh = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let stopped = fresh.trace(&mut film, 0, BATCHES, 4, &mut |_| false).unwrap_or_else(|e| panic!("{e}"));
    assert!(!stopped && film.samples(0) == 0);
    assert!(bits(&passes(&mut fresh, &[BATCHES])) == bits(&whole));
}

#[test]
fn split_whole_by_tiles() {
    let prepared = cornell(6);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let whole = passes(&mut renderer, &[BATCHES]);
    for max_lanes in [1, 500, 1000] {
        let mut tiled = instrument::with_lanes(device(), &prepared, max_lanes).unwrap_or_else(|e| panic!("{e}"));
        assert!(tiled.lanes() < renderer.lanes(), "{max_lanes} lanes make no tiles");
        assert!(bits(&passes(&mut tiled, &[BATCHES])) == bits(&whole), "tiles of {max_lanes} lanes differ");
    }
}

/// A kernel that traverses rays repeatedly, for timing, makes the same picture.
#[test]
fn however_often_rays_are_walked() {
    let mut prepared = cornell(6);
    let whole = passes(&mut Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}")), &[BATCHES]);
    prepared = prepared.instrumented(Instrument::RepeatedTraversal);
    let mut repeating = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    for walks in [1, 3] {
        instrument::set_traversals_per_ray(&mut repeating, walks);
        let before = repeating.counts;
        assert!(bits(&passes(&mut repeating, &[BATCHES])) == bits(&whole), "{walks} traversals per ray");
        assert!(repeating.counts.device_seconds > before.device_seconds);
    }
    // The clock of the device cannot show more than the wait for it.
    assert!(repeating.counts.device_seconds <= repeating.counts.trace_seconds * 1.001);
}

/// Pixels are known by their number in the whole picture: crops trace these alone, and put together
/// they are the whole.
#[test]
fn split_whole_by_crops() {
    let prepared = cornell(7);
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let mut whole = passes(&mut renderer, &[BATCHES]);
    renderer.trace_features(&mut whole).unwrap_or_else(|e| panic!("{e}"));
    let mut joined = Film::new(SIZE[0], SIZE[1]);
    for edges in [[0, 0, 48, 1], [0, 1, 17, 40], [17, 1, 48, 9], [17, 9, 48, 40]] {
        let window = Window::crop(SIZE, edges).unwrap_or_else(|| panic!("{edges:?}"));
        let mut film = Film::of_window(window);
        let paths = renderer.counts.paths;
        renderer.trace(&mut film, 0, BATCHES, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(renderer.counts.paths - paths, window.area() * u64::from(4 * BATCHES));
        renderer.trace_features(&mut film).unwrap_or_else(|e| panic!("{e}"));
        joined.merge(&film).unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(bits(&joined) == bits(&whole));
    assert_eq!(joined.features(), whole.features());
}

#[test]
fn seeds_and_batches_differ() {
    let film = |seed, first| {
        let prepared = cornell(seed);
        let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
        let mut film = Film::new(SIZE[0], SIZE[1]);
        renderer.trace(&mut film, first, 1, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        bits(&film)
    };
    let first = film(1, 0);
    for (seed, batch) in [(2, 0), (1, 1), (0, 1), (1, 1 << 20), (1 << 31, 0)] {
        let other = film(seed, batch);
        let same = first.iter().zip(&other).filter(|(a, b)| a == b && **a != [0; 3]).count();
        // Some pixels show the lamp alone.
        assert!(same < first.len() / 20, "{same} pixels are alike with seed {seed}, batch {batch}");
    }
}
