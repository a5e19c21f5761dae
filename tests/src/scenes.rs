//! Scenes for the tests, beside those of `surelight_scenes`.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec4};
use surelight_scene::{
    AlphaMode, Anisotropy, Camera, Clearcoat, ClipRange, DiffuseTransmission, Environment, EnvironmentMap, Filter,
    Image, Instance, Iridescence, Light, LightKind, Material, Mesh, NormalTexture, Projection, Scene, Sheen, Texture,
    TextureRef, Volume, Wrap,
};
use surelight_scenes::{furnace, probes, shapes::Shape};

/// Procedural scenes that are made for tests.
pub fn probes() -> Vec<Scene> {
    vec![
        furnace::bare_room(),
        probes::convex_furnace([0.8, 0.4, 0.2], 2),
        probes::two_triangles(),
        probes::slab(1.5, 1.0, 0.5),
        probes::mirror_corridor(3, [0.9, 0.8, 0.7]),
        probes::soup(100, 1),
        probes::terrain(4),
    ]
}

/// Lambert's ρ/π alone.
pub fn lambert(reflectance: [f32; 3]) -> Material {
    let [r, g, b] = reflectance;
    Material { base_color: [r, g, b, 1.0], metallic: 0.0, specular: 0.0, double_sided: true, ..Material::default() }
}

/// Black, shining from the front.
pub fn emitter(radiance: [f32; 3]) -> Material {
    Material { emissive: radiance, double_sided: false, ..lambert([0.0; 3]) }
}

/// Adds a shape with its own material, placed by the identity.
pub fn add(scene: &mut Scene, shape: Shape, material: Material) {
    scene.materials.push(material);
    scene.meshes.push(shape.bare().into_mesh("", scene.materials.len() - 1, false));
    scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world: DAffine3::IDENTITY });
}

/// Camera to world: from `eye` towards `target`, `up` upwards.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> DAffine3 {
    let z = (eye - target).normalize();
    let x = up.cross(z).normalize();
    DAffine3::from_mat3_translation(DMat3::from_cols(x, z.cross(x), z), eye)
}

/// Parallel rays over a square of half-width `half`.
pub fn orthographic(to_world: DAffine3, half: f64) -> Camera {
    let projection = Projection::Orthographic { xmag: half, ymag: half };
    Camera { name: String::new(), to_world, projection, clip: ClipRange::NONE }
}

/// A pinhole with a square picture; `yfov` in degrees.
pub fn pinhole(to_world: DAffine3, yfov: f64) -> Camera {
    let projection = Projection::Perspective { yfov: yfov.to_radians(), aspect: Some(1.0) };
    Camera { name: String::new(), to_world, projection, clip: ClipRange::NONE }
}

