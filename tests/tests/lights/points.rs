//! Where on a light.

use glam::{DVec3, Vec3};
use surelight_estimate::{normal_quantile, sidak_level};
use surelight_prepare::{Part, Settings};
use surelight_tests::light::{Query, Sample, probe, random_queries};
use surelight_tests::render::{ALPHA, prepare};

use crate::lamps::{Chosen, Lamp, NORMAL, POSITION, SAMPLES, area_pdf, chosen, lamps, samples_of, scene, with_square};

/// Wherever points are taken, their mean of one over the pdf is the area of each part of a lamp: by
/// a lamp alone, triangle or square, far or so near that the pdf varies fivefold, and by a tree
/// over several.
///
/// 16 parts per lamp, α Šidák over all. Of the likeliest lamps a bias of 1 % would be detected in
/// each part, nine times in ten.
#[test]
fn points_follow_the_pdf() {
    let [near, far] = [0.6, 4.0].map(|distance| {
        let corner = DVec3::new(-0.7, -1.0, distance);
        [corner, corner + DVec3::new(0.0, 1.5, 0.2), corner + DVec3::new(2.0, 0.1, 0.3)]
    });
    let alone = |corners, square| vec![Lamp { corners, radiance: [2.0, 3.0, 1.0], square }];
    let cases = [
        ("near triangle", alone(near, false)),
        ("near square", alone(near, true)),
        ("far square", alone(far, true)),
        ("tree", with_square(lamps(), near)),
    ];
    let level = sidak_level(ALPHA, 3 * 16 + 9 * 16);
    let quantile = normal_quantile(1.0 - 0.5 * level);
    for (name, lamps) in cases {
        let prepared = prepare(&scene(&lamps), &Settings::new(8, 8));
        assert_eq!(prepared.key().has(Part::LightTree), lamps.len() > 1);
        let samples = samples_of(&lamps, &prepared, 1);
        let mut tested = 0;
        for (k, lamp) in lamps.iter().enumerate() {
            let mut sums = [[0.0f64; 3]; 16];
            let (mut least, mut most) = (f64::MAX, 0.0f64);
            for (s, chosen) in &samples {
                let &Chosen::Lamp(of, b1, b2) = chosen else { continue };
                if of != k {
                    continue;
                }
                let inverse = 1.0 / area_pdf(lamp, s);
                (least, most) = (least.min(inverse), most.max(inverse));
                for c in 0..3 {
                    let value = f64::from(s.radiance[c]) * f64::from(s.pdf);
                    let exact = f64::from(lamp.radiance[c]);
                    assert!((value - exact).abs() <= 1e-5 * exact, "lamp {k} shines {value}, not {exact}");
                }
                let sum = &mut sums[lamp.part(b1, b2)];
                *sum = [sum[0] + 1.0, sum[1] + inverse, sum[2] + inverse * inverse];
            }
            for (part, [count, first, second]) in sums.into_iter().enumerate() {
                // Lamps that are rarely chosen have too few samples.
                if count < 200.0 {
                    continue;
                }
                tested += 1;
                let n = SAMPLES as f64;
                let (mean, exact) = (first / n, lamp.area() / 16.0);
                let z = (mean - exact) / ((second / n - mean * mean) / n).sqrt();
                assert!(z.abs() < quantile, "{name}, lamp {k}, part {part}: {mean} instead of {exact}, z = {z:.2}");
            }
            println!("{name}, lamp {k}: the pdf varies {:.1}-fold", most / least);
            assert!(!name.starts_with("near") || most > 4.0 * least, "{name}: the pdf varies too little");
        }
        assert!(tested >= 16 * lamps.len().min(2), "{name}: {tested} parts tested");
    }
}

/// A BSDF sample that hits a light computes the pdf that light sampling would have had there: else
/// the weights of multiple importance sampling would not add up to one.
#[test]
fn hit_and_sampled_pdfs_agree() {
    let corner = DVec3::new(-0.7, -1.0, 0.6);
    let near = [corner, corner + DVec3::new(0.0, 1.5, 0.2), corner + DVec3::new(2.0, 0.1, 0.3)];
    for square in [false, true] {
        let lamps = vec![Lamp { corners: near, radiance: [1.0; 3], square }];
        let prepared = prepare(&scene(&lamps), &Settings::new(8, 8));
        let sampled: Vec<_> = samples_of(&lamps, &prepared, 2)
            .into_iter()
            .filter_map(|(s, c)| matches!(c, Chosen::Lamp(..)).then_some(s))
            .take(100_000)
            .collect();
        let again =
            |s: &Sample| Query { viewer: s.direction, normal: NORMAL.to_array(), ..Query::with(POSITION, 0, [0.5; 2]) };
        // The pdf varies over the lamp as for BSDF samples that hit it; its mean is the lamp's
        // probability by its area.
        let queries: Vec<_> = sampled.iter().map(|s| Query { both_sides: 1, ..again(s) }).collect();
        let hits = probe(&prepared, "probe_light", &queries);
        let factor = |s: &Sample, hits: &Sample| area_pdf(&lamps[0], s) / f64::from(hits.other_pdf);
        let first = factor(&sampled[0], &hits[0]);
        let probability = first * lamps[0].area();
        assert!(probability > 0.2 && probability < 1.0, "the lamp is chosen with a probability of {probability}");
        for (s, hits) in sampled.iter().zip(&hits) {
            assert!((factor(s, hits) / first - 1.0).abs() < 1e-3, "{s:?} against {}", hits.other_pdf);
        }
    }
    let prepared = prepare(&scene(&with_square(lamps(), near)), &Settings::new(8, 8));
    for both_sides in [0, 1] {
        let queries: Vec<_> = random_queries(POSITION, 100_000, 3)
            .into_iter()
            .map(|query| Query { both_sides, normal: NORMAL.to_array(), ..query })
            .collect();
        for s in probe(&prepared, "probe_light_met", &queries) {
            assert!((s.pdf / s.other_pdf - 1.0).abs() < 2e-3, "{s:?}");
        }
    }
}

/// The ends of the random numbers' range give points on the lights.
#[test]
fn endpoints_are_finite() {
    let lamps = lamps();
    let prepared = prepare(&scene(&lamps), &Settings::new(8, 8));
    let last = 1.0 - f32::EPSILON / 2.0;
    let mut queries = Vec::new();
    for choice in (0..=64u64).map(|k| (k << 26).min(u64::from(u32::MAX)) as u32).flat_map(|c| [c, c.wrapping_sub(1)]) {
        for u in [0.0, 0.5, last] {
            queries.extend([0.0, 0.5, last].map(|v| Query::with(POSITION, choice, [u, v])));
        }
    }
    for s in probe(&prepared, "probe_light", &queries) {
        chosen(&lamps, &s);
        assert!(s.radiance.iter().all(|r| r.is_finite() && *r >= 0.0) && s.pdf.is_finite(), "{s:?}");
        assert!((Vec3::from(s.direction).length() - 1.0).abs() < 1e-5, "{s:?}");
    }
    for s in probe(&prepared, "probe_environment_sample", &queries) {
        assert!(s.pdf > 0.0 && s.pdf.is_finite() && (s.direction().length() - 1.0).abs() < 1e-5, "{s:?}");
    }
}
