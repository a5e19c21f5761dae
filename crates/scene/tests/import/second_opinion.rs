//! The crate `gltf` as a second opinion: its validator must accept what `surelight_scenes::glb`
//! encodes and what these tests build.

use std::path::Path;

use surelight_scene::{LoadOptions, load_bytes};
use surelight_scenes::{GALLERY, glb};

use crate::build::Gltf;

#[test]
fn gltf_validates_what_the_writer_writes() {
    for entry in GALLERY {
        let made = (entry.build)();
        let bytes = glb::encode(&made, entry.known).expect("writes");
        // Full validation of names, ranges and required fields; extensions stay as JSON.
        let other = validated(&bytes).unwrap_or_else(|e| panic!("{}: {e}", entry.name));
        let ours = load_bytes(&bytes, Path::new("made.glb"), &LoadOptions::default()).expect("loads");
        let placed: usize = other.nodes().filter_map(|n| n.mesh()).map(|m| m.primitives().count()).sum();
        assert_eq!(ours.instances.len(), placed, "{}", entry.name);
        let bin = other.blob.as_deref().unwrap_or_default();
        let mut triangles = 0;
        for mesh in other.nodes().filter_map(|n| n.mesh()) {
            for primitive in mesh.primitives() {
                let reader = primitive.reader(|buffer| (buffer.index() == 0).then_some(bin));
                let corners = match reader.read_indices() {
                    Some(indices) => indices.into_u32().count(),
                    None => reader.read_positions().map_or(0, |p| p.count()),
                };
                triangles += corners / 3;
            }
        }
        assert_eq!(ours.triangle_count(), triangles, "{}", entry.name);
    }
}

#[test]
fn gltf_validates_the_documents_of_these_tests() {
    // It requires the bounds of POSITION, which a reader does not need and the builder leaves out.
    let mut gltf = Gltf::square();
    for accessor in gltf.json["accessors"].as_array_mut().expect("array") {
        accessor["min"] = serde_json::json!([0, 0, 0]);
        accessor["max"] = serde_json::json!([1, 1, 0]);
    }
    validated(&gltf.glb()).expect("valid");
    // And it does refuse: an index past the end.
    gltf.json["nodes"][0]["mesh"] = serde_json::json!(7);
    assert!(validated(&gltf.glb()).is_err());
}

/// Parses and validates.
fn validated(glb: &[u8]) -> Result<gltf::Gltf, gltf::Error> {
    gltf::Gltf::from_slice(glb)
}
