//! Draco and Basis Universal, variants, and specular-glossiness.

use std::sync::Once;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde_json::{Value, json};
use surelight_scene::{LoadOptions, Scene, load_bytes};

use crate::build::{Gltf, png, warned};
use crate::geometry_extensions::{asset, equals_its_counterpart, loaded};

#[test]
fn draco_equals_the_plain_file() {
    // Encoded by Google's Draco; the plain counterpart is decoded by Draco itself.
    equals_its_counterpart(&loaded(&asset("draco.glb")));
}

#[test]
fn basis_textures_are_their_gradients() {
    // 4 × 4 blocks of one colour each: red grows to the right, green downwards, blue is 64. Lossy,
    // so near.
    let scene = loaded(&asset("basisu.glb"));
    for (image, most) in scene.images.iter().zip([8, 2]) {
        assert_eq!((image.width, image.height), (16, 16));
        for (i, texel) in image.rgba.as_chunks::<4>().0.iter().enumerate() {
            let expected = [i % 16 / 4 * 80, i / 64 * 80, 64, 255];
            for (&c, e) in texel.iter().zip(expected) {
                assert!((i64::from(c) - e as i64).abs() <= most, "{}: {i} {texel:?} {expected:?}", image.name);
            }
        }
    }
    assert_eq!(scene.images.len(), 2);
}

/// The file with a Draco stream of 441 vertices and 800 triangles, once `edit` has changed its
/// JSON.
fn draco(edit: impl Fn(&mut Gltf)) -> Gltf {
    let file = asset("draco.glb");
    let length = u32::from_le_bytes(*file[12..].first_chunk().expect("length")) as usize;
    let json = serde_json::from_slice(&file[20..20 + length]).expect("JSON");
    let mut gltf = Gltf { json, bin: file[28 + length..].to_vec() };
    edit(&mut gltf);
    gltf
}

#[track_caller]
fn stream_is_drawn(gltf: &Gltf, warning: &str) {
    let scene = gltf.load();
    warned(&scene, warning);
    let (packed, plain) = (&scene.meshes[0], &scene.meshes[1]);
    assert_eq!((&packed.positions, &packed.uvs), (&plain.positions, &plain.uvs));
    assert_eq!((packed.triangles.len(), packed.normals.is_some()), (plain.triangles.len(), true));
}

#[test]
fn the_counts_of_a_draco_stream_hold() {
    for (vertices, corners, stated) in [
        (440, 2400, "accessors state 440 vertices and 800 triangles"),
        (441, 3, "accessors state 441 vertices and 1 triangle"),
        (1, 2400, "accessors state 1 vertex and 800 triangles"),
        (100_000, 30_000, "accessors state 100000 vertices and 10000 triangles"),
    ] {
        let gltf = draco(|gltf| {
            for (accessor, count) in [vertices, vertices, vertices, corners].into_iter().enumerate() {
                gltf.json["accessors"][accessor]["count"] = json!(count);
            }
        });
        stream_is_drawn(&gltf, stated);
        stream_is_drawn(&gltf, "mesh 0, primitive 0 has 441 vertices and 800 triangles");
    }
    // Even where the accessors disagree with each other.
    let gltf = draco(|gltf| gltf.json["accessors"][1]["count"] = json!(7));
    assert_eq!(gltf.load().warnings, Vec::<String>::new());
    // Accessors that are not in the stream are removed with it.
    draco(|gltf| {
        let extension = &mut gltf.primitive()["extensions"]["KHR_draco_mesh_compression"];
        extension["attributes"] = json!({"NORMAL": 1, "TEXCOORD_0": 0});
        gltf.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": 3});
    })
    .refused(&["mesh 0, primitive 0", "3 positions beside a Draco stream of 441 vertices"]);
}

#[test]
fn a_draco_stream_without_an_indices_accessor_is_drawn() {
    let gltf = draco(|gltf| {
        gltf.primitive().as_object_mut().expect("object").remove("indices");
    });
    stream_is_drawn(&gltf, "mesh 0, primitive 0 has no indices accessor beside it");
}

#[test]
fn draco_streams_beyond_their_accessors_are_limited() {
    let gltf = draco(|gltf| {
        for accessor in 0..4 {
            gltf.json["accessors"][accessor]["count"] = json!(3);
        }
    });
    let options = LoadOptions { max_geometry_bytes: 10_000, ..LoadOptions::default() };
    let error = load_bytes(&gltf.glb(), "made.glb".as_ref(), &options).expect_err("refused");
    assert!(matches!(error, surelight_scene::LoadError::TooLarge { .. }), "{error}");
    assert!(error.to_string().contains("mesh 0, primitive 0 would take"), "{error}");
}

/// Panics inside the decoders, which the importer would catch.
static CAUGHT: AtomicUsize = AtomicUsize::new(0);

fn watch_decoders() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let file = info.location().map_or("", |l| l.file());
            if ["draco-core-", "basisu-", "ruzstd-"].iter().any(|name| file.contains(name)) {
                CAUGHT.fetch_add(1, Ordering::SeqCst);
            }
            usual(info);
        }));
    });
}

