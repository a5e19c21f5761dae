//! Do error bars hold? Of many independent renders, the 95 % interval of 95 ± 2 % of the certified
//! pixels contains the truth; and where it would not, pixels are not certified.
//!
//! Pictures are small, but not so small that neighbours show other things: at 10 × 10 pixels, whose
//! neighbours cannot vouch for each other, the glass room's certified pixels hold in 91 % only.
//!
//! Power: every count is of 200 renders of 256 pixels. Their standard error is below 0.3 % for
//! pixels that are certified in all of them, so that an interval that covered 93.7 % or 96.3 % in
//! truth would be distinguished from 95 %, nine times in ten at α = 0.01, and one outside 95 ± 2 %
//! fails.

use glam::DVec3;
use surelight_estimate::student_t_quantile;
use surelight_film::Film;
use surelight_prepare::{Integrator, PathReuse, Settings};
use surelight_render::Renderer;
use surelight_scene::Scene;
use surelight_scenes::{cornell_box, glass, quad_light, veach_mis};
use surelight_tests::render::{device, prepare};
use surelight_tests::scenes::{look_at, pinhole};
use surelight_tests::seeds::film_of;

use super::adaptive::far_box;

const SIZE: [u32; 2] = [16, 16];
const RENDERS: u32 = if cfg!(feature = "long") { 1000 } else { 200 };
/// An interval needs 16 scrambles.
const BATCHES: u32 = 16;

/// How often intervals hold.
struct Coverage {
    /// Of certified pixels, the share whose interval contains the truth.
    certified: f64,
    /// Of all pixels.
    all: f64,
    /// Share of pixels that are certified.
    share: f64,
    /// Of pixels with a light tail so far, the share whose interval contains the truth.
    provisional: f64,
    /// Share of pixels with a light tail so far.
    provisional_share: f64,
    /// Minimum and maximum per pixel of a render.
    samples: [u64; 2],
}

/// Settings of the pictures.
fn usual(integrator: Integrator) -> Settings {
    Settings { integrator, ..Settings::new(SIZE[0], SIZE[1]) }
}

/// Counts over all renders; `truth` in green, or `None` for the mean of all the renders.
fn coverage(name: &str, scene: &Scene, settings: &Settings, samples: u32, truth: Option<f64>) -> Coverage {
    let mut renderer = Renderer::new(device(), &prepare(scene, settings)).unwrap_or_else(|e| panic!("{e}"));
    let size = [settings.width, settings.height];
    let film = |seed| {
        renderer.set_seed(seed);
        assert!(renderer.adapt(Some(BATCHES * samples), &mut |_| true).unwrap_or_else(|e| panic!("{e}")));
        film_of(&mut renderer, size, 0, BATCHES, samples)
    };
    let films: Vec<Film> = (0..RENDERS).map(film).collect();
    let mut whole = Film::new(size[0], size[1]);
    films.iter().for_each(|film| whole.merge(film).expect("the same size"));
    let t = student_t_quantile(0.975, f64::from(BATCHES - 1));
    // A render is part of the mean that it is compared with: their difference varies by 1 − 1/R of
    // its own variance.
    let shrunk = if truth.is_some() { 1.0 } else { 1.0 - 1.0 / f64::from(RENDERS) };
    let (mut judged, mut held, mut certified, mut certified_held) = (0, 0, 0, 0);
    let (mut provisional, mut provisional_held) = (0, 0);
    for film in &films {
        let certificate = film.certify();
        for i in 0..film.pixels().len() {
            let truth = truth.unwrap_or(whole.mean(i)[1]);
            let variance = film.variance_of_mean(i).expect("16 batches")[1];
            // Sums are f32.
            let half_width = t * (variance * shrunk).sqrt() + 1e-6 * truth;
            // Pixels without any spread have no interval to judge: they would only inflate the
            // count.
            if variance == 0.0 {
                continue;
            }
            judged += 1;
            let holds = (film.mean(i)[1] - truth).abs() <= half_width;
            held += u32::from(holds);
            certified += u32::from(certificate.certified[i]);
            certified_held += u32::from(holds && certificate.certified[i]);
            provisional += u32::from(certificate.provisional[i]);
            provisional_held += u32::from(holds && certificate.provisional[i]);
        }
    }
    let all = f64::from(judged);
    let counts = || films.iter().flat_map(|film| (0..film.pixels().len()).map(|i| film.samples(i)));
    let found = Coverage {
        certified: f64::from(certified_held) / f64::from(certified).max(1.0),
        all: f64::from(held) / all,
        share: f64::from(certified) / all,
        provisional: f64::from(provisional_held) / f64::from(provisional).max(1.0),
        provisional_share: f64::from(provisional) / all,
        samples: [counts().min().unwrap_or(0), counts().max().unwrap_or(0)],
    };
    println!(
        "{name}, {:?} spp: 95 % intervals hold for {:.2} % of certified pixels ({:.1} % of all), {:.2} % of those with a light tail ({:.1} %) and {:.2} % of all",
        found.samples,
        100.0 * found.certified,
        100.0 * found.share,
        100.0 * found.provisional,
        100.0 * found.provisional_share,
        100.0 * found.all
    );
    found
}

fn assert_holds(name: &str, found: &Coverage) {
    assert!((found.certified - 0.95).abs() <= 0.02, "{name}: intervals hold for {:.4}", found.certified);
}

