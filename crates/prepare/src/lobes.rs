//! The lobes of a material, by its factors.

use surelight_scene::{AlphaMode, Material};

/// Whether the base has a microfacet lobe: a metal, or a dielectric with specular strength (even of
/// index 1, since F90 is the strength, not 1), or a thin film.
pub(super) fn has_facets(m: &Material) -> bool {
    !m.unlit && (m.metallic > 0.0 || m.transmission > 0.0 || m.specular > 0.0 || has_film(m))
}

/// Whether the material is more than Lambert's.
pub(super) fn is_glossy(m: &Material) -> bool {
    has_facets(m) || is_coated(m) || has_sheen(m) || has_diffuse_transmission(m)
}

/// Whether there is a clear coat.
pub(super) fn is_coated(m: &Material) -> bool {
    !m.unlit && m.clearcoat.factor > 0.0
}

/// Whether there is sheen.
pub(super) fn has_sheen(m: &Material) -> bool {
    !m.unlit && m.sheen.color.iter().any(|&c| c > 0.0)
}

/// Whether facets are anisotropic.
pub(super) fn is_anisotropic(m: &Material) -> bool {
    has_facets(m) && m.anisotropy.strength > 0.0
}

/// Whether there is a thin film.
pub(super) fn has_film(m: &Material) -> bool {
    let film = &m.iridescence;
    let thickness = if film.thickness_texture.is_some() { film.thickness_minimum } else { 0.0 };
    !m.unlit && film.factor > 0.0 && film.thickness_maximum.max(thickness) > 0.0
}

/// Whether refraction differs by colour: only a volume bends light at all.
pub(super) fn is_dispersive(m: &Material) -> bool {
    !m.unlit && m.transmission > 0.0 && m.volume.is_some() && ior_spread(m) > 0.0
}

/// How far the indices of red and blue are from that of green (KHR_materials_dispersion, the
/// section on implementation).
pub(super) fn ior_spread(m: &Material) -> f32 {
    (m.ior - 1.0).max(0.0) * 0.025 * m.dispersion
}

/// Whether the Lambertian base sends light to its other side.
pub(super) fn has_diffuse_transmission(m: &Material) -> bool {
    !m.unlit && m.diffuse_transmission.factor > 0.0
}

/// Whether the surface encloses a medium and has alpha.
pub(super) fn has_alpha_volume(m: &Material) -> bool {
    m.alpha_mode != AlphaMode::Opaque && m.volume.is_some() && transmits(m)
}

/// Whether light may go straight through: a thin wall whose facets may be smooth. `smooth`: whether
/// α may fall below the kernel's ALPHA_SMOOTH.
pub(super) fn is_pane(m: &Material, smooth: bool) -> bool {
    !m.unlit && m.transmission > 0.0 && m.ior != 0.0 && m.volume.is_none() && smooth
}

/// Whether light gets to the other side at all.
pub(super) fn transmits(m: &Material) -> bool {
    !m.unlit && m.transmission > 0.0 || has_diffuse_transmission(m)
}

/// The mean albedo of the base by its factor, which a texture halves; 0 for unlit materials.
pub(super) fn mean_albedo(m: &Material) -> f64 {
    if m.unlit {
        return 0.0;
    }
    let factor = m.base_color[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0;
    if m.base_color_texture.is_some() { 0.5 * factor } else { factor }
}
