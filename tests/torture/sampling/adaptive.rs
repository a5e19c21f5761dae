//! Samples that are the mean of several paths, where noise is strong.

use std::collections::BTreeSet;

use surelight_estimate::{Estimate, detectable_bias, sidak_level, welch_test};
use surelight_film::{Film, Window};
use surelight_render::{Renderer, Settings};
use surelight_scene::procedural::cornell_box::cornell_box;
use surelight_scene::{Projection, Scene};
use surelight_tests::render::{ALPHA, all, bits, device, prepare};

const SIZE: [u32; 2] = [45, 30];

/// A Cornell box in the midst of nothing, where there is no noise.
fn far_box() -> Scene {
    let mut scene = cornell_box();
    scene.cameras[0].projection = Projection::Perspective { yfov: 1.3, aspect: None };
    scene
}

fn renderer(scene: &Scene, adaptive: bool, one_scramble: bool) -> Renderer<'static> {
    let settings = Settings { adaptive, one_scramble, ..Settings::new(SIZE[0], SIZE[1]) };
    let prepared = prepare(scene, &settings);
    assert_eq!(prepared.features.adaptive, adaptive);
    Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"))
}

fn trace(renderer: &mut Renderer<'_>, window: Window, batches: u32, samples: u32) -> Film {
    let mut film = Film::of_window(window);
    renderer.trace(&mut film, 0, batches, samples, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    film
}

fn adapt(renderer: &mut Renderer<'_>, window: &Window) -> f64 {
    renderer.adapt(window, &mut |_| true).unwrap_or_else(|e| panic!("{e}")).expect("nobody stops it")
}

/// Each block of 8×8 pixels is, to rounding, the picture of k times as many samples, for one k of 1 to 8; more than one k is
/// found, and their mean is what is told. Before the look all are 1, to the bit.
#[test]
fn adaptive_samples_are_means_of_paths() {
    let whole = Window::all(SIZE[0], SIZE[1]);
    for one_scramble in [true, false] {
        let (scene, samples) = (far_box(), 4);
        let mut plain = renderer(&scene, false, one_scramble);
        let pictures: Vec<Film> = (1..=8).map(|k| trace(&mut plain, whole, 1, k * samples)).collect();
        let mut adaptive = renderer(&scene, true, one_scramble);
        assert!(bits(&trace(&mut adaptive, whole, 1, samples)) == bits(&pictures[0]), "before the look");

        let told = adapt(&mut adaptive, &whole);
        let found = trace(&mut adaptive, whole, 1, samples);
        let (mut multiplicities, mut paths) = (BTreeSet::new(), 0);
        for block in 0..SIZE[0].div_ceil(8) * SIZE[1].div_ceil(8) {
            let corner = [block % SIZE[0].div_ceil(8), block / SIZE[0].div_ceil(8)].map(|n| 8 * n);
            let pixels: Vec<usize> = all(&found)
                .filter(|&i| [i as u32 % SIZE[0], i as u32 / SIZE[0]].map(|n| n / 8 * 8) == corner)
                .collect();
            let same = |film: &Film| {
                let near = |a: f64, b: f64| (a - b).abs() <= 2e-6 * a.abs().max(b.abs());
                pixels.iter().all(|&i| found.mean(i).iter().zip(film.mean(i)).all(|(&a, b)| near(a, b)))
            };
            let k =
                1 + pictures.iter().position(same).unwrap_or_else(|| panic!("the block at {corner:?} is no such mean"));
            multiplicities.insert(k);
            paths += k * pixels.len();
        }
        println!("paths of a sample: {multiplicities:?}, on average {told:.2}");
        assert!(multiplicities.len() > 2 && multiplicities.contains(&1), "{multiplicities:?}");
        assert_eq!(told, paths as f64 / all(&found).len() as f64);
    }
}

/// A crop, and a render in two parts, have the bits of the whole.
#[test]
fn adaptive_parts_have_the_bits_of_the_whole() {
    let (scene, all) = (far_box(), Window::all(SIZE[0], SIZE[1]));
    let mut first = renderer(&scene, true, false);
    adapt(&mut first, &all);
    let whole = trace(&mut first, all, 3, 4);

    let crop = Window::crop(SIZE, [5, 11, 42, 29]).expect("it is inside");
    let mut second = renderer(&scene, true, false);
    adapt(&mut second, &crop);
    let part = trace(&mut second, crop, 3, 4);
    let inside: Vec<_> = (11..29).flat_map(|y| (5..42).map(move |x| (y * SIZE[0] + x) as usize)).collect();
    let of_whole = bits(&whole);
    assert!(bits(&part) == inside.iter().map(|&i| of_whole[i]).collect::<Vec<_>>());

    let mut third = renderer(&scene, true, false);
    adapt(&mut third, &all);
    let mut joined = Film::of_window(all);
    for [begin, count] in [[0, 1], [1, 2]] {
        third.trace(&mut joined, begin, count, 4, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(bits(&joined) == of_whole);
}

/// Over seeds, each with a look of its own, pictures of few samples have the mean of those without a look; their relative squared error is
/// smaller by more than they have more paths.
#[test]
fn looking_for_noise_does_not_bias() {
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
            paths += adapt(&mut adaptive, &whole) / f64::from(SEEDS);
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
        println!("channel {channel}: off by {:+.1e}, {detectable:.1e} would be seen", test.difference / a.mean);
        assert!(test.p > level, "channel {channel}: off by {:+.1e}, p {:.1e}", test.difference / a.mean, test.p);
        assert!(detectable < 0.03, "only {detectable:.1e} would be seen");
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
