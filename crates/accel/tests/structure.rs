//! Invariants of every stream of items.

mod common;

use common::{Rng, build, lone, scene, soup, sphere};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use surelight_accel::{
    Accel, BuildOptions, Instancing, MAX_STACK_DEPTH, NO_INSTANCE, Quality, Ray, Skipped, item::Kind,
};
use surelight_scene::{Mesh, Scene};

/// Follows every reference once, checks in exact arithmetic that everything below a child is inside
/// its planes, and returns how often each prim id occurs.
fn inspect(accel: &Accel) -> Vec<u32> {
    let mut uses = vec![0; accel.triangles.len()];
    let mut reached = vec![false; accel.items.len()];
    let mut roots = vec![0];
    let mut depths = Vec::new();
    while let Some(root) = roots.pop() {
        if !reached[root as usize] {
            let mut deepest = 0;
            inspect_item(accel, root, &mut uses, &mut reached, &mut roots, 0, &mut deepest);
            depths.push(deepest);
        }
    }
    assert!(reached.iter().all(|&r| r), "an item is not part of any tree");
    let inner = depths[1..].iter().max().map_or(0, |d| d + 1);
    assert!(depths[0] + inner <= accel.stack_depth, "{depths:?}, {} stated", accel.stack_depth);
    assert!(accel.stack_depth <= MAX_STACK_DEPTH);
    uses
}

/// Returns the box of the vertices below, in f64; instances are empty.
fn inspect_item(
    accel: &Accel,
    at: u32,
    uses: &mut [u32],
    reached: &mut [bool],
    roots: &mut Vec<u32>,
    depth: u32,
    deepest: &mut u32,
) -> [DVec3; 2] {
    assert!(!std::mem::replace(&mut reached[at as usize], true), "item {at} is reached twice");
    let item = &accel.items[at as usize];
    let mut all = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    match item.kind() {
        Kind::Node(count) => {
            *deepest = (*deepest).max(depth + 1);
            for c in 0..count {
                let below = inspect_item(accel, item.0[4] + c, uses, reached, roots, depth + 1, deepest);
                let planes = item.child_planes(c as usize);
                assert!(planes[0].cmplt(below[0]).all() && planes[1].cmpgt(below[1]).all(), "{planes:?} {below:?}");
                all = [all[0].min(below[0]), all[1].max(below[1])];
            }
        }
        Kind::Pair => {
            for k in [12, 13] {
                uses[item.0[k] as usize] += if item.0[12] == item.0[13] && k == 13 { 0 } else { 1 };
            }
            for v in [0, 3, 6, 9].map(|w| item.vec3(w).as_dvec3()) {
                all = [all[0].min(v), all[1].max(v)];
            }
        }
        Kind::Instance => {
            let record = &accel.instances[item.0[14] as usize].to_object;
            for (k, value) in record.iter().enumerate() {
                assert_eq!(item.0[if k == 11 { 12 } else { k }], value.to_bits());
            }
            roots.push(item.0[13]);
        }
    }
    all
}

/// Each triangle of a stream has the corners that its source names.
fn vertices_are_those_of_the_scene(accel: &Accel, scene: &Scene) {
    for item in accel.items.iter().filter(|i| i.kind() == Kind::Pair) {
        for (word, vertices) in [(12, [0, 3, 6]), (13, [9, 6, 3])] {
            let source = accel.triangles[item.0[word] as usize];
            if word == 12 || item.0[12] != item.0[13] {
                let positions = source.corners.map(|i| scene.meshes[source.mesh as usize].positions[i as usize]);
                assert_eq!(positions, item.corners(item.0[word]));
                assert_eq!(positions, vertices.map(|w| item.vec3(w)));
            }
        }
    }
}

#[test]
fn streams_are_well_formed() {
    for (seed, n) in [(1, 0), (2, 1), (3, 2), (4, 3), (5, 5), (6, 17), (7, 3000)] {
        let mut rng = Rng::new(seed);
        let mut mesh = soup(&mut rng, n, 0.1);
        if n > 100 {
            // Something to pair up: a sphere beside the soup.
            let ball = sphere(20, 30);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(&ball.positions);
            mesh.triangles.extend(ball.triangles.iter().map(|t| t.map(|i| i + first)));
        }
        let count = mesh.triangles.len();
        let scene = lone(mesh);
        for quality in [Quality::Fast, Quality::Medium, Quality::Slow] {
            for instancing in [Instancing::Never, Instancing::Always] {
                let accel = build(&scene, &BuildOptions { quality, instancing });
                let uses = inspect(&accel);
                assert!(uses.len() == count && uses.iter().all(|&u| u == 1), "{n}: each triangle once");
                vertices_are_those_of_the_scene(&accel, &scene);
                let pairs = accel.items.iter().filter(|i| i.kind() == Kind::Pair).count();
                assert!(n <= 100 || pairs < count - 500, "{pairs} leaves of {count} triangles");
            }
        }
    }
}

