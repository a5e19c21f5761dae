//! The outputs of a render: both images, all layers, a consistent summary.

mod common;

use common::Folder;
use serde_json::Value;
use surelight_film::read_exr;

#[test]
fn a_render_leaves_both_images_and_a_summary() {
    let folder = Folder::new();
    let ran = folder.run("{box} --size 48x32 --spp 8 --json").succeeded();
    assert_eq!(folder.files(), ["cornell-box.exr", "cornell-box.png"]);

    let png = image::open(folder.path("cornell-box.png")).unwrap();
    assert_eq!((png.width(), png.height()), (48, 32));

    let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!((&summary["width"], &summary["height"], &summary["spp"]), (&48.into(), &32.into(), &8.into()));
    assert_eq!(summary["paths"], 48 * 32 * 8);
    assert!(summary["rays"].as_u64() >= summary["paths"].as_u64(), "{summary}");
    assert_eq!(summary["stopped"], "done");
    assert_eq!(summary["dropped_samples"], 0);
    assert_eq!(summary["biased"], Value::Array(vec![]));
    assert_eq!(summary["shared_paths"], false, "of so few paths, they are not");
    assert_eq!(summary["outputs"], serde_json::json!(["cornell-box.png", "cornell-box.exr"]));
    assert!(summary["adapter"]["name"].as_str().is_some_and(|name| !name.is_empty()), "{summary}");
    assert!(summary["peak_device_bytes"].as_u64() > Some(0), "{summary}");
    assert!(summary["relative_error"]["mean"].as_f64() > Some(0.0), "{summary}");
    let seconds = summary["seconds"].as_object().unwrap();
    let parts: f64 = seconds.iter().filter(|(stage, _)| *stage != "total").map(|(_, s)| s.as_f64().unwrap()).sum();
    assert!(parts > 0.0 && parts <= seconds["total"].as_f64().unwrap() * 1.001, "{summary}");
}

#[test]
fn the_exr_has_every_layer_and_says_how_it_was_made() {
    let folder = Folder::new();
    folder
        .run("render {box} --size 16x16 --spp 4 --seed 5 --max-radiance 9 --max-bounces 3 -o a.exr --quiet")
        .succeeded();
    assert_eq!(folder.files(), ["a.exr"]);
    let exr = read_exr(&folder.path("a.exr")).unwrap();
    assert_eq!((exr.width, exr.height), (16, 16));
    let layers = "R G B A Variance.R Variance.G Variance.B Samples.N \
                  Albedo.R Albedo.G Albedo.B N.X N.Y N.Z Depth.Z";
    for layer in layers.split_whitespace() {
        assert!(exr.channels.contains_key(layer), "{layer} is missing: {:?}", exr.channels.keys());
    }
    assert!(exr.channels["Samples.N"].iter().all(|&n| n == 4.0));
    assert!(exr.channels["Variance.R"].iter().any(|&v| v > 0.0));
    assert!(exr.channels["R"].iter().any(|&r| r > 0.0));
    assert!(exr.channels["Depth.Z"].iter().any(|&z| z > 0.0));

    let metadata = exr.surelight_metadata().unwrap();
    assert_eq!((metadata.seed, metadata.sample_range), (5, [0, 4]));
    assert_eq!(metadata.version, env!("CARGO_PKG_VERSION"));
    assert!(!metadata.device.is_empty());
    let biased = metadata.biased.join(" ");
    assert!(biased.contains("max-radiance") && biased.contains("max-bounces"), "{biased}");
}

#[test]
fn the_seed_alone_decides_the_noise() {
    let folder = Folder::new();
    for line in ["--seed 1 -o a.exr", "--seed 1 -o b.exr", "--seed 2 -o c.exr"] {
        folder.run(&format!("{{box}} --size 24x24 --spp 4 --quiet {line}")).succeeded();
    }
    let red = |name: &str| read_exr(&folder.path(name)).unwrap().channels["R"].clone();
    assert!(red("a.exr") == red("b.exr"), "one seed gave two images");
    assert!(red("a.exr") != red("c.exr"), "two seeds gave one image");
}