/// Loads `name` with random bytes after `begin` changed; how often it is refused or warned of.
/// Nothing may panic, not even where that is caught.
fn mutate(name: &str, begin: usize, length: usize, rounds: usize) -> usize {
    watch_decoders();
    let whole = asset(name);
    let (mut noticed, mut seed) = (0, 9_u32);
    for round in 0..rounds {
        let mut bytes = whole.clone();
        for _ in 0..=round % 4 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let at = begin + (seed >> 8) as usize % length;
            bytes[at] = (seed >> 3) as u8;
        }
        let outcome = load_bytes(&bytes, "made.glb".as_ref(), &LoadOptions::default());
        noticed += usize::from(outcome.map_or(true, |scene| !scene.warnings.is_empty()));
        assert_eq!(CAUGHT.load(Ordering::SeqCst), 0, "{name}, round {round}");
    }
    noticed
}

/// Where the binary chunk begins.
fn bin(name: &str) -> usize {
    asset(name).windows(4).position(|w| w == b"BIN\0").expect("chunk") + 4
}

#[test]
fn damaged_draco_streams_never_panic() {
    assert!(mutate("draco.glb", bin("draco.glb"), 10_819, 2000) > 100);
}

#[test]
fn damaged_basis_textures_never_panic() {
    assert!(mutate("basisu.glb", bin("basisu.glb"), 660, 2000) > 100);
}

/// The triangle with three materials and two variants.
fn varied(variant: Option<&str>) -> Result<Scene, String> {
    let mut gltf = Gltf::triangle().material(json!({"name": "own"}));
    gltf.push("materials", json!({"name": "beach"}));
    gltf.push("materials", json!({"name": "street"}));
    gltf.json["extensionsUsed"] = json!(["KHR_materials_variants"]);
    let variants = json!({"variants": [{"name": "Beach"}, {"name": "Street"}, {"name": "None"}]});
    gltf.json["extensions"] = json!({"KHR_materials_variants": variants});
    gltf.primitive()["extensions"] = json!({"KHR_materials_variants": {"mappings": [
        {"material": 1, "variants": [0]}, {"material": 2, "variants": [1]},
    ]}});
    let options = LoadOptions { variant: variant.map(str::to_owned), ..LoadOptions::default() };
    load_bytes(&gltf.glb(), "made.glb".as_ref(), &options).map_err(|e| e.to_string())
}

#[test]
fn variants_choose_materials() {
    for (variant, material) in [
        (None, "own"),
        (Some("Beach"), "beach"),
        (Some("Street"), "street"),
        (Some("1"), "street"),
        (Some("None"), "own"),
    ] {
        let scene = varied(variant).expect("loads");
        assert_eq!(scene.materials[scene.meshes[0].material].name, material);
        assert!(scene.warnings.is_empty());
    }
    let message = varied(Some("Night")).expect_err("refused");
    assert!(message.contains("\"Night\"") && message.contains("\"Beach\", \"Street\""), "{message}");
}

/// The square with a specular-glossiness material.
fn specular_glossiness(mut json: Value, texture: bool) -> Scene {
    let mut gltf = Gltf::square();
    if texture {
        let view = gltf.view(&png(2, 1, &[10, 20, 30, 255, 40, 50, 60, 51]));
        let image = gltf.push("images", json!({"bufferView": view}));
        gltf.push("textures", json!({"source": image}));
        json["specularGlossinessTexture"] = json!({"index": 0});
    }
    gltf.json["extensionsUsed"] = json!(["KHR_materials_pbrSpecularGlossiness"]);
    let gltf = gltf.material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1], "metallicFactor": 1},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": json},
    }));
    let scene = gltf.load();
    assert_eq!(scene.warnings, Vec::<String>::new());
    scene
}

#[test]
fn specular_glossiness_becomes_a_dielectric_of_that_reflectance() {
    let scene = specular_glossiness(
        json!({"diffuseFactor": [0.1, 0.2, 0.3, 0.4], "specularFactor": [0.04, 0.5, 1.0], "glossinessFactor": 0.75}),
        false,
    );
    let m = &scene.materials[0];
    assert_eq!((m.base_color, m.metallic, m.roughness), ([0.1, 0.2, 0.3, 0.4], 0.0, 0.25));
    // Reflectance at normal incidence as glTF computes it is the specular colour.
    let base = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
    for (c, specular) in m.specular_color.into_iter().zip([0.04, 0.5, 1.0]) {
        assert!(((base * c).min(1.0) * m.specular - specular).abs() < 1e-6);
    }
}

#[test]
fn glossiness_textures_become_roughness_textures() {
    let scene = specular_glossiness(json!({"glossinessFactor": 0.5}), true);
    let m = &scene.materials[0];
    let image = |reference: &Option<surelight_scene::TextureRef>| {
        let texture = reference.as_ref().expect("texture").texture;
        &scene.images[scene.textures[texture].image].rgba
    };
    assert_eq!(image(&m.specular_color_texture)[..4], [10, 20, 30, 255]);
    // 1 − ½ · 1 and 1 − ½ · 0.2, in green; no metal in blue.
    let roughness = image(&m.metallic_roughness_texture);
    assert_eq!([roughness[1], roughness[2], roughness[5], roughness[6]], [128, 0, 230, 0]);
    assert_eq!((m.roughness, m.metallic), (1.0, 0.0));
}
