//! The container, buffers and URIs.

use std::fs;
use std::path::Path;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::json;
use surelight_scene::{LoadError, LoadOptions, load, load_bytes};

use crate::build::{Gltf, warned, words};

fn text(gltf: &Gltf) -> Vec<u8> {
    gltf.json.to_string().into_bytes()
}

/// The triangle as .gltf whose buffer is at `uri`.
fn with_uri(uri: &str) -> Gltf {
    let mut gltf = Gltf::triangle();
    gltf.json["buffers"][0]["uri"] = json!(uri);
    gltf
}

/// Writes `gltf` and its buffer under `name` to a new folder and loads it from there.
fn load_beside(gltf: &Gltf, name: &str) -> Result<surelight_scene::Scene, LoadError> {
    let folder = tempfile::tempdir().expect("folder");
    let scenes = folder.path().join("scenes");
    fs::create_dir_all(scenes.join("sub")).expect("folder");
    fs::write(scenes.join(name), &gltf.bin).expect("buffer");
    fs::write(folder.path().join("outside.bin"), &gltf.bin).expect("buffer");
    fs::write(scenes.join("scene.gltf"), text(gltf)).expect("scene");
    load(&scenes.join("scene.gltf"), &LoadOptions::default())
}

#[test]
fn glb_loads() {
    let scene = Gltf::triangle().load();
    assert_eq!(scene.name, "made");
    assert_eq!(scene.triangle_count(), 1);
    assert_eq!(scene.warnings, Vec::<String>::new());
}

#[test]
fn the_content_decides_and_not_the_name() {
    let glb = Gltf::triangle().glb();
    assert!(load_bytes(&glb, Path::new("made.gltf"), &LoadOptions::default()).is_ok());
}

#[test]
fn data_uri_loads() {
    let bin = Gltf::triangle().bin;
    for uri in [
        format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bin)),
        format!("DATA:;base64,{}", BASE64_STANDARD.encode(&bin).trim_end_matches('=')),
        format!("data:;base64,{}#fragment", BASE64_STANDARD.encode(&bin)),
        // Without base64: bytes percent-encoded.
        format!("data:,{}", bin.iter().map(|b| format!("%{b:02x}")).collect::<String>()),
    ] {
        let file = text(&with_uri(&uri));
        let scene = load_bytes(&file, Path::new("made.gltf"), &LoadOptions::default()).expect("loads");
        assert_eq!(scene.meshes[0].positions[1].x, 1.0);
    }
}

#[test]
fn base64_may_have_line_breaks_and_lack_its_padding() {
    // Lengths of 0, 1 and 2 bytes beyond groups of three: with no, two and one = at the end.
    for extra in 0..3 {
        let mut bin = Gltf::triangle().bin;
        bin.extend(vec![7; extra]);
        let encoded = BASE64_STANDARD.encode(&bin);
        for (line, payload) in [("\n", &*encoded), ("\r\n ", encoded.trim_end_matches('=')), ("%0D%0A", &encoded)] {
            let lines: Vec<&str> = payload.as_bytes().chunks(10).map(|l| str::from_utf8(l).expect("ASCII")).collect();
            let mut gltf = with_uri(&format!("data:application/octet-stream;base64,{line}{}{line}", lines.join(line)));
            gltf.json["buffers"][0]["byteLength"] = json!(bin.len());
            let scene = load_bytes(&text(&gltf), Path::new("made.gltf"), &LoadOptions::default()).expect("loads");
            assert_eq!(scene.meshes[0].positions[1].x, 1.0);
        }
    }
}

#[test]
fn broken_data_uris_are_refused() {
    with_uri("data:application/octet-stream;base64,@@@@").refused(&["buffer 0", "base64"]);
    with_uri("data:nothing").refused(&["buffer 0", "comma"]);
    with_uri("data:,abc").refused(&["buffer 0", "states 36 bytes", "only 3"]);
}

#[test]
fn relative_uris_load() {
    for (uri, name) in [
        ("scene.bin", "scene.bin"),
        ("./scene.bin", "scene.bin"),
        ("sub/a%20b.bin", "sub/a b.bin"),
        ("sub/a b.bin", "sub/a b.bin"),
        ("%C3%BCml%C3%A4ut.bin", "ümläut.bin"),
        ("❤.bin", "❤.bin"),
        ("100%.bin", "100%.bin"),
        ("sub\\x.bin", "sub/x.bin"),
        ("sub/../scene.bin", "scene.bin"),
        // RFC 3986 resolves dot segments before anything is looked up: this folder need not exist.
        ("gone/../scene.bin", "scene.bin"),
        ("./sub/./%2e%2e/scene.bin", "scene.bin"),
        ("gone\\..\\scene.bin", "scene.bin"),
    ] {
        let scene = load_beside(&with_uri(uri), name).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(scene.triangle_count(), 1, "{uri}");
    }
}

