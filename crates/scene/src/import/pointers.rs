//! KHR_animation_pointer: the properties that may be animated, and the document with their values.
//!
//! Values are put into the JSON before anything is read, so that every reader sees them. Only the
//! objects that change become trees of values; the rest of the text is copied.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use super::document::Extensions;
use super::error::{Fault, Result};
use super::uri::shown;
use super::warnings::Warnings;

pub(crate) const NAME: &str = "KHR_animation_pointer";

/// Objects whose members all have defaults: a file may leave them out, and still animate their
/// members.
const OPTIONAL: [&str; 2] = ["pbrMetallicRoughness", "spot"];

#[derive(Deserialize)]
struct TargetJson {
    pointer: String,
}

/// The JSON pointer of a channel's target; `None` when it has none, or an unusable one.
pub(crate) fn of(extensions: &Extensions) -> Option<String> {
    extensions.parse::<TargetJson>(NAME)?.ok().map(|json| json.pointer)
}

/// A property that may be animated, by the glTF 2.0 Asset Object Model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    Translation {
        node: usize,
    },
    Rotation {
        node: usize,
    },
    Scale {
        node: usize,
    },
    /// All weights of a node, or one of them.
    NodeWeights {
        node: usize,
        only: Option<usize>,
    },
    /// All weights of a mesh, or one of them.
    MeshWeights {
        mesh: usize,
        only: Option<usize>,
    },
    /// Anything else, which is set in the JSON.
    Json(Kind),
}

/// Types of properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Flag,
    Float,
    Float2,
    Float3,
    Float4,
    Rotation,
}

/// The parts of a JSON pointer (RFC 6901), unescaped; `None` when it is none.
pub(crate) fn tokens(pointer: &str) -> Option<Vec<String>> {
    let escaped = pointer.strip_prefix('/')?.split('/');
    escaped
        .map(|token| {
            let plain = token.replace("~1", "").replace("~0", "");
            // ~1 before ~0, so that ~01 is ~1 and not a slash.
            (!plain.contains('~')).then(|| token.replace("~1", "/").replace("~0", "~"))
        })
        .collect()
}

/// An index as RFC 6901 writes it: digits without leading zeros.
fn index(token: &str) -> Option<usize> {
    let digits = token.bytes().all(|b| b.is_ascii_digit()) && (token == "0" || !token.starts_with('0'));
    digits.then(|| token.parse().ok()).flatten()
}

/// The property that a pointer names; `None` where it may not be animated.
pub(crate) fn target(tokens: &[String]) -> Option<Target> {
    let tokens: Vec<&str> = tokens.iter().map(String::as_str).collect();
    let json = |kind| Some(Target::Json(kind));
    match tokens.as_slice() {
        ["nodes", node, rest @ ..] => {
            let node = index(node)?;
            match rest {
                ["translation"] => Some(Target::Translation { node }),
                ["rotation"] => Some(Target::Rotation { node }),
                ["scale"] => Some(Target::Scale { node }),
                ["weights"] => Some(Target::NodeWeights { node, only: None }),
                ["weights", only] => Some(Target::NodeWeights { node, only: Some(index(only)?) }),
                ["extensions", "KHR_node_visibility", "visible"] => json(Kind::Flag),
                _ => None,
            }
        }
        ["meshes", mesh, "weights"] => Some(Target::MeshWeights { mesh: index(mesh)?, only: None }),
        ["meshes", mesh, "weights", only] => Some(Target::MeshWeights { mesh: index(mesh)?, only: Some(index(only)?) }),
        ["cameras", camera, rest @ ..] => {
            index(camera)?;
            match rest {
                ["perspective", "aspectRatio" | "yfov" | "znear" | "zfar"] => json(Kind::Float),
                ["orthographic", "xmag" | "ymag" | "znear" | "zfar"] => json(Kind::Float),
                _ => None,
            }
        }
        ["extensions", "KHR_lights_punctual", "lights", light, rest @ ..] => {
            index(light)?;
            match rest {
                ["color"] => json(Kind::Float3),
                ["intensity" | "range"] | ["spot", "innerConeAngle" | "outerConeAngle"] => json(Kind::Float),
                _ => None,
            }
        }
        ["extensions", "EXT_lights_image_based", "lights", light, rest @ ..] => {
            index(light)?;
            match rest {
                ["intensity"] => json(Kind::Float),
                ["rotation"] => json(Kind::Rotation),
                _ => None,
            }
        }
        ["materials", material, rest @ ..] => {
            index(material)?;
            of_material(rest).map(Target::Json)
        }
        _ => None,
    }
}

