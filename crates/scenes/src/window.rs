//! A sunlit room behind a window pane.
//!
//! Sun and sky reach the room through a single pane of smooth thin glass alone. Light sampling goes
//! straight through it.
//!
//! **Known in closed form.** A pane of index 1.5 transmits 1 − F(cos θ) with Fresnel's F, 0.96 at
//! normal incidence: direct sunlight in the room is that of the open window times 1 − F at
//! [`SUN_COSINE`].

use glam::DVec3;
use surelight_scene::{Light, LightKind, Material, Scene};

use crate::builder::{Builder, emitter, lambert};
use crate::shapes::Shape;

/// Cosine of the angle of incidence of sunlight on the pane: the sun shines along (−12, −9,
/// −4)/√241.
pub const SUN_COSINE: f64 = 0.772_987_951_7;

/// The scene.
pub fn window() -> Scene {
    let mut b = Builder::new("window");
    let walls = b.material(lambert("walls", [0.78, 0.75, 0.70]));
    let boards = b.material(lambert("floor", [0.46, 0.30, 0.18]));
    let wood = b.material(lambert("table", [0.32, 0.19, 0.10]));
    let rug = b.material(lambert("rug", [0.45, 0.08, 0.07]));
    let clay = b.material(Material {
        name: "glazed clay".into(),
        base_color: [0.08, 0.22, 0.36, 1.0],
        metallic: 0.0,
        roughness: 0.25,
        double_sided: true,
        ..Material::default()
    });
    let sky = b.material(emitter("sky", [2.2, 3.0, 4.2]));
    let glass = b.material(Material {
        name: "pane".into(),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        double_sided: true,
        ..Material::default()
    });

    // A room of 4 m × 2.8 m × 5 m; the window is in the wall at x = 2.
    let (low, high) = (DVec3::new(-2.0, 0.0, -3.0), DVec3::new(2.0, 2.8, 2.0));
    let wall = |center: DVec3, u: DVec3, v: DVec3| Shape::parallelogram(center, u, v);
    let half = (high - low) * 0.5;
    let middle = (low + high) * 0.5;
    b.add("floor", wall(middle.with_y(low.y), DVec3::X * half.x, DVec3::NEG_Z * half.z), boards);
    b.add("ceiling", wall(middle.with_y(high.y), DVec3::X * half.x, DVec3::Z * half.z), walls);
    b.add("far wall", wall(middle.with_z(low.z), DVec3::X * half.x, DVec3::Y * half.y), walls);
    b.add("near wall", wall(middle.with_z(high.z), DVec3::NEG_X * half.x, DVec3::Y * half.y), walls);
    b.add("left wall", wall(middle.with_x(low.x), DVec3::NEG_Z * half.z, DVec3::Y * half.y), walls);

    // The wall around the opening, by pieces; then the pane, a hand's breadth outside.
    let (sill, lintel, left, right) = (0.7, 2.3, -1.9, 0.3);
    let piece = |y0: f64, y1: f64, z0: f64, z1: f64| {
        let center = DVec3::new(high.x, 0.5 * (y0 + y1), 0.5 * (z0 + z1));
        Shape::parallelogram(center, DVec3::Z * (0.5 * (z1 - z0)), DVec3::Y * (0.5 * (y1 - y0)))
    };
    b.add("below the window", piece(low.y, sill, low.z, high.z), walls);
    b.add("above the window", piece(lintel, high.y, low.z, high.z), walls);
    b.add("beside the window", piece(sill, lintel, low.z, left), walls);
    b.add("beside the window", piece(sill, lintel, right, high.z), walls);
    let pane = Shape::parallelogram(
        DVec3::new(high.x + 0.08, 0.5 * (sill + lintel), 0.5 * (left + right)),
        DVec3::Z * (0.5 * (right - left) + 0.12),
        DVec3::Y * (0.5 * (lintel - sill) + 0.12),
    );
    b.add("pane", pane, glass);
    for (name, lo, hi) in [
        ("transom", DVec3::new(1.97, 1.48, left), DVec3::new(2.03, 1.54, right)),
        ("mullion", DVec3::new(1.97, sill, -0.83), DVec3::new(2.03, lintel, -0.77)),
    ] {
        b.add(name, Shape::cuboid(lo, hi), walls);
    }

    b.add("rug", Shape::cuboid(DVec3::new(-1.1, 0.0, -1.9), DVec3::new(0.7, 0.015, 0.3)), rug);
    b.add("table top", Shape::cuboid(DVec3::new(-1.7, 0.70, -2.6), DVec3::new(-0.3, 0.74, -1.9)), wood);
    for (x, z) in [(-1.66, -2.56), (-0.4, -2.56), (-1.66, -2.0), (-0.4, -2.0)] {
        b.add("table leg", Shape::cuboid(DVec3::new(x, 0.0, z), DVec3::new(x + 0.06, 0.70, z + 0.06)), wood);
    }
    b.add("bowl", Shape::icosphere(4).placed(0.16, DVec3::new(-0.85, 0.901, -2.25)), clay);

    // A strip of sky beyond, below the sun.
    let strip = Shape::panel(DVec3::new(9.0, 1.6, -0.8), DVec3::new(2.0, 1.6, -0.8), 7.0, 1.6);
    b.add("sky", strip, sky);

    b.camera(DVec3::new(-1.6, 1.45, 1.8), DVec3::new(0.35, 0.85, -1.6), 55.0, 4.0 / 3.0);
    let mut scene = b.finish();
    let direction = DVec3::new(-12.0, -9.0, -4.0).normalize();
    scene.lights.push(Light {
        name: "sun".into(),
        kind: LightKind::Directional { direction },
        intensity: [60.0, 54.0, 44.0],
    });
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_reaches_the_pane_at_its_cosine() {
        let LightKind::Directional { direction } = window().lights[0].kind else { panic!("the sun is far away") };
        assert!((direction.x + SUN_COSINE).abs() < 1e-9, "{direction}");
    }
}
