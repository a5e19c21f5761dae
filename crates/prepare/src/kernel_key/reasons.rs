//! The elements of a scene that need a part of the kernel, in words: `material "Glass"`.

use surelight_scene::{ClipRange, LightKind, Material, Mesh, Scene};

/// The materials that satisfy a condition.
pub(super) fn materials(scene: &Scene, wants: fn(&Material) -> bool) -> Option<String> {
    let all = scene.materials.iter().enumerate();
    named("material", all.filter(|(_, m)| wants(m)).map(|(i, m)| (i, m.name.as_str())))
}

/// The meshes that satisfy a condition.
pub(super) fn meshes(scene: &Scene, wants: fn(&Mesh) -> bool) -> Option<String> {
    let all = scene.meshes.iter().enumerate();
    named("mesh", all.filter(|(_, m)| wants(m)).map(|(i, m)| (i, m.name.as_str())))
}

/// The meshes that are placed more than once.
pub(super) fn instances(scene: &Scene) -> Option<String> {
    let mut placed = vec![0usize; scene.meshes.len()];
    scene.instances.iter().for_each(|instance| placed[instance.mesh] += 1);
    let all = scene.meshes.iter().enumerate();
    named("mesh", all.filter(|&(i, _)| placed[i] > 1).map(|(i, mesh)| (i, mesh.name.as_str())))
}

/// The lights without extent.
pub(super) fn punctual_lights(scene: &Scene) -> Option<String> {
    let kinds = scene.lights.iter().map(|light| match light.kind {
        LightKind::Point { .. } => "point",
        LightKind::Spot { .. } => "spot",
        LightKind::Directional { .. } => "directional",
    });
    named("light", kinds.enumerate())
}

/// The cameras with a near or a far plane.
pub(super) fn clipping_cameras(scene: &Scene) -> Option<String> {
    let all = scene.cameras.iter().enumerate();
    named("camera", all.filter(|(_, c)| c.clip != ClipRange::NONE).map(|(i, c)| (i, c.name.as_str())))
}

/// The number of textures.
pub(super) fn textures(scene: &Scene) -> Option<String> {
    Some(format!("{} textures", scene.textures.len())).filter(|_| !scene.textures.is_empty())
}

/// `material "Glass"` or `3 materials, the first "Glass"`; `None` for none. A number replaces an
/// empty name.
fn named<'a>(kind: &str, all: impl Iterator<Item = (usize, &'a str)>) -> Option<String> {
    let mut all = all.peekable();
    let &(index, name) = all.peek()?;
    let first = if name.is_empty() { format!("{index}") } else { format!("\"{name}\"") };
    let plural = if kind == "mesh" { "meshes".to_owned() } else { format!("{kind}s") };
    Some(match all.count() {
        1 => format!("{kind} {first}"),
        count => format!("{count} {plural}, the first {first}"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_is_named() {
        let glass = Material { name: "Glass".into(), transmission: 1.0, metallic: 0.0, ..Material::default() };
        let steel = Material { name: "Steel".into(), ..Material::default() };
        let scene = Scene { materials: vec![steel.clone(), glass, steel], ..Scene::default() };
        assert_eq!(materials(&scene, |m| m.transmission > 0.0).as_deref(), Some("material \"Glass\""));
        assert_eq!(materials(&scene, |m| m.metallic > 0.0).as_deref(), Some("2 materials, the first \"Steel\""));
        assert_eq!(materials(&scene, |m| m.volume.is_some()), None);
        let nameless = Scene { materials: vec![Material { unlit: true, ..Material::default() }], ..Scene::default() };
        assert_eq!(materials(&nameless, |m| m.unlit).as_deref(), Some("material 0"));
    }
}