/// The scene with one more object that needs every feature that a kernel can have, and lights of
/// every kind.
///
/// The object is a millimetre large and far above the camera's view; its lights are 1e-12 of the
/// scene's. The picture is the same; its kernel is the general one. Projection and settings (lens,
/// clamp) are left to the caller.
pub fn with_everything(mut scene: Scene) -> Scene {
    let bounds = scene.bounds().expect("the scene has triangles");
    let size = (bounds.1 - bounds.0).length();
    let at = (bounds.0 + bounds.1) * 0.5 + DVec3::new(0.31, 2.0, 0.17) * size;
    let first_texture = scene.textures.len();
    add_textures(&mut scene);
    let texture =
        |k: usize| Some(TextureRef { texture: first_texture + k % 3, uv_set: (k % 2) as u32, transform: None });
    let general = Material {
        name: "everything".into(),
        base_color: [0.5, 0.6, 0.7, 0.8],
        base_color_texture: texture(0),
        metallic: 0.5,
        roughness: 0.5,
        metallic_roughness_texture: texture(1),
        normal_texture: texture(2).map(|texture| NormalTexture { texture, scale: 0.5 }),
        emissive: [1e-12; 3],
        emissive_texture: texture(3),
        alpha_mode: AlphaMode::Blend,
        specular: 0.9,
        specular_texture: texture(4),
        specular_color: [0.9, 0.8, 0.7],
        specular_color_texture: texture(5),
        transmission: 0.5,
        transmission_texture: texture(6),
        volume: Some(Volume { attenuation_distance: 1.0, attenuation_color: [0.5; 3] }),
        dispersion: 0.5,
        clearcoat: Clearcoat {
            factor: 0.5,
            texture: texture(7),
            roughness: 0.3,
            roughness_texture: texture(8),
            normal_texture: texture(9).map(|texture| NormalTexture { texture, scale: 0.25 }),
        },
        sheen: Sheen {
            color: [0.3, 0.2, 0.1],
            color_texture: texture(10),
            roughness: 0.5,
            roughness_texture: texture(11),
        },
        anisotropy: Anisotropy { strength: 0.5, rotation: 1.0, texture: texture(12) },
        iridescence: Iridescence {
            factor: 0.5,
            texture: texture(13),
            thickness_texture: texture(14),
            ..Iridescence::default()
        },
        diffuse_transmission: DiffuseTransmission {
            factor: 0.5,
            texture: texture(15),
            color: [0.9, 0.5, 0.2],
            color_texture: texture(16),
        },
        ..Material::default()
    };
    scene.materials.push(general);
    let general = scene.materials.len() - 1;
    scene.materials.push(Material { unlit: true, base_color: [0.0, 0.0, 0.0, 1.0], ..Material::default() });
    let mut mesh: Mesh = Shape::uv_sphere(48, 48).into_mesh("everything", general, true);
    mesh.uvs.push(mesh.uvs[0].iter().map(|uv| Vec2::new(uv.y, uv.x)).collect());
    mesh.colors = Some(vec![Vec4::new(0.9, 0.8, 0.7, 0.9); mesh.positions.len()]);
    scene.meshes.push(mesh);
    let sphere = scene.meshes.len() - 1;
    for k in 0..2 {
        let matrix3 = DMat3::from_diagonal(DVec3::new(1.0, -0.5, 0.7) * 1e-3 * size);
        // They overlap, as volumes may.
        let translation = at + DVec3::X * f64::from(k) * 1.5e-3 * size;
        scene.instances.push(Instance { mesh: sphere, to_world: DAffine3 { matrix3, translation } });
    }
    // Instances begin where copies would have a million triangles.
    let crowd = Shape::uv_sphere(8, 12).into_mesh("crowd", general + 1, true);
    let count = (1 << 20) / crowd.triangles.len() + 1;
    scene.meshes.push(crowd);
    for k in 0..count {
        let translation = at + DVec3::new((k % 100) as f64, 200.0, (k / 100) as f64) * 1e-4 * size;
        let to_world = DAffine3 { matrix3: DMat3::from_diagonal(DVec3::splat(3e-5 * size)), translation };
        scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world });
    }
    let card = Shape::parallelogram(at + DVec3::Y * 5e-3 * size, DVec3::X * 1e-4 * size, DVec3::Z * 1e-4 * size);
    scene.meshes.push(card.bare().into_mesh("unlit", general + 1, false));
    scene.instances.push(Instance { mesh: scene.meshes.len() - 1, to_world: DAffine3::IDENTITY });
    let pane = Material { metallic: 0.0, roughness: 0.0, transmission: 1.0, ..Material::default() };
    let sheet = Shape::parallelogram(at + DVec3::Y * 8e-3 * size, DVec3::X * 1e-4 * size, DVec3::Z * 1e-4 * size);
    add(&mut scene, sheet, pane);
    let light = |kind| Light { name: String::new(), kind, intensity: [1e-12; 3] };
    scene.lights.extend([
        light(LightKind::Point { position: at }),
        light(LightKind::Spot { position: at, direction: DVec3::Y, inner: 0.1, outer: 0.2 }),
        light(LightKind::Directional { direction: DVec3::NEG_Y }),
    ]);
    scene.environment = Some(match scene.environment.take() {
        Some(Environment::Uniform(radiance)) => map(8, 4, |_, _| radiance),
        Some(map) => map,
        None => map(8, 4, |_, _| [1e-12; 3]),
    });
    scene
}

/// A map by its texels, as column and row, not turned.
pub fn map(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Environment {
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    Environment::Map { map: Arc::new(EnvironmentMap { width, height, texels }), rotation: 0.0, scale: 1.0 }
}

/// Three textures, one of each way to wrap.
fn add_textures(scene: &mut Scene) {
    let rgba = (0..16u8).flat_map(|i| [200 + i, 150 + 2 * i, 240, 255 - i]).collect();
    scene.images.push(Image { name: "everything".into(), width: 4, height: 4, rgba });
    let image = scene.images.len() - 1;
    for (wrap, filter) in
        [(Wrap::Repeat, Filter::Linear), (Wrap::MirroredRepeat, Filter::Nearest), (Wrap::ClampToEdge, Filter::Linear)]
    {
        scene.textures.push(Texture { image, wrap_s: wrap, wrap_t: wrap, filter });
    }
}
