//! Scenes that the encoder writes and the importer reads back.

use std::path::Path;

use glam::{Affine2, DQuat, DVec3, Mat2, Vec2, Vec3, Vec4};
use surelight_scene::{
    AlphaMode, Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, LoadOptions, Material, NormalTexture, Sheen,
    TextureRef, Volume, load_bytes,
};

use super::*;
use crate::{GALLERY, probes};

fn back(scene: &Scene) -> Scene {
    let file = encode(scene, "a note").unwrap();
    load_bytes(&file, Path::new("scene.glb"), &LoadOptions::default()).unwrap()
}

/// Matrices go through f32.
fn near(a: &DAffine3, b: &DAffine3) -> bool {
    let scale = a.translation.abs().max_element().max(1.0);
    a.abs_diff_eq(*b, 1e-6 * scale)
}

fn assert_same(read: &Scene, written: &Scene) {
    let name = &written.name;
    assert_eq!(read.warnings, Vec::<String>::new(), "{name}");
    assert_eq!(read.meshes.len(), written.meshes.len(), "{name}");
    for (a, b) in read.meshes.iter().zip(&written.meshes) {
        assert_eq!(a, b, "{name}: mesh {}", b.name);
    }
    assert_eq!(read.materials, written.materials, "{name}");
    assert_eq!(read.textures, written.textures, "{name}");
    assert_eq!(read.instances.len(), written.instances.len(), "{name}");
    for (a, b) in read.instances.iter().zip(&written.instances) {
        assert_eq!(a.mesh, b.mesh, "{name}");
        assert!(near(&a.to_world, &b.to_world), "{name}: {a:?} instead of {b:?}");
    }
    assert_eq!(read.images.len(), written.images.len(), "{name}");
    for (a, b) in read.images.iter().zip(&written.images) {
        assert_eq!((a.width, a.height, &a.rgba), (b.width, b.height, &b.rgba), "{name}");
    }
    assert_eq!(read.cameras.len(), written.cameras.len(), "{name}");
    for (a, b) in read.cameras.iter().zip(&written.cameras) {
        assert_eq!(a.name, b.name, "{name}");
        assert!(near(&a.to_world, &b.to_world), "{name}");
        match (a.projection, b.projection) {
            (Projection::Perspective { yfov: f, aspect: r }, Projection::Perspective { yfov: g, aspect: s }) => {
                assert!((f - g).abs() < 1e-6 && r.zip(s).is_none_or(|(r, s)| (r - s).abs() < 1e-6))
            }
            (Projection::Orthographic { xmag: x, ymag: y }, Projection::Orthographic { xmag: v, ymag: w }) => {
                assert!((x - v).abs() < 1e-6 && (y - w).abs() < 1e-6)
            }
            _ => panic!("{name}: another projection"),
        }
    }
}

#[test]
fn gallery_and_probes_come_back() {
    for entry in GALLERY {
        let scene = (entry.build)();
        assert_same(&back(&scene), &scene);
    }
    for scene in [
        probes::two_triangles(),
        probes::slab(1.5, 0.5, 0.5),
        probes::mirror_corridor(3, [0.9; 3]),
        probes::soup(100, 1),
    ] {
        assert_same(&back(&scene), &scene);
    }
}

