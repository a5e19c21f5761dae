//! A path tracer in f64 on the CPU, for diffuse scenes: shares no code with the renderer.
//!
//! The area form of the rendering equation: at each vertex a point on a lamp, chosen by area, is
//! connected; emission is added at the camera's first hit alone. Rays are tested against every
//! triangle (Möller & Trumbore 1997). Random numbers are SplitMix64's.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use surelight_film::{BatchSum, Film};
use surelight_scene::{Projection, Scene};

use crate::random::Random;

/// Paths end by roulette alone from here on; before, none does.
const ROULETTE_FROM: u32 = 4;

/// A ray starts this far off the surface that it leaves, in metres: f64 needs next to nothing.
const OFFSET: f64 = 1e-9;

struct Triangle {
    v0: DVec3,
    e1: DVec3,
    e2: DVec3,
    normal: DVec3,
    area: f64,
    albedo: DVec3,
    emission: DVec3,
    two_sided: bool,
}

/// A scene of Lambertian surfaces that emit or reflect, with a pinhole camera.
pub struct PathOracle {
    triangles: Vec<Triangle>,
    /// Indices of emitters, each with the sum of areas up to it.
    lamps: Vec<(usize, f64)>,
    eye: DVec3,
    /// Right, up and forwards; the sides as long as half the picture at distance 1.
    frame: [DVec3; 3],
}

