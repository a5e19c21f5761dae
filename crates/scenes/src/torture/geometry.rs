//! Geometry that rays slip through, stick to or get lost in: cases 9 to 19.

use glam::{DAffine3, DQuat, DVec3};
use surelight_scene::{Environment, Material, Scene};

use super::{Case, orthographic};
use crate::Entry;
use crate::builder::{Builder, emitter, lambert};
use crate::random::SplitMix;
use crate::shapes::Shape;

/// The group's cases.
pub const CASES: &[Case] = &[
    Case::new(
        9,
        Entry {
            name: "watertight-inside",
            shows: "The inside of a closed black ball in a blazing sky (`--sky 1e6,1e6,1e6`).",
            known: "Every pixel is 0: one that is not has seen a ray slip through an edge.",
            build: || watertight_inside(DVec3::ZERO),
        },
    ),
    Case::new(
        10,
        Entry {
            name: "vertex-edge-aim",
            shows: "The same ball far from the origin, from inside and near its wall (`--sky 1e6,1e6,1e6`).",
            known: "Every pixel is 0; and so is every ray's share that is aimed at a vertex or along an edge.",
            build: || watertight_inside(DVec3::new(40.0, -20.0, 10.0)),
        },
    ),
    Case::new(
        11,
        Entry {
            name: "respawn",
            shows: "A closed hall of 300 m with walls of 2 m, turned, of reflectance 0.9375 that shines by itself.",
            known: "Every pixel is (1, 0.5, 0.25): Le = L·(1 − ρ). A ray that meets the wall it leaves makes it brighter or \
                    darker by its depth series.",
            build: respawn,
        },
    ),
    Case::new(
        12,
        Entry {
            name: "concentric-4e-5",
            shows: "Between two closed balls of radius 1 and 1.00004, a blazing lamp within the inner one and a blazing \
                    sky around the outer one (`--sky 1e6,1e6,1e6`).",
            known: "Every pixel is 0: neither paths nor shadow rays pass either ball.",
            build: concentric,
        },
    ),
    Case::new(
        13,
        Entry {
            name: "needle",
            shows: "Four hundred black needles of aspect 10^6 before a wide shining triangle.",
            known: "A ray meets what brute force in f64 meets, outside of an error band.",
            build: needle,
        },
    ),
    Case::new(
        14,
        Entry {
            name: "degenerate",
            shows: "A lamp over a ball and a floor, with triangles among theirs that have no area.",
            known: "The picture is that of the scene without them, bit for bit, and they are counted: 12. (The generator \
                    can add 6 with corners that are NaN or infinite, which are counted apart.)",
            build: || degenerate(Defects::ZeroArea),
        },
    ),
    Case::generated(
        15,
        Entry {
            name: "same-centroid-1e6",
            shows: "A million triangles about one point, from a metre down to 10^-36 of it, under a white sky.",
            known: "A ray hits the triangle that brute force in f64 finds, or its traversal is reported as cut short: no \
                    plane separates triangles with one centroid, and a ray near it intersects the boxes of all.",
            build: || same_centroid(1_000_000),
        },
    ),
    Case::new(
        16,
        Entry {
            name: "axis-aligned-rays",
            shows: "A lattice of shining squares in planes at whole numbers, seen along an axis by parallel rays.",
            known: "Every pixel is 1: the squares that face the camera fill the view, and those that it sees edge-on lie \
                    in the planes of rays, boxes and one another.",
            build: axis_aligned_rays,
        },
    ),
    Case::new(
        17,
        Entry {
            name: "instance-vs-baked",
            shows: "One ball, placed eight times: stretched, sheared and mirrored, its mesh a thousand times too small or \
                    too large.",
            known: "The picture is that of the same balls as copies in world space. It has no closed form.",
            build: instance_vs_baked,
        },
    ),
    Case::new(
        18,
        Entry {
            name: "coplanar-twins",
            shows: "A floor and a block whose every triangle is there twice, under a lamp.",
            known: "The picture is that of the single surfaces. It has no closed form.",
            build: || coplanar_twins(DuplicatedPart::Surfaces),
        },
    ),
    Case::new(
        19,
        Entry {
            name: "shading-normal-flip",
            shows: "Two white balls of 80 triangles in a white sky, one with smooth normals, one with these turned inwards.",
            known: "A sample is 1 or 0, never more. A point whose shading normal leans by θ shows (1 + cos θ)/2: directions \
                    are drawn about the shading normal, and those that leave through the surface are lost. A normal that \
                    faces away is first turned until it just faces the viewer.",
            build: shading_normal_flip,
        },
    ),
];

