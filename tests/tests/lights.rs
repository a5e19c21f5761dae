//! Sampling of lights: which one, and where on it, follow the pdf that is claimed; the value is the light's over that pdf.

use glam::{DVec3, Vec3};
use surelight_estimate::{chi_squared_test, normal_quantile, sidak_level};
use surelight_render::{Integrator, Prepared, Settings};
use surelight_scene::{Light, LightKind, Material, Scene, procedural::shapes::Shape};
use surelight_tests::light::{Query, Sample, probe, random_queries};
use surelight_tests::random::Random;
use surelight_tests::render::{ALPHA, prepare};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, pinhole};

const SAMPLES: usize = 1_000_000;
/// Where light is asked for: before all the lamps.
const POSITION: [f32; 3] = [0.1, -0.2, 0.3];
/// How the surface there faces.
const NORMAL: Vec3 = Vec3::new(0.48, 0.36, 0.8);

/// A lamp of the test: corners relative to the camera at the origin, and radiance.
struct Lamp {
    corners: [DVec3; 3],
    radiance: [f32; 3],
    /// Of two triangles.
    square: bool,
}

impl Lamp {
    fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).length() * if self.square { 1.0 } else { 0.5 }
    }

    /// One of 16 parts, alike in area.
    fn part(&self, b1: f64, b2: f64) -> usize {
        let cell = |b: f64| ((4.0 * b) as usize).min(3);
        if self.square { 4 * cell(b1.max(0.0)) + cell(b2.max(0.0)) } else { part(b1, b2) }
    }
}

/// Triangles of very different power, turned towards the origin; the first two of them one square.
fn lamps() -> Vec<Lamp> {
    let lamp = |center: [f64; 3], half: f64, radiance: [f32; 3]| {
        let center = DVec3::from(center);
        let side = center.any_orthonormal_vector() * half;
        let up = side.cross(center).normalize() * half;
        let corner = |a: f64, b: f64| center + side * a + up * b;
        let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
        [[a, b, c], [a, c, d]].map(|corners| Lamp { corners, radiance, square: false })
    };
    [
        lamp([2.0, 1.0, 0.5], 0.5, [1.0; 3]),
        lamp([-3.0, 0.2, 0.1], 0.1, [10.0, 5.0, 0.0]),
        lamp([0.5, 2.5, -2.0], 1.0, [0.01, 0.02, 0.03]),
        lamp([0.0, -3.0, 1.0], 0.3, [0.0, 0.0, 4.0]),
    ]
    .into_iter()
    .flatten()
    .collect()
}

const POINT: DVec3 = DVec3::new(1.5, -1.0, 2.5);

fn scene(lamps: &[Lamp]) -> Scene {
    let mut scene = Scene { name: "lamps".into(), ..Scene::default() };
    for lamp in lamps {
        let [a, b, c] = lamp.corners;
        let mut shape = Shape { positions: lamp.corners.to_vec(), triangles: vec![[0, 1, 2]], ..Shape::default() };
        if lamp.square {
            shape.positions.push(b + c - a);
            shape.triangles.push([3, 2, 1]);
        }
        assert!((b - a).cross(c - a).dot(a) < 0.0, "lamps shine at the origin");
        add(&mut scene, shape, emitter(lamp.radiance));
    }
    // Something that is no light.
    add(&mut scene, Shape::parallelogram(DVec3::Z * -5.0, DVec3::X, DVec3::Y), lambert([0.5; 3]));
    scene.lights.push(Light { name: String::new(), kind: LightKind::Point { position: POINT }, intensity: [0.3; 3] });
    scene.environment = Some(map(8, 4, |x, y| [0.01 * (1 + x + y) as f32; 3]));
    scene.cameras = vec![pinhole(look_at(DVec3::ZERO, DVec3::Z, DVec3::Y), 60.0)];
    scene
}

/// What a sample chose.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Chosen {
    /// A lamp, with the barycentric weights of the point.
    Lamp(usize, f64, f64),
    Point,
    Environment,
}

