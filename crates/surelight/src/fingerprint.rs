//! A hash of a scene as loaded: renders of one scene can be told from those of another.

use std::fmt::Debug;

use surelight_scene::{Environment, Scene};
use xxhash_rust::xxh3::Xxh3;

/// Hash of everything in a scene that shows, as 16 hexadecimal digits. The same on every machine; not for security.
pub(crate) fn of(scene: &Scene) -> String {
    let mut hash = Hash(Xxh3::new());
    for mesh in &scene.meshes {
        mesh.positions.iter().for_each(|p| hash.floats(&p.to_array()));
        mesh.triangles.iter().for_each(|t| t.iter().for_each(|&i| hash.word(i.into())));
        mesh.normals.iter().flatten().for_each(|n| hash.floats(&n.to_array()));
        mesh.tangents.iter().flatten().for_each(|t| hash.floats(&t.to_array()));
        mesh.uvs.iter().flatten().for_each(|uv| hash.floats(&uv.to_array()));
        mesh.colors.iter().flatten().for_each(|c| hash.floats(&c.to_array()));
        hash.word(mesh.material as u64);
        hash.word(mesh.uvs.len() as u64);
    }
    scene.images.iter().for_each(|image| hash.bytes(&image.rgba));
    // Small things by what they say of themselves: nothing in them can be forgotten.
    scene.instances.iter().for_each(|instance| hash.text(instance));
    scene.materials.iter().for_each(|material| hash.text(material));
    scene.textures.iter().for_each(|texture| hash.text(texture));
    scene.lights.iter().for_each(|light| hash.text(light));
    match &scene.environment {
        Some(Environment::Map { map, rotation, scale }) => {
            map.texels.iter().for_each(|texel| hash.floats(texel));
            hash.text(&(map.width, map.height, rotation, scale));
        }
        other => hash.text(other),
    }
    format!("{:016x}", hash.0.digest())
}

/// Hash of a text, likewise.
pub(crate) fn of_text(text: &str) -> String {
    of_bytes(text.as_bytes())
}

/// Hash of bytes, likewise.
pub(crate) fn of_bytes(bytes: &[u8]) -> String {
    let mut hash = Hash(Xxh3::new());
    hash.bytes(bytes);
    format!("{:016x}", hash.0.digest())
}

/// XXH3 over little-endian words and bytes.
struct Hash(Xxh3);

impl Hash {
    fn word(&mut self, word: u64) {
        self.0.update(&word.to_le_bytes());
    }

    fn floats(&mut self, floats: &[f32]) {
        floats.iter().for_each(|x| self.word(x.to_bits().into()));
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
        self.word(bytes.len() as u64);
    }

    fn text(&mut self, thing: &impl Debug) {
        self.bytes(format!("{thing:?}").as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use surelight_scene::{Image, Material, Mesh};

    use super::*;

    #[test]
    fn every_kind_of_change_shows() {
        let image = Image { name: "a".into(), width: 1, height: 1, rgba: vec![0; 4] };
        let scene = Scene {
            meshes: vec![Mesh { positions: vec![[0.0; 3].into()], ..Mesh::default() }],
            materials: vec![Material::default()],
            images: vec![image],
            ..Scene::default()
        };
        let changes: [fn(&mut Scene); 5] = [
            |scene| scene.meshes[0].positions[0].y = 1e-30,
            |scene| scene.materials[0].roughness = 0.5,
            |scene| scene.images[0].rgba[3] = 1,
            |scene| scene.environment = Some(Environment::Uniform([0.0; 3])),
            |scene| scene.meshes[0].positions.clear(),
        ];
        let mut hashes = vec![of(&scene)];
        for change in changes {
            let mut changed = scene.clone();
            change(&mut changed);
            hashes.push(of(&changed));
        }
        hashes.sort();
        hashes.dedup();
        assert_eq!(hashes.len(), 6);
    }
}
