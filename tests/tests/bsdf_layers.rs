//! Clear coats, sheen, anisotropy, thin films and diffuse transmission, as the BSDF module computes
//! them on the device: values by the extensions' formulas in f64, samples by their pdf, light
//! conserved, and nothing changed where a layer is not.

use std::sync::LazyLock;

use glam::{DVec3, Vec3};
use surelight_estimate::{Moments, sidak_level, z_test};
use surelight_tests::bsdf::{BsdfProbe, Material, sphere_directions, uniforms};
use surelight_tests::chi2;
use surelight_tests::layer_oracle::Layered;

const ALPHA: f64 = 0.01;

static PROBE: LazyLock<BsdfProbe> = LazyLock::new(BsdfProbe::layered);

/// The albedo of a black base under microfacets that reflect nothing.
fn black(degrees: f64) -> Material {
    Material { base_color: [0.0; 3], ..Material::lambert(degrees) }
}

/// Each layer by itself, and all together, over several bases.
fn materials(degrees: f64) -> Vec<(&'static str, Material)> {
    let brown = |m: Material| Material { base_color: [0.8, 0.5, 0.2], ..m };
    vec![
        ("coated dielectric", brown(Material::dielectric(0.3, degrees)).coated(0.1)),
        ("coated metal", brown(Material::metal(0.6, degrees)).coated(0.5)),
        ("sheen over Lambert", brown(Material::lambert(degrees)).with_sheen(0.3)),
        ("sharp sheen over black", black(degrees).with_sheen(0.02)),
        ("sheen over a dielectric", brown(Material::dielectric(0.4, degrees)).with_sheen(1.0)),
        ("brushed metal", brown(Material::metal(0.1, degrees)).brushed(0.6)),
        ("brushed glass", Material::glass(0.2, degrees).brushed(0.5)),
        ("film on a dielectric", brown(Material::dielectric(0.3, degrees)).filmed(300.0)),
        ("film on metal", brown(Material::metal(0.3, degrees)).filmed(550.0)),
        ("film on glass", Material::glass(0.3, degrees).filmed(400.0)),
        ("film on glass, from within", Material::glass_within(0.3, degrees).filmed(400.0)),
        ("dispersive glass", Material::glass(0.3, degrees).dispersive(0.1)),
        ("dispersive glass, from within", Material::glass_within(0.3, degrees).dispersive(0.1)),
        ("leaf", brown(Material::dielectric(0.3, degrees)).translucent(0.4)),
        ("partly glass", Material::medley(0.3, degrees).translucent(0.5)),
        (
            "everything",
            Material::medley(0.3, degrees).translucent(0.5).with_sheen(0.3).coated(0.2).filmed(250.0).brushed(0.5),
        ),
        ("everything thin", Material::thin(0.3, degrees).translucent(0.5).with_sheen(0.3).coated(0.3).filmed(250.0)),
    ]
}

#[test]
fn values_are_the_extensions_formulas() {
    let mut worst = (0.0, String::new());
    for degrees in [0.0, 40.0, 75.0] {
        for (name, m) in materials(degrees) {
            let mut wis = sphere_directions(1500, 1);
            wis.extend(PROBE.sample(&m, &uniforms(1500, 2)).iter().filter(|s| s.is_valid()).map(|s| s.wi));
            let oracle = Layered::new(&m);
            for (wi, e) in wis.iter().zip(PROBE.eval(&m, &wis)) {
                let (wo, i) = (Vec3::from(m.wo), Vec3::from(*wi));
                // Near grazing and the critical angle Fresnel's equations keep few digits in f32.
                let h = if i.z < 0.0 { wo + m.eta * i } else { wo + i }.normalize();
                let (oh, ih) = (wo.dot(h), i.dot(h));
                let margin = if m.ior_spread > 0.0 { 0.15 } else { 0.05 };
                let critical = (m.eta * m.eta - 1.0 + oh * oh).abs() < margin;
                let delicate = m.transmission > 0.0 && (critical || i.z < 0.0 && oh.abs().min(ih.abs()) < 0.2);
                if wi[2].abs() < 1e-2 || delicate {
                    continue;
                }
                let exact = oracle.value(DVec3::from(wi.map(f64::from)));
                for c in 0..3 {
                    let error = (f64::from(e.value[c]) - exact[c]).abs() / exact.max_element().max(1e-2);
                    if error > worst.0 {
                        worst = (error, format!("{name}: {m:?}\ntowards {wi:?}: {:?}, not {exact}", e.value));
                    }
                }
            }
        }
    }
    println!("largest relative error {:.1e}", worst.0);
    // Sheen's albedos come from a table.
    assert!(worst.0 < 1e-2, "relative error {:.1e}: {}", worst.0, worst.1);
}

