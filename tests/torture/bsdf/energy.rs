//! The BSDF's albedo under uniform light, against quadrature in f64; conservation of energy; the
//! limit of smooth surfaces.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use surelight_estimate::{Moments, sidak_level, z_test};
use surelight_prepare::Settings;
use surelight_scenes::torture;
use surelight_tests::bsdf::{BsdfProbe, Material, uniforms};
use surelight_tests::bsdf_oracle::{albedo, fresnel_exact};
use surelight_tests::render::render;

const ALPHA: f64 = 0.01;

static PROBE: LazyLock<BsdfProbe> = LazyLock::new(BsdfProbe::full);

/// Mean weight of samples and its standard error: the Monte Carlo estimate of the albedo (green).
fn sampled_albedo(m: &Material, samples: usize, seed: u64) -> (f64, f64) {
    let mut moments = Moments::default();
    for s in PROBE.sample(m, &uniforms(samples, seed)) {
        moments.push(if s.is_valid() { f64::from(s.weight[1]) } else { 0.0 });
    }
    (moments.mean(), moments.variance_of_mean().sqrt())
}

/// Compares sampled albedos with quadrature; prints the smallest bias that would have been detected
/// 9 times in 10.
fn check(name: &str, materials: &[Material]) {
    let level = sidak_level(ALPHA, materials.len());
    let (mut pooled_bias, mut pooled_variance, mut worst_detectable) = (0.0, 0.0, 0.0_f64);
    for (m, seed) in materials.iter().zip(1000..) {
        let exact = albedo(m, 512).sum().y;
        let half = albedo(m, 256).sum().y;
        let (mean, error) = sampled_albedo(m, 250_000, seed);
        // The error of quadrature is included, at most its change from half the points; so are
        // events rarer than the samples show.
        let error = error.hypot(exact - half).max(1e-5);
        let test = z_test(mean, error, exact, level);
        println!("{name} α {} z {:.4}: {mean:.5} ± {error:.5}, exactly {exact:.5}", m.alpha, m.wo[2]);
        assert!((exact - half).abs() < 5e-4 * exact, "{m:?}: quadrature has not converged: {half}, {exact}");
        assert!(test.p > level, "{m:?}: albedo {mean} ± {error} instead of {exact}");
        pooled_bias += mean / exact - 1.0;
        pooled_variance += (error / exact).powi(2);
        worst_detectable = worst_detectable.max(test.detectable / exact);
    }
    let n = materials.len() as f64;
    let pooled = z_test(pooled_bias / n, pooled_variance.sqrt() / n, 0.0, ALPHA);
    println!(
        "{name}: a relative bias of {:.2e} in all, {worst_detectable:.1e} in any one, would have been detected",
        pooled.detectable
    );
    assert!(pooled.p > ALPHA, "{name}: the pooled albedo is off by {:.1e} of itself", pooled_bias / n);
}

fn over(kind: fn(f32, f64) -> Material, alphas: &[f32], angles: &[f64]) -> Vec<Material> {
    alphas.iter().flat_map(|&alpha| angles.iter().map(move |&degrees| kind(alpha, degrees))).collect()
}

#[test]
fn furnace_ggx() {
    let materials = over(Material::metal, &[0.001, 0.01, 0.1, 0.3, 0.6, 1.0], &[0.0, 45.0, 75.0, 88.0]);
    check("metal", &materials);
    // α = 1 viewed from above has a closed form: D = 1/π, G2 = 2c/(1 + c), and ∫ c/(1 + c) dc = 1 −
    // ln 2.
    let closed = albedo(&Material::metal(1.0, 0.0), 512).sum().y;
    assert!((closed - (1.0 - std::f64::consts::LN_2)).abs() < 1e-5, "the quadrature itself is off: {closed}");
    for m in &materials {
        assert!(albedo(m, 256).sum().max_element() < 1.0 + 1e-4, "{m:?} reflects more than there is");
    }
}

#[test]
fn other_albedos_are_the_quadrature() {
    let angles = [0.0, 60.0, 85.0];
    check("dielectric", &over(Material::dielectric, &[0.05, 0.3, 1.0], &angles));
    check("glass", &over(Material::glass, &[0.05, 0.3, 1.0], &angles));
    check("glass from within", &over(Material::glass_within, &[0.05, 0.3, 1.0], &angles));
    check("thin wall", &over(Material::thin, &[0.05, 0.3, 1.0], &angles));
    check("medley", &over(Material::medley, &[0.05, 0.3, 1.0], &angles));
}

