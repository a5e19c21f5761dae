//! Pixels that have more samples, or fewer, by how noisy their surroundings are.

use std::collections::BTreeSet;

use surelight_estimate::{Estimate, detectable_bias, sidak_level, welch_test};
use surelight_film::{Film, Window};
use surelight_prepare::{Part, PathReuse, Settings};
use surelight_render::Renderer;
use surelight_scene::{Projection, Scene};
use surelight_scenes::cornell_box::cornell_box;
use surelight_tests::render::{ALPHA, all, bits, device, prepare};

const SIZE: [u32; 2] = [45, 30];

/// A Cornell box in the midst of nothing, where there is no noise.
pub(super) fn far_box() -> Scene {
    let mut scene = cornell_box();
    scene.cameras[0].projection = Projection::Perspective { yfov: 1.3, aspect: None };
    scene
}

fn with(scene: &Scene, settings: &Settings) -> Renderer<'static> {
    let prepared = prepare(scene, settings);
    assert_eq!(prepared.key().has(Part::Adaptive), settings.adaptive);
    Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"))
}

fn renderer(scene: &Scene, adaptive: bool, one_scramble: bool) -> Renderer<'static> {
    with(scene, &Settings { adaptive, one_scramble, ..Settings::new(SIZE[0], SIZE[1]) })
}

fn trace(renderer: &mut Renderer<'_>, window: Window, batches: u32, samples: u32) -> Film {
    trace_from(renderer, window, 0, batches, samples)
}

