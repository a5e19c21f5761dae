//! Tangents for normal maps: the file's where they are usable, else MikkTSpace.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Affine2, Vec2, Vec3, Vec4};

use super::normals::{face, unit};
use crate::Mesh;

/// Makes the file's tangents unit vectors with a sign of ±1; `None` when any of them cannot be.
pub(crate) fn normalise(tangents: Vec<[f32; 4]>) -> Option<Vec<Vec4>> {
    tangents
        .into_iter()
        .map(|[x, y, z, w]| {
            let sign = if w > 0.0 { 1.0 } else { -1.0 };
            (w != 0.0 && w.is_finite()).then_some(())?;
            Some(unit(Vec3::new(x, y, z))?.extend(sign))
        })
        .collect()
}

/// Fills `mesh.tangents` by MikkTSpace for the coordinates that the normal map is looked up with
/// (its set and transform: a turned map turns its bumps). Vertices at which triangles disagree are
/// split.
pub(crate) fn generate(mesh: &mut Mesh, uv_set: usize, transform: Option<Affine2>) {
    // Coordinates beyond this overflow in products; such triangles are far outside any scene that
    // can be traced.
    const FAR: f32 = 1e12;
    if mesh.normals.is_none() {
        unweld(mesh);
    }
    let transform = transform.unwrap_or(Affine2::IDENTITY);
    let uvs: Vec<Vec2> = match mesh.uvs.get(uv_set) {
        Some(set) => set.iter().map(|&uv| transform.transform_point2(uv)).collect(),
        None => vec![Vec2::ZERO; mesh.positions.len()],
    };
    // NaN is not less than anything.
    let near = |v: u32| mesh.positions[v as usize].abs().cmplt(Vec3::splat(FAR)).all();
    let faces: Vec<usize> = (0..mesh.triangles.len()).filter(|&t| mesh.triangles[t].iter().all(|&v| near(v))).collect();
    let corner_normals: Vec<Vec3> = match &mesh.normals {
        Some(_) => Vec::new(),
        None => mesh.triangles.iter().map(|&t| face(&mesh.positions, t).unwrap_or(Vec3::Z)).collect(),
    };
    let mut surface = Surface { mesh, uvs: &uvs, faces: &faces, face_normals: &corner_normals, tangents: Vec::new() };
    surface.tangents = vec![None; mesh.triangles.len() * 3];
    // The error type has no values in this version; a future failure leaves the fallback tangents.
    let _ = generate_tangents(&mut surface);
    let corners = surface.tangents;
    let tangents: Vec<Vec4> = corners
        .iter()
        .enumerate()
        .map(|(corner, tangent)| {
            tangent.and_then(unit_tangent).unwrap_or_else(|| {
                let normal = match &mesh.normals {
                    Some(normals) => normals[mesh.triangles[corner / 3][corner % 3] as usize],
                    None => corner_normals[corner / 3],
                };
                normal.any_orthonormal_vector().extend(1.0)
            })
        })
        .collect();
    weld(mesh, &tangents);
}

fn unit_tangent(tangent: [f32; 4]) -> Option<Vec4> {
    Some(unit(Vec3::new(tangent[0], tangent[1], tangent[2]))?.extend(tangent[3]))
}

/// The mesh as MikkTSpace reads it.
struct Surface<'a> {
    mesh: &'a Mesh,
    uvs: &'a [Vec2],
    /// Triangles to process.
    faces: &'a [usize],
    /// A normal a triangle, for flat meshes.
    face_normals: &'a [Vec3],
    /// Three a triangle.
    tangents: Vec<Option<[f32; 4]>>,
}

impl Surface<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[self.faces[face]][corner] as usize
    }
}

impl Geometry for Surface<'_> {
    fn num_faces(&self) -> usize {
        self.faces.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        match &self.mesh.normals {
            Some(normals) => normals[self.vertex(face, vert)].to_array(),
            None => self.face_normals[self.faces[face]].to_array(),
        }
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        // v points up in MikkTSpace, down in glTF.
        let uv = self.uvs[self.vertex(face, vert)];
        [uv.x, 1.0 - uv.y]
    }

    fn set_tangent(&mut self, tangent: Option<TangentSpace>, face: usize, vert: usize) {
        self.tangents[self.faces[face] * 3 + vert] = tangent.map(|t| t.tangent_encoded());
    }
}

/// Gives every corner its own vertex.
fn unweld(mesh: &mut Mesh) {
    let order: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    pick_vertices(mesh, &order);
    for (i, triangle) in mesh.triangles.iter_mut().enumerate() {
        let first = 3 * i as u32;
        *triangle = [first, first + 1, first + 2];
    }
}

/// Sets the tangents, three per triangle, splitting vertices whose corners differ.
fn weld(mesh: &mut Mesh, corners: &[Vec4]) {
    const NONE: u32 = u32::MAX;
    let vertices = mesh.positions.len();
    let mut tangents: Vec<Option<Vec4>> = vec![None; vertices];
    let mut next = vec![NONE; vertices];
    let mut order: Vec<u32> = (0..vertices as u32).collect();
    for (triangle, corners) in mesh.triangles.iter_mut().zip(corners.chunks_exact(3)) {
        for (index, &tangent) in triangle.iter_mut().zip(corners) {
            // Copies of a vertex form a list that begins with the vertex itself.
            let mut at = *index as usize;
            loop {
                match tangents[at] {
                    None => tangents[at] = Some(tangent),
                    Some(other) if other == tangent => {}
                    Some(_) if next[at] != NONE => {
                        at = next[at] as usize;
                        continue;
                    }
                    Some(_) => {
                        next[at] = tangents.len() as u32;
                        at = tangents.len();
                        order.push(order[*index as usize]);
                        tangents.push(Some(tangent));
                        next.push(NONE);
                    }
                }
                break;
            }
            *index = at as u32;
        }
    }
    pick_vertices(mesh, &order);
    mesh.tangents = Some(tangents.into_iter().map(|t| t.unwrap_or(Vec4::new(1.0, 0.0, 0.0, 1.0))).collect());
}

/// Rebuilds the vertex arrays from the old vertices in `order`.
fn pick_vertices(mesh: &mut Mesh, order: &[u32]) {
    fn pick<T: Copy>(from: &mut Vec<T>, order: &[u32]) {
        *from = order.iter().map(|&i| from[i as usize]).collect();
    }
    pick(&mut mesh.positions, order);
    if let Some(normals) = &mut mesh.normals {
        pick(normals, order);
    }
    for set in &mut mesh.uvs {
        pick(set, order);
    }
    if let Some(colors) = &mut mesh.colors {
        pick(colors, order);
    }
}
