//! Invariants of every generated scene, and the closed forms that can be checked without rendering.

use std::f64::consts::PI;

use glam::DVec3;
use surelight_scene::{EnvironmentMap, Mesh};

use super::shapes::Shape;
use super::*;

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
        assert_eq!(scene.validate(), Ok(()), "{}", entry.name);
        for mesh in &scene.meshes {
            assert!(mesh.positions.iter().all(|p| p.is_finite()));
            if let Some(normals) = &mesh.normals {
                assert!(normals.iter().all(|v| (v.length() - 1.0).abs() < 1e-6));
            }
            if let Some(tangents) = &mesh.tangents {
                assert!(tangents.iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-6));
            }
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
    // Red on the left of the picture: the view direction is −Z with +X to the right.
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

#[test]
fn lens_is_closed_and_has_the_volume_of_two_caps() {
    let (curvature, aperture) = (0.55f64, 0.3f64);
    let h = curvature - (curvature * curvature - aperture * aperture).sqrt();
    let caps = 2.0 * PI * h * h * (3.0 * curvature - h) / 3.0;
    let lens = Shape::lens(curvature, aperture, 32, 256);
    assert!((volume(&lens) / caps - 1.0).abs() < 1e-3);
    // Closed: every directed edge has its opposite, by position (the two caps have separate
    // vertices).
    let key = |i: u32| lens.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
    let edges: std::collections::HashSet<_> =
        lens.triangles.iter().flat_map(|&[a, b, c]| [(key(a), key(b)), (key(b), key(c)), (key(c), key(a))]).collect();
    assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
}

#[test]
fn veach_lights_have_equal_power_and_plates_mirror_them() {
    let scene = veach_mis::veach_mis();
    let eye = scene.cameras[0].to_world.translation;
    let mut lights = 0;
    for mesh in &scene.meshes {
        let material = &scene.materials[mesh.material];
        if material.is_emissive() {
            lights += 1;
            let area: f64 = mesh
                .triangles
                .iter()
                .map(|&t| {
                    let [a, b, c] = corners(mesh, t);
                    (b - a).cross(c - a).length() / 2.0
                })
                .sum();
            let luminance: f64 =
                material.emissive.iter().zip([0.2126, 0.7152, 0.0722]).map(|(&l, w)| f64::from(l) * w).sum();
            assert!((PI * luminance * area / veach_mis::POWER - 1.0).abs() < 1e-4);
        } else if mesh.name.starts_with("plate") {
            let [a, b, c] = corners(mesh, mesh.triangles[0]);
            let normal = (b - a).cross(c - a).normalize();
            let middle = (a + c) / 2.0;
            let to_eye = (eye - middle).normalize();
            let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
            // The mirrored ray hits the row of lights.
            let row = DVec3::new(0.0, 2.7, -0.6);
            assert!(mirrored.cross((row - middle).normalize()).length() < 1e-5, "{}", mesh.name);
            assert!(normal.dot(to_eye) > 0.0);
        }
    }
    assert_eq!(lights, 4);
}

#[test]
fn many_lights_has_two_thousand_glowing_triangles_and_a_dozen_dominate() {
    let scene = many_lights::many_lights();
    let glowing: usize =
        scene.meshes.iter().filter(|m| scene.materials[m.material].is_emissive()).map(|m| m.triangles.len()).sum();
    assert_eq!(glowing, 2000);
    let power: Vec<f64> = many_lights::powers().iter().map(|p| p.iter().sum()).collect();
    let (small, large) = power.split_at(8);
    let (small, large): (f64, f64) = (small.iter().sum(), large.iter().sum());
    assert!(large > 2.0 * small, "large {large}, small {small}");
}

#[test]
fn sky_irradiance_of_a_uniform_map_is_pi() {
    let (width, height) = (16, 8);
    let map = EnvironmentMap { width, height, texels: vec![[1.0, 2.0, 0.0]; 128] };
    let e = spheres::sky_irradiance(&map);
    assert!((e[0] - PI).abs() < 1e-12 && (e[1] - 2.0 * PI).abs() < 1e-12 && e[2] == 0.0);
    let sky = spheres::sky();
    assert_eq!(sky.texels.len(), (sky.width * sky.height) as usize);
    assert!(sky.texels.iter().flatten().all(|&x| x.is_finite() && x > 0.0));
}

