//! KHR_materials_pbrSpecularGlossiness (archived), as a metallic-roughness material with
//! KHR_materials_specular.
//!
//! A metalness of 0 with an index of refraction so high that the reflection at normal incidence is
//! the specular colour itself; roughness is 1 − glossiness. This keeps every factor and colour
//! texture. Two things change: glossiness textures become roughness textures rounded to 8 bits, and
//! the diffuse part is dimmed by the reflection at each angle (1 − max F, as the core model does)
//! and not by 1 − max(specular) at all angles.

use serde::Deserialize;

use super::document::{MaterialJson, TextureInfo};
use super::material_draft::{MaterialDraft, Reader};

pub(crate) const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

/// Index of refraction, and the reflectance ((n − 1) / (n + 1))² that the specular colour is to be
/// divided by.
const IOR: f32 = 1000.0;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Json {
    diffuse_factor: Option<[f64; 4]>,
    diffuse_texture: Option<TextureInfo>,
    specular_factor: Option<[f64; 3]>,
    glossiness_factor: Option<f64>,
    specular_glossiness_texture: Option<TextureInfo>,
}

/// Replaces the core model's values where the extension is there; readers of both are to take the
/// extension.
pub(crate) fn read(json: &MaterialJson, draft: &mut MaterialDraft, reader: &mut Reader) {
    let Some(parsed) = json.extensions.parse::<Json>(NAME) else { return };
    let json = match parsed {
        Ok(json) => json,
        Err(e) => {
            reader.warnings.push(format!("{NAME} of {} is ignored: {e}.", reader.place));
            return;
        }
    };
    let reflectance = ((IOR - 1.0) / (IOR + 1.0)).powi(2);
    let glossiness = reader.factor(json.glossiness_factor, 1.0, 0.0, 1.0, "glossinessFactor");
    let material = &mut draft.material;
    material.base_color = reader.factors(json.diffuse_factor, [1.0; 4], 1.0, "diffuseFactor");
    material.metallic = 0.0;
    material.roughness = 1.0 - glossiness;
    material.ior = IOR;
    material.specular = 1.0;
    material.specular_color =
        reader.factors(json.specular_factor, [1.0; 3], 1.0, "specularFactor").map(|c| c / reflectance);
    draft.base_color = reader.texture(json.diffuse_texture.as_ref());
    draft.specular_color = reader.texture(json.specular_glossiness_texture.as_ref());
    draft.metallic_roughness = None;
    draft.glossiness = draft.specular_color.clone().map(|lookup| (lookup, glossiness));
}