#[test]
fn time_stops_a_render() {
    let folder = Folder::new();
    // Time alone is the target: reached. Before a sample count it is a stop on the way.
    for (spp, code, stopped) in [("", 0, "done"), ("--spp 1000000", 3, "time")] {
        let ran = folder.run(&format!("{{box}} --size 16x16 --time 1.5s {spp} --json --quiet"));
        assert_eq!(ran.code, Some(code), "{ran:#?}");
        let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(summary["stopped"], stopped);
        assert!(summary["spp"].as_u64() >= Some(1));
        assert!(summary["seconds"]["total"].as_f64() < Some(15.0), "{summary}");
        assert_eq!(summary["checkpoint"].is_null(), code == 0, "{summary}");
    }
    assert_eq!(folder.files(), ["cornell-box.checkpoint.exr", "cornell-box.exr", "cornell-box.png"]);
}

/// In a room they do, by default: from as many paths on as make up for a kernel that takes longer
/// to compile, whatever part of them is rendered.
#[test]
fn path_reuse_is_chosen_where_it_pays() {
    let folder = Folder::new();
    let shares = |options: &str| {
        let ran = folder.run(&format!("{{box}} --json --quiet -o a.exr {options}")).succeeded();
        let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
        summary["shared_paths"].as_bool().unwrap()
    };
    assert!(shares("--size 64x64 --spp 64"));
    assert!(!shares("--size 64x63 --spp 64"));
    assert!(shares("--size 64x63 --spp 64 --shared-paths on"));
    assert!(shares("--size 64x64 --spp 64 --samples 4..8 --crop 8,8,16,16"));
    assert!(shares("--size 8x8 --time 0.01s"));
    assert!(!shares("--size 64x64 --spp 64 --shared-paths off"));
}

#[test]
fn quiet_is_quiet_and_a_log_is_lines() {
    let folder = Folder::new();
    let quiet = folder.run("{box} --size 8x8 --spp 1 --quiet --shared-paths on").succeeded();
    assert_eq!(quiet.stderr, "");
    assert!(quiet.stdout.lines().count() <= 4 && quiet.stdout.starts_with("image     "), "{}", quiet.stdout);
    let shared = folder.run("{box} --size 8x8 --spp 1 --shared-paths on").succeeded();
    assert!(shared.stdout.contains("samples   1 per pixel; 64 paths, shared by 2×2 pixels, "), "{}", shared.stdout);
    let log = folder.run("{box} --size 8x8 --spp 1").succeeded();
    assert!(
        log.stdout.contains("samples   1 per pixel; 64 paths, ") && !log.stdout.contains("shared"),
        "{}",
        log.stdout
    );
    assert!(!log.stderr.is_empty() && !log.stderr.contains(['\r', '\u{1b}']), "{:?}", log.stderr);
}

#[test]
fn awkward_sizes_render() {
    let folder = Folder::new();
    for size in ["1x1", "1x257", "257x1", "65x63"] {
        folder.run(&format!("{{box}} --size {size} --spp 2 --quiet -o {size}.exr")).succeeded();
        let exr = read_exr(&folder.path(&format!("{size}.exr"))).unwrap();
        assert_eq!(format!("{}x{}", exr.width, exr.height), size);
        assert!(exr.channels["Samples.N"].iter().all(|&n| n == 2.0), "{size}");
    }
}

#[test]
fn options_change_what_they_say() {
    let folder = Folder::new();
    let mean = |line: &str| {
        folder.run(&format!("{{box}} --size 16x16 --spp 4 --quiet -o a.exr {line}")).succeeded();
        let red = read_exr(&folder.path("a.exr")).unwrap().channels["R"].clone();
        red.iter().map(|&r| f64::from(r)).sum::<f64>() / red.len() as f64
    };
    let (full, direct, none) = (mean(""), mean("--max-bounces 1"), mean("--max-bounces 0"));
    assert!(none < direct && direct < full, "{none} {direct} {full}");
    // From far outside the box, the sky fills the image.
    let sky = mean("--eye 1000,1000,1000 --target 2000,2000,2000 --sky 0.25,0,0");
    assert!((sky - 0.25).abs() < 1e-6, "{sky}");
}