#[test]
fn samples_follow_the_pdf() {
    let mut all = Vec::new();
    for degrees in [30.0, 75.0] {
        // Each at one angle, its neighbours at the other.
        let skipped = usize::from(degrees > 50.0);
        all.extend(materials(degrees).into_iter().skip(skipped).step_by(2));
        // Deltas beside broad lobes.
        all.push(("smooth coat", Material::dielectric(0.3, degrees).coated(0.0)));
        all.push((
            "smooth base, coated and with sheen",
            Material::dielectric(0.0, degrees).with_sheen(0.3).coated(0.1),
        ));
    }
    let level = sidak_level(ALPHA, all.len());
    let mut failures = Vec::new();
    for ((name, m), seed) in all.iter().zip(5000..) {
        let o = chi2::outcome(&PROBE, m, m, 200_000, seed);
        println!("{name}, z {:.3}: p {:.4}, mass {:.6}, {} degrees of freedom", m.wo[2], o.p, o.mass, o.dof);
        assert!(o.mass < 1.0 + 2e-4, "{name}: the pdf integrates to {}", o.mass);
        if o.p < level {
            failures.push(format!("{name}: {m:?}: p = {:.1e}", o.p));
        }
    }
    assert!(failures.is_empty(), "at level {level:.1e}:\n{}", failures.join("\n"));
    // A coat's α that is 3 % off would be detected.
    let m = black(60.0).coated(0.2);
    let wrong = Material { coat_alpha: 0.206, ..m };
    let p = chi2::outcome(&PROBE, &m, &wrong, 200_000, 6000).p;
    assert!(p < level, "3 % of the coat's α pass unseen: p = {p}");
}

#[test]
fn weights_are_value_over_pdf_and_finite() {
    for degrees in [0.0, 50.0, 85.0, 89.99] {
        for (name, m) in materials(degrees) {
            let samples: Vec<_> = PROBE.sample(&m, &uniforms(3000, 4)).into_iter().filter(|s| s.is_valid()).collect();
            let wis: Vec<_> = samples.iter().map(|s| s.wi).collect();
            assert!(wis.len() > 200, "{name}: only {} samples are valid", wis.len());
            for (s, e) in samples.iter().zip(PROBE.eval(&m, &wis)) {
                assert!((s.pdf - e.pdf).abs() <= 1e-5 * e.pdf, "{name}: {s:?} {e:?}");
                for c in 0..3 {
                    let value = s.weight[c] * s.pdf;
                    assert!((e.value[c] - value).abs() <= 1e-5 * value.max(1e-12), "{name}: {s:?} {e:?}");
                    assert!(s.weight[c] >= 0.0 && s.weight[c] < 1e3, "{name}: {s:?}");
                }
            }
        }
    }
    // Corners of the random numbers, α and angles.
    let ends = [0.0, 1.0 / 16_777_216.0, 0.5, 1.0 - 1.0 / 16_777_216.0];
    let cube: Vec<[f32; 3]> = (0..64).map(|i| [ends[i / 16], ends[i / 4 % 4], ends[i % 4]]).collect();
    for z in [1.0, 1e-3, 1e-7, 1e-30] {
        let wo = [-(1.0_f32 - z * z).sqrt(), 0.0, z];
        for (name, kind) in materials(0.0) {
            for (alpha, along) in [(0.0, 0.0), (0.0, 1.0), (1e-4, 1e-4), (1.0, 1.0)] {
                for lobe in [0.0, 1e-4, 1.0] {
                    let m = Material { alpha, alpha_along: along, coat_alpha: lobe, sheen_alpha: lobe, wo, ..kind };
                    for s in PROBE.sample(&m, &cube) {
                        let numbers = [s.weight[0], s.weight[1], s.weight[2], s.pdf];
                        assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{name}: {m:?}: {s:?}");
                        assert!(Vec3::from(s.wi).is_finite(), "{name}: {m:?}: {s:?}");
                    }
                }
            }
        }
    }
}

