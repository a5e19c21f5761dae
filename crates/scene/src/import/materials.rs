//! Materials: the core metallic-roughness model; [`super::material_extensions`] and
//! [`super::material_layers`] add the rest.

use super::document::{Document, Int, MaterialJson};
use super::material_draft::{MaterialDraft, Reader};
use super::warnings::Warnings;
use super::{material_extensions, material_layers, specular_glossiness};
use crate::{AlphaMode, Material};

/// Reads material `index`, which must be in range.
pub(crate) fn read(document: &Document, index: usize, warnings: &mut Warnings) -> MaterialDraft {
    let Some(json) = document.materials.get(index) else {
        return MaterialDraft::default();
    };
    let place = match &json.name {
        Some(name) => format!("material {index} ({name:?})"),
        None => format!("material {index}"),
    };
    let mut reader = Reader { document, place, warnings };
    let mut draft = core(json, &mut reader);
    specular_glossiness::read(json, &mut draft, &mut reader);
    material_extensions::read(json, &mut draft, &mut reader);
    material_layers::read(json, &mut draft, &mut reader);
    draft
}

fn core(json: &MaterialJson, reader: &mut Reader) -> MaterialDraft {
    let pbr = &json.pbr_metallic_roughness;
    let material = Material {
        name: json.name.clone().unwrap_or_default(),
        base_color: reader.factors(pbr.base_color_factor, [1.0; 4], 1.0, "baseColorFactor"),
        metallic: reader.factor(pbr.metallic_factor, 1.0, 0.0, 1.0, "metallicFactor"),
        roughness: reader.factor(pbr.roughness_factor, 1.0, 0.0, 1.0, "roughnessFactor"),
        emissive: reader.factors(json.emissive_factor, [0.0; 3], 1.0, "emissiveFactor"),
        alpha_mode: alpha_mode(json, reader),
        double_sided: json.double_sided,
        ..Material::default()
    };
    MaterialDraft {
        base_color: reader.texture(pbr.base_color_texture.as_ref()),
        metallic_roughness: reader.texture(pbr.metallic_roughness_texture.as_ref()),
        normal: reader.normal_map(json.normal_texture.as_ref()),
        emissive: reader.texture(json.emissive_texture.as_ref()),
        material,
        ..MaterialDraft::default()
    }
}

fn alpha_mode(json: &MaterialJson, reader: &mut Reader) -> AlphaMode {
    match json.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        // A cutoff above 1 is allowed and hides everything.
        Some("MASK") => AlphaMode::Mask(reader.factor(json.alpha_cutoff, 0.5, 0.0, f32::MAX, "alphaCutoff")),
        Some("BLEND") => AlphaMode::Blend,
        Some(other) => {
            let text = format!("alphaMode of {} is {other:?}, which is unknown; it is drawn opaque.", reader.place);
            reader.warnings.push(text);
            AlphaMode::Opaque
        }
    }
}

/// The index of a primitive's material, or `None` for the default one; an index out of range is a
/// warning.
pub(crate) fn index_of(
    document: &Document,
    material: Option<Int>,
    place: &str,
    warnings: &mut Warnings,
) -> Option<usize> {
    let index = material?.index();
    if index < document.materials.len() {
        return Some(index);
    }
    let fault = super::error::Fault::no_such(place, "material", index, document.materials.len());
    warnings.push(format!("The default material is used: {}.", fault.reason()));
    None
}
