//! Cases 10, 13, 15 and 16, and companions: the traversal that ships, run on the device by a probe,
//! against brute force in f64 over the scene: random and awkward triangles, awkward rays, instances
//! under any transform. An answer is right when it is f64's, or when the ray grazes an edge or two
//! surfaces within the rounding of f32 (`Oracle::judge`); such ties must be rare.

use glam::{DAffine3, DMat3, DVec3, Vec3};
use surelight_accel::oracle::Oracle;
use surelight_accel::{BuildOptions, Instancing, Quality, Ray};
use surelight_prepare::{Part, Settings};
use surelight_scene::Mesh;
use surelight_scenes::{shapes::Shape, torture::geometry};
use surelight_tests::random::Random;
use surelight_tests::render::{all, render};
use surelight_tests::traversal::{
    FAR, ProbeRays, compare_with_oracle, lone, on_instance, point_of, prepare, traverse, try_traverse,
};

/// Triangles of about `size` with separate corners, in [−1, 1]³.
fn soup(random: &mut Random, n: u32, size: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..n {
        let c = random.cube();
        mesh.positions.extend([(); 3].map(|()| c + random.cube() * size));
        mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    mesh
}

fn sphere(subdivisions: u32) -> Mesh {
    Shape::icosphere(subdivisions).faceted().into_mesh("sphere", 0, false)
}

/// Rays between random points of a cube about the origin.
fn rays(random: &mut Random, n: usize, reach: f32) -> Vec<Ray> {
    let mut ray = || {
        let (a, b) = (random.cube() * reach, random.cube() * reach);
        Ray::new(a, (b - a).normalize())
    };
    (0..n).map(|_| ray()).collect()
}

fn with(instancing: Instancing) -> BuildOptions {
    BuildOptions { instancing, ..BuildOptions::default() }
}

#[test]
fn random_soups() {
    for (seed, n, size) in [(1, 1, 1.0), (2, 2, 1.0), (3, 3, 0.5), (4, 40, 0.5), (5, 1000, 0.1), (6, 3000, 0.3)] {
        let mut random = Random::new(seed);
        let mesh = soup(&mut random, n, size);
        for quality in [Quality::Medium, Quality::Slow] {
            let (scene, prepared) = lone(mesh.clone(), BuildOptions { quality, ..BuildOptions::default() });
            let rays = rays(&mut random, 2000, 2.0);
            let tally = compare_with_oracle(&format!("soup of {n}"), &scene, &prepared, &rays);
            assert!(tally.hits > 10 && tally.ties <= 10, "{tally:?}");
        }
    }
}

#[test]
fn instances_that_stretch_shear_and_mirror() {
    for (seed, scale) in [(11, 1.0), (12, 1e3), (13, 1e-3)] {
        let mut random = Random::new(seed);
        let meshes = vec![sphere(1), soup(&mut random, 100, 0.4)];
        let placements: Vec<_> = (0..12)
            .map(|k| {
                let mut stretch = random.cube().as_dvec3().abs() + 0.2;
                if k % 2 == 1 {
                    stretch[k / 2 % 3] *= -1.0;
                }
                let turned =
                    DMat3::from_quat(random.turn()) * DMat3::from_diagonal(stretch) * DMat3::from_quat(random.turn());
                (k % 2, DAffine3 { matrix3: turned * scale, translation: random.cube().as_dvec3() * 4.0 * scale })
            })
            .collect();
        let rays = rays(&mut random, 3000, 5.0 * scale as f32);
        let mut hits = [0, 0];
        for (k, instancing) in [Instancing::Always, Instancing::Never].into_iter().enumerate() {
            let (scene, prepared) = prepare(meshes.clone(), &placements, with(instancing));
            assert_eq!(prepared.key().has(Part::Instances), instancing == Instancing::Always);
            let name = format!("instances at scale {scale:e}, {instancing:?}");
            let tally = compare_with_oracle(&name, &scene, &prepared, &rays);
            assert!(tally.hits > 300 && tally.ties <= 15, "{tally:?}");
            hits[k] = tally.hits;
        }
        assert!(hits[0].abs_diff(hits[1]) <= 3, "{hits:?} hits, placed and copied");
    }
}

/// Triangles of aspect 1e6, with a wide one behind them.
#[test]
fn needle() {
    let scene = geometry::needle();
    let mut mesh = scene.meshes[0].clone();
    let (n, wall) = (mesh.positions.len() as u32, &scene.meshes[1]);
    mesh.positions.extend(&wall.positions);
    mesh.triangles.extend(wall.triangles.iter().map(|t| t.map(|i| i + n)));
    let mut random = Random::new(21);
    let mut aimed = rays(&mut random, 500, 1.5);
    for k in 0..2500 {
        let o = random.cube() * 3.0;
        let p = point_of(&mesh, k % 400, random.unit() * 0.5, random.unit() * 0.5);
        aimed.push(Ray::new(o, (p - o).normalize()));
    }
    let (scene, prepared) = lone(mesh, BuildOptions::default());
    assert!(compare_with_oracle("needles", &scene, &prepared, &aimed).hits > 1000);
    // The error band is wider than a needle, so that brute force excuses a traversal which misses
    // it. Most are hit nevertheless.
    let oracle = Oracle::new(&scene, DVec3::ZERO);
    let queries: Vec<_> = aimed.iter().map(ProbeRays::closest).collect();
    let (mut there, mut hits) = (0, 0);
    for (ray, found) in aimed.iter().zip(traverse(&prepared, &queries)) {
        if let Some(crossing) = oracle.intersect(ray).filter(|c| c.vertices[0] < n) {
            there += 1;
            hits +=
                usize::from(found.hit().is_some_and(|hit| f64::from(hit.t) < crossing.t + crossing.t_band.min(1e-3)));
        }
    }
    println!("of {there} needles that a ray hits in f64 the traversal hits {hits}");
    assert!(there > 500 && 2 * hits > there, "of {there} needles that a ray hits in f64 the traversal hits {hits}");
}

/// Rays along the axes with signed zeros among their components, from grid points: they run in the
/// planes of boxes and triangles.
#[test]
fn axis_aligned_rays() {
    let scene = geometry::axis_aligned_rays();
    // Through pixels of the picture, all of them squares.
    let film = render(&scene, &Settings::new(48, 48), 1, 16);
    let holes = all(&film).filter(|&i| film.mean(i) != [1.0; 3]).count();
    assert_eq!(holes, 0, "pixels of the lattice are not 1");

    let mesh = scene.meshes[0].clone();
    let mut rays = Vec::new();
    for axis in 0..3 {
        for mask in 0..8 {
            for k in 0..64 {
                let grid = Vec3::new((k % 4) as f32, (k / 4 % 4) as f32, (k / 16) as f32) - 1.0;
                let sign = |a: usize| if mask >> a & 1 == 1 { -1.0f32 } else { 1.0 };
                let mut d = Vec3::new(0.0 * sign(0), 0.0 * sign(1), 0.0 * sign(2));
                d[axis] = sign(axis);
                for nudge in [0.0, 0.25, -0.25] {
                    let mut o = grid + nudge;
                    rays.push(Ray::new(o, d));
                    o[axis] = -4.0 * d[axis];
                    rays.push(Ray::new(o, d));
                }
            }
        }
    }
    for instancing in [Instancing::Never, Instancing::Always] {
        let (scene, prepared) = lone(mesh.clone(), with(instancing));
        let tally = compare_with_oracle("rays along axes", &scene, &prepared, &rays);
        assert!(tally.hits * 2 > rays.len(), "{tally:?}");
        // From outside through the insides of squares nothing is in doubt.
        let sure = |r: &&Ray| {
            let axis = r.direction.abs().max_position();
            r.origin[axis].abs() == 4.0
                && (0..3).filter(|&a| a != axis).all(|a| {
                    let x = r.origin[a];
                    x > -1.0 && x < 2.0 && x.fract() != 0.0
                })
        };
        let sure: Vec<_> = rays.iter().filter(sure).map(ProbeRays::closest).collect();
        let missed = traverse(&prepared, &sure).iter().filter(|f| f.hit().is_none()).count();
        assert!(sure.len() > 100 && missed == 0, "{missed} of {} rays miss the squares they pierce", sure.len());
    }
}

/// Triangles about one point: a quarter of the million, unless there is time.
const MILLION: u32 = if cfg!(feature = "long") { 1_000_000 } else { 250_000 };

/// Many triangles in one place: the tree cannot separate them, and the stack must hold all the
/// same.
#[test]
fn same_centroid_1e6() {
    let around = |c: Vec3, r: f32| [c + Vec3::new(r, 0.0, -r), c + Vec3::new(-r, r, 0.0), c + Vec3::new(0.0, -r, r)];
    let place = |n: u32, f: &dyn Fn(f32) -> [Vec3; 3]| {
        let mut mesh = Mesh::default();
        for k in 0..n {
            mesh.positions.extend(f(k as f32 / n as f32));
            mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
        }
        mesh
    };
    let cases = [
        ("concentric", place(20_000, &|k| around(Vec3::ZERO, 1.0 + k))),
        ("identical", place(20_000, &|_| around(Vec3::ONE, 0.5))),
        ("growing", place(20_000, &|k| around(Vec3::ZERO, (k * 40.0).exp2()))),
    ];
    for (name, mesh) in cases {
        let mut random = Random::new(31);
        let rays: Vec<_> = (0..48)
            .map(|_| {
                let k = random.index(mesh.triangles.len());
                let (p, size) = (
                    point_of(&mesh, k, 0.3, 0.2),
                    (point_of(&mesh, k, 1.0, 0.0) - point_of(&mesh, k, 0.0, 0.0)).length(),
                );
                let o = p + random.cube() * 3.0 * size;
                Ray::new(o, (p - o).normalize())
            })
            .collect();
        let (scene, prepared) = lone(mesh, BuildOptions::default());
        assert!(compare_with_oracle(name, &scene, &prepared, &rays).hits > 40);
    }

    let mesh = geometry::same_centroid(MILLION).meshes.remove(0);
    let mut random = Random::new(32);
    let aimed: Vec<_> = (0..24)
        .map(|_| {
            // Past the centroid, near corners of the greatest.
            let p = point_of(&mesh, random.index(500), 0.05, 0.05);
            let d = p.cross(random.cube()).normalize();
            Ray::new(p - d, d)
        })
        .collect();
    let (scene, prepared) = lone(mesh, BuildOptions::default());
    println!("a stack of {} entries for {MILLION} triangles", prepared.accel.stack_depth);
    let tally = compare_with_oracle("a million", &scene, &prepared, &aimed);
    assert!(tally.hits == aimed.len() && tally.ties < 4, "{tally:?}");

    // A known issue: a ray with a hundred thousand triangles at one distance hits more items than
    // the limit of a traversal. It is reported, not wrong. When this test fails, traversal has no
    // limit any more: use more triangles above.
    let (_, prepared) = lone(place(100_000, &|k| around(Vec3::ZERO, 1.0 + k)), BuildOptions::default());
    let through = ProbeRays::closest(&Ray::new(Vec3::new(0.1, 0.2, 5.0), Vec3::NEG_Z));
    assert!(!try_traverse(&prepared, &[through])[0].is_complete(), "a traversal of 100,000 items ends");
}

/// Rays from within a closed mesh, aimed at random, at corners and at edges, never get out.
#[test]
fn vertex_edge_aim() {
    for (scale, shift) in [(1.0, Vec3::ZERO), (1.0, Vec3::new(40.0, -20.0, 10.0)), (1e-3, Vec3::splat(0.1))] {
        let mut mesh = sphere(3);
        mesh.positions.iter_mut().for_each(|p| *p = *p * scale + shift);
        for instancing in [Instancing::Never, Instancing::Always] {
            let (scene, prepared) = lone(mesh.clone(), with(instancing));
            let mesh = &scene.meshes[0];
            let mut random = Random::new(41);
            let queries: Vec<_> = (0..200_000)
                .map(|k| {
                    let o = shift + random.cube().normalize() * [0.0, 0.5, 0.99][k % 3] * scale;
                    let t = random.index(mesh.triangles.len());
                    let target = match k % 4 {
                        0 => point_of(mesh, t, 0.0, 0.0),
                        1 => point_of(mesh, t, random.unit(), 0.0),
                        _ => shift + random.cube() * scale,
                    };
                    let ray = Ray::new(o, (target - o).normalize());
                    ProbeRays::closest(&ray).with_shadow(&ray, FAR)
                })
                .collect();
            let finite: Vec<_> = queries.into_iter().filter(|q| q.direction.iter().all(|d| d.is_finite())).collect();
            let escaped = traverse(&prepared, &finite).iter().filter(|f| f.hit().is_none() || !f.occluded()).count();
            assert_eq!(escaped, 0, "of {} at scale {scale}, shift {shift}, {instancing:?}", finite.len());
        }
    }
}

/// A shadow ray is blocked when it ends behind the closest hit, and free when it ends before; and
/// the closest hit is the same, bit for bit, whatever shadow ray was traced before it.
#[test]
fn shadows_end_at_the_closest_hit() {
    let mut random = Random::new(51);
    let meshes = vec![sphere(2), soup(&mut random, 500, 0.4)];
    let placements: Vec<_> = (0..6)
        .map(|k| (k % 2, DAffine3::from_rotation_translation(random.turn(), random.cube().as_dvec3() * 2.0)))
        .collect();
    for instancing in [Instancing::Never, Instancing::Always] {
        let (_, prepared) = prepare(meshes.clone(), &placements, with(instancing));
        let rays = rays(&mut random, 20_000, 3.0);
        let alone = traverse(&prepared, &rays.iter().map(ProbeRays::closest).collect::<Vec<_>>());
        let hits: Vec<_> = rays.iter().zip(&alone).filter_map(|(r, f)| Some((r, f.hit()?))).collect();
        assert!(hits.len() > 5000, "{} hits", hits.len());
        if instancing == Instancing::Always {
            assert!(hits.iter().all(|(_, hit)| on_instance(hit)));
        }
        let ending = |factor: f32| -> Vec<bool> {
            let queries: Vec<_> =
                hits.iter().map(|(ray, hit)| ProbeRays::closest(ray).with_shadow(ray, hit.t * factor)).collect();
            traverse(&prepared, &queries).iter().map(|f| f.occluded()).collect()
        };
        assert!(ending(1.0 + 1e-6).iter().all(|&o| o), "a shadow ray passes its hit");
        assert!(!ending(1.0).iter().any(|&o| o), "a shadow ray hits a surface at its end");

        // Another ray's shadow first.
        let queries: Vec<_> = rays
            .iter()
            .zip(rays.iter().rev())
            .map(|(ray, other)| ProbeRays::closest(ray).with_shadow(other, FAR))
            .collect();
        let after = traverse(&prepared, &queries);
        assert!(alone.iter().zip(&after).all(|(a, b)| a.hit() == b.hit()), "a shadow ray changes the closest hit");
        assert!(alone.iter().rev().zip(&after).all(|(a, b)| a.hit().is_some() == b.occluded()));
    }
}