/// Mean weight of samples in the upper and the lower hemisphere, with standard errors (green).
fn sampled(m: &Material, seed: u64) -> [(f64, f64); 2] {
    let mut moments = [Moments::default(), Moments::default()];
    for s in PROBE.sample(m, &uniforms(100_000, seed)) {
        let weight = if s.is_valid() { f64::from(s.weight[1]) } else { 0.0 };
        let above = s.wi[2] > 0.0;
        moments[0].push(if above { weight } else { 0.0 });
        moments[1].push(if above { 0.0 } else { weight });
    }
    moments.map(|m| (m.mean(), m.variance_of_mean().sqrt()))
}

/// The mean weight of samples under uniform light is the integral of the formula, above and below.
#[test]
fn albedos_are_the_integrals() {
    let all: Vec<_> = [20.0, 60.0].into_iter().flat_map(materials).collect();
    let level = sidak_level(ALPHA, 2 * all.len());
    let mut power = 0.0_f64;
    for ((name, m), seed) in all.iter().zip(7000..) {
        let oracle = Layered::new(m);
        let (exact, half) = (oracle.albedos(300), oracle.albedos(150));
        for (k, (mean, error)) in sampled(m, seed).into_iter().enumerate() {
            let error = error.hypot((exact[k].y - half[k].y).abs()).hypot(1e-3 * exact[k].y).max(1e-5);
            let test = z_test(mean, error, exact[k].y, level);
            assert!(test.p > level, "{name}, side {k}: {mean} ± {error} instead of {}", exact[k].y);
            power = power.max(test.detectable / exact[k].y.max(0.1));
        }
    }
    println!("a relative bias of {power:.1e} would have been detected");
    assert!(power < 0.1, "blind to {power}");
}

/// Layers over lossless white return at most the incident light, for any α and from any direction.
#[test]
fn layers_gain_no_light() {
    let mut largest = (0.0, String::new());
    for degrees in [0.0, 30.0, 60.0, 75.0, 85.0, 88.0, 89.5] {
        let white = Material::lambert(degrees);
        let fully = |m: Material| Material { coat: 1.0, ..m };
        let mut all = Vec::new();
        for alpha in [0.0, 0.01, 0.02, 0.04, 0.1, 0.3, 0.6, 1.0] {
            let velvet = Material { sheen_color: [1.0; 3], ..white.with_sheen(alpha) };
            all.push((format!("sheen {alpha}"), velvet));
            all.push((
                format!("sheen {alpha} over black"),
                Material { sheen_color: [1.0; 3], ..black(degrees).with_sheen(alpha) },
            ));
            all.push((format!("coat {alpha}"), fully(white.coated(alpha))));
            all.push((format!("coat {alpha} over sheen"), fully(velvet.coated(alpha))));
            all.push((
                format!("film {alpha}"),
                Material { film: 1.0, ..Material::metal(alpha.max(0.01), degrees).filmed(380.0) },
            ));
            all.push((format!("leaf {alpha}"), Material { through_color: [1.0; 3], ..white.translucent(alpha) }));
            all.push((format!("brushed {alpha}"), Material::metal(0.05, degrees).brushed(alpha.max(0.05))));
        }
        for (name, m) in all {
            let [(above, ea), (below, eb)] = sampled(&m, 8000);
            let (sum, error) = (above + below, ea.hypot(eb));
            let excess = sum - 4.5 * error;
            if excess > largest.0 {
                largest = (excess, format!("{name} at {degrees}°: {sum} ± {error}"));
            }
        }
    }
    println!("largest: {}", largest.1);
    assert!(largest.0 < 1.002, "{}", largest.1);
}

