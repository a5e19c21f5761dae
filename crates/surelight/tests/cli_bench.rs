//! `surelight bench` from end to end on a tiny scene: the report, its data, resuming, Ctrl-C,
//! comparing, refused options.

mod common;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::{Folder, Ran, cornell_box};
use serde_json::Value;
use surelight_bench::{data::CSV_COLUMNS, report::read_data};

/// Two methods, two repeats, a picture of 32×32 pixels: seconds.
const TINY: &str =
    "bench {box} --size 32x32 --vary integrator=mis,whitted --vary sampler=independent --repeats 2 --quiet";

fn text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path(name)).unwrap()
}

/// Every element that is opened is closed, in order. Void elements of the page end with `/>`.
fn is_well_formed(html: &str) -> Result<(), String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html.strip_prefix("<!DOCTYPE html>").ok_or("no DOCTYPE")?;
    while let Some(start) = rest.find('<') {
        if rest[..start].contains('>') {
            return Err(format!("a stray > before {:.60}", &rest[start..]));
        }
        let end = start + rest[start..].find('>').ok_or("a tag does not end")?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            if open.pop() != Some(name) {
                return Err(format!("</{name}> closes something else"));
            }
        } else if !tag.ends_with('/') {
            /// Elements without an end tag (HTML Living Standard, 13.1.2).
            const VOID: [&str; 6] = ["br", "col", "hr", "img", "link", "meta"];
            let name = tag.split_whitespace().next().unwrap_or_default();
            if !VOID.contains(&name) {
                open.push(name);
            }
            if name == "style" {
                rest = &rest[rest.find("</style>").ok_or("style does not end")?..];
            }
        }
    }
    if open.is_empty() { Ok(()) } else { Err(format!("not closed: {open:?}")) }
}

#[test]
fn a_report_is_whole_and_its_data_are_right() {
    let folder = Folder::new();
    let larger = TINY.replace("32x32", "48x48").replace("--repeats 2", "--repeats 4");
    let ran = folder.run(&format!("{larger} --spp 128 -o report --note shared")).succeeded();
    assert!(ran.stdout.contains("cornell-box: ") && ran.stdout.contains("index.html"), "{}", ran.stdout);

    let page = text(&folder, "report/index.html");
    assert_eq!(is_well_formed(&page), Ok(()));
    // Nothing is fetched, nothing is run.
    for outside in ["src=\"http", "href=\"http", "<script", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    for part in [
        "mis/independent",
        "whitted/independent (biased)",
        "data:image/png;base64,",
        "shared",
        "is traversal of the BVH",
    ] {
        assert!(page.contains(part), "{part}");
    }
    for chart in ["error-time", "error-samples", "front", "calibration", "bias", "stages"] {
        assert!(text(&folder, &format!("report/cornell-box/{chart}.svg")).starts_with("<svg"), "{chart}");
        assert!(
            image::open(folder.path(&format!("report/cornell-box/{chart}.png"))).unwrap().width() > 1000,
            "{chart}"
        );
    }
    for picture in ["reference", "mis-independent", "mis-independent-error", "whitted-independent"] {
        let size = image::open(folder.path(&format!("report/cornell-box/{picture}.png"))).unwrap();
        assert_eq!((size.width(), size.height()), (48, 48), "{picture}");
    }

    let csv = text(&folder, "report/data.csv");
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some(CSV_COLUMNS.join(",").as_str()));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.iter().all(|row| row.len() == CSV_COLUMNS.len()));
    // 1, 2, 4, … 128 samples, two methods, four repeats.
    assert_eq!(rows.len(), 8 * 2 * 4);
    let column = |name: &str| CSV_COLUMNS.iter().position(|c| *c == name).unwrap();
    for row in &rows {
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert_eq!(number("paths"), 48.0 * 48.0 * number("spp"));
        assert!(number("device_s") > 0.0 && number("rays") > number("paths"));
        assert!(number("dispatch_s") >= 0.999 * number("device_s") && number("wall_s") >= number("dispatch_s"));
    }

    // The page is computed from the rows.
    let data = read_data(&folder.path("report/data.json")).unwrap();
    let scene = &data.scenes[0];
    assert_eq!((scene.rows.len(), scene.methods.len()), (rows.len(), 2));
    assert!(scene.methods[0].biased.is_none() && scene.methods[1].biased.is_some());
    for (row, line) in scene.rows.iter().zip(&rows) {
        assert!((row.rel_mse - line[column("rel_mse")].parse::<f64>().unwrap()).abs() <= 1e-6 * row.rel_mse.abs());
    }
    // Independent samples converge as N^−½; with other seeds the slope was −0.494, −0.504, −0.494,
    // each ± 0.015.
    let slope = scene.slope(0).unwrap();
    assert!((slope.value + 0.5).abs() < 0.05 && slope.high - slope.low < 0.1, "{slope:?}");
    // Whitted's has a floor.
    let end = |method| scene.curve(method).last().unwrap().error;
    assert!(end(1) > 3.0 * end(0), "{} {}", end(0), end(1));
    assert!(scene.bias(0).unwrap().holds(0.0) && scene.bias(1).unwrap().high < -0.05);
    let coverage = scene.at_end(0, |r| r.coverage).unwrap();
    assert!((0.9..0.99).contains(&coverage), "{coverage}");
}

