//! What every generated scene must be, and the closed forms that can be checked without rendering.

use std::f64::consts::PI;

use glam::DVec3;

use super::shapes::Shape;
use super::*;
use crate::Mesh;

fn corners(mesh: &Mesh, t: [u32; 3]) -> [DVec3; 3] {
    t.map(|i| mesh.positions[i as usize].as_dvec3())
}

/// World triangles with their material.
fn triangles(scene: &Scene) -> Vec<([DVec3; 3], usize)> {
    let mut out = Vec::new();
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        for &t in &mesh.triangles {
            out.push((corners(mesh, t).map(|p| instance.to_world.transform_point3(p)), mesh.material));
        }
    }
    out
}

fn hits([a, b, c]: [DVec3; 3], from: DVec3, to: DVec3) -> bool {
    let (e1, e2, d) = (b - a, c - a, to - from);
    let p = d.cross(e2);
    let det = e1.dot(p);
    if det == 0.0 {
        return false;
    }
    let s = from - a;
    let u = s.dot(p) / det;
    let q = s.cross(e1);
    let v = d.dot(q) / det;
    let t = e2.dot(q) / det;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-6 && t < 1.0 - 1e-6
}

#[test]
fn gallery_keeps_the_promises_of_the_data_model() {
    for entry in GALLERY {
        let scene = (entry.build)();
        assert_eq!(scene.name, entry.name);
        assert!(scene.has_light() && scene.cameras.len() == 1, "{}", entry.name);
        for instance in &scene.instances {
            assert!(instance.mesh < scene.meshes.len());
        }
        for mesh in &scene.meshes {
            let n = mesh.positions.len();
            assert!(mesh.material < scene.materials.len());
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
            assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < n));
            if let Some(normals) = &mesh.normals {
                assert!(normals.len() == n && normals.iter().all(|v| (v.length() - 1.0).abs() < 1e-6));
            }
            if let Some(tangents) = &mesh.tangents {
                assert!(tangents.iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-6));
            }
            assert!(mesh.uvs.iter().all(|uv| uv.len() == n));
            for &t in &mesh.triangles {
                let [a, b, c] = corners(mesh, t);
                let normal = (b - a).cross(c - a);
                assert!(normal.length() > 0.0, "{}: {} has a triangle of no area", entry.name, mesh.name);
                if let Some(normals) = &mesh.normals {
                    let shading: glam::Vec3 = t.map(|i| normals[i as usize]).into_iter().sum();
                    assert!(shading.as_dvec3().dot(normal) > 0.0, "{}: {} is turned over", entry.name, mesh.name);
                }
            }
        }
        for material in &scene.materials {
            let unit = |x: f32| (0.0..=1.0).contains(&x);
            assert!(material.base_color.iter().all(|&c| unit(c)) && unit(material.metallic));
            assert!(unit(material.roughness) && unit(material.transmission));
        }
        for (a, b) in scene.meshes.iter().zip(&(entry.build)().meshes) {
            assert_eq!(a, b, "{} differs from run to run", entry.name);
        }
    }
}

#[test]
fn shapes_are_closed_and_face_outwards() {
    let ball_volume = |n: u32| {
        // Volume by the divergence theorem: negative when turned over.
        let s = Shape::icosphere(n);
        assert_eq!(s.triangles.len(), 20 << (2 * n));
        volume(&s)
    };
    let exact = 4.0 * PI / 3.0;
    let (v3, v4) = (ball_volume(3), ball_volume(4));
    assert!(v3 < v4 && v4 < exact);
    // The error falls by four with each subdivision.
    assert!(((exact - v3) / (exact - v4) - 4.0).abs() < 0.05);
    assert!((volume(&Shape::uv_sphere(128, 64)) / exact - 1.0).abs() < 2e-3);
    let cuboid = Shape::cuboid(DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 2.5));
    assert!((volume(&cuboid) - 3.0).abs() < 1e-12);
    assert!((cuboid.area() - 2.0 * (6.0 + 1.0 + 1.5)).abs() < 1e-12);
    assert!((volume(&cuboid.turned_over()) + 3.0).abs() < 1e-12);
    let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(x, z)| DVec3::new(x, 0.0, z));
    assert!((volume(&Shape::prism(square, 2.0)) - 2.0).abs() < 1e-12);
    let mirrored = Shape::icosphere(1).transformed(&glam::DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0)));
    assert!(volume(&mirrored) > 0.0);
    let disc = Shape::disc(64);
    assert!((disc.area() - 32.0 * (PI / 32.0).sin()).abs() < 1e-12);
    let first = disc.triangles[0].map(|i| disc.positions[i as usize]);
    assert!((first[1] - first[0]).cross(first[2] - first[0]).y > 0.0);
}

