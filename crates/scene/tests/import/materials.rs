//! Materials and their extensions.

use serde_json::{Value, json};
use surelight_scene::{AlphaMode, Anisotropy, Clearcoat, Iridescence, Material, Sheen, Volume};

use crate::build::{Gltf, warned};

fn material(json: Value) -> Material {
    let mut scene = Gltf::square().material(json).load();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    scene.materials.remove(0)
}

fn extended(name: &str, json: Value) -> Material {
    material(json!({"extensions": {name: json}}))
}

#[test]
fn defaults_are_gltfs() {
    assert_eq!(material(json!({})), Material::default());
    let scene = Gltf::triangle().load();
    assert_eq!(scene.materials, [Material::default()]);
}

#[test]
fn factors() {
    let got = material(json!({
        "name": "m", "doubleSided": true, "emissiveFactor": [0.1, 0.2, 0.3],
        "pbrMetallicRoughness": {"baseColorFactor": [0.4, 0.5, 0.6, 0.7], "metallicFactor": 0.8, "roughnessFactor": 0.9},
    }));
    let expected = Material {
        name: "m".into(),
        base_color: [0.4, 0.5, 0.6, 0.7],
        metallic: 0.8,
        roughness: 0.9,
        emissive: [0.1, 0.2, 0.3],
        double_sided: true,
        ..Material::default()
    };
    assert_eq!(got, expected);
}

#[test]
fn alpha_modes() {
    assert_eq!(material(json!({"alphaMode": "OPAQUE", "alphaCutoff": 0.1})).alpha_mode, AlphaMode::Opaque);
    assert_eq!(material(json!({"alphaMode": "MASK"})).alpha_mode, AlphaMode::Mask(0.5));
    assert_eq!(material(json!({"alphaMode": "MASK", "alphaCutoff": 1.5})).alpha_mode, AlphaMode::Mask(1.5));
    assert_eq!(material(json!({"alphaMode": "BLEND"})).alpha_mode, AlphaMode::Blend);
    let scene = Gltf::square().material(json!({"alphaMode": "SHINY"})).load();
    assert_eq!(scene.materials[0].alpha_mode, AlphaMode::Opaque);
    warned(&scene, "SHINY");
}

#[test]
fn factors_out_of_range_are_clamped_with_a_warning() {
    let scene = Gltf::square()
        .material(json!({
            "name": "wild", "emissiveFactor": [-1, 0, 0],
            "pbrMetallicRoughness": {"baseColorFactor": [5, 1, 1, 1], "metallicFactor": -3, "roughnessFactor": 1e300},
        }))
        .load();
    let got = &scene.materials[0];
    assert_eq!((got.base_color, got.metallic, got.roughness, got.emissive), ([1.0; 4], 0.0, 1.0, [0.0; 3]));
    assert_eq!(scene.warnings.len(), 4);
    assert!(scene.warnings.iter().all(|w| w.contains("material 0 (\"wild\")")), "{:?}", scene.warnings);
}

#[test]
fn emissive_strength() {
    let got = material(json!({
        "emissiveFactor": [1, 0.5, 0], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 20}},
    }));
    assert_eq!(got.emissive, [20.0, 10.0, 0.0]);
}

#[test]
fn ior() {
    assert_eq!(extended("KHR_materials_ior", json!({})).ior, 1.5);
    assert_eq!(extended("KHR_materials_ior", json!({"ior": 1.33})).ior, 1.33);
    assert_eq!(extended("KHR_materials_ior", json!({"ior": 0})).ior, 0.0);
    let scene = Gltf::square().material(json!({"extensions": {"KHR_materials_ior": {"ior": 0.5}}})).load();
    assert_eq!(scene.materials[0].ior, 1.0);
    warned(&scene, "ior of material 0 is 0.5");
}

#[test]
fn specular() {
    let got = extended("KHR_materials_specular", json!({"specularFactor": 0.25, "specularColorFactor": [1, 2, 3]}));
    assert_eq!((got.specular, got.specular_color), (0.25, [1.0, 2.0, 3.0]));
}

#[test]
fn transmission() {
    assert_eq!(extended("KHR_materials_transmission", json!({"transmissionFactor": 0.75})).transmission, 0.75);
    assert_eq!(extended("KHR_materials_transmission", json!({})).transmission, 0.0);
}

#[test]
fn volume() {
    let volume = |json| extended("KHR_materials_volume", json).volume;
    assert_eq!(volume(json!({"attenuationDistance": 2})), None, "no thickness is a thin wall");
    assert_eq!(
        volume(json!({"thicknessFactor": 3, "attenuationDistance": 2, "attenuationColor": [0.1, 0.2, 0.3]})),
        Some(Volume { attenuation_distance: 2.0, attenuation_color: [0.1, 0.2, 0.3] })
    );
    let clear = Some(Volume { attenuation_distance: f32::INFINITY, attenuation_color: [1.0; 3] });
    assert_eq!(volume(json!({"thicknessFactor": 1e-3})), clear);
    for distance in [0.0, -1.0, 1e-300] {
        let json = json!({"thicknessFactor": 1, "attenuationDistance": distance});
        let scene = Gltf::square().material(json!({"extensions": {"KHR_materials_volume": json}})).load();
        assert_eq!(scene.materials[0].volume, clear);
        warned(&scene, "attenuationDistance");
    }
}

#[test]
fn unlit() {
    assert!(extended("KHR_materials_unlit", json!({})).unlit);
}

