//! Punctual lights: KHR_lights_punctual.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::DVec3;
use serde::Deserialize;
use serde_json::Value;

use super::document::{Document, Int};
use super::error::Fault;
use super::nodes::{PlacedNode, name_of};
use super::warnings::Warnings;
use crate::{Light, LightKind};

const NAME: &str = "KHR_lights_punctual";

#[derive(Deserialize)]
struct RootJson {
    lights: Vec<Value>,
}

#[derive(Deserialize)]
struct NodeJson {
    light: Int,
}

#[derive(Deserialize)]
struct LightJson {
    name: Option<String>,
    #[serde(rename = "type")]
    kind: String,
    color: Option<[f64; 3]>,
    intensity: Option<f64>,
    range: Option<f64>,
    spot: Option<SpotJson>,
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct SpotJson {
    inner_cone_angle: Option<f64>,
    outer_cone_angle: Option<f64>,
}

/// Lights of the placed nodes, in the order of the nodes. A broken one is left out with a warning.
pub(crate) fn read(document: &Document, placed: &[PlacedNode], warnings: &mut Warnings) -> Vec<Light> {
    let defined = match document.extensions.parse::<RootJson>(NAME) {
        None => Vec::new(),
        Some(Ok(root)) => root.lights,
        Some(Err(e)) => {
            warnings.push(format!("The lights of the file are left out: {e}."));
            Vec::new()
        }
    };
    let mut lights = Vec::new();
    for placed in placed.iter().filter(|placed| placed.visible) {
        let node = &document.nodes[placed.node];
        let Some(reference) = node.extensions.parse::<NodeJson>(NAME) else { continue };
        let place = format!("node {}", placed.node);
        let parsed = match reference.map(|json| json.light.index()) {
            Err(e) => Err(format!("{place} names no light ({e})")),
            Ok(index) => match defined.get(index) {
                None => Err(Fault::no_such(&place, "light", index, defined.len()).reason()),
                Some(json) => LightJson::deserialize(json).map_err(|e| format!("light {index}: {e}")).and_then(|json| {
                    let place = format!("light {index}");
                    let kind = kind(&json, placed, &place, warnings)?;
                    let intensity = intensity(&json, &place, warnings);
                    if json.range.is_some() {
                        warnings.push("The range of a light is not followed: light falls off with the square of distance alone.");
                    }
                    Ok(Light { name: name_of(node, json.name.as_ref()), kind, intensity })
                }),
            },
        };
        match parsed {
            Ok(light) => lights.push(light),
            Err(reason) => warnings.push(format!("A light is left out: {reason}.")),
        }
    }
    lights
}

fn intensity(json: &LightJson, place: &str, warnings: &mut Warnings) -> [f32; 3] {
    let mut within = |value: f64, most: f64, name: &str| {
        let clamped = value.clamp(0.0, most);
        if clamped != value {
            warnings.push(format!("The {name} of {place} is {value}; {clamped} is used."));
        }
        clamped
    };
    let intensity = within(json.intensity.unwrap_or(1.0), 1e15, "intensity");
    json.color.unwrap_or([1.0; 3]).map(|c| (within(c, 1e3, "color") * intensity) as f32)
}

fn kind(json: &LightJson, placed: &PlacedNode, place: &str, warnings: &mut Warnings) -> Result<LightKind, String> {
    let position = placed.to_world.translation;
    if !position.is_finite() {
        return Err(format!("node {} has a transform that is not finite", placed.node));
    }
    // Scale changes neither direction nor intensity.
    let direction = || {
        (-placed.to_world.matrix3.z_axis)
            .try_normalize()
            .filter(|d: &DVec3| d.is_finite())
            .ok_or_else(|| format!("node {} has a singular transform", placed.node))
    };
    match json.kind.as_str() {
        "point" => Ok(LightKind::Point { position }),
        "directional" => Ok(LightKind::Directional { direction: direction()? }),
        "spot" => {
            let spot = json.spot.as_ref();
            let stated = (
                spot.and_then(|s| s.inner_cone_angle).unwrap_or(0.0),
                spot.and_then(|s| s.outer_cone_angle).unwrap_or(FRAC_PI_4),
            );
            // As f32 the inner angle must still be below the outer one: the falloff divides by
            // their cosines' difference.
            let outer = stated.1.clamp(1e-3, FRAC_PI_2);
            let inner = stated.0.clamp(0.0, outer * (1.0 - 1e-4));
            if (inner - stated.0).abs() > 1e-3 || (outer - stated.1).abs() > 1e-3 {
                warnings.push(format!(
                    "The cone angles of {place} are {} and {}; {inner} and {outer} are used.",
                    stated.0, stated.1
                ));
            }
            Ok(LightKind::Spot {
                position,
                direction: direction()?,
                inner: inner as f32,
                outer: (outer as f32).min(std::f32::consts::FRAC_PI_2),
            })
        }
        other => Err(format!("{place} has the unknown type {other:?}")),
    }
}
