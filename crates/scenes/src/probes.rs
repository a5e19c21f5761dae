//! Small scenes for tests: each isolates one mechanism, and its answer is known.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use surelight_scene::{Camera, ClipRange, Environment, Projection, Scene, Volume};

use crate::builder::{Builder, emitter, glass, lambert, metal};
use crate::polygon_irradiance;
use crate::random::{SplitMix, fractal_noise};
use crate::shapes::Shape;

/// A diffuse ball in a uniform environment of radiance 1.
///
/// Convex, so that nothing is reflected twice: every pixel of the ball is ρ, every other one 1, and
/// under cosine sampling so is every single sample.
pub fn convex_furnace(reflectance: [f32; 3], subdivisions: u32) -> Scene {
    let mut b = Builder::new("convex-furnace");
    let material = b.material(lambert("ball", reflectance));
    // Faceted: with interpolated normals a tessellated ball is not convex to shading.
    b.add("ball", Shape::icosphere(subdivisions).faceted(), material);
    b.camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0, 1.0);
    let mut scene = b.finish();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// A floor triangle under a lamp triangle.
///
/// Only the floor reflects and the lamp is black: a floor point shows ρ/π·L·E with E from
/// [`polygon_irradiance`]; [`two_triangles_radiance`] gives it.
pub fn two_triangles() -> Scene {
    let mut b = Builder::new("two-triangles");
    let floor = b.material(lambert("floor", [0.5, 0.25, 0.75]));
    let light = b.material(emitter("light", [4.0, 8.0, 2.0]));
    let triangle =
        |positions: [DVec3; 3]| Shape { positions: positions.to_vec(), triangles: vec![[0, 1, 2]], ..Shape::default() };
    b.add("floor", triangle([(-3.0, 3.0), (3.0, 3.0), (0.0, -3.0)].map(|(x, z)| DVec3::new(x, 0.0, z))), floor);
    b.add("light", triangle(TWO_TRIANGLES_LAMP), light);
    b.camera(DVec3::new(0.0, 3.0, 3.0), DVec3::ZERO, 45.0, 1.0);
    b.finish()
}

const TWO_TRIANGLES_LAMP: [DVec3; 3] =
    [DVec3::new(-0.5, 1.0, -0.5), DVec3::new(0.5, 1.0, -0.5), DVec3::new(0.0, 1.0, 0.5)];

/// Radiance of the floor of [`two_triangles`] at (x, 0, z), a point of the floor.
pub fn two_triangles_radiance(x: f64, z: f64) -> [f64; 3] {
    let irradiance = polygon_irradiance(DVec3::new(x, 0.0, z), DVec3::Y, &TWO_TRIANGLES_LAMP);
    [0.5 * 4.0, 0.25 * 8.0, 0.75 * 2.0].map(|k| k / std::f64::consts::PI * irradiance)
}

/// A slab of glass, `thickness` metres, between two lamps, at right angles to an orthographic
/// camera.
///
/// The lamp behind the slab shines (1, 0, 1), the one behind the camera (0, 1, 1): red shows the
/// slab's transmittance, green its reflectance, blue their sum. White light is dimmed to
/// `absorption` (one factor for all channels; 1 for clear glass) on its way through.
/// [`slab_answer`] gives the values.
pub fn slab(ior: f32, thickness: f64, absorption: f32) -> Scene {
    let mut b = Builder::new("slab");
    let volume = Volume {
        attenuation_distance: if absorption < 1.0 { thickness as f32 } else { f32::INFINITY },
        attenuation_color: [absorption; 3],
    };
    let material = b.material(glass("slab", ior, volume));
    let back = b.material(emitter("lamp behind", [1.0, 0.0, 1.0]));
    let front = b.material(emitter("lamp before", [0.0, 1.0, 1.0]));
    let half = DVec3::new(100.0, 100.0, thickness / 2.0);
    b.add("slab", Shape::cuboid(-half, half), material);
    let lamp = |z: f64, u: DVec3| Shape::parallelogram(DVec3::Z * z, u * 50.0, DVec3::Y * 50.0);
    b.add("lamp behind", lamp(-4.0, DVec3::X), back);
    b.add("lamp before", lamp(4.0, DVec3::NEG_X), front);
    let mut scene = b.finish();
    scene.cameras.push(orthographic(DAffine3::from_translation(DVec3::Z * 2.0), 0.5));
    scene
}

