//! Material records, written by the names and offsets that the kernel itself states.

use surelight_scene::{AlphaMode, Material, Scene, Volume};

use super::lobes::{has_alpha_volume, ior_spread, is_dispersive};
use super::slots::Slot;
use super::textures::Textures;
use crate::reflect::{RecordLayout, RecordWriter};
use crate::shared::{FLAG_BOUNDARY, FLAG_DOUBLE_SIDED, FLAG_NOT_OPAQUE, FLAG_THIN, FLAG_UNLIT};

/// A material with its textures resolved: all that a kernel may read, before its parts are known.
#[derive(Clone, Debug)]
pub(crate) struct PreparedMaterial {
    pub(crate) material: Material,
    /// The medium's rank above the material's index, where volumes are nested; 0: none.
    pub(crate) medium: u32,
    /// Indices of texture uses, by slot.
    textures: [u32; Slot::ALL.len()],
}

impl PreparedMaterial {
    /// Gathers the material's textures. A texture whose factor is 0 is not looked up, so it is left
    /// out.
    pub(crate) fn new(scene: &Scene, material: &Material, textures: &mut Textures) -> Self {
        let used = Slot::ALL.map(|slot| {
            let (wanted, reference, srgb) = slot.of(material);
            textures.add(scene, if wanted { reference } else { None }, srgb)
        });
        Self { material: material.clone(), medium: 0, textures: used }
    }

    pub(crate) fn has(&self, slot: Slot) -> bool {
        self.texture(slot) != super::textures::NO_TEXTURE
    }

    fn texture(&self, slot: Slot) -> u32 {
        self.textures[slot as usize]
    }
}

/// Reflectance of a dielectric at normal incidence; an index of 0 means "infinite" and gives 1
/// (KHR_materials_ior).
fn f0(m: &Material) -> [f32; 3] {
    let r = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    // Colour textures multiply before the clamp at 1; the kernel clamps again to F90.
    m.specular_color.map(|c| r * c * m.specular)
}

/// Absorption per metre: the colour is the transmittance over the distance (KHR_materials_volume).
fn extinction(volume: Option<Volume>) -> [f32; 3] {
    match volume {
        Some(v) if v.attenuation_distance.is_finite() && v.attenuation_distance > 0.0 => {
            // Black would be ∞, and ∞ · 0 NaN: 1e-6 of the light is as good as none.
            // Nor may the shortest distance make it infinite.
            v.attenuation_color.map(|c| (-c.clamp(1e-6, 1.0).ln() / v.attenuation_distance).min(1e30))
        }
        _ => [0.0; 3],
    }
}

/// Every field of a material record on the host, with its size. A kernel has some of them, and no
/// others.
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
            (has_alpha_volume(m), FLAG_BOUNDARY),
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
        w.put("ior_spread", if is_dispersive(m) { ior_spread(m) } else { 0.0 });
        w.put("extinction", extinction(m.volume));
        w.put("medium", p.medium);
        w.put("coat", m.clearcoat.factor);
        w.put("coat_roughness", m.clearcoat.roughness);
        w.put("coat_normal_scale", m.clearcoat.normal_texture.as_ref().map_or(1.0, |n| n.scale));
        w.put("sheen_color", m.sheen.color);
        w.put("sheen_roughness", m.sheen.roughness);
        let (sin, cos) = f64::from(m.anisotropy.rotation).sin_cos();
        w.put("anisotropy", m.anisotropy.strength);
        w.put("anisotropy_turn", [cos as f32, sin as f32]);
        let film = &m.iridescence;
        w.put("film", film.factor);
        w.put("film_ior", film.ior);
        w.put("film_thickness", [film.thickness_minimum, film.thickness_maximum]);
        w.put("diffuse_transmission", m.diffuse_transmission.factor);
        w.put("through_color", m.diffuse_transmission.color);
        for slot in Slot::ALL {
            w.put(slot.field(), p.texture(slot));
        }
        w.put("normal_scale", m.normal_texture.as_ref().map_or(1.0, |n| n.scale));
    }
    w
}
