//! Checks the invariants of a scene, before anything relies on them.

use rayon::prelude::*;

use crate::{Environment, LightKind, Mesh, Scene, TextureRef};

/// Why a scene is not valid: the place that is wrong, and how.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// An index beyond the end of the array that it refers to.
    #[error("the scene is not valid: {place}: index {index} of {count} {target}")]
    Index {
        /// The owner of the index, for example `mesh 3, triangle 7, corner 2`.
        place: String,
        /// The index.
        index: usize,
        /// The kind of its target, for example `vertices`.
        target: &'static str,
        /// How many of these there are.
        count: usize,
    },
    /// An array that is shorter or longer than another one says.
    #[error("the scene is not valid: {place}: {found} elements where {expected} are needed")]
    Length {
        /// The array, for example `mesh 3, normals`.
        place: String,
        /// Its length.
        found: usize,
        /// The length that it must have.
        expected: usize,
    },
    /// An image or a map without texels.
    #[error("the scene is not valid: {place}: no texels")]
    Empty {
        /// Which.
        place: String,
    },
    /// A transform, a position or a direction that is NaN or infinite.
    #[error("the scene is not valid: {place}: not finite")]
    NotFinite {
        /// Which, for example `instance 3, transform`.
        place: String,
    },
}

/// Triangles per work item of a thread.
const CHUNK: usize = 1 << 14;

impl Scene {
    /// Whether all indices are in range, all arrays as long as they must be, and all transforms
    /// finite.
    ///
    /// This holds for every scene that [`crate::load`] returns. It takes one pass over the
    /// triangles.
    ///
    /// # Errors
    /// Names the first place that is wrong.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (i, instance) in self.instances.iter().enumerate() {
            check_index(instance.mesh, self.meshes.len(), "meshes", || format!("instance {i}"))?;
            check_finite(instance.to_world.is_finite(), || format!("instance {i}, transform"))?;
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            check_index(mesh.material, self.materials.len(), "materials", || format!("mesh {i}"))?;
            check_mesh(i, mesh)?;
        }
        self.check_textures()?;
        for (i, light) in self.lights.iter().enumerate() {
            let finite = match light.kind {
                LightKind::Point { position } => position.is_finite(),
                LightKind::Spot { position, direction, .. } => position.is_finite() && direction.is_finite(),
                LightKind::Directional { direction } => direction.is_finite(),
            };
            check_finite(finite, || format!("light {i}, position and direction"))?;
        }
        for (i, camera) in self.cameras.iter().enumerate() {
            check_finite(camera.to_world.is_finite(), || format!("camera {i}, transform"))?;
        }
        match &self.environment {
            Some(Environment::Map { map, .. }) => {
                check_texels(map.texels.len(), [map.width, map.height], 1, || "environment map".into())
            }
            Some(Environment::Uniform(_)) | None => Ok(()),
        }
    }

    fn check_textures(&self) -> Result<(), SceneError> {
        // A mesh without one of the UV sets has zeros in their place, but some mesh must have it.
        let uv_sets = self.meshes.iter().map(|mesh| mesh.uvs.len()).max().unwrap_or(0).max(1);
        let mut used = vec![false; self.materials.len()];
        self.meshes.iter().for_each(|mesh| used[mesh.material] = true);
        for (i, (material, used)) in self.materials.iter().zip(used).enumerate() {
            for (name, reference) in material.textures() {
                let Some(TextureRef { texture, uv_set, transform }) = reference else { continue };
                let place = || format!("material {i}, {name} texture");
                check_index(*texture, self.textures.len(), "textures", place)?;
                if used {
                    check_index(*uv_set as usize, uv_sets, "UV sets", place)?;
                }
                check_finite(transform.is_none_or(|t| t.is_finite()), || format!("{}, transform", place()))?;
            }
        }
        for (i, texture) in self.textures.iter().enumerate() {
            check_index(texture.image, self.images.len(), "images", || format!("texture {i}"))?;
        }
        for (i, image) in self.images.iter().enumerate() {
            check_texels(image.rgba.len(), [image.width, image.height], 4, || format!("image {i}"))?;
        }
        Ok(())
    }
}

fn check_mesh(i: usize, mesh: &Mesh) -> Result<(), SceneError> {
    let vertices = mesh.positions.len();
    let check_length = |found: Option<usize>, name: &str| match found {
        Some(found) if found != vertices => {
            Err(SceneError::Length { place: format!("mesh {i}, {name}"), found, expected: vertices })
        }
        _ => Ok(()),
    };
    check_length(mesh.normals.as_ref().map(Vec::len), "normals")?;
    check_length(mesh.tangents.as_ref().map(Vec::len), "tangents")?;
    check_length(mesh.colors.as_ref().map(Vec::len), "colors")?;
    for (k, uvs) in mesh.uvs.iter().enumerate() {
        check_length(Some(uvs.len()), &format!("UV set {k}"))?;
    }
    // The largest index is found several times faster than a triangle that holds it, and mostly
    // decides.
    let largest = |chunk: &[[u32; 3]]| chunk.as_flattened().iter().copied().fold(0, u32::max);
    let largest = mesh.triangles.par_chunks(CHUNK).map(largest).max();
    if largest.is_none_or(|index| (index as usize) < vertices) {
        return Ok(());
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        for (corner, &index) in corners.iter().enumerate() {
            let place = || format!("mesh {i}, triangle {triangle}, corner {corner}");
            check_index(index as usize, vertices, "vertices", place)?;
        }
    }
    Ok(())
}

fn check_index(
    index: usize,
    count: usize,
    target: &'static str,
    place: impl FnOnce() -> String,
) -> Result<(), SceneError> {
    if index < count { Ok(()) } else { Err(SceneError::Index { place: place(), index, target, count }) }
}

fn check_finite(finite: bool, place: impl FnOnce() -> String) -> Result<(), SceneError> {
    if finite { Ok(()) } else { Err(SceneError::NotFinite { place: place() }) }
}

fn check_texels(
    found: usize,
    [width, height]: [u32; 2],
    elements_per_texel: usize,
    place: impl FnOnce() -> String,
) -> Result<(), SceneError> {
    let expected = (width as usize).saturating_mul(height as usize).saturating_mul(elements_per_texel);
    if expected == 0 {
        Err(SceneError::Empty { place: place() })
    } else if found != expected {
        Err(SceneError::Length { place: place(), found, expected })
    } else {
        Ok(())
    }
}
