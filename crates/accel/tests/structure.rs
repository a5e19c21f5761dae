//! What every stream of items must be, whatever it was built from.

mod common;

use common::{Rng, build, lone, scene, soup, sphere};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use surelight_accel::{
    Accel, AccelError, Bounds, BuildOptions, Instancing, Layout, NO_INSTANCE, Quality, Skipped,
    item::{TAG_INSTANCE, TAG_NODE, TAG_TRIANGLE},
    wide,
};
use surelight_scene::{Mesh, Scene};

/// Follows every reference once; checks boxes, order and depth, and returns how often each prim id was met.
fn inspect(accel: &Accel) -> Vec<u32> {
    let mut uses = vec![0; accel.triangles.len()];
    let mut reached = vec![false; accel.items.len()];
    let mut roots = Vec::new();
    let top = inspect_tree(accel, 0, &mut uses, &mut reached, &mut roots);
    let inner = roots
        .iter()
        .map(|&root| {
            // A mesh is walked once however many instances share it.
            if reached[root as usize] { 0 } else { inspect_tree(accel, root, &mut uses, &mut reached, &mut Vec::new()) }
        })
        .max()
        .map_or(0, |d| d + 1);
    assert!(accel.triangles.is_empty() || reached.iter().all(|&r| r), "an item is not part of any tree");
    assert!(top + inner <= accel.stack_depth.max(1), "{top} + {inner} entries, {} stated", accel.stack_depth);
    assert!(accel.stack_depth <= surelight_accel::MOST_STACK);
    uses
}

fn inspect_tree(accel: &Accel, root: u32, uses: &mut [u32], reached: &mut [bool], roots: &mut Vec<u32>) -> u32 {
    assert_eq!(accel.items[root as usize].tag(), TAG_NODE, "a root is a node");
    let everything = Bounds { lo: Vec3::splat(f32::MIN), hi: Vec3::splat(f32::MAX) };
    let mut work = vec![(root, everything, 0)];
    let mut deepest = 0;
    let mut last = None;
    while let Some((at, within, depth)) = work.pop() {
        assert!(last.is_none_or(|l| at > l) || at == root, "items are not in depth-first order");
        last = Some(at);
        assert!(!reached[at as usize], "item {at} is reached twice");
        reached[at as usize] = true;
        let item = &accel.items[at as usize];
        deepest = deepest.max(depth);
        match item.tag() {
            TAG_NODE => {
                for k in [1, 0] {
                    let bounds = item.child_bounds(k);
                    if bounds != Bounds::NEVER_HIT {
                        assert!(within.contains(bounds) && !bounds.is_empty(), "{bounds:?} sticks out of {within:?}");
                        work.push((item.child(k), bounds, depth + 1));
                    }
                }
            }
            TAG_TRIANGLE => {
                uses[item.0[3] as usize] += 1;
                if item.more() {
                    assert_eq!(accel.items[at as usize + 1].tag(), TAG_TRIANGLE);
                    assert!(!accel.items[at as usize + 1].more(), "a leaf of three");
                    work.push((at + 1, within, depth));
                }
            }
            TAG_INSTANCE => {
                assert!(!item.more(), "an instance stands alone in its leaf");
                let record = &accel.instances[item.0[13] as usize];
                for (word, value) in item.0.iter().zip(record.to_object) {
                    assert_eq!(*word, value.to_bits());
                }
                roots.push(item.0[12]);
            }
            tag => panic!("tag {tag}"),
        }
    }
    deepest
}

/// Each triangle's item lies in the boxes above it: checked by corners, with the margin to spare.
fn corners_are_inside(accel: &Accel) {
    for item in accel.items.iter().filter(|i| i.tag() == TAG_NODE) {
        for k in 0..2 {
            let mut at = item.child(k) as usize;
            while item.child_bounds(k) != Bounds::NEVER_HIT && accel.items[at].tag() == TAG_TRIANGLE {
                let t = &accel.items[at];
                let (v0, e1, e2) = (t.vec3(0), t.vec3(4), t.vec3(8));
                let b = item.child_bounds(k);
                for p in [v0, v0 + e1, v0 + e2] {
                    assert!(p.cmpgt(b.lo).all() && p.cmplt(b.hi).all(), "{p} touches or leaves {b:?}");
                }
                if !t.more() {
                    break;
                }
                at += 1;
            }
        }
    }
}

