//! A still life for the front page: glass, metal, cloth, wood and lamplight on one table.
//!
//! A carafe and a ball of clear glass with their caustics, a bowl of brushed copper (anisotropy),
//! velvet (sheen), a table whose wood is a texture painted by code, a lamp whose shade glows
//! (diffuse transmission), and a window through which the evening sun shines. Warm light comes from
//! the sun and the lamp, cool light from the sky, as a photographer would place them: the sun from
//! behind makes the glass glow, a panel beside the camera fills the shadows.
//!
//! The picture has no closed form. `cargo xtask gallery` renders it.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DAffine3, DQuat, DVec2, DVec3};
use surelight_scene::{
    Anisotropy, Camera, ClipRange, Filter, Image, Light, LightKind, Material, Projection, Scene, Sheen, Volume,
};

use crate::builder::{Builder, emitter, glass as clear_glass, lambert, look_at, metal};
use crate::paint::{paint, smoothstep, srgb};
use crate::random::{fractal_noise, noise};
use crate::shapes::Shape;

/// The wall with the window lies in this plane of constant z.
const WALL: f64 = -0.95;
/// The window's opening: lower left and upper right corner, as (x, y).
const OPENING: [DVec2; 2] = [DVec2::new(-1.02, 0.06), DVec2::new(-0.08, 1.15)];
/// Half the size of the table's top in x and z.
const TABLE: DVec2 = DVec2::new(0.95, 0.46);
/// Half the width of the velvet runner.
const RUNNER_HALF_WIDTH: f64 = 0.23;
/// The runner's middle line in x.
const RUNNER_X: f64 = 0.25;
/// Middle of the bowl's foot on the table, as (x, z).
const BOWL: DVec2 = DVec2::new(0.24, 0.12);

/// The scene.
pub fn still_life() -> Scene {
    let mut b = Builder::new("still life");
    room(&mut b);
    table(&mut b);
    velvet(&mut b);
    glass(&mut b);
    copper_bowl(&mut b);
    lamp(&mut b);
    b.camera(DVec3::new(0.06, 0.40, 1.62), DVec3::new(0.035, 0.138, 0.0), 24.0, 1.5);
    let mut scene = b.finish();
    scene.cameras.push(Camera {
        name: "detail".to_owned(),
        to_world: look_at(DVec3::new(-0.36, 0.27, 0.98), DVec3::new(-0.125, 0.07, 0.12)),
        projection: Projection::Perspective { yfov: 24f64.to_radians(), aspect: Some(1.5) },
        clip: ClipRange::NONE,
    });
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional { direction: DVec3::new(0.42, -0.40, 0.80).normalize() },
        intensity: [12.5, 8.6, 4.7],
    });
    scene
}