/// Rough glass of index 1 bends nothing: all of its facets agree on the way straight through, which
/// must not be lost for being infinitely narrow.
#[test]
fn index_one_lets_light_through() {
    for alpha in [0.01, 0.3] {
        for degrees in [0.0, 60.0] {
            let m = Material { eta: 1.0, ior: 1.0, f0: [0.0; 3], ..Material::glass(alpha, degrees) };
            let exact = albedo(&m, 256).sum().y;
            let (mean, error) = sampled_albedo(&m, 20_000, 50);
            assert!((mean - exact).abs() < 4.0 * error + 5e-3, "{m:?}: {mean} of {exact} goes through");
            assert!(exact > 0.9);
        }
    }
}

/// A property of glTF's model, kept because files are made for it: the base is weighted by 1 − F at
/// the half-vector, not by the transmittance of the specular layer, so a white glossy dielectric
/// reflects more than it receives at grazing angles, and a closed white room of it would brighten
/// without end. This test states by how much; Lambertian, metal and glass surfaces never gain
/// (tests here).
#[test]
fn gltf_dielectric_gains_at_grazing_angles_only() {
    for (alpha, bound) in [(0.01, 1.05), (0.1, 1.03), (0.3, 1.01), (1.0, 1.0)] {
        let n = 64;
        let mut mean = 0.0;
        for i in 0..n {
            // cosθ² uniform: the cosine-weighted hemisphere.
            let cosine = ((f64::from(i) + 0.5) / f64::from(n)).sqrt();
            let white = albedo(&Material::dielectric(alpha, cosine.acos().to_degrees()), 64).sum().x;
            assert!(cosine < 0.6 || white < 1.02, "α {alpha}: {white} at cosine {cosine}");
            mean += white / f64::from(n);
        }
        println!("a white glTF dielectric of α {alpha} returns {mean:.4} of light from everywhere");
        assert!(mean < bound, "α {alpha}: {mean}");
    }
}

/// Rough glass loses only light that other facets mask: nothing leaves it twice.
#[test]
fn rough_glass_never_gains() {
    for kind in [Material::glass, Material::glass_within, Material::thin] {
        for m in over(kind, &[0.01, 0.1, 0.5, 1.0], &[0.0, 50.0, 80.0, 89.0]) {
            let eta2 = if m.thin == 0.0 { f64::from(m.eta).powi(2) } else { 1.0 };
            let part = albedo(&m, 256);
            // The flux, without the scaling of radiance by the squared index.
            let flux = part.reflected + part.transmitted * eta2;
            assert!(flux.max_element() < 1.0 + 1e-4, "{m:?} scatters {flux} of 1");
            for s in PROBE.sample(&m, &uniforms(20_000, 1)).iter().filter(|s| s.is_valid()) {
                let scale = if s.wi[2] < 0.0 { eta2 as f32 } else { 1.0 };
                let weight = s.weight[1] * scale;
                // Masking in both directions is at most masking in one.
                assert!(weight < 1.0 + 1e-4, "{m:?}: weight {weight}, {s:?}");
            }
        }
    }
}

/// R + T = 1: with lobes chosen by Fresnel's own shares, each sample of clear smooth glass carries
/// exactly all of the light.
#[test]
fn smooth_glass_keeps_everything() {
    for kind in [Material::glass, Material::glass_within, Material::thin] {
        for degrees in [0.0, 20.0, 41.0, 43.0, 60.0, 85.0, 89.9] {
            let m = kind(0.0, degrees);
            let reflectance = fresnel_exact(f64::from(m.wo[2]), f64::from(if m.thin == 0.0 { m.eta } else { m.ior }));
            let samples = PROBE.sample(&m, &uniforms(100_000, 7));
            let mut reflected = 0;
            for s in &samples {
                assert!(s.is_valid() && s.is_delta() && s.pdf == 0.0, "{m:?}: {s:?}");
                let through = s.wi[2] < 0.0;
                let weight = if through && m.thin == 0.0 { s.weight[1] * m.eta * m.eta } else { s.weight[1] };
                assert!((weight - 1.0).abs() < 4.0 * f32::EPSILON, "{m:?}: {s:?}");
                reflected += usize::from(!through);
                let wo = Vec3::from(m.wo);
                let sines = Vec3::from(s.wi).truncate() * if through { m.eta } else { 1.0 };
                assert!((sines + wo.truncate()).length() < 1e-6, "Snell's law fails: {m:?}: {s:?}");
            }
            let n = samples.len() as f64;
            let error = (reflectance * (1.0 - reflectance) / n).sqrt().max(1e-9);
            let test = z_test(reflected as f64 / n, error, reflectance, sidak_level(ALPHA, 21));
            assert!(test.p > sidak_level(ALPHA, 21), "{m:?}: {reflected} of {n}, expected {reflectance}");
        }
    }
}