/// The wide format: follows every reference once, checks that what lies below a child is inside its planes in exact
/// arithmetic, and returns how often each prim id was met.
fn inspect_wide(accel: &Accel) -> Vec<u32> {
    let mut uses = vec![0; accel.triangles.len()];
    let mut reached = vec![false; accel.items.len()];
    let mut roots = vec![0];
    let mut depths = Vec::new();
    while let Some(root) = roots.pop() {
        if !reached[root as usize] {
            let mut deepest = 0;
            inspect_wide_item(accel, root, &mut uses, &mut reached, &mut roots, 0, &mut deepest);
            depths.push(deepest);
        }
    }
    assert!(reached.iter().all(|&r| r), "an item is not part of any tree");
    let inner = depths[1..].iter().max().map_or(0, |d| d + 1);
    assert!(depths[0] + inner <= accel.stack_depth, "{depths:?}, {} stated", accel.stack_depth);
    uses
}

/// Returns the box of the vertices below, in f64; instances count as nothing.
fn inspect_wide_item(
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
    match wide::kind(item) {
        wide::Kind::Node(count) => {
            *deepest = (*deepest).max(depth + 1);
            for c in 0..count {
                let below = inspect_wide_item(accel, item.0[4] + c, uses, reached, roots, depth + 1, deepest);
                let planes = wide::child_planes(item, c as usize);
                assert!(planes[0].cmplt(below[0]).all() && planes[1].cmpgt(below[1]).all(), "{planes:?} {below:?}");
                all = [all[0].min(below[0]), all[1].max(below[1])];
            }
        }
        wide::Kind::Pair => {
            for k in [12, 13] {
                uses[item.0[k] as usize] += if item.0[12] == item.0[13] && k == 13 { 0 } else { 1 };
            }
            for v in [0, 3, 6, 9].map(|w| item.vec3(w).as_dvec3()) {
                all = [all[0].min(v), all[1].max(v)];
            }
        }
        wide::Kind::Instance => {
            let record = &accel.instances[item.0[14] as usize].to_object;
            for (k, value) in record.iter().enumerate() {
                assert_eq!(item.0[if k == 11 { 12 } else { k }], value.to_bits());
            }
            roots.push(item.0[13]);
        }
    }
    all
}

/// Each triangle of a wide stream has the corners that its source names.
fn vertices_are_those_of_the_scene(accel: &Accel, scene: &Scene) {
    for item in accel.items.iter().filter(|i| wide::kind(i) == wide::Kind::Pair) {
        for (word, vertices) in [(12, [0, 3, 6]), (13, [9, 6, 3])] {
            let source = accel.triangles[item.0[word] as usize];
            if word == 12 || item.0[12] != item.0[13] {
                let positions = source.corners.map(|i| scene.meshes[source.mesh as usize].positions[i as usize]);
                assert_eq!(positions, vertices.map(|w| item.vec3(w)));
            }
        }
    }
}

#[test]
fn wide_streams_are_well_formed() {
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
                let accel = build(&scene, &BuildOptions { quality, instancing, layout: Layout::Wide });
                let uses = inspect_wide(&accel);
                assert!(uses.len() == count && uses.iter().all(|&u| u == 1), "{n}: each triangle once");
                vertices_are_those_of_the_scene(&accel, &scene);
                let pairs = accel.items.iter().filter(|i| wide::kind(i) == wide::Kind::Pair).count();
                assert!(n <= 100 || pairs < count - 500, "{pairs} leaves of {count} triangles");
            }
        }
    }
}

#[test]
fn streams_are_well_formed() {
    for (seed, n) in [(1, 0), (2, 1), (3, 2), (4, 3), (5, 4), (6, 17), (7, 3000)] {
        let mut rng = Rng::new(seed);
        let scene = lone(soup(&mut rng, n, 0.1));
        for quality in [Quality::Fast, Quality::Medium] {
            for instancing in [Instancing::Never, Instancing::Always] {
                let accel = build(&scene, &BuildOptions { quality, instancing, layout: Layout::Binary });
                let uses = inspect(&accel);
                assert!(uses.len() == n && uses.iter().all(|&u| u == 1), "{n}: each triangle once");
                corners_are_inside(&accel);
                assert_eq!(accel.bounds.is_empty(), n == 0);
            }
        }
        // Splits put a triangle into several leaves, under one id.
        let accel = build(&scene, &BuildOptions { quality: Quality::Slow, ..BuildOptions::default() });
        let uses = inspect(&accel);
        assert!(uses.len() == n && uses.iter().all(|&u| u >= 1), "{n}: each triangle at least once");
    }
}