/// Every field of every type away from its default.
#[test]
fn a_scene_with_everything_comes_back() {
    let (sin, cos) = 0.4f32.sin_cos();
    let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos)) * Mat2::from_diagonal(Vec2::new(2.0, 0.5));
    let transform = Affine2::from_mat2_translation(turn, Vec2::new(0.25, -1.5));
    let texture = |index: usize| TextureRef { texture: index, uv_set: (index % 2) as u32, transform: None };
    let material = Material {
        name: "everything".into(),
        base_color: [0.1, 0.2, 0.3, 0.4],
        base_color_texture: Some(TextureRef { transform: Some(transform), ..texture(0) }),
        metallic: 0.5,
        roughness: 0.25,
        metallic_roughness_texture: Some(texture(1)),
        normal_texture: Some(NormalTexture { texture: texture(0), scale: 0.5 }),
        emissive: [801.7, 0.3, 1e-3],
        emissive_texture: Some(texture(1)),
        alpha_mode: AlphaMode::Mask(0.3),
        double_sided: true,
        unlit: false,
        ior: 1.33,
        specular: 0.5,
        specular_texture: Some(texture(0)),
        specular_color: [2.0, 1.0, 0.5],
        specular_color_texture: Some(texture(1)),
        transmission: 0.75,
        transmission_texture: Some(texture(0)),
        volume: Some(Volume { attenuation_distance: 0.7, attenuation_color: [0.5, 1.0, 0.25] }),
        dispersion: 0.5,
        clearcoat: Clearcoat {
            factor: 0.5,
            texture: Some(texture(0)),
            roughness: 0.25,
            roughness_texture: Some(texture(1)),
            normal_texture: Some(NormalTexture { texture: texture(0), scale: 0.75 }),
        },
        sheen: Sheen {
            color: [0.5, 0.25, 0.125],
            color_texture: Some(texture(1)),
            roughness: 0.3,
            roughness_texture: Some(texture(0)),
        },
        anisotropy: Anisotropy { strength: 0.5, rotation: 1.25, texture: Some(texture(1)) },
        iridescence: Iridescence {
            factor: 0.75,
            texture: Some(texture(0)),
            ior: 1.4,
            thickness_minimum: 50.0,
            thickness_maximum: 600.0,
            thickness_texture: Some(texture(1)),
        },
        diffuse_transmission: DiffuseTransmission {
            factor: 0.25,
            texture: Some(texture(0)),
            color: [0.5, 0.75, 0.25],
            color_texture: Some(texture(1)),
        },
    };
    let mesh = Mesh {
        // Closed, since its material has a volume.
        name: "tetrahedron".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.1, 1.0, 0.0), Vec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        normals: Some(vec![Vec3::Z, Vec3::new(0.6, 0.0, 0.8), Vec3::Z, Vec3::Z]),
        tangents: Some(vec![Vec4::new(1.0, 0.0, 0.0, -1.0); 4]),
        uvs: vec![
            vec![Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE],
            vec![Vec2::ONE, Vec2::X, Vec2::new(0.3, 0.7), Vec2::ZERO],
        ],
        colors: Some(vec![Vec4::ONE, Vec4::new(0.5, 0.25, 1.0, 0.75), Vec4::ONE, Vec4::ONE]),
        material: 0,
    };
    let unlit = Material { name: "unlit".into(), unlit: true, alpha_mode: AlphaMode::Blend, ..Material::default() };
    let bare = Mesh { material: 1, normals: None, tangents: None, uvs: vec![], colors: None, ..mesh.clone() };
    let image = |seed: u8, alpha: u8| Image {
        name: format!("image {seed}"),
        width: 2,
        height: 1,
        rgba: vec![seed, 2, 3, alpha, 250, 251, 252, 255],
    };
    let turned = DAffine3::from_scale_rotation_translation(
        DVec3::new(1.0, -2.0, 0.5),
        DQuat::from_rotation_y(0.7),
        DVec3::new(1.0, 2.0, 3.0),
    );
    let direction = DVec3::new(1.0, -2.0, 0.5).normalize();
    let position = DVec3::new(-1.0, 4.0, 0.25);
    let light = |kind| Light { name: "light".into(), kind, intensity: [30.0, 0.25, 7.5] };
    let scene = Scene {
        name: "scene".into(),
        meshes: vec![mesh, bare],
        instances: [0, 0, 1].map(|mesh| Instance { mesh, to_world: turned }).to_vec(),
        materials: vec![material, unlit],
        textures: vec![
            Texture { image: 0, wrap_s: Wrap::ClampToEdge, wrap_t: Wrap::MirroredRepeat, filter: Filter::Nearest },
            Texture { image: 1, wrap_s: Wrap::Repeat, wrap_t: Wrap::ClampToEdge, filter: Filter::Linear },
        ],
        images: vec![image(1, 255), image(9, 7)],
        cameras: vec![
            Camera {
                name: "wide".into(),
                to_world: DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.3), position),
                projection: Projection::Perspective { yfov: 1.1, aspect: None },
                clip: ClipRange { near: 0.25, far: f64::INFINITY },
            },
            Camera {
                name: "flat".into(),
                to_world: DAffine3::IDENTITY,
                projection: Projection::Orthographic { xmag: 2.0, ymag: 0.75 },
                clip: ClipRange { near: 0.5, far: 64.0 },
            },
        ],
        lights: vec![
            light(LightKind::Point { position }),
            light(LightKind::Spot { position, direction, inner: 0.25, outer: 0.5 }),
            light(LightKind::Directional { direction }),
        ],
        ..Scene::default()
    };
    let read = back(&scene);
    let mut expected = scene.clone();
    // The transform is split into an angle and put together again.
    let at = |s: &Scene| s.materials[0].base_color_texture.as_ref().unwrap().transform.unwrap();
    assert!(at(&read).abs_diff_eq(at(&scene), 1e-6));
    expected.materials[0].base_color_texture.as_mut().unwrap().transform = Some(at(&read));
    assert_same(&read, &expected);
    let clips = |s: &Scene| s.cameras.iter().map(|camera| camera.clip).collect::<Vec<_>>();
    assert_eq!(clips(&read), clips(&scene));
    assert_eq!(read.lights.len(), 3);
    for (a, b) in read.lights.iter().zip(&scene.lights) {
        assert_eq!((&a.name, a.intensity), (&b.name, b.intensity));
        match (a.kind, b.kind) {
            (LightKind::Point { position: p }, LightKind::Point { position: q }) => assert_eq!(p, q),
            (
                LightKind::Spot { position: p, direction: d, inner: i, outer: o },
                LightKind::Spot { position: q, direction: e, inner: j, outer: u },
            ) => assert!(p == q && d.distance(e) < 1e-6 && i == j && o == u),
            (LightKind::Directional { direction: d }, LightKind::Directional { direction: e }) => {
                assert!(d.distance(e) < 1e-6);
            }
            _ => panic!("{a:?} instead of {b:?}"),
        }
    }
}
