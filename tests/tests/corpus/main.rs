//! Real files: a corpus of sample models, conformance suites and malformed files; and damaged ones
//! ([`fuzz`]), which need no corpus.
//!
//! Runs where `SURELIGHT_CORPUS` names its folder (from the repository's root, or absolute) and
//! says so where it does not: `SURELIGHT_CORPUS=FOLDER cargo test --release --test corpus --
//! --nocapture` prints a table of all files.

mod estimators;
mod fuzz;
mod loading;
mod models;
mod rendering;

use std::path::{Path, PathBuf};

/// The corpus' folder; `None`, with a word about it, where there is none.
fn corpus() -> Option<PathBuf> {
    let Some(named) = std::env::var_os("SURELIGHT_CORPUS") else {
        eprintln!("skipped: SURELIGHT_CORPUS names no folder, so nothing is checked");
        return None;
    };
    // Tests run in their crate's folder.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(named);
    assert!(folder.is_dir(), "SURELIGHT_CORPUS names {}, which is no folder", folder.display());
    Some(folder)
}

/// Files below a folder whose names end like scenes or environment maps, in order.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).expect("folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if matches!(path.extension().and_then(|e| e.to_str()), Some("gltf" | "glb" | "exr" | "hdr")) {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}
