//! Parts of a file: variants and moments of animations, by `surelight measure`.

mod common;

use common::Folder;

/// A red triangle before the camera, green as a variant, that an animation takes ten metres away
/// within a second.
const SCENE: &str = r#"{
"asset": {"version": "2.0"},
"extensionsUsed": ["KHR_materials_variants"],
"extensions": {"KHR_materials_variants": {"variants": [{"name": "green"}]}},
"scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"materials": [
  {"emissiveFactor": [1, 0, 0], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}},
  {"emissiveFactor": [0, 1, 0], "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]}}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0,
  "extensions": {"KHR_materials_variants": {"mappings": [{"material": 1, "variants": [0]}]}}}]}],
"animations": [{"name": "away", "samplers": [{"input": 1, "output": 2}],
  "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
"accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]},
  {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]},
  {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
"bufferViews": [
  {"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
  {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
"buffers": [{"byteLength": 68, "uri": "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAACBBAAAAAAAAAAA="}]
}"#;

/// Luminance along −Z.
fn seen(options: &str) -> f64 {
    let folder = Folder::new();
    std::fs::write(folder.path("a.gltf"), SCENE).unwrap();
    let line = format!("measure a.gltf --point 0,0,3 --direction 0,0,-1 --max-bounces 0 --spp 64 --json {options}");
    let report: serde_json::Value = serde_json::from_str(&folder.run(&line).succeeded().stdout).unwrap();
    report["luminance"]["value"].as_f64().unwrap()
}

#[test]
fn variants_and_moments_are_chosen() {
    for (options, luminance) in [
        ("", 0.2126),
        ("--variant green", 0.7152),
        ("--variant 0", 0.7152),
        ("--animation away", 0.2126),
        ("--animation away --at 0.01", 0.2126),
        ("--animation 0 --at 0.5 --variant green", 0.0),
    ] {
        assert!((seen(options) - luminance).abs() < 1e-5, "{options}: {} instead of {luminance}", seen(options));
    }
}

#[test]
fn unknown_selections_are_reported() {
    let folder = Folder::new();
    std::fs::write(folder.path("a.gltf"), SCENE).unwrap();
    let line = "measure a.gltf --point 0,0,3 --direction 0,0,-1";
    folder.run(&format!("{line} --variant blue")).failed_with(&["a.gltf", "blue"]);
    folder.run(&format!("{line} --animation home")).failed_with(&["a.gltf", "home"]);
    assert_eq!(folder.run(&format!("{line} --at 1")).code, Some(2));
}
