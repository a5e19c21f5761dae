//! Triangle shapes, put together in f64 and rounded to f32 once, so that they come out alike on
//! every platform.

use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec4};
use rayon::prelude::*;
use surelight_scene::Mesh;

/// Triangles under construction; counter-clockwise from the front, as glTF has it.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// Unit vertex normals; empty means flat.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, v pointing down; empty when there are none.
    pub uvs: Vec<DVec2>,
    /// Unit tangents: where u grows. Empty when there are none.
    pub tangents: Vec<DVec3>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    /// A convex quadrilateral by its corners, counter-clockwise from the front, beginning at the
    /// lower left: two triangles, flat, with (u, v) from (0, 1) at the first corner to (1, 0) at
    /// the third.
    pub fn quad(corners: [DVec3; 4]) -> Self {
        let tangent = (corners[1] - corners[0]).normalize();
        Self {
            positions: corners.to_vec(),
            normals: Vec::new(),
            uvs: vec![DVec2::new(0.0, 1.0), DVec2::ONE, DVec2::new(1.0, 0.0), DVec2::ZERO],
            tangents: vec![tangent; 4],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        }
    }

    /// A parallelogram centred at `center`; its front is where `half_u` × `half_v` points.
    pub fn parallelogram(center: DVec3, half_u: DVec3, half_v: DVec3) -> Self {
        Self::quad([
            center - half_u - half_v,
            center + half_u - half_v,
            center + half_u + half_v,
            center - half_u + half_v,
        ])
    }

    /// A rectangle with level upper and lower edges about `center`, its front towards `target`
    /// (which must not lie straight above or below).
    pub fn panel(center: DVec3, target: DVec3, half_width: f64, half_height: f64) -> Self {
        let normal = (target - center).normalize();
        let side = DVec3::Y.cross(normal).normalize();
        Self::parallelogram(center, side * half_width, normal.cross(side) * half_height)
    }

    /// An axis-aligned box, its front outside: 12 flat triangles over 24 vertices.
    pub fn cuboid(lo: DVec3, hi: DVec3) -> Self {
        let center = (lo + hi) * 0.5;
        let half = (hi - lo) * 0.5;
        let mut shape = Self::default();
        for axis in 0..3 {
            let [n, u, v] = [0, 1, 2].map(|k| {
                let mut e = DVec3::ZERO;
                e[(axis + k) % 3] = half[(axis + k) % 3];
                e
            });
            shape.append(Self::parallelogram(center + n, u, v));
            shape.append(Self::parallelogram(center - n, v, u));
        }
        shape
    }

    /// A block with a flat top and a flat bottom, by the four corners of its bottom
    /// (counter-clockwise from above) and its height: 12 flat triangles, front outside.
    pub fn prism(bottom: [DVec3; 4], height: f64) -> Self {
        let top = bottom.map(|p| p + DVec3::Y * height);
        let mut shape = Self::quad(top);
        for i in 0..4 {
            let j = (i + 1) % 4;
            shape.append(Self::quad([bottom[i], bottom[j], top[j], top[i]]));
        }
        shape.append(Self::quad([bottom[3], bottom[2], bottom[1], bottom[0]]));
        shape
    }

    /// The unit sphere from an icosahedron, each triangle cut into four `subdivisions` times:
    /// 20·4^k triangles whose vertices lie on the sphere, smooth normals, front outside.
    pub fn icosphere(subdivisions: u32) -> Self {
        let g = (1.0 + 5f64.sqrt()) / 2.0;
        let mut points: Vec<DVec3> = Vec::new();
        for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
            points.extend([DVec3::new(0.0, a, b), DVec3::new(a, b, 0.0), DVec3::new(b, 0.0, a)]);
        }
        // Faces are the triples of mutually nearest vertices (edge length 2), turned outwards.
        let near = |i: usize, j: usize| (points[i].distance(points[j]) - 2.0).abs() < 1e-9;
        let mut triangles = Vec::new();
        for i in 0..12 {
            for j in i + 1..12 {
                for k in j + 1..12 {
                    if near(i, j) && near(j, k) && near(i, k) {
                        let outward = (points[j] - points[i]).cross(points[k] - points[i]).dot(points[i]) > 0.0;
                        let (j, k) = if outward { (j, k) } else { (k, j) };
                        triangles.push([i as u32, j as u32, k as u32]);
                    }
                }
            }
        }
        let mut points: Vec<DVec3> = points.into_iter().map(DVec3::normalize).collect();
        for _ in 0..subdivisions {
            let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    points.len() as u32 - 1
                })
            };
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]| {
                    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                })
                .collect();
        }
        Self { normals: points.clone(), positions: points, triangles, ..Self::default() }
    }

    /// The unit sphere by longitude and latitude, with (u, v): u once around from −X over +Z... to
    /// −X, v from the north pole (+Y) down. Front outside, smooth normals, tangents.
    pub fn uv_sphere(slices: u32, stacks: u32) -> Self {
        let mut shape = Self::default();
        for j in 0..=stacks {
            for i in 0..=slices {
                let (u, v) = (f64::from(i) / f64::from(slices), f64::from(j) / f64::from(stacks));
                let (sin_phi, cos_phi) = (u * TAU).sin_cos();
                let (sin_theta, cos_theta) = (v * PI).sin_cos();
                let n = DVec3::new(-sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
                shape.positions.push(n);
                shape.normals.push(n);
                shape.uvs.push(DVec2::new(u, v));
                shape.tangents.push(DVec3::new(sin_phi, 0.0, cos_phi));
            }
        }
        let at = |i: u32, j: u32| j * (slices + 1) + i;
        for j in 0..stacks {
            for i in 0..slices {
                if j > 0 {
                    shape.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
                }
                if j + 1 < stacks {
                    shape.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
                }
            }
        }
        shape
    }

    /// The unit disc in the plane y = 0, front towards +Y, as a fan of `segments` triangles: a
    /// regular polygon.
    pub fn disc(segments: u32) -> Self {
        let mut shape = Self { positions: vec![DVec3::ZERO], ..Self::default() };
        for i in 0..segments {
            let (sin, cos) = (f64::from(i) / f64::from(segments) * TAU).sin_cos();
            shape.positions.push(DVec3::new(cos, 0.0, -sin));
            shape.triangles.push([0, i + 1, (i + 1) % segments + 1]);
        }
        shape
    }

    /// A floor at y = 0 that curves up into a wall, as photographers use it: from z = `front` to
    /// z = −`back`, the bend of radius `bend`, the wall up to `height`, from x = −`half_width` to
    /// `half_width`. Front above and before it.
    pub fn cyclorama(half_width: f64, front: f64, back: f64, bend: f64, height: f64) -> Self {
        let steps = 24;
        let mut profile = vec![(DVec3::new(0.0, 0.0, front), DVec3::Y)];
        for i in 0..=steps {
            let (sin, cos) = (f64::from(i) / f64::from(steps) * FRAC_PI_2).sin_cos();
            let normal = DVec3::new(0.0, cos, sin);
            profile.push((DVec3::new(0.0, bend, bend - back) - normal * bend, normal));
        }
        profile.push((DVec3::new(0.0, height, -back), DVec3::Z));
        let mut shape = Self::default();
        for (point, normal) in profile {
            for side in [-half_width, half_width] {
                shape.positions.push(point + DVec3::X * side);
                shape.normals.push(normal);
            }
        }
        for i in 0..shape.positions.len() as u32 / 2 - 1 {
            let [a, b, c, d] = [0, 1, 3, 2].map(|k| 2 * i + k);
            shape.triangles.extend([[a, b, c], [a, c, d]]);
        }
        shape
    }

    /// A symmetric biconvex lens about the y axis: two spherical caps of curvature radius
    /// `curvature` that meet in a sharp rim of radius `aperture`. Closed, front outside, normals of
    /// the spheres.
    pub fn lens(curvature: f64, aperture: f64, rings: u32, segments: u32) -> Self {
        let edge = (aperture / curvature).asin();
        let depth = curvature * edge.cos();
        let mut cap = Self::default();
        let mut push = |normal: DVec3| {
            cap.positions.push(normal * curvature - DVec3::Y * depth);
            cap.normals.push(normal);
        };
        push(DVec3::Y);
        for ring in 1..=rings {
            let (sin, cos) = (edge * f64::from(ring) / f64::from(rings)).sin_cos();
            for i in 0..segments {
                let (s, c) = (f64::from(i) / f64::from(segments) * TAU).sin_cos();
                push(DVec3::new(sin * c, cos, -sin * s));
            }
        }
        for ring in 0..rings {
            for i in 0..segments {
                let j = (i + 1) % segments;
                let at = |ring: u32, i: u32| if ring == 0 { 0 } else { 1 + (ring - 1) * segments + i };
                let [a, b, c, d] = [at(ring, i), at(ring + 1, i), at(ring + 1, j), at(ring, j)];
                cap.triangles.push([a, b, c]);
                if ring > 0 {
                    cap.triangles.push([a, c, d]);
                }
            }
        }
        // The rim lies in y = 0 exactly, so that the mirrored cap joins it without a gap.
        let rim = cap.positions.len() - segments as usize;
        cap.positions[rim..].iter_mut().for_each(|p| p.y = 0.0);
        let below = cap.clone().transformed(&DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)));
        cap.append(below);
        cap
    }

    /// A height field over [−1, 1]² in x and z: 2·`n`² triangles, front towards +Y. `smooth` gives
    /// normals, by central differences of `height` over half a cell to each side.
    pub fn height_field(n: u32, smooth: bool, height: impl Fn(f64, f64) -> f64 + Sync) -> Self {
        let step = 2.0 / f64::from(n);
        let coordinate = |i: u32| -1.0 + step * f64::from(i);
        let point = |k: u32| (coordinate(k % (n + 1)), coordinate(k / (n + 1)));
        let vertices = 0..(n + 1) * (n + 1);
        let positions = vertices.clone().into_par_iter().map(|k| {
            let (x, z) = point(k);
            DVec3::new(x, height(x, z), z)
        });
        let normals = vertices.into_par_iter().map(|k| {
            let (x, z) = point(k);
            let h = step * 0.5;
            let slope_x = (height(x + h, z) - height(x - h, z)) / (2.0 * h);
            let slope_z = (height(x, z + h) - height(x, z - h)) / (2.0 * h);
            DVec3::new(-slope_x, 1.0, -slope_z).normalize()
        });
        let triangles = (0..n).flat_map(|j| {
            (0..n).flat_map(move |i| {
                let a = j * (n + 1) + i;
                let [b, c, d] = [a + 1, a + n + 2, a + n + 1];
                [[a, d, c], [a, c, b]]
            })
        });
        Self {
            positions: positions.collect(),
            normals: if smooth { normals.collect() } else { Vec::new() },
            triangles: triangles.collect(),
            ..Self::default()
        }
    }

    /// A profile of (radius, height) turned once around the y axis. Front to the right of the
    /// profile's direction: a profile that runs up has its front outside. Smooth normals, split
    /// where the profile bends by more than 40°; u once around, v along the profile, 1 at its first
    /// point; tangents around the axis.
    pub fn revolved(profile: &[DVec2], segments: u32) -> Self {
        let direction = |i: usize| (profile[i + 1] - profile[i]).normalize();
        let last = profile.len() - 1;
        // Rows of vertices: a point of the profile and the normal there. A crease has two rows.
        let mut rows: Vec<(usize, DVec2)> = Vec::new();
        for i in 0..=last {
            let before = direction(i.max(1) - 1);
            let after = direction(i.min(last - 1));
            let normal = |d: DVec2| DVec2::new(d.y, -d.x);
            if before.dot(after) < 40f64.to_radians().cos() {
                rows.push((i, normal(before)));
                rows.push((i, normal(after)));
            } else {
                rows.push((i, normal((before + after).normalize())));
            }
        }
        let mut shape = Self::default();
        for &(point, normal) in &rows {
            for column in 0..=segments {
                // The last column lies exactly on the first.
                let angle = f64::from(column % segments) / f64::from(segments) * TAU;
                let (sin, cos) = angle.sin_cos();
                let around = |p: DVec2| DVec3::new(p.x * cos, p.y, -p.x * sin);
                shape.positions.push(around(profile[point]));
                shape.normals.push(around(normal));
                let (u, v) = (f64::from(column) / f64::from(segments), 1.0 - point as f64 / last as f64);
                shape.uvs.push(DVec2::new(u, v));
                shape.tangents.push(DVec3::new(-sin, 0.0, -cos));
            }
        }
        for (row, pair) in rows.windows(2).enumerate() {
            let (lower, upper) = (pair[0].0, pair[1].0);
            if lower == upper {
                continue;
            }
            for column in 0..segments {
                let a = row as u32 * (segments + 1) + column;
                let [b, c, d] = [a + 1, a + segments + 2, a + segments + 1];
                if profile[lower].x > 0.0 {
                    shape.triangles.push([a, b, c]);
                }
                if profile[upper].x > 0.0 {
                    shape.triangles.push([a, c, d]);
                }
            }
        }
        shape
    }

    /// The surface `point`(u, v) over [0, 1]², `columns` × `rows` cells; front where ∂u × ∂v
    /// points. Normals and tangents by central differences, texture coordinates (u, 1 − v).
    pub fn sheet(columns: u32, rows: u32, point: impl Fn(f64, f64) -> DVec3) -> Self {
        let step = 0.25 / f64::from(columns.max(rows));
        let mut shape = Self::default();
        for j in 0..=rows {
            for i in 0..=columns {
                let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
                let along_u = point(u + step, v) - point(u - step, v);
                let along_v = point(u, v + step) - point(u, v - step);
                shape.positions.push(point(u, v));
                shape.normals.push(along_u.cross(along_v).normalize());
                shape.uvs.push(DVec2::new(u, 1.0 - v));
                shape.tangents.push(along_u.normalize());
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = j * (columns + 1) + i;
                let [b, c, d] = [a + 1, a + columns + 2, a + columns + 1];
                shape.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        shape
    }

    /// Placed by `m`. A mirror turns the triangles over, so that the front stays outside.
    #[must_use]
    pub fn transformed(mut self, m: &DAffine3) -> Self {
        let normal = m.matrix3.inverse().transpose();
        self.positions.iter_mut().for_each(|p| *p = m.transform_point3(*p));
        self.normals.iter_mut().for_each(|n| *n = (normal * *n).normalize());
        self.tangents.iter_mut().for_each(|t| *t = m.transform_vector3(*t).normalize());
        if m.matrix3.determinant() < 0.0 {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self
    }

    /// Scaled about the origin, then moved.
    #[must_use]
    pub fn placed(self, scale: f64, at: DVec3) -> Self {
        self.transformed(&DAffine3::from_scale_rotation_translation(DVec3::splat(scale), glam::DQuat::IDENTITY, at))
    }

    /// Inside out: the front is where the back was.
    #[must_use]
    pub fn turned_over(mut self) -> Self {
        self.normals.iter_mut().for_each(|n| *n = -*n);
        self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        self
    }

    /// Without vertex normals: every triangle flat.
    #[must_use]
    pub fn faceted(mut self) -> Self {
        self.normals.clear();
        self
    }

    /// Positions only: no texture coordinates, no tangents.
    #[must_use]
    pub fn bare(mut self) -> Self {
        self.uvs.clear();
        self.tangents.clear();
        self
    }

    /// Adds another shape with the same attributes.
    pub fn append(&mut self, other: Self) {
        let base = self.positions.len() as u32;
        self.positions.extend(other.positions);
        self.normals.extend(other.normals);
        self.uvs.extend(other.uvs);
        self.tangents.extend(other.tangents);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + base)));
    }

    /// Sum of the triangles' areas.
    pub fn area(&self) -> f64 {
        self.triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| self.positions[i as usize]);
                (b - a).cross(c - a).length() * 0.5
            })
            .sum()
    }

    /// Rounded to f32, with tangents on request only (materials with a normal map need them).
    pub fn into_mesh(mut self, name: &str, material: usize, tangents: bool) -> Mesh {
        let count = self.positions.len();
        if tangents && self.normals.is_empty() {
            // glTF heeds tangents only beside normals. Flat shapes with tangents share no vertex
            // between faces.
            self.normals = vec![DVec3::ZERO; count];
            for t in &self.triangles {
                let [a, b, c] = t.map(|i| self.positions[i as usize]);
                t.iter().for_each(|&i| self.normals[i as usize] = (b - a).cross(c - a).normalize());
            }
        }
        debug_assert!([self.normals.len(), self.uvs.len(), self.tangents.len()].iter().all(|&n| n == 0 || n == count));
        Mesh {
            name: name.to_owned(),
            positions: self.positions.iter().map(|v| v.as_vec3()).collect(),
            triangles: self.triangles,
            normals: (!self.normals.is_empty()).then(|| self.normals.iter().map(|v| v.as_vec3()).collect()),
            tangents: (tangents && !self.tangents.is_empty())
                .then(|| self.tangents.iter().map(|t| t.as_vec3().extend(1.0)).collect::<Vec<Vec4>>()),
            uvs: if self.uvs.is_empty() {
                Vec::new()
            } else {
                vec![self.uvs.iter().map(|v| v.as_vec2()).collect::<Vec<Vec2>>()]
            },
            colors: None,
            material,
        }
    }
}