/// Where a layer's factor is 0, values and samples are those of the bare base.
#[test]
fn layers_of_factor_0_are_none() {
    let u = uniforms(2000, 9);
    let wis = sphere_directions(2000, 9);
    for base in [
        Material::dielectric(0.2, 40.0),
        Material::metal(0.1, 70.0),
        Material::glass(0.3, 30.0),
        Material::lambert(60.0),
    ] {
        let none = [
            ("coat", Material { coat: 0.0, ..base.coated(0.1) }),
            ("sheen", Material { sheen_color: [0.0; 3], ..base.with_sheen(0.3) }),
            ("film", Material { film: 0.0, ..base.filmed(300.0) }),
            ("leaf", base.translucent(0.0)),
        ];
        for (name, m) in none {
            for (a, b) in PROBE.eval(&base, &wis).iter().zip(PROBE.eval(&m, &wis)) {
                assert_eq!((a.value, a.pdf, a.albedo), (b.value, b.pdf, b.albedo), "{name} on {base:?}");
            }
            for (a, b) in PROBE.sample(&base, &u).iter().zip(PROBE.sample(&m, &u)) {
                assert_eq!((a.wi, a.pdf, a.weight), (b.wi, b.pdf, b.weight), "{name} on {base:?}");
            }
        }
    }
}

/// Facets that are rougher along x, turned by 90°, are rougher along y.
#[test]
fn a_turned_grain_swaps_the_axes() {
    let turn = |[x, y, z]: [f32; 3]| [-y, x, z];
    let wis = sphere_directions(4000, 10);
    let turned: Vec<_> = wis.iter().map(|&w| turn(w)).collect();
    for m in [Material::metal(0.1, 50.0).brushed(0.7), Material::glass(0.2, 60.0).brushed(0.6)] {
        let other = Material { alpha: m.alpha_along, alpha_along: m.alpha, wo: turn(m.wo), ..m };
        for (a, b) in PROBE.eval(&m, &wis).iter().zip(PROBE.eval(&other, &turned)) {
            for c in 0..3 {
                assert!((a.value[c] - b.value[c]).abs() <= 2e-4 * a.value[c].max(1e-3), "{m:?}: {a:?} or {b:?}");
            }
            assert!((a.pdf - b.pdf).abs() <= 2e-4 * a.pdf.max(1e-3), "{m:?}: {a:?} or {b:?}");
        }
    }
}

/// A Lambertian sheet reflects (1 − t)·ρ and sends t·τ through, for each sample's sum of sides.
#[test]
fn diffuse_transmission_splits_light_as_stated() {
    let t = 0.3;
    let m = Material { base_color: [0.9, 0.8, 0.7], ..Material::lambert(50.0) }.translucent(t);
    let [(above, ea), (below, eb)] = sampled(&m, 11);
    assert!((above - f64::from(0.7 * m.base_color[1])).abs() < 4.0 * ea, "{above} ± {ea}");
    assert!((below - f64::from(t * m.through_color[1])).abs() < 4.0 * eb, "{below} ± {eb}");
    assert!(ea < 5e-3 && eb < 5e-3);
}

/// Smooth dispersive glass: a refracted sample is of one channel and follows its Snell's law; over
/// all samples each channel keeps all of its light.
#[test]
fn each_colour_goes_its_own_way() {
    for m in [Material::glass(0.0, 60.0).dispersive(0.1), Material::glass_within(0.0, 30.0).dispersive(0.1)] {
        let mut moments = [Moments::default(), Moments::default(), Moments::default()];
        let mut served = [0; 3];
        for s in PROBE.sample(&m, &uniforms(100_000, 14)) {
            assert!(s.is_valid() && s.is_delta(), "{m:?}: {s:?}");
            let through = s.wi[2] < 0.0;
            let alone: Vec<usize> = (0..3).filter(|&c| s.weight[c] > 0.0).collect();
            assert!(!through || alone.len() == 1, "{m:?}: {s:?}");
            if through {
                let eta = m.eta_of(alone[0]);
                let sines = Vec3::from(s.wi).truncate() * eta;
                assert!((sines + Vec3::from(m.wo).truncate()).length() < 2e-6, "Snell's law fails: {m:?}: {s:?}");
                served[alone[0]] += 1;
            }
            for (c, channel) in moments.iter_mut().enumerate() {
                let radiance_scale = if through { m.eta_of(c).powi(2) } else { 1.0 };
                channel.push(f64::from(s.weight[c] * radiance_scale));
            }
        }
        assert!(served.iter().all(|&n| n > 1000), "{m:?}: {served:?}");
        for (c, channel) in moments.iter().enumerate() {
            let (mean, error) = (channel.mean(), channel.variance_of_mean().sqrt());
            assert!((mean - 1.0).abs() < 4.0 * error && error < 0.01, "{m:?}: channel {c} keeps {mean} ± {error}");
        }
    }
}

