//! Wrong usage is told with exit code 2, help and version with 0; neither touches a scene or a device.

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

#[test]
fn devices_lists_what_render_can_use() {
    let text = Folder::new().run("devices").succeeded().stdout;
    assert!(text.starts_with("0  ") && text.contains("driver "), "{text}");
    let json = Folder::new().run("devices --json").succeeded().stdout;
    let list: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert!(list[0]["max_binding_bytes"].as_u64() > Some(0), "{json}");
}

#[test]
fn info_tells_contents_kernel_and_gaps() {
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
