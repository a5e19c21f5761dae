//! Names of files, folders and their contents: any script, any bytes, any length.

mod common;

use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::Path;

use common::{Folder, Ran, cornell_box};
use surelight_film::settings::Environment;
use surelight_film::{Metadata, read_exr, read_part};

/// Options of a render that takes no time.
const SMALL: [&str; 5] = ["--size", "8x8", "--spp", "2", "--quiet"];

/// Names beyond Latin-1, beyond UTF-16 units, in composed and decomposed form.
const NAMES: [&str; 6] = ["日本", "a–b", "❤", "e\u{301}te\u{301}", "été", "😀"];

/// Runs the program with `words`, which may be of any bytes.
fn run<S: AsRef<OsStr>>(folder: &Folder, words: &[S]) -> Ran {
    Ran::from(folder.command(words).output().unwrap())
}

fn words(list: &[&OsStr]) -> Vec<OsString> {
    list.iter().copied().map(OsString::from).chain(SMALL.map(OsString::from)).collect()
}

/// Names of the scene and of the environment map that a file records.
fn names(metadata: Metadata) -> [String; 2] {
    let settings = metadata.settings.unwrap();
    let Environment::Map { file, .. } = settings.environment else { panic!("{settings:?}") };
    [settings.scene, file]
}

/// A map of one colour.
fn write_sky(path: &Path) {
    image::Rgb32FImage::from_pixel(4, 2, image::Rgb([0.5, 0.25, 1.0])).save(path).unwrap();
}

#[test]
fn scenes_folders_and_maps_have_names_in_any_script() {
    let folder = Folder::new();
    for name in NAMES {
        fs::create_dir(folder.path(name)).unwrap();
        let (scene, sky) = (format!("{name}/{name}.glb"), format!("{name}/{name}.hdr"));
        fs::copy(cornell_box(), folder.path(&scene)).unwrap();
        write_sky(&folder.path(&sky));
        let ran = run(&folder, &words(&[&scene, "--env", &sky, "--json"].map(OsStr::new))).succeeded();
        let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(summary["scene"], *scene);
        assert_eq!(summary["outputs"], serde_json::json!([format!("{name}.png"), format!("{name}.exr")]));

        let metadata = read_exr(&folder.path(&format!("{name}.exr"))).unwrap().surelight_metadata().unwrap();
        assert_eq!(names(metadata), [scene, sky]);
    }
}

#[test]
fn parts_with_names_in_any_script_are_merged_compared_and_resumed() {
    let folder = Folder::new();
    fs::copy(cornell_box(), folder.path("日本.glb")).unwrap();
    for range in ["0..1", "1..2"] {
        let part = format!("部{range}.exr");
        let line = ["日本.glb", "--samples", range, "-o", &part].map(OsStr::new);
        run(&folder, &words(&line)).succeeded();
    }
    run(&folder, &["merge", "部0..1.exr", "部1..2.exr", "-o", "全.exr"]).succeeded();
    run(&folder, &words(&["日本.glb", "-o", "一.exr"].map(OsStr::new))).succeeded();
    run(&folder, &["compare", "全.exr", "一.exr"]).succeeded();
    let [merged, whole] = ["全.exr", "一.exr"].map(|name| read_exr(&folder.path(name)).unwrap());
    assert_eq!(merged.channels["R"], whole.channels["R"]);
    assert_eq!(merged.surelight_metadata().unwrap().settings.unwrap().scene, "日本.glb");

    let line = ["日本.glb", "-o", "続.exr", "--size", "8x8", "--spp", "1000000", "--time", "0.5s", "--quiet"];
    assert_eq!(run(&folder, &line).code, Some(3));
    let (_, metadata) = read_part(&folder.path("続.checkpoint.exr")).unwrap();
    assert_eq!(metadata.settings.unwrap().scene, "日本.glb");
    let before = metadata.sample_range[1];
    let ran = run(&folder, &[&line[..], &["--resume"]].concat());
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(3), ""));
    let (_, metadata) = read_part(&folder.path("続.checkpoint.exr")).unwrap();
    assert!(metadata.sample_range[1] > before, "{metadata:?}");
}

#[test]
fn cameras_have_names_in_any_script() {
    let folder = Folder::new();
    let mut scene = surelight_scene::load(&cornell_box(), &surelight_scene::LoadOptions::default()).unwrap();
    for name in NAMES {
        scene.cameras[0].name = name.into();
        fs::write(folder.path("a.glb"), surelight_scenes::glb::encode(&scene, "").unwrap()).unwrap();
        run(&folder, &words(&["a.glb", "--camera", name, "-o", "a.exr"].map(OsStr::new))).succeeded();
        let metadata = read_exr(&folder.path("a.exr")).unwrap().surelight_metadata().unwrap();
        assert_eq!(metadata.settings.unwrap().camera.name, name);
    }
}

