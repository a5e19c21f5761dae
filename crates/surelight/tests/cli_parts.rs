//! Renders in parts: however one is cut, interrupted or killed, the files are those of a single
//! run, byte for byte.

mod common;

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::Stdio;
use std::time::{Duration, Instant};

use common::{Folder, Ran, cornell_box};
use surelight_film::read_exr;

/// Renders the Cornell box without progress; the options come after.
fn box_of(folder: &Folder, spp: u32, options: &str) -> Ran {
    folder.run(&format!("{{box}} --size 37x29 --spp {spp} --shared-paths on --quiet {options}"))
}

#[track_caller]
fn same(folder: &Folder, a: &str, b: &str) {
    assert!(fs::read(folder.path(a)).unwrap() == fs::read(folder.path(b)).unwrap(), "{a} and {b} differ");
}

#[test]
fn four_slices_and_four_crops_merge_to_the_whole() {
    let folder = Folder::new();
    box_of(&folder, 100, "-o whole.exr -o whole.png --max-radiance 0.3 --eye 0.1,1,3 --target 0,1,0").succeeded();
    let settings = "--max-radiance 0.3 --eye 0.1,1,3 --target 0,1,0";
    for samples in ["0..24", "24..48", "48..72", "72..100"] {
        box_of(&folder, 100, &format!("-o s{samples}.exr --samples {samples} {settings}")).succeeded();
    }
    let merged =
        folder.run("merge s48..72.exr s0..24.exr s72..100.exr s24..48.exr -o m.exr -o m.png --json").succeeded();
    let merged: serde_json::Value = serde_json::from_str(&merged.stdout).unwrap();
    assert_eq!((&merged["spp"], &merged["parts"], &merged["missing"]), (&100.into(), &4.into(), &().into()));
    same(&folder, "m.exr", "whole.exr");
    same(&folder, "m.png", "whole.png");

    // Neither as wide nor as high as blocks of 8.
    for crop in ["0,0,20,13", "20,0,37,13", "0,13,3,29", "3,13,37,29"] {
        box_of(&folder, 100, &format!("-o c{crop}.exr --crop {crop} {settings}")).succeeded();
    }
    folder.run("merge c0,0,20,13.exr c20,0,37,13.exr c0,13,3,29.exr c3,13,37,29.exr -o c.exr").succeeded();
    same(&folder, "c.exr", "whole.exr");
    let crop = read_exr(&folder.path("c3,13,37,29.exr")).unwrap();
    assert_eq!((crop.width, crop.height, crop.position), (34, 16, [3, 13]));
    assert!(crop.channels.contains_key("Albedo.R") && !crop.channels.contains_key("Moments.00"));
}

#[test]
fn merge_lists_missing_parts_and_refuses_foreign_ones() {
    let folder = Folder::new();
    for (name, spp, options) in [
        ("a", 16, "--samples 0..4"),
        ("b", 16, "--samples 4..10"),
        ("c", 16, "--samples 10..16"),
        ("seed", 16, "--samples 4..10 --seed 1"),
        ("sampler", 16, "--samples 4..10 --sampler independent"),
        ("spp", 17, "--samples 4..10"),
        ("all", 16, ""),
    ] {
        box_of(&folder, spp, &format!("{options} -o {name}.exr")).succeeded();
    }
    let some = folder.run("merge a.exr b.exr -o ab.exr");
    assert_eq!(some.code, Some(3), "{some:#?}");
    assert!(some.stdout.contains("samples 10..16 of all pixels are missing"), "{some:#?}");
    folder.run("merge c.exr ab.exr -o abc.exr").succeeded();
    same(&folder, "abc.exr", "all.exr");

    let files = folder.files();
    folder.run("merge a.exr seed.exr -o x.exr").failed_with(&["a.exr", "seed.exr", "--seed is 0", "1 in the second"]);
    folder.run("merge a.exr sampler.exr -o x.exr").failed_with(&["--sampler is sobol", "independent"]);
    folder.run("merge a.exr spp.exr -o x.exr").failed_with(&["--spp is 16", "17"]);
    folder.run("merge a.exr c.exr -o x.exr").failed_with(&["hole", "samples 4..10"]);
    folder.run("merge ab.exr b.exr -o x.exr").failed_with(&["ab.exr", "b.exr", "4..10", "twice"]);
    folder.run("merge all.exr -o x.exr").failed_with(&["all.exr", "no part"]);
    folder.run("merge a.exr b.exr -o b.exr").failed_with(&["b.exr", "reads it"]);
    let whole = fs::read(folder.path("b.exr")).unwrap();
    fs::write(folder.path("cut.exr"), &whole[..whole.len() - 100]).unwrap();
    folder.run("merge a.exr cut.exr -o x.exr").failed_with(&["cut.exr", "cut short"]);
    fs::remove_file(folder.path("cut.exr")).unwrap();
    assert_eq!(folder.files(), files);
}

