//! The emitters of a mesh, and their power.

use glam::Vec2;
use surelight_accel::Accel;
use surelight_scene::{AlphaMode, Material, Mesh, Scene, TextureRef};

use super::{
    Integrator, luminance,
    parallelograms::{self, Facet},
    textures::{lookup_alpha, lookup_srgb},
};

/// A triangle of a mesh that emits, or two that form a parallelogram.
pub(super) struct Emitter {
    pub(super) prim: usize,
    /// Which of its corners is the light's first.
    pub(super) corner: usize,
    pub(super) other: Option<usize>,
    /// Per area.
    pub(super) weight: f32,
}

impl Emitter {
    pub(super) fn prims(&self) -> impl Iterator<Item = usize> {
        [self.prim].into_iter().chain(self.other)
    }
}

/// The triangles of a mesh that emit light. `prims`: its triangles.
pub(super) fn emitters(
    scene: &Scene,
    accel: &Accel,
    mesh: u32,
    prims: &[usize],
    integrator: Integrator,
) -> Vec<Emitter> {
    let mesh = &scene.meshes[mesh as usize];
    let material = &scene.materials[mesh.material];
    let triangles: Vec<_> = prims.iter().map(|&prim| accel.triangles[prim].corners).collect();
    let emitter = |piece: Facet| {
        let weight = triangle_weight(scene, mesh, material, triangles[piece.triangle]);
        let other = piece.other.map(|k| prims[k]);
        Emitter { prim: prims[piece.triangle], corner: piece.corner, other, weight }
    };
    pieces(scene, mesh, &triangles, integrator)
        .into_iter()
        .map(emitter)
        .filter(|emitter| emitter.weight > 0.0)
        .collect()
}

/// Triangles of an emissive mesh, joined where they may be.
pub(super) fn pieces(scene: &Scene, mesh: &Mesh, triangles: &[[u32; 3]], integrator: Integrator) -> Vec<Facet> {
    let material = &scene.materials[mesh.material];
    // A parallelogram has no texture coordinates; and Whitted's rays aim at the middles of
    // triangles.
    let coat = &material.clearcoat;
    let plain = material.emissive_texture.is_none()
        && coat.texture.is_none()
        && coat.roughness_texture.is_none()
        && material.alpha_mode == AlphaMode::Opaque;
    if !plain || integrator == Integrator::Whitted {
        return parallelograms::unpaired(triangles.len());
    }
    let positions = |t: &[u32; 3]| t.map(|i| mesh.positions[i as usize]);
    parallelograms::join(&triangles.iter().map(positions).collect::<Vec<_>>())
}

/// Luminance of a triangle's mean emission times coverage, both sides counted where both emit.
fn triangle_weight(scene: &Scene, mesh: &Mesh, material: &Material, corners: [u32; 3]) -> f32 {
    let sides = if material.double_sided { 2.0 } else { 1.0 };
    let varies = material.emissive_texture.is_some()
        || material.alpha_mode != AlphaMode::Opaque && (material.base_color_texture.is_some() || mesh.colors.is_some());
    let mean = if varies {
        mean_emission(scene, mesh, material, corners)
    } else {
        let coverage = coverage(material, material.base_color[3]);
        material.emissive.map(|c| c * coverage)
    };
    (sides * luminance(mean)) as f32
}

/// Probability that a surface of this alpha is hit. Counterpart of `coverage_at` in
/// `shaders/scene/coverage.wesl`.
fn coverage(material: &Material, alpha: f32) -> f32 {
    match material.alpha_mode {
        AlphaMode::Opaque => 1.0,
        AlphaMode::Mask(cutoff) => f32::from(u8::from(alpha >= cutoff)),
        AlphaMode::Blend => alpha.clamp(0.0, 1.0),
    }
}

/// Mean over a triangle of emission times coverage, by a grid fine enough to sample each texel of
/// small textures.
fn mean_emission(scene: &Scene, mesh: &Mesh, material: &Material, corners: [u32; 3]) -> [f32; 3] {
    let uvs = |texture: &TextureRef| {
        corners.map(|c| mesh.uvs.get(texture.uv_set as usize).map_or(Vec2::ZERO, |uvs| uvs[c as usize]))
    };
    let emissive = material.emissive_texture.as_ref().map(|texture| (texture, uvs(texture)));
    let base = material.base_color_texture.as_ref().filter(|_| material.alpha_mode != AlphaMode::Opaque);
    let base = base.map(|texture| (texture, uvs(texture)));
    let alphas = mesh.colors.as_ref().map_or([1.0; 3], |colors| corners.map(|c| colors[c as usize].w));
    let texels = |&(texture, uvs): &(&TextureRef, [Vec2; 3])| {
        let image = &scene.images[scene.textures[texture.texture].image];
        let size = Vec2::new(image.width as f32, image.height as f32);
        ((uvs[1] - uvs[0]) * size).length().max(((uvs[2] - uvs[0]) * size).length())
    };
    let extent = emissive.iter().chain(&base).map(texels).fold(0.0, f32::max);
    let n = (extent.min(64.0) as usize).clamp(4, 64);
    let mut sum = [0.0f64; 3];
    let mut count = 0.0;
    for i in 0..n {
        for j in 0..n - i {
            let (b1, b2) = ((i as f32 + 1.0 / 3.0) / n as f32, (j as f32 + 1.0 / 3.0) / n as f32);
            let at = |uvs: [Vec2; 3]| uvs[0] + b1 * (uvs[1] - uvs[0]) + b2 * (uvs[2] - uvs[0]);
            let emission = emissive.map_or([1.0; 3], |(texture, uvs)| lookup_srgb(scene, texture, at(uvs)));
            let alpha = material.base_color[3]
                * base.map_or(1.0, |(texture, uvs)| lookup_alpha(scene, texture, at(uvs)))
                * (alphas[0] + b1 * (alphas[1] - alphas[0]) + b2 * (alphas[2] - alphas[0]));
            let coverage = coverage(material, alpha);
            for c in 0..3 {
                sum[c] += f64::from(emission[c] * coverage);
            }
            count += 1.0;
        }
    }
    [0, 1, 2].map(|c| material.emissive[c] * (sum[c] / count) as f32)
}
