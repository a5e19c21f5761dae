//! A caller's mistakes: each gives an error that names the mistake, no panic and no picture.

use std::sync::Arc;

use glam::{Affine2, DAffine3, DVec3, Vec2, Vec3, Vec4};
use surelight_accel::{Accel, AccelError, BuildOptions};
use surelight_film::{Film, FilmError};
use surelight_prepare::{PrepareError, Prepared, Settings};
use surelight_render::{RenderError, Renderer};
use surelight_scene::{
    Clearcoat, Environment, EnvironmentMap, Filter, Image, Instance, Light, LightKind, Material, Mesh, NormalTexture,
    Scene, Texture, TextureRef, Wrap,
};
use surelight_tests::render::{device, prepare};
use surelight_tests::scenes::{emitter, lambert, look_at, pinhole};

/// Two triangles, one mesh a material, with everything that has an index or a length.
fn scene() -> Scene {
    let mesh = |material| Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        normals: Some(vec![Vec3::Z; 4]),
        tangents: Some(vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4]),
        uvs: vec![vec![Vec2::ZERO; 4]; 2],
        colors: Some(vec![Vec4::ONE; 4]),
        material,
        ..Mesh::default()
    };
    let image = Image { name: String::new(), width: 2, height: 2, rgba: vec![255; 16] };
    let texture = Texture { image: 0, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat, filter: Filter::Linear };
    let light = |kind| Light { name: String::new(), kind, intensity: [1.0; 3] };
    let textured = Material {
        base_color_texture: Some(TextureRef { texture: 0, uv_set: 1, transform: Some(Affine2::IDENTITY) }),
        ..lambert([0.5; 3])
    };
    Scene {
        meshes: vec![mesh(0), mesh(1)],
        instances: (0..2).map(|mesh| Instance { mesh, to_world: DAffine3::IDENTITY }).collect(),
        materials: vec![textured, emitter([1.0; 3])],
        textures: vec![texture],
        images: vec![image],
        cameras: vec![pinhole(look_at(DVec3::Z * 3.0, DVec3::ZERO, DVec3::Y), 60.0)],
        lights: vec![
            light(LightKind::Point { position: DVec3::Z }),
            light(LightKind::Spot { position: DVec3::Z, direction: DVec3::Z, inner: 0.1, outer: 0.2 }),
            light(LightKind::Directional { direction: DVec3::Z }),
        ],
        environment: Some(Environment::Map {
            map: Arc::new(EnvironmentMap { width: 2, height: 1, texels: vec![[1.0; 3]; 2] }),
            rotation: 0.0,
            scale: 1.0,
        }),
        ..Scene::default()
    }
}

fn reference(texture: usize, uv_set: u32, transform: Option<Affine2>) -> Option<TextureRef> {
    Some(TextureRef { texture, uv_set, transform })
}

fn map(width: u32, height: u32, texels: usize) -> Option<Environment> {
    let map = Arc::new(EnvironmentMap { width, height, texels: vec![[1.0; 3]; texels] });
    Some(Environment::Map { map, rotation: 0.0, scale: 1.0 })
}

