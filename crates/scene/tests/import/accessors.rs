//! Accessors: every component type, strides, sparse parts, implied zeros, and everything out of
//! range.

use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

use crate::build::{BYTE, FLOAT, Gltf, SHORT, SQUARE, UBYTE, UINT, USHORT, floats, shorts, words};

/// Colours of the triangle's three vertices, loaded from an accessor of this type.
fn colors(bytes: &[u8], component: u32, kind: &str) -> Vec<Vec4> {
    let mut gltf = Gltf::triangle();
    let colors = gltf.accessor(bytes, component, kind, 3);
    gltf.json["accessors"][colors]["normalized"] = json!(component != FLOAT);
    gltf.primitive()["attributes"]["COLOR_0"] = json!(colors);
    gltf.load().meshes.remove(0).colors.expect("colours")
}

#[test]
fn colors_of_every_type() {
    let expected = [Vec4::new(0.0, 0.4, 1.0, 1.0), Vec4::ZERO.with_w(1.0), Vec4::ONE];
    let close = |got: Vec<Vec4>| {
        for (got, expected) in got.iter().zip(expected) {
            assert!((*got - expected).abs().max_element() < 1e-7, "{got} {expected}");
        }
        assert_eq!(got.len(), 3);
    };
    close(colors(&floats(&[0., 0.4, 1., 1., 0., 0., 0., 1., 1., 1., 1., 1.]), FLOAT, "VEC4"));
    close(colors(&floats(&[0., 0.4, 1., 0., 0., 0., 1., 1., 1.]), FLOAT, "VEC3"));
    close(colors(&[0, 102, 255, 255, 0, 0, 0, 255, 255, 255, 255, 255], UBYTE, "VEC4"));
    close(colors(&[0, 102, 255, 0, 0, 0, 255, 255, 255], UBYTE, "VEC3"));
    let m = u16::MAX;
    close(colors(&shorts(&[0, 26214, m, m, 0, 0, 0, m, m, m, m, m]), USHORT, "VEC4"));
    close(colors(&shorts(&[0, 26214, m, 0, 0, 0, m, m, m]), USHORT, "VEC3"));
}

#[test]
fn colors_are_clamped_and_never_nan() {
    let got = colors(&floats(&[2., -1., f32::NAN, 1., 0., 0., 0., f32::INFINITY, 1., 1., 1., 1.]), FLOAT, "VEC4");
    assert_eq!(got[0], Vec4::new(1.0, 0.0, 0.0, 1.0));
    assert_eq!(got[1].w, 1.0);
}

#[test]
fn normalised_texture_coordinates() {
    let mut gltf = Gltf::square();
    let texture = gltf.texture();
    let mut gltf = gltf.material(json!({"pbrMetallicRoughness": {"baseColorTexture": {"index": texture}}}));
    let uvs = gltf.accessor(&shorts(&[0, 65535, 32768, 0, 1, 2, 3, 4]), USHORT, "VEC2", 4);
    gltf.json["accessors"][uvs]["normalized"] = json!(true);
    gltf.primitive()["attributes"]["TEXCOORD_0"] = json!(uvs);
    let mesh = gltf.load().meshes.remove(0);
    assert_eq!(mesh.uvs[0][0], Vec2::new(0.0, 1.0));
    assert_eq!(mesh.uvs[0][1].x, 32768.0 / 65535.0);

    gltf.json["accessors"][uvs]["normalized"] = json!(false);
    gltf.refused(&["TEXCOORD_0 of mesh 0, primitive 0", "normalised"]);
}

