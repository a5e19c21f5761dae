//! The encoder's bytes, parsed by the test itself.

use glam::{Affine2, DVec3, Mat2, Vec2, Vec3};
use serde_json::Value;
use surelight_scene::{
    AlphaMode, Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, NormalTexture, Sheen, TextureRef,
    Volume,
};

use super::*;

fn parts(file: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!(&file[..4], b"glTF");
    assert_eq!((word(4), word(8)), (2, file.len()));
    let json = word(12);
    assert_eq!(&file[16..20], b"JSON");
    let binary = 20 + json;
    assert_eq!(word(binary), file.len() - binary - 8);
    assert_eq!(&file[binary + 4..binary + 8], b"BIN\0");
    (serde_json::from_slice(&file[20..binary]).unwrap(), &file[binary + 8..])
}

fn triangle(material: usize) -> Mesh {
    Mesh {
        name: "triangle".into(),
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 0.1, -2.0)],
        triangles: vec![[0, 1, 2]],
        material,
        ..Mesh::default()
    }
}

fn one_triangle(material: Material) -> Scene {
    Scene {
        meshes: vec![triangle(0)],
        instances: vec![Instance { mesh: 0, to_world: DAffine3::IDENTITY }],
        materials: vec![material],
        ..Scene::default()
    }
}

#[test]
fn geometry_is_laid_out_as_gltf_wants_it() {
    let mut scene = one_triangle(Material::default());
    scene.meshes.push(Mesh { material: 1, ..triangle(0) });
    scene.materials.push(Material::default());
    let to_world = DAffine3::from_translation(DVec3::new(0.1, 2.0, -3.0));
    scene.instances.push(Instance { mesh: 1, to_world });
    let file = encode(&scene, "known: nothing").unwrap();
    assert_eq!(file, encode(&scene, "known: nothing").unwrap());
    let (json, binary) = parts(&file);
    assert_eq!(json["asset"]["extras"]["notes"], "known: nothing");
    // Equal vertex data is stored once.
    assert_eq!(json["accessors"].as_array().unwrap().len(), 2);
    assert_eq!(json["meshes"][0]["primitives"][0]["attributes"], json["meshes"][1]["primitives"][0]["attributes"]);
    let accessor = &json["accessors"][0];
    assert_eq!(accessor["min"], serde_json::json!([0.0, 0.0, -2.0]));
    assert_eq!(accessor["max"].to_string(), "[1.0,0.1,0.0]");
    let view = &json["bufferViews"][0];
    assert_eq!((view["byteOffset"].as_u64(), view["byteLength"].as_u64()), (Some(0), Some(36)));
    assert_eq!(binary[12..16], 1.0f32.to_le_bytes());
    assert_eq!(json["nodes"][0].get("matrix"), None);
    assert_eq!(json["nodes"][1]["matrix"][12].to_string(), "0.1");
    assert_eq!(json["scenes"][0]["nodes"], serde_json::json!([0, 1]));
}

#[test]
fn indices_are_as_wide_as_needed() {
    for (vertices, component) in [(0xffff, 5123), (0x10000, 5125)] {
        let mut scene = one_triangle(Material::default());
        scene.meshes[0].positions = vec![Vec3::ZERO; vertices];
        let file = encode(&scene, "").unwrap();
        let (json, _) = parts(&file);
        assert_eq!(json["accessors"][1]["componentType"], component);
    }
}

#[test]
fn default_material_needs_no_extension() {
    let file = encode(&one_triangle(Material::default()), "").unwrap();
    let (json, _) = parts(&file);
    assert_eq!(json.get("extensionsUsed"), None);
    assert_eq!(json["materials"][0].get("extensions"), None);
    assert_eq!(json["asset"].get("extras"), None);
}

#[test]
fn emission_survives_bit_for_bit() {
    let radiance = [17.3f32, 1e-3, 801.7];
    let file = encode(&one_triangle(Material { emissive: radiance, ..Material::default() }), "").unwrap();
    let (json, _) = parts(&file);
    let m = &json["materials"][0];
    let strength = m["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"].as_f64().unwrap() as f32;
    for c in 0..3 {
        let factor = m["emissiveFactor"][c].as_f64().unwrap() as f32;
        assert!((0.0..=1.0).contains(&factor));
        assert_eq!(factor * strength, radiance[c]);
    }
}