/// The wall with its window, the sky and hills beyond, the floor, and the panel that fills the
/// shadows.
fn room(b: &mut Builder) {
    let plaster = b.material(lambert("plaster", [0.30, 0.37, 0.42]));
    let paint_white = b.material(lambert("window frame", [0.70, 0.68, 0.64]));
    let floor = b.material(lambert("floor", [0.16, 0.11, 0.08]));
    let [low, high] = OPENING;
    let wall = |x0: f64, x1: f64, y0: f64, y1: f64| {
        let center = DVec3::new(0.5 * (x0 + x1), 0.5 * (y0 + y1), WALL);
        Shape::parallelogram(center, DVec3::X * (0.5 * (x1 - x0)), DVec3::Y * (0.5 * (y1 - y0)))
    };
    b.add("wall left of the window", wall(-2.4, low.x, -0.8, 2.2), plaster);
    b.add("wall right of the window", wall(high.x, 2.4, -0.8, 2.2), plaster);
    b.add("wall below the window", wall(low.x, high.x, -0.8, low.y), plaster);
    b.add("wall above the window", wall(low.x, high.x, high.y, 2.2), plaster);
    let ground = DVec3::new(0.0, -0.8, 0.6);
    b.add("floor", Shape::parallelogram(ground, DVec3::X * 2.4, DVec3::NEG_Z * 1.6), floor);

    // Frame and bars fill the depth of the reveal.
    let middle = DVec2::new(0.5 * (low.x + high.x), 0.40);
    for (name, x, y, z) in [
        ("sill", [low.x - 0.05, high.x + 0.05], [low.y - 0.03, low.y], [WALL - 0.12, WALL + 0.06]),
        ("lintel", [low.x, high.x], [high.y, high.y + 0.03], [WALL - 0.12, WALL + 0.01]),
        ("left jamb", [low.x - 0.03, low.x], [low.y, high.y], [WALL - 0.12, WALL + 0.01]),
        ("right jamb", [high.x, high.x + 0.03], [low.y, high.y], [WALL - 0.12, WALL + 0.01]),
        ("mullion", [middle.x - 0.014, middle.x + 0.014], [low.y, high.y], [WALL - 0.10, WALL - 0.06]),
        ("transom", [low.x, high.x], [middle.y - 0.012, middle.y + 0.012], [WALL - 0.10, WALL - 0.06]),
    ] {
        b.add(name, Shape::cuboid(DVec3::new(x[0], y[0], z[0]), DVec3::new(x[1], y[1], z[1])), paint_white);
    }

    // Below the sun's rays, as far as the camera sees through the window.
    let view = b.texture(evening(), Filter::Linear);
    let sky = b.material(Material { emissive_texture: Some(view), ..emitter("sky and hills", [1.25; 3]) });
    let backdrop = Shape::parallelogram(DVec3::new(-1.7, 0.25, -4.0), DVec3::X * 2.6, DVec3::Y * 1.2);
    b.add("sky and hills", backdrop, sky);
    let zenith = b.material(emitter("upper sky", [1.3, 1.9, 3.0]));
    let upper = Shape::panel(DVec3::new(-1.5, 4.2, -3.4), DVec3::new(-0.5, 0.6, WALL), 2.2, 1.2);
    b.add("upper sky", upper, zenith);

    let strip = b.material(emitter("strip light", [7.0, 7.2, 7.6]));
    b.add("strip light", Shape::panel(DVec3::new(-1.15, 0.75, 1.75), DVec3::new(0.1, 0.1, 0.0), 0.09, 0.6), strip);
    let fill = b.material(emitter("fill", [2.6, 2.7, 2.9]));
    b.add("fill", Shape::panel(DVec3::new(1.7, 1.2, 2.3), DVec3::new(0.1, 0.1, 0.0), 0.7, 0.9), fill);
}

/// The view from the window: a sky that pales towards two ranges of hills.
fn evening() -> Image {
    paint("evening", 384, 192, |u, v| {
        let (blue, pale) = (DVec3::new(0.20, 0.40, 0.85), DVec3::new(1.0, 0.80, 0.58));
        let ridge =
            |height: f64, scale: f64, seed: f64| height - 0.06 * fractal_noise(DVec3::new(u * scale, seed, 0.5), 5);
        let sky = pale.lerp(blue, smoothstep(0.0, 0.62, 0.62 - v));
        let far = DVec3::new(0.30, 0.36, 0.44);
        let near = DVec3::new(0.085, 0.11, 0.10);
        let edge = |at: f64| smoothstep(at - 0.004, at + 0.004, v);
        srgb(sky.lerp(far, edge(ridge(0.60, 5.0, 3.0))).lerp(near, edge(ridge(0.70, 8.0, 9.0))))
    })
}

