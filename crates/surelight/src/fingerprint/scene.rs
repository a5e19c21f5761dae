//! The hash of a scene: the bits of its values, field by field, independent of `Debug` output.

use std::sync::Arc;

use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use surelight_scene::{
    AlphaMode, Anisotropy, Clearcoat, DiffuseTransmission, Environment, EnvironmentMap, Filter, Image, Instance,
    Iridescence, Light, LightKind, Material, Mesh, NormalTexture, Scene, Sheen, Texture, TextureRef, Volume, Wrap,
};

use super::Hash;

/// Hash of all visible content of a scene, as 16 hexadecimal digits. The same on every machine; not
/// for security.
pub(crate) fn of(scene: &Scene) -> String {
    let mut hash = Hash::new();
    scene.hash_into(&mut hash);
    hash.digits()
}

/// A value that a hash is made of.
trait HashInput {
    fn hash_into(&self, hash: &mut Hash);
}

/// Unsigned integers, and values with a fixed pattern of bits.
macro_rules! words {
    ($($type:ty: |$value:ident| $word:expr),+ $(,)?) => {$(
        impl HashInput for $type {
            fn hash_into(&self, hash: &mut Hash) {
                let $value = *self;
                hash.word($word);
            }
        }
    )+};
}

words! {
    bool: |x| x.into(),
    u32: |x| x.into(),
    usize: |x| x as u64,
    f32: |x| x.to_bits().into(),
    f64: |x| x.to_bits(),
    Wrap: |x| match x {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    },
    Filter: |x| match x {
        Filter::Linear => 0,
        Filter::Nearest => 1,
    },
}

/// Vectors and matrices, as arrays.
macro_rules! arrays {
    ($($type:ty: $array:ident),+ $(,)?) => {$(
        impl HashInput for $type {
            fn hash_into(&self, hash: &mut Hash) {
                self.$array().hash_into(hash);
            }
        }
    )+};
}

arrays! {
    Vec2: to_array,
    Vec3: to_array,
    Vec4: to_array,
    DVec3: to_array,
    Affine2: to_cols_array,
    DAffine3: to_cols_array,
}

/// Structures. The list names every field, or the pattern does not compile; `but` those that do not
/// show.
macro_rules! fields {
    ($($type:ty { $($field:ident),+ $(; but $($hidden:ident),+)? })+) => {$(
        impl HashInput for $type {
            fn hash_into(&self, hash: &mut Hash) {
                let Self { $($field,)+ $($($hidden: _,)+)? } = self;
                $($field.hash_into(hash);)+
            }
        }
    )+};
}

fields! {
    Scene {
        meshes, instances, materials, textures, images, lights, environment;
        but name, cameras, extensions, warnings
    }
    Mesh { positions, triangles, normals, tangents, uvs, colors, material; but name }
    Instance { mesh, to_world }
    Image { width, height, rgba; but name }
    Texture { image, wrap_s, wrap_t, filter }
    TextureRef { texture, uv_set, transform }
    NormalTexture { texture, scale }
    Material {
        name, base_color, base_color_texture, metallic, roughness, metallic_roughness_texture, normal_texture,
        emissive, emissive_texture, alpha_mode, double_sided, unlit, ior, specular, specular_texture,
        specular_color, specular_color_texture, transmission, transmission_texture, volume, dispersion, clearcoat,
        sheen, anisotropy, iridescence, diffuse_transmission
    }
    Volume { attenuation_distance, attenuation_color }
    Clearcoat { factor, texture, roughness, roughness_texture, normal_texture }
    Sheen { color, color_texture, roughness, roughness_texture }
    Anisotropy { strength, rotation, texture }
    Iridescence { factor, texture, ior, thickness_minimum, thickness_maximum, thickness_texture }
    DiffuseTransmission { factor, texture, color, color_texture }
    Light { name, kind, intensity }
    EnvironmentMap { width, height, texels }
}

impl HashInput for AlphaMode {
    fn hash_into(&self, hash: &mut Hash) {
        match self {
            Self::Opaque => hash.word(0),
            Self::Mask(cutoff) => {
                hash.word(1);
                cutoff.hash_into(hash);
            }
            Self::Blend => hash.word(2),
        }
    }
}

