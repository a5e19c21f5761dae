//! KHR_mesh_quantization, EXT_mesh_gpu_instancing and meshopt: each equals its plain counterpart.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use serde_json::{Value, json};
use surelight_scene::{LoadOptions, Mesh, Scene, load_bytes};

use crate::build::{BYTE, FLOAT, Gltf, SHORT, UBYTE, USHORT, floats, shorts};

/// A file of assets/gltf.
pub(crate) fn asset(name: &str) -> Vec<u8> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/gltf");
    std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[track_caller]
pub(crate) fn loaded(bytes: &[u8]) -> Scene {
    let scene = load_bytes(bytes, "made.glb".as_ref(), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(scene.warnings, Vec::<String>::new());
    scene
}

fn uses(gltf: &mut Gltf, name: &str) {
    gltf.json["extensionsUsed"] = json!([name]);
    gltf.json["extensionsRequired"] = json!([name]);
}

/// The square with an emissive texture, its vertices made by `edit`.
fn square(edit: impl Fn(&mut Gltf) -> Value) -> Mesh {
    let mut gltf = Gltf::square();
    uses(&mut gltf, "KHR_mesh_quantization");
    let texture = gltf.texture();
    let mut gltf = gltf.material(json!({"emissiveTexture": {"index": texture}}));
    let indices = gltf.primitive()["indices"].clone();
    gltf.primitive()["attributes"] = edit(&mut gltf);
    gltf.primitive()["indices"] = indices;
    gltf.load().meshes.remove(0)
}

#[test]
fn a_quantised_mesh_equals_its_float_counterpart() {
    let signed = |values: &[i8]| values.iter().map(|&v| v as u8).collect::<Vec<u8>>();
    let expected = square(|gltf| {
        let p = gltf.accessor(&floats(&[0., 0., -2., 100., 0., 7., 100., 50., 1., 0., 50., 0.]), FLOAT, "VEC3", 4);
        let n = gltf.accessor(&floats(&[0., 0., 1., 1., 0., 0., 0., -1., 0., 0., 0., 1.]), FLOAT, "VEC3", 4);
        let t = gltf.accessor(&floats(&[-3., 5., 0., 120., 7., -128., 1., 1.]), FLOAT, "VEC2", 4);
        json!({"POSITION": p, "NORMAL": n, "TEXCOORD_0": t})
    });
    // Bytes and shorts as stored, three of them padded to four.
    let bytes = square(|gltf| {
        let p = gltf.view(&signed(&[0, 0, -2, 0, 100, 0, 7, 0, 100, 50, 1, 0, 0, 50, 0, 0]));
        let n = gltf.view(&signed(&[0, 0, 127, 0, 127, 0, 0, 0, 0, -127, 0, 0, 0, 0, 127, 0]));
        let t = gltf.accessor(&signed(&[-3, 5, 0, 120, 7, -128, 1, 1]), BYTE, "VEC2", 4);
        for view in [p, n] {
            gltf.json["bufferViews"][view]["byteStride"] = json!(4);
        }
        let p = gltf.push("accessors", json!({"bufferView": p, "componentType": BYTE, "type": "VEC3", "count": 4}));
        let n = gltf.push(
            "accessors",
            json!({"bufferView": n, "componentType": BYTE, "type": "VEC3", "count": 4, "normalized": true}),
        );
        json!({"POSITION": p, "NORMAL": n, "TEXCOORD_0": t})
    });
    assert_eq!(bytes, expected);
    let short = |v: i16| v as u16;
    let shorts = square(|gltf| {
        let p: Vec<u16> = [0, 0, -2, 100, 0, 7, 100, 50, 1, 0, 50, 0].map(short).to_vec();
        let p = gltf.accessor(&shorts(&p), SHORT, "VEC3", 4);
        let n: Vec<u16> = [0, 0, 32767, 32767, 0, 0, 0, -32767, 0, 0, 0, 32767].map(short).to_vec();
        let n = gltf.accessor(&shorts(&n), SHORT, "VEC3", 4);
        gltf.json["accessors"][n]["normalized"] = json!(true);
        let t = gltf.accessor(&shorts(&[-3, 5, 0, 120, 7, -128, 1, 1].map(short)), SHORT, "VEC2", 4);
        json!({"POSITION": p, "NORMAL": n, "TEXCOORD_0": t})
    });
    assert_eq!(shorts, expected);
}

#[test]
fn normalised_positions_are_fractions() {
    let mesh = square(|gltf| {
        let p = gltf.accessor(&[0, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 51], UBYTE, "VEC3", 4);
        gltf.json["accessors"][p]["normalized"] = json!(true);
        let t = gltf.accessor(&shorts(&[0, 65535, 13107, 0, 0, 0, 1, 1]), USHORT, "VEC2", 4);
        json!({"POSITION": p, "TEXCOORD_0": t})
    });
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::new(1., 1., 0.), Vec3::new(0., 1., 0.2)]);
    assert_eq!(mesh.uvs[0][1], Vec2::new(13107.0, 0.0));
}