/// A radiance that no test can overlook.
pub const BLAZE: f32 = 1e6;

fn blazing(mut scene: Scene) -> Scene {
    scene.environment = Some(Environment::Uniform([BLAZE; 3]));
    scene
}

/// A closed black ball of 1,280 triangles about `middle`, viewed from within: from near its wall
/// where it is off the origin.
pub fn watertight_inside(middle: DVec3) -> Scene {
    let off_origin = middle != DVec3::ZERO;
    let mut b = Builder::new(if off_origin { "vertex-edge-aim" } else { "watertight-inside" });
    let black = b.material(lambert("black", [0.0; 3]));
    b.add("ball", Shape::icosphere(3).placed(1.0, middle), black);
    let eye = middle + DVec3::new(0.3, 0.5, 0.1) * if off_origin { 1.65 } else { 1.0 };
    b.camera(eye, middle, 120.0, 1.0);
    blazing(b.finish())
}

/// Radiance of the walls of [`respawn`].
pub const HALL_RADIANCE: [f32; 3] = [1.0, 0.5, 0.25];

/// A long hall, turned so that no wall lies along an axis.
pub fn respawn() -> Scene {
    let mut b = Builder::new("respawn");
    let reflectance = 0.9375;
    let wall = lambert("wall", [reflectance; 3]);
    let wall = b.material(Material { emissive: HALL_RADIANCE.map(|l| l * (1.0 - reflectance)), ..wall });
    let turn = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let hall = Shape::cuboid(DVec3::splat(-1.0), DVec3::new(40.0, 1.0, 300.0)).turned_over();
    b.add("hall", hall.transformed(&turn), wall);
    let at = |x, y, z| turn.transform_point3(DVec3::new(x, y, z));
    b.camera(at(0.0, 0.2, 5.0), at(0.3, 0.0, 0.0), 90.0, 1.0);
    b.finish()
}

/// Relative width of the gap of [`concentric`].
pub const GAP: f64 = 4e-5;

/// Two balls with a gap between them; the camera is in it.
pub fn concentric() -> Scene {
    let mut b = Builder::new("concentric-4e-5");
    let wall = b.material(lambert("wall", [0.9; 3]));
    let lamp = b.material(emitter("lamp", [BLAZE; 3]));
    let ball = Shape::icosphere(3);
    let [p, q, r] = ball.triangles[0].map(|i| ball.positions[i as usize]);
    let eye = (p + q + r) / 3.0 * (1.0 + GAP / 2.0);
    // Along the gap, as far as there is an along.
    let towards = eye + eye.cross(DVec3::Y).normalize();
    b.add("inner", ball.clone(), wall);
    b.add("outer", ball.placed(1.0 + GAP, DVec3::ZERO), wall);
    b.add("lamp", Shape::cuboid(DVec3::splat(-0.2), DVec3::splat(0.2)), lamp);
    b.camera(eye, towards, 90.0, 1.0);
    blazing(b.finish())
}

/// Needles with corners at random, and behind them a triangle that none of them hides.
pub fn needle() -> Scene {
    let mut b = Builder::new("needle");
    let black = b.material(lambert("needle", [0.0; 3]));
    let light = b.material(emitter("wall", [1.0; 3]));
    let mut random = SplitMix::new(21);
    let mut needles = Shape::default();
    for k in 0..400 {
        let (a, along, across) = (random.cube(), random.cube(), random.cube());
        needles.positions.extend([a, a + along, a + along * 0.5 + across * 1e-6]);
        needles.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let corners = [(9.0, -9.0), (-9.0, -9.0), (0.0, 9.0)].map(|(x, y)| DVec3::new(x, y, 2.0));
    b.add("needles", needles, black);
    b.add("wall", Shape { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Shape::default() }, light);
    b.camera(DVec3::new(0.2, 0.1, -4.0), DVec3::ZERO, 40.0, 1.0);
    b.finish()
}

/// The defects of some triangles of [`degenerate`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Defects {
    /// Nothing.
    None,
    /// Twelve have no area: six with two corners in one place, six with all on a line.
    ZeroArea,
    /// These, and six whose corners are not finite. glTF cannot hold them.
    NotFinite,
}

