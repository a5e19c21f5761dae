//! Lights of every kind for the tests, and a sample's choice among them.

use glam::{DVec3, Vec3};
use surelight_prepare::Prepared;
use surelight_scene::{Light, LightKind, Scene};
use surelight_scenes::shapes::Shape;
use surelight_tests::light::{Query, Sample, probe, random_queries};
use surelight_tests::scenes::{add, emitter, lambert, look_at, map, pinhole};

pub(crate) const SAMPLES: usize = 1_000_000;
/// The receiving point: in front of all the lamps.
pub(crate) const POSITION: [f32; 3] = [0.1, -0.2, 0.3];
/// How the surface there faces.
pub(crate) const NORMAL: Vec3 = Vec3::new(0.48, 0.36, 0.8);

/// A lamp of the test: corners relative to the camera at the origin, and radiance.
pub(crate) struct Lamp {
    pub(crate) corners: [DVec3; 3],
    pub(crate) radiance: [f32; 3],
    /// Of two triangles.
    pub(crate) square: bool,
}

impl Lamp {
    pub(crate) fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).length() * if self.square { 1.0 } else { 0.5 }
    }

    /// One of 16 parts, alike in area.
    pub(crate) fn part(&self, b1: f64, b2: f64) -> usize {
        let cell = |b: f64| ((4.0 * b) as usize).min(3);
        if self.square { 4 * cell(b1.max(0.0)) + cell(b2.max(0.0)) } else { part(b1, b2) }
    }
}

/// Triangles of very different power, turned towards the origin; the first two of them one square.
pub(crate) fn lamps() -> Vec<Lamp> {
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

pub(crate) const POINT: DVec3 = DVec3::new(1.5, -1.0, 2.5);

pub(crate) fn scene(lamps: &[Lamp]) -> Scene {
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

/// A sample's choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Chosen {
    /// A lamp, with the barycentric weights of the point.
    Lamp(usize, f64, f64),
    Point,
    Environment,
}

pub(crate) fn chosen(lamps: &[Lamp], s: &Sample) -> Chosen {
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
pub(crate) fn part(b1: f64, b2: f64) -> usize {
    let (x, y) = ((4.0 * b1.clamp(0.0, 1.0 - 1e-9)), (4.0 * b2.clamp(0.0, 1.0 - 1e-9)));
    let (i, j) = (x as usize, y as usize);
    let upper = x.fract() + y.fract() > 1.0 && i + j < 3;
    // Rows of 7, 5, 3 and 1 small triangles.
    let row = [0, 7, 12, 15][j.min(3)];
    (row + 2 * i.min(3 - j.min(3)) + usize::from(upper)).min(15)
}

/// Solid-angle pdf as area pdf.
pub(crate) fn area_pdf(lamp: &Lamp, s: &Sample) -> f64 {
    let [a, b, c] = lamp.corners;
    let n = (b - a).cross(c - a).normalize();
    let p = DVec3::from(s.target.map(f64::from)) - DVec3::from(POSITION.map(f64::from));
    f64::from(s.pdf) * n.dot(p.normalize()).abs() / p.length_squared()
}

/// Lamps, one of them a square of two triangles.
pub(crate) fn with_square(mut lamps: Vec<Lamp>, corners: [DVec3; 3]) -> Vec<Lamp> {
    lamps.push(Lamp { corners, radiance: [2.0, 3.0, 1.0], square: true });
    lamps
}

/// Samples of the table, and the choice of each. Light from behind contributes, too.
pub(crate) fn samples_of(lamps: &[Lamp], prepared: &Prepared, seed: u64) -> Vec<(Sample, Chosen)> {
    let queries: Vec<_> = random_queries(POSITION, SAMPLES, seed)
        .into_iter()
        .map(|query| Query { both_sides: 1, normal: NORMAL.to_array(), ..query })
        .collect();
    probe(prepared, "probe_light", &queries).into_iter().map(|s| (s, chosen(lamps, &s))).collect()
}