/// Means and error bars of an extended render are those of a render in one go.
#[test]
fn finished_renders_are_extended() {
    let folder = Folder::new();
    let extended =
        |options: &str| folder.run(&format!("{{box}} --size 37x29 --shared-paths on {options} --json")).succeeded();
    let summary = |ran: &Ran| serde_json::from_str::<serde_json::Value>(&ran.stdout).unwrap();
    extended("--spp 64 -o a.exr");
    let bytes = fs::metadata(folder.path("a.exr")).unwrap().len();
    let longer = summary(&extended("--spp 128 -o a.exr --resume"));
    assert_eq!(
        (&longer["spp"], &longer["resumed_spp"], &longer["resumed_from"]),
        (&128.into(), &64.into(), &"a.exr".into())
    );
    assert!(longer["paths"].as_u64() >= Some(37 * 29 * 128), "{longer}");
    let direct_summary = summary(&extended("--spp 128 -o direct.exr"));
    let [a, direct] = ["a.exr", "direct.exr"].map(|name| read_exr(&folder.path(name)).unwrap());
    for (x, y) in a.rgb("").unwrap().into_iter().flatten().zip(direct.rgb("").unwrap().into_iter().flatten()) {
        assert!((x - y).abs() <= 1e-5 * y.abs(), "{x} {y}");
    }
    let mean_error = |summary: &serde_json::Value| summary["relative_error"]["mean"].as_f64().unwrap();
    let ratio = mean_error(&longer) / mean_error(&direct_summary);
    assert!((0.85..1.2).contains(&ratio), "{ratio}");
    let metadata = a.surelight_metadata().unwrap();
    assert_eq!((metadata.sample_range, metadata.extended_from.as_slice()), ([0, 128], [64].as_slice()));
    assert!(metadata.part.is_none() && fs::metadata(folder.path("a.exr")).unwrap().len() < bytes * 11 / 10);

    // On to independent scrambles and certificates.
    let certified = summary(&extended("--spp 512 -o a.exr --resume"));
    assert!(certified["intervals"]["certified"].as_f64() > Some(0.5), "{certified}");
    assert_eq!(read_exr(&folder.path("a.exr")).unwrap().surelight_metadata().unwrap().extended_from, [64, 128]);

    // There is nothing to add; the picture can still be displayed differently.
    let before = read_exr(&folder.path("a.exr")).unwrap();
    let done = summary(&extended("--spp 512 -o a.exr -o a.png --exposure 1 --resume"));
    assert_eq!((&done["rays"], &done["spp"]), (&0.into(), &512.into()));
    let after = read_exr(&folder.path("a.exr")).unwrap();
    assert_eq!((&after.metadata, after.rgb("")), (&before.metadata, before.rgb("")));

    // Other settings are another render, which replaces the file.
    let ran = extended("--spp 4 --seed 1 -o a.exr --resume");
    assert!(ran.stderr.contains("--seed is 0 there and 1 here") && ran.stderr.contains("begins anew"), "{ran:#?}");
    assert_eq!(summary(&ran)["resumed_spp"], 0);
}

