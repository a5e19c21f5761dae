//! Cases 6 and 7: the ends of the random numbers' range, and cosines above 1.

use glam::{DQuat, DVec3, Vec3};
use surelight_prepare::Settings;
use surelight_scenes::torture::{self, numeric};
use surelight_tests::bsdf::{BsdfProbe, Eval, Material};
use surelight_tests::light::{Query, probe};
use surelight_tests::render::{all, prepare, render};
use surelight_tests::sampler;
use surelight_tests::scenes::map;

/// The greatest number below 1 that a kernel draws, and the smallest above 0.
const LAST: f32 = 1.0 - STEP;
const STEP: f32 = 1.0 / 16_777_216.0;

/// The next f32 above 1.
fn one_up() -> f32 {
    f32::from_bits(1.0_f32.to_bits() + 1)
}

/// Every kind of base, and none of the layers.
fn kinds() -> [Material; 11] {
    [
        Material::lambert(0.0),
        Material::dielectric(1.0, 0.0),
        Material::metal(1.0, 0.0),
        Material::glass(1.0, 0.0),
        Material::glass_within(1.0, 0.0),
        Material::thin(1.0, 0.0),
        Material::medley(1.0, 0.0),
        Material { base_color: [0.0; 3], ..Material::medley(1.0, 0.0) },
        Material { base_color: [0.0; 3], ..Material::lambert(0.0) },
        // No interface at all, an index of 1, and one that reflects everything.
        Material { eta: 1.0, ior: 1.0, f0: [0.0; 3], ..Material::glass(1.0, 0.0) },
        Material { eta: 1e4, ior: 1e4, f0: [1.0; 3], ..Material::glass(1.0, 0.0) },
    ]
}

const ALPHAS: [f32; 6] = [0.0, 0.99e-4, 1e-4, 1e-3, 0.1, 1.0];

/// Bits become numbers below 1, samplers draw such numbers, and lobes and lights make something
/// finite of the ends.
#[test]
fn u_endpoints() {
    for (name, features) in sampler::SAMPLERS {
        let ends = [0, 1, 255, 256, 0x7fff_ffff, 0xffff_ff00, 0xffff_ff7f, 0xffff_ff80, u32::MAX];
        let queries: Vec<_> = ends.map(|bits| sampler::Query { bits, count: 1, ..Default::default() }).into();
        for (query, point) in queries.iter().zip(sampler::sample(features, &queries)) {
            assert!((0.0..=LAST).contains(&point.unit), "{name}: {:#x} becomes {}", query.bits, point.unit);
        }
        assert_eq!(sampler::sample(features, &queries).last().map(|p| p.unit), Some(LAST));
    }
    lobes();
    lights();
}

/// BSDF samples: finite, on the viewer's or the other side, their densities positive.
fn lobes() {
    let probe = BsdfProbe::full();
    let ends = [0.0, STEP, 0.25, 0.5, 0.75, LAST];
    let cube: Vec<[f32; 3]> = (0..216).map(|i| [ends[i / 36], ends[i / 6 % 6], ends[i % 6]]).collect();
    let grazing = |z: f32| [-(1.0 - z * z).sqrt(), 0.0, z];
    for kind in kinds() {
        for alpha in ALPHAS {
            for wo in [[0.0, 0.0, 1.0], [0.36, 0.48, 0.8], grazing(1.7e-3), grazing(1e-7), grazing(1e-30)] {
                let m = Material { alpha, alpha_along: alpha, wo, ..kind };
                for (u, s) in cube.iter().zip(probe.sample(&m, &cube)) {
                    let numbers = [s.weight[0], s.weight[1], s.weight[2], s.pdf, s.wi[0], s.wi[1], s.wi[2]];
                    assert!(numbers.iter().all(|x| x.is_finite()), "{m:?}\nat {u:?}: {s:?}");
                    assert!(numbers[..4].iter().all(|&x| x >= 0.0), "{m:?}\nat {u:?}: {s:?}");
                    assert!(!s.is_valid() || s.pdf > 0.0 || s.is_delta(), "{m:?}\nat {u:?}: {s:?}");
                    assert!(!s.is_delta() || (alpha < 1e-4 && s.pdf == 0.0), "{m:?}\nat {u:?}: {s:?}");
                    let length = Vec3::from(s.wi).length();
                    assert!(!s.is_valid() || (length - 1.0).abs() < 1e-5, "{m:?}\nat {u:?}: {s:?}");
                }
            }
        }
    }
}