#[test]
fn resuming_measures_only_missing_trials() {
    let folder = Folder::new();
    folder.run(&format!("{TINY} --spp 8 -o report")).succeeded();
    // As if it had been interrupted in the second repeat of the second method.
    let path = folder.path("report/data.json");
    let mut data: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let rows = data["scenes"][0]["rows"].as_array_mut().unwrap();
    let all = rows.clone();
    rows.retain(|r| !(r["method"] == 1 && r["repeat"] == 1 && r["spp"].as_u64() > Some(2)));
    assert_eq!(rows.len() + 2, all.len());
    std::fs::write(&path, data.to_string()).unwrap();

    folder.run(&format!("{TINY} --spp 8 -o report --resume")).succeeded();
    let again = read_data(&path).unwrap();
    let rows = &again.scenes[0].rows;
    assert_eq!(rows.len(), all.len());
    for old in &all {
        let new = rows
            .iter()
            .find(|r| old["method"] == r.method && old["repeat"] == r.repeat && old["spp"] == r.spp)
            .unwrap();
        // The same samples and reference, whenever they are traced; times stay where nothing was
        // done again.
        assert!((new.rel_mse / old["rel_mse"].as_f64().unwrap() - 1.0).abs() < 1e-6);
        let redone = (new.method, new.repeat) == (1, 1);
        assert!(redone || old["wall_seconds"] == new.wall_seconds);
    }
    // Of a complete race only the report is written again.
    std::fs::remove_file(folder.path("report/index.html")).unwrap();
    folder.run(&format!("{TINY} --spp 8 -o report --resume")).succeeded();
    assert_eq!(read_data(&path).unwrap().scenes, again.scenes);
    assert!(text(&folder, "report/index.html").contains("mis/independent"));
    let other = folder.run(&format!("{TINY} --spp 8 -o report --resume --vary max-bounces=2"));
    other.failed_with(&["cannot be resumed", "other methods"]);
}

#[test]
fn versions_are_compared_and_a_planted_loss_is_found() {
    let folder = Folder::new();
    folder.run(&format!("{TINY} --spp 16 -o report")).succeeded();
    // A report against itself has lost nothing.
    let same = folder.run("bench -o report --compare report/data.json").succeeded();
    assert!(same.stdout.contains("verdict: no loss"), "{}", same.stdout);

    // An old version whose picture was a tenth darker: some ten standard errors of so small a race.
    let mut old: Value = serde_json::from_str(&text(&folder, "report/data.json")).unwrap();
    for row in old["scenes"][0]["rows"].as_array_mut().unwrap() {
        let mean = row["mean"].as_f64().unwrap();
        row["mean"] = (0.9 * mean).into();
    }
    std::fs::write(folder.path("old.json"), old.to_string()).unwrap();
    let lost = folder.run("bench -o report --compare old.json");
    assert_eq!(lost.code, Some(4), "{lost:#?}");
    assert!(lost.stdout.contains("LOSS another picture"), "{}", lost.stdout);
    assert!(text(&folder, "report/comparison.json").contains("another picture"));

    std::fs::write(folder.path("no.json"), "{\"schema\": 99}").unwrap();
    folder.run("bench -o report --compare no.json").failed_with(&["no.json", "schema 99"]);
}

