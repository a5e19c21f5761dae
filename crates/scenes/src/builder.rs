//! Puts a [`Scene`] together from shapes, with the materials that the procedural scenes share.

use glam::{DAffine3, DMat3, DVec3};
use surelight_scene::{
    AlphaMode, Camera, ClipRange, Filter, Image, Instance, Material, Projection, Scene, Texture, TextureRef, Volume,
    Wrap,
};

use crate::shapes::Shape;

/// A scene under construction.
pub(crate) struct Builder {
    scene: Scene,
}

impl Builder {
    pub(crate) fn new(name: &str) -> Self {
        Self { scene: Scene { name: name.to_owned(), ..Scene::default() } }
    }

    pub(crate) fn material(&mut self, material: Material) -> usize {
        self.scene.materials.push(material);
        self.scene.materials.len() - 1
    }

    /// A mesh placed by the identity; texture coordinates are kept when the material uses them.
    pub(crate) fn add(&mut self, name: &str, shape: Shape, material: usize) {
        let mesh = self.mesh(name, shape, material);
        self.place(mesh, DAffine3::IDENTITY);
    }

    /// A mesh to be placed later.
    pub(crate) fn mesh(&mut self, name: &str, shape: Shape, material: usize) -> usize {
        let used = &self.scene.materials[material];
        let textured = used.base_color_texture.is_some()
            || used.metallic_roughness_texture.is_some()
            || used.normal_texture.is_some()
            || used.emissive_texture.is_some();
        let tangents = used.normal_texture.is_some() || used.anisotropy.strength > 0.0;
        let shape = if textured || tangents { shape } else { shape.bare() };
        self.scene.meshes.push(shape.into_mesh(name, material, tangents));
        self.scene.meshes.len() - 1
    }

    pub(crate) fn place(&mut self, mesh: usize, to_world: DAffine3) {
        self.scene.instances.push(Instance { mesh, to_world });
    }

    /// A repeating texture.
    pub(crate) fn texture(&mut self, image: Image, filter: Filter) -> TextureRef {
        self.scene.images.push(image);
        self.scene.textures.push(Texture {
            image: self.scene.images.len() - 1,
            wrap_s: Wrap::Repeat,
            wrap_t: Wrap::Repeat,
            filter,
        });
        TextureRef { texture: self.scene.textures.len() - 1, uv_set: 0, transform: None }
    }

    /// A pinhole camera at `eye` towards `target`; `yfov` is the full vertical angle in degrees.
    pub(crate) fn camera(&mut self, eye: DVec3, target: DVec3, yfov: f64, aspect: f64) {
        self.scene.cameras.push(Camera {
            name: "camera".to_owned(),
            to_world: look_at(eye, target),
            projection: Projection::Perspective { yfov: yfov.to_radians(), aspect: Some(aspect) },
            clip: ClipRange::NONE,
        });
    }

    pub(crate) fn finish(self) -> Scene {
        self.scene
    }
}

/// Camera to world, +Y up; the view must not be vertical.
pub(crate) fn look_at(eye: DVec3, target: DVec3) -> DAffine3 {
    let z = (eye - target).normalize();
    let x = DVec3::Y.cross(z).normalize();
    DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), eye)
}

/// Lambert's ρ/π alone: a dielectric whose reflection is switched off.
pub(crate) fn lambert(name: &str, reflectance: [f32; 3]) -> Material {
    let [r, g, b] = reflectance;
    Material {
        name: name.to_owned(),
        base_color: [r, g, b, 1.0],
        metallic: 0.0,
        specular: 0.0,
        double_sided: true,
        ..Material::default()
    }
}

/// Black, and shining from its front alone.
pub(crate) fn emitter(name: &str, radiance: [f32; 3]) -> Material {
    Material { emissive: radiance, double_sided: false, ..lambert(name, [0.0; 3]) }
}

/// A conductor with GGX α.
pub(crate) fn metal(name: &str, f0: [f32; 3], alpha: f64) -> Material {
    let [r, g, b] = f0;
    Material {
        name: name.to_owned(),
        base_color: [r, g, b, 1.0],
        metallic: 1.0,
        roughness: alpha.sqrt() as f32,
        double_sided: true,
        ..Material::default()
    }
}

/// A smooth clear dielectric that fills its closed mesh.
pub(crate) fn glass(name: &str, ior: f32, volume: Volume) -> Material {
    Material {
        name: name.to_owned(),
        metallic: 0.0,
        roughness: 0.0,
        transmission: 1.0,
        ior,
        volume: Some(volume),
        alpha_mode: AlphaMode::Opaque,
        ..Material::default()
    }
}
