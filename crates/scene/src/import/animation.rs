//! Animations: the values of node properties, and by KHR_animation_pointer of any other property,
//! at one moment.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::{DQuat, DVec4};
use gltf::json::animation::{Interpolation, Property};
use gltf::json::validation::Checked;
use serde::Deserialize;
use serde_json::Value;

use super::accessor::{Accessors, Component, Typed};
use super::document::{Extensions, Int, get, parse_raw};
use super::error::{Fault, Result};
use super::pointers::{self, Edit, Kind, Target as Animated};
use super::uri::shown;
use super::warnings::Warnings;
use crate::Moment;

/// Elements of a sampler's input or output.
const MAX_KEYFRAMES: usize = 1 << 24;

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

/// Properties of a node that replace those of the JSON.
#[derive(Debug, Default)]
pub(crate) struct Pose {
    pub(crate) translation: Option<[f64; 3]>,
    pub(crate) rotation: Option<[f64; 4]>,
    pub(crate) scale: Option<[f64; 3]>,
    pub(crate) weights: Option<Vec<f64>>,
}

/// Poses by node; empty at rest.
pub(crate) type Poses = HashMap<usize, Pose>;

/// Animated properties at a moment.
#[derive(Debug, Default)]
pub(crate) struct Motion {
    pub(crate) poses: Poses,
    /// Of objects other than nodes.
    pub(crate) edits: Vec<Edit>,
}

/// Animated properties and their values at a moment.
pub(crate) fn motion(accessors: &Accessors, moment: &Moment, warnings: &mut Warnings) -> Result<Motion> {
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
    let mut reader = Reader {
        accessors,
        animation: &animations[index],
        seconds: moment.seconds,
        place: format!("animation {index}"),
        motion: Motion::default(),
        mesh_weights: BTreeMap::new(),
    };
    let mut moved = HashSet::new();
    for channel in &reader.animation.channels {
        let Some((pointer, target)) = reader.target(channel, warnings) else { continue };
        if !moved.insert(pointer.clone()) {
            let pointer = shown(&pointer);
            warnings.push(format!("{} moves {pointer:?} by two channels; the first one is used.", reader.place));
            continue;
        }
        reader.read(channel, &pointer, target, warnings)?;
    }
    Ok(reader.finish())
}

/// Reads the channels of an animation.
struct Reader<'a> {
    accessors: &'a Accessors<'a>,
    animation: &'a AnimationJson,
    seconds: f64,
    /// `animation 0`.
    place: String,
    motion: Motion,
    mesh_weights: BTreeMap<usize, Vec<f64>>,
}