#[test]
fn integers_need_the_extension() {
    let mut gltf = Gltf::triangle();
    let p = gltf.accessor(&shorts(&[0, 0, 0, 1, 0, 0, 0, 1, 0]), USHORT, "VEC3", 3);
    gltf.primitive()["attributes"]["POSITION"] = json!(p);
    gltf.refused(&["POSITION of mesh 0, primitive 0", "not a VEC3 of floats"]);
    uses(&mut gltf, "KHR_mesh_quantization");
    assert_eq!(gltf.load().triangle_count(), 1);
    // Directions have signs.
    gltf.primitive()["attributes"]["NORMAL"] = json!(p);
    gltf.refused(&["NORMAL of mesh 0, primitive 0", "not a VEC3 of floats"]);
}

/// The triangle on a moved node, placed three times by the extension.
fn instanced() -> Gltf {
    let mut gltf = Gltf::triangle();
    uses(&mut gltf, "EXT_mesh_gpu_instancing");
    let translation = gltf.accessor(&floats(&[1., 2., 3., 0., 0., 0., -5., 0., 0.]), FLOAT, "VEC3", 3);
    let half = (0.5_f32.sqrt() * 32767.0) as i16 as u16;
    let rotation = gltf.accessor(&shorts(&[0, 0, 0, 32767, 0, 0, half, half, 32767, 0, 0, 0]), SHORT, "VEC4", 3);
    gltf.json["accessors"][rotation]["normalized"] = json!(true);
    let scale = gltf.accessor(&floats(&[1., 1., 1., 2., 3., 4., 1., 1., -1.]), FLOAT, "VEC3", 3);
    gltf.json["nodes"][0] = json!({
        "mesh": 0, "translation": [10, 0, 0], "scale": [2, 2, 2],
        "extensions": {"EXT_mesh_gpu_instancing": {
            "attributes": {"TRANSLATION": translation, "ROTATION": rotation, "SCALE": scale, "_ID": 99}
        }},
    });
    gltf
}

#[test]
fn instances_are_placed_like_nodes() {
    let scene = instanced().load();
    assert!(scene.warnings.is_empty());
    assert_eq!((scene.meshes.len(), scene.instances.len()), (1, 3));
    let parent = DAffine3::from_translation(DVec3::X * 10.0) * DAffine3::from_scale(DVec3::splat(2.0));
    let turns =
        [DQuat::IDENTITY, DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2), DQuat::from_xyzw(1., 0., 0., 0.)];
    let scales = [DVec3::ONE, DVec3::new(2., 3., 4.), DVec3::new(1., 1., -1.)];
    let translations = [DVec3::new(1., 2., 3.), DVec3::ZERO, DVec3::new(-5., 0., 0.)];
    for i in 0..3 {
        let expected = parent * DAffine3::from_scale_rotation_translation(scales[i], turns[i], translations[i]);
        assert!(scene.instances[i].to_world.abs_diff_eq(expected, 1e-6), "{i}: {:?}", scene.instances[i].to_world);
    }
}

