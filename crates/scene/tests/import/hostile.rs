//! Files changed at random: the result is a valid scene or an error, never a panic.
//!
//! `SURELIGHT_FUZZ_CASES` sets the number of cases for each kind (default 2000), `SURELIGHT_CORPUS`
//! adds its small files as seeds. The random numbers are fixed, so a failure comes back.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use surelight_scene::{LoadOptions, Moment, Scene, load_bytes, load_environment};

use crate::build::{FLOAT, Gltf, floats};
use crate::geometry_extensions::asset;

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ z >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ z >> 31
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

fn cases() -> u64 {
    std::env::var("SURELIGHT_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(2000)
}

/// A file with a bit of everything.
fn rich() -> Gltf {
    let mut gltf = Gltf::square();
    let texture = gltf.texture();
    let info = json!({"index": texture, "texCoord": 0, "extensions": {"KHR_texture_transform": {"scale": [2, 2]}}});
    let mut gltf = gltf.material(json!({
        "name": "m", "alphaMode": "MASK", "alphaCutoff": 0.5, "emissiveFactor": [1, 1, 1],
        "normalTexture": info, "pbrMetallicRoughness": {"baseColorTexture": info, "metallicFactor": 0.5},
        "extensions": {
            "KHR_materials_ior": {"ior": 1.4}, "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 2},
            "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": info},
        },
    }));
    gltf.json["samplers"] = json!([{"wrapS": 33071}]);
    gltf.json["textures"][0]["sampler"] = json!(0);
    let colors = gltf.accessor(&floats(&[0.5; 16]), FLOAT, "VEC4", 4);
    gltf.primitive()["attributes"]["COLOR_0"] = json!(colors);
    let at = gltf.view(&[1, 3]);
    let values = gltf.view(&floats(&[1., 2., 3., 4., 5., 6.]));
    let sparse = json!({
        "count": 2, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": values},
    });
    let positions = gltf.primitive()["attributes"]["POSITION"].as_u64().expect("index") as usize;
    gltf.json["accessors"][positions]["sparse"] = sparse;
    gltf.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}]);
    gltf.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}, "intensity": 2}]}});
    gltf.json["nodes"] = json!([
        {"mesh": 0, "children": [1, 2], "scale": [1, 2, 3]},
        {"camera": 0, "rotation": [0, 0, 0, 1]},
        {"extensions": {"KHR_lights_punctual": {"light": 0}}, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1]},
    ]);
    gltf
}

/// Changes one random value of a JSON tree.
fn mutate(value: &mut Value, random: &mut Random) {
    let mut leaves = Vec::new();
    collect(value, String::new(), &mut leaves);
    let path = &leaves[random.below(leaves.len())];
    let Some(target) = value.pointer_mut(path) else { return };
    *target = match random.below(16) {
        0 => json!(-1),
        1 => json!(random.below(8)),
        2 => json!(u64::MAX - random.next() % 4),
        3 => json!(1_u64 << (random.next() % 64)),
        4 => json!(1e300),
        5 => json!(-1e-300),
        6 => json!(random.below(100)),
        7 => json!(0.5),
        8 => Value::Null,
        9 => json!("x"),
        10 => json!([]),
        11 => json!({}),
        12 => json!([0, 0, 0]),
        13 => json!(true),
        14 => json!([5120, 5121, 5122, 5123, 5125, 5126][random.below(6)]),
        _ => json!(["VEC2", "VEC3", "VEC4", "SCALAR", "MAT4", "BLEND", "data:,", "../x"][random.below(8)]),
    };
}

fn collect(value: &Value, path: String, out: &mut Vec<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                collect(value, format!("{path}/{}", key.replace('~', "~0").replace('/', "~1")), out);
            }
        }
        Value::Array(items) => {
            for (i, value) in items.iter().enumerate() {
                collect(value, format!("{path}/{i}"), out);
            }
        }
        _ => {}
    }
    out.push(path);
}