impl Reader<'_> {
    /// The target of a channel, also as a JSON pointer; warns when there is none.
    fn target(&self, channel: &Channel, warnings: &mut Warnings) -> Option<(String, Animated)> {
        if let Checked::Valid(property) = channel.target.path {
            // A channel without a node is for extensions.
            let node = channel.target.node?.index();
            let (name, target) = match property {
                Property::Translation => ("translation", Animated::Translation { node }),
                Property::Rotation => ("rotation", Animated::Rotation { node }),
                Property::Scale => ("scale", Animated::Scale { node }),
                Property::MorphTargetWeights => ("weights", Animated::NodeWeights { node, only: None }),
            };
            return Some((format!("/nodes/{node}/{name}"), target));
        }
        let pointer = pointers::of(&channel.target.extensions);
        let target = pointer.as_deref().and_then(pointers::tokens).and_then(|tokens| pointers::target(&tokens));
        if target.is_none() {
            let place = &self.place;
            warnings.push(match (&pointer, channel.target.extensions.has(pointers::NAME)) {
                (Some(pointer), _) => {
                    let pointer = shown(pointer);
                    format!("{pointer:?} ({}) is no property that {place} can move; it does not move.", pointers::NAME)
                }
                (None, true) => format!("A channel of {place} has an unusable {}; it does not move.", pointers::NAME),
                (None, false) => {
                    format!(
                        "A channel of {place} moves a property of unknown name, which is not supported; it does not move."
                    )
                }
            });
        }
        pointer.zip(target)
    }

    fn read(&mut self, channel: &Channel, pointer: &str, target: Animated, warnings: &mut Warnings) -> Result<()> {
        let sampler = get(&self.animation.samplers, channel.sampler, "sampler", &self.place)?;
        match target {
            Animated::Translation { node } => {
                let value = self.sample(sampler, false)?;
                self.pose(node)?.translation = value;
            }
            Animated::Scale { node } => {
                let value = self.sample(sampler, false)?;
                self.pose(node)?.scale = value;
            }
            Animated::Rotation { node } => {
                let value = self.sample(sampler, true)?;
                self.pose(node)?.rotation = value;
            }
            Animated::NodeWeights { node, only } => {
                let json = get(&self.accessors.document.nodes, Int(node as u64), "node", &self.place)?;
                let mesh = json.mesh.map_or(usize::MAX, Int::index);
                match only {
                    None => {
                        let weights = self.weights(sampler, mesh)?;
                        self.pose(node)?.weights = weights;
                    }
                    Some(only) => {
                        let Some([value]) = self.sample(sampler, false)? else { return Ok(()) };
                        if self.pose(node)?.weights.is_none() {
                            let own = Some(&json.weights).filter(|own| !own.is_empty());
                            let rest = self.rest(mesh, own);
                            self.pose(node)?.weights = Some(rest);
                        }
                        let weights = self.pose(node)?.weights.as_deref_mut().unwrap_or_default();
                        set_weight(weights, only, value, pointer, warnings);
                    }
                }
            }
            Animated::MeshWeights { mesh, only } => {
                get(&self.accessors.document.meshes, Int(mesh as u64), "mesh", &self.place)?;
                match only {
                    None => {
                        let weights = self.weights(sampler, mesh)?;
                        self.mesh_weights.extend(weights.map(|weights| (mesh, weights)));
                    }
                    Some(only) => {
                        let Some([value]) = self.sample(sampler, false)? else { return Ok(()) };
                        if !self.mesh_weights.contains_key(&mesh) {
                            self.mesh_weights.insert(mesh, self.rest(mesh, None));
                        }
                        let weights = self.mesh_weights.entry(mesh).or_default();
                        set_weight(weights, only, value, pointer, warnings);
                    }
                }
            }
            Animated::Json(kind) => {
                let Some(numbers) = self.value(sampler, kind, pointer)? else { return Ok(()) };
                if !numbers.iter().all(|number| number.is_finite()) {
                    let pointer = shown(pointer);
                    warnings.push(format!("{pointer:?} would not be finite; it does not move."));
                    return Ok(());
                }
                let value = match (kind, numbers.as_slice()) {
                    (Kind::Flag, &[number]) => (number != 0.0).into(),
                    (_, &[number]) => number.into(),
                    (_, numbers) => numbers.into(),
                };
                self.edit(pointer, value);
            }
        }
        Ok(())
    }

    /// The pose of a node, which must exist.
    fn pose(&mut self, node: usize) -> Result<&mut Pose> {
        get(&self.accessors.document.nodes, Int(node as u64), "node", &self.place)?;
        Ok(self.motion.poses.entry(node).or_default())
    }

    /// How many morph targets a mesh has.
    fn targets(&self, mesh: usize) -> usize {
        let mesh = self.accessors.document.meshes.get(mesh);
        mesh.map_or(0, |mesh| mesh.primitives.iter().map(|p| p.targets.len()).max().unwrap_or(0))
    }

    fn edit(&mut self, pointer: &str, value: Value) {
        if let Some(tokens) = pointers::tokens(pointer) {
            self.motion.edits.push(Edit { pointer: pointer.into(), tokens, value });
        }
    }

    fn finish(mut self) -> Motion {
        for (mesh, weights) in std::mem::take(&mut self.mesh_weights) {
            // A weight that is no number moves nothing.
            let weights: Vec<f64> = weights.into_iter().map(|w| if w.is_finite() { w } else { 0.0 }).collect();
            self.edit(&format!("/meshes/{mesh}/weights"), weights.into());
        }
        self.motion
    }

    fn sample<const N: usize>(&self, sampler: &Sampler, turns: bool) -> Result<Option<[f64; N]>> {
        sample(self.accessors, sampler, self.seconds, turns, &self.place)
    }

    /// A property that is no node's.
    fn value(&self, sampler: &Sampler, kind: Kind, pointer: &str) -> Result<Option<Vec<f64>>> {
        fn list<const N: usize>(value: Option<[f64; N]>) -> Option<Vec<f64>> {
            value.map(Vec::from)
        }
        match kind {
            Kind::Flag => {
                let output = bounded(self.accessors, sampler.output, &format!("a sampler's output of {}", self.place))?;
                let bytes = output.width == 1 && output.component == Component::U8 && !output.normalized;
                if !bytes || interpolation(sampler, &self.place)? != Interpolation::Step {
                    let cause = format!("moves {:?} by other than unsigned bytes and STEP", shown(pointer));
                    return Err(Fault::invalid(&self.place, cause));
                }
                Ok(list(self.sample::<1>(sampler, false)?))
            }
            Kind::Float => Ok(list(self.sample::<1>(sampler, false)?)),
            Kind::Float2 => Ok(list(self.sample::<2>(sampler, false)?)),
            Kind::Float3 => Ok(list(self.sample::<3>(sampler, false)?)),
            Kind::Float4 => Ok(list(self.sample::<4>(sampler, false)?)),
            Kind::Rotation => Ok(list(self.sample::<4>(sampler, true)?)),
        }
    }

    /// The weights of a mesh's morph targets.
    fn weights(&self, sampler: &Sampler, mesh: usize) -> Result<Option<Vec<f64>>> {
        weights(self.accessors, sampler, self.seconds, self.targets(mesh), &self.place)
    }

    /// The weights of a mesh's morph targets at rest, of which a node may have its own.
    fn rest(&self, mesh: usize, own: Option<&Vec<f64>>) -> Vec<f64> {
        let json = self.accessors.document.meshes.get(mesh);
        let mut weights = own.or(json.map(|mesh| &mesh.weights)).cloned().unwrap_or_default();
        weights.resize(self.targets(mesh), 0.0);
        weights
    }
}