/// A file may hold nothing at all: then there is only the sky.
#[test]
fn an_empty_scene_is_sky() {
    let folder = Folder::new();
    std::fs::write(folder.path("empty.gltf"), "{\"asset\": {\"version\": \"2.0\"}}").unwrap();
    folder.run("empty.gltf --size 8x8 --spp 2 --quiet -o a.exr").succeeded();
    let exr = read_exr(&folder.path("a.exr")).unwrap();
    assert!(exr.channels["G"].iter().all(|&g| g == 1.0), "{:?}", exr.channels["G"]);
}

/// In a box in the dark most pixels have fewer samples than requested, some more; the file records
/// how many.
#[test]
fn adaptive_samples_are_reported() {
    let folder = Folder::new();
    let far = "{box} --size 40x40 --eye 0,1,12 --target 0,1,0 --sky 0,0,0 --quiet";
    let ran = folder.run(&format!("{far} --spp 64 --adaptive --json -o a.exr")).succeeded();
    let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
    let exr = read_exr(&folder.path("a.exr")).unwrap();
    let counts = &exr.channels["Samples.N"];
    let [least, most] = [f32::min, f32::max].map(|of| counts.iter().copied().reduce(of).unwrap());
    // A quarter of 60, and four of batches too short to be distributed.
    assert!(least == 19.0 && most > 128.0, "{least} to {most} samples");
    assert_eq!(summary["pixel_samples"], serde_json::json!([least as u64, most as u64]));
    assert_eq!(summary["spp"], 64);
    assert_eq!(summary["paths"].as_u64(), Some(counts.iter().map(|&n| n as u64).sum()), "{summary}");
    assert!(exr.surelight_metadata().unwrap().settings.unwrap().adaptive);
    let loud = far.replace(" --quiet", "");
    let ran = folder.run(&format!("{loud} --spp 64 --adaptive -o a.png")).succeeded();
    assert!(ran.stdout.contains(&format!("64 per pixel, {least} to {most} by noise")), "{}", ran.stdout);

    // Two parts are the whole, bit for bit, if both are adaptive.
    for range in ["0..24", "24..64"] {
        folder.run(&format!("{far} --spp 64 --samples {range} --adaptive -o {range}.exr")).succeeded();
    }
    folder.run("merge 0..24.exr 24..64.exr -o b.exr").succeeded();
    let joined = read_exr(&folder.path("b.exr")).unwrap();
    assert!(exr.channels.iter().all(|(name, channel)| *channel == joined.channels[name]), "merged parts differ");
    folder.run(&format!("{far} --spp 64 --samples 24..64 -o c.exr")).succeeded();
    folder.run("merge 0..24.exr c.exr -o d.exr").failed_with(&["adaptive"]);
}

/// A camera whose near plane lies beyond the box's back wall shows the sky alone, and says so;
/// `--clip off` shows the box.
#[test]
fn clipping_planes_are_followed_and_can_be_put_off() {
    let folder = Folder::new();
    let mut scene = surelight_scene::load(&common::cornell_box(), &surelight_scene::LoadOptions::default()).unwrap();
    scene.cameras[0].clip.near = 1e3;
    std::fs::write(folder.path("cut.glb"), surelight_scenes::glb::encode(&scene, "").unwrap()).unwrap();
    let render = |clip: &str| {
        let ran = folder.run(&format!("cut.glb --size 8x8 --spp 1 --json {clip} -o a.exr")).succeeded();
        let summary: Value = serde_json::from_str(&ran.stdout).unwrap();
        let exr = read_exr(&folder.path("a.exr")).unwrap();
        let is_warned = summary["warnings"].to_string().contains("nearer than znear = 1000 m");
        (is_warned, exr.channels["Depth.Z"].iter().any(|&z| z > 0.0), exr.surelight_metadata().unwrap())
    };
    let (is_warned, shown, metadata) = render("");
    assert!(is_warned && !shown && !metadata.settings.unwrap().unclipped);
    let (is_warned, shown, metadata) = render("--clip off");
    assert!(!is_warned && shown && metadata.settings.unwrap().unclipped);
}