/// Glass without dispersion in a kernel that has it: the values are those of a kernel without it.
#[test]
fn no_spread_is_no_dispersion() {
    let plain = BsdfProbe::full();
    let wis = sphere_directions(4000, 15);
    for m in [Material::glass(0.2, 50.0), Material::glass_within(0.4, 30.0), Material::medley(0.3, 60.0)] {
        let m = Material { channels: [1.0 / 3.0; 3], ..m };
        for (a, b) in plain.eval(&m, &wis).iter().zip(PROBE.eval(&m, &wis)) {
            for c in 0..3 {
                assert!((a.value[c] - b.value[c]).abs() <= 1e-4 * a.value[c].max(1e-4), "{m:?}: {a:?} or {b:?}");
            }
            assert!((a.pdf - b.pdf).abs() <= 1e-4 * a.pdf.max(1e-4), "{m:?}: {a:?} or {b:?}");
        }
        let smooth = Material { alpha: 0.0, alpha_along: 0.0, ..m };
        let u = uniforms(2000, 16);
        for (a, b) in plain.sample(&smooth, &u).iter().zip(PROBE.sample(&smooth, &u)) {
            let same = a.is_valid() == b.is_valid() && a.is_delta() == b.is_delta();
            assert!(same && Vec3::from(a.wi).distance(b.wi.into()) < 1e-5, "{a:?} or {b:?}");
            assert!(
                Vec3::from(a.weight).distance(b.weight.into()) < 1e-4 * Vec3::from(a.weight).length(),
                "{a:?} or {b:?}"
            );
        }
    }
}

/// f is symmetric but for the coat, whose Fresnel term is the viewer's (as its extension has it).
#[test]
fn reciprocity() {
    let pairs = sphere_directions(6000, 12);
    for (name, kind) in materials(0.0) {
        if kind.coat > 0.0 || kind.transmission > 0.0 && kind.thin == 0.0 {
            continue;
        }
        let (mut there, mut back, mut wis, mut back_wis, mut scale) = (vec![], vec![], vec![], vec![], vec![]);
        for &[a, b] in pairs.as_chunks::<2>().0 {
            let (wo, wi) = (Vec3::from(a) * Vec3::new(1.0, 1.0, a[2].signum()), Vec3::from(b));
            if wo.z < 0.05 || wi.z.abs() < 0.05 {
                continue;
            }
            // From the other side, up is down.
            let flip = Vec3::new(1.0, 1.0, wi.z.signum());
            there.push(Material { wo: wo.into(), ..kind });
            wis.push(wi.into());
            back.push(Material { wo: (wi * flip).into(), ..kind });
            back_wis.push((wo * flip).into());
            scale.push(f64::from(wo.z) / f64::from(wi.z.abs()));
        }
        let values = PROBE.eval_each(&there, &wis).into_iter().zip(PROBE.eval_each(&back, &back_wis));
        for ((t, b), scale) in values.zip(scale) {
            for c in 0..3 {
                let (t, b) = (f64::from(t.value[c]) * scale, f64::from(b.value[c]));
                assert!((t - b).abs() <= 2e-4 * t.max(b).max(1e-2), "{name}: {t} or {b}");
            }
        }
    }
}

#[test]
fn specialised_kernels_agree_with_the_general_one() {
    for (name, m) in materials(45.0).into_iter().step_by(2) {
        // Without dispersion, channels are as likely.
        let m = Material { channels: [1.0 / 3.0; 3], ..m };
        let special = BsdfProbe::new(&m.key());
        let u = uniforms(2000, 13);
        for (s, g) in special.sample(&m, &u).iter().zip(PROBE.sample(&m, &u)) {
            assert_eq!(s.is_valid(), g.is_valid(), "{name}");
            let close = (Vec3::from(s.weight) - Vec3::from(g.weight)).length() <= 1e-3 * Vec3::from(g.weight).length();
            assert!(!g.is_valid() || close, "{name}: weight {:?} or {:?}", s.weight, g.weight);
        }
    }
}