/// The promises that everything downstream relies on.
fn check(scene: &Scene) {
    assert_eq!(scene.validate(), Ok(()));
    for mesh in &scene.meshes {
        assert!(mesh.normals.iter().flatten().all(|v| v.is_normalized()));
        assert!(mesh.tangents.iter().flatten().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0));
        assert!(mesh.uvs.iter().flatten().all(|uv| uv.is_finite()));
        assert!(mesh.colors.iter().flatten().all(|c| c.is_finite()));
    }
    for m in &scene.materials {
        let unit = |c: f32| (0.0..=1.0).contains(&c);
        assert!(m.base_color.into_iter().all(unit) && unit(m.metallic) && unit(m.roughness) && unit(m.transmission));
        assert!(m.emissive.iter().chain(&m.specular_color).all(|c| c.is_finite() && *c >= 0.0) && unit(m.specular));
        assert!(m.ior == 0.0 || m.ior >= 1.0);
        assert!(m.volume.is_none_or(|v| v.attenuation_distance > 0.0 && v.attenuation_color.into_iter().all(unit)));
    }
    assert!(scene.lights.iter().all(|l| l.intensity.iter().all(|c| c.is_finite() && *c >= 0.0)));
    assert!(scene.frame_camera(1.0).to_world.is_finite());
}

fn attempt(bytes: &[u8], path: &Path, what: &str) -> bool {
    // Small limits, so that a mutation that needs much memory is an error and not a slow test.
    let options = LoadOptions { max_image_pixels: 1 << 20, max_geometry_bytes: 16 << 20, ..LoadOptions::default() };
    let moment = Moment { animation: "0".into(), seconds: 0.4 };
    let moving = LoadOptions { animation: Some(moment), ..options.clone() };
    let outcome = std::panic::catch_unwind(|| match load_bytes(bytes, path, &options) {
        Ok(scene) => {
            check(&scene);
            if let Ok(moved) = load_bytes(bytes, path, &moving) {
                check(&moved);
            }
            true
        }
        Err(error) => {
            assert!(error.to_string().ends_with('.'), "{error}");
            false
        }
    });
    match outcome {
        Ok(loaded) => loaded,
        Err(_) => {
            let kept = std::env::temp_dir().join("surelight-hostile.bin");
            let _ = fs::write(&kept, bytes);
            panic!("{what} panicked; the file is {}", kept.display());
        }
    }
}

/// Splits a .glb into JSON and binary chunk; `None` for other files.
fn open(bytes: &[u8]) -> Option<Gltf> {
    let length = u32::from_le_bytes(*bytes.get(12..)?.first_chunk()?) as usize;
    let json = serde_json::from_slice(bytes.get(20..20 + length)?).ok()?;
    Some(Gltf { json, bin: bytes.get(28 + length..).unwrap_or_default().to_vec() })
}

fn seeds() -> Vec<(PathBuf, Gltf)> {
    let mut seeds = vec![(PathBuf::from("rich.glb"), rich()), (PathBuf::from("square.glb"), Gltf::square())];
    seeds.push((PathBuf::from("skinned.glb"), crate::posing::skinned()));
    seeds.push((PathBuf::from("moving.glb"), crate::pointers::moving()));
    for name in ["basisu.glb", "draco.glb", "meshopt-ext.glb", "meshopt-khr.glb"] {
        seeds.extend(open(&asset(name)).map(|gltf| (PathBuf::from(name), gltf)));
    }
    let Some(corpus) = std::env::var_os("SURELIGHT_CORPUS").map(PathBuf::from) else { return seeds };
    for folder in ["geometry", "materials", "textures", "scenes", "malformed/derived"] {
        for entry in fs::read_dir(corpus.join(folder)).into_iter().flatten().flatten() {
            let small = entry.metadata().is_ok_and(|m| m.len() < 60_000);
            if let Some(gltf) = small.then(|| fs::read(entry.path()).ok()).flatten().and_then(|b| open(&b)) {
                seeds.push((entry.path(), gltf));
            }
        }
    }
    seeds.sort_by(|a, b| a.0.cmp(&b.0));
    seeds
}

