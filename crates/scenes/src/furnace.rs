//! A closed room in which everything has the same radiance, whatever its material: the picture is
//! uniform.
//!
//! **Known in closed form.** Where every surface is Lambertian and emits Le = L·(1 − ρ), the
//! radiance is L everywhere and in every direction, exactly: L = Le + ρ·L is the rendering equation
//! of a closed room, so that L = Le/(1 − ρ) for each surface by itself. Here L = [`RADIANCE`], and
//! room, ball and block have different ρ (each with 1 − ρ exact in f32). A trace of a contour means
//! light lost or gained. With at most D scattering events a surface ρ among walls ρ shows L·(1 −
//! ρ^(D+1)): the partial sum of the series ([`after_bounces`], [`bare_room`]).

use glam::{DAffine3, DQuat, DVec3};
use surelight_scene::{Material, Scene};

use crate::builder::{Builder, lambert};
use crate::shapes::Shape;

/// The radiance that every pixel shows, linear Rec. 709.
pub const RADIANCE: [f32; 3] = [0.5, 0.25, 0.125];

/// Reflectance of the room's walls.
pub const WALL_REFLECTANCE: f32 = 0.5;

/// Reflectance and self-emission such that L = Le/(1 − ρ).
fn balanced(name: &str, reflectance: f32) -> Material {
    Material { emissive: RADIANCE.map(|l| l * (1.0 - reflectance)), ..lambert(name, [reflectance; 3]) }
}

/// A room of 2 m with a ball (ρ = 0.75) and a tilted block (ρ = 0.25) in it.
pub fn furnace() -> Scene {
    let mut b = room();
    let ball = b.material(balanced("ball", 0.75));
    let block = b.material(balanced("block", 0.25));
    b.add("ball", Shape::icosphere(3).placed(0.35, DVec3::new(-0.35, -0.45, -0.3)), ball);
    let turn = DAffine3::from_rotation_translation(DQuat::from_rotation_y(0.5), DVec3::new(0.4, -0.5, -0.35));
    let cube = Shape::cuboid(DVec3::new(-0.25, -0.3, -0.25), DVec3::new(0.25, 0.3, 0.25));
    b.add("block", cube.transformed(&turn), block);
    b.finish()
}

/// The same room empty: every surface has ρ = [`WALL_REFLECTANCE`].
pub fn bare_room() -> Scene {
    room().finish()
}

/// The radiance of the bare room with at most `bounces` scattering events: Le·Σ ρᵏ for k = 0 …
/// `bounces`.
pub fn after_bounces(bounces: u32) -> [f64; 3] {
    let kept = 1.0 - f64::from(WALL_REFLECTANCE).powi(bounces as i32 + 1);
    RADIANCE.map(|l| f64::from(l) * kept)
}

fn room() -> Builder {
    let mut b = Builder::new("furnace");
    let wall = b.material(balanced("wall", WALL_REFLECTANCE));
    b.add("room", Shape::cuboid(DVec3::splat(-1.0), DVec3::splat(1.0)).turned_over(), wall);
    b.camera(DVec3::new(0.3, 0.25, 0.9), DVec3::new(0.0, -0.35, -0.3), 60.0, 1.0);
    b
}
