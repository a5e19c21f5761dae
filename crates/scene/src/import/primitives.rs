//! Primitives: accessors and a mode in, a [`Mesh`] out.

use std::collections::BTreeMap;

use glam::{Vec2, Vec3, Vec4};

use super::accessor::{Accessors, Component, Typed};
use super::document::{Int, Primitive, get};
use super::draco;
use super::error::{Fault, Result};
use super::material_draft::MaterialDraft;
use super::normals::{self, Repair};
use super::skins::{self, Influences, Skin};
use super::tangents;
use super::triangles::{Kind, Mode, kind};
use super::warnings::{Warnings, count_of};
use crate::Mesh;

/// Texture coordinates beyond this are no coordinates: f32 has no fraction left there.
const MAX_UV: f32 = 1e9;

/// Sets of four joints that a vertex may have.
const MAX_JOINT_SETS: usize = 4;

type Triangles = Vec<[u32; 3]>;

/// The morph targets and the skin of a primitive.
pub(crate) struct Deformation<'a> {
    /// Of its morph targets, in order; those left out are 0.
    pub(crate) weights: &'a [f32],
    pub(crate) skin: Option<&'a Skin>,
}

/// A primitive with area whose accessors exist and have sensible types; no vertex has been read
/// yet.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    json: &'a Primitive,
    /// `mesh 0, primitive 1`.
    place: String,
    mode: Mode,
    positions: Typed<'a>,
    /// Vertices: those of `positions`, or of the Draco stream.
    count: usize,
    indices: Option<Typed<'a>>,
    /// Corners: those of `indices`, of vertices without indices, or of the Draco stream.
    corners: usize,
}

impl<'a> Plan<'a> {
    /// Checks a primitive; `None` when it has no area.
    pub(crate) fn new(
        accessors: &Accessors<'a>,
        mesh: usize,
        primitive: usize,
        warnings: &mut Warnings,
    ) -> Result<Option<Self>> {
        let place = format!("mesh {mesh}, primitive {primitive}");
        let meshes = &accessors.document.meshes;
        let json = &get(meshes, Int(mesh as u64), "mesh", &place)?.primitives[primitive];
        let mode = match kind(json.mode) {
            Kind::Triangles(mode) => mode,
            Kind::Thin => {
                warnings.push("Points and lines are not shown: they have no area.");
                return Ok(None);
            }
            Kind::Unknown => {
                return Err(Fault::invalid(place, format!("has the unknown mode {}", json.mode.map_or(0, |m| m.0))));
            }
        };
        let Some(&positions) = json.attributes.get("POSITION") else {
            warnings.push(format!("There is a primitive without POSITION, which is not shown: {place}."));
            return Ok(None);
        };
        let positions = accessors.typed(positions, &user("POSITION", &place))?;
        // A Draco stream holds single triangles, whatever the mode.
        let mode = if json.extensions.has(draco::NAME) { Mode::List } else { mode };
        let indices = match json.indices {
            Some(index) => Some(accessors.typed(index, &user("indices", &place))?),
            None => None,
        };
        let count = positions.count;
        let corners = indices.map_or(count, |i| i.count);
        Ok(Some(Self { json, place, mode, positions, count, indices, corners }))
    }

    /// Bytes that reading takes at most, so that a small file cannot exhaust the memory.
    pub(crate) fn bytes(&self, draft: &MaterialDraft) -> u64 {
        let corners = self.corners as u64;
        let triangles = self.mode.triangles_of(corners as usize) as u64;
        let picked = self.count as u64;
        let vertices = if self.indices.is_some() && !self.positions.is_sparse() { picked.min(corners) } else { picked };
        let normal = if self.json.attributes.contains_key("NORMAL") { 12 } else { 0 };
        let color = if self.json.attributes.contains_key("COLOR_0") { 16 } else { 0 };
        // Tangents are at worst made for every corner.
        let tangents = if draft.tangent_space().is_some() { corners * 80 } else { 0 };
        // Joints and weights, and the differences of one morph target at a time.
        let held = if self.json.attributes.contains_key("JOINTS_0") { 32 } else { 0 };
        let morphed = if self.json.targets.is_empty() { 0 } else { 12 };
        let draco = if self.json.extensions.has(draco::NAME) { 64 } else { 0 };
        vertices * (held + morphed + draco + 12 + normal + color + 8 * draft.uv_sets() as u64)
            + corners * 4
            + triangles * 12
            + tangents
    }

