//! Images made by code.

use glam::DVec3;
use surelight_scene::Image;

/// An image from a function of (u, v) at texel centres, v from the top; values in [0, 1] as stored.
pub(crate) fn paint(name: &str, width: u32, height: u32, texel: impl Fn(f64, f64) -> [f64; 4]) -> Image {
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height {
        for x in 0..width {
            let u = (f64::from(x) + 0.5) / f64::from(width);
            let v = (f64::from(y) + 0.5) / f64::from(height);
            rgba.extend(texel(u, v).map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8));
        }
    }
    Image { name: name.to_owned(), width, height, rgba }
}

/// A linear colour as an opaque sRGB texel (IEC 61966-2-1).
pub(crate) fn srgb(linear: DVec3) -> [f64; 4] {
    let encode = |c: f64| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    [encode(linear.x), encode(linear.y), encode(linear.z), 1.0]
}

/// A tangent-space normal as a texel.
pub(crate) fn encode_normal(normal: DVec3) -> [f64; 4] {
    let n = normal.normalize() * 0.5 + DVec3::splat(0.5);
    [n.x, n.y, n.z, 1.0]
}

/// 0 below `lo`, 1 above `hi`, smooth between.
pub(crate) fn smoothstep(lo: f64, hi: f64, x: f64) -> f64 {
    let t = ((x - lo) / (hi - lo)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
