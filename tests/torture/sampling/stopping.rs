//! Stopping at a stated error keeps the confidence level, also where light arrives in rare, bright
//! samples; where that is impossible, the render reports it.
//!
//! A spot of floor under a small lamp whose directions are sampled uniformly: a sample is 0, or,
//! with the probability p that a direction hits the lamp, about 1/p of the mean. The truth is
//! Lambert's formula for polygons.

use surelight_estimate::{Moments, sidak_level, z_test};
use surelight_film::{Bound, Film, Precision};
use surelight_prepare::{Directions, Integrator, Settings};
use surelight_render::{Goal, Outcome, Renderer, render};
use surelight_scenes::torture::sampling::spot;
use surelight_tests::render::{ALPHA, all, device, pooled, prepare};

const SIZE: [u32; 2] = [8, 4];

fn settings() -> Settings {
    let integrator = Integrator::Hemisphere(Directions::Uniform);
    Settings { integrator, max_bounces: Some(1), ..Settings::new(SIZE[0], SIZE[1]) }
}

/// Totals of many renders that stop at `error`.
#[derive(Debug, Default)]
struct Tally {
    renders: u32,
    done: u32,
    certified: u32,
    held: u32,
    /// Certified pixels that no light has reached.
    believed_black: u32,
    spp: u64,
    /// Of each render, its mean over pixels relative to the truth.
    means: Moments,
}

fn tally(p: f64, error: f64, max_spp: u32, seeds: std::ops::Range<u32>) -> Tally {
    let (scene, truth) = spot(p);
    let mut renderer = Renderer::new(device(), &prepare(&scene, &settings())).unwrap_or_else(|e| panic!("{e}"));
    let precision = Precision { error, confidence: 0.95, bound: Bound::Clt };
    let goal = Goal { spp: Some(max_spp), precision: Some(precision), ..Goal::default() };
    let mut tally = Tally::default();
    for seed in seeds {
        renderer.set_seed(seed);
        let mut film = Film::new(SIZE[0], SIZE[1]);
        let outcome = render(&mut renderer, &mut film, &goal, &mut |_| true).unwrap_or_else(|e| panic!("{e}"));
        assert!(matches!(outcome, Outcome::Done | Outcome::SamplesUp), "{outcome:?}");
        let certificate = film.certify();
        let reach = precision.reach(&film, &certificate);
        assert_eq!(
            outcome == Outcome::Done,
            precision.is_reached(&reach) && film.samples(0) > 0,
            "{outcome:?} {reach:?}"
        );
        tally.renders += 1;
        tally.done += u32::from(outcome == Outcome::Done);
        tally.spp += film.samples(0);
        tally.means.push(pooled(&film, 1, all(&film)).mean / truth);
        for i in (0..film.pixels().len()).filter(|&i| certificate.certified[i]) {
            let standard_error = film.variance_of_mean(i).expect("many batches")[1].sqrt();
            let half_width = Bound::Clt.factor(0.95, film.degrees_of_freedom(i)) * standard_error;
            tally.certified += 1;
            tally.held += u32::from((film.mean(i)[1] - truth).abs() <= half_width);
            tally.believed_black += u32::from(film.mean(i)[1] == 0.0);
        }
    }
    println!(
        "p = 1/{:.0}: {tally:?}, intervals hold for {:.4}",
        1.0 / p,
        f64::from(tally.held) / f64::from(tally.certified)
    );
    tally
}

/// The stopping time biases the mean little: by less than a hundredth of the requested half-width;
/// z over renders.
///
/// There is a small bias: with 1,000 renders, 0.20 % ± 0.05 % where 40 % is requested and one
/// direction in 256 hits the lamp. Pixels that have hit the lamp often are certified sooner than
/// those that have hit it seldom.
///
/// Five hundred renders of 32 pixels each: the share of intervals that hold has a standard error of
/// 0.2 %.
#[test]
fn optional_stop() {
    let mut held = 0;
    let mut certified = 0;
    for (p, error, renders) in [(1.0 / 64.0, 0.25, 250), (1.0 / 128.0, 0.3, 150), (1.0 / 256.0, 0.4, 100)] {
        let renders = if cfg!(feature = "long") { 1000 } else { renders };
        let found = tally(p, error, 1 << 16, 0..renders);
        let nearest = found.means.mean().clamp(1.0 - 0.01 * error, 1.0 + 0.01 * error);
        let test = z_test(found.means.mean(), found.means.variance_of_mean().sqrt(), nearest, sidak_level(ALPHA, 3));
        if cfg!(feature = "long") && p < 0.005 {
            // The known issue: a thousand renders show it.
            let unbiased = z_test(found.means.mean(), found.means.variance_of_mean().sqrt(), 1.0, ALPHA);
            assert!(unbiased.p < ALPHA, "stopping no longer biases: the known issue is one no more, {unbiased:?}");
        }
        let (z, seen) = (test.z, 100.0 * test.detectable);
        println!(
            "mean of all renders {:.4} of the truth, z {z:+.2}; {seen:.2} % would be detected",
            found.means.mean()
        );
        assert!(test.p > sidak_level(ALPHA, 3) && test.detectable < 0.02, "{test:?}");
        assert_eq!(found.done, renders, "the error can be reached");
        assert_eq!(found.believed_black, 0);
        // About the number that the variance of a Bernoulli sample requires, less the savings of
        // Sobol points: not stopped early by luck.
        let needed = (1.96 / error).powi(2) * (1.0 - p) / p;
        let mean = found.spp as f64 / f64::from(renders);
        assert!(mean > 0.5 * needed && mean < 4.0 * needed, "{mean:.0} samples where {needed:.0} are needed");
        held += found.held;
        certified += found.certified;
    }
    let share = f64::from(held) / f64::from(certified);
    println!("intervals hold for {share:.4} of {certified}");
    assert!((0.94..=0.98).contains(&share), "intervals at 95 % hold for {share:.4}");
}

/// Too few samples for so rare a light: reported, not certified.
#[test]
fn unreachable_targets_are_reported() {
    let found = tally(1.0 / 1024.0, 0.05, 512, 0..40);
    assert_eq!(found.done, 0, "{found:?}");
    assert_eq!(found.spp, 512 * 40);
    // Most pixels have hit the lamp never or once; a neighbour's sample prevents a certificate for
    // those that never did.
    assert_eq!(found.believed_black, 0, "{found:?}");
    assert!(f64::from(found.certified) < 0.15 * f64::from(40 * SIZE[0] * SIZE[1]), "{found:?}");
}