#[test]
fn indices_of_every_type() {
    for (bytes, component) in
        [(vec![0, 1, 2, 0, 2, 3], UBYTE), (shorts(&[0, 1, 2, 0, 2, 3]), USHORT), (words(&[0, 1, 2, 0, 2, 3]), UINT)]
    {
        let mut gltf = Gltf::square();
        let indices = gltf.accessor(&bytes, component, "SCALAR", 6);
        gltf.primitive()["indices"] = json!(indices);
        assert_eq!(gltf.load().meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    }
    for component in [BYTE, SHORT, FLOAT] {
        let mut gltf = Gltf::square();
        let indices = gltf.accessor(&[0; 24], component, "SCALAR", 6);
        gltf.primitive()["indices"] = json!(indices);
        gltf.refused(&["indices of mesh 0, primitive 0", "unsigned integers"]);
    }
}

#[test]
fn strided_indices_are_read_though_the_specification_forbids_them() {
    let mut gltf = Gltf::square();
    let bytes: Vec<u8> = [0, 1, 2, 0, 2, 3_u16].iter().flat_map(|i| [i.to_le_bytes(), [0xAA; 2]].concat()).collect();
    let indices = gltf.accessor(&bytes, USHORT, "SCALAR", 6);
    let view = gltf.json["accessors"][indices]["bufferView"].as_u64().expect("view") as usize;
    gltf.json["bufferViews"][view]["byteStride"] = json!(4);
    gltf.primitive()["indices"] = json!(indices);
    assert_eq!(gltf.load().meshes[0].triangles, [[0, 1, 2], [0, 2, 3]]);
}

#[test]
fn interleaved_attributes() {
    let mut gltf = Gltf::triangle();
    let vertices: Vec<f32> = (0..3).flat_map(|i| [i as f32, 10.0 + i as f32, 20.0, 0., 0., 2.]).collect();
    let view = gltf.view(&floats(&vertices));
    gltf.json["bufferViews"][view]["byteStride"] = json!(24);
    let accessor = |offset: usize| json!({"bufferView": view, "byteOffset": offset, "componentType": FLOAT, "type": "VEC3", "count": 3});
    let positions = gltf.push("accessors", accessor(0));
    let normals = gltf.push("accessors", accessor(12));
    gltf.primitive()["attributes"] = json!({"POSITION": positions, "NORMAL": normals});
    let mesh = gltf.load().meshes.remove(0);
    assert_eq!(mesh.positions[2], Vec3::new(2.0, 12.0, 20.0));
    assert_eq!(mesh.normals, Some(vec![Vec3::Z; 3]));
}

#[test]
fn sparse_parts_replace_elements() {
    let mut gltf = Gltf::triangle();
    let at = gltf.view(&shorts(&[2, 0]));
    let values = gltf.view(&floats(&[7., 8., 9., 4., 5., 6.]));
    gltf.json["accessors"][0]["sparse"] = json!({
        "count": 2, "indices": {"bufferView": at, "componentType": USHORT}, "values": {"bufferView": values},
    });
    let positions = gltf.load().meshes.remove(0).positions;
    assert_eq!(positions, [Vec3::new(4.0, 5.0, 6.0), Vec3::X, Vec3::new(7.0, 8.0, 9.0)]);

    // The same on top of implied zeros.
    gltf.json["accessors"][0].as_object_mut().expect("object").remove("bufferView");
    assert_eq!(gltf.load().meshes[0].positions[1], Vec3::ZERO);

    let mut bad = gltf.clone();
    bad.json["accessors"][0]["sparse"]["count"] = json!(4);
    bad.refused(&["accessor 0 (POSITION of mesh 0, primitive 0)", "4 elements"]);
    let mut bad = gltf.clone();
    bad.json["accessors"][0]["count"] = json!(2);
    bad.refused(&["accessor 0", "element 2"]);
    let mut bad = gltf.clone();
    bad.json["accessors"][0]["sparse"]["indices"]["componentType"] = json!(FLOAT);
    bad.refused(&["accessor 0", "sparse indices"]);
    let mut bad = gltf.clone();
    bad.json["accessors"][0]["sparse"]["values"]["byteOffset"] = json!(4);
    bad.refused(&["accessor 0", "sparse values"]);
    let mut bad = gltf;
    bad.json["accessors"][0]["sparse"]["indices"]["bufferView"] = json!(99);
    bad.refused(&["accessor 0", "bufferView 99"]);
}

#[test]
fn no_buffer_view_means_zeros() {
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0].as_object_mut().expect("object").remove("bufferView");
    assert_eq!(gltf.load().meshes[0].positions, [Vec3::ZERO; 3]);
}

