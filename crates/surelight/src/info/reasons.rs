//! What in a scene asks for a part of the kernel.

use surelight_scene::{AlphaMode, ClipRange, LightKind, Material, Mesh, Scene};

/// What asks for the feature of this name; `None` where it is no single thing of the file.
pub(super) fn find(feature: &str, scene: &Scene) -> Option<String> {
    let materials = |wants: fn(&Material) -> bool| {
        let all = scene.materials.iter().enumerate();
        named("material", all.filter(|(_, m)| wants(m)).map(|(i, m)| (i, m.name.as_str())))
    };
    let meshes = |wants: fn(&Mesh) -> bool| {
        let all = scene.meshes.iter().enumerate();
        named("mesh", all.filter(|(_, m)| wants(m)).map(|(i, m)| (i, m.name.as_str())))
    };
    match feature {
        "vertex_normals" => meshes(|m| m.normals.is_some()),
        "vertex_colors" => meshes(|m| m.colors.is_some()),
        "tangents" => meshes(|m| m.tangents.is_some()),
        "base_color_texture" => materials(|m| m.base_color_texture.is_some()),
        "metallic_roughness_texture" => materials(|m| m.metallic_roughness_texture.is_some()),
        "normal_texture" => materials(|m| m.normal_texture.is_some()),
        "emissive_texture" => materials(|m| m.emissive_texture.is_some()),
        "specular_texture" => materials(|m| m.specular_texture.is_some()),
        "specular_color_texture" => materials(|m| m.specular_color_texture.is_some()),
        "transmission_texture" => materials(|m| m.transmission_texture.is_some()),
        "alpha" => materials(|m| m.alpha_mode != AlphaMode::Opaque),
        "metal" => materials(|m| m.metallic > 0.0),
        "clearcoat_texture" => materials(|m| m.clearcoat.texture.is_some()),
        "clearcoat_roughness_texture" => materials(|m| m.clearcoat.roughness_texture.is_some()),
        "clearcoat_normal_texture" => materials(|m| m.clearcoat.normal_texture.is_some()),
        "sheen_color_texture" => materials(|m| m.sheen.color_texture.is_some()),
        "sheen_roughness_texture" => materials(|m| m.sheen.roughness_texture.is_some()),
        "anisotropy_texture" => materials(|m| m.anisotropy.texture.is_some()),
        "iridescence_texture" => materials(|m| m.iridescence.texture.is_some()),
        "iridescence_thickness_texture" => materials(|m| m.iridescence.thickness_texture.is_some()),
        "diffuse_transmission_texture" => materials(|m| m.diffuse_transmission.texture.is_some()),
        "diffuse_transmission_color_texture" => materials(|m| m.diffuse_transmission.color_texture.is_some()),
        "transmission" => materials(|m| m.transmission > 0.0 || m.diffuse_transmission.factor > 0.0),
        "diffuse_transmission" => materials(|m| m.diffuse_transmission.factor > 0.0),
        "dispersion" => materials(|m| m.dispersion > 0.0 && m.volume.is_some()),
        "anisotropy" => materials(|m| m.anisotropy.strength > 0.0),
        "iridescence" => materials(|m| m.iridescence.factor > 0.0),
        "sheen" => materials(|m| m.sheen.color.iter().any(|&c| c > 0.0)),
        "clearcoat" => materials(|m| m.clearcoat.factor > 0.0),
        "volume_alpha" => materials(|m| m.volume.is_some() && m.alpha_mode != AlphaMode::Opaque),
        "panes" => materials(|m| m.transmission > 0.0 && m.volume.is_none()),
        "volume" => materials(|m| m.volume.is_some()),
        "nested" => materials(|m| m.volume.is_some() && (m.transmission > 0.0 || m.diffuse_transmission.factor > 0.0)),
        "unlit" => materials(|m| m.unlit),
        "emission" | "area_lights" => materials(Material::is_emissive),
        "instances" => {
            let mut placed = vec![0usize; scene.meshes.len()];
            scene.instances.iter().for_each(|instance| placed[instance.mesh] += 1);
            let all = scene.meshes.iter().enumerate();
            named("mesh", all.filter(|&(i, _)| placed[i] > 1).map(|(i, mesh)| (i, mesh.name.as_str())))
        }
        "punctual_lights" => {
            let kinds = scene.lights.iter().map(|light| match light.kind {
                LightKind::Point { .. } => "point",
                LightKind::Spot { .. } => "spot",
                LightKind::Directional { .. } => "directional",
            });
            named("light", kinds.enumerate())
        }
        "camera_clip" => {
            let all = scene.cameras.iter().enumerate();
            named("camera", all.filter(|(_, c)| c.clip != ClipRange::NONE).map(|(i, c)| (i, c.name.as_str())))
        }
        "textures" => Some(format!("{} textures", scene.textures.len())).filter(|_| !scene.textures.is_empty()),
        _ => None,
    }
}

/// "material "Glass"" or "3 materials, the first "Glass""; `None` for none. What has no name is told by its number.
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
    fn the_cause_is_named() {
        let glass = Material { name: "Glass".into(), transmission: 1.0, metallic: 0.0, ..Material::default() };
        let steel = Material { name: "Steel".into(), ..Material::default() };
        let scene = Scene { materials: vec![steel.clone(), glass, steel], ..Scene::default() };
        assert_eq!(find("transmission", &scene).as_deref(), Some("material \"Glass\""));
        assert_eq!(find("metal", &scene).as_deref(), Some("2 materials, the first \"Steel\""));
        assert_eq!(find("volume", &scene), None);
        let nameless = Scene { materials: vec![Material { unlit: true, ..Material::default() }], ..Scene::default() };
        assert_eq!(find("unlit", &nameless).as_deref(), Some("material 0"));
    }
}