/// A spot of a floor under a square lamp, so small that all pixels see the same.
#[test]
fn intervals_hold_against_a_closed_form() {
    let mut scene = quad_light::quad_light();
    let (x, z) = (0.3, -0.2);
    let spot = DVec3::new(x, 0.0, z);
    scene.cameras[0] = pinhole(look_at(spot + DVec3::new(0.4, 0.3, 0.5), spot, DVec3::Y), 1e-3);
    let found =
        coverage("a spot under a lamp", &scene, &usual(Integrator::Area), 16, Some(quad_light::radiance(x, z)[1]));
    assert_holds("a spot under a lamp", &found);
    assert!(found.share > 0.9, "only {:.3} of the pixels are certified", found.share);
}

#[test]
fn replicates() {
    assert_holds("cornell", &coverage("cornell", &cornell_box::cornell_box(), &usual(Integrator::Mis), 16, None));
}

/// Below 256 samples, which give no certificate, a render takes all its points from one sequence.
/// Batches then compensate each other, and their error estimate is an upper bound. It is slightly
/// too large for most pixels, and at few samples skewness makes up for that: intervals must hold at
/// least as often as those of certified pixels must.
#[test]
fn intervals_of_one_scramble_hold() {
    let settings = Settings { one_scramble: true, ..usual(Integrator::Mis) };
    let found = coverage("cornell, one scramble", &cornell_box::cornell_box(), &settings, 4, None);
    assert!(
        found.all > 0.93 && found.share == 0.0,
        "intervals hold for {:.4}, certified {:.4}",
        found.all,
        found.share
    );
}

/// At 64 samples, the default, tails already distinguish most pixels whose interval holds from
/// those without their rare, bright samples.
#[test]
fn provisional_verdicts_hold() {
    let cases = [
        ("cornell", cornell_box::cornell_box(), Integrator::Mis, PathReuse::On),
        ("veach-mis", veach_mis::veach_mis(), Integrator::Mis, PathReuse::Off),
        ("glass", glass::glass(), Integrator::Mis, PathReuse::Off),
        ("glass by caustics", glass::glass(), Integrator::Caustics, PathReuse::Off),
    ];
    for (name, scene, integrator, path_reuse) in cases {
        let settings = Settings { one_scramble: true, path_reuse, ..usual(integrator) };
        let found = coverage(name, &scene, &settings, 4, None);
        let (holds, share) = (found.provisional, found.provisional_share);
        assert!(holds > 0.94, "{name}: intervals hold for {holds:.4}");
        assert!(share > 0.3, "{name}: {share:.4} of the pixels have a light tail");
        if name == "glass" {
            assert!(found.all < 0.90, "{name}: the verdict excludes nothing: {:.4}", found.all);
        }
    }
}

/// Pixels that share paths err together, but each one's batches are still independent of one
/// another.
#[test]
fn intervals_of_path_reuse_hold() {
    let settings = Settings { path_reuse: PathReuse::On, ..usual(Integrator::Mis) };
    let found = coverage("cornell, shared paths", &cornell_box::cornell_box(), &settings, 16, None);
    assert_holds("cornell, shared paths", &found);
    assert!(found.share > 0.4, "only {:.3} of the pixels are certified", found.share);
}

/// Of each pixel, batches are independent estimates of as many samples, however many the
/// measurement of noise has assigned. Some have a quarter of others' here, or an eighth.
#[test]
fn intervals_of_adaptive_samples_hold() {
    let scene = far_box();
    let settings = |one_scramble| Settings { adaptive: true, one_scramble, ..Settings::new(32, 24) };
    let found = coverage("cornell, adaptive", &scene, &settings(false), 32, None);
    assert!(found.samples[0] == 256 && found.samples[1] > 512, "{:?} samples", found.samples);
    assert_holds("cornell, adaptive", &found);
    assert!(found.share > 0.4, "only {:.3} of the pixels are certified", found.share);
    let found = coverage("cornell, adaptive, one scramble", &scene, &settings(true), 4, None);
    assert!(found.samples[0] == 16 && found.samples[1] > 64, "{:?} samples", found.samples);
    assert!(found.all > 0.93, "intervals hold for {:.4}", found.all);
}

/// Caustics and light through glass are found by chance: few pixels are certified, and their
/// intervals hold.
#[test]
fn intervals_hold_behind_glass_where_they_are_certified() {
    let found = coverage("glass", &glass::glass(), &usual(Integrator::Mis), 16, None);
    assert_holds("glass", &found);
    assert!(found.all < 0.93, "without the certificate, intervals would hold as well: {:.4}", found.all);
    assert!(found.share < 0.5, "{:.3} of the pixels are certified", found.share);
}

/// Nearly all pixels are certified in the end, where no light is found by chance alone.
#[test]
fn a_cornell_box_is_certified_in_the_end() {
    let size = [24, 24];
    let prepared = prepare(&cornell_box::cornell_box(), &Settings::new(size[0], size[1]));
    let mut renderer = Renderer::new(device(), &prepared).unwrap_or_else(|e| panic!("{e}"));
    let share = film_of(&mut renderer, size, 0, BATCHES, 256).certify().share();
    println!("cornell, 4096 spp: {:.2} % of the pixels are certified", 100.0 * share);
    assert!(share > 0.99, "{share}");
}