    /// Reads the vertices and triangles that `draft`'s material needs; `material` is that
    /// material's index in the scene.
    pub(crate) fn read(
        &self,
        accessors: &Accessors,
        draft: &MaterialDraft,
        material: usize,
        deformation: &Deformation,
    ) -> Result<(Mesh, Warnings)> {
        let mut warnings = Warnings::default();
        let draco = draco::decode(accessors, self.json, self.count, self.corners, &self.place)?;
        let unfolded = draco.as_ref().map(|draco| self.with_counts_of(draco, &mut warnings)).transpose()?;
        let plan = unfolded.as_ref().unwrap_or(self);
        // Bytes beyond those of the check of all sizes.
        let beyond = plan.bytes(draft).saturating_sub(self.bytes(draft));
        accessors.buffers.reserve(beyond, &self.place)?;
        let (triangles, pick) = plan.triangles(accessors, draco.as_ref(), &mut warnings)?;
        let vertices = Vertices { plan, accessors, draco: draco.as_ref(), pick: pick.as_deref() };
        let positions = vertices.positions()?;
        let mut mesh = Mesh { positions, triangles, material, ..Mesh::default() };
        mesh.normals = vertices.normals(&mesh, &mut warnings)?;
        mesh.uvs = vertices.uvs(draft.uv_sets(), &mut warnings)?;
        mesh.colors = vertices.colors(&mut warnings)?;
        if let Some((uv_set, transform)) = draft.tangent_space() {
            // Tangents without normals are to be ignored: glTF 2.0 section 3.7.2.1.
            mesh.tangents = if mesh.normals.is_some() { vertices.tangents(&mut warnings)? } else { None };
            vertices.deform(&mut mesh, deformation, &mut warnings)?;
            if mesh.tangents.is_none() {
                tangents::generate(&mut mesh, uv_set as usize, transform);
            }
        } else {
            vertices.deform(&mut mesh, deformation, &mut warnings)?;
        }
        Ok((mesh, warnings))
    }

    /// The plan with the counts of its Draco stream, which take precedence over those of the
    /// accessors: encoders split vertices.
    fn with_counts_of(&self, draco: &draco::Decoded, warnings: &mut Warnings) -> Result<Self> {
        let (count, triangles) = (draco.vertices(), draco.triangles());
        let place = &self.place;
        if self.indices.is_none() {
            warnings.push(format!(
                "The Draco stream of {place} has no indices accessor beside it; its own indices are used."
            ));
        }
        if count != self.count || (self.indices.is_some() && triangles != self.corners / 3) {
            if !draco.has("POSITION") {
                let cause = format!("has {} positions beside a Draco stream of {count} vertices", self.count);
                return Err(Fault::invalid(place, cause));
            }
            let stated = match &self.indices {
                Some(_) => format!("{} and {}", count_of(self.count, "vertex"), count_of(self.corners / 3, "triangle")),
                None => count_of(self.count, "vertex"),
            };
            warnings.push(format!(
                "The Draco stream of {place} has {} and {} where its accessors state {stated}; the stream is used.",
                count_of(count, "vertex"),
                count_of(triangles, "triangle"),
            ));
        }
        Ok(Self { count, corners: 3 * triangles, place: place.clone(), ..*self })
    }