#[test]
fn queries_and_fragments_are_no_part_of_the_path() {
    for (uri, name) in [
        ("scene.bin?v=2", "scene.bin"),
        ("scene.bin#a", "scene.bin"),
        ("scene.bin?v=2:3#../..", "scene.bin"),
        ("scene.bin?/../../x", "scene.bin"),
        ("sub/../scene.bin?v=2", "scene.bin"),
        ("a%23b.bin", "a#b.bin"),
        ("a%3Fb.bin?v=2", "a?b.bin"),
        // Not encoded, as exporters have it: the file with that name is the only one there.
        ("a#b.bin", "a#b.bin"),
        ("a?b.bin", "a?b.bin"),
        ("a%20b#c.bin", "a b#c.bin"),
    ] {
        let scene = load_beside(&with_uri(uri), name).unwrap_or_else(|e| panic!("{uri}: {e}"));
        assert_eq!(scene.triangle_count(), 1, "{uri}");
    }
    // Where both exist, the path follows the standard.
    let folder = tempfile::tempdir().expect("folder");
    let gltf = with_uri("a.bin#b");
    fs::write(folder.path().join("a.bin"), &gltf.bin).expect("buffer");
    fs::write(folder.path().join("a.bin#b"), [0]).expect("another file");
    fs::write(folder.path().join("scene.gltf"), text(&gltf)).expect("scene");
    load(&folder.path().join("scene.gltf"), &LoadOptions::default()).expect("loads");
    for uri in ["?v=2", "#a", "sub/..", "."] {
        let message = load_beside(&with_uri(uri), "scene.bin").expect_err("refused").to_string();
        assert!(message.contains("buffer 0") && message.contains("names no file"), "{uri}: {message}");
    }
}

#[test]
fn a_missing_file_names_its_near_match_of_another_case() {
    for (uri, name, meant) in [
        ("SCENE.BIN", "scene.bin", "scene.bin"),
        ("Sub/Scene.bin?v=2", "sub/scene.BIN", "sub/scene.BIN"),
        ("%C3%9Cml%C3%A4ut.bin", "ümläut.bin", "ümläut.bin"),
    ] {
        let error = load_beside(&with_uri(uri), name).expect_err("refused");
        let message = error.to_string();
        assert!(matches!(error, LoadError::Read { .. }), "{message}");
        assert!(message.ends_with(&format!("(did you mean {meant}?).")), "{message}");
    }
    let message = load_beside(&with_uri("scenes.bin"), "scene.bin").expect_err("refused").to_string();
    assert!(!message.contains("did you mean"), "{message}");
    // The same for images, which cost a warning.
    let folder = tempfile::tempdir().expect("folder");
    let mut gltf = Gltf::square();
    gltf.push("images", json!({"uri": "Tex.PNG"}));
    gltf.push("textures", json!({"source": 0}));
    let gltf = gltf.material(json!({"emissiveTexture": {"index": 0}}));
    fs::write(folder.path().join("tex.png"), [0]).expect("image");
    fs::write(folder.path().join("scene.glb"), gltf.glb()).expect("scene");
    let scene = load(&folder.path().join("scene.glb"), &LoadOptions::default()).expect("loads");
    warned(&scene, "(did you mean tex.png?)");
}

#[test]
fn uris_do_not_leave_the_folder() {
    for uri in [
        "../outside.bin",
        "%2e%2e/outside.bin",
        "..\\outside.bin",
        "%2E%2E%5Coutside.bin",
        "sub/../../outside.bin",
        "sub/../../outside.bin?v=2",
        "gone/../../scenes/scene.bin",
        "/etc/passwd",
        "%2Fetc%2Fpasswd",
        "\\\\server\\share",
        "C:/x.bin",
        "C%3A/x.bin",
        "file:///etc/passwd",
        "https://example.org/x.bin",
        "",
        "%ff%fe.bin",
        "a%00b.bin",
    ] {
        match load_beside(&with_uri(uri), "scene.bin") {
            Err(LoadError::Invalid { place, cause, .. }) => {
                assert!(place.starts_with("buffer 0"), "{uri}: {place} {cause}")
            }
            other => panic!("{uri}: {other:?}"),
        }
    }
}

#[cfg(unix)]
#[test]
fn links_do_not_leave_the_folder_either() {
    let folder = tempfile::tempdir().expect("folder");
    let scenes = folder.path().join("scenes");
    fs::create_dir(&scenes).expect("folder");
    let gltf = with_uri("link.bin");
    fs::write(folder.path().join("outside.bin"), &gltf.bin).expect("buffer");
    std::os::unix::fs::symlink("../outside.bin", scenes.join("link.bin")).expect("link");
    fs::write(scenes.join("scene.gltf"), text(&gltf)).expect("scene");
    let message = load(&scenes.join("scene.gltf"), &LoadOptions::default()).expect_err("refused").to_string();
    assert!(message.contains("link that leaves"), "{message}");
}