#[test]
fn changed_json_never_panics() {
    let seeds = seeds();
    let mut loaded = 0;
    for case in 0..cases() {
        let mut random = Random(case);
        let (path, seed) = &seeds[random.below(seeds.len())];
        let mut gltf = seed.clone();
        for _ in 0..1 + random.below(4) {
            mutate(&mut gltf.json, &mut random);
        }
        loaded += usize::from(attempt(&gltf.glb(), path, &format!("case {case} of {}", path.display())));
    }
    // Both outcomes must occur, or the mutations are too wild or too tame to test anything.
    assert!(loaded > 0 && (loaded as u64) < cases(), "{loaded} of {} load", cases());
}

#[test]
fn changed_bytes_never_panic() {
    let seeds = seeds();
    for case in 0..cases() {
        let mut random = Random(case ^ 0xABCD_0000_0000);
        let (path, seed) = &seeds[random.below(seeds.len())];
        let mut bytes = seed.glb();
        for _ in 0..1 + random.below(8) {
            // Half of them hit the binary chunk: vertices, indices, images.
            let at = random.below(bytes.len());
            bytes[at] = match random.below(4) {
                0 => 0,
                1 => 0xFF,
                2 => bytes[at] ^ 1 << random.below(8),
                _ => random.next() as u8,
            };
        }
        attempt(&bytes, path, &format!("case {case} of {}", path.display()));
    }
}

#[test]
fn changed_environment_maps_never_panic() {
    let mut seeds = vec![b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".repeat(2)];
    let texels: Vec<[f32; 3]> = (0..64 * 32).map(|i| [i as f32, 1.0, (i % 7) as f32]).collect();
    for compression in [
        exr::prelude::Compression::ZIP16,
        exr::prelude::Compression::PIZ,
        exr::prelude::Compression::RLE,
        exr::prelude::Compression::PXR24,
        exr::prelude::Compression::B44,
        exr::prelude::Compression::Uncompressed,
    ] {
        use exr::prelude::*;
        let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
            let [r, g, b] = texels[at.1 * 64 + at.0];
            (f16::from_f32(r), f16::from_f32(g), f16::from_f32(b))
        });
        let encoding = Encoding { compression, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let layer = Layer::new((64, 32), LayerAttributes::named("sky"), encoding, channels);
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_layer(layer).write().to_buffered(&mut bytes).expect("encodes");
        seeds.push(bytes.into_inner());
    }
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("map");
    for case in 0..cases() / 2 {
        let mut random = Random(case ^ 0x1234_0000_0000);
        let mut bytes = seeds[random.below(seeds.len())].clone();
        for _ in 0..1 + random.below(4) {
            // Most possible defects are in the header and the offset table.
            let range = if random.below(2) == 0 { bytes.len().min(600) } else { bytes.len() };
            let at = random.below(range);
            bytes[at] = if random.below(2) == 0 { random.next() as u8 } else { bytes[at] ^ 1 << random.below(8) };
        }
        fs::write(&path, &bytes).expect("file");
        let outcome = std::panic::catch_unwind(|| load_environment(&path));
        match outcome {
            Ok(Ok(map)) => assert!(map.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0)),
            Ok(Err(error)) => assert!(error.to_string().ends_with('.'), "{error}"),
            Err(_) => {
                let kept = std::env::temp_dir().join("surelight-hostile.exr");
                let _ = fs::write(&kept, &bytes);
                panic!("case {case} panicked; the file is {}", kept.display());
            }
        }
    }
}

#[test]
fn a_buffer_that_is_not_there_lends_no_size() {
    // 4 thousand million vertices of implied zeros, allowed if the file were as large as it claims.
    for buffer in [json!({"byteLength": 1_u64 << 52}), json!({"byteLength": 1_u64 << 52, "uri": "data:,"})] {
        let mut gltf = Gltf::triangle();
        gltf.push("buffers", buffer);
        gltf.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": u32::MAX});
        gltf.refused(&["its geometry", "are allowed"]);
    }
}

#[test]
fn a_mistyped_object_is_named() {
    let mut gltf = Gltf::triangle();
    gltf.json["samplers"] = json!(["sampler"]);
    gltf.refused(&["samplers[0]", "\"sampler\"", "must be an object"]);
}