#[test]
#[cfg(unix)]
fn an_interrupt_keeps_what_was_measured() {
    let folder = Folder::new();
    let scene = cornell_box();
    let mut child = folder
        .command([
            "bench",
            scene.to_str().unwrap(),
            "--size",
            "32x32",
            "--vary",
            "integrator=mis",
            "--vary",
            "sampler=sobol",
        ])
        .args(["--spp", "256", "--repeats", "1000", "-o", "report", "--quiet"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let data = folder.path("report/data.json");
    let start = Instant::now();
    while !measured(&data) {
        assert!(start.elapsed() < Duration::from_secs(100), "nothing is measured");
        assert_eq!(child.try_wait().unwrap(), None, "it ended by itself");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let ran = Ran::from(child.wait_with_output().unwrap());
    assert_eq!(ran.code, Some(3), "{ran:#?}");
    assert!(ran.stdout.contains("--resume"), "{ran:#?}");
    assert!(read_data(&data).unwrap().scenes[0].rows.iter().any(|r| r.spp == 256));
    assert_eq!(is_well_formed(&text(&folder, "report/index.html")), Ok(()));
}

#[test]
fn shared_paths_can_be_raced() {
    let folder = Folder::new();
    let race = "bench {box} --size 16x16 --spp 4 --repeats 2 --vary integrator=mis --vary sampler=sobol -o r --quiet";
    let ran = folder.run(&format!("{race} --vary shared-paths=off,on --vary max-bounces=1,unlimited")).succeeded();
    let data = read_data(&folder.path("r/data.json")).unwrap();
    let methods = data.scenes[0].methods.iter();
    let raced: Vec<_> = methods.map(|m| (m.name.as_str(), m.words.shared_paths.as_str())).collect();
    let [alone, shared] = ["mis/sobol", "mis/sobol, shared paths"];
    let [alone_once, shared_once] = [alone, shared].map(|name| format!("{name} ≤ 1 bounce"));
    assert_eq!(raced, [(&*alone_once, "off"), (&*shared_once, "on"), (alone, "off"), (shared, "on")]);
    // Light of one bounce is from lamps alone.
    let output: Vec<_> = ran.stdout.lines().filter(|line| line.contains("path reuse has no effect")).collect();
    assert_eq!(output, [format!("warning: {shared_once}: path reuse has no effect on this scene")]);
    // With path reuse, more rays are traced for as many paths.
    let rays = |method| data.scenes[0].rows_of(method).filter(|row| row.spp == 4).map(|row| row.rays).sum::<u64>();
    assert_eq!(rays(0), rays(1));
    assert!(rays(3) > rays(2) + rays(2) / 10, "{} against {}", rays(3), rays(2));
}

#[cfg(unix)]
fn measured(data: &Path) -> bool {
    read_data(data).is_ok_and(|data| data.scenes[0].is_complete(0, 0))
}

#[test]
fn a_given_reference_and_other_renderers_are_taken() {
    let folder = Folder::new();
    folder.run("{box} --size 32x32 --spp 256 --seed 9 -o ref.exr --quiet").succeeded();
    std::fs::write(folder.path("peers.csv"), "scene,renderer,seconds,rel_mse\ncornell-box,Elsewhere,0.5,0.01\n")
        .unwrap();
    folder.run(&format!("{TINY} --spp 4 -o report --reference ref.exr --overlay peers.csv")).succeeded();
    let page = text(&folder, "report/index.html");
    assert!(page.contains("Elsewhere") && page.contains("reference by ref.exr with 256 samples per pixel"));
    // A race between renderers, drawn on existing measurements; its pictures had 256×256 pixels.
    let races = r#"[{"scene": "cornell-box", "renderer": "Somebody", "spp": 64, "mpaths": 4.0, "relmse": 0.005, "efficiency": 190.735}]"#;
    std::fs::write(folder.path("races.json"), races).unwrap();
    let ran = folder.run(&format!("{TINY} --spp 4 -o report --resume --overlay races.json")).succeeded();
    assert!(ran.stdout.contains("are of pictures of 65536 pixels, these have 1024"), "{}", ran.stdout);
    assert!(text(&folder, "report/index.html").contains("Somebody"));

    let wrong = folder.run("bench {box} --size 16x16 --spp 4 --reference ref.exr --quiet --vary integrator=mis");
    wrong.failed_with(&["ref.exr", "32x32 pixels", "16x16"]);
    std::fs::write(folder.path("bad.csv"), "scene,seconds\n").unwrap();
    folder.run("bench {box} --spp 4 --overlay bad.csv --quiet").failed_with(&["bad.csv", "no column"]);
    let usage = folder.run("bench {box} --vary bounces=3");
    assert!(usage.code == Some(2) && usage.stderr.contains("there is no option"), "{usage:#?}");
}
