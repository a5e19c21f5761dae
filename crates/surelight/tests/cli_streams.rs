//! Images to standard output, scenes from standard input.

mod common;

use std::fs;
use std::io::Write;
use std::process::{Command, Output, Stdio};

use common::{Folder, Ran, cornell_box};
use surelight_film::{read_exr, read_part};

/// Options of a render that takes no time.
const SMALL: &str = "--size 8x8 --spp 2 --quiet";

/// At this many samples a test would not end if rendering came first.
const FOREVER: &str = "--size 512x512 --spp 1000000 --quiet";

/// The program with arguments separated by spaces, and bytes for standard input.
fn run(folder: &Folder, line: &str, input: &[u8]) -> Output {
    let scene = cornell_box();
    let words = line.split_whitespace().map(|word| if word == "{box}" { scene.to_str().unwrap() } else { word });
    let mut command = folder.command(words);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let input = input.to_owned();
    // An early refusal closes the pipe.
    let writer = std::thread::spawn(move || _ = pipe.write_all(&input));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

#[test]
fn standard_output_has_the_bytes_of_the_file() {
    let folder = Folder::new();
    for format in ["exr", "png"] {
        folder.run(&format!("{{box}} {SMALL} -o a.{format}")).succeeded();
        let ran = run(&folder, &format!("{{box}} {SMALL} -o - --format {format}"), b"");
        assert_eq!(ran.status.code(), Some(0));
        assert!(ran.stdout == fs::read(folder.path(&format!("a.{format}"))).unwrap(), "{format}");
        // The summary goes to standard error.
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert!(stderr.contains("image     standard output (8x8)") && stderr.contains("noise     "), "{stderr}");
    }
    assert_eq!(folder.files(), ["a.exr", "a.png"]);
}

#[test]
fn a_format_serves_names_that_tell_none() {
    let folder = Folder::new();
    let ran = run(&folder, &format!("{{box}} {SMALL} -o picture -o - -o b.exr --format png"), b"");
    assert_eq!(ran.status.code(), Some(0));
    assert!(ran.stdout.starts_with(b"\x89PNG") && ran.stdout == fs::read(folder.path("picture")).unwrap());
    assert!(read_exr(&folder.path("b.exr")).is_ok());
    assert_eq!(folder.files(), ["b.exr", "picture"]);
}

#[test]
fn one_image_and_nothing_else_goes_to_standard_output() {
    let folder = Folder::new();
    for (options, words) in [
        ("-o -", "--format png"),
        ("-o - -o - --format exr", "given twice"),
        ("-o - --format exr --json", "standard output"),
        ("-o - --format exr --resume", "checkpoint"),
        ("-o a.exr --format exr", "'--format' is for"),
        ("--format exr", "--output"),
        ("-o a.jpg", "'a.jpg' for '--output <PATH>'"),
    ] {
        let ran = folder.run(&format!("{{box}} {FOREVER} {options}"));
        assert_eq!((ran.code, ran.stdout.as_str()), (Some(2), ""), "{options}");
        assert!(ran.stderr.contains(words), "{options}: {}", ran.stderr);
    }
    assert!(folder.files().is_empty());
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_one_sentence() {
    let folder = Folder::new();
    for (more, left) in [("", vec![]), (" -o a.png", vec!["a.checkpoint.exr", "a.png"])] {
        let line = format!("\"$0\" \"$1\" {SMALL} -o - --format exr{more} | true; exit ${{PIPESTATUS[0]}}");
        let mut shell = Command::new("bash");
        shell.args(["-c", &line, env!("CARGO_BIN_EXE_surelight")]).arg(cornell_box());
        let ran = Ran::from(shell.current_dir(folder.path("")).output().unwrap());
        ran.failed_with(&["standard output could not be written", "has ended"]);
        assert_eq!(folder.files(), left, "the other outputs are written");
    }
}

/// Without a file there is no place for a checkpoint; with one, it is beside the file.
#[test]
fn a_render_that_ends_early_writes_what_it_has() {
    let folder = Folder::new();
    let line = "{box} --size 8x8 --spp 100000000 --time 0.5s --quiet -o - --format exr";
    let ran = run(&folder, line, b"");
    let stderr = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(3), "{stderr}");
    assert!(stderr.contains("no checkpoint was saved") && !stderr.contains("continues"), "{stderr}");
    assert!(ran.stdout.starts_with(&[0x76, 0x2f, 0x31, 0x01]) && folder.files().is_empty());

    let ran = run(&folder, &format!("{line} -o b.png"), b"");
    assert!(String::from_utf8(ran.stderr).unwrap().contains("--resume continues from b.checkpoint.exr"));
    assert_eq!(folder.files(), ["b.checkpoint.exr", "b.png"]);
    assert!(read_part(&folder.path("b.checkpoint.exr")).is_ok());
}

#[test]
fn scenes_come_from_standard_input() {
    let folder = Folder::new();
    let glb = fs::read(cornell_box()).unwrap();
    folder.run(&format!("{{box}} {SMALL} -o a.exr")).succeeded();
    let ran = Ran::from(run(&folder, &format!("- {SMALL} --json"), &glb)).succeeded();
    let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(summary["scene"], "standard input");
    assert_eq!(summary["outputs"], serde_json::json!(["stdin.png", "stdin.exr"]));
    assert_eq!(folder.files(), ["a.exr", "stdin.exr", "stdin.png"]);
    let [file, stream] = ["a.exr", "stdin.exr"].map(|name| read_exr(&folder.path(name)).unwrap());
    assert_eq!(file.channels, stream.channels);
    let metadata = stream.surelight_metadata().unwrap();
    assert_eq!(metadata.settings.unwrap().scene, "standard input");
    assert_eq!(metadata.scene_hash, file.surelight_metadata().unwrap().scene_hash);

    let listing = Ran::from(run(&folder, "info -", &glb)).succeeded().stdout;
    assert!(listing.contains("standard input") && listing.contains("triangles"), "{listing}");
    let measured =
        Ran::from(run(&folder, "measure - --irradiance 0,0.5,0 --normal 0,1,0 --spp 256 --json", &glb)).succeeded();
    assert!(measured.stdout.contains("standard input"), "{measured:?}");
    // Both at once.
    let ran = run(&folder, &format!("- {SMALL} -o - --format exr"), &glb);
    assert!(ran.status.success() && ran.stdout == fs::read(folder.path("stdin.exr")).unwrap());
}

/// A stream that is no scene is refused without reading on; a scene from a pipe refers to no files.
#[test]
fn scenes_from_standard_input_must_be_whole() {
    let folder = Folder::new();
    fs::write(folder.path("a.bin"), [0; 36]).unwrap();
    let glb = fs::read(cornell_box()).unwrap();
    let gltf = |uri: &str| format!(r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":36,"uri":"{uri}"}}]}}"#);
    let image = r#"{"asset":{"version":"2.0"},"images":[{"uri":"a.png"}]}"#;
    for (input, words) in [
        (&b""[..], &["standard input", "empty"][..]),
        (&[0; 100_000], &["standard input", "begins neither"]),
        (&glb[..glb.len() / 2], &["standard input", "cut short"]),
        (gltf("a.bin").as_bytes(), &["standard input", "buffer 0", "a.bin", "no folder", "one .glb"]),
        (image.as_bytes(), &["standard input", "image 0", "a.png"]),
    ] {
        for line in [format!("- {FOREVER}"), "info -".into()] {
            Ran::from(run(&folder, &line, input)).failed_with(words);
        }
    }
    let whole = gltf("data:application/octet-stream;base64,AAAA");
    Ran::from(run(&folder, "info -", whole.as_bytes())).succeeded();
    assert_eq!(folder.files(), ["a.bin"]);
}