#[test]
fn ranges_beyond_the_limits_are_refused() {
    let edit = |edit: &dyn Fn(&mut Gltf), parts: &[&str]| {
        let mut gltf = Gltf::triangle();
        edit(&mut gltf);
        gltf.refused(parts);
    };
    let accessor = "accessor 0 (POSITION of mesh 0, primitive 0)";
    edit(&|g| g.json["accessors"][0]["count"] = json!(4), &[accessor, "4 elements of 12 bytes", "36 bytes"]);
    edit(&|g| g.json["accessors"][0]["count"] = json!(1_u64 << 31), &[" bytes"]);
    edit(&|g| g.json["accessors"][0]["count"] = json!(u64::MAX), &[accessor]);
    edit(&|g| g.json["accessors"][0]["byteOffset"] = json!(4), &[accessor, "byte 4"]);
    edit(&|g| g.json["accessors"][0]["byteOffset"] = json!(1_u64 << 53), &[accessor]);
    edit(&|g| g.json["accessors"][0]["byteOffset"] = json!(u64::MAX), &[accessor]);
    edit(&|g| g.json["accessors"][0]["bufferView"] = json!(1), &["accessor 0", "bufferView 1"]);
    // Cut to 32 bits this would be bufferView 0.
    edit(&|g| g.json["accessors"][0]["bufferView"] = json!(1_u64 << 32), &["bufferView 4294967296"]);
    edit(&|g| g.json["bufferViews"][0]["byteLength"] = json!(37), &["bufferView 0", "37 bytes"]);
    edit(&|g| g.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX), &["bufferView 0"]);
    edit(&|g| g.json["bufferViews"][0]["buffer"] = json!(1), &["bufferView 0", "buffer 1"]);
    edit(&|g| g.json["bufferViews"][0]["byteStride"] = json!(8), &[accessor, "stride of 8"]);
    edit(&|g| g.json["bufferViews"][0]["byteStride"] = json!(u64::MAX), &[accessor]);
    edit(&|g| g.json["buffers"][0]["byteLength"] = json!(100), &["buffer 0", "states 100 bytes", "only 36"]);
    edit(&|g| g.json["accessors"][0]["componentType"] = json!(5124), &["accessor 0", "5124"]);
    edit(&|g| g.json["accessors"][0]["componentType"] = json!(FLOAT as u64 + (1 << 32)), &["accessor 0"]);
    edit(&|g| g.json["accessors"][0]["type"] = json!("VEC9"), &["accessor 0", "VEC9"]);
    edit(&|g| g.json["accessors"][0]["type"] = json!("MAT4"), &["accessor 0", "MAT4"]);
    edit(&|g| g.json["accessors"][0]["type"] = json!("VEC2"), &[accessor, "VEC3 of floats"]);
    edit(&|g| g.primitive()["attributes"]["POSITION"] = json!(5), &["POSITION of mesh 0, primitive 0", "accessor 5"]);
}

#[test]
fn zeros_without_a_buffer_cannot_fill_memory() {
    let mut gltf = Gltf::triangle();
    gltf.json["accessors"][0] = json!({"componentType": FLOAT, "type": "VEC3", "count": 3_000_000_000_u32});
    gltf.refused(&["its geometry", "bytes of memory"]);
}

#[test]
fn attributes_must_have_one_element_per_vertex() {
    let mut gltf = Gltf::square();
    let normals = gltf.accessor(&floats(&SQUARE), FLOAT, "VEC3", 3);
    gltf.primitive()["attributes"]["NORMAL"] = json!(normals);
    gltf.refused(&["NORMAL of mesh 0, primitive 0", "3 elements", "POSITION has 4"]);
}

#[test]
fn whole_numbers_may_be_written_as_floats() {
    let mut gltf = Gltf::triangle();
    gltf.json["nodes"][0]["mesh"] = json!(0.0);
    gltf.json["accessors"][0]["count"] = json!(3.0);
    assert_eq!(gltf.load().triangle_count(), 1);
}