impl HashInput for LightKind {
    fn hash_into(&self, hash: &mut Hash) {
        match self {
            Self::Point { position } => {
                hash.word(0);
                position.hash_into(hash);
            }
            Self::Spot { position, direction, inner, outer } => {
                hash.word(1);
                [position, direction].hash_into(hash);
                [inner, outer].hash_into(hash);
            }
            Self::Directional { direction } => {
                hash.word(2);
                direction.hash_into(hash);
            }
        }
    }
}

impl HashInput for Environment {
    fn hash_into(&self, hash: &mut Hash) {
        match self {
            Self::Uniform(radiance) => {
                hash.word(0);
                radiance.hash_into(hash);
            }
            Self::Map { map, rotation, scale } => {
                hash.word(1);
                map.hash_into(hash);
                [rotation, scale].hash_into(hash);
            }
        }
    }
}

impl HashInput for String {
    fn hash_into(&self, hash: &mut Hash) {
        hash.bytes(self.as_bytes());
    }
}

/// Eight bytes at once: images are large.
impl HashInput for Vec<u8> {
    fn hash_into(&self, hash: &mut Hash) {
        hash.bytes(self);
    }
}

impl<T: HashInput> HashInput for &T {
    fn hash_into(&self, hash: &mut Hash) {
        (*self).hash_into(hash);
    }
}

impl<T: HashInput> HashInput for Arc<T> {
    fn hash_into(&self, hash: &mut Hash) {
        (**self).hash_into(hash);
    }
}

impl<T: HashInput> HashInput for Option<T> {
    fn hash_into(&self, hash: &mut Hash) {
        self.is_some().hash_into(hash);
        self.iter().for_each(|value| value.hash_into(hash));
    }
}

impl<T: HashInput, const N: usize> HashInput for [T; N] {
    fn hash_into(&self, hash: &mut Hash) {
        self.iter().for_each(|value| value.hash_into(hash));
    }
}

impl<T: HashInput> HashInput for Vec<T> {
    fn hash_into(&self, hash: &mut Hash) {
        hash.word(self.len() as u64);
        self.iter().for_each(|value| value.hash_into(hash));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene() -> Scene {
        let image = Image { name: "a".into(), width: 1, height: 1, rgba: vec![0; 4] };
        let light = Light {
            name: String::new(),
            kind: LightKind::Directional { direction: DVec3::NEG_Y },
            intensity: [0.1, 2.0, 3.0],
        };
        Scene {
            meshes: vec![Mesh { positions: vec![[0.0; 3].into()], ..Mesh::default() }],
            instances: vec![Instance { mesh: 0, to_world: DAffine3::IDENTITY }],
            materials: vec![Material::default()],
            images: vec![image],
            lights: vec![light],
            ..Scene::default()
        }
    }

    #[test]
    fn every_kind_of_change_shows() {
        type Change = fn(&mut Scene);
        let changes: [Change; 12] = [
            |scene| scene.meshes[0].positions[0].y = 1e-30,
            |scene| scene.meshes[0].positions.clear(),
            |scene| scene.meshes[0].normals = Some(vec![]),
            |scene| scene.instances[0].to_world.translation.x = 1e-30,
            |scene| scene.materials[0].roughness = 0.5,
            |scene| scene.materials[0].alpha_mode = AlphaMode::Mask(0.5),
            |scene| {
                scene.materials[0].volume =
                    Some(Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] });
            },
            |scene| scene.images[0].rgba[3] = 1,
            |scene| scene.lights[0].kind = LightKind::Point { position: DVec3::NEG_Y },
            |scene| scene.lights[0].intensity[0] = 0.2,
            |scene| scene.environment = Some(Environment::Uniform([0.0; 3])),
            |scene| {
                let map = EnvironmentMap { width: 1, height: 1, texels: vec![[0.0; 3]] };
                scene.environment = Some(Environment::Map { map: map.into(), rotation: 0.0, scale: 1.0 });
            },
        ];
        let mut hashes = vec![of(&scene())];
        for change in changes {
            let mut changed = scene();
            change(&mut changed);
            hashes.push(of(&changed));
        }
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), 1 + changes.len());
    }

    /// Files hold it: a change makes every checkpoint and part one of another scene.
    #[test]
    fn the_hash_does_not_change_between_versions() {
        assert_eq!(of(&scene()), "e3a4864d7a2aafe7");
    }
}