/// A lamp, a ball and a floor with defects among the triangles of each.
pub fn degenerate(defects: Defects) -> Scene {
    let mut b = Builder::new("degenerate");
    let floor = b.material(lambert("floor", [0.5, 0.6, 0.7]));
    let ball = b.material(lambert("ball", [0.8, 0.5, 0.3]));
    let lamp = b.material(emitter("lamp", [8.0, 7.0, 6.0]));
    let spoilt = |mut shape: Shape| {
        // Flat, so that added triangles need no normals.
        shape.normals.clear();
        let n = shape.positions.len() as u32;
        let [p, q] = [shape.positions[0], shape.positions[1]];
        shape.positions.extend([p, q, p + (q - p) * 0.5, p + (q - p) * 2.0]);
        if defects == Defects::NotFinite {
            shape.positions.extend([DVec3::new(f64::NAN, 0.0, 0.0), DVec3::new(0.0, f64::INFINITY, 0.0)]);
            shape.triangles.insert(0, [0, 1, n + 4]);
            shape.triangles.push([n + 5, 1, 2]);
        }
        if defects != Defects::None {
            shape.triangles.insert(1, [0, 1, 1]);
            shape.triangles.extend([[n, n + 1, 0], [n, n + 2, n + 3], [n + 2, n + 1, n + 3]]);
        }
        shape
    };
    b.add("floor", spoilt(Shape::parallelogram(DVec3::NEG_Y, DVec3::X * 4.0, DVec3::NEG_Z * 4.0).bare()), floor);
    b.add("ball", spoilt(Shape::icosphere(2).bare()), ball);
    b.add("lamp", spoilt(Shape::parallelogram(DVec3::Y * 3.0, DVec3::X, DVec3::Z).bare()), lamp);
    b.camera(DVec3::new(0.0, 1.0, 6.0), DVec3::ZERO, 40.0, 1.0);
    b.finish()
}

/// `n` triangles about the origin, turned at random, each smaller than the one before, from size 1
/// to 2^-120.
pub fn same_centroid(n: u32) -> Scene {
    let mut b = Builder::new("same-centroid-1e6");
    let material = b.material(lambert("triangle", [0.5; 3]));
    let mut random = SplitMix::new(15);
    let mut shape = Shape::default();
    for k in 0..n {
        let size = (-120.0 * f64::from(k) / f64::from(n)).exp2();
        let (x, y) = random.cube().normalize().any_orthonormal_pair();
        let corner = |angle: f64| (x * angle.cos() + y * angle.sin()) * size;
        shape.positions.extend([0.0, 2.0, 4.0].map(|thirds| corner(thirds * std::f64::consts::FRAC_PI_3)));
        shape.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    b.add("triangles", shape, material);
    b.camera(DVec3::new(3.0, 4.0, 5.0), DVec3::ZERO, 40.0, 1.0);
    let mut scene = b.finish();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// Squares of 3 m in the planes −1, 0, 1 and 2 of each axis, front towards its end.
pub fn axis_aligned_rays() -> Scene {
    let mut b = Builder::new("axis-aligned-rays");
    let light = b.material(emitter("square", [1.0; 3]));
    let mut shape = Shape::default();
    for i in -1..=2 {
        for axis in 0..3 {
            let [n, u, v] = [0, 1, 2].map(|k| DVec3::AXES[(axis + k) % 3]);
            shape.append(Shape::parallelogram(n * f64::from(i) + (u + v) * 0.5, u * 1.5, v * 1.5).bare());
        }
    }
    b.add("lattice", shape, light);
    let mut scene = b.finish();
    scene.cameras.push(orthographic(DAffine3::from_translation(DVec3::new(0.5, 0.5, 4.0)), 1.5));
    scene
}

/// Placements of [`instance_vs_baked`]: of a mesh of radius 1000 where even, of radius 1/1000 where
/// odd.
fn placements() -> impl Iterator<Item = DAffine3> {
    (0..8).map(|k| {
        let at = DVec3::new(f64::from(k % 4) * 2.2 - 3.3, 0.0, f64::from(k / 4) * 2.2 - 1.1);
        let stretch = DVec3::new(1.0, 0.4 + 0.1 * f64::from(k), if k % 3 == 1 { -0.8 } else { 0.9 });
        let [turn, lean] =
            [1.0, 0.37].map(|f| DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 0.5).normalize(), f * f64::from(k)));
        let scale = if k % 2 == 0 { 1e-3 } else { 1e3 };
        DAffine3::from_rotation_translation(turn, at)
            * DAffine3::from_scale(stretch * scale)
            * DAffine3::from_quat(lean)
    })
}