/// Crops and adaptive samples extend as well, and an interrupted extension can be resumed.
#[test]
fn extensions_of_crops_and_adaptive_renders() {
    let folder = Folder::new();
    for options in ["--crop 3,5,30,20", "--adaptive --shared-paths off", "--error 40% --sky 0,0,0"] {
        let spp = |n: u32| if options.starts_with("--error") { String::new() } else { format!("--spp {n}") };
        folder.run(&format!("{{box}} --size 37x29 {} {options} -o a.exr --quiet", spp(16))).succeeded();
        let before = read_exr(&folder.path("a.exr")).unwrap();
        let more = options.replace("40%", "6%");
        let ran = folder.run(&format!("{{box}} --size 37x29 {} {more} -o a.exr --resume --json", spp(32))).succeeded();
        let summary: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(
            summary["resumed_spp"],
            before.surelight_metadata().unwrap().sample_range[1],
            "{options}: {summary}"
        );
        let after = read_exr(&folder.path("a.exr")).unwrap();
        let [first, then] = [&before, &after].map(|image| image.channels["Samples.N"].iter().sum::<f32>());
        assert!(then > first, "{options}: {first} {then}");
        fs::remove_file(folder.path("a.exr")).unwrap();
    }
}

/// Parts of two adapters merge on request, and the file records it.
#[test]
fn parts_of_two_adapters_merge_on_request() {
    let folder = Folder::new();
    for (name, samples) in [("a", "0..8"), ("b", "8..16")] {
        box_of(&folder, 16, &format!("--samples {samples} -o {name}.exr")).succeeded();
    }
    let (film, mut metadata) = surelight_film::read_part(&folder.path("b.exr")).unwrap();
    metadata.device = "Another GPU".into();
    surelight_film::write_exr(&folder.path("b.exr"), &film, &metadata).unwrap();
    folder.run("merge a.exr b.exr -o m.exr").failed_with(&["the device", "Another GPU", "--mixed"]);
    let ran = folder.run("merge a.exr b.exr -o m.exr --mixed").succeeded();
    assert!(ran.stdout.contains("mixed") && ran.stdout.contains("Another GPU"), "{ran:#?}");
    let mixed = read_exr(&folder.path("m.exr")).unwrap().surelight_metadata().unwrap().mixed;
    assert!(mixed.len() == 2 && mixed[0].starts_with("Another GPU, driver"), "{mixed:?}");
    let (_, mut metadata) = surelight_film::read_part(&folder.path("b.exr")).unwrap();
    metadata.seed = 5;
    surelight_film::write_exr(&folder.path("b.exr"), &film, &metadata).unwrap();
    folder.run("merge a.exr b.exr -o m.exr --mixed").failed_with(&["--seed"]);
}

/// Pictures with settings of another version are compared, but not merged or resumed.
#[test]
fn settings_of_another_version_are_refused() {
    let folder = Folder::new();
    let options = "--samples 0..8 -o a.exr";
    box_of(&folder, 16, options).succeeded();
    let (film, mut metadata) = surelight_film::read_part(&folder.path("a.exr")).unwrap();
    metadata.settings.as_mut().unwrap().version = 7;
    for name in ["b.exr", "a.checkpoint.exr"] {
        surelight_film::write_exr(&folder.path(name), &film, &metadata).unwrap();
    }
    let words = "settings have version 7";
    folder.run("merge a.exr b.exr -o m.exr").failed_with(&["b.exr", words]);
    box_of(&folder, 16, &format!("{options} --resume")).failed_with(&["a.checkpoint.exr", words]);
    folder.run("compare a.exr b.exr").succeeded();

    // A finished image of another version is replaced, with a note.
    let finished = surelight_film::Metadata { part: None, ..metadata };
    surelight_film::write_exr(&folder.path("c.exr"), &film, &finished).unwrap();
    let ran = folder.run("{box} --size 37x29 --spp 16 -o c.exr --resume").succeeded();
    assert!(ran.stderr.contains("version of the settings is 7 there and 1 here"), "{ran:#?}");
}

#[test]
fn valid_part_boundaries_are_reported() {
    let folder = Folder::new();
    for (options, words) in [
        ("--spp 1000 --samples 0..250", "224 and 256"),
        ("--spp 64 --samples 3..8", "2 and 4"),
        ("--spp 64 --samples 32..65", "beyond '--spp 64'"),
        ("--samples 0..16", "--spp"),
        ("--spp 64 --samples 0..16 -o a.png", ".exr"),
    ] {
        let ran = folder.run(&format!("{{box}} {options}"));
        assert_eq!(ran.code, Some(2), "{ran:#?}");
        assert!(ran.stderr.contains(words), "{ran:#?}");
    }
    folder.run("{box} --size 9x9 --crop 0,0,10,9").failed_with(&["region", "9x9"]);
    assert!(folder.files().is_empty());
}

