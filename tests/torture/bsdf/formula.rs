//! The device's BSDF against the specifications' formulas in f64, and the identities that any BSDF
//! obeys.

use glam::{DVec3, Vec3};
use surelight_tests::bsdf::{BsdfProbe, Material, sphere_directions, uniforms};
use surelight_tests::bsdf_oracle::lobes;

/// Every kind of material at several roughnesses and angles.
fn materials() -> Vec<Material> {
    let kinds = [
        Material::dielectric,
        Material::metal,
        Material::glass,
        Material::glass_within,
        Material::thin,
        Material::medley,
    ];
    // Weakened and coloured reflection, which total internal reflection is not.
    let weak = |alpha, degrees| Material { f0: [0.02, 0.01, 0.0], f90: 0.5, ..Material::glass_within(alpha, degrees) };
    let mut all = vec![Material::lambert(40.0), weak(0.2, 20.0), weak(0.6, 50.0), weak(1.0, 75.0)];
    for kind in kinds {
        for alpha in [0.05, 0.2, 0.6, 1.0] {
            all.extend([0.0, 35.0, 70.0, 88.0].map(|degrees| kind(alpha, degrees)));
        }
    }
    all
}

fn relative(device: f32, exact: f64, scale: f64) -> f64 {
    (f64::from(device) - exact).abs() / scale.max(1e-30)
}

/// Whether the angle at a facet is within some degrees of grazing or of the critical angle.
/// Fresnel's equations have the square root of a difference there, which keeps few digits in f32;
/// it has no effect on a picture.
fn nearly_critical(m: &Material, wo: Vec3, wi: Vec3) -> bool {
    let solid = m.transmission > 0.0 && m.thin == 0.0;
    let h = if wi.z < 0.0 { wo + m.eta * wi } else { wo + wi }.normalize();
    let (o, i) = (wo.dot(h), wi.dot(h));
    let g2 = m.eta * m.eta - 1.0 + o * o;
    solid && if wi.z < 0.0 { o.abs().min(i.abs()) < 0.2 } else { g2.abs() < 0.05 }
}

/// Directions over the whole sphere, and some from the material's own lobes.
fn directions(probe: &BsdfProbe, m: &Material) -> Vec<[f32; 3]> {
    let mut all = sphere_directions(4000, 1);
    all.extend(probe.sample(m, &uniforms(4000, 2)).iter().filter(|s| s.is_valid()).map(|s| s.wi));
    all
}

#[test]
fn value_is_the_specifications_formula() {
    let probe = BsdfProbe::full();
    let mut worst = (0.0, String::new());
    for m in materials() {
        let wis = directions(&probe, &m);
        for (wi, e) in wis.iter().zip(probe.eval(&m, &wis)) {
            let exact = lobes(&m, DVec3::from(wi.map(f64::from))).sum();
            if wi[2].abs() < 1e-3 || nearly_critical(&m, m.wo.into(), (*wi).into()) {
                continue;
            }
            for c in 0..3 {
                let error = relative(e.value[c], exact[c], exact.max_element().max(1e-3));
                if error > worst.0 {
                    worst = (error, format!("{m:?}\ntowards {wi:?}: {:?}, not {exact}", e.value));
                }
            }
        }
    }
    println!("largest relative error {:.1e}", worst.0);
    assert!(worst.0 < 2e-4, "relative error {:.1e}: {}", worst.0, worst.1);
}

/// Cosine-weighted directions, to the last digits: sine and cosine are the shader's own.
#[test]
fn cosine_directions_are_exact() {
    let m = Material::lambert(0.0);
    let mut u = uniforms(100_000, 8);
    // Around the seams between quarters of a turn.
    u.extend((0..=8).flat_map(|i| (-2..=2).map(move |j| [0.0, i as f32 / 8.0 + j as f32 / 16_777_216.0, 0.5])));
    u.retain(|u| (0.0..1.0).contains(&u[1]));
    for (u, s) in u.iter().zip(BsdfProbe::new(&m.key()).sample(&m, &u)) {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(u[1])).sin_cos();
        let (r, z) = (f64::from(u[2]).sqrt(), (1.0 - f64::from(u[2])).sqrt());
        let error = (DVec3::from(s.wi.map(f64::from)) - DVec3::new(r * cos, r * sin, z)).length();
        assert!(error < 3e-7, "{u:?}: {:?} is {error:.1e} off", s.wi);
    }
}