fn volume(s: &Shape) -> f64 {
    s.triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| s.positions[i as usize]);
            a.dot(b.cross(c)) / 6.0
        })
        .sum()
}

#[test]
fn polygon_irradiance_matches_quadrature() {
    let polygon = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, z)| DVec3::new(x, 1.0, z));
    let point = DVec3::new(0.3, 0.0, 0.2);
    let n = 400;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n) - 0.5;
            let d = DVec3::new(at(i), 1.0, at(j)) - point;
            sum += 1.0 / d.length_squared().powi(2);
        }
    }
    let quadrature = sum / f64::from(n * n);
    let exact = polygon_irradiance(point, DVec3::Y, &polygon);
    assert!((exact / quadrature - 1.0).abs() < 1e-5, "{exact} against {quadrature}");
}

#[test]
fn cornell_box_faces_the_camera() {
    let scene = cornell_box::cornell_box();
    assert_eq!(scene.triangle_count(), 38);
    let inside = DVec3::new(0.0, 0.3, -0.28);
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        let block = mesh.name.ends_with("block");
        let middle = mesh.positions.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / mesh.positions.len() as f64;
        for &t in &mesh.triangles {
            let [a, b, c] = corners(mesh, t);
            let normal = (b - a).cross(c - a);
            let towards = if block { a - middle } else { inside - a };
            assert!(normal.dot(towards) > 0.0, "{} is turned over", mesh.name);
        }
    }
    // Red on the left of the picture: the camera looks along −Z with +X to the right.
    let left = &scene.meshes.iter().find(|m| m.name == "left wall").unwrap().positions;
    assert!(left.iter().all(|p| p.x < 0.0));
    assert!((scene.cameras[0].to_world.matrix3.z_axis - DVec3::Z).length() < 1e-12);
}

#[test]
fn cornell_box_probe_sees_the_whole_lamp() {
    let scene = cornell_box::cornell_box();
    let lamp = cornell_box::lamp();
    let blockers: Vec<_> = triangles(&scene);
    for i in 0..=20 {
        for j in 0..=20 {
            let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
            let target = lamp[0] + (lamp[1] - lamp[0]) * u + (lamp[3] - lamp[0]) * v;
            assert!(!blockers.iter().any(|(t, _)| hits(*t, cornell_box::PROBE, target)));
        }
    }
    let area = (lamp[1] - lamp[0]).length() * (lamp[3] - lamp[0]).length();
    let power = cornell_box::RADIANCE.map(|l| (PI * f64::from(l) * area * 1e3).round() / 1e3);
    assert_eq!(power, [0.729, 0.515, 0.172]);
}

#[test]
fn furnace_balances_on_every_surface() {
    for scene in [furnace::furnace(), furnace::bare_room()] {
        for m in &scene.materials {
            for c in 0..3 {
                assert_eq!(m.emissive[c] / (1.0 - m.base_color[c]), furnace::RADIANCE[c]);
            }
        }
    }
    assert_eq!(furnace::after_bounces(0)[0], 0.25);
    assert!((furnace::after_bounces(40)[2] - 0.125).abs() < 1e-12);
}