/// Balls with smooth normals under a lamp and on a floor.
pub fn instance_vs_baked() -> Scene {
    let mut b = Builder::new("instance-vs-baked");
    let floor = b.material(lambert("floor", [0.5; 3]));
    let matt = b.material(lambert("ball", [0.8, 0.6, 0.3]));
    let lamp = b.material(emitter("lamp", [6.0, 5.0, 4.0]));
    b.add("floor", Shape::parallelogram(DVec3::NEG_Y, DVec3::X * 6.0, DVec3::NEG_Z * 4.0), floor);
    b.add("lamp", Shape::parallelogram(DVec3::new(-2.0, 5.0, 1.0), DVec3::X, DVec3::Z), lamp);
    let meshes = [1e3, 1e-3].map(|radius| b.mesh("ball", Shape::icosphere(2).placed(radius, DVec3::ZERO), matt));
    for (k, to_world) in placements().enumerate() {
        b.place(meshes[k % 2], to_world);
    }
    b.camera(DVec3::new(0.0, 4.0, 8.0), DVec3::ZERO, 40.0, 1.5);
    b.finish()
}

/// The duplicated part of [`coplanar_twins`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DuplicatedPart {
    /// Nothing.
    None,
    /// The reflecting surfaces.
    Surfaces,
    /// The lamp.
    Lamp,
}

/// A block on a floor under a lamp, part of it twice in the same place.
pub fn coplanar_twins(duplicated: DuplicatedPart) -> Scene {
    let mut b = Builder::new("coplanar-twins");
    let floor = b.material(lambert("floor", [0.5, 0.6, 0.7]));
    let block = b.material(lambert("block", [0.8, 0.5, 0.3]));
    let lamp = b.material(emitter("lamp", [8.0, 7.0, 6.0]));
    let surfaces = if duplicated == DuplicatedPart::Surfaces { 2 } else { 1 };
    for _ in 0..surfaces {
        b.add("floor", Shape::parallelogram(DVec3::NEG_Y, DVec3::X * 4.0, DVec3::NEG_Z * 4.0), floor);
        b.add("block", Shape::cuboid(DVec3::new(-1.0, -1.0, -0.7), DVec3::new(0.6, 0.5, 0.7)), block);
    }
    for _ in 0..if duplicated == DuplicatedPart::Lamp { 2 } else { 1 } {
        b.add("lamp", Shape::parallelogram(DVec3::new(1.0, 3.0, 1.0), DVec3::X, DVec3::Z), lamp);
    }
    b.camera(DVec3::new(1.0, 2.0, 6.0), DVec3::ZERO, 40.0, 1.0);
    b.finish()
}

/// A ball as it should be, and one that an exporter has turned inside out.
pub fn shading_normal_flip() -> Scene {
    let mut b = Builder::new("shading-normal-flip");
    let white = b.material(lambert("white", [1.0; 3]));
    let ball = Shape::icosphere(1);
    for (k, x) in [-1.3, 1.3].into_iter().enumerate() {
        b.add(["smooth", "turned over"][k], ball.clone().placed(1.0, DVec3::X * x), white);
    }
    b.camera(DVec3::new(0.0, 0.0, 8.0), DVec3::ZERO, 36.0, 1.5);
    let mut scene = b.finish();
    for normal in scene.meshes[1].normals.iter_mut().flatten() {
        *normal = -*normal;
    }
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}