#[test]
fn texture_transform_is_the_matrix_of_the_extension() {
    for (rotation, scale) in [(0.0f32, [1.0f32, 1.0]), (0.4, [2.0, 0.5]), (-2.5, [3.0, -0.25])] {
        let (sin, cos) = rotation.sin_cos();
        // By columns: u' = cos·u + sin·v, v' = −sin·u + cos·v, after scaling.
        let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
        let matrix2 = turn * Mat2::from_diagonal(Vec2::from(scale));
        let transform = Affine2::from_mat2_translation(matrix2, Vec2::new(0.25, -1.5));
        let texture = TextureRef { texture: 0, uv_set: 0, transform: Some(transform) };
        let mut scene = one_triangle(Material { base_color_texture: Some(texture), ..Material::default() });
        scene.images.push(Image { name: "dot".into(), width: 1, height: 1, rgba: vec![1, 2, 3, 4] });
        scene.textures.push(Texture {
            image: 0,
            wrap_s: Wrap::ClampToEdge,
            wrap_t: Wrap::Repeat,
            filter: Filter::Nearest,
        });
        let file = encode(&scene, "").unwrap();
        let (json, binary) = parts(&file);
        let info = &json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
        let written = &info["extensions"]["KHR_texture_transform"];
        let near = |v: &Value, x: f32| (v.as_f64().unwrap() as f32 - x).abs() < 1e-5;
        assert!(near(&written["rotation"], rotation), "{written}");
        assert!(near(&written["scale"][0], scale[0]) && near(&written["scale"][1], scale[1]), "{written}");
        assert!(near(&written["offset"][0], 0.25) && near(&written["offset"][1], -1.5));
        assert_eq!(json["samplers"][0]["wrapS"], 33071);
        let view = &json["bufferViews"][json["images"][0]["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        let png = &binary[start..start + view["byteLength"].as_u64().unwrap() as usize];
        let decoded = image::load_from_memory(png).unwrap().to_rgba8();
        assert_eq!(decoded.into_raw(), [1, 2, 3, 4]);
        assert_eq!(json["extensionsUsed"], serde_json::json!(["KHR_texture_transform"]));
    }
}

#[test]
fn lights_point_along_their_node() {
    for direction in [DVec3::NEG_Z, DVec3::Z, DVec3::NEG_Y, DVec3::new(1.0, 2.0, -3.0).normalize()] {
        let mut scene = one_triangle(Material::default());
        scene.lights.push(Light {
            name: "sun".into(),
            kind: LightKind::Directional { direction },
            intensity: [3.0, 2.0, 0.7],
        });
        let file = encode(&scene, "").unwrap();
        let (json, _) = parts(&file);
        let node = &json["nodes"][1];
        let z = match node.get("matrix") {
            None => DVec3::Z,
            Some(m) => DVec3::from_array([8, 9, 10].map(|i| m[i].as_f64().unwrap())),
        };
        assert!((-z - direction).length() < 1e-6);
        let light = &json["extensions"]["KHR_lights_punctual"]["lights"][0];
        assert_eq!((light["type"].as_str(), light["intensity"].as_f64()), (Some("directional"), Some(4.0)));
        assert_eq!(light["color"][1].as_f64(), Some(0.5));
    }
}

#[test]
fn every_field_has_its_place() {
    let texture = || Some(TextureRef { texture: 0, uv_set: 1, transform: None });
    let material = Material {
        name: "all".into(),
        base_color: [0.1, 0.2, 0.3, 0.4],
        base_color_texture: texture(),
        metallic: 0.5,
        roughness: 0.25,
        metallic_roughness_texture: texture(),
        normal_texture: Some(NormalTexture { texture: texture().unwrap(), scale: 0.5 }),
        emissive: [1.0, 0.5, 0.0],
        emissive_texture: texture(),
        alpha_mode: AlphaMode::Mask(0.3),
        double_sided: true,
        unlit: true,
        ior: 1.33,
        specular: 0.5,
        specular_texture: texture(),
        specular_color: [2.0, 1.0, 1.0],
        specular_color_texture: texture(),
        transmission: 0.75,
        transmission_texture: texture(),
        volume: Some(Volume { attenuation_distance: f32::INFINITY, attenuation_color: [0.5, 1.0, 1.0] }),
        dispersion: 0.5,
        clearcoat: Clearcoat {
            factor: 0.5,
            texture: texture(),
            roughness: 0.25,
            roughness_texture: texture(),
            normal_texture: Some(NormalTexture { texture: texture().unwrap(), scale: 0.5 }),
        },
        sheen: Sheen { color: [0.5; 3], color_texture: texture(), roughness: 0.25, roughness_texture: texture() },
        anisotropy: Anisotropy { strength: 0.5, rotation: 1.5, texture: texture() },
        iridescence: Iridescence {
            factor: 0.5,
            texture: texture(),
            ior: 1.5,
            thickness_minimum: 50.0,
            thickness_maximum: 100.0,
            thickness_texture: texture(),
        },
        diffuse_transmission: DiffuseTransmission {
            factor: 0.5,
            texture: texture(),
            color: [0.25; 3],
            color_texture: texture(),
        },
    };
    let file = encode(&one_triangle(material), "").unwrap();
    let (json, _) = parts(&file);
    let expected = serde_json::json!({
        "name": "all",
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
            "baseColorTexture": { "index": 0, "texCoord": 1 },
            "metallicFactor": 0.5,
            "roughnessFactor": 0.25,
            "metallicRoughnessTexture": { "index": 0, "texCoord": 1 }
        },
        "normalTexture": { "index": 0, "texCoord": 1, "scale": 0.5 },
        "emissiveFactor": [1.0, 0.5, 0.0],
        "emissiveTexture": { "index": 0, "texCoord": 1 },
        "alphaMode": "MASK",
        "alphaCutoff": 0.3,
        "doubleSided": true,
        "extensions": {
            "KHR_materials_ior": { "ior": 1.33 },
            "KHR_materials_specular": {
                "specularFactor": 0.5,
                "specularTexture": { "index": 0, "texCoord": 1 },
                "specularColorFactor": [2.0, 1.0, 1.0],
                "specularColorTexture": { "index": 0, "texCoord": 1 }
            },
            "KHR_materials_transmission": {
                "transmissionFactor": 0.75,
                "transmissionTexture": { "index": 0, "texCoord": 1 }
            },
            "KHR_materials_unlit": {},
            "KHR_materials_volume": { "thicknessFactor": 1.0, "attenuationColor": [0.5, 1.0, 1.0] },
            "KHR_materials_anisotropy": {
                "anisotropyStrength": 0.5, "anisotropyRotation": 1.5,
                "anisotropyTexture": { "index": 0, "texCoord": 1 }
            },
            "KHR_materials_clearcoat": {
                "clearcoatFactor": 0.5, "clearcoatTexture": { "index": 0, "texCoord": 1 },
                "clearcoatRoughnessFactor": 0.25, "clearcoatRoughnessTexture": { "index": 0, "texCoord": 1 },
                "clearcoatNormalTexture": { "index": 0, "texCoord": 1, "scale": 0.5 }
            },
            "KHR_materials_diffuse_transmission": {
                "diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": { "index": 0, "texCoord": 1 },
                "diffuseTransmissionColorFactor": [0.25, 0.25, 0.25],
                "diffuseTransmissionColorTexture": { "index": 0, "texCoord": 1 }
            },
            "KHR_materials_dispersion": { "dispersion": 0.5 },
            "KHR_materials_iridescence": {
                "iridescenceFactor": 0.5, "iridescenceTexture": { "index": 0, "texCoord": 1 },
                "iridescenceIor": 1.5, "iridescenceThicknessMinimum": 50.0, "iridescenceThicknessMaximum": 100.0,
                "iridescenceThicknessTexture": { "index": 0, "texCoord": 1 }
            },
            "KHR_materials_sheen": {
                "sheenColorFactor": [0.5, 0.5, 0.5], "sheenColorTexture": { "index": 0, "texCoord": 1 },
                "sheenRoughnessFactor": 0.25, "sheenRoughnessTexture": { "index": 0, "texCoord": 1 }
            }
        }
    });
    assert_eq!(json["materials"][0], expected);
}

#[test]
fn bad_scenes_are_refused_in_a_sentence() {
    let mut scene = one_triangle(Material::default());
    scene.meshes[0].positions[1].y = f32::NAN;
    let message = encode(&scene, "").unwrap_err().to_string();
    assert!(message.contains("mesh 0 (\"triangle\")") && message.contains("not finite"), "{message}");

    let mut scene = one_triangle(Material::default());
    scene.meshes[0].triangles.clear();
    assert!(matches!(encode(&scene, ""), Err(EncodeError::EmptyMesh { .. })));

    let sheared = Affine2::from_mat2_translation(Mat2::from_cols(Vec2::X, Vec2::ONE), Vec2::ZERO);
    let texture = TextureRef { texture: 0, uv_set: 0, transform: Some(sheared) };
    let scene = one_triangle(Material { base_color_texture: Some(texture), ..Material::default() });
    assert!(matches!(encode(&scene, ""), Err(EncodeError::Shear { .. })));
}