fn chosen(lamps: &[Lamp], s: &Sample) -> Chosen {
    if s.distance > 1e30 {
        return Chosen::Environment;
    }
    let p = DVec3::from(s.target.map(f64::from));
    if (p - POINT).length() < 1e-5 {
        return Chosen::Point;
    }
    let inside = |lamp: &Lamp| {
        let [a, b, c] = lamp.corners;
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let (b1, b2) = ((p - a).cross(e2).dot(n) / n.dot(n), e1.cross(p - a).dot(n) / n.dot(n));
        let off = (p - a).dot(n.normalize()).abs();
        let within = if lamp.square { b1.max(b2) < 1.0 + 1e-4 } else { b1 + b2 < 1.0 + 1e-4 };
        (off < 1e-4 && b1 > -1e-4 && b2 > -1e-4 && within).then_some((b1, b2))
    };
    let found = lamps.iter().enumerate().find_map(|(k, lamp)| inside(lamp).map(|(b1, b2)| Chosen::Lamp(k, b1, b2)));
    found.unwrap_or_else(|| panic!("{s:?} lies on no lamp"))
}

/// One of 16 parts of a triangle, alike in area.
fn part(b1: f64, b2: f64) -> usize {
    let (x, y) = ((4.0 * b1.clamp(0.0, 1.0 - 1e-9)), (4.0 * b2.clamp(0.0, 1.0 - 1e-9)));
    let (i, j) = (x as usize, y as usize);
    let upper = x.fract() + y.fract() > 1.0 && i + j < 3;
    // Rows of 7, 5, 3 and 1 small triangles.
    let row = [0, 7, 12, 15][j.min(3)];
    (row + 2 * i.min(3 - j.min(3)) + usize::from(upper)).min(15)
}

/// Solid-angle pdf as area pdf.
fn area_pdf(lamp: &Lamp, s: &Sample) -> f64 {
    let [a, b, c] = lamp.corners;
    let n = (b - a).cross(c - a).normalize();
    let p = DVec3::from(s.target.map(f64::from)) - DVec3::from(POSITION.map(f64::from));
    f64::from(s.pdf) * n.dot(p.normalize()).abs() / p.length_squared()
}

/// Lamps, one of them a square of two triangles.
fn with_square(mut lamps: Vec<Lamp>, corners: [DVec3; 3]) -> Vec<Lamp> {
    lamps.push(Lamp { corners, radiance: [2.0, 3.0, 1.0], square: true });
    lamps
}

/// Samples of the table, and what each of them chose. Light from behind counts, too.
fn samples_of(lamps: &[Lamp], prepared: &Prepared, seed: u64) -> Vec<(Sample, Chosen)> {
    let queries: Vec<_> = random_queries(POSITION, SAMPLES, seed)
        .into_iter()
        .map(|query| Query { both_sides: 1, normal: NORMAL.to_array(), ..query })
        .collect();
    probe(prepared, "probe_light", &queries).into_iter().map(|s| (s, chosen(lamps, &s))).collect()
}

/// Wherever points are taken, their mean of one over the pdf is the area of each part of a lamp: by a lamp alone, triangle or square, far
/// or so near that the pdf varies fivefold, and by a tree over several.
///
/// 16 parts a lamp, α Šidák over all. Of the likeliest lamps a bias of 1 % would be seen in each part, nine times in ten.
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
        assert_eq!(prepared.features.light_tree, lamps.len() > 1);
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
                // Of lamps that are hardly ever chosen too little is known.
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
            assert!(!name.starts_with("near") || most > 4.0 * least, "{name}: the pdf hardly varies");
        }
        assert!(tested >= 16 * lamps.len().min(2), "{name}: {tested} parts tested");
    }
}

