//! `compare` distinguishes renders of one scene from those of another estimator, by its exit code.

mod common;

use common::Folder;
use serde_json::Value;

/// A folder with two seeds of the Cornell box, and Whitted's idea of it.
fn renders() -> Folder {
    let folder = Folder::new();
    for line in ["--seed 1 -o a.exr", "--seed 2 -o b.exr", "--seed 3 -o whitted.exr --integrator whitted"] {
        folder.run(&format!("{{box}} --size 32x32 --spp 256 --quiet {line}")).succeeded();
    }
    folder
}

#[test]
fn two_seeds_agree_and_whitted_does_not() {
    let folder = renders();
    let same = folder.run("compare a.exr b.exr").succeeded();
    for words in ["mean ", "RMSE ", "relMSE ", "SMAPE ", "FLIP ", "the same", "would have been detected"] {
        assert!(same.stdout.contains(words), "{words:?} is missing: {same:#?}");
    }
    let json: Value = serde_json::from_str(&folder.run("compare a.exr b.exr --json").succeeded().stdout).unwrap();
    let verdict = &json["verdict"];
    assert_eq!((&verdict["differ"], &verdict["tiles"], &json["pixels"]), (&false.into(), &4.into(), &1024.into()));
    // Else "the same" would say nothing.
    let detectable = verdict["detectable"].as_f64().unwrap();
    assert!(detectable > 0.0 && detectable < 0.05, "only a bias of {detectable} would be detected");
    assert!(json["mean_relative"].as_f64().unwrap().abs() < detectable, "{json}");
    assert_eq!(json["notes"], Value::Array(vec![]));
    assert_eq!((&verdict["outcome"], &json["plan"]), (&"same".into(), &Value::Null));

    // A third of the bias takes nine times the 256 samples.
    let third = 100.0 * detectable / 3.0;
    let planned = folder.run(&format!("compare a.exr b.exr --plan {third}% --json")).succeeded();
    let plan = &serde_json::from_str::<Value>(&planned.stdout).unwrap()["plan"];
    let samples = plan["samples"][0].as_f64().unwrap();
    assert!((samples / 2304.0 - 1.0).abs() < 0.001 && plan["samples"][0] == plan["samples"][1], "{plan}");
    let planned = folder.run("compare a.exr b.exr --plan 0.1%").succeeded();
    assert!(planned.stdout.contains("plan ") && planned.stdout.contains("these samples"), "{planned:#?}");

    let other = folder.run("compare whitted.exr a.exr --map map.png");
    assert_eq!(other.code, Some(4), "{other:#?}");
    assert!(
        other.stdout.contains("they differ") && other.stdout.contains("biased by integrator whitted"),
        "{other:#?}"
    );
    let map = image::open(folder.path("map.png")).unwrap().to_rgb8();
    assert_eq!((map.width(), map.height()), (32, 32));
    // Without light between surfaces most of the box is darker: the cool arm has more blue than
    // red.
    let darker = map.pixels().filter(|p| p[2] > p[0]).count();
    assert!(darker > 512, "{darker} of 1024 pixels are shown as darker");

    let json = folder.run("compare whitted.exr a.exr --json");
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!(json["verdict"]["differ"], true);
    assert!(json["mean_relative"].as_f64().unwrap() < -0.05, "{json}");
    assert!(json["verdict"]["different_tiles"][0]["p"].as_f64().unwrap() < 1e-6, "{json}");
}

#[test]
fn an_image_is_itself() {
    let folder = Folder::new();
    folder.run("{box} --size 16x16 --spp 4 -o a.exr --quiet").succeeded();
    let json = folder.run("compare a.exr a.exr --json").succeeded();
    let json: Value = serde_json::from_str(&json.stdout).unwrap();
    assert_eq!((&json["rmse"], &json["flip"], &json["verdict"]["differ"]), (&0.0.into(), &0.0.into(), &false.into()));
}

#[test]
fn incomparable_images_are_reported() {
    let folder = Folder::new();
    folder.run("{box} --size 16x16 --spp 2 -o a.exr --quiet").succeeded();
    folder.run("{box} --size 16x12 --spp 2 -o small.exr --quiet").succeeded();
    std::fs::write(folder.path("text.exr"), "no image").unwrap();
    let before = folder.files();
    folder.run("compare a.exr small.exr --map map.png").failed_with(&["small.exr", "16x16", "16x12"]);
    folder.run("compare a.exr a.exr --reference-variance small.exr").failed_with(&["small.exr", "size"]);
    folder.run("compare a.exr text.exr").failed_with(&["text.exr"]);
    folder.run("compare gone.exr a.exr").failed_with(&["gone.exr", "not exist"]);
    folder.run("compare a.exr a.exr --map gone/map.png").failed_with(&["gone"]);
    assert_eq!(folder.files(), before);
}

/// A file with R, G, B and nothing else, as any renderer writes it.
fn foreign(folder: &Folder, name: &str, value: f32) {
    use exr::prelude::write_rgb_file;
    write_rgb_file(folder.path(name), 16, 16, |_, _| (value, value, value)).unwrap();
}

#[test]
fn images_of_other_renderers_get_metrics_and_with_a_variance_a_verdict() {
    let folder = Folder::new();
    folder.run("{box} --size 16x16 --spp 64 -o a.exr --quiet").succeeded();
    foreign(&folder, "other.exr", 0.5);
    foreign(&folder, "variance.exr", 1e-6);
    let plain = folder.run("compare a.exr other.exr --map map.png").succeeded();
    assert!(plain.stdout.contains("RMSE") && plain.stdout.contains("verdict   none"), "{plain:#?}");
    assert!(plain.stdout.contains("other.exr has no variance"), "{plain:#?}");
    assert!(folder.files().contains(&"map.png".to_owned()));
    let judged = folder.run("compare a.exr other.exr --reference-variance variance.exr");
    assert_eq!(judged.code, Some(4), "{judged:#?}");
}

#[test]
fn differences_below_noise_are_not_called_the_same() {
    let folder = Folder::new();
    folder.run("{box} --size 16x16 --spp 64 -o a.exr --quiet").succeeded();
    folder.run("{box} --size 16x16 --spp 64 --max-bounces 0 -o dark.exr --quiet").succeeded();
    foreign(&folder, "other.exr", 0.5);
    foreign(&folder, "noise.exr", 1e6);
    let noisy = "compare a.exr other.exr --reference-variance noise.exr";
    let output = folder.run(noisy).succeeded();
    assert!(output.stdout.contains("cannot tell") && output.stdout.contains("Tail.K"), "{output:#?}");
    let json: Value = serde_json::from_str(&folder.run(&format!("{noisy} --json")).succeeded().stdout).unwrap();
    assert_eq!((&json["verdict"]["outcome"], &json["verdict"]["differ"]), (&"cannot tell".into(), &false.into()));
    for (line, code) in [
        (format!("{noisy} --strict"), 5),
        ("compare a.exr other.exr --strict".into(), 5),
        ("compare a.exr a.exr --strict".into(), 0),
        ("compare dark.exr a.exr --strict".into(), 4),
    ] {
        let ended = folder.run(&line);
        assert_eq!(ended.code, Some(code), "{line}: {ended:#?}");
    }
}
