//! A corner of a room for the texture slots: base colour, metallic-roughness, normal map, alpha
//! mask.
//!
//! The floor is a nearest-filtered checker repeated by KHR_texture_transform; the ball is copper
//! with a patina, one noise deciding base colour, metalness and roughness together; the wall is
//! tiled by a normal map; the screen is a lattice cut out by alpha.
//!
//! **Known in closed form.** Texel counts under nearest filtering: the checker's squares are equal,
//! so that the floor's mean reflectance is the mean of its two colours ([`FLOOR_COLORS`], as far as
//! 8-bit sRGB holds them); the screen lets through exactly the share of its texels below the cutoff
//! ([`screen_openness`]). The picture has no closed form.

use glam::{Affine2, DAffine3, DQuat, DVec3, Vec2};
use surelight_scene::{AlphaMode, Filter, Image, Material, NormalTexture, Scene};

use crate::builder::{Builder, emitter, lambert};
use crate::paint::{encode_normal, paint, smoothstep, srgb};
use crate::random::fractal_noise;
use crate::shapes::Shape;

/// Linear colours of the checker.
pub const FLOOR_COLORS: [[f64; 3]; 2] = [[0.62, 0.57, 0.48], [0.085, 0.10, 0.125]];

/// Tiles along a side of the normal map.
const TILES: f64 = 4.0;

/// The scene.
pub fn textured() -> Scene {
    let mut b = Builder::new("textured");

    let mut checker = b.texture(checker_image(), Filter::Nearest);
    checker.transform = Some(Affine2::from_scale(Vec2::splat(5.0)));
    let floor = b.material(Material { base_color_texture: Some(checker), ..white("floor", 0.35) });
    let normal = b.texture(tile_normals(), Filter::Linear);
    let wall = b.material(Material {
        base_color: [0.055, 0.16, 0.20, 1.0],
        normal_texture: Some(NormalTexture { texture: normal, scale: 1.0 }),
        ..white("tiles", 0.22)
    });
    let color = b.texture(patina_colors(), Filter::Linear);
    let surface = b.texture(patina_surface(), Filter::Linear);
    let patina = b.material(Material {
        base_color_texture: Some(color),
        metallic: 1.0,
        metallic_roughness_texture: Some(surface),
        ..white("copper and patina", 1.0)
    });
    let lattice = b.texture(lattice_image(), Filter::Nearest);
    let screen = b.material(Material {
        base_color_texture: Some(lattice),
        alpha_mode: AlphaMode::Mask(0.5),
        ..white("screen", 0.6)
    });
    let plaster = b.material(lambert("plaster", [0.66, 0.60, 0.53]));
    let light = b.material(emitter("lamp", [150.0, 128.0, 100.0]));
    let sky = b.material(emitter("window", [2.4, 3.0, 3.9]));

    b.add("floor", Shape::parallelogram(DVec3::new(0.0, 0.0, 0.5), DVec3::X * 2.5, DVec3::NEG_Z * 2.5), floor);
    b.add("back wall", Shape::parallelogram(DVec3::new(0.0, 1.5, -2.0), DVec3::X * 2.5, DVec3::Y * 1.5), wall);
    b.add("left wall", Shape::parallelogram(DVec3::new(-2.5, 1.5, 0.5), DVec3::NEG_Z * 2.5, DVec3::Y * 1.5), plaster);
    let turn = DQuat::from_rotation_y(2.1);
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(0.62), turn, DVec3::new(-0.55, 0.62, -0.55));
    b.add("ball", Shape::uv_sphere(64, 32).transformed(&place), patina);
    let turn = DQuat::from_rotation_y(-0.62);
    let card = Shape::parallelogram(DVec3::Y * 0.86, DVec3::X * 0.55, DVec3::Y * 0.85);
    let place = DAffine3::from_rotation_translation(turn, DVec3::new(1.12, 0.0, -0.25));
    b.add("screen", card.transformed(&place), screen);

    b.add("lamp", Shape::panel(DVec3::new(2.3, 3.0, -1.2), DVec3::new(0.2, 0.3, 0.2), 0.3, 0.3), light);
    b.add("window", Shape::panel(DVec3::new(-0.8, 3.2, 3.4), DVec3::new(0.0, 0.5, -0.6), 1.6, 1.1), sky);
    b.camera(DVec3::new(0.75, 1.35, 3.7), DVec3::new(0.08, 0.74, -0.5), 36.0, 4.0 / 3.0);
    b.finish()
}

