//! KHR_materials_variants: one of several sets of materials, chosen by name.

use serde::Deserialize;

use super::document::{Document, Int, Primitive};
use super::error::{Fault, Result};
use super::warnings::Warnings;

const NAME: &str = "KHR_materials_variants";

#[derive(Deserialize)]
struct RootJson {
    variants: Vec<VariantJson>,
}

#[derive(Deserialize)]
struct VariantJson {
    #[serde(default)]
    name: String,
}

#[derive(Deserialize)]
struct PrimitiveJson {
    mappings: Vec<Mapping>,
}

#[derive(Deserialize)]
struct Mapping {
    material: Int,
    variants: Vec<Int>,
}

/// The index of the variant called `wanted` (or numbered so, when none is called so).
pub(crate) fn choose(document: &Document, wanted: Option<&str>) -> Result<Option<usize>> {
    let Some(wanted) = wanted else { return Ok(None) };
    let place = "the choice of a variant";
    let names = match document.extensions.parse::<RootJson>(NAME) {
        None => return Err(Fault::invalid(place, format!("is {wanted:?}, but the file has none"))),
        Some(Err(e)) => {
            return Err(Fault::invalid(place, format!("is {wanted:?}, but the file's cannot be read: {e}")));
        }
        Some(Ok(root)) => root.variants,
    };
    let numbered = || wanted.parse().ok().filter(|&index: &usize| index < names.len());
    names.iter().position(|v| v.name == wanted).or_else(numbered).map(Some).ok_or_else(|| {
        let known: Vec<String> = names.iter().take(20).map(|v| format!("{:?}", v.name)).collect();
        Fault::invalid(place, format!("is {wanted:?}, but the file has {}", known.join(", ")))
    })
}

/// The material of a primitive under a variant: its own where the variant does not change it.
pub(crate) fn material(
    primitive: &Primitive,
    variant: Option<usize>,
    place: &str,
    warnings: &mut Warnings,
) -> Option<Int> {
    let Some(variant) = variant else { return primitive.material };
    match primitive.extensions.parse::<PrimitiveJson>(NAME) {
        None => primitive.material,
        Some(Ok(json)) => json
            .mappings
            .into_iter()
            .find(|mapping| mapping.variants.iter().any(|v| v.index() == variant))
            .map_or(primitive.material, |mapping| Some(mapping.material)),
        Some(Err(e)) => {
            warnings.push(format!("{NAME} of {place} is ignored: {e}."));
            primitive.material
        }
    }
}