#[test]
fn an_empty_scene_is_one_node_that_nothing_hits() {
    let mut nothing_sound = soup(&mut Rng::new(1), 5, 1.0);
    nothing_sound.positions.fill(Vec3::splat(f32::NAN));
    let broken = lone(nothing_sound);
    for scene in [&Scene::default(), &lone(Mesh::default()), &broken] {
        for (instancing, layout) in [
            (Instancing::Auto, Layout::Binary),
            (Instancing::Always, Layout::Binary),
            (Instancing::Auto, Layout::Wide),
            (Instancing::Always, Layout::Wide),
        ] {
            let accel = build(scene, &BuildOptions { instancing, layout, ..BuildOptions::default() });
            assert!(!accel.items.is_empty() && accel.triangles.is_empty() && accel.instances.is_empty());
            let mut rng = Rng::new(7);
            for k in 0..1000 {
                let d = if k == 0 { Vec3::ONE } else { rng.cube() };
                assert_eq!(accel.intersect(&surelight_accel::Ray::new(rng.cube(), d)), None);
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
fn indices_out_of_range_are_refused() {
    let mut mesh = soup(&mut Rng::new(1), 3, 1.0);
    mesh.triangles[1][2] = 9;
    let refused = |s: &Scene| Accel::build(s, DVec3::ZERO, &BuildOptions::default()).unwrap_err();
    assert_eq!(refused(&lone(mesh)), AccelError::VertexIndex { mesh: 0, triangle: 1, vertices: 9 });
    let bad = scene(vec![], &[(0, DAffine3::IDENTITY)]);
    assert_eq!(refused(&bad), AccelError::MeshIndex { instance: 0, mesh: 0, meshes: 0 });
}

#[test]
fn only_reused_meshes_become_instances() {
    let at = |x: f64| DAffine3::from_translation(DVec3::new(x, 0.0, 0.0));
    let flat = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::new(1.0, 1.0, 0.0)), translation: DVec3::X * 30.0 };
    let meshes = || vec![sphere(380, 760), sphere(4, 8), sphere(32, 64)];
    // Mesh 0 is big, two of it have more than a million triangles, and a third is squashed flat; mesh 1 is small; mesh 2 is placed once.
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
    corners_are_inside(&accel);
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
            assert_eq!((a.tag(), a.more(), a.child(0)), (b.tag(), b.more(), b.child(0)));
            let node = a.tag() == TAG_NODE;
            let lengths: &[usize] =
                if node { &[0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14] } else { &[0, 1, 2, 4, 5, 6, 7, 8, 9, 10, 11] };
            for &word in lengths {
                assert_eq!((a.float(word) * factor).to_bits(), b.0[word], "word {word}");
            }
            assert!(!node || a.child(1) == b.child(1));
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
        // Random bits make every kind of float; mixed with tame ones, and some sizes that only just fit.
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
                let mut column = || vector(&mut rng).as_dvec3();
                let to_world = DAffine3::from_cols(column(), column(), column(), column());
                (k % 3, to_world)
            })
            .collect();
        let scene = scene(meshes, &placements);
        let origin = if round % 3 == 0 { vector(&mut rng).as_dvec3() } else { DVec3::ZERO };
        let quality = [Quality::Fast, Quality::Medium, Quality::Slow][rng.index(3)];
        for layout in [Layout::Binary, Layout::Wide] {
            for instancing in [Instancing::Never, Instancing::Always] {
                let accel = Accel::build(&scene, origin, &BuildOptions { quality, instancing, layout }).unwrap();
                let uses = if layout == Layout::Wide { inspect_wide(&accel) } else { inspect(&accel) };
                assert!(uses.iter().all(|&u| u >= 1));
                kept += uses.len();
                for _ in 0..20 {
                    let ray = surelight_accel::Ray::new(vector(&mut rng), vector(&mut rng));
                    if let Some(hit) = accel.intersect(&ray) {
                        assert!((hit.prim as usize) < accel.triangles.len() && hit.t > 0.0 && hit.t < 1e30);
                    }
                }
            }
        }
    }
    assert!(kept > 3_000, "{kept} triangles in all");
}
