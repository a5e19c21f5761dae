//! How errors fall with the number of samples: of pictures, and of a smooth integral in two
//! dimensions.

use surelight_prepare::{Sampler, Settings};
use surelight_render::{Formula, Integrand};
use surelight_tests::render::{all, device, prepare, trace};

/// RMS errors of a picture of `spp` samples per pixel for each of `spps`, over pixels and channels:
/// the whole error of unbiased pictures.
///
/// A picture is 16 scrambles, of one sample at least, as in a render: its variance is known from
/// the spread of `batches` scrambles.
fn errors(sampler: Sampler, spps: &[u32], batches: u32) -> Vec<f64> {
    let scene = surelight_scenes::cornell_box::cornell_box();
    let prepared = prepare(&scene, &Settings { sampler, ..Settings::new(24, 24) });
    let error = |&spp: &u32| {
        let film = trace(&prepared, [24, 24], batches, (spp / 16).max(1));
        let scrambles = f64::from(spp.min(16));
        let variance = |i: usize| film.variance_of_mean(i).expect("several batches").iter().sum::<f64>();
        let squares = all(&film).map(|i| variance(i) * f64::from(batches) / scrambles).sum::<f64>();
        (squares / (3.0 * film.pixels().len() as f64)).sqrt()
    };
    spps.iter().map(error).collect()
}

/// The power of N with which errors fall, from the first size to the last.
fn power(sizes: [u32; 2], errors: &[f64]) -> f64 {
    (errors[1] / errors[0]).ln() / f64::from(sizes[1] / sizes[0]).ln()
}

/// Independent samples err by 1/√N; Sobol's by less, although 16 scrambles tell the error bar.
///
/// The pixels that the lamp's edge crosses make up most of these errors. Over five seeds the slopes
/// had standard deviations of 0.010 and 0.006.
#[test]
fn slope() {
    let (few, many) = ([16, 256], [4, 1024]);
    let independent = errors(Sampler::Independent, &few, 256);
    let sobol = errors(Sampler::Sobol, &many, 64);
    let (flat, steep) = (power(few, &independent), power(many, &sobol));
    println!("independent {flat:.3} {independent:.4?}, sobol {steep:.3} {sobol:.4?}");
    assert!((flat + 0.5).abs() < 0.02, "independent samples' error falls with the power {flat}");
    assert!(steep < -0.65, "Sobol's error falls with the power {steep}");
}

/// Errors of a smooth integral in two dimensions, by sampler: RMS over independent replicates.
fn errors_of_formula(sampler: Sampler, sizes: [u32; 2]) -> Vec<f64> {
    const REPLICATES: u32 = 512;
    let formula = Formula::new("exp(-x*x-y*y)*(1.0+x*y)", 2).expect("the formula is valid");
    let mut integrand = Integrand::new(device(), &formula, &[[0.0, 1.0]; 2], 64).unwrap_or_else(|e| panic!("{e}"));
    // ∫e^(−x²) = √π/2·erf 1, ∫x e^(−x²) = (1 − 1/e)/2, each squared.
    let truth = (0.746_824_132_812_427_f64).powi(2) + (0.5 * (1.0 - (-1.0f64).exp())).powi(2);
    let error = |samples| {
        let found = integrand.sample(sampler, REPLICATES, samples, 0, 1).unwrap_or_else(|e| panic!("{e}"));
        let squares = found.replicates.iter().map(|r| (r / truth - 1.0).powi(2)).sum::<f64>();
        (squares / f64::from(REPLICATES)).sqrt()
    };
    sizes.map(error).to_vec()
}

/// Where the integrand is smooth, Owen's scrambling gives N^−3/2 (Owen 1997). From 16 to 1024
/// points: f32 values limit longer runs.
///
/// 512 replicates: each error is known to 3 %, a slope to 0.01.
#[test]
fn slope_of_a_smooth_integral() {
    let sizes = [16, 1024];
    let flat = power(sizes, &errors_of_formula(Sampler::Independent, sizes));
    let steep = power(sizes, &errors_of_formula(Sampler::Sobol, sizes));
    println!("smooth in two dimensions: independent {flat:.3}, sobol {steep:.3}");
    assert!((flat + 0.5).abs() < 0.03, "independent samples' error falls with the power {flat}");
    assert!(steep < -1.2, "Sobol's error falls with the power {steep}");
}