#[test]
fn mistyped_extensions_are_ignored_with_a_word() {
    for (name, json) in [
        ("KHR_materials_ior", json!({"ior": "1.3"})),
        ("KHR_materials_specular", json!({"specularColorFactor": [1]})),
        ("KHR_materials_volume", json!(7)),
        ("KHR_materials_transmission", json!({"transmissionTexture": {"index": -1}})),
    ] {
        let scene = Gltf::square().material(json!({"extensions": {name: json}})).load();
        assert_eq!(scene.materials[0], Material::default());
        warned(&scene, name);
    }
}

#[test]
fn only_used_materials_are_kept_and_the_default_comes_last() {
    let mut gltf = Gltf::square();
    for name in ["unused", "b", "also unused", "a"] {
        gltf.push("materials", json!({"name": name}));
    }
    let mut second = gltf.primitive().clone();
    second["material"] = json!(1);
    let mut third = second.clone();
    third["material"] = json!(99);
    gltf.primitive()["material"] = json!(3);
    gltf.json["meshes"][0]["primitives"] = json!([gltf.primitive().clone(), second, third]);
    let scene = gltf.load();
    let names: Vec<_> = scene.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["b", "a", ""]);
    assert_eq!(scene.meshes.iter().map(|m| m.material).collect::<Vec<_>>(), [1, 0, 2]);
    warned(&scene, "material 99");
}

#[test]
fn layers() {
    let coat = json!({"clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25});
    let coat = extended("KHR_materials_clearcoat", coat).clearcoat;
    assert_eq!(coat, Clearcoat { factor: 0.5, roughness: 0.25, ..Clearcoat::default() });
    let sheen = json!({"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.5});
    let sheen = extended("KHR_materials_sheen", sheen).sheen;
    assert_eq!(sheen, Sheen { color: [0.1, 0.2, 0.3], roughness: 0.5, ..Sheen::default() });
    let grain = json!({"anisotropyStrength": 0.5, "anisotropyRotation": -1.5});
    let grain = extended("KHR_materials_anisotropy", grain).anisotropy;
    assert_eq!(grain, Anisotropy { strength: 0.5, rotation: -1.5, texture: None });
    let film = json!({"iridescenceFactor": 0.5, "iridescenceIor": 1.8, "iridescenceThicknessMinimum": 10,
        "iridescenceThicknessMaximum": 20});
    let film = extended("KHR_materials_iridescence", film).iridescence;
    let expected =
        Iridescence { factor: 0.5, ior: 1.8, thickness_minimum: 10.0, thickness_maximum: 20.0, ..film.clone() };
    assert_eq!((&film, film.texture.is_none()), (&expected, true));
    let leaf = json!({"diffuseTransmissionFactor": 0.25, "diffuseTransmissionColorFactor": [0.5, 1, 0]});
    let leaf = extended("KHR_materials_diffuse_transmission", leaf).diffuse_transmission;
    assert_eq!((leaf.factor, leaf.color), (0.25, [0.5, 1.0, 0.0]));
    assert_eq!(extended("KHR_materials_dispersion", json!({"dispersion": 0.36})).dispersion, 0.36);
    // Their defaults do nothing.
    for name in ["dispersion", "clearcoat", "sheen", "anisotropy", "iridescence", "diffuse_transmission"] {
        assert_eq!(extended(&format!("KHR_materials_{name}"), json!({})), Material::default(), "{name}");
    }
}

#[test]
fn layers_out_of_range_are_clamped_with_a_warning() {
    let scene = Gltf::square()
        .material(json!({"extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 2},
            "KHR_materials_sheen": {"sheenRoughnessFactor": -1},
            "KHR_materials_anisotropy": {"anisotropyStrength": 5},
            "KHR_materials_iridescence": {"iridescenceIor": 0.5, "iridescenceThicknessMaximum": 1e300},
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 7},
        }}))
        .load();
    let m = &scene.materials[0];
    assert_eq!((m.clearcoat.factor, m.sheen.roughness, m.anisotropy.strength), (1.0, 0.0, 1.0));
    assert_eq!((m.iridescence.ior, m.iridescence.thickness_maximum, m.diffuse_transmission.factor), (1.0, 1e6, 1.0));
    assert_eq!(scene.warnings.len(), 6, "{:?}", scene.warnings);
}

/// Anisotropy needs tangents: the file's, or generated ones along the first texture coordinates.
#[test]
fn anisotropic_materials_get_tangents() {
    let grain = json!({"extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5}}});
    let scene = Gltf::square().material(grain).load();
    let tangents = scene.meshes[0].tangents.as_ref().expect("tangents are made");
    let [a, b] = [1, 0].map(|k| scene.meshes[0].triangles[0][k] as usize);
    let (uvs, positions) = (&scene.meshes[0].uvs[0], &scene.meshes[0].positions);
    assert!(uvs[a] != uvs[b] && positions[a] != positions[b]);
    // Along u: the derivative of position by u, found from the first triangle's edges.
    let t = scene.meshes[0].triangles[0].map(|v| v as usize);
    let (d1, d2) = (uvs[t[1]] - uvs[t[0]], uvs[t[2]] - uvs[t[0]]);
    let (p1, p2) = (positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    let along_u = ((p1 * d2.y - p2 * d1.y) / d1.perp_dot(d2)).normalize();
    for tangent in tangents {
        assert!(tangent.truncate().distance(along_u) < 1e-5, "{tangent} instead of {along_u}");
    }
    assert!(Gltf::square().material(json!({})).load().meshes[0].tangents.is_none());
}