/// The table's choice among a lamp, a point light and an environment follows the probabilities that samples claim.
#[test]
fn choice_follows_the_pdf() {
    let lamps: Vec<_> = lamps().into_iter().take(1).collect();
    let prepared = prepare(&scene(&lamps), &Settings::new(8, 8));
    let all = samples_of(&lamps, &prepared, 1);
    let (mut observed, mut expected) = (Vec::new(), Vec::new());
    // What a point light brings over its true irradiance is one over its probability.
    let r2 = (POINT - DVec3::from(POSITION.map(f64::from))).length_squared();
    let points: Vec<_> = all.iter().filter(|(_, c)| *c == Chosen::Point).collect();
    let value = f64::from(points.first().expect("the point light is chosen").0.radiance[0]);
    observed.push(points.len() as u64);
    expected.push(0.3 / r2 / value * SAMPLES as f64);
    assert!(points.iter().all(|(s, _)| s.pdf == 0.0), "a point has no solid angle");
    // And the environment's pdf over what the map alone claims is its probability.
    let skies: Vec<_> = all.iter().filter(|(_, c)| *c == Chosen::Environment).map(|(s, _)| *s).collect();
    let directions: Vec<_> = skies.iter().take(64).map(|s| Query::towards(s.direction())).collect();
    let alone = probe(&prepared, "probe_environment_eval", &directions);
    observed.push(skies.len() as u64);
    expected.push(f64::from(skies[0].pdf) / f64::from(alone[0].pdf) * SAMPLES as f64);
    for (s, map) in skies.iter().zip(&alone) {
        let exact = map.radiance[0] / s.pdf;
        assert!((s.radiance[0] / exact - 1.0).abs() < 1e-4, "{s:?} against {map:?}");
    }
    observed.push(SAMPLES as u64 - observed.iter().sum::<u64>());
    expected.push(SAMPLES as f64 - expected.iter().sum::<f64>());
    let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{e}"));
    println!("choice of a light: {observed:?}, χ² p = {:.4}", test.p);
    assert!(test.p > ALPHA, "{observed:?} instead of {expected:?}, p = {:.1e}", test.p);
}

