//! Bad input: one sentence that names file and cause, exit code 1, and no file left behind.

mod common;

use std::fs;

use common::{Folder, cornell_box};

/// A one-triangle glTF whose material shows `image`.
fn gltf_with_image(image: &str) -> String {
    serde_json::json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}], "scene": 0,
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": image}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteLength": 24},
        ],
        "buffers": [{"uri": "triangle.bin", "byteLength": 36}],
    })
    .to_string()
}

fn triangle() -> Vec<u8> {
    [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn a_missing_scene_is_named() {
    let folder = Folder::new();
    for command in ["", "render ", "info "] {
        folder.run(&format!("{command}gone.glb")).failed_with(&["gone.glb"]);
    }
    assert!(folder.files().is_empty());
}

#[test]
fn a_truncated_glb_is_reported() {
    let folder = Folder::new();
    let whole = fs::read(cornell_box()).unwrap();
    for length in [0, 4, 11, 12, 20, whole.len() / 2, whole.len() - 1] {
        fs::write(folder.path("cut.glb"), &whole[..length]).unwrap();
        folder.run("cut.glb --size 8x8 --spp 1").failed_with(&["cut.glb"]);
    }
    assert_eq!(folder.files(), ["cut.glb"]);
}

#[test]
fn files_other_than_gltf_are_reported() {
    let folder = Folder::new();
    fs::write(folder.path("a.glb"), "This is a poem.").unwrap();
    fs::write(folder.path("a.gltf"), "{\"asset\": {\"version\": \"1.0\"}}").unwrap();
    fs::create_dir(folder.path("folder.glb")).unwrap();
    folder.run("a.glb").failed_with(&["a.glb"]);
    folder.run("a.gltf").failed_with(&["a.gltf"]);
    folder.run("folder.glb").failed_with(&["folder.glb"]);
    assert_eq!(folder.files(), ["a.glb", "a.gltf", "folder.glb"]);
}

/// Messages name the kind of other files, for scenes and environments.
#[test]
fn files_of_the_wrong_kind_are_recognised() {
    let folder = Folder::new();
    for (bytes, words) in [
        (&b""[..], "it is empty"),
        (b"PK\x03\x04 and more", "ZIP archive: unpack it first"),
        (b"\x1f\x8b\x08 and more", "gzip"),
        (b"BLENDER-v300", "export it as glTF 2.0"),
        (b"Kaydara FBX Binary", "FBX"),
        (b"version https://git-lfs.github.com/spec/v1", "git lfs pull"),
        (b"\xff\xfe{\0", "save it as UTF-8"),
        (b"\x89PNG\r\n\x1a\n", "a PNG image"),
    ] {
        fs::write(folder.path("a.glb"), bytes).unwrap();
        folder.run("a.glb").failed_with(&["a.glb", words]);
    }
    for (bytes, words) in
        [(&b""[..], "it is empty"), (b"\x89PNG\r\n\x1a\n", "a PNG image"), (b"\xff\xd8\xff\xe0", "a JPEG image")]
    {
        fs::write(folder.path("e.hdr"), bytes).unwrap();
        folder.run("{box} --env e.hdr").failed_with(&["e.hdr", words]);
    }
    fs::write(folder.path("e.exr"), b"\x89PNG\r\n\x1a\n").unwrap();
    folder.run("compare e.exr e.exr").failed_with(&["e.exr", "it is not an OpenEXR file"]);
}

/// A device has no end, and reading it would fill the memory.
#[cfg(target_os = "linux")]
#[test]
fn devices_are_not_read() {
    let folder = Folder::new();
    folder.run("/dev/zero").failed_with(&["/dev/zero", "it is a device"]);
    folder.run("{box} --env /dev/zero").failed_with(&["/dev/zero", "it is a device"]);
}

/// Beyond `ulimit -f`, writing fails with a sentence and leaves no half file; by default the system
/// kills the program.
#[cfg(unix)]
#[test]
fn the_limit_on_file_sizes_is_reported() {
    let folder = Folder::new();
    let script = "ulimit -f 1 && exec \"$0\" \"$@\"";
    let program = env!("CARGO_BIN_EXE_surelight");
    let scene = cornell_box();
    let output = std::process::Command::new("sh")
        .args(["-c", script, program, scene.to_str().unwrap(), "--size", "64x64", "--spp", "2", "--quiet"])
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    common::Ran::from(output).failed_with(&["cornell-box.exr", "limit on file sizes"]);
    assert!(!folder.files().iter().any(|name| name.ends_with(".part")), "{:?}", folder.files());
}

/// Names of files may hold escape sequences, which the terminal must not obey.
#[cfg(unix)]
#[test]
fn control_characters_in_names_do_not_reach_the_terminal() {
    let folder = Folder::new();
    let name = "a\u{1b}[31mb.glb";
    for there in [false, true] {
        if there {
            fs::copy(cornell_box(), folder.path(name)).unwrap();
        }
        let output = folder.command([name, "--size", "8x8", "--spp", "1"]).output().unwrap();
        let text = [output.stdout, output.stderr].concat();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(output.status.success(), there, "{text}");
        assert!(!text.contains('\u{1b}') && text.contains("a\\u{1b}[31mb"), "{text:?}");
    }
    assert!(folder.path("a\u{1b}[31mb.png").is_file());
}

/// A picture that is gone costs a warning, not the render; a buffer that is gone costs the render.
#[test]
fn a_missing_image_is_a_warning_and_a_missing_buffer_an_error() {
    let folder = Folder::new();
    fs::write(folder.path("a.gltf"), gltf_with_image("wood.png")).unwrap();
    folder.run("a.gltf --size 8x8 --spp 1").failed_with(&["triangle.bin"]);
    assert_eq!(folder.files(), ["a.gltf"]);

    fs::write(folder.path("triangle.bin"), triangle()).unwrap();
    let ran = folder.run("a.gltf --size 8x8 --spp 1 --json").succeeded();
    let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let warnings = summary["warnings"].to_string();
    assert!(warnings.contains("wood.png"), "{warnings}");
    // No camera and no light in that file: both are reported.
    assert!(warnings.contains("camera") && warnings.contains("sky"), "{warnings}");
}

#[test]
fn outputs_are_checked_before_rendering() {
    let folder = Folder::new();
    // At this many samples the test would not end if rendering came first.
    let forever = "{box} --size 512x512 --spp 1000000";
    folder.run(&format!("{forever} -o gone/a.png")).failed_with(&["gone/a.png", "gone", "does not exist"]);
    folder.run(&format!("{forever} -o a.png -o a.png")).failed_with(&["a.png", "twice"]);
    assert!(folder.files().is_empty());
    fs::create_dir(folder.path("b.exr")).unwrap();
    folder.run(&format!("{forever} -o b.exr")).failed_with(&["b.exr", "folder"]);
    assert_eq!(folder.files(), ["b.exr"]);
}

/// Files outside the scene's folder are read where `--allow-outside` names their folder, by every
/// command.
#[test]
fn textures_outside_the_scenes_folder_need_permission() {
    let folder = Folder::new();
    for name in ["scenes", "textures"] {
        fs::create_dir(folder.path(name)).unwrap();
    }
    fs::write(folder.path("scenes/a.gltf"), gltf_with_image("../textures/a.png")).unwrap();
    fs::write(folder.path("scenes/triangle.bin"), triangle()).unwrap();
    image::RgbImage::from_pixel(1, 1, image::Rgb([1, 2, 3])).save(folder.path("textures/a.png")).unwrap();
    let before = fs::read(folder.path("textures/a.png")).unwrap();

    for command in ["info scenes/a.gltf", "scenes/a.gltf --size 8x8 --spp 1 -o a.png"] {
        let refused = folder.run(command).succeeded().stdout;
        assert!(refused.contains("../textures/a.png") && refused.contains("--allow-outside DIR"), "{refused}");
        let read = folder.run(&format!("{command} --allow-outside scenes --allow-outside textures")).succeeded();
        assert!(!read.stdout.contains("a.png,") && !read.stdout.contains("allow-outside"), "{read:#?}");
    }
    let ray = "--point 0.2,0.2,1 --direction 0,0,-1 --spp 1 --json --allow-outside textures";
    let measured = folder.run(&format!("measure scenes/a.gltf {ray}")).succeeded().stdout;
    assert!(!measured.contains("allow-outside"), "{measured}");

    let over = "scenes/a.gltf --size 8x8 --spp 1 -o textures/a.png --allow-outside textures";
    folder.run(over).failed_with(&["textures/a.png", "reads it"]);
    assert_eq!(fs::read(folder.path("textures/a.png")).unwrap(), before);

    for (wrong, words) in [("gone", "the folder does not exist"), ("a.png", "this is a file")] {
        let ran = folder.run(&format!("scenes/a.gltf --allow-outside {wrong}"));
        assert_eq!(ran.code, Some(2), "{ran:#?}");
        assert!(ran.stderr.contains(words) && ran.stderr.contains(wrong), "{ran:#?}");
    }
}

/// A texture is known by its file, however its URI spells that: plain, percent-encoded, or long.
#[test]
fn a_texture_of_the_scene_is_not_overwritten() {
    let long = "n".repeat(200) + ".png";
    for (uri, file) in [("a.png", "a.png"), ("%E6%97%A5%20x.png", "日 x.png"), (&long, &long)] {
        let folder = Folder::new();
        fs::write(folder.path("a.gltf"), gltf_with_image(uri)).unwrap();
        fs::write(folder.path("triangle.bin"), triangle()).unwrap();
        let texture = image::RgbImage::from_pixel(1, 1, image::Rgb([1, 2, 3]));
        texture.save(folder.path(file)).unwrap();
        let before = fs::read(folder.path(file)).unwrap();
        let output = folder.command(["a.gltf", "--size", "8x8", "--spp", "1", "-o", file]).output().unwrap();
        common::Ran::from(output).failed_with(&[file, "reads it"]);
        assert_eq!(fs::read(folder.path(file)).unwrap(), before);
    }
}

#[test]
fn unknown_choices_are_reported_with_the_known_ones() {
    let folder = Folder::new();
    folder.run("{box} --camera nowhere").failed_with(&["nowhere", "cornell-box.glb"]);
    folder.run("{box} --scene 7").failed_with(&["scene", "7"]);
    folder.run("{box} --adapter no-such-gpu").failed_with(&["no-such-gpu"]);
    folder.run("{box} --env gone.hdr").failed_with(&["gone.hdr"]);
    folder.run("{box} --eye 1,1,1 --target 1,1,1").failed_with(&["--eye", "--target"]);
    fs::write(folder.path("bad.hdr"), "no map at all").unwrap();
    folder.run("{box} --env bad.hdr").failed_with(&["bad.hdr"]);
    assert_eq!(folder.files(), ["bad.hdr"]);
}

#[test]
fn an_image_beyond_memory_is_refused() {
    let folder = Folder::new();
    folder.run("{box} --size 65536x65536 --spp 1").failed_with(&["65536x65536", "--size"]);
    assert!(folder.files().is_empty());
}

/// Only Vulkan can be hidden from a program by its environment.
#[cfg(target_os = "linux")]
#[test]
fn no_adapter_is_reported_with_the_remedy() {
    let folder = Folder::new();
    let scene = cornell_box();
    for args in [vec![scene.as_os_str()], vec![std::ffi::OsStr::new("devices")]] {
        let output = folder
            .command(args)
            .env("VK_DRIVER_FILES", "/nowhere.json")
            .env("VK_ICD_FILENAMES", "/nowhere.json")
            .output()
            .unwrap();
        common::Ran::from(output).failed_with(&["adapter", "setup.sh"]);
    }
    assert!(folder.files().is_empty());
}

/// A file-size limit replaces a full disk: the image does not fit, and nothing of it stays.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_behind() {
    let folder = Folder::new();
    let output = std::process::Command::new("sh")
        // 512-byte blocks; a size limit also raises SIGXFSZ, which must be ignored to see the
        // error.
        .args(["-c", "trap '' XFSZ; ulimit -f 4; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_surelight")])
        .arg(cornell_box())
        .args(["--size", "64x64", "--spp", "1", "--quiet", "-o", "a.exr"])
        .env("MESA_SHADER_CACHE_DISABLE", "true") // its cache would reach the limit too
        .current_dir(folder.path("."))
        .output()
        .unwrap();
    common::Ran::from(output).failed_with(&["a.exr"]);
    assert!(folder.files().is_empty(), "{:?}", folder.files());
}

/// An image that fails costs neither those after it nor the samples, and the error lists the saved
/// files. /dev/full replaces a full disk.
#[cfg(target_os = "linux")]
#[test]
fn one_output_that_fails_does_not_cost_the_others() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("/dev/full", folder.path("full.exr")).unwrap();
    let line = "{box} --size 8x8 --spp 4 --quiet -o a.png -o full.exr -o b.exr";
    folder.run(line).failed_with(&[
        "the file \"full.exr\" could not be written: the disk is full",
        "\"a.png\", \"b.exr\" were saved",
        "--resume continues from \"a.checkpoint.exr\"",
    ]);
    assert_eq!(folder.files(), ["a.checkpoint.exr", "a.png", "b.exr", "full.exr"]);
    let saved = fs::read(folder.path("b.exr")).unwrap();
    assert!(image::open(folder.path("a.png")).is_ok());

    // With space available, only writing remains: no sample is taken again.
    fs::remove_file(folder.path("full.exr")).unwrap();
    folder.run(&format!("{line} --resume")).succeeded();
    assert_eq!(folder.files(), ["a.png", "b.exr", "full.exr"]);
    assert!(["b.exr", "full.exr"].iter().all(|name| fs::read(folder.path(name)).unwrap() == saved));
}
