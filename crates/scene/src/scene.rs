use crate::{Camera, Environment, Image, Instance, Light, Material, Mesh, Texture};

/// A scene: plain data.
///
/// [`crate::load`] returns a valid one: all indices are in range, all arrays as long as they must
/// be. [`Scene::validate`] checks one that was made otherwise.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Stem of the file it was loaded from, or the name that its maker chose.
    pub name: String,
    /// Meshes, one per glTF primitive, stored once however often they are placed.
    pub meshes: Vec<Mesh>,
    /// Placed meshes.
    pub instances: Vec<Instance>,
    /// The file's materials in use, then glTF's default material if a primitive needs it, then
    /// thin-walled copies of materials with a volume for meshes that are not closed.
    pub materials: Vec<Material>,
    /// Textures that materials refer to.
    pub textures: Vec<Texture>,
    /// Images that textures refer to.
    pub images: Vec<Image>,
    /// Cameras in node order.
    pub cameras: Vec<Camera>,
    /// Punctual lights.
    pub lights: Vec<Light>,
    /// Light from far away: the file's (EXT_lights_image_based), or set by the caller (`--env`,
    /// `--sky`).
    pub environment: Option<Environment>,
    /// Extensions that the file names and how they were handled.
    pub extensions: Vec<ExtensionUse>,
    /// Everything that was not read as written, one sentence each; shown once, at the end.
    pub warnings: Vec<String>,
}

/// An extension that the file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExtensionUse {
    /// For example `KHR_materials_ior`.
    pub name: String,
    /// In `extensionsRequired`.
    pub required: bool,
    /// Whether the picture follows it.
    pub honoured: bool,
}

impl Scene {
    /// Triangles as placed: every instance counted.
    pub fn triangle_count(&self) -> usize {
        self.instances.iter().map(|i| self.meshes[i.mesh].triangles.len()).sum()
    }

    /// Whether anything in the scene gives light.
    pub fn has_light(&self) -> bool {
        !self.lights.is_empty()
            || self.environment.is_some()
            || self.instances.iter().any(|i| self.materials[self.meshes[i.mesh].material].is_emissive())
    }
}
