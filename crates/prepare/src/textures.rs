//! Texels of every image in use, and the records by which materials sample them.

use std::{collections::HashMap, sync::OnceLock};

use glam::Affine2;
use surelight_scene::{Filter, Scene, TextureRef, Wrap};

use crate::shared::TextureUse;

/// Means "no texture" in a material record.
pub(crate) const NO_TEXTURE: u32 = u32::MAX;

/// Collects the textures of materials.
#[derive(Default)]
pub(crate) struct Textures {
    /// RGBA8, image after image.
    pub(crate) texels: Vec<u32>,
    pub(crate) uses: Vec<TextureUse>,
    offsets: HashMap<usize, u32>,
}

impl Textures {
    /// The index that a material record holds for this texture; `srgb`: its colours are to be
    /// linearised.
    pub(crate) fn add(&mut self, scene: &Scene, reference: Option<&TextureRef>, srgb: bool) -> u32 {
        let Some(reference) = reference else { return NO_TEXTURE };
        let texture = &scene.textures[reference.texture];
        let image = &scene.images[texture.image];
        let texels = &mut self.texels;
        let offset = *self.offsets.entry(texture.image).or_insert_with(|| {
            let offset = texels.len() as u32;
            texels.extend(image.rgba.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])));
            offset
        });
        let wrap = |w| match w {
            Wrap::Repeat => 0,
            Wrap::MirroredRepeat => 1,
            Wrap::ClampToEdge => 2,
        };
        let nearest = u32::from(texture.filter == Filter::Nearest);
        let m = reference.transform.unwrap_or(Affine2::IDENTITY);
        let entry = TextureUse {
            offset,
            width: image.width,
            height: image.height,
            flags: wrap(texture.wrap_s)
                | wrap(texture.wrap_t) << 2
                | nearest << 4
                | u32::from(srgb) << 5
                | reference.uv_set << 8,
            row_u: [m.matrix2.x_axis.x, m.matrix2.y_axis.x, m.translation.x],
            row_v: [m.matrix2.x_axis.y, m.matrix2.y_axis.y, m.translation.y],
            ..TextureUse::default()
        };
        let found = self.uses.iter().position(|u| *u == entry);
        found.unwrap_or_else(|| {
            self.uses.push(entry);
            self.uses.len() - 1
        }) as u32
    }
}

/// Bilinear lookup on the CPU, the counterpart of `sample_texture`: linear RGB of an sRGB texture.
pub(crate) fn lookup_srgb(scene: &Scene, reference: &TextureRef, uv: glam::Vec2) -> [f32; 3] {
    lookup(scene, reference, uv, |texel| [texel[0], texel[1], texel[2]].map(srgb_to_linear))
}

/// Bilinear lookup of a texture's alpha.
pub(crate) fn lookup_alpha(scene: &Scene, reference: &TextureRef, uv: glam::Vec2) -> f32 {
    let [alpha] = lookup(scene, reference, uv, |texel| [f32::from(texel[3]) / 255.0]);
    alpha
}

fn lookup<const N: usize>(
    scene: &Scene,
    reference: &TextureRef,
    uv: glam::Vec2,
    decode: impl Fn(&[u8]) -> [f32; N],
) -> [f32; N] {
    let texture = &scene.textures[reference.texture];
    let image = &scene.images[texture.image];
    let uv = reference.transform.map_or(uv, |m| m.transform_point2(uv));
    let p = uv * glam::Vec2::new(image.width as f32, image.height as f32);
    let nearest = texture.filter == Filter::Nearest;
    let corner = if nearest { p.floor() } else { (p - 0.5).floor() };
    let f = if nearest { glam::Vec2::ZERO } else { p - 0.5 - corner };
    let fetch = |dx: i64, dy: i64| {
        let x = wrap_coordinate(corner.x as i64 + dx, i64::from(image.width), texture.wrap_s);
        let y = wrap_coordinate(corner.y as i64 + dy, i64::from(image.height), texture.wrap_t);
        let at = 4 * (y as usize * image.width as usize + x as usize);
        decode(&image.rgba[at..at + 4])
    };
    let (a, b, c, d) = (fetch(0, 0), fetch(1, 0), fetch(0, 1), fetch(1, 1));
    std::array::from_fn(|k| {
        let top = a[k] + (b[k] - a[k]) * f.x;
        let bottom = c[k] + (d[k] - c[k]) * f.x;
        top + (bottom - top) * f.y
    })
}

fn wrap_coordinate(i: i64, size: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => i.rem_euclid(size),
        Wrap::MirroredRepeat => {
            let folded = i.rem_euclid(2 * size);
            folded.min(2 * size - 1 - folded)
        }
        Wrap::ClampToEdge => i.clamp(0, size - 1),
    }
}

/// sRGB to linear (IEC 61966-2-1), by a table.
fn srgb_to_linear(byte: u8) -> f32 {
    static TABLE: OnceLock<[f32; 256]> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        std::array::from_fn(|i| {
            let c = i as f32 / 255.0;
            if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        })
    });
    table[usize::from(byte)]
}