/// Samples of lights: unit directions, positive densities, and points that lie where the light is.
fn lights() {
    let mut scene = torture::scene("u-endpoints");
    scene.environment = Some(map(8, 4, |x, y| [0.01 * (1 + x + y) as f32; 3]));
    let prepared = prepare(&scene, &Settings::new(8, 8));
    let mut queries = Vec::new();
    for choice in (0..=64u64).map(|k| (k << 26).min(u64::from(u32::MAX)) as u32).flat_map(|c| [c, c.wrapping_sub(1)]) {
        for u in [0.0, 0.5, LAST] {
            queries.extend([0.0, 0.5, LAST].map(|v| Query::with([0.0, -1.0, -7.0], choice, [u, v])));
        }
    }
    let mut near = 0;
    for s in probe(&prepared, "probe_light", &queries) {
        assert!(s.radiance.iter().all(|r| r.is_finite() && *r >= 0.0) && s.pdf.is_finite(), "{s:?}");
        assert!((s.direction().length() - 1.0).abs() < 1e-5, "{s:?}");
        if s.distance < 1e3 {
            near += 1;
            let to = DVec3::from(s.target.map(f64::from)) - DVec3::new(0.0, -1.0, -7.0);
            assert!((to - s.direction() * f64::from(s.distance)).length() < 1e-4, "{s:?}");
        }
    }
    assert!(near > 100, "{near} samples are of lamps");
    for s in probe(&prepared, "probe_environment_sample", &queries) {
        assert!(s.pdf > 0.0 && s.pdf.is_finite() && (s.direction().length() - 1.0).abs() < 1e-5, "{s:?}");
    }
}

/// Directions that are longer than 1 by an ULP or two, and cosines with them.
#[test]
fn dot_above_one() {
    let probe = BsdfProbe::full();
    let slanted = (Vec3::new(0.36, 0.48, 0.8) * one_up()).to_array();
    for kind in kinds() {
        for alpha in ALPHAS {
            for wo in [[0.0, 0.0, one_up()], [3e-4, 0.0, one_up()], slanted] {
                let m = Material { alpha, alpha_along: alpha, wo, ..kind };
                // Towards the poles, the horizon, the mirror direction and back.
                let [x, y, z] = wo;
                let wis = [
                    [0.0, 0.0, one_up()],
                    [0.0, 0.0, -one_up()],
                    [one_up(), 0.0, 0.0],
                    [-x, -y, z],
                    [-x, -y, -z],
                    wo,
                    [x, y, -z],
                ];
                for (wi, e) in wis.iter().zip(probe.eval(&m, &wis)) {
                    let Eval { value, pdf, albedo, .. } = e;
                    let numbers = [value[0], value[1], value[2], pdf, albedo[0], albedo[1], albedo[2]];
                    assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{m:?}\ntowards {wi:?}: {e:?}");
                }
            }
        }
    }
    // A narrow lobe viewed and lit along its normal, however it is turned.
    let truth = numeric::dot_above_one_radiance();
    for angle in [0.0, 0.7, 1.9, 2.6, 3.0] {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), angle);
        let film = render(&numeric::dot_above_one(turn), &Settings::new(16, 16), 1, 1);
        let off = |i: usize| (0..3).map(|c| (film.mean(i)[c] / truth[c] - 1.0).abs()).fold(0.0, f64::max);
        let worst = all(&film).map(off).fold(0.0, f64::max);
        println!("turned by {angle}: {worst:.1e} of {truth:?} at most");
        assert!(worst < 2e-6, "turned by {angle}, pixels are off by {worst:.1e}");
    }
}
