//! The supported extensions, and warnings about the others.

use std::collections::BTreeSet;

use super::document::Document;
use super::error::{Fault, Result};
use super::warnings::Warnings;
use crate::ExtensionUse;

/// Extensions that the picture follows.
const HONOURED: &[&str] = &[
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Extensions about matters that no picture shows: to leave them out is to follow them.
const INVISIBLE: &[&str] = &["KHR_xmp_json_ld", "KHR_xmp", "FB_ngon_encoding"];

/// How to do without an extension, where a usual tool can take it out.
const REMEDIES: &[(&str, &str)] =
    &[("EXT_texture_avif", ": convert its textures, for example with `gltf-transform png in.glb out.glb`")];

/// Lists the extensions that the file names; refuses a required one that is not followed, warns
/// once of each other.
pub(crate) fn check(document: &Document, warnings: &mut Warnings) -> Result<Vec<ExtensionUse>> {
    let required: BTreeSet<&String> = document.extensions_required.iter().collect();
    let named: BTreeSet<&String> = document.extensions_used.iter().chain(required.iter().copied()).collect();
    let mut uses = Vec::new();
    for name in named {
        let required = required.contains(name);
        let honoured = HONOURED.contains(&name.as_str()) || INVISIBLE.contains(&name.as_str());
        if !honoured && required {
            let remedy = REMEDIES.iter().find(|(known, _)| known == name).map_or("", |(_, remedy)| remedy);
            return Err(Fault::RequiredExtension { extension: super::uri::shown(name), remedy });
        }
        if !honoured {
            warnings.push(format!("The extension {} is not supported and is ignored.", super::uri::shown(name)));
        }
        uses.push(ExtensionUse { name: name.clone(), required, honoured });
    }
    Ok(uses)
}