/// Transmittance and reflectance of [`slab`], all internal reflections summed: with r = ((n −
/// 1)/(n + 1))² and one-way absorption τ, T = (1 − r)²τ/(1 − r²τ²) and R = r + r(1 − r)²τ²/(1 −
/// r²τ²); for τ = 1, R = 2r/(1 + r).
pub fn slab_answer(ior: f64, absorption: f64) -> (f64, f64) {
    let r = ((ior - 1.0) / (ior + 1.0)).powi(2);
    let series = (1.0 - r).powi(2) / (1.0 - (r * absorption).powi(2));
    (series * absorption, r + series * r * absorption * absorption)
}

/// Two facing mirrors with a lamp of radiance 1 at the end, under parallel camera rays at 45°.
///
/// Every ray is reflected `bounces` times, always at 45°, before it reaches the lamp: the picture
/// shows Fᵏ ([`mirror_corridor_radiance`]).
pub fn mirror_corridor(bounces: u32, f0: [f32; 3]) -> Scene {
    let mut b = Builder::new("mirror-corridor");
    let mirror = b.material(metal("mirror", f0, 0.0));
    let light = b.material(emitter("lamp", [1.0; 3]));
    let length = f64::from(bounces);
    let wall = |side: f64| {
        let middle = DVec3::new(0.5 * side, 0.0, 0.5 - length / 2.0);
        Shape::parallelogram(middle, DVec3::Z * side * (length / 2.0 + 0.5), DVec3::Y)
    };
    if bounces > 0 {
        b.add("right mirror", wall(1.0), mirror);
        b.add("left mirror", wall(-1.0), mirror);
    }
    b.add("lamp", Shape::parallelogram(DVec3::Z * -length, DVec3::X * 0.5, DVec3::Y), light);
    let mut scene = b.finish();
    // Half a step from a wall at first, so that it strikes a mirror every metre and the lamp in its
    // middle.
    let turn = DMat3::from_quat(DQuat::from_rotation_y(-std::f64::consts::FRAC_PI_4));
    let eye = if bounces > 0 { DVec3::ZERO } else { DVec3::new(-0.1, 0.0, 0.1) };
    scene.cameras.push(orthographic(DAffine3::from_mat3_translation(turn, eye), 0.01));
    scene
}

/// Radiance of [`mirror_corridor`], by Schlick's F at 45°.
pub fn mirror_corridor_radiance(bounces: u32, f0: [f64; 3]) -> [f64; 3] {
    let fifth = (1.0 - std::f64::consts::FRAC_1_SQRT_2).powi(5);
    f0.map(|f| (f + (1.0 - f) * fifth).powi(bounces as i32))
}

/// `n` random triangles in the cube [−1, 1]³, of every orientation and of sizes over three decades,
/// in four diffuse colours, under a uniform environment. For traversal against brute force.
pub fn soup(n: usize, seed: u64) -> Scene {
    let mut b = Builder::new("soup");
    let mut random = SplitMix::new(seed);
    let colors = [[0.7, 0.3, 0.2], [0.2, 0.6, 0.3], [0.2, 0.3, 0.7], [0.7, 0.7, 0.7]];
    let mut groups = vec![Shape::default(); colors.len()];
    for i in 0..n {
        let size = 10f64.powf(random.range(-3.0, 0.0)) * 0.5;
        let middle = random.cube();
        let shape = &mut groups[i % colors.len()];
        let base = shape.positions.len() as u32;
        shape.positions.extend([(); 3].map(|()| middle + random.cube() * size));
        shape.triangles.push([base, base + 1, base + 2]);
    }
    for (index, (shape, color)) in groups.into_iter().zip(colors).enumerate() {
        if !shape.triangles.is_empty() {
            let material = b.material(lambert(&format!("color {index}"), color));
            b.add(&format!("soup {index}"), shape, material);
        }
    }
    b.camera(DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO, 40.0, 1.0);
    let mut scene = b.finish();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

/// A rough terrain of 2·`n`² triangles under a uniform environment, `n` < 65,535: for scaling, up
/// to many millions.
pub fn terrain(n: u32) -> Scene {
    let mut b = Builder::new("terrain");
    let ground = b.material(lambert("ground", [0.5, 0.45, 0.4]));
    let height = |x: f64, z: f64| 0.12 * fractal_noise(DVec3::new(x * 2.0, 0.0, z * 2.0), 6);
    b.add("terrain", Shape::height_field(n, false, height), ground);
    b.camera(DVec3::new(0.0, 0.7, 1.5), DVec3::ZERO, 45.0, 1.5);
    let mut scene = b.finish();
    scene.environment = Some(Environment::Uniform([1.0; 3]));
    scene
}

fn orthographic(to_world: DAffine3, half: f64) -> Camera {
    let projection = Projection::Orthographic { xmag: half, ymag: half };
    Camera { name: "camera".to_owned(), to_world, projection, clip: ClipRange::NONE }
}