/// The exposure that `auto` chooses is in the summary and in both files, and typed as a number it
/// gives the same picture.
#[test]
fn automatic_exposure_is_recorded() {
    let folder = Folder::new();
    let line = "{box} --size 24x24 --spp 4";
    let summary = folder.run(&format!("{line} --exposure auto --json -o auto.png -o auto.exr")).succeeded();
    let summary: Value = serde_json::from_str(&summary.stdout).unwrap();
    let ev = summary["exposure"]["ev"].as_f64().unwrap();
    assert_eq!(summary["exposure"]["automatic"], true);
    assert!(ev.abs() < 5.0 && ev != 0.0, "{summary}");
    let log_average = summary["exposure"]["log_average_luminance"].as_f64().unwrap();
    assert!((log_average * ev.exp2() / 0.18 - 1.0).abs() < 0.01, "{summary}");

    let typed = folder.run(&format!("{line} --exposure {ev} -o typed.png -o typed.exr")).succeeded().stdout;
    assert!(!typed.contains("EV"), "{typed}");
    let pixels = |name| image::open(folder.path(name)).unwrap();
    assert_eq!(pixels("auto.png"), pixels("typed.png"));
    let png = std::fs::read(folder.path("auto.png")).unwrap();
    let text = format!("surelight\0{{\"exposure\":{{\"ev\":{ev:?},\"automatic\":true}}}}");
    assert!(png.windows(text.len()).any(|window| window == text.as_bytes()), "{text}");

    let recorded = |name| read_exr(&folder.path(name)).unwrap().surelight_metadata().unwrap().exposure;
    let exposure = recorded("auto.exr").unwrap();
    assert_eq!((exposure.ev, exposure.automatic), (ev, true));
    assert_eq!(recorded("typed.exr"), None);
    let text = folder.run(&format!("{line} --exposure auto -o auto.png")).succeeded().stdout;
    assert!(text.contains(&format!("exposure {ev:+.1} EV (auto: log-average luminance ")), "{text}");
}

/// A picture without detail in its PNG comes with a hint; not where the exposure was chosen or
/// there is no PNG.
#[test]
fn a_picture_too_dark_or_bright_comes_with_a_hint() {
    let folder = Folder::new();
    for (radiance, loss, try_ev) in [(1.0 / 8192.0, "black", 11), (64.0, "clipped", -8)] {
        let line =
            format!("{{box}} --eye 0,0,99 --target 0,0,999 --size 8x8 --spp 2 --sky {radiance},{radiance},{radiance}");
        let hint = |options: &str| -> Value {
            let summary = folder.run(&format!("{line} --json {options}")).succeeded().stdout;
            serde_json::from_str::<Value>(&summary).unwrap()["exposure_hint"].clone()
        };
        let found = hint("-o a.png");
        assert_eq!(
            (&found["loss"], &found["share"], &found["try_ev"]),
            (&loss.into(), &1.0.into(), &f64::from(try_ev).into())
        );
        for none in ["-o a.exr", "-o a.png --exposure 0", "-o a.png --exposure auto"] {
            assert_eq!(hint(none), Value::Null, "{radiance} {none}");
        }
        let text = folder.run(&format!("{line} -o a.png")).succeeded().stdout;
        assert!(text.contains(&format!("try --exposure auto or --exposure {try_ev:+}")), "{text}");
    }
}