/// A scene in `project/scenes` whose buffer is in `project/buffers`, loaded with `allowed` folders.
fn load_outside(uri: &str, allowed: &[&str]) -> Result<surelight_scene::Scene, LoadError> {
    let project = tempfile::tempdir().expect("folder");
    for folder in ["scenes", "buffers/deep", "other"] {
        fs::create_dir_all(project.path().join(folder)).expect("folder");
    }
    let uri = uri.replace("{project}", &project.path().to_string_lossy());
    let gltf = with_uri(&uri);
    for file in ["buffers/a.bin", "buffers/deep/a.bin", "other/a.bin"] {
        fs::write(project.path().join(file), &gltf.bin).expect("buffer");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("../other/a.bin", project.path().join("buffers/out.bin")).expect("link");
        symlink("../buffers/a.bin", project.path().join("scenes/in.bin")).expect("link");
    }
    fs::write(project.path().join("scenes/scene.gltf"), text(&gltf)).expect("scene");
    let allow_outside = allowed.iter().map(|folder| project.path().join(folder)).collect();
    load(&project.path().join("scenes/scene.gltf"), &LoadOptions { allow_outside, ..LoadOptions::default() })
}

#[test]
fn allowed_folders_outside_the_scenes_own_are_read() {
    for uri in [
        "../buffers/a.bin",
        "..\\buffers\\a.bin",
        "../buffers/deep/a.bin?v=2",
        "gone/../../buffers/deep/../a.bin",
        #[cfg(unix)]
        "{project}/buffers/a.bin",
        #[cfg(unix)]
        "in.bin",
    ] {
        let message = load_outside(uri, &[]).expect_err("refused").to_string();
        assert!(message.contains("buffer 0") && message.contains("--allow-outside DIR"), "{uri}: {message}");
        for allowed in [&["buffers"][..], &["other", "buffers"], &["."], &["gone", "scenes/../buffers"]] {
            load_outside(uri, allowed).unwrap_or_else(|e| panic!("{uri}, {allowed:?}: {e}"));
        }
        let message = load_outside(uri, &["other"]).expect_err("refused").to_string();
        assert!(message.contains("folders of --allow-outside"), "{uri}: {message}");
    }
}

#[test]
fn nothing_leaves_the_allowed_folders() {
    for uri in [
        "../other/a.bin",
        "../buffers/../other/a.bin",
        "../buffers",
        "../gone.bin",
        "../../../../../../../../etc/passwd",
        "/etc/passwd",
        "{project}/buffers/../other/a.bin",
        "//server/buffers/a.bin",
        "file:///etc/passwd",
        #[cfg(unix)]
        "../buffers/out.bin",
    ] {
        match load_outside(uri, &["buffers"]) {
            Err(LoadError::Invalid { .. }) => {}
            other => panic!("{uri}: {other:?}"),
        }
    }
    let missing = load_outside("../buffers/gone.bin", &["buffers"]).expect_err("is not there");
    assert!(matches!(missing, LoadError::Read { .. }), "{missing}");
    let other_case = load_outside("../buffers/DEEP/A.bin", &["buffers"]).expect_err("is not there").to_string();
    assert!(
        cfg!(not(target_os = "linux")) || other_case.contains("did you mean ../buffers/deep/a.bin"),
        "{other_case}"
    );
}

#[test]
fn a_uri_that_names_a_folder_is_refused() {
    let error = load_beside(&with_uri("sub"), "scene.bin").expect_err("refused");
    assert!(error.to_string().contains("no regular file"), "{error}");
}

#[test]
fn missing_files_are_named() {
    let error = load(Path::new("/nowhere/scene.glb"), &LoadOptions::default()).expect_err("refused");
    assert!(matches!(error, LoadError::Read { .. }) && error.to_string().contains("/nowhere/scene.glb"), "{error}");
    let error = load_beside(&with_uri("gone.bin"), "scene.bin").expect_err("refused");
    assert!(matches!(error, LoadError::Read { .. }) && error.to_string().contains("gone.bin"), "{error}");
}

#[test]
fn an_unused_buffer_may_be_missing() {
    let mut gltf = Gltf::triangle();
    gltf.push("buffers", json!({"uri": "gone.bin", "byteLength": 1}));
    gltf.load();
}

#[test]
fn a_cut_glb_is_refused_at_every_length() {
    let glb = Gltf::triangle().glb();
    for length in 0..glb.len() {
        let error = load_bytes(&glb[..length], Path::new("cut.glb"), &LoadOptions::default());
        assert!(matches!(error, Err(LoadError::Format { .. })), "{length}: {error:?}");
    }
}