/// Starts a render that a signal ends while it traces, once it is `ready`, and returns its options:
/// its image is large enough for the signal to come in time. Its files are in the folder.
#[cfg(unix)]
fn stopped(folder: &Folder, options: &str, signal: &str, ready: impl Fn() -> bool) -> (String, Option<i32>) {
    for size in ["40x30", "400x300", "1600x1200"] {
        let options = format!("--size {size} -o a.exr {options}");
        let mut child = folder
            .command([cornell_box().as_os_str()])
            .args(options.split(' '))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        log.read_line(&mut line).unwrap();
        assert!(line.contains("tracing"), "{line}");
        let start = Instant::now();
        while !ready() && child.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < Duration::from_secs(60), "nothing happens");
            std::thread::sleep(Duration::from_millis(2));
        }
        let _ =
            std::process::Command::new("kill").args([signal, &child.id().to_string()]).stderr(Stdio::null()).status();
        let code = child.wait().unwrap().code();
        if folder.path("a.checkpoint.exr").exists() {
            return (options, code);
        }
    }
    panic!("the device is too fast for this test");
}

#[cfg(unix)]
#[test]
fn killed_renders_resume_to_the_same_bytes() {
    // With a precision, the pilot's result is kept, too.
    for goal in ["--spp 256", "--error 12%"] {
        let folder = Folder::new();
        let checkpoint = folder.path("a.checkpoint.exr");
        let (options, code) = stopped(&folder, &format!("{goal} --checkpoint 1ms"), "-KILL", || checkpoint.exists());
        assert_eq!((code, folder.path("a.exr").exists()), (None, false));
        let resumed = folder.run(&format!("{{box}} {options} --resume --json")).succeeded();
        let summary: serde_json::Value = serde_json::from_str(&resumed.stdout).unwrap();
        assert!(summary["resumed_spp"].as_u64() > Some(0) && summary["checkpoint"].is_null(), "{summary}");
        assert_eq!(folder.files(), ["a.exr"]);
        folder.run(&format!("{{box}} {options} -o whole.exr").replace("-o a.exr ", "")).succeeded();
        same(&folder, "a.exr", "whole.exr");
    }
}

#[cfg(unix)]
#[test]
fn interrupted_renders_resume_and_refuse_other_settings() {
    let folder = Folder::new();
    // Ctrl-C takes effect once there is a sample, however early it comes.
    let (options, code) = stopped(&folder, "--spp 256", "-INT", || true);
    assert_eq!(code, Some(3));
    assert_eq!(folder.files(), ["a.checkpoint.exr", "a.exr"]);
    let kept = fs::read(folder.path("a.checkpoint.exr")).unwrap();

    for (line, words) in [
        ("{box} OPTIONS --resume --seed 1", ["--seed is 0 there", "1 here"]),
        ("{box} OPTIONS --resume --max-bounces 2", ["--max-bounces is unlimited", "2 here"]),
        ("{box} OPTIONS --resume --crop 0,0,9,9", ["--crop is not set", "0,0,9,9"]),
        ("{box} OPTIONS --resume --samples 0..16", ["--samples is not set", "0..16"]),
        ("{other} OPTIONS --resume", ["scene", "hash"]),
    ] {
        let other = cornell_box().with_file_name("furnace.glb").display().to_string();
        let ran = folder.run(&line.replace("OPTIONS", &options).replace("{other}", &other));
        ran.failed_with(&["a.checkpoint.exr", words[0], words[1]]);
    }
    for length in [0, 100, kept.len() / 2, kept.len() - 1] {
        fs::write(folder.path("a.checkpoint.exr"), &kept[..length]).unwrap();
        folder.run(&format!("{{box}} {options} --resume")).failed_with(&["a.checkpoint.exr", "cut short"]);
    }
    fs::write(folder.path("a.checkpoint.exr"), &kept).unwrap();

    folder.run(&format!("{{box}} {options} --resume")).succeeded();
    assert_eq!(folder.files(), ["a.exr"]);
    folder.run(&format!("{{box}} {options} -o whole.exr").replace("-o a.exr ", "")).succeeded();
    same(&folder, "a.exr", "whole.exr");
}