/// As α falls to where the deltas take over, albedo and direction go over into theirs.
#[test]
fn ggx_mirror() {
    let kinds = [Material::dielectric, Material::metal, Material::glass, Material::glass_within, Material::thin];
    for kind in kinds {
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            let (rough, smooth) = (kind(2e-4, degrees), kind(0.0, degrees));
            let (a, ea) = sampled_albedo(&rough, 100_000, 31);
            let (b, eb) = sampled_albedo(&smooth, 100_000, 32);
            let error = ea.hypot(eb).max(1e-6);
            // 1e-3 for the width of the lobe, at the steepest of Fresnel's curve.
            assert!((a - b).abs() < 4.0 * error + 1e-3, "{rough:?}: {a} against {b} when smooth, ± {error}");

            let u = uniforms(20_000, 33);
            let pairs = PROBE.sample(&rough, &u).into_iter().zip(PROBE.sample(&smooth, &u));
            let mut deviations: Vec<f32> = pairs
                .filter(|(r, s)| s.is_delta() && r.is_valid() && (r.wi[2] > 0.0) == (s.wi[2] > 0.0))
                .map(|(r, s)| (Vec3::from(r.wi) - Vec3::from(s.wi)).length())
                .collect();
            deviations.sort_by(f32::total_cmp);
            let median = deviations[deviations.len() / 2];
            assert!(median < 20.0 * rough.alpha, "{rough:?}: half the directions are {median} off");
        }
    }
}

/// Kernels without microfacets: every weight is the base colour, and there is nothing else to
/// compute.
#[test]
fn lambert_has_no_variance() {
    let m = Material { base_color: [0.7, 0.3, 0.1], ..Material::lambert(50.0) };
    for probe in [&*PROBE, &BsdfProbe::new(&m.key())] {
        for s in probe.sample(&m, &uniforms(100_000, 40)) {
            assert!(s.is_valid());
            for c in 0..3 {
                assert!((s.weight[c] - m.base_color[c]).abs() <= 4.0 * f32::EPSILON * m.base_color[c], "{s:?}");
            }
        }
        let e = probe.eval(&m, &[[0.0, 0.6, 0.8]])[0];
        assert_eq!(e.albedo, m.base_color);
        let expected = DVec3::from(m.base_color.map(f64::from)) * 0.8 / std::f64::consts::PI;
        assert!((DVec3::from(e.value.map(f64::from)) - expected).length() < 1e-7);
    }
}

/// The scene of case 28 itself: one pixel per plate, smooth at one end and of α = 1 at the other;
/// the albedo decreases in between.
#[test]
fn furnace_ggx_as_a_picture() {
    let film = render(&torture::scene("furnace-ggx"), &Settings::new(6, 1), 16, 1024);
    let level = sidak_level(ALPHA, 2);
    for (plate, truth) in [(0, 1.0), (5, 1.0 - 2f64.ln())] {
        // α = 0.001 loses a hundred-thousandth to facets that send light down.
        let error = film.variance_of_mean(plate).expect("16 batches")[1].sqrt().hypot(2e-5);
        let test = z_test(film.mean(plate)[1], error, truth, level);
        println!("plate {plate}: {:.5} ± {error:.1e}, exactly {truth:.5}", film.mean(plate)[1]);
        assert!(test.p > level && test.detectable < 0.01, "plate {plate}: {test:?}");
    }
    assert!((1..6).all(|i| film.mean(i)[1] < film.mean(i - 1)[1] + 1e-5), "rougher metal returns less");
}

/// The scene of case 29 itself: a metal of α = 0.0002 and a smooth one beside each other.
#[test]
fn ggx_mirror_as_a_picture() {
    let film = render(&torture::scene("ggx-mirror"), &Settings::new(2, 1), 16, 64);
    let schlick = |f0: f64| f0 + (1.0 - f0) * (1.0 - 0.5f64.sqrt()).powi(5);
    for (pixel, name) in [(0, "rough"), (1, "smooth")] {
        for (found, f0) in film.mean(pixel).into_iter().zip([0.9, 0.5, 0.1]) {
            // Linear in the lobe's width at most.
            assert!((found / schlick(f0) - 1.0).abs() < 1e-3, "{name}: {found} instead of {}", schlick(f0));
        }
    }
}