fn trace_from(renderer: &mut Renderer<'_>, window: Window, first: u32, batches: u32, samples: u32) -> Film {
    let mut film = Film::of_window(window);
    renderer.trace(&mut film, first, batches, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    film
}

/// Measures noise as for a render of 64 samples. Returns the mean share of all pixels.
fn adapt(renderer: &mut Renderer<'_>) -> f64 {
    assert!(renderer.adapt(Some(64), &mut |_| true).unwrap_or_else(|e| panic!("{e}")), "nothing stops it");
    renderer.mean_share(&Window::all(SIZE[0], SIZE[1]))
}

/// Each block of 8×8 pixels is, to the bit, the picture of as many samples as the film says that it
/// has, of its own part of the sequence; some have fewer than requested, some more, and short
/// batches never fewer. Before the measurement all have equally many.
#[test]
fn blocks_are_pictures_of_their_own_samples() {
    const FIRST: u32 = 4;
    let (scene, whole) = (far_box(), Window::all(SIZE[0], SIZE[1]));
    for (path_reuse, one_scramble) in
        [(PathReuse::Off, true), (PathReuse::Off, false), (PathReuse::On, true), (PathReuse::On, false)]
    {
        let settings = Settings { path_reuse, one_scramble, ..Settings::new(SIZE[0], SIZE[1]) };
        let mut plain = with(&scene, &settings);
        let mut adaptive = with(&scene, &Settings { adaptive: true, ..settings });
        let before = trace_from(&mut adaptive, whole, FIRST, 1, 8);
        assert!(bits(&before) == bits(&trace_from(&mut plain, whole, FIRST, 1, 8)), "before the measurement");

        let reported = adapt(&mut adaptive);
        let mut shares = BTreeSet::new();
        for samples in [2, 8] {
            let found = trace_from(&mut adaptive, whole, FIRST, 1, samples);
            let counts: BTreeSet<u64> = all(&found).map(|i| found.samples(i)).collect();
            for &count in &counts {
                // With one scramble all samples of a pixel are numbered, including omitted ones.
                let quarters = 4 * count as u32 / samples;
                let own = match (one_scramble, quarters) {
                    (false, _) => FIRST,
                    (true, 0..4) => (1 << 24) + FIRST * quarters / 4,
                    (true, _) => FIRST * quarters / 4,
                };
                let picture = trace_from(&mut plain, whole, own, 1, count as u32);
                let mut here = all(&found).filter(|&i| found.samples(i) == count);
                assert!(here.all(|i| found.mean(i) == picture.mean(i)), "{count} samples for {samples}");
                shares.insert((samples, quarters));
            }
            let mean = all(&found).map(|i| found.samples(i)).sum::<u64>() as f64 / all(&found).len() as f64;
            assert!(samples < 4 || reported == mean / f64::from(samples), "{reported} was reported");
        }
        println!("samples requested, quarters of them: {shares:?}");
        assert!(shares.contains(&(8, 1)) && shares.iter().any(|&(_, q)| q > 4), "{shares:?}");
        assert!(shares.iter().all(|&(samples, q)| samples > 2 || q >= 4), "{shares:?}");
    }
}

/// A crop, and a render in two parts, have the bits of the whole.
#[test]
fn adaptive_parts_have_the_bits_of_the_whole() {
    let (scene, all) = (far_box(), Window::all(SIZE[0], SIZE[1]));
    let mut first = renderer(&scene, true, false);
    adapt(&mut first);
    let whole = trace(&mut first, all, 3, 4);

    let crop = Window::crop(SIZE, [5, 11, 42, 29]).expect("it is inside");
    let mut second = renderer(&scene, true, false);
    adapt(&mut second);
    let part = trace(&mut second, crop, 3, 4);
    let inside: Vec<_> = (11..29).flat_map(|y| (5..42).map(move |x| (y * SIZE[0] + x) as usize)).collect();
    let of_whole = bits(&whole);
    assert!(bits(&part) == inside.iter().map(|&i| of_whole[i]).collect::<Vec<_>>());

    let mut third = renderer(&scene, true, false);
    adapt(&mut third);
    let mut joined = Film::of_window(all);
    for [begin, count] in [[0, 1], [1, 2]] {
        third.trace(&mut joined, begin, count, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(bits(&joined) == of_whole);
}

/// Over seeds, each with a separate measurement, pictures of few samples have the mean of those
/// without one; their relative squared error falls by more than their number of paths grows.
#[test]
fn measuring_noise_does_not_bias() {
    const SEEDS: u32 = 192;
    let (scene, whole) = (far_box(), Window::all(SIZE[0], SIZE[1]));
    let [mut plain, mut adaptive] = [false, true].map(|adaptive| renderer(&scene, adaptive, true));
    let apart: Vec<Film> = (0..SEEDS)
        .map(|seed| {
            plain.set_seed(seed);
            trace(&mut plain, whole, 1, 8)
        })
        .collect();
    let mut paths = 0.0;
    let looked: Vec<Film> = (SEEDS..2 * SEEDS)
        .map(|seed| {
            adaptive.set_seed(seed);
            paths += adapt(&mut adaptive) / f64::from(SEEDS);
            trace(&mut adaptive, whole, 1, 8)
        })
        .collect();
    let of = |films: &[Film], value: &dyn Fn(&Film) -> f64| {
        let n = films.len() as f64;
        let mean = films.iter().map(value).sum::<f64>() / n;
        let squares = films.iter().map(|film| (value(film) - mean).powi(2)).sum::<f64>();
        Estimate { mean, variance: squares / (n * (n - 1.0)), dof: n - 1.0 }
    };
    let level = sidak_level(ALPHA, 3);
    for channel in 0..3 {
        let value = |film: &Film| all(film).map(|i| film.mean(i)[channel]).sum::<f64>() / all(film).len() as f64;
        let (a, b) = (of(&apart, &value), of(&looked, &value));
        let test = welch_test(&b, &a);
        let detectable = detectable_bias(test.standard_error, level, 0.9) / a.mean;
        println!("channel {channel}: off by {:+.1e}, {detectable:.1e} would be detected", test.difference / a.mean);
        assert!(test.p > level, "channel {channel}: off by {:+.1e}, p {:.1e}", test.difference / a.mean, test.p);
        assert!(detectable < 0.03, "only {detectable:.1e} would be detected");
    }
    let error = |films: &[Film]| {
        let relative = |i: usize| {
            let pixel = of(films, &|film| film.mean(i)[1]);
            pixel.variance * films.len() as f64 / (pixel.mean.powi(2) + 1e-3)
        };
        all(&films[0]).map(relative).sum::<f64>()
    };
    let gain = error(&apart) / error(&looked);
    println!("{gain:.2} times less error for {paths:.2} times the paths");
    assert!(gain > 1.2 * paths, "{gain} times less error for {paths} times the paths");
}
