//! Ctrl-C: the first writes image and checkpoint and exits with 3, the second ends at once.

#![cfg(unix)]

mod common;

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use common::{Folder, cornell_box};
use surelight_film::read_exr;

/// A render that would take days, once its first line in the log says that it traces.
fn started(folder: &Folder) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut child = folder
        .command([cornell_box().as_os_str()])
        .args(["--size", "64x64", "--spp", "100000000", "-o", "a.exr", "-o", "a.png", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut log = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    log.read_line(&mut line).unwrap();
    assert!(line.contains("tracing"), "{line}");
    (child, log)
}

fn interrupt(child: &Child) {
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn an_interrupt_saves_the_image() {
    let folder = Folder::new();
    let (mut child, mut log) = started(&folder);
    std::thread::sleep(Duration::from_millis(700));
    interrupt(&child);
    let (mut rest, mut summary) = (String::new(), String::new());
    log.read_to_string(&mut rest).unwrap();
    child.stdout.take().unwrap().read_to_string(&mut summary).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(3), "{rest}");
    assert_eq!(folder.files(), ["a.checkpoint.exr", "a.exr", "a.png"]);

    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["stopped"], "interrupt");
    let spp = summary["spp"].as_u64().unwrap();
    assert!(spp >= 1);
    let samples = &read_exr(&folder.path("a.exr")).unwrap().channels["Samples.N"];
    assert!(samples.iter().all(|&n| n as u64 == spp), "the image holds another number of samples than reported");
}

#[test]
fn a_second_interrupt_ends_at_once() {
    let folder = Folder::new();
    let (mut child, _log) = started(&folder);
    let start = Instant::now();
    // The first may already have ended it by the time of the second: both ways it ends.
    while child.try_wait().unwrap().is_none() {
        let _ = Command::new("kill").args(["-INT", &child.id().to_string()]).stderr(Stdio::null()).status();
        std::thread::sleep(Duration::from_millis(5));
        assert!(start.elapsed() < Duration::from_secs(20), "it does not end");
    }
    let code = child.wait().unwrap().code();
    assert!(matches!(code, Some(130 | 3)), "{code:?}");
}

/// Before there is anything to write, the first one ends the program, even where reading waits
/// without end.
#[test]
fn an_interrupt_while_loading_ends_at_once() {
    let folder = Folder::new();
    assert!(Command::new("mkfifo").arg(folder.path("pipe.glb")).status().unwrap().success());
    let mut child =
        folder.command(["pipe.glb", "-o", "a.png"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    interrupt(&child);
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(5));
        if start.elapsed() > Duration::from_secs(10) {
            child.kill().unwrap();
            panic!("it does not end");
        }
    }
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("error: interrupted before the first sample was done; nothing was written"), "{text}");
    assert_eq!(folder.files(), ["pipe.glb"]);
}