    /// The triangles, and which of the file's vertices they use when a selection pays.
    fn triangles(
        &self,
        accessors: &Accessors,
        draco: Option<&draco::Decoded>,
        warnings: &mut Warnings,
    ) -> Result<(Triangles, Option<Vec<u32>>)> {
        let count = self.count;
        let unused = self.mode.unused_of(self.corners);
        if unused > 0 {
            warnings.push(format!("{} at the end of {} make no triangle.", count_of(unused, "corner"), self.place));
        }
        let mut indices = match (draco, &self.indices) {
            (Some(draco), _) => draco.indices(),
            (None, Some(typed)) => accessors.indices(typed).map_err(|f| f.used_by(&user("indices", &self.place)))?,
            (None, None) => return Ok((self.mode.triangles(count, |i| i as u32), None)),
        };
        if let Some(at) = indices.iter().position(|&i| i as usize >= count) {
            let cause = format!("has index {} at place {at}, but its vertices are {count}", indices[at]);
            return Err(Fault::invalid(&self.place, cause));
        }
        // Exporters let many primitives share one large vertex array: keep what this one uses.
        let mut pick = None;
        if indices.len() < count {
            let mut used = indices.clone();
            used.sort_unstable();
            used.dedup();
            for index in &mut indices {
                *index = used.partition_point(|u| u < index) as u32;
            }
            pick = Some(used);
        }
        Ok((self.mode.triangles(indices.len(), |i| indices[i]), pick))
    }
}

fn user(what: &str, place: &str) -> String {
    format!("{what} of {place}")
}

/// The vertex attributes of a primitive, of all its vertices or the picked ones.
struct Vertices<'a> {
    plan: &'a Plan<'a>,
    accessors: &'a Accessors<'a>,
    draco: Option<&'a draco::Decoded>,
    pick: Option<&'a [u32]>,
}