#[test]
fn textured_counts_hold() {
    let open = textured::screen_openness();
    assert!(open > 0.3 && open < 0.7, "{open}");
    let scene = textured::textured();
    let tiles = scene.meshes.iter().find(|m| m.name == "back wall").unwrap();
    // Tangent along +X, bitangent (n × t) up: the convention of glTF for an unmirrored map.
    let tangent = tiles.tangents.as_ref().unwrap()[0];
    assert_eq!(tangent.to_array(), [1.0, 0.0, 0.0, 1.0]);
    assert!(scene.meshes.iter().filter(|m| m.tangents.is_some()).count() == 1);
    let checker = &scene.images[0];
    assert_eq!(checker.rgba[0..4], checker.rgba[12..16]);
    assert_ne!(checker.rgba[0..4], checker.rgba[4..8]);
}

#[test]
fn slab_answer_conserves_energy_and_matches_the_known_value() {
    let (t, r) = probes::slab_answer(1.5, 1.0);
    assert!((t + r - 1.0).abs() < 1e-15);
    assert!((r - 2.0 * 0.04 / 1.04).abs() < 1e-15);
    // The series summed by hand.
    let (rho, tau) = (0.04f64, 0.7f64);
    let by_hand: f64 = (0..40).map(|k| (1.0 - rho).powi(2) * tau * (rho * tau).powi(2 * k)).sum();
    assert!((probes::slab_answer(1.5, 0.7).0 - by_hand).abs() < 1e-15);
}

#[test]
fn probes_are_what_they_say() {
    for (faces, scene) in [
        (80, probes::convex_furnace([0.5; 3], 1)),
        (2, probes::two_triangles()),
        (16, probes::slab(1.5, 0.5, 1.0)),
        (6, probes::mirror_corridor(3, [0.9; 3])),
        (1001, probes::soup(1001, 5)),
        (200, probes::terrain(10)),
    ] {
        assert_eq!(scene.triangle_count(), faces, "{}", scene.name);
        assert!(scene.has_light() && scene.cameras.len() == 1);
        assert!(!glb::encode(&scene, "").unwrap().is_empty());
    }
    assert_eq!(probes::soup(50, 1).meshes, probes::soup(50, 1).meshes);
    assert_ne!(probes::soup(50, 1).meshes, probes::soup(50, 2).meshes);
}

/// Follows a ray through mirrors to the lamp; `None` when it escapes.
fn follow(scene: &Scene, mut origin: DVec3, mut direction: DVec3) -> Option<u32> {
    let all = triangles(scene);
    for bounces in 0..100 {
        let nearest = all
            .iter()
            .filter_map(|&([a, b, c], material)| {
                let n = (b - a).cross(c - a);
                let t = n.dot(a - origin) / n.dot(direction);
                let p = origin + direction * t;
                let inside = [(a, b), (b, c), (c, a)].iter().all(|&(u, v)| (v - u).cross(p - u).dot(n) >= -1e-12);
                (t > 1e-9 && inside).then_some((t, n.normalize(), material))
            })
            .min_by(|x, y| x.0.total_cmp(&y.0))?;
        let (t, n, material) = nearest;
        if scene.materials[material].is_emissive() {
            return (n.dot(direction) < 0.0).then_some(bounces);
        }
        assert!(n.dot(direction) < 0.0, "the mirror shows its back");
        origin += direction * t;
        direction -= 2.0 * n.dot(direction) * n;
    }
    None
}

#[test]
fn corridor_reflects_as_often_as_requested() {
    for k in [0, 1, 2, 3, 10] {
        let scene = probes::mirror_corridor(k, [0.9; 3]);
        let camera = &scene.cameras[0].to_world;
        for (x, y) in [(0.0, 0.0), (0.01, 0.01), (-0.01, 0.005)] {
            let origin = camera.transform_point3(DVec3::new(x, y, 0.0));
            assert_eq!(follow(&scene, origin, camera.transform_vector3(DVec3::NEG_Z)), Some(k));
        }
    }
}

#[test]
fn quad_light_leans_towards_the_camera_and_the_floor_before_it() {
    let scene = quad_light::quad_light();
    let lamp = quad_light::lamp();
    let front = (lamp[1] - lamp[0]).cross(lamp[3] - lamp[0]);
    assert!(front.dot(scene.cameras[0].to_world.translation - lamp[0]) > 0.0);
    assert!(lamp.iter().all(|p| p.y > 0.0));
    assert_eq!(quad_light::radiance(0.0, -1.5), [0.0; 3]);
    assert_eq!(quad_light::radiance(4.1, 0.0), [0.0; 3]);
    // Against a midpoint rule over the lamp.
    let (x, z) = (0.4, 0.6);
    let n = 300;
    let mut e = 0.0;
    for i in 0..n {
        for j in 0..n {
            let at = |k: i32| (f64::from(k) + 0.5) / f64::from(n);
            let p = lamp[0] + (lamp[1] - lamp[0]) * at(i) + (lamp[3] - lamp[0]) * at(j);
            let d = p - DVec3::new(x, 0.0, z);
            e += d.y * front.dot(-d) / d.length_squared().powi(2) / f64::from(n * n);
        }
    }
    let expected = f64::from(quad_light::FLOOR_REFLECTANCE[1]) / PI * f64::from(quad_light::LAMP_RADIANCE[1]) * e;
    assert!((quad_light::radiance(x, z)[1] / expected - 1.0).abs() < 1e-4);
}