/// The table: a top of oak planks, and an apron below it.
fn table(b: &mut Builder) {
    let grain = b.texture(planks(), Filter::Linear);
    let oak = b.material(Material {
        base_color_texture: Some(grain),
        metallic: 0.0,
        roughness: 0.36,
        double_sided: true,
        ..Material { name: "oak".to_owned(), ..Material::default() }
    });
    let thickness = 0.035;
    let half = DVec3::new(TABLE.x, 0.0, TABLE.y);
    b.add("table top", Shape::parallelogram(DVec3::ZERO, DVec3::X * half.x, DVec3::NEG_Z * half.z), oak);
    let edge = DVec3::new(0.0, -0.5 * thickness, half.z);
    b.add("table edge", Shape::parallelogram(edge, DVec3::X * half.x, DVec3::Y * (0.5 * thickness)), oak);
    let wood = b.material(lambert("apron", [0.16, 0.085, 0.045]));
    let low = DVec3::new(0.06 - half.x, -0.12, 0.06 - half.z);
    b.add("apron", Shape::cuboid(low, DVec3::new(half.x - 0.06, -thickness, half.z - 0.05)), wood);
}

/// Planks along u, with annual rings, fibres and the gaps between them.
fn planks() -> Image {
    const PLANKS: f64 = 6.0;
    paint("oak", 1024, 512, |u, v| {
        let row = (v * PLANKS).floor();
        let across = v * PLANKS - row;
        let p = DVec3::new(u * 2.2, across * 0.9, row * 7.3);
        let bend = fractal_noise(p + DVec3::splat(2.0), 4);
        let ring = 0.5 + 0.5 * (TAU * (4.0 * across + 1.7 * bend + 0.37 * row)).sin();
        let fibre = 0.5 + 0.5 * noise(DVec3::new(u * 40.0, v * 420.0, 1.0));
        let tone = 0.5 + 0.5 * noise(DVec3::new(row * 3.1, 0.5, 4.5));
        let (dark, light) = (DVec3::new(0.17, 0.075, 0.030), DVec3::new(0.42, 0.225, 0.105));
        let color = dark.lerp(light, 0.25 + 0.45 * ring.powf(0.7) + 0.30 * fibre) * (0.75 + 0.4 * tone);
        let gap = smoothstep(0.0, 0.014, across.min(1.0 - across));
        srgb(color * (0.12 + 0.88 * gap))
    })
}

/// A runner of velvet that lies in folds and hangs over the table's front edge.
fn velvet(b: &mut Builder) {
    let velvet = b.material(Material {
        sheen: Sheen { color: [0.42, 0.50, 0.85], roughness: 0.38, ..Sheen::default() },
        ..lambert("velvet", [0.012, 0.022, 0.075])
    });
    let cloth = Shape::sheet(90, 190, |u, v| {
        let across = (u - 0.5) * 2.0 * RUNNER_HALF_WIDTH;
        let along = v * 1.02;
        let (flat, bend) = (0.72, 0.016);
        let quarter = bend * 0.5 * PI;
        // The middle line: flat, around the edge, down.
        let z_edge = TABLE.y;
        let (line, normal) = if along < flat {
            (DVec2::new(z_edge - flat + along, 0.0), DVec2::Y)
        } else if along < flat + quarter {
            let (sin, cos) = ((along - flat) / bend).sin_cos();
            (DVec2::new(z_edge + bend * sin, bend * (cos - 1.0)), DVec2::new(sin, cos))
        } else {
            (DVec2::new(z_edge + bend, -bend - (along - flat - quarter)), DVec2::X)
        };
        let hang = smoothstep(flat - 0.05, flat + 0.25, along);
        let x = across + 0.02 * noise(DVec3::new(along * 5.0, 3.0, across * 4.0)) + 0.03 * (along - 0.4);
        let wander = noise(DVec3::new(across * 5.0, along * 4.0, 8.0));
        let wave = 0.5 + 0.5 * (TAU * (across * 9.0 + 0.35 * wander + 0.5 * along)).sin();
        let crease = 0.5 + 0.5 * (TAU * (along * 4.2 + across * 3.0 + 0.8 * wander)).sin();
        let base = (line.x - BOWL.y).hypot(x + RUNNER_X - BOWL.x);
        let free = smoothstep(0.085, 0.20, base);
        let fold = free * (0.016 * crease.powi(4) * (1.0 - hang) + 0.022 * wave.powi(2) * (0.12 + hang));
        let lift = 0.004 + fold;
        DVec3::new(RUNNER_X + x, line.y + normal.y * lift, line.x + normal.x * lift)
    });
    // The sheet's front lies below: u runs to the right, v towards the camera.
    b.add("velvet runner", cloth.turned_over(), velvet);
}