impl Vertices<'_> {
    /// An attribute's accessor, which must have as many elements as POSITION.
    fn typed(&self, name: &str, legal: impl Fn(&Typed) -> bool, needed: &str) -> Result<Option<Typed<'_>>> {
        let Some(&index) = self.plan.json.attributes.get(name) else {
            return Ok(None);
        };
        let typed = self.accessors.typed(index, &user(name, &self.plan.place))?;
        let place = || format!("accessor {} ({})", index.index(), user(name, &self.plan.place));
        // Data of a Draco stream has the stream's counts.
        if typed.count != self.plan.count && !self.draco.is_some_and(|draco| draco.has(name)) {
            let cause = format!("has {} elements, but POSITION has {}", typed.count, self.plan.count);
            return Err(Fault::invalid(place(), cause));
        }
        if !legal(&typed) {
            return Err(Fault::invalid(place(), format!("is not {needed}")));
        }
        Ok(Some(typed))
    }

    fn floats<const N: usize>(&self, of: &Typed, name: &str) -> Result<Vec<[f32; N]>> {
        if let Some(floats) = self.draco.and_then(|draco| draco.floats(of, name, self.pick)) {
            return floats;
        }
        self.accessors.floats(of, self.pick).map_err(|f| f.used_by(&user(name, &self.plan.place)))
    }

    /// Components that positions and texture coordinates may have; integers by
    /// KHR_mesh_quantization alone.
    fn is_length(&self, typed: &Typed) -> bool {
        let short = !matches!(typed.component, Component::U32 | Component::F32);
        typed.component == Component::F32 || short && self.accessors.quantized
    }

    /// The same for normals and tangents, which have signs.
    fn is_direction(&self, typed: &Typed) -> bool {
        let signed = matches!(typed.component, Component::I8 | Component::I16) && typed.normalized;
        typed.component == Component::F32 || signed && self.accessors.quantized
    }

    /// The same for the displacements of a morph target, which need not be below 1.
    fn is_signed(&self, typed: &Typed) -> bool {
        let signed = matches!(typed.component, Component::I8 | Component::I16);
        typed.component == Component::F32 || signed && self.accessors.quantized
    }

    fn positions(&self) -> Result<Vec<Vec3>> {
        let legal = |t: &Typed| t.width == 3 && self.is_length(t);
        let Some(typed) = self.typed("POSITION", legal, "a VEC3 of floats")? else {
            return Ok(Vec::new());
        };
        Ok(vec3s(self.floats(&typed, "POSITION")?))
    }

    fn normals(&self, mesh: &Mesh, warnings: &mut Warnings) -> Result<Option<Vec<Vec3>>> {
        let legal = |t: &Typed| t.width == 3 && self.is_direction(t);
        let Some(typed) = self.typed("NORMAL", legal, "a VEC3 of floats")? else {
            return Ok(None);
        };
        let mut normals = vec3s(self.floats(&typed, "NORMAL")?);
        Ok(match normals::normalise(&mut normals, &mesh.positions, &mesh.triangles) {
            Repair::None => Some(normals),
            Repair::Some(bad) => {
                let bad = count_of(bad, "normal");
                warnings
                    .push(format!("{bad} of {} cannot be normalised; the triangles around give it.", self.plan.place));
                Some(normals)
            }
            Repair::All => {
                if !normals.is_empty() {
                    warnings.push(format!("No normal of {} can be normalised; it is shaded flat.", self.plan.place));
                }
                None
            }
        })
    }

    fn uvs(&self, sets: usize, warnings: &mut Warnings) -> Result<Vec<Vec<Vec2>>> {
        let legal = |t: &Typed| t.width == 2 && (is_fraction(t) || self.is_length(t));
        (0..sets)
            .map(|set| {
                let name = format!("TEXCOORD_{set}");
                let Some(typed) = self.typed(&name, legal, "a VEC2 of floats or normalised unsigned integers")? else {
                    if set + 1 == sets {
                        warnings.push(format!(
                            "The material of {} uses {name}, which it lacks; 0 is used.",
                            self.plan.place
                        ));
                    }
                    let count = self.pick.map_or(self.plan.count, <[u32]>::len);
                    return Ok(vec![Vec2::ZERO; count]);
                };
                let mut uvs: Vec<Vec2> = self.floats(&typed, &name)?.into_iter().map(Vec2::from_array).collect();
                let mut bad = 0;
                for uv in &mut uvs {
                    // NaN is not less than anything.
                    if !uv.abs().cmplt(Vec2::splat(MAX_UV)).all() {
                        *uv = Vec2::ZERO;
                        bad += 1;
                    }
                }
                if bad > 0 {
                    let bad = count_of(bad, "element");
                    warnings.push(format!("{bad} of {name} of {} are not finite; 0 is used.", self.plan.place));
                }
                Ok(uvs)
            })
            .collect()
    }

    /// Moves the vertices by morph targets, then by the skin; glTF 2.0 sections 3.7.2.2 and 3.7.3.
    fn deform(&self, mesh: &mut Mesh, by: &Deformation, warnings: &mut Warnings) -> Result<()> {
        let place = &self.plan.place;
        for (target, &weight) in self.plan.json.targets.iter().zip(by.weights).filter(|(_, weight)| **weight != 0.0) {
            if let Some(by) = self.differences(target, "POSITION", Self::is_length)? {
                skins::morph(&mut mesh.positions, &by, weight);
            }
            if let (Some(normals), Some(by)) = (&mut mesh.normals, self.differences(target, "NORMAL", Self::is_signed)?)
            {
                skins::morph(normals, &by, weight);
            }
            if let (Some(tangents), Some(by)) =
                (&mut mesh.tangents, self.differences(target, "TANGENT", Self::is_signed)?)
            {
                skins::morph_tangents(tangents, &by, weight);
            }
            if target.keys().any(|name| name.starts_with("TEXCOORD_") || name.starts_with("COLOR_")) {
                warnings.push(format!("Morph targets of colours or texture coordinates are not followed ({place})."));
            }
        }
        if !by.weights.is_empty() {
            let unit = |v: Vec3| normals::unit(v).unwrap_or(Vec3::Z);
            mesh.normals.iter_mut().flatten().for_each(|normal| *normal = unit(*normal));
            mesh.tangents.iter_mut().flatten().for_each(|t| *t = unit(t.truncate()).extend(t.w));
        }
        match by.skin {
            Some(skin) => skin.apply(mesh, &self.influences()?, place, warnings),
            None => Ok(()),
        }
    }

    /// The displacements of an attribute by a morph target.
    fn differences(
        &self,
        target: &BTreeMap<String, Int>,
        name: &str,
        legal: fn(&Self, &Typed) -> bool,
    ) -> Result<Option<Vec<[f32; 3]>>> {
        let Some(&index) = target.get(name) else { return Ok(None) };
        let user = user(&format!("{name} of a morph target"), &self.plan.place);
        let typed = self.accessors.typed(index, &user)?;
        if typed.count != self.plan.count || typed.width != 3 || !legal(self, &typed) {
            let cause = format!("is not a VEC3 of {} floats", self.plan.count);
            return Err(Fault::invalid(format!("accessor {} ({user})", index.index()), cause));
        }
        self.accessors.floats(&typed, self.pick).map(Some).map_err(|f| f.used_by(&user))
    }

    /// Joints and weights, all sets of four.
    fn influences(&self) -> Result<Vec<Influences>> {
        let is_joint =
            |t: &Typed| t.width == 4 && matches!(t.component, Component::U8 | Component::U16) && !t.normalized;
        let is_weight = |t: &Typed| t.width == 4 && is_fraction(t);
        let mut sets = Vec::new();
        for set in 0..MAX_JOINT_SETS {
            let names = [format!("JOINTS_{set}"), format!("WEIGHTS_{set}")];
            let joints = self.typed(&names[0], is_joint, "a VEC4 of unsigned bytes or shorts")?;
            let weights = self.typed(&names[1], is_weight, "a VEC4 of floats or normalised unsigned integers")?;
            let (Some(joints), Some(weights)) = (joints, weights) else { break };
            sets.push(Influences {
                joints: self.floats(&joints, &names[0])?,
                weights: self.floats(&weights, &names[1])?,
            });
        }
        Ok(sets)
    }

    fn colors(&self, warnings: &mut Warnings) -> Result<Option<Vec<Vec4>>> {
        let legal = |t: &Typed| (t.width == 3 || t.width == 4) && is_fraction(t);
        let needed = "a VEC3 or VEC4 of floats or normalised unsigned integers";
        let Some(typed) = self.typed("COLOR_0", legal, needed)? else {
            return Ok(None);
        };
        let colors: Vec<[f32; 4]> = if typed.width == 4 {
            self.floats(&typed, "COLOR_0")?
        } else {
            self.floats::<3>(&typed, "COLOR_0")?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
        };
        if colors.iter().flatten().any(|c| c.is_nan()) {
            warnings.push(format!("COLOR_0 of {} has NaN in it; 0 is used.", self.plan.place));
        }
        // To [0, 1] as glTF says.
        let in_range = |c: f32| if c.is_nan() { 0.0 } else { c.clamp(0.0, 1.0) };
        Ok(Some(colors.into_iter().map(|c| Vec4::from_array(c.map(in_range))).collect()))
    }

    fn tangents(&self, warnings: &mut Warnings) -> Result<Option<Vec<Vec4>>> {
        let legal = |t: &Typed| t.width == 4 && self.is_direction(t);
        let Some(typed) = self.typed("TANGENT", legal, "a VEC4 of floats")? else {
            return Ok(None);
        };
        let tangents = tangents::normalise(self.floats(&typed, "TANGENT")?);
        if tangents.is_none() {
            warnings.push(format!("Some tangents of {} are unusable; all are made by MikkTSpace.", self.plan.place));
        }
        Ok(tangents)
    }
}

fn is_fraction(typed: &Typed) -> bool {
    match typed.component {
        Component::F32 => true,
        Component::U8 | Component::U16 => typed.normalized,
        Component::I8 | Component::I16 | Component::U32 => false,
    }
}

fn vec3s(arrays: Vec<[f32; 3]>) -> Vec<Vec3> {
    arrays.into_iter().map(Vec3::from_array).collect()
}