#[test]
fn strangers_are_refused() {
    for (bytes, part) in [
        (&b""[..], "empty"),
        (b"hello", "begins neither"),
        (b"{\"asset\": ", "JSON"),
        (b"{}", "asset"),
        (b"[1, 2]", "begins neither"),
        (b"glTF\x01\x00\x00\x00\x0c\x00\x00\x00", "version 1"),
        (b"{\"asset\": {\"version\": \"1.0\"}}", "version 1.0"),
        (b"{\"asset\": {\"version\": \"2.1\", \"minVersion\": \"2.1\"}}", "version 2.1"),
        (b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"mesh\": \"x\"}]}", "nodes[0].mesh"),
        (b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"mesh\": 1.5}]}", "nodes[0].mesh"),
        (b"{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [{\"translation\": [1, 2]}]}", "nodes[0].translation"),
        (b"{\"asset\": {\"version\": \"\xff\"}}", "UTF-8"),
    ] {
        let error = load_bytes(bytes, Path::new("odd.gltf"), &LoadOptions::default()).expect_err("refused");
        let message = error.to_string();
        assert!(matches!(error, LoadError::Format { .. }) && message.contains(part), "{message}");
        assert!(message.starts_with("odd.gltf is not"), "{message}");
    }
}

#[test]
fn deep_json_is_refused_and_not_recursed_into() {
    let text = format!("{{\"asset\": {{\"version\": \"2.0\"}}, \"extras\": {}", "[".repeat(1_000_000));
    assert!(load_bytes(text.as_bytes(), Path::new("deep.gltf"), &LoadOptions::default()).is_err());
}

#[test]
fn byte_order_mark_and_padding_are_no_fault() {
    let mut file = b"\xef\xbb\xbf".to_vec();
    file.extend(text(&Gltf::empty()));
    file.extend([0, 0]);
    let scene = load_bytes(&file, Path::new("made.gltf"), &LoadOptions::default()).expect("loads");
    warned(&scene, "no triangles");
}

#[test]
fn chunks_too_many_are_ignored_with_a_word() {
    let mut glb = Gltf::triangle().glb();
    glb.extend(words(&[4, 0x004E_4942, 7]));
    let total = glb.len() as u32;
    glb[8..12].copy_from_slice(&total.to_le_bytes());
    let scene = load_bytes(&glb, Path::new("made.glb"), &LoadOptions::default()).expect("loads");
    warned(&scene, "chunk");

    let mut glb = Gltf::triangle().glb();
    glb.push(0);
    let scene = load_bytes(&glb, Path::new("made.glb"), &LoadOptions::default()).expect("loads");
    warned(&scene, "after its stated end");

    // A chunk of another kind is to be skipped.
    let mut glb = Gltf::triangle().glb();
    glb.extend(words(&[4, 0x1234_5678, 7]));
    let total = glb.len() as u32;
    glb[8..12].copy_from_slice(&total.to_le_bytes());
    let scene = load_bytes(&glb, Path::new("made.glb"), &LoadOptions::default()).expect("loads");
    assert!(scene.warnings.is_empty());
}

#[test]
fn required_extensions_are_refused_by_name_and_optional_ones_warned_of() {
    let mut gltf = Gltf::triangle();
    gltf.json["extensionsUsed"] = json!(["EXT_nonsense", "KHR_materials_ior"]);
    let scene = gltf.load();
    warned(&scene, "EXT_nonsense");
    let named: Vec<_> = scene.extensions.iter().map(|e| (e.name.as_str(), e.required, e.honoured)).collect();
    assert_eq!(named, [("EXT_nonsense", false, false), ("KHR_materials_ior", false, true)]);

    gltf.json["extensionsRequired"] = json!(["KHR_materials_ior", "KHR_materials_volume", "KHR_materials_specular"]);
    assert!(gltf.load().extensions.iter().any(|e| e.required && e.honoured));

    gltf.json["extensionsRequired"] = json!(["EXT_nonsense"]);
    gltf.refused(&["requires the extension EXT_nonsense"]);
    gltf.json["extensionsRequired"] = json!(["EXT_texture_avif"]);
    gltf.refused(&["EXT_texture_avif", "gltf-transform"]);
}

#[test]
fn limits_are_stated() {
    let glb = Gltf::triangle().glb();
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("big.glb");
    fs::write(&path, &glb).expect("file");
    let options = LoadOptions { max_buffer_bytes: 100, ..LoadOptions::default() };
    let error = load(&path, &options).expect_err("refused");
    assert!(matches!(error, LoadError::TooLarge { .. }) && error.to_string().contains("100 bytes"), "{error}");
}
