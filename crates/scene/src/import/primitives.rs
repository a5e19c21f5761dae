//! Primitives: accessors and a mode in, a [`Mesh`] out.

use glam::{Vec2, Vec3, Vec4};

use super::accessor::{Accessors, Component, Typed};
use super::document::{Int, Primitive, get};
use super::error::{Fault, Result};
use super::materials::Draft;
use super::normals::{self, Repair};
use super::tangents;
use super::triangles::{Kind, Mode, kind};
use super::warnings::{Warnings, count_of};
use crate::Mesh;

/// Texture coordinates beyond this are no coordinates: f32 has no fraction left there.
const MOST_UV: f32 = 1e9;

type Triangles = Vec<[u32; 3]>;

/// A primitive with area whose accessors exist and have sensible types; no vertex has been read yet.
#[derive(Debug)]
pub(crate) struct Plan<'a> {
    json: &'a Primitive,
    /// `mesh 0, primitive 1`.
    place: String,
    mode: Mode,
    positions: Typed<'a>,
    indices: Option<Typed<'a>>,
}

impl<'a> Plan<'a> {
    /// Checks a primitive; `None` when it has nothing that a path tracer could show.
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
        if json.extensions.has("KHR_draco_mesh_compression") && !positions.has_view() {
            return Err(Fault::invalid(
                place,
                "is compressed with Draco, which is not supported, and has no plain copy",
            ));
        }
        let indices = match json.indices {
            Some(index) => Some(accessors.typed(index, &user("indices", &place))?),
            None => None,
        };
        Ok(Some(Self { json, place, mode, positions, indices }))
    }

    /// Bytes that reading takes at most, so that a small file cannot ask for all memory.
    pub(crate) fn bytes(&self, draft: &Draft) -> u64 {
        let corners = self.indices.map_or(self.positions.count, |i| i.count) as u64;
        let triangles = self.mode.triangles_of(corners as usize) as u64;
        let picked = self.positions.count as u64;
        let vertices = if self.indices.is_some() && !self.positions.is_sparse() { picked.min(corners) } else { picked };
        let normal = if self.json.attributes.contains_key("NORMAL") { 12 } else { 0 };
        let color = if self.json.attributes.contains_key("COLOR_0") { 16 } else { 0 };
        // Tangents are at worst made for every corner.
        let tangents = if draft.normal.is_some() { corners * 80 } else { 0 };
        vertices * (12 + normal + color + 8 * draft.uv_sets() as u64) + corners * 4 + triangles * 12 + tangents
    }

    /// Reads the vertices and triangles that `draft`'s material needs; `material` is that material's index in the scene.
    pub(crate) fn read(&self, accessors: &Accessors, draft: &Draft, material: usize) -> Result<(Mesh, Warnings)> {
        let mut warnings = Warnings::default();
        let (triangles, pick) = self.triangles(accessors, &mut warnings)?;
        let vertices = Vertices { plan: self, accessors, pick: pick.as_deref() };
        let positions = vertices.positions()?;
        let mut mesh = Mesh { positions, triangles, material, ..Mesh::default() };
        mesh.normals = vertices.normals(&mesh, &mut warnings)?;
        mesh.uvs = vertices.uvs(draft.uv_sets(), &mut warnings)?;
        mesh.colors = vertices.colors(&mut warnings)?;
        if let Some((lookup, _)) = &draft.normal {
            // Tangents without normals are to be ignored: glTF 2.0 section 3.7.2.1.
            mesh.tangents = if mesh.normals.is_some() { vertices.tangents(&mut warnings)? } else { None };
            if mesh.tangents.is_none() {
                tangents::generate(&mut mesh, lookup.uv_set as usize, lookup.transform);
            }
        }
        Ok((mesh, warnings))
    }

    /// The triangles, and which of the file's vertices they use when that is worth a selection.
    fn triangles(&self, accessors: &Accessors, warnings: &mut Warnings) -> Result<(Triangles, Option<Vec<u32>>)> {
        let count = self.positions.count;
        let corners = self.indices.map_or(count, |i| i.count);
        let unused = self.mode.unused_of(corners);
        if unused > 0 {
            warnings.push(format!("{} at the end of {} make no triangle.", count_of(unused, "corner"), self.place));
        }
        let Some(typed) = &self.indices else {
            return Ok((self.mode.triangles(count, |i| i as u32), None));
        };
        let mut indices = accessors.indices(typed).map_err(|f| f.used_by(&user("indices", &self.place)))?;
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
    pick: Option<&'a [u32]>,
}

impl Vertices<'_> {
    /// An attribute's accessor, which must have as many elements as POSITION.
    fn typed(&self, name: &str, legal: fn(&Typed) -> bool, needed: &str) -> Result<Option<Typed<'_>>> {
        let Some(&index) = self.plan.json.attributes.get(name) else {
            return Ok(None);
        };
        let typed = self.accessors.typed(index, &user(name, &self.plan.place))?;
        let place = || format!("accessor {} ({})", index.index(), user(name, &self.plan.place));
        if typed.count != self.plan.positions.count {
            let cause = format!("has {} elements, but POSITION has {}", typed.count, self.plan.positions.count);
            return Err(Fault::invalid(place(), cause));
        }
        if !legal(&typed) {
            return Err(Fault::invalid(place(), format!("is not {needed}")));
        }
        Ok(Some(typed))
    }

    fn floats<const N: usize>(&self, of: &Typed, name: &str) -> Result<Vec<[f32; N]>> {
        self.accessors.floats(of, self.pick).map_err(|f| f.used_by(&user(name, &self.plan.place)))
    }

    fn positions(&self) -> Result<Vec<Vec3>> {
        let is_float3 = |t: &Typed| t.width == 3 && t.component == Component::F32;
        let Some(typed) = self.typed("POSITION", is_float3, "a VEC3 of floats")? else {
            return Ok(Vec::new());
        };
        Ok(vec3s(self.floats(&typed, "POSITION")?))
    }

    fn normals(&self, mesh: &Mesh, warnings: &mut Warnings) -> Result<Option<Vec<Vec3>>> {
        let is_float3 = |t: &Typed| t.width == 3 && t.component == Component::F32;
        let Some(typed) = self.typed("NORMAL", is_float3, "a VEC3 of floats")? else {
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
        let legal = |t: &Typed| t.width == 2 && is_fraction(t);
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
                    let count = self.pick.map_or(self.plan.positions.count, <[u32]>::len);
                    return Ok(vec![Vec2::ZERO; count]);
                };
                let mut uvs: Vec<Vec2> = self.floats(&typed, &name)?.into_iter().map(Vec2::from_array).collect();
                let mut bad = 0;
                for uv in &mut uvs {
                    // NaN is not less than anything.
                    if !uv.abs().cmplt(Vec2::splat(MOST_UV)).all() {
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
        let is_float4 = |t: &Typed| t.width == 4 && t.component == Component::F32;
        let Some(typed) = self.typed("TANGENT", is_float4, "a VEC4 of floats")? else {
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