#[test]
fn an_empty_scene_is_one_node_that_nothing_hits() {
    let mut nothing_sound = soup(&mut Rng::new(1), 5, 1.0);
    nothing_sound.positions.fill(Vec3::splat(f32::NAN));
    let broken = lone(nothing_sound);
    for scene in [&Scene::default(), &lone(Mesh::default()), &broken] {
        for instancing in [Instancing::Auto, Instancing::Always] {
            let accel = build(scene, &BuildOptions { instancing, ..BuildOptions::default() });
            assert!(accel.bounds.is_empty() && !accel.items.is_empty());
            assert!(accel.triangles.is_empty() && accel.instances.is_empty());
            let mut rng = Rng::new(7);
            for k in 0..1000 {
                let d = if k == 0 { Vec3::ONE } else { rng.cube() };
                assert_eq!(accel.intersect(&Ray::new(rng.cube(), d)), None);
            }
        }
    }
    assert_eq!(build(&broken, &BuildOptions::default()).skipped, Skipped { non_finite: 5, zero_area: 0 });
}

#[test]
fn degenerate_triangles_are_skipped_and_counted() {
    let mut rng = Rng::new(11);
    let clean = soup(&mut rng, 500, 0.2);
    let mut dirty = clean.clone();
    let vertex = dirty.positions.len() as u32;
    dirty.positions.extend([
        Vec3::new(f32::NAN, 0.0, 0.0),
        Vec3::new(0.0, f32::INFINITY, 0.0),
        Vec3::new(0.0, 0.0, f32::NEG_INFINITY),
        Vec3::splat(3e38),
    ]);
    for k in 0..40 {
        let bad = match k % 8 {
            n @ 0..4 => [k, vertex + n, k + 1],
            4 => [k, k, k + 1],
            5 => [k + 1, k, k],
            6 => [k, k + 1, k],
            _ => [k, k, k],
        };
        dirty.triangles.insert(rng.index(dirty.triangles.len()), bad);
    }
    for instancing in [Instancing::Never, Instancing::Always] {
        let options = BuildOptions { instancing, ..BuildOptions::default() };
        let (a, b) = (build(&lone(clean.clone()), &options), build(&lone(dirty.clone()), &options));
        assert_eq!(b.skipped, Skipped { non_finite: 20, zero_area: 20 });
        assert!(a.items == b.items && a.triangles == b.triangles, "the rest is the cleaned mesh");
    }
}

#[test]
fn only_reused_meshes_become_instances() {
    let at = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let flat = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)), translation: DVec3::X * 30.0 };
    let meshes = || vec![sphere(380, 760), sphere(4, 8), sphere(32, 64)];
    // Mesh 0 is big, two of it have more than a million triangles, and a third is squashed flat;
    // mesh 1 is small; mesh 2 is placed once.
    let placements = [(0, at(0.0)), (0, at(3.0)), (1, at(6.0)), (1, at(9.0)), (2, at(12.0)), (0, flat)];
    let accel = build(&scene(meshes(), &placements), &BuildOptions::default());
    let placed: Vec<u32> = accel.instances.iter().map(|r| r.scene_instance).collect();
    assert_eq!(placed, [0, 1]);
    let instances_of = |mesh| {
        let mut of: Vec<u32> = accel.triangles.iter().filter(|t| t.mesh == mesh).map(|t| t.instance).collect();
        of.sort_unstable();
        of.dedup();
        of
    };
    assert_eq!(instances_of(0), [5, NO_INSTANCE]);
    assert_eq!(instances_of(1), [2, 3]);
    assert_eq!(instances_of(2), [4]);
    inspect(&accel);
    assert!(build(&scene(meshes(), &placements[..1]), &BuildOptions::default()).instances.is_empty());
    // Fewer triangles than that are copied.
    let few = vec![sphere(32, 64), sphere(4, 8), sphere(32, 64)];
    assert!(build(&scene(few, &placements), &BuildOptions::default()).instances.is_empty());
}