fn set_weight(weights: &mut [f64], index: usize, value: f64, pointer: &str, warnings: &mut Warnings) {
    let count = weights.len();
    match weights.get_mut(index) {
        Some(weight) => *weight = value,
        None => {
            let pointer = shown(pointer);
            warnings.push(format!("{pointer:?} is no weight of the mesh's {count} morph targets; it does not move."));
        }
    }
}

/// Two keyframes around a time and how far it is from the first to the second.
struct KeyframePair {
    first: usize,
    second: usize,
    /// 0 … 1.
    t: f64,
    /// Seconds between the two.
    span: f64,
    keys: usize,
}

/// An accessor of keyframes: without a view, a count alone could take any amount of memory.
fn bounded<'a>(accessors: &Accessors<'a>, index: Int, user: &str) -> Result<Typed<'a>> {
    let of = accessors.typed(index, user)?;
    if of.count > MAX_KEYFRAMES {
        return Err(Fault::too_large(user, format!("has {} elements, and {MAX_KEYFRAMES} are allowed", of.count)));
    }
    Ok(of)
}

/// `None` for a sampler without keyframes.
fn between(accessors: &Accessors, sampler: &Sampler, seconds: f64, place: &str) -> Result<Option<KeyframePair>> {
    let user = format!("a sampler's input of {place}");
    let of = bounded(accessors, sampler.input, &user)?;
    let times: Vec<f64> =
        accessors.floats::<1>(&of, None).map_err(|f| f.used_by(&user))?.into_iter().map(|[t]| f64::from(t)).collect();
    let keys = times.len();
    if keys == 0 {
        return Ok(None);
    }
    // Before the first and after the last keyframe the property keeps their values.
    let after = times.partition_point(|&t| t <= seconds);
    let (first, second) = (after.saturating_sub(1), after.min(keys - 1));
    let span = times[second] - times[first];
    let t = if span > 0.0 { ((seconds - times[first]) / span).clamp(0.0, 1.0) } else { 0.0 };
    Ok(Some(KeyframePair { first, second, t, span, keys }))
}

fn interpolation(sampler: &Sampler, place: &str) -> Result<Interpolation> {
    match sampler.interpolation {
        None => Ok(Interpolation::Linear),
        Some(Checked::Valid(interpolation)) => Ok(interpolation),
        Some(Checked::Invalid) => Err(Fault::invalid(place, "has a sampler of unknown interpolation")),
    }
}

/// A number, a vector or, where it `turns`, a quaternion at a time.
fn sample<const N: usize>(
    accessors: &Accessors,
    sampler: &Sampler,
    seconds: f64,
    turns: bool,
    place: &str,
) -> Result<Option<[f64; N]>> {
    let Some(at) = between(accessors, sampler, seconds, place)? else { return Ok(None) };
    let interpolation = interpolation(sampler, place)?;
    let user = format!("a sampler's output of {place}");
    let of = bounded(accessors, sampler.output, &user)?;
    if of.width != N || of.component == Component::U32 {
        let needed = if N == 1 { "SCALAR".into() } else { format!("VEC{N}") };
        return Err(Fault::invalid(
            place,
            format!("has a sampler whose output is not {needed} of floats or fractions"),
        ));
    }
    let mut read = reader(interpolation, &at, of.count, 1, place, |pick| {
        let values = accessors.floats::<N>(&of, Some(pick)).map_err(|f| f.used_by(&user))?;
        Ok(values
            .into_iter()
            .map(|v| DVec4::from_array(std::array::from_fn(|i| v.get(i).map_or(0.0, |&c| c.into()))))
            .collect())
    })?;
    let value = match (interpolation, turns) {
        (Interpolation::Linear, true) => {
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

/// For each of `width` values a keyframe: the two values around a time, or for splines value,
/// tangent out, tangent in, value. Refuses an output that is too short.
fn reader(
    interpolation: Interpolation,
    at: &KeyframePair,
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
            // The order is in-tangent, value, out-tangent.
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
fn blend(interpolation: Interpolation, at: &KeyframePair, values: &[DVec4]) -> DVec4 {
    let t = at.t;
    match (interpolation, values) {
        (Interpolation::CubicSpline, &[from, out_tangent, in_tangent, to]) => {
            let (t2, t3) = (t * t, t * t * t);
            from * (2.0 * t3 - 3.0 * t2 + 1.0)
                + out_tangent * (at.span * (t3 - 2.0 * t2 + t))
                + to * (3.0 * t2 - 2.0 * t3)
                + in_tangent * (at.span * (t3 - t2))
        }
        (Interpolation::Linear, &[from, to]) => from.lerp(to, t),
        (_, values) => values.first().copied().unwrap_or(DVec4::ZERO),
    }
}

fn slerp(a: DQuat, b: DQuat, t: f64) -> DVec4 {
    let unit = |q: DQuat| if q.is_finite() && q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
    unit(a).slerp(unit(b), t).into()
}
