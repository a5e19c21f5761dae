//! Wrong usage has exit code 2, help and version with 0; neither touches a scene or a device.

mod common;

use common::Folder;

#[test]
fn wrong_usage_exits_with_2_and_writes_nothing() {
    let folder = Folder::new();
    for line in [
        "",
        "render",
        "a.glb --no-such-option",
        "a.glb --size 12",
        "a.glb --spp 0",
        "a.glb --time soon",
        "a.glb -o picture.jpg",
        "a.glb --env a.hdr --sky 1,1,1",
        "a.glb --eye 0,0,0",
        "a.glb --tonemap filmic",
        "info",
        "a.glb --integrator area --directions cosine",
        "a.glb --error 0%",
        "a.glb --confidence 95%",
    ] {
        let ran = folder.run(line);
        assert_eq!(ran.code, Some(2), "{line}: {ran:#?}");
        assert_eq!(ran.stdout, "", "{line}");
        assert!(!ran.stderr.is_empty(), "{line}");
    }
    assert!(folder.files().is_empty());
}

#[test]
fn help_names_every_command_and_exit_code() {
    let ran = Folder::new().run("--help").succeeded();
    for word in
        ["render", "info", "devices", "--spp", "--integrator", "--sampler", "--max-bounces", "--env", "Exit codes"]
    {
        assert!(ran.stdout.contains(word), "{word}: {}", ran.stdout);
    }
    let version = Folder::new().run("--version").succeeded();
    assert_eq!(version.stdout, concat!("surelight ", env!("CARGO_PKG_VERSION"), "\n"));
}

/// `-h` fits a screen: a line for each option that most people need, and the names of all others.
#[test]
fn the_short_help_is_one_screen_and_names_every_option() {
    let short = Folder::new().run("-h").succeeded().stdout;
    assert!(short.lines().count() <= 48, "{short}");
    assert!(short.lines().all(|line| line.chars().count() <= 100), "{short}");
    let first = "--output --size --spp --time --error --integrator --env --camera --exposure --quiet --help --version";
    let explained = short.lines().skip_while(|line| *line != "Options:").skip(1).take_while(|line| !line.is_empty());
    let explained: Vec<_> = explained.collect();
    for (line, option) in explained.iter().zip(first.split(' ')) {
        assert!(line.contains(option), "{line:?} lacks {option}");
    }
    assert_eq!(explained.len(), first.split(' ').count(), "{short}");

    let long = Folder::new().run("--help").succeeded().stdout;
    let options: Vec<_> =
        long.lines().filter_map(|line| line.trim_start_matches(" -oqhV,").trim().strip_prefix("--")).collect();
    assert!(options.len() > 30, "{long}");
    for option in options {
        let name = option.split([' ', '=']).next().unwrap();
        assert!(short.contains(&format!("--{name}")), "--{name} is missing in\n{short}");
    }
    for heading in ["Sampling:", "Camera:", "Environment:", "Scene:", "Picture:", "Parts and resuming:"] {
        assert!(long.lines().any(|line| line == heading), "{heading} is missing in\n{long}");
    }
}

#[test]
fn every_command_has_a_short_help() {
    for command in ["render", "info", "measure", "integrate", "compare", "bench", "merge", "devices"] {
        let short = Folder::new().run(&format!("{command} -h")).succeeded().stdout;
        let long = Folder::new().run(&format!("{command} --help")).succeeded().stdout;
        assert!(short.contains("Usage: ") && short.lines().count() <= long.lines().count(), "{command}: {short}");
    }
}

#[test]
fn devices_lists_what_render_can_use() {
    let text = Folder::new().run("devices").succeeded().stdout;
    assert!(text.starts_with("0  ") && text.contains("driver "), "{text}");
    let json = Folder::new().run("devices --json").succeeded().stdout;
    let list: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(list[0]["max_binding_bytes"].as_u64() > Some(0), "{json}");
}

#[test]
fn info_lists_contents_kernel_and_gaps() {
    let folder = Folder::new();
    let text = folder.run("info {box}").succeeded().stdout;
    for word in ["triangles", "cameras", "area_lights", "does without", "transmission"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let json: serde_json::Value = serde_json::from_str(&folder.run("info {box} --json").succeeded().stdout).unwrap();
    assert!(json["triangles_placed"].as_u64() > Some(10), "{json}");
    let kernel = json["kernel"].as_array().unwrap();
    let part = |name: &str| kernel.iter().find(|part| part["name"] == name).unwrap();
    assert_eq!(part("area_lights")["included"], true);
    assert!(part("area_lights")["because"].as_str().unwrap().contains("material"), "{json}");
    assert_eq!(part("environment_map")["included"], false);
    assert!(folder.files().is_empty());
}

/// A reader that goes away early is no error, and above all no panic.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    use std::process::Stdio;
    let folder = Folder::new();
    let mut child = folder
        .command([std::ffi::OsStr::new("info"), common::cornell_box().as_os_str()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}