#[test]
fn specialised_kernels_agree_with_the_general_one() {
    let general = BsdfProbe::full();
    let smooth = [Material::dielectric(0.0, 30.0), Material::metal(0.0, 60.0), Material::glass(0.0, 45.0)];
    for m in materials().into_iter().step_by(5).chain(smooth) {
        let special = BsdfProbe::new(&m.key());
        let u = uniforms(2000, 3);
        for (s, g) in special.sample(&m, &u).iter().zip(general.sample(&m, &u)) {
            assert_eq!(s.is_valid(), g.is_valid(), "{m:?}");
            let close = (Vec3::from(s.weight) - Vec3::from(g.weight)).length() <= 1e-4 * Vec3::from(g.weight).length();
            assert!(!g.is_valid() || close, "{m:?}: weight {:?} or {:?}", s.weight, g.weight);
        }
    }
}

#[test]
fn weight_is_value_over_pdf() {
    let probe = BsdfProbe::full();
    for m in materials() {
        let samples: Vec<_> = probe.sample(&m, &uniforms(4000, 4)).into_iter().filter(|s| s.is_valid()).collect();
        let wis: Vec<_> = samples.iter().map(|s| s.wi).collect();
        assert!(wis.len() > 1000, "{m:?}: only {} samples are valid", wis.len());
        for (s, e) in samples.iter().zip(probe.eval(&m, &wis)) {
            assert!(relative(s.pdf, f64::from(e.pdf), f64::from(e.pdf)) < 1e-5, "{m:?}: {s:?} {e:?}");
            for c in 0..3 {
                let value = f64::from(s.weight[c]) * f64::from(s.pdf);
                assert!(relative(e.value[c], value, value.max(1e-12)) < 1e-5, "{m:?}: {s:?} {e:?}");
            }
        }
    }
}

/// f is symmetric; between media f/η² is (Veach 1997, section 5.2).
/// For broad lobes: a narrow one amplifies the rounding of the half-vector by about 1/α.
#[test]
fn reciprocity() {
    let probe = BsdfProbe::full();
    let mut worst = (0.0_f64, String::new());
    let pairs = sphere_directions(20_000, 5);
    for m in materials().into_iter().filter(|m| m.alpha >= 0.2) {
        let (mut there, mut back, mut back_wis, mut scale) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut wis = Vec::new();
        for &[a, b] in pairs.as_chunks::<2>().0 {
            let wo = Vec3::from(a) * Vec3::new(1.0, 1.0, a[2].signum());
            let wi = Vec3::from(b);
            // Away from the horizon, where f is a quotient of vanishing numbers.
            if wo.z < 0.05 || wi.z.abs() < 0.05 || nearly_critical(&m, wo, wi) {
                continue;
            }
            // From the other side, up is down.
            let flip = Vec3::new(1.0, 1.0, wi.z.signum());
            let through = wi.z < 0.0 && m.thin == 0.0;
            let eta = if through { 1.0 / m.eta } else { m.eta };
            there.push(Material { wo: wo.into(), ..m });
            wis.push(wi.into());
            back.push(Material { wo: (wi * flip).into(), eta, ..m });
            back_wis.push((wo * flip).into());
            let radiance = if through { f64::from(m.eta).powi(2) } else { 1.0 };
            scale.push(radiance * f64::from(wo.z) / f64::from(wi.z.abs()));
        }
        let values = probe.eval_each(&there, &wis).into_iter().zip(probe.eval_each(&back, &back_wis));
        for (((t, b), scale), (m, wi)) in values.zip(scale).zip(there.iter().zip(&wis)) {
            for c in 0..3 {
                let (t, b) = (f64::from(t.value[c]) * scale, f64::from(b.value[c]));
                let asymmetry = (t - b).abs() / t.max(b).max(1e-2);
                if asymmetry > worst.0 {
                    worst = (asymmetry, format!("{m:?} towards {wi:?}: {t} or {b}"));
                }
            }
        }
    }
    println!("largest relative asymmetry {:.1e}", worst.0);
    assert!(worst.0 < 1e-5, "relative asymmetry {:.1e}: {}", worst.0, worst.1);
}

#[test]
fn only_lone_deltas_are_delta() {
    let probe = BsdfProbe::full();
    let is_delta = |m: &Material| probe.eval(m, &[[0.0, 0.0, 1.0]])[0].is_delta == 1.0;
    assert!(is_delta(&Material::metal(0.0, 30.0)));
    assert!(is_delta(&Material::glass(0.0, 30.0)));
    assert!(!is_delta(&Material::metal(1e-4, 30.0)));
    assert!(!is_delta(&Material::lambert(30.0)));
    assert!(!is_delta(&Material::dielectric(0.0, 30.0)), "its base scatters");
}