#[test]
fn broken_instances_are_refused_and_limited() {
    let edit = |change: &dyn Fn(&mut Gltf), parts: &[&str]| {
        let mut gltf = instanced();
        change(&mut gltf);
        gltf.refused(parts);
    };
    let attributes = |g: &mut Gltf| g.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"].take();
    edit(&|g| drop(attributes(g)), &["node 0", "EXT_mesh_gpu_instancing"]);
    edit(&|g| g.json["accessors"][1]["count"] = json!(2), &["node 0", "2 and 3"]);
    edit(&|g| g.json["accessors"][1]["count"] = json!(4_000_000_000_u32), &["node 0", "instances"]);
    edit(&|g| g.json["accessors"][2]["normalized"] = json!(false), &["node 0", "neither floats"]);
    edit(&|g| g.json["accessors"][3]["bufferView"] = json!(77), &["accessor 3", "bufferView 77"]);
    let options = LoadOptions { max_instances: 2, ..LoadOptions::default() };
    let message = load_bytes(&instanced().glb(), "made.glb".as_ref(), &options).expect_err("refused").to_string();
    assert!(message.contains("node 0 has 3 instances"), "{message}");
}

/// Compressed meshes equal the plain ones beside them in the file.
#[track_caller]
pub(crate) fn equals_its_counterpart(scene: &Scene) {
    let half = scene.meshes.len() / 2;
    assert!(half >= 1 && scene.meshes.len() == 2 * half);
    for (packed, plain) in scene.meshes[..half].iter().zip(&scene.meshes[half..]) {
        assert_eq!((packed.name.as_str(), plain.name.as_str()), ("compressed", "plain"));
        assert!(packed.triangles.len() > 700);
        assert_eq!(packed.positions, plain.positions);
        // The triangle codec may begin a triangle with another corner.
        let turned = |t: &[u32; 3]| {
            let first = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
            [t[first], t[(first + 1) % 3], t[(first + 2) % 3]]
        };
        assert!(packed.triangles.iter().map(turned).eq(plain.triangles.iter().map(turned)));
        assert_eq!(packed.uvs, plain.uvs);
        assert_eq!(packed.normals.is_some(), plain.normals.is_some());
        for (a, b) in packed.normals.iter().flatten().zip(plain.normals.iter().flatten()) {
            // The decoders may round the last bit of a byte differently.
            assert!((*a - *b).length() < 0.012, "{a} {b}");
        }
    }
}

#[test]
fn meshopt_equals_the_plain_file() {
    // Encoded by meshoptimizer 0.30: vertex codec 0 and 1, triangles, index sequences, octahedral
    // and exponential filters.
    for name in ["meshopt-ext.glb", "meshopt-khr.glb"] {
        equals_its_counterpart(&loaded(&asset(name)));
    }
}

#[test]
fn damaged_meshopt_streams_are_refused_or_decoded_and_never_panic() {
    for name in ["meshopt-ext.glb", "meshopt-khr.glb"] {
        let whole = asset(name);
        let (mut refused, mut seed) = (0, 1_u32);
        let begin = whole.windows(4).position(|w| w == b"BIN\0").expect("chunk") + 4;
        for _ in 0..3000 {
            let mut bytes = whole.clone();
            for _ in 0..3 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let at = begin + (seed >> 8) as usize % 4000;
                bytes[at] = bytes[at].wrapping_add((seed >> 3) as u8 | 1);
            }
            refused += usize::from(load_bytes(&bytes, "made.glb".as_ref(), &LoadOptions::default()).is_err());
        }
        assert!(refused > 100, "{name}: {refused}");
    }
}

#[test]
fn meshopt_counts_alone_take_no_memory() {
    for (from, to) in [("\"count\":441", "\"count\":999"), ("\"count\":2400", "\"count\":9900")] {
        let text = String::from_utf8_lossy(&asset("meshopt-ext.glb")).len();
        assert!(text > 0);
        let mut bytes = asset("meshopt-ext.glb");
        let at = bytes.windows(from.len()).position(|w| w == from.as_bytes()).expect(from);
        bytes[at..at + from.len()].copy_from_slice(to.as_bytes());
        assert!(load_bytes(&bytes, "made.glb".as_ref(), &LoadOptions::default()).is_err());
    }
    let options = LoadOptions { max_geometry_bytes: 1000, ..LoadOptions::default() };
    let message =
        load_bytes(&asset("meshopt-ext.glb"), "made.glb".as_ref(), &options).expect_err("refused").to_string();
    assert!(message.contains("bytes"), "{message}");
}