/// Names that are no text are valid: they are recorded with U+FFFD in place of bytes that are not
/// UTF-8.
#[cfg(target_os = "linux")]
#[test]
fn paths_need_not_be_utf_8() {
    use std::os::unix::ffi::OsStrExt;
    let folder = Folder::new();
    let named = |end: &[u8]| OsStr::from_bytes(&[b"\xff\xfe", end].concat()).to_owned();
    let at = |name: &OsStr| folder.path("").join(name);
    let (scene, sky) = (named(b".glb"), named(b".hdr"));
    fs::copy(cornell_box(), at(&scene)).unwrap();
    write_sky(&folder.path("sky.hdr"));
    fs::rename(folder.path("sky.hdr"), at(&sky)).unwrap();

    let ran = run(&folder, &words(&[&scene, OsStr::new("--env"), &sky, OsStr::new("--json")])).succeeded();
    let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(summary["outputs"][0], "\u{fffd}\u{fffd}.png");
    assert!(at(&named(b".png")).is_file());
    let metadata = read_exr(&at(&named(b".exr"))).unwrap().surelight_metadata().unwrap();
    assert_eq!(names(metadata), ["\u{fffd}\u{fffd}.glb", "\u{fffd}\u{fffd}.hdr"]);

    let output = named(b"2.exr");
    run(&folder, &words(&[OsStr::new("render"), &scene, OsStr::new("-o"), &output])).succeeded();
    let map = named(b".map.png");
    let compared = [OsStr::new("compare"), &output, &output, OsStr::new("--map"), &map];
    run(&folder, &compared).succeeded();
    assert!(at(&map).is_file());
    run(&folder, &[OsStr::new("info"), &scene]).succeeded();
    let chart = named(b".svg");
    run(
        &folder,
        &["integrate", "x0", "--over", "0..1", "-o"].map(OsStr::new).into_iter().chain([&*chart]).collect::<Vec<_>>(),
    )
    .succeeded();
    assert!(at(&chart).is_file());
}

/// A name of 255 bytes is the longest that a file can have; its checkpoint's is made shorter.
#[cfg(target_os = "linux")]
#[test]
fn names_may_be_as_long_as_the_file_system_allows() {
    let folder = Folder::new();
    let long = |length: usize| "n".repeat(length - ".exr".len()) + ".exr";
    for length in [243, 255] {
        folder.run(&format!("{{box}} --size 8x8 --spp 2 --quiet -o {}", long(length))).succeeded();
    }
    assert_eq!(folder.files(), [long(243), long(255)]);

    // At this many samples the test would not end if rendering came first.
    let forever = "{box} --size 512x512 --spp 1000000";
    folder.run(&format!("{forever} -o {}", long(256))).failed_with(&["n.exr", "name is too long"]);

    let line = format!("{{box}} --size 8x8 --spp 1000000 --time 0.5s --quiet --json -o {}", long(255));
    let ran = folder.run(&line);
    assert_eq!(ran.code, Some(3), "{ran:#?}");
    let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let checkpoint = summary["checkpoint"].as_str().unwrap();
    assert!(folder.path(checkpoint).is_file() && checkpoint.ends_with(".checkpoint.exr"), "{summary}");
    let ran = folder.run(&format!("{line} --resume"));
    assert_eq!((ran.code, ran.stderr.as_str()), (Some(3), ""));
    assert_eq!(folder.files().len(), 3, "{:?}", folder.files());
}

/// A write through a link goes to the file it names, whether that exists already or not.
#[cfg(unix)]
#[test]
fn outputs_are_written_through_links() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    fs::create_dir(folder.path("far")).unwrap();
    symlink("far/frame.exr", folder.path("latest.exr")).unwrap();
    for seed in [1, 2] {
        folder.run(&format!("{{box}} --size 8x8 --spp 2 --quiet -o latest.exr --seed {seed}")).succeeded();
        assert!(folder.path("latest.exr").is_symlink());
        let metadata = read_exr(&folder.path("far/frame.exr")).unwrap().surelight_metadata().unwrap();
        assert_eq!(metadata.seed, seed);
    }
    let forever = "{box} --size 512x512 --spp 1000000";
    folder.run(&format!("{forever} -o latest.exr -o far/frame.exr")).failed_with(&["far/frame.exr", "twice"]);
    symlink("gone/frame.exr", folder.path("lost.exr")).unwrap();
    folder.run(&format!("{forever} -o lost.exr")).failed_with(&["lost.exr", "gone", "does not exist"]);
}
