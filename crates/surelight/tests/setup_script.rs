//! `setup.sh` on simulated machines: its tools are replaced by scripts that record their arguments.

#![cfg(target_os = "linux")]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A machine made of scripts in a folder.
struct Machine {
    folder: tempfile::TempDir,
}

impl Machine {
    /// With these package managers, a plain user and sudo; no Vulkan loader yet, which any
    /// installation provides.
    fn new(managers: &[&str]) -> Self {
        let machine = Self { folder: tempfile::tempdir().unwrap() };
        fs::create_dir(machine.path("bin")).unwrap();
        let folder = machine.folder.path().display();
        machine.tool("ldconfig", &format!("cat {folder}/libraries"));
        machine.tool("id", "echo 1000");
        machine.tool("uname", "echo Linux");
        machine.tool("sudo", &format!("echo sudo >> {folder}/log; exec \"$@\""));
        machine.tool("cargo", "");
        machine.tool("cc", "");
        machine.tool("rustc", "echo 'rustc 99.0.0'");
        for manager in managers {
            let install = format!("echo {manager} \"$@\" >> {folder}/log; echo libvulkan.so.1 > {folder}/libraries");
            machine.tool(manager, &install);
        }
        for name in ["sh", "cat", "sed", "head", "ls", "dirname", "env"] {
            let real = ["/usr/bin", "/bin"].iter().map(|bin| Path::new(bin).join(name)).find(|p| p.exists()).unwrap();
            std::os::unix::fs::symlink(real, machine.path("bin").join(name)).unwrap();
        }
        for name in ["libraries", "log"] {
            fs::write(machine.path(name), "").unwrap();
        }
        machine
    }

    /// A driver of this library, which is there.
    fn with_driver(self, library: &str) -> Self {
        let library = self.path(library);
        fs::write(&library, "").unwrap();
        let manifest = format!("{{\"ICD\": {{\"library_path\": \"{}\"}}}}", library.display());
        fs::write(self.path("icd.json"), manifest).unwrap();
        self
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn tool(&self, name: &str, body: &str) {
        let path = self.path("bin").join(name);
        fs::write(&path, format!("#!/bin/sh\n{body}\n")).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }

    fn run(&self) -> Output {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../setup.sh");
        Command::new("/bin/sh")
            .arg(script)
            .env_clear()
            .env("PATH", self.path("bin"))
            .env("HOME", self.folder.path())
            .env("VK_DRIVER_FILES", self.path("icd.json"))
            .output()
            .unwrap()
    }

    fn log(&self) -> String {
        fs::read_to_string(self.path("log")).unwrap()
    }
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn nothing_is_installed_where_nothing_is_missing() {
    let machine = Machine::new(&["apt-get"]).with_driver("libvulkan_lvp.so");
    fs::write(machine.path("libraries"), "\tlibvulkan.so.1 (libc6,x86-64) => /lib/libvulkan.so.1\n").unwrap();
    let output = machine.run();
    assert!(output.status.success(), "{}", text(&output));
    assert!(text(&output).contains("nothing to install"), "{}", text(&output));
    assert_eq!(machine.log(), "");
}

#[test]
fn each_distribution_is_served_with_its_own_packages_and_only_once() {
    for (manager, packages) in [
        ("apt-get", "libvulkan1 mesa-vulkan-drivers"),
        ("dnf", "vulkan-loader mesa-vulkan-drivers"),
        ("pacman", "vulkan-icd-loader vulkan-swrast"),
    ] {
        let machine = Machine::new(&[manager]).with_driver("libvulkan_lvp.so");
        let first = machine.run();
        assert!(first.status.success(), "{manager}: {}", text(&first));
        assert!(text(&first).contains("installed: Vulkan loader"), "{manager}: {}", text(&first));
        let log = machine.log();
        assert!(log.contains(packages) && log.contains("sudo"), "{manager}: {log}");
        let second = machine.run();
        assert!(text(&second).contains("nothing to install"), "{manager}: {}", text(&second));
        assert_eq!(machine.log(), log, "{manager}: the second run installed again");
    }
}

#[test]
fn an_unknown_distribution_learns_which_packages_are_missing() {
    let machine = Machine::new(&[]).with_driver("libvulkan_lvp.so");
    let output = machine.run();
    assert!(!output.status.success());
    assert!(text(&output).contains("libvulkan.so.1"), "{}", text(&output));
}

#[test]
fn missing_rust_is_reported_and_not_installed() {
    let machine = Machine::new(&["apt-get"]).with_driver("libvulkan_lvp.so");
    fs::write(machine.path("libraries"), "libvulkan.so.1").unwrap();
    fs::remove_file(machine.path("bin/cargo")).unwrap();
    let output = machine.run();
    assert!(!output.status.success() && text(&output).contains("rustup.rs"), "{}", text(&output));

    machine.tool("cargo", "");
    machine.tool("rustc", "echo 'rustc 1.70.0 (90c541806 2023-05-31)'");
    let output = machine.run();
    assert!(!output.status.success() && text(&output).contains("this is 1.70"), "{}", text(&output));
    assert_eq!(machine.log(), "");
}

#[test]
fn a_driver_whose_library_is_gone_does_not_count() {
    let machine = Machine::new(&["apt-get"]).with_driver("libvulkan_lvp.so");
    fs::write(machine.path("libraries"), "libvulkan.so.1").unwrap();
    fs::remove_file(machine.path("libvulkan_lvp.so")).unwrap();
    let output = machine.run();
    assert!(!output.status.success() && text(&output).contains("no usable driver"), "{}", text(&output));
}

#[test]
fn macos_and_windows_need_nothing() {
    for (system, interface) in [("Darwin", "Metal"), ("MINGW64_NT-10.0", "Direct3D 12")] {
        let machine = Machine::new(&["apt-get"]);
        machine.tool("uname", &format!("echo {system}"));
        let output = machine.run();
        assert!(output.status.success() && text(&output).contains(interface), "{}", text(&output));
        assert_eq!(machine.log(), "");
    }
}