#[test]
fn scaling_by_a_power_of_two_scales_every_item() {
    let mut rng = Rng::new(21);
    let mesh = soup(&mut rng, 3000, 0.1);
    let plain = build(&lone(mesh.clone()), &BuildOptions::default());
    for exponent in [-20, 20] {
        let factor = (exponent as f32).exp2();
        let mut scaled = mesh.clone();
        scaled.positions.iter_mut().for_each(|p| *p *= factor);
        let accel = build(&lone(scaled), &BuildOptions::default());
        assert_eq!(accel.items.len(), plain.items.len());
        for (a, b) in plain.items.iter().zip(&accel.items) {
            assert_eq!(a.kind(), b.kind());
            // A node's grid origin, or four corners; then the steps. All else is numbers of items
            // and planes.
            let node = a.kind() != Kind::Pair;
            let (lengths, steps) = if node { (3, 1) } else { (12, 0) };
            for word in 0..lengths {
                assert_eq!((a.float(word) * factor).to_bits(), b.0[word], "word {word}");
            }
            assert!(!node || a.step() * factor == b.step());
            assert_eq!(a.0[lengths + steps..], b.0[lengths + steps..]);
        }
    }
}

#[test]
fn far_from_the_origin_nothing_changes() {
    // 2^20 is exact next to these coordinates in f64, so the items must be the same to the bit.
    let mut mesh = soup(&mut Rng::new(31), 2000, 0.1);
    mesh.positions.iter_mut().for_each(|p| *p = (*p * 4096.0).round() / 4096.0);
    let near = build(&lone(mesh.clone()), &BuildOptions::default());
    let away = DVec3::new(1048576.0, -1048576.0, 524288.0);
    let scene = scene(vec![mesh], &[(0, DAffine3::from_translation(away))]);
    let far = Accel::build(&scene, away, &BuildOptions::default()).unwrap();
    assert!(near.items == far.items);
    let unmoved = build(&scene, &BuildOptions::default());
    assert!(unmoved.items != far.items, "without the origin the items differ: the test can fail");
}

#[test]
fn hostile_scenes_never_panic() {
    let mut rng = Rng::new(71);
    let mut kept = 0;
    for round in 0..200 {
        // Random bits make every kind of float; mixed with tame ones, and some sizes that only just
        // fit.
        let float = |rng: &mut Rng| match rng.index(if round % 2 == 0 { 4 } else { 20 }) {
            0 => f32::from_bits(rng.bits()),
            1 => [0.0, -0.0, 1e18, -1e18, 9e17, 1e-38, 1e-45, f32::MAX][rng.index(8)],
            2 => (rng.unit() * 120.0 - 60.0).exp2(),
            _ => rng.unit() * 2.0 - 1.0,
        };
        let vector = |rng: &mut Rng| Vec3::new(float(rng), float(rng), float(rng));
        let meshes: Vec<Mesh> = (0..3)
            .map(|k| {
                let n = [3, 90, 1 + rng.index(300)][k];
                let positions = (0..n).map(|_| vector(&mut rng)).collect();
                let triangles = (0..n).map(|_| [0; 3].map(|_| rng.index(n) as u32)).collect();
                Mesh { positions, triangles, ..Mesh::default() }
            })
            .collect();
        let placements: Vec<(usize, DAffine3)> = (0..4)
            .map(|k| {
                // Scenes that are not finite are refused.
                let mut column = || {
                    let column = vector(&mut rng);
                    if column.is_finite() { column.as_dvec3() } else { DVec3::ZERO }
                };
                let to_world = DAffine3::from_cols(column(), column(), column(), column());
                (k % 3, to_world)
            })
            .collect();
        let scene = scene(meshes, &placements);
        let origin = if round % 3 == 0 { vector(&mut rng).as_dvec3() } else { DVec3::ZERO };
        let quality = [Quality::Fast, Quality::Medium, Quality::Slow][rng.index(3)];
        for instancing in [Instancing::Never, Instancing::Always] {
            let accel = Accel::build(&scene, origin, &BuildOptions { quality, instancing }).unwrap();
            let uses = inspect(&accel);
            assert!(uses.iter().all(|&u| u == 1));
            kept += uses.len();
            for _ in 0..20 {
                let ray = Ray::new(vector(&mut rng), vector(&mut rng));
                if let Some(hit) = accel.intersect(&ray) {
                    assert!((hit.prim as usize) < accel.triangles.len() && hit.t > 0.0 && hit.t < 1e30);
                }
            }
        }
    }
    assert!(kept > 3_000, "{kept} triangles in all");
}