/// The numbers in the notes are computed, not remembered.
#[test]
fn notes_state_true_numbers() {
    let known = |name: &str| GALLERY.iter().find(|e| e.name == name).unwrap().known;
    let triple = |v: [f64; 3]| format!("({:.3}, {:.3}, {:.3})", v[0], v[1], v[2]);
    let lamp = cornell_box::lamp();
    let area = (lamp[1] - lamp[0]).cross(lamp[3] - lamp[0]).length();
    let radiance = cornell_box::RADIANCE.map(f64::from);
    let cornell = known("cornell-box");
    assert!(cornell.contains(&triple(radiance.map(|l| PI * l * area))), "{cornell}");
    let irradiance = polygon_irradiance(cornell_box::PROBE, DVec3::Y, &lamp);
    assert!(cornell.contains(&triple(radiance.map(|l| l * irradiance))), "{cornell}");
    let furnace = furnace::RADIANCE;
    assert!(known("furnace").contains(&format!("({}, {}, {})", furnace[0], furnace[1], furnace[2])));
    assert!(known("veach-mis").contains(&format!("{}", veach_mis::POWER)));
    let textured_note = known("textured");
    assert!(textured_note.contains(&format!("{:.2} %", 100.0 * textured::screen_openness())), "{textured_note}");
    let [a, b] = textured::FLOOR_COLORS;
    let [red, green, blue] = [0, 1, 2].map(|c| (a[c] + b[c]) / 2.0);
    assert!(textured_note.contains(&format!("({red:.4}, {green:.4}, {blue:.4})")), "{textured_note}");
    let mut total = [0.0; 3];
    many_lights::powers().iter().for_each(|p| (0..3).for_each(|c| total[c] += p[c]));
    let many = format!("({:.1}, {:.1}, {:.1})", total[0], total[1], total[2]);
    assert!(known("many-lights").contains(&many), "{many}");
    let sky = triple(spheres::sky_irradiance(&spheres::sky()));
    assert!(spheres::SKY_KNOWN.contains(&sky), "{sky}");
}

/// A profile that runs up from the axis and back to it encloses a volume: its area and its outside
/// are those of the solid, and every edge has two triangles.
#[test]
fn revolved_profiles_are_closed() {
    // The sine of π is not quite zero in f64, and the pole is on the axis.
    let on_axis = |x: f64| if x < 1e-9 { 0.0 } else { x };
    let angles = (0..=64).map(|i| f64::from(i) / 64.0 * PI);
    let half_circle: Vec<_> = angles.map(|a| glam::dvec2(on_axis(a.sin()), -a.cos())).collect();
    let cylinder = [glam::dvec2(0.0, 0.0), glam::dvec2(1.0, 0.0), glam::dvec2(1.0, 2.0), glam::dvec2(0.0, 2.0)];
    for (profile, area, center) in [(&half_circle[..], 4.0 * PI, DVec3::ZERO), (&cylinder[..], 6.0 * PI, DVec3::Y)] {
        let shape = Shape::revolved(profile, 96);
        assert!((shape.area() / area - 1.0).abs() < 2e-3, "{}", shape.area());
        let mut edges = std::collections::HashMap::new();
        for t in &shape.triangles {
            let p = t.map(|i| shape.positions[i as usize]);
            let normal = (p[1] - p[0]).cross(p[2] - p[0]);
            assert!(normal.dot(p[0] - center) >= 0.0, "a front is inside");
            assert!(t.iter().all(|&i| shape.normals[i as usize].dot(normal) > 0.0), "a normal is turned");
            for k in 0..3 {
                let mut edge = [p[k], p[(k + 1) % 3]].map(|v| (v * 1e9).round().as_i64vec3().to_array());
                edge.sort_unstable();
                *edges.entry(edge).or_insert(0) += 1;
            }
        }
        assert!(edges.values().all(|&n| n == 2), "an edge is open");
    }
}