/// Share of the screen through which light passes.
pub fn screen_openness() -> f64 {
    let image = lattice_image();
    let open = image.rgba.chunks_exact(4).filter(|t| t[3] < 128).count();
    open as f64 / (image.rgba.len() / 4) as f64
}

fn white(name: &str, roughness: f32) -> Material {
    Material { name: name.to_owned(), metallic: 0.0, roughness, double_sided: true, ..Material::default() }
}

fn checker_image() -> Image {
    paint("checker", 2, 2, |u, v| {
        let odd = (u < 0.5) != (v < 0.5);
        srgb(DVec3::from(FLOOR_COLORS[usize::from(odd)]))
    })
}

/// Square tiles with rounded edges, every one tilted a little its own way.
fn tile_normals() -> Image {
    paint("tile normals", 256, 256, |u, v| {
        let (x, y) = (u * TILES, v * TILES);
        let (column, row) = (x.floor(), y.floor());
        // Position within the tile, −1 … 1; the bevel is a quarter circle over the outer tenth.
        let bevel = |t: f64| {
            let d = 2.0 * (t - t.floor()) - 1.0;
            let over = ((d.abs() - 0.88) / 0.12).max(0.0);
            over * 0.85 * d.signum()
        };
        let tilt = |k: f64| 0.035 * fractal_noise(DVec3::new(column * 3.7, row * 5.3, k), 1);
        // v points down, the bitangent up.
        encode_normal(DVec3::new(bevel(x) + tilt(0.5), -bevel(y) + tilt(9.5), 1.0))
    })
}

/// How far copper has turned green at a point of the map, 0 … 1; evaluated on the sphere, so that
/// no seam shows.
fn patina_cover(u: f64, v: f64) -> f64 {
    let (sin_phi, cos_phi) = (u * std::f64::consts::TAU).sin_cos();
    let (sin_theta, cos_theta) = (v * std::f64::consts::PI).sin_cos();
    let p = DVec3::new(-sin_theta * cos_phi, cos_theta, sin_theta * sin_phi);
    smoothstep(0.02, 0.22, fractal_noise(p * 2.3 + DVec3::splat(4.0), 5) + 0.25 * cos_theta)
}

fn patina_colors() -> Image {
    let (copper, green) = (DVec3::new(0.95, 0.50, 0.33), DVec3::new(0.14, 0.40, 0.33));
    paint("patina colour", 192, 96, |u, v| srgb(copper.lerp(green, patina_cover(u, v))))
}

/// G: roughness, B: metalness.
fn patina_surface() -> Image {
    paint("patina surface", 192, 96, |u, v| {
        let cover = patina_cover(u, v);
        [0.0, 0.24 + 0.66 * cover, 1.0 - cover, 1.0]
    })
}

/// A lattice of rings: alpha 1 where there is wood, 0 in the openings.
fn lattice_image() -> Image {
    let wood = srgb(DVec3::new(0.30, 0.125, 0.05));
    paint("lattice", 192, 288, |u, v| {
        let (x, y) = (u * 4.0, v * 6.0);
        let frame = x.min(4.0 - x).min(y).min(6.0 - y) < 0.14;
        // Overlapping circles about every lattice point and about every middle.
        let ring = |ox: f64, oy: f64| {
            let d = |t: f64, o: f64| (t + o) - (t + o).round();
            let radius = d(x, ox).hypot(d(y, oy));
            (radius - 0.42).abs() < 0.06
        };
        let there = frame || ring(0.0, 0.0) || ring(0.5, 0.5);
        [wood[0], wood[1], wood[2], f64::from(u8::from(there))]
    })
}
