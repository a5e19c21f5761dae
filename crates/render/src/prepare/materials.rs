//! Material records, written by the names and offsets that the kernel itself states.

use surelight_scene::{AlphaMode, Material, Scene, Volume};

use super::textures::Textures;
use crate::reflect::{RecordLayout, RecordWriter};

const FLAG_DOUBLE_SIDED: u32 = 1;
const FLAG_UNLIT: u32 = 2;
const FLAG_THIN: u32 = 4;
const FLAG_NOT_OPAQUE: u32 = 8;

/// A material with its textures resolved: what the kernel may ask for, before it is known what it does ask for.
#[derive(Clone, Debug)]
pub(crate) struct PreparedMaterial {
    pub(crate) material: Material,
    base_color: u32,
    metallic_roughness: u32,
    normal: u32,
    emissive: u32,
    specular: u32,
    specular_color: u32,
    transmission: u32,
}

impl PreparedMaterial {
    /// Gathers the material's textures. A texture whose factor is 0 is not looked up, so it is left out.
    pub(crate) fn new(scene: &Scene, material: &Material, textures: &mut Textures) -> Self {
        let m = material;
        let shaded = !m.unlit;
        let reflects = shaded && is_glossy(m);
        let transmits = shaded && m.transmission > 0.0;
        let mut add = |wanted: bool, reference, srgb| textures.add(scene, if wanted { reference } else { None }, srgb);
        let roughness_counts = reflects && (m.roughness > 0.0 || m.metallic > 0.0);
        Self {
            base_color: add(true, m.base_color_texture.as_ref(), true),
            metallic_roughness: add(roughness_counts, m.metallic_roughness_texture.as_ref(), false),
            normal: add(shaded, m.normal_texture.as_ref().map(|n| &n.texture), false),
            emissive: add(m.is_emissive(), m.emissive_texture.as_ref(), true),
            specular: add(reflects && m.specular > 0.0, m.specular_texture.as_ref(), false),
            specular_color: add(reflects && m.specular > 0.0, m.specular_color_texture.as_ref(), true),
            transmission: add(transmits, m.transmission_texture.as_ref(), false),
            material: m.clone(),
        }
    }

    pub(crate) fn has(&self, slot: Slot) -> bool {
        let index = match slot {
            Slot::BaseColor => self.base_color,
            Slot::MetallicRoughness => self.metallic_roughness,
            Slot::Normal => self.normal,
            Slot::Emissive => self.emissive,
            Slot::Specular => self.specular,
            Slot::SpecularColor => self.specular_color,
            Slot::Transmission => self.transmission,
        };
        index != super::textures::NO_TEXTURE
    }
}

/// Where a material can have a texture.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Slot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Emissive,
    Specular,
    SpecularColor,
    Transmission,
}

/// Whether a microfacet lobe can be seen: a metal, or a dielectric with specular strength (even of index 1, since F90 is
/// the strength, not 1).
pub(crate) fn is_glossy(m: &Material) -> bool {
    !m.unlit && (m.metallic > 0.0 || m.transmission > 0.0 || m.specular > 0.0)
}

/// Reflectance of a dielectric at normal incidence; an index of 0 stands for 1, "infinite" (KHR_materials_ior).
fn f0(m: &Material) -> [f32; 3] {
    let r = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    // Colour textures multiply before the clamp at 1; the kernel clamps again to F90.
    m.specular_color.map(|c| r * c * m.specular)
}

/// Absorption per metre: the colour is what is left after the distance (KHR_materials_volume).
fn extinction(volume: Option<Volume>) -> [f32; 3] {
    match volume {
        Some(v) if v.attenuation_distance.is_finite() && v.attenuation_distance > 0.0 => {
            // Black would be ∞, and ∞ · 0 NaN: 1e-6 of the light is as good as none.
            v.attenuation_color.map(|c| -c.clamp(1e-6, 1.0).ln() / v.attenuation_distance)
        }
        _ => [0.0; 3],
    }
}

/// Every field of a material record that the host knows, with its size. A kernel has some of them, and no others.
pub fn material_fields() -> Vec<(&'static str, u32)> {
    let material = PreparedMaterial::new(&Scene::default(), &Material::default(), &mut Textures::default());
    write_records(&[material], &RecordLayout::default()).fields.into_iter().collect()
}

/// The records of all materials.
pub(crate) fn write(materials: &[PreparedMaterial], layout: &RecordLayout) -> Vec<u8> {
    write_records(materials, layout).bytes
}

fn write_records<'a>(materials: &[PreparedMaterial], layout: &'a RecordLayout) -> RecordWriter<'a> {
    let mut w = RecordWriter::new(layout);
    for p in materials {
        let m = &p.material;
        w.begin();
        let thin = m.volume.is_none();
        let mut flags = 0;
        for (on, flag) in [
            (m.double_sided, FLAG_DOUBLE_SIDED),
            (m.unlit, FLAG_UNLIT),
            (thin, FLAG_THIN),
            (m.alpha_mode != AlphaMode::Opaque, FLAG_NOT_OPAQUE),
        ] {
            flags |= if on { flag } else { 0 };
        }
        w.put("flags", flags);
        w.put("base_color", m.base_color);
        w.put("emissive", if m.unlit { [0.0; 3] } else { m.emissive });
        w.put("roughness", m.roughness);
        w.put("metallic", m.metallic);
        w.put("f0", f0(m));
        w.put("f90", m.specular);
        w.put("alpha_cutoff", if let AlphaMode::Mask(cutoff) = m.alpha_mode { cutoff } else { -1.0 });
        w.put("transmission", if m.ior == 0.0 { 0.0 } else { m.transmission });
        w.put("ior", if m.ior == 0.0 { 1.5 } else { m.ior });
        w.put("extinction", extinction(m.volume));
        w.put("base_color_texture", p.base_color);
        w.put("metallic_roughness_texture", p.metallic_roughness);
        w.put("normal_texture", p.normal);
        w.put("normal_scale", m.normal_texture.as_ref().map_or(1.0, |n| n.scale));
        w.put("emissive_texture", p.emissive);
        w.put("specular_texture", p.specular);
        w.put("specular_color_texture", p.specular_color);
        w.put("transmission_texture", p.transmission);
    }
    w
}