fn of_material(tokens: &[&str]) -> Option<Kind> {
    match tokens {
        ["alphaCutoff"] | ["normalTexture", "scale"] | ["occlusionTexture", "strength"] => Some(Kind::Float),
        ["emissiveFactor"] => Some(Kind::Float3),
        ["pbrMetallicRoughness", "metallicFactor" | "roughnessFactor"] => Some(Kind::Float),
        ["pbrMetallicRoughness", "baseColorFactor"] => Some(Kind::Float4),
        [owner @ .., texture, "extensions", "KHR_texture_transform", property] if texture.ends_with("Texture") => {
            let known = match owner {
                [] | ["pbrMetallicRoughness"] => true,
                ["extensions", name] => name.starts_with("KHR_materials_"),
                _ => false,
            };
            match *property {
                "offset" | "scale" => known.then_some(Kind::Float2),
                "rotation" => known.then_some(Kind::Float),
                _ => None,
            }
        }
        ["extensions", extension, rest @ ..] => {
            let (colors, numbers): (&[&str], &[&str]) = match *extension {
                "KHR_materials_anisotropy" => (&[], &["anisotropyStrength", "anisotropyRotation"]),
                "KHR_materials_clearcoat" => match rest {
                    ["clearcoatNormalTexture", "scale"] => return Some(Kind::Float),
                    _ => (&[], &["clearcoatFactor", "clearcoatRoughnessFactor"]),
                },
                "KHR_materials_diffuse_transmission" => {
                    (&["diffuseTransmissionColorFactor"], &["diffuseTransmissionFactor"])
                }
                "KHR_materials_dispersion" => (&[], &["dispersion"]),
                "KHR_materials_emissive_strength" => (&[], &["emissiveStrength"]),
                "KHR_materials_ior" => (&[], &["ior"]),
                "KHR_materials_iridescence" => {
                    let thickness = ["iridescenceThicknessMinimum", "iridescenceThicknessMaximum"];
                    (&[], &["iridescenceFactor", "iridescenceIor", thickness[0], thickness[1]])
                }
                "KHR_materials_sheen" => (&["sheenColorFactor"], &["sheenRoughnessFactor"]),
                "KHR_materials_specular" => (&["specularColorFactor"], &["specularFactor"]),
                "KHR_materials_transmission" => (&[], &["transmissionFactor"]),
                "KHR_materials_volume" => (&["attenuationColor"], &["thicknessFactor", "attenuationDistance"]),
                _ => return None,
            };
            let [property] = rest else { return None };
            let color = colors.contains(property).then_some(Kind::Float3);
            color.or(numbers.contains(property).then_some(Kind::Float))
        }
        _ => None,
    }
}

/// A value for the JSON.
#[derive(Debug)]
pub(crate) struct Edit {
    /// As the file writes it.
    pub(crate) pointer: String,
    pub(crate) tokens: Vec<String>,
    pub(crate) value: Value,
}

/// The text of a document with these values in it. Pointers to nothing are ignored with a warning.
pub(crate) fn apply(text: &str, edits: Vec<Edit>, warnings: &mut Warnings) -> Result<String> {
    let broken = |e: serde_json::Error| Fault::Format(format!("its JSON cannot be parsed: {e}"));
    let mut members: BTreeMap<String, Edited> = BTreeMap::new();
    for (name, raw) in serde_json::from_str::<BTreeMap<String, &RawValue>>(text).map_err(broken)? {
        members.insert(name, Edited::Text(raw.get().into()));
    }
    for edit in edits {
        let [first, rest @ ..] = edit.tokens.as_slice() else { continue };
        let outcome = match members.get_mut(first) {
            Some(member) => member.set(rest, edit.value),
            None => Err(format!("the file has no {first}")),
        };
        if let Err(reason) = outcome {
            let pointer = shown(&edit.pointer);
            warnings.push(format!("{pointer:?} ({NAME}) is not animated: {reason}."));
        }
    }
    let members: Vec<String> =
        members.into_iter().map(|(name, member)| format!("{}:{}", Value::from(name), member.into_text())).collect();
    Ok(format!("{{{}}}", members.join(",")))
}

/// A member of the root.
enum Edited {
    Text(String),
    /// An array whose elements are edited one by one.
    Elements(Vec<Edited>),
    Tree(Value),
}

impl Edited {
    fn set(&mut self, path: &[String], value: Value) -> std::result::Result<(), String> {
        let unreadable = |e: serde_json::Error| format!("the value {}", super::json::fault(&e));
        if let Self::Text(text) = self {
            *self = if text.starts_with('[') {
                let elements: Vec<&RawValue> = serde_json::from_str(text).map_err(unreadable)?;
                Self::Elements(elements.into_iter().map(|raw| Self::Text(raw.get().into())).collect())
            } else {
                Self::Tree(serde_json::from_str(text).map_err(unreadable)?)
            };
        }
        match (self, path) {
            (Self::Elements(elements), [element, rest @ ..]) => {
                let count = elements.len();
                let element = index(element).and_then(|i| elements.get_mut(i));
                element.ok_or_else(|| format!("the last one is {}", count.saturating_sub(1)))?.set(rest, value)
            }
            (Self::Tree(tree), path) => set(tree, path, value),
            _ => Err("it leads to no property".into()),
        }
    }

    fn into_text(self) -> String {
        match self {
            Self::Text(text) => text,
            Self::Elements(elements) => {
                format!("[{}]", elements.into_iter().map(Self::into_text).collect::<Vec<_>>().join(","))
            }
            Self::Tree(tree) => tree.to_string(),
        }
    }
}

/// Sets the member at the end of a path of objects and arrays.
fn set(mut tree: &mut Value, path: &[String], value: Value) -> std::result::Result<(), String> {
    let [path @ .., name] = path else { return Err("it leads to no property".into()) };
    for token in path {
        let missing = || format!("there is no {}", shown(token));
        tree = match tree {
            Value::Object(members) => {
                if OPTIONAL.contains(&token.as_str()) && !members.contains_key(token) {
                    members.insert(token.clone(), Map::new().into());
                }
                members.get_mut(token).ok_or_else(missing)?
            }
            Value::Array(items) => index(token).and_then(|i| items.get_mut(i)).ok_or_else(missing)?,
            _ => return Err(missing()),
        };
    }
    match tree {
        Value::Object(members) => {
            members.insert(name.clone(), value);
            Ok(())
        }
        _ => Err(format!("{} is part of no object", shown(name))),
    }
}
