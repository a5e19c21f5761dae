//! Animations: what the nodes' properties are at one moment.

use std::collections::HashMap;

use glam::{DQuat, DVec4};
use gltf::json::animation::{Interpolation, Property};
use gltf::json::validation::Checked;
use serde::Deserialize;

use super::accessor::{Accessors, Component, Typed};
use super::document::{Extensions, Int, get, parse_raw};
use super::error::{Fault, Result};
use super::warnings::Warnings;
use crate::Moment;

/// Elements of a sampler's input or output.
const MOST_KEYS: usize = 1 << 24;

/// An animation of the JSON.
#[derive(Debug, Deserialize)]
pub(crate) struct AnimationJson {
    name: Option<String>,
    #[serde(default)]
    channels: Vec<Channel>,
    #[serde(default)]
    samplers: Vec<Sampler>,
}

#[derive(Debug, Deserialize)]
struct Channel {
    sampler: Int,
    target: Target,
}

#[derive(Debug, Deserialize)]
struct Target {
    node: Option<Int>,
    path: Checked<Property>,
    #[serde(default)]
    extensions: Extensions,
}

#[derive(Debug, Deserialize)]
struct Sampler {
    input: Int,
    output: Int,
    interpolation: Option<Checked<Interpolation>>,
}

/// Properties of a node that differ from what the node says.
#[derive(Debug, Default)]
pub(crate) struct Pose {
    pub(crate) translation: Option<[f64; 3]>,
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    pub(crate) weights: Option<Vec<f64>>,
}

/// Poses by node; empty at rest.
pub(crate) type Poses = HashMap<usize, Pose>;

/// The poses of a moment.
pub(crate) fn poses(accessors: &Accessors, moment: &Moment, warnings: &mut Warnings) -> Result<Poses> {
    let animations: Vec<AnimationJson> = match accessors.document.animations.as_deref().map(parse_raw) {
        None => Vec::new(),
        Some(Ok(animations)) => animations,
        Some(Err(e)) => return Err(Fault::invalid("animations in its JSON", format!("cannot be read: {e}"))),
    };
    let named = animations.iter().position(|a| a.name.as_deref() == Some(&moment.animation));
    let numbered = || moment.animation.parse().ok().filter(|&i: &usize| i < animations.len());
    let Some(index) = named.or_else(numbered) else {
        let names: Vec<String> = animations
            .iter()
            .enumerate()
            .take(20)
            .map(|(i, a)| a.name.as_ref().map_or_else(|| i.to_string(), |name| format!("{name:?}")))
            .collect();
        let known = if names.is_empty() { "none".into() } else { names.join(", ") };
        let cause = format!("is {:?}, but the file has {known}", moment.animation);
        return Err(Fault::invalid("the choice of an animation", cause));
    };
    let place = format!("animation {index}");
    let animation = &animations[index];
    let mut poses = Poses::new();
    for channel in &animation.channels {
        let Checked::Valid(property) = channel.target.path else {
            let pointer = channel.target.extensions.has("KHR_animation_pointer");
            let what = if pointer { "KHR_animation_pointer" } else { "a property of unknown name" };
            warnings.push(format!("A channel of {place} moves {what}, which is not supported; it stands still."));
            continue;
        };
        // A channel without a node is for extensions.
        let Some(node) = channel.target.node else { continue };
        let node_json = get(&accessors.document.nodes, node, "node", &place)?;
        let sampler = get(&animation.samplers, channel.sampler, "sampler", &place)?;
        let pose = poses.entry(node.index()).or_default();
        match property {
            Property::Translation => pose.translation = sample::<3>(accessors, sampler, moment.seconds, &place)?,
            Property::Scale => pose.scale = sample::<3>(accessors, sampler, moment.seconds, &place)?,
            Property::Rotation => pose.rotation = sample::<4>(accessors, sampler, moment.seconds, &place)?,
            Property::MorphTargetWeights => {
                let mesh = node_json.mesh.and_then(|m| accessors.document.meshes.get(m.index()));
                let targets = mesh.map_or(0, |m| m.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0));
                pose.weights = weights(accessors, sampler, moment.seconds, targets, &place)?;
            }
        }
    }
    Ok(poses)
}

/// Two keyframes around a time and how far it is from the first to the second.
struct Between {
    first: usize,
    second: usize,
    /// 0 … 1.
    t: f64,
    /// Seconds between the two.
    span: f64,
    keys: usize,
}

/// An accessor of keyframes: without a view, a number alone could ask for any memory.
fn bounded<'a>(accessors: &Accessors<'a>, index: Int, user: &str) -> Result<Typed<'a>> {
    let of = accessors.typed(index, user)?;
    if of.count > MOST_KEYS {
        return Err(Fault::too_large(user, format!("has {} elements, and {MOST_KEYS} are allowed", of.count)));
    }
    Ok(of)
}

/// `None` for a sampler without keyframes.
fn between(accessors: &Accessors, sampler: &Sampler, seconds: f64, place: &str) -> Result<Option<Between>> {
    let user = format!("a sampler's input of {place}");
    let of = bounded(accessors, sampler.input, &user)?;
    let times: Vec<f64> =
        accessors.floats::<1>(&of, None).map_err(|f| f.used_by(&user))?.into_iter().map(|[t]| f64::from(t)).collect();
    let keys = times.len();
    if keys == 0 {
        return Ok(None);
    }
    // Before the first and after the last keyframe the property stands still.
    let after = times.partition_point(|&t| t <= seconds);
    let (first, second) = (after.saturating_sub(1), after.min(keys - 1));
    let span = times[second] - times[first];
    let t = if span > 0.0 { ((seconds - times[first]) / span).clamp(0.0, 1.0) } else { 0.0 };
    Ok(Some(Between { first, second, t, span, keys }))
}

