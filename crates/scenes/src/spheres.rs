//! A chart of balls: metalness upwards, roughness to the right.
//!
//! Meant for [`sky`] (`--env assets/sky.exr`); its own soft box lights it when rendered alone.
//!
//! **Known in closed form.** A ball of metalness 1 and roughness 0 is a mirror: it reflects the
//! radiance in the mirrored direction times Schlick's F(θ) = F0 + (1 − F0)(1 − cosθ)⁵, F0 =
//! [`BASE_COLOR`]. Under a uniform environment of radiance 1 a metal of roughness r has the
//! directional albedo of GGX with α = r² (by quadrature) as its radiance, since balls do not
//! reflect one another in the limit of wide spacing. [`sky_irradiance`] is the irradiance of a
//! horizontal floor under the open sky.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec3};
use surelight_scene::{EnvironmentMap, Material, Scene};

use crate::builder::{Builder, emitter, lambert};
use crate::paint::smoothstep;
use crate::shapes::Shape;

/// Base colour of every ball, linear: gold when metallic.
pub const BASE_COLOR: [f32; 3] = [1.0, 0.71, 0.29];

/// Roughness steps, 0 … 1.
pub const COLUMNS: usize = 9;

/// Metalness steps, 0 … 1 from the bottom row to the top one.
pub const ROWS: usize = 5;

/// The closed form of [`sky`].
pub const SKY_KNOWN: &str = "A horizontal floor under the open sky receives Σ L·cosθ·ΔΩ over the upper texels: \
                             (0.986, 1.077, 1.536).";

/// Direction of the sun in [`sky`].
const SUN: DVec3 = DVec3::new(-0.52, 0.62, 0.59);

/// The scene.
pub fn spheres() -> Scene {
    let mut b = Builder::new("spheres");
    let spacing = 1.12;
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let metallic = row as f32 / (ROWS - 1) as f32;
            let roughness = column as f32 / (COLUMNS - 1) as f32;
            let name = format!("metallic {metallic} roughness {roughness}");
            let [r, g, bl] = BASE_COLOR;
            let material = b.material(Material {
                name: name.clone(),
                base_color: [r, g, bl, 1.0],
                metallic,
                roughness,
                ..Material::default()
            });
            let mesh = b.mesh(&name, Shape::icosphere(3), material);
            let x = (column as f64 - (COLUMNS - 1) as f64 / 2.0) * spacing;
            let at = DVec3::new(x, 0.55 + row as f64 * spacing, -0.35 * row as f64);
            b.place(mesh, DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.5)));
        }
    }
    let studio = b.material(lambert("studio", [0.30, 0.31, 0.33]));
    b.add("studio", Shape::cyclorama(16.0, 8.0, 6.0, 2.5, 12.0), studio);
    let light = b.material(emitter("soft box", [7.0, 6.7, 6.3]));
    let middle = DVec3::new(0.0, 2.4, -0.7);
    b.add("soft box", Shape::panel(DVec3::new(4.5, 9.5, 8.0), middle, 3.4, 2.2), light);
    let strip = b.material(emitter("strip", [2.4, 3.0, 3.9]));
    b.add("strip", Shape::panel(DVec3::new(-11.0, 4.5, 5.0), middle, 1.0, 4.0), strip);
    b.camera(DVec3::new(0.0, 3.9, 15.5), DVec3::new(0.0, 2.66, 0.0), 22.5, 16.0 / 9.0);
    b.finish()
}

/// A clear late-afternoon sky, 128 × 64: pale horizon, blue zenith, a soft sun to the upper left,
/// dim ground.
pub fn sky() -> EnvironmentMap {
    let (width, height) = (128u32, 64u32);
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in 0..height {
        for column in 0..width {
            let direction = texel_direction(width, height, column, row);
            texels.push(sky_radiance(direction).to_array().map(|c| c as f32));
        }
    }
    EnvironmentMap { width, height, texels }
}

/// Irradiance of the map on a horizontal surface that faces up: Σ L cosθ ΔΩ over the texels of the
/// upper half.
pub fn sky_irradiance(map: &EnvironmentMap) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for row in 0..map.height / 2 {
        // ∫ cosθ sinθ dθ over the row, exactly.
        let edge = |k: u32| (f64::from(k) / f64::from(map.height) * PI).sin().powi(2) * 0.5;
        let weight = (edge(row + 1) - edge(row)) * TAU / f64::from(map.width);
        for column in 0..map.width {
            let texel = map.texels[(row * map.width + column) as usize];
            for c in 0..3 {
                sum[c] += f64::from(texel[c]) * weight;
            }
        }
    }
    sum
}

/// Middle of a texel: u = ½ + atan2(z, x)/2π, v = ½ − asin(y)/π.
fn texel_direction(width: u32, height: u32, column: u32, row: u32) -> DVec3 {
    let phi = ((f64::from(column) + 0.5) / f64::from(width) - 0.5) * TAU;
    let elevation = (0.5 - (f64::from(row) + 0.5) / f64::from(height)) * PI;
    DVec3::new(elevation.cos() * phi.cos(), elevation.sin(), elevation.cos() * phi.sin())
}

fn sky_radiance(d: DVec3) -> DVec3 {
    let (zenith, horizon, ground) =
        (DVec3::new(0.10, 0.22, 0.55), DVec3::new(0.85, 0.80, 0.75), DVec3::new(0.10, 0.09, 0.08));
    let air = zenith.lerp(horizon, (1.0 - d.y.max(0.0)).powi(4));
    let base = ground.lerp(air, smoothstep(-0.06, 0.03, d.y));
    let toward_sun = d.dot(SUN.normalize()).max(0.0);
    let glow = DVec3::new(1.0, 0.72, 0.42) * (0.9 * toward_sun.powi(24));
    let disc =
        DVec3::new(95.0, 78.0, 56.0) * smoothstep(5.0f64.to_radians().cos(), 2.5f64.to_radians().cos(), toward_sun);
    (base + glow + disc) * 0.65
}