/// A carafe and a ball of clear glass.
fn glass(b: &mut Builder) {
    let clear = Volume { attenuation_distance: 0.25, attenuation_color: [0.80, 0.93, 0.90] };
    let crystal = b.material(clear_glass("clear glass", 1.5, clear));
    let outer = [
        (0.0, 0.0),
        (0.040, 0.0),
        (0.047, 0.003),
        (0.054, 0.012),
        (0.064, 0.035),
        (0.068, 0.060),
        (0.064, 0.088),
        (0.052, 0.115),
        (0.038, 0.140),
        (0.028, 0.163),
        (0.0235, 0.185),
        (0.0235, 0.205),
        (0.027, 0.225),
        (0.034, 0.243),
        (0.0385, 0.252),
    ];
    let inner = [
        (0.0365, 0.2525),
        (0.0315, 0.243),
        (0.0245, 0.225),
        (0.0208, 0.205),
        (0.0208, 0.185),
        (0.0252, 0.163),
        (0.035, 0.140),
        (0.0488, 0.115),
        (0.0605, 0.088),
        (0.0643, 0.060),
        (0.0602, 0.037),
        (0.050, 0.019),
        (0.036, 0.012),
        (0.015, 0.010),
        (0.0, 0.010),
    ];
    let profile: Vec<DVec2> = spline(&outer, 6).into_iter().chain(spline(&inner, 6)).collect();
    let gap = 1e-3;
    let carafe = Shape::revolved(&profile, 160);
    b.add("carafe", carafe.placed(1.0, DVec3::new(-0.155, gap, 0.02)), crystal);
    b.add("ball", Shape::icosphere(5).placed(0.043, DVec3::new(-0.025, 0.043 + gap, 0.225)), crystal);
}