fn interpolation(sampler: &Sampler, place: &str) -> Result<Interpolation> {
    match sampler.interpolation {
        None => Ok(Interpolation::Linear),
        Some(Checked::Valid(interpolation)) => Ok(interpolation),
        Some(Checked::Invalid) => Err(Fault::invalid(place, "has a sampler of unknown interpolation")),
    }
}

/// A vector or quaternion at a time.
fn sample<const N: usize>(
    accessors: &Accessors,
    sampler: &Sampler,
    seconds: f64,
    place: &str,
) -> Result<Option<[f64; N]>> {
    let Some(at) = between(accessors, sampler, seconds, place)? else { return Ok(None) };
    let interpolation = interpolation(sampler, place)?;
    let user = format!("a sampler's output of {place}");
    let of = bounded(accessors, sampler.output, &user)?;
    if of.width != N || of.component == Component::U32 {
        return Err(Fault::invalid(place, format!("has a sampler whose output is not VEC{N}")));
    }
    let mut read = reader(interpolation, &at, of.count, 1, place, |pick| {
        let values = accessors.floats::<N>(&of, Some(pick)).map_err(|f| f.used_by(&user))?;
        Ok(values
            .into_iter()
            .map(|v| DVec4::from_array(std::array::from_fn(|i| v.get(i).map_or(0.0, |&c| c.into()))))
            .collect())
    })?;
    let value = match (interpolation, N) {
        (Interpolation::Linear, 4) => {
            let [a, b] = [read[0][0], read[0][1]].map(DQuat::from_vec4);
            // Quaternions and their negatives turn alike: the shorter way round.
            slerp(a, b, at.t)
        }
        _ => blend(interpolation, &at, &read.remove(0)),
    };
    Ok(Some(std::array::from_fn(|i| value.to_array().get(i).copied().unwrap_or(0.0))))
}

/// Weights of `targets` morph targets at a time.
fn weights(
    accessors: &Accessors,
    sampler: &Sampler,
    seconds: f64,
    targets: usize,
    place: &str,
) -> Result<Option<Vec<f64>>> {
    let Some(at) = between(accessors, sampler, seconds, place)? else { return Ok(None) };
    let interpolation = interpolation(sampler, place)?;
    let user = format!("a sampler's output of {place}");
    let of = bounded(accessors, sampler.output, &user)?;
    let read = reader(interpolation, &at, of.count, targets, place, |pick| {
        let values = accessors.floats::<1>(&of, Some(pick)).map_err(|f| f.used_by(&user))?;
        Ok(values.into_iter().map(|[v]| DVec4::splat(f64::from(v))).collect())
    })?;
    Ok(Some(read.iter().map(|values| blend(interpolation, &at, values).x).collect()))
}

/// For each of `width` values a keyframe: the two values around a time, or for splines value, tangent out, tangent in,
/// value. Refuses an output that is too short.
fn reader(
    interpolation: Interpolation,
    at: &Between,
    count: usize,
    width: usize,
    place: &str,
    read: impl FnOnce(&[u32]) -> Result<Vec<DVec4>>,
) -> Result<Vec<Vec<DVec4>>> {
    let rows = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let needed = at.keys as u64 * rows as u64 * width as u64;
    if (count as u64) < needed {
        let cause = format!("has a sampler with {count} outputs, where {needed} are needed");
        return Err(Fault::invalid(place, cause));
    }
    let index = |key: usize, row: usize, value: usize| ((key * rows + row) * width + value) as u32;
    let pick: Vec<u32> = (0..width)
        .flat_map(|value| match rows {
            // In-tangent, value, out-tangent stand in this order.
            3 => vec![
                index(at.first, 1, value),
                index(at.first, 2, value),
                index(at.second, 0, value),
                index(at.second, 1, value),
            ],
            _ => vec![index(at.first, 0, value), index(at.second, 0, value)],
        })
        .collect();
    let values = read(&pick)?;
    Ok(values.chunks(pick.len().checked_div(width).unwrap_or(1).max(1)).map(<[DVec4]>::to_vec).collect())
}

/// Between two keyframes; glTF 2.0 appendix C.
fn blend(interpolation: Interpolation, at: &Between, values: &[DVec4]) -> DVec4 {
    let t = at.t;
    match (interpolation, values) {
        (Interpolation::CubicSpline, &[from, leave, arrive, to]) => {
            let (t2, t3) = (t * t, t * t * t);
            from * (2.0 * t3 - 3.0 * t2 + 1.0)
                + leave * (at.span * (t3 - 2.0 * t2 + t))
                + to * (3.0 * t2 - 2.0 * t3)
                + arrive * (at.span * (t3 - t2))
        }
        (Interpolation::Linear, &[from, to]) => from.lerp(to, t),
        (_, values) => values.first().copied().unwrap_or(DVec4::ZERO),
    }
}

fn slerp(a: DQuat, b: DQuat, t: f64) -> DVec4 {
    let unit = |q: DQuat| if q.is_finite() && q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    unit(a).slerp(unit(b), t).into()
}