impl PathOracle {
    /// Of the scene through its first camera, for a picture of width/height `aspect`.
    pub fn new(scene: &Scene, aspect: f64) -> Self {
        let mut triangles = Vec::new();
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh];
            let material = &scene.materials[mesh.material];
            let vec = |c: [f32; 3]| DVec3::from(c.map(f64::from));
            for t in &mesh.triangles {
                let [v0, v1, v2] = t.map(|i| instance.to_world.transform_point3(mesh.positions[i as usize].as_dvec3()));
                let (e1, e2) = (v1 - v0, v2 - v0);
                let cross = e1.cross(e2);
                let [r, g, b, _] = material.base_color;
                triangles.push(Triangle {
                    v0,
                    e1,
                    e2,
                    normal: cross.normalize(),
                    area: cross.length() / 2.0,
                    albedo: vec([r, g, b]),
                    emission: vec(material.emissive),
                    two_sided: material.double_sided,
                });
            }
        }
        let (mut lamps, mut total) = (Vec::new(), 0.0);
        for (i, t) in triangles.iter().enumerate().filter(|(_, t)| t.emission != DVec3::ZERO) {
            total += t.area;
            lamps.push((i, total));
        }
        let camera = &scene.cameras[0];
        let Projection::Perspective { yfov, .. } = camera.projection else { panic!("the oracle knows pinholes") };
        let up = (yfov / 2.0).tan();
        let turn = |v| camera.to_world.transform_vector3(v);
        let frame = [turn(DVec3::X) * up * aspect, turn(DVec3::Y) * up, turn(DVec3::NEG_Z)];
        Self { triangles, lamps, eye: camera.to_world.translation, frame }
    }

    /// The nearest triangle before `t_max`, and its distance.
    fn closest(&self, o: DVec3, d: DVec3, t_max: f64) -> Option<(f64, &Triangle)> {
        let mut best = (t_max, None);
        for triangle in &self.triangles {
            let p = d.cross(triangle.e2);
            let det = triangle.e1.dot(p);
            let s = o - triangle.v0;
            let u = s.dot(p) / det;
            let q = s.cross(triangle.e1);
            let (v, t) = (d.dot(q) / det, triangle.e2.dot(q) / det);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < best.0 {
                best = (t, Some(triangle));
            }
        }
        best.1.map(|triangle| (best.0, triangle))
    }

    /// Light from a random point on a lamp, reflected at `x` with normal `n`, without the albedo.
    fn direct(&self, x: DVec3, n: DVec3, random: &mut Random) -> DVec3 {
        let Some(&(_, total)) = self.lamps.last() else { return DVec3::ZERO };
        let pick = unit(random) * total;
        let at = self.lamps.partition_point(|&(_, sum)| sum <= pick).min(self.lamps.len() - 1);
        let lamp = &self.triangles[self.lamps[at].0];
        let (root, v) = (unit(random).sqrt(), unit(random));
        let point = lamp.v0 + lamp.e1 * (root * (1.0 - v)) + lamp.e2 * (root * v);
        let to = point - x;
        let distance = to.length();
        let d = to / distance;
        let (cos_x, cos_y) = (n.dot(d), -lamp.normal.dot(d));
        if cos_x <= 0.0 || (cos_y <= 0.0 && !lamp.two_sided) {
            return DVec3::ZERO;
        }
        match self.closest(x, d, distance * (1.0 - 1e-9)) {
            Some(_) => DVec3::ZERO,
            None => lamp.emission * (cos_x * cos_y.abs() * total / (PI * distance * distance)),
        }
    }

    /// One path's radiance.
    fn sample(&self, mut o: DVec3, mut d: DVec3, random: &mut Random) -> DVec3 {
        let (mut radiance, mut throughput) = (DVec3::ZERO, DVec3::ONE);
        for bounce in 0.. {
            let Some((t, triangle)) = self.closest(o, d, f64::INFINITY) else { break };
            let front = triangle.normal.dot(d) < 0.0;
            if bounce == 0 && (front || triangle.two_sided) {
                radiance += triangle.emission;
            }
            let n = if front { triangle.normal } else { -triangle.normal };
            let x = o + d * t + n * OFFSET;
            throughput *= triangle.albedo;
            if bounce >= ROULETTE_FROM {
                let survival = throughput.max_element().min(1.0);
                if unit(random) >= survival {
                    break;
                }
                throughput /= survival;
            }
            if throughput == DVec3::ZERO {
                break;
            }
            radiance += throughput * self.direct(x, n, random);
            // By the cosine: a point of the unit sphere about the normal's tip.
            let (z, phi) = (1.0 - 2.0 * unit(random), TAU * unit(random));
            let r = (1.0 - z * z).max(0.0).sqrt();
            d = (n + DVec3::new(r * phi.cos(), r * phi.sin(), z)).normalize();
            o = x;
        }
        radiance
    }

    /// A picture of independent batches. A batch is a sample in each of `cells`² parts of the
    /// pixel.
    pub fn render(&self, size: [u32; 2], batches: u32, cells: u32, seed: u64) -> Film {
        let mut film = Film::new(size[0], size[1]);
        let count = size[0] * size[1];
        let pixels: Vec<u32> = (0..count).collect();
        for batch in 0..batches {
            let mut sums = Vec::with_capacity(pixels.len());
            for &pixel in &pixels {
                let key = (u64::from(batch) * u64::from(count) + u64::from(pixel)) ^ (seed << 40);
                // Twice, since neighbouring seeds of SplitMix64 give shifted copies of one
                // sequence.
                let mut random = Random::new(Random::new(key).bits());
                let (mut sum, mut largest, mut squares) = (DVec3::ZERO, 0.0_f64, 0.0);
                for k in 0..cells * cells {
                    let at = |i: u32, n: u32, u: f64| 2.0 * (f64::from(i) + u) / f64::from(n) - 1.0;
                    let jitter = |cell: u32, u: f64| (f64::from(cell) + u) / f64::from(cells);
                    let x = at(pixel % size[0], size[0], jitter(k % cells, unit(&mut random)));
                    let y = at(pixel / size[0], size[1], jitter(k / cells, unit(&mut random)));
                    let [right, up, forward] = self.frame;
                    let d = (forward + right * x - up * y).normalize();
                    let value = self.sample(self.eye, d, &mut random);
                    let brightness = value.dot(DVec3::new(0.2126, 0.7152, 0.0722));
                    sum += value;
                    largest = largest.max(brightness);
                    squares += brightness * brightness;
                }
                sums.push(BatchSum::new(sum.as_vec3().to_array(), largest as f32, squares as f32));
            }
            film.add_batch(cells * cells, &pixels, &sums).unwrap_or_else(|e| panic!("{e}"));
        }
        film
    }
}

/// In [0, 1), 53 bits.
fn unit(random: &mut Random) -> f64 {
    (random.bits() >> 11) as f64 / (1u64 << 53) as f64
}