type Mistake = (&'static str, fn(&mut Scene));

/// The mistake, as in the error, and an edit that makes it.
const MISTAKES: &[Mistake] = &[
    ("instance 1: index 2 of 2 meshes", |s| s.instances[1].mesh = 2),
    ("instance 0, transform: not finite", |s| s.instances[0].to_world.translation.y = f64::NAN),
    ("instance 1, transform: not finite", |s| s.instances[1].to_world.matrix3.x_axis.z = f64::INFINITY),
    ("mesh 0: index 7 of 2 materials", |s| s.meshes[0].material = 7),
    ("mesh 1, triangle 1, corner 2: index 99 of 4 vertices", |s| s.meshes[1].triangles[1][2] = 99),
    ("mesh 0, triangle 0, corner 0: index 4 of 4 vertices", |s| s.meshes[0].triangles[0] = [4, 5, u32::MAX]),
    ("mesh 0, triangle 0, corner 0: index 0 of 0 vertices", |s| {
        s.meshes[0] = Mesh { triangles: vec![[0; 3]], ..Mesh::default() };
    }),
    ("mesh 1, normals: 3 elements where 4 are needed", |s| s.meshes[1].normals.as_mut().unwrap().truncate(3)),
    ("mesh 0, tangents: 5 elements where 4 are needed", |s| s.meshes[0].tangents = Some(vec![Vec4::ONE; 5])),
    ("mesh 0, colors: 0 elements where 4 are needed", |s| s.meshes[0].colors = Some(Vec::new())),
    ("mesh 0, UV set 1: 3 elements where 4 are needed", |s| s.meshes[0].uvs[1].truncate(3)),
    ("material 0, base color texture: index 1 of 1 textures", |s| {
        s.materials[0].base_color_texture = reference(1, 0, None);
    }),
    ("material 1, clearcoat normal texture: index 3 of 1 textures", |s| {
        let normal_texture = reference(3, 0, None).map(|texture| NormalTexture { texture, scale: 1.0 });
        s.materials[1].clearcoat = Clearcoat { factor: 1.0, normal_texture, ..Clearcoat::default() };
    }),
    ("material 0, emissive texture: index 2 of 2 UV sets", |s| {
        s.materials[0].emissive_texture = reference(0, 2, None);
    }),
    ("material 0, emissive texture, transform: not finite", |s| {
        s.materials[0].emissive_texture = reference(0, 0, Some(Affine2::from_scale(Vec2::splat(f32::NAN))));
    }),
    ("texture 0: index 1 of 1 images", |s| s.textures[0].image = 1),
    ("image 0: 15 elements where 16 are needed", |s| s.images[0].rgba.truncate(15)),
    ("image 0: no texels", |s| s.images[0] = Image { name: String::new(), width: 0, height: 3, rgba: Vec::new() }),
    ("environment map: 3 elements where 2 are needed", |s| s.environment = map(2, 1, 3)),
    ("environment map: no texels", |s| s.environment = map(0, 0, 0)),
    ("light 0, position and direction: not finite", |s| {
        s.lights[0].kind = LightKind::Point { position: DVec3::INFINITY };
    }),
    ("light 1, position and direction: not finite", |s| {
        let direction = DVec3::NAN;
        s.lights[1].kind = LightKind::Spot { position: DVec3::ZERO, direction, inner: 0.1, outer: 0.2 };
    }),
    ("light 2, position and direction: not finite", |s| {
        s.lights[2].kind = LightKind::Directional { direction: DVec3::NAN };
    }),
    ("camera 0, transform: not finite", |s| s.cameras[0].to_world.translation.x = f64::INFINITY),
];

#[test]
fn scenes_that_are_not_valid_are_refused() {
    let sound = scene();
    let camera = sound.cameras[0].clone();
    let settings = Settings::new(8, 8);
    Prepared::new(&sound, &camera, &settings).unwrap_or_else(|e| panic!("{e}"));
    for (what, spoil) in MISTAKES {
        let mut scene = sound.clone();
        spoil(&mut scene);
        let wanted = format!("the scene is not valid: {what}");
        match Prepared::new(&scene, &camera, &settings).err() {
            Some(error @ PrepareError::Scene(_)) => assert_eq!(error.to_string(), wanted),
            other => panic!("{what}: {other:?}"),
        }
        match Accel::build(&scene, DVec3::ZERO, &BuildOptions::default()).err() {
            Some(error @ AccelError::Scene(_)) => assert_eq!(error.to_string(), wanted),
            other => panic!("{what}: {other:?}"),
        }
    }
}

#[test]
fn untraceable_paths_are_not_lost_work() {
    let mut renderer = Renderer::new(device(), &prepare(&scene(), &Settings::new(8, 8))).unwrap();
    let mut trace = |film: &mut Film, batches, samples| renderer.trace(film, 0, batches, samples, &mut |_| true);
    let mut film = Film::new(8, 8);
    let error = trace(&mut Film::new(9, 8), 1, 1).unwrap_err();
    assert!(matches!(error, RenderError::FilmSize { film: [9, 8], view: [8, 8] }), "{error:?}");
    assert_eq!(error.to_string(), "the film is of an image of 9x8 pixels, the view of one of 8x8");
    let error = trace(&mut film, 1, 0).unwrap_err();
    assert!(matches!(error, RenderError::Film(FilmError::NoSamples)), "{error:?}");
    assert!(std::error::Error::source(&error).is_some_and(|source| source.is::<FilmError>()));
    let error = trace(&mut film, 1 << 20, 1).unwrap_err();
    assert!(matches!(error, RenderError::TooManyBatches { batches: 0x10_0000, .. }), "{error:?}");
    assert!(trace(&mut film, 0, 1).unwrap());
    assert!((0..64).all(|i| film.samples(i) == 0));
    // Valid calls still work.
    assert!(trace(&mut film, 2, 1).unwrap());
    assert!((0..64).all(|i| film.samples(i) == 2));
    let error = renderer.trace_features(&mut Film::new(8, 9)).unwrap_err();
    assert!(matches!(error, RenderError::FilmSize { film: [8, 9], view: [8, 8] }), "{error:?}");
}