#[test]
fn checkpoints_of_other_renders_are_reported_and_left_alone() {
    let folder = Folder::new();
    // A checkpoint has the form of a part.
    box_of(&folder, 16, "--samples 0..4 -o a.checkpoint.exr").succeeded();
    let before = fs::read(folder.path("a.checkpoint.exr")).unwrap();
    let ran = folder.run("{box} --size 9x9 --spp 2 -o a.exr").succeeded();
    assert!(ran.stderr.contains("a.checkpoint.exr\" holds 4 samples") && ran.stderr.contains("--resume"), "{ran:#?}");
    assert!(fs::read(folder.path("a.checkpoint.exr")).unwrap() == before);
    // Without one, a render that is to be resumed begins: a script may always say --resume.
    let ran = folder.run("{box} --size 9x9 --spp 2 -o b.exr --resume").succeeded();
    assert!(ran.stderr.contains("checkpoint \"b.checkpoint.exr\"") && ran.stderr.contains("begins anew"), "{ran:#?}");
}

/// Coverage is cut, joined and resumed like radiance, and parts without it are of another render.
#[test]
fn transparent_parts_merge_and_resume_to_the_whole() {
    let folder = Folder::new();
    let view = "--transparent --sky 0.5,0.7,1 --fov 70";
    for more in ["--shared-paths on", "--adaptive", "--sampler stratified --integrator caustics"] {
        let run = |rest: &str| folder.run(&format!("{{box}} --size 37x29 --spp 64 --quiet {view} {more} {rest}"));
        run("-o whole.exr -o whole.png").succeeded();
        run("-o left.exr --crop 0,0,17,29 --samples 0..24").succeeded();
        run("-o right.exr --crop 17,0,37,29 --samples 0..24").succeeded();
        run("-o rest.exr --samples 24..64").succeeded();
        folder.run("merge rest.exr left.exr right.exr -o merged.exr -o merged.png").succeeded();
        same(&folder, "merged.exr", "whole.exr");
        same(&folder, "merged.png", "whole.png");

        // On a fast machine it is done before the time is up.
        let stopped = run("-o a.exr --time 1ms");
        if stopped.code == Some(3) {
            run("-o a.exr --time 1h --resume").succeeded();
            same(&folder, "a.exr", "whole.exr");
        }
    }
    let whole = read_exr(&folder.path("whole.exr")).unwrap();
    assert!(whole.surelight_metadata().unwrap().is_transparent());
    let alpha = &whole.channels["A"];
    assert!(alpha.contains(&0.0) && alpha.contains(&1.0) && alpha.iter().any(|&a| a > 0.0 && a < 1.0));

    let line =
        "{box} --size 37x29 --spp 64 --sampler stratified --integrator caustics --quiet --sky 0.5,0.7,1 --fov 70";
    folder.run(&format!("{line} -o opaque.exr --samples 0..24")).succeeded();
    folder.run("merge opaque.exr rest.exr -o b.exr").failed_with(&["--transparent is not set", "true"]);
    folder.run(&format!("{line} -o rest.checkpoint.exr --samples 0..24")).succeeded();
    let resumed = folder.run(&format!("{line} -o rest.exr --samples 0..24 --transparent --resume"));
    resumed.failed_with(&["--transparent is not set there", "true here"]);
}

#[test]
fn a_picture_without_the_option_has_no_coverage() {
    let folder = Folder::new();
    box_of(&folder, 16, "-o a.exr -o a.png --samples 0..4").succeeded();
    let image = read_exr(&folder.path("a.exr")).unwrap();
    assert!(image.channels["A"].iter().all(|&a| a == 1.0));
    assert!(!image.surelight_metadata().unwrap().is_transparent());
    assert!(!image::open(folder.path("a.png")).unwrap().color().has_alpha());
}