/// Whoever meets a light by chance computes the pdf that light sampling would have had there: else the weights of multiple importance
/// sampling would not add up to one.
#[test]
fn met_and_sampled_pdfs_agree() {
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
        // The pdf varies over the lamp as it does for whoever meets it, whose mean is the lamp's probability by its area.
        let queries: Vec<_> = sampled.iter().map(|s| Query { both_sides: 1, ..again(s) }).collect();
        let met = probe(&prepared, "probe_light", &queries);
        let factor = |s: &Sample, met: &Sample| area_pdf(&lamps[0], s) / f64::from(met.other_pdf);
        let first = factor(&sampled[0], &met[0]);
        let probability = first * lamps[0].area();
        assert!(probability > 0.2 && probability < 1.0, "the lamp is chosen with a probability of {probability}");
        for (s, met) in sampled.iter().zip(&met) {
            assert!((factor(s, met) / first - 1.0).abs() < 1e-3, "{s:?} against {}", met.other_pdf);
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

/// Half of the choice goes to every emitter alike, half by power: luminance times area.
#[test]
fn choice_is_half_even_half_by_power() {
    // Whitted chooses by the table however many there are, with points that are uniform, and does without the environment.
    let lamps: Vec<_> = lamps().into_iter().step_by(2).take(2).collect();
    let emitters = lamps.len() as f64 + 1.0; // the point light
    let settings = Settings { integrator: Integrator::Whitted, ..Settings::new(8, 8) };
    let prepared = prepare(&scene(&lamps), &settings);
    let samples = probe(&prepared, "probe_light", &random_queries(POSITION, 20_000, 2));
    let mut per_power = Vec::new();
    for (k, lamp) in lamps.iter().enumerate() {
        let Some(s) = samples.iter().find(|s| matches!(chosen(&lamps, s), Chosen::Lamp(of, ..) if of == k)) else {
            continue;
        };
        let [a, b, c] = lamp.corners;
        let area = 0.5 * (b - a).cross(c - a).length();
        let luminance: f64 = lamp.radiance.iter().zip([0.2126, 0.7152, 0.0722]).map(|(&r, w)| f64::from(r) * w).sum();
        let by_power = area_pdf(lamp, s) * area - 0.5 / emitters;
        per_power.push(by_power / (luminance * area));
    }
    assert_eq!(per_power.len(), 2);
    // Rounding of the even share weighs most in the faintest lamp.
    for ratio in &per_power {
        assert!((ratio / per_power[0] - 1.0).abs() < 1e-3, "{per_power:?}");
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

/// Forty-eight triangles of a spiral, a third of them shining to both sides, some very bright, and a cluster of 40 in one
/// place.
fn many() -> Scene {
    let mut scene = Scene { name: "many".into(), ..Scene::default() };
    for k in 0..48 {
        let t = 0.5 + f64::from(k) * 0.3;
        let at = DVec3::new(t * t.cos(), 0.4 * t - 2.0, t * t.sin());
        let (e1, e2) = (DVec3::new(0.2, 0.1 * t.sin(), 0.0), DVec3::new(0.0, 0.1, 0.2 * t.cos()));
        let shape = Shape { positions: vec![at, at + e1, at + e2], triangles: vec![[0, 1, 2]], ..Shape::default() };
        let material = emitter([if k % 5 == 0 { 50.0 } else { 1.0 }; 3]);
        add(&mut scene, shape, Material { double_sided: k % 3 == 0, ..material });
    }
    // Something glossy, so that the tree looks at that, too.
    let shiny = Material { roughness: 0.3, ..Material::default() };
    add(&mut scene, Shape::parallelogram(DVec3::Z * -50.0, DVec3::X, DVec3::Y), shiny);
    add(&mut scene, Shape::icosphere(1).placed(0.1, DVec3::new(1.0, 0.5, -0.5)), emitter([2.0; 3]));
    scene.cameras = vec![pinhole(look_at(DVec3::ZERO, DVec3::Z, DVec3::Y), 60.0)];
    scene
}

/// Places that ask the tree: within the spiral, on a light, in the cluster, far away; facing anywhere, dull and glossy.
fn askers() -> Vec<Query> {
    let mut random = Random::new(3);
    let mut askers = Vec::new();
    let mut direction = || DVec3::from([0; 3].map(|_| 2.0 * f64::from(random.unit()) - 1.0)).normalize();
    for position in [[0.0; 3], [0.439, -1.8, 0.24], [1.0, 0.5, -0.5], [1.0, 0.61, -0.5], [300.0, 20.0, 1e4]] {
        for (both_sides, alpha, share) in [(0, 0.0, 0.0), (1, 0.3, 0.5), (0, 0.005, 0.96)] {
            let (normal, viewer) = (direction(), direction());
            let viewer = if viewer.dot(normal) < 0.0 { -viewer } else { viewer };
            let [normal, viewer] = [normal, viewer].map(|v| v.as_vec3().to_array());
            askers.push(Query { both_sides, normal, alpha, viewer, share, ..Query::with(position, 0, [0.5; 2]) });
        }
    }
    askers
}

/// Wherever it is asked for, a tree's choice of a light follows the probabilities that it tells, which add up to one, are
/// positive, and are the same from either end: from the descent that chooses, and from the light that a direction met.
#[test]
fn a_tree_chooses_as_it_tells() {
    let prepared = prepare(&many(), &Settings::new(8, 8));
    assert!(prepared.features.light_tree);
    let lights = 48 + 80;
    let n = 100_000;
    let askers = askers();
    let level = sidak_level(ALPHA, askers.len());
    for (k, asker) in askers.iter().enumerate() {
        let mut random = Random::new(100 + k as u64);
        let queries: Vec<_> =
            (0..n).map(|i| Query { choice: (random.bits() >> 32) as u32, light: i % lights, ..*asker }).collect();
        let results = probe(&prepared, "probe_light_tree", &queries);
        let told: Vec<f64> = results[..lights as usize].iter().map(|r| f64::from(r.other_pdf)).collect();
        let sum: f64 = told.iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "probabilities at {asker:?} add up to {sum}");
        assert!(told.iter().all(|&p| p > 0.0), "a light is left out at {asker:?}: {told:?}");
        let mut observed = vec![0u64; lights as usize];
        for r in &results {
            let light = r.distance as usize;
            observed[light] += 1;
            assert!((f64::from(r.pdf) / told[light] - 1.0).abs() < 1e-4, "light {light} at {asker:?}: {r:?}");
        }
        let expected: Vec<_> = told.iter().map(|p| p * f64::from(n)).collect();
        let test = chi_squared_test(&observed, &expected, 5.0).unwrap_or_else(|e| panic!("{e}"));
        println!(
            "asker {k}: the likeliest of {lights} lights {:.3}, χ² p = {:.4}",
            told.iter().fold(0.0, |a, &b| b.max(a)),
            test.p
        );
        assert!(test.p > level, "{observed:?} instead of {expected:?} at {asker:?}, p = {:.1e}", test.p);
    }
}

/// The ends of the range of choices give lights; and samples of the whole table carry the tree's probability.
#[test]
fn a_trees_samples_are_whole() {
    let mut scene = many();
    scene.lights.push(Light { name: String::new(), kind: LightKind::Point { position: POINT }, intensity: [0.3; 3] });
    let prepared = prepare(&scene, &Settings::new(8, 8));
    let choices = (0..=64u64).map(|k| (k << 26).min(u64::from(u32::MAX)) as u32).flat_map(|c| [c, c.wrapping_sub(1)]);
    let queries: Vec<_> = choices.flat_map(|choice| askers().into_iter().map(move |q| Query { choice, ..q })).collect();
    for s in probe(&prepared, "probe_light", &queries) {
        assert!(s.radiance.iter().all(|r| r.is_finite() && *r >= 0.0) && s.pdf.is_finite(), "{s:?}");
        assert!((Vec3::from(s.direction).length() - 1.0).abs() < 1e-5, "{s:?}");
    }
}

/// A large map leaves the choice of a texel few random bits, and among other lights fewer: a bright spot in a dark sky must still be
/// chosen as often as it should.
///
/// A million samples of the sky know its share, about 2/3, to 0.07 %: a bias of 0.33 % would be seen 9 times in 10.
#[test]
fn large_maps_are_sampled_fairly() {
    let (width, height) = (1024u32, 512u32);
    let bright = |x: u32, y: u32| (300..316).contains(&x) && (100..116).contains(&y);
    let mut scene = scene(&lamps());
    scene.environment =
        Some(map(width, height, |x, y| [if bright(x, y) { 50.0 } else { 0.001 + 0.002 * (x % 7) as f32 }; 3]));
    let settings = Settings { integrator: Integrator::Area, ..Settings::new(8, 8) };
    let prepared = prepare(&scene, &settings);
    let samples = probe(&prepared, "probe_light", &random_queries(POSITION, 2_000_000, 5));
    let skies: Vec<_> = samples.iter().filter(|s| s.distance > 1e30).map(Sample::direction).collect();
    // Inside the spot's edge, where what is told is one number.
    let texel = |d: &DVec3| {
        let u = 0.5 + d.z.atan2(d.x) / std::f64::consts::TAU;
        ((u * f64::from(width)) as u32, (d.y.acos() / std::f64::consts::PI * f64::from(height)) as u32)
    };
    let inside = |x: u32, y: u32| (301..315).contains(&x) && (101..115).contains(&y);
    let found = skies.iter().map(texel).filter(|&(x, y)| inside(x, y)).count();
    let mut share = 0.0;
    let centre = |x: u32, y: u32| {
        let turn = std::f64::consts::TAU * ((f64::from(x) + 0.5) / f64::from(width) - 0.5);
        let (sin, cos) = (std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(height)).sin_cos();
        DVec3::new(sin * turn.cos(), cos, sin * turn.sin())
    };
    for y in 101..115 {
        let told = probe(&prepared, "probe_environment_eval", &[Query::towards(centre(308, y))])[0].other_pdf;
        let edge = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(height)).cos();
        share += 14.0 * f64::from(told) * std::f64::consts::TAU / f64::from(width) * (edge(y) - edge(y + 1));
    }
    let n = skies.len() as f64;
    let z = (found as f64 - share * n) / (n * share * (1.0 - share)).sqrt();
    println!("{found} of {n} samples of the sky in the spot, {:.1} expected, z {z:+.2}", share * n);
    assert!(n > 500_000.0 && (0.3..0.9).contains(&share), "{n} samples, share {share}");
    assert!(z.abs() < 3.3, "{found} samples instead of {}, z = {z}", share * n);
}