/// A bowl of brushed copper on the velvet, with lemons in and beside it.
fn copper_bowl(b: &mut Builder) {
    let copper = b.material(Material {
        // Brushed around the axis, so that highlights spread across the grooves.
        anisotropy: Anisotropy { strength: 0.8, rotation: FRAC_PI_2 as f32, ..Anisotropy::default() },
        ..metal("brushed copper", [0.93, 0.58, 0.42], 0.07)
    });
    let profile = [
        (0.0, 0.006),
        (0.030, 0.006),
        (0.042, 0.004),
        (0.046, 0.0),
        (0.048, 0.004),
        (0.046, 0.012),
        (0.060, 0.022),
        (0.085, 0.045),
        (0.102, 0.075),
        (0.108, 0.098),
        (0.1085, 0.100),
        (0.107, 0.101),
        (0.104, 0.098),
        (0.097, 0.075),
        (0.080, 0.047),
        (0.055, 0.026),
        (0.030, 0.018),
        (0.0, 0.016),
    ];
    let bowl = Shape::revolved(&spline(&profile, 5), 160);
    let at = DVec3::new(BOWL.x, 0.0055, BOWL.y);
    b.add("bowl", bowl.placed(1.0, at), copper);

    let lemon = b.material(Material {
        name: "lemon".into(),
        base_color: [0.80, 0.50, 0.035, 1.0],
        metallic: 0.0,
        roughness: 0.38,
        double_sided: true,
        ..Material::default()
    });
    for (index, (place, yaw, roll)) in [
        (at + DVec3::new(-0.036, 0.058, 0.020), 0.5, 0.15),
        (at + DVec3::new(0.040, 0.060, 0.012), -0.9, 0.2),
        (at + DVec3::new(0.002, 0.066, -0.045), 1.9, -0.1),
        (at + DVec3::new(0.002, 0.108, 0.002), 0.25, 0.35),
        (DVec3::new(-0.305, 0.0335, 0.17), -0.55, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        let turn = DQuat::from_rotation_y(yaw) * DQuat::from_rotation_z(roll + 0.5 * PI);
        let place = DAffine3::from_rotation_translation(turn, place);
        b.add("lemon", fruit(index as f64).transformed(&place), lemon);
    }
}

/// A lemon about the y axis, pores and all.
fn fruit(seed: f64) -> Shape {
    Shape::sheet(96, 96, |u, v| {
        let (sin_phi, cos_phi) = (u * TAU).sin_cos();
        let theta = (0.004 + 0.992 * v) * PI;
        let (sin, cos) = theta.sin_cos();
        // An ellipsoid with a nipple at either end.
        let tip = smoothstep(0.80, 1.0, cos.abs());
        let n = DVec3::new(sin * cos_phi, cos, -sin * sin_phi);
        let pores = 0.00035 * noise(n * 38.0 + DVec3::splat(seed * 11.0));
        let shape = 0.0010 * fractal_noise(n * 2.0 + DVec3::splat(seed * 5.0), 2);
        let radius = 0.0325 + pores + shape;
        DVec3::new(n.x * radius, -n.y * (0.039 + 0.0065 * tip), n.z * radius)
    })
}

/// A lamp of brass with a linen shade, its bulb inside.
fn lamp(b: &mut Builder) {
    let brass = b.material(metal("brass", [0.88, 0.68, 0.36], 0.08));
    let glow = b.texture(lit_linen(), Filter::Linear);
    let linen = b.material(Material {
        emissive_texture: Some(glow),
        base_color: [0.55, 0.46, 0.34, 1.0],
        ..emitter("linen shade", [2.5, 1.32, 0.50])
    });
    let bulb = b.material(emitter("bulb", [250.0, 146.0, 64.0]));
    let at = DVec3::new(0.49, 0.0, -0.27);
    let stem = [
        (0.0, 0.0),
        (0.060, 0.0),
        (0.064, 0.004),
        (0.062, 0.010),
        (0.040, 0.018),
        (0.016, 0.028),
        (0.011, 0.045),
        (0.018, 0.075),
        (0.024, 0.100),
        (0.018, 0.125),
        (0.009, 0.150),
        (0.007, 0.20),
        (0.007, 0.255),
        (0.0, 0.256),
    ];
    b.add("lamp stem", Shape::revolved(&spline(&stem, 5), 64).placed(1.0, at + DVec3::Y * 1e-3), brass);
    let shade = [DVec2::new(0.130, 0.225), DVec2::new(0.085, 0.385)];
    b.add("lamp shade", Shape::revolved(&shade, 96).placed(1.0, at), linen);
    b.add("bulb", Shape::icosphere(2).placed(0.021, at + DVec3::Y * 0.285), bulb);
}

/// What shines through the shade: brightest beside the bulb, with the weave of the cloth.
fn lit_linen() -> Image {
    paint("linen", 256, 128, |u, v| {
        let height = 1.0 - v;
        let fall = (-((height - 0.38) / 0.42).powi(2)).exp();
        let weave =
            0.03 * noise(DVec3::new(u * 256.0, v * 6.0, 2.0)) + 0.03 * noise(DVec3::new(u * 20.0, v * 128.0, 7.0));
        let hem = if !(0.035..0.965).contains(&v) { 0.35 } else { 1.0 };
        srgb(DVec3::splat(((0.16 + 0.80 * fall + weave) * hem).clamp(0.0, 1.0)))
    })
}

/// Points on the Catmull–Rom spline through `points`, `steps` a segment.
fn spline(points: &[(f64, f64)], steps: u32) -> Vec<DVec2> {
    let at = |i: isize| {
        let (x, y) = points[i.clamp(0, points.len() as isize - 1) as usize];
        DVec2::new(x, y)
    };
    let mut curve = Vec::new();
    for i in 0..points.len() as isize - 1 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for k in 0..steps {
            let t = f64::from(k) / f64::from(steps);
            let p = b * 2.0
                + (c - a) * t
                + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t)
                + (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
            curve.push((p * 0.5).max(DVec2::ZERO));
        }
    }
    curve.push(at(points.len() as isize - 1));
    curve
}
