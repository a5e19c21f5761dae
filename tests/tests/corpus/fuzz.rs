//! Damaged files by the thousand: seeds are changed in their JSON's structure, in their text and in
//! their bytes, and the result must load or be refused, soon, within bounded memory, and without a
//! panic.
//!
//! Seeds are the repository's own files, and those of the corpus where it is there.
//! `SURELIGHT_FUZZ_CASES=100000` runs that many cases instead of a short slice,
//! `SURELIGHT_FUZZ_SEED` others.

mod mutate;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use surelight_prepare::{Prepared, Settings};
use surelight_scene::{LoadOptions, load_bytes, load_environment};
use surelight_tests::random::Random;

use crate::loading::{LIMIT, check};
use crate::{corpus, files_below};

use mutate::{bytes, document};

/// Larger files would take their time and find no more.
const LARGEST_SEED: u64 = 64 << 10;
/// Files that a small .gltf names may be large.
const LARGEST_FOLDER: u64 = 2 << 20;
const SLICE: u32 = 2000;
const MAX_MEMORY: u64 = 1 << 30;

/// The current case, for a watchdog to report when it does not end.
#[derive(Clone, Default)]
struct Watch(Arc<Mutex<Option<(String, Instant)>>>);

impl Watch {
    /// Ends the process, with the case's name, when one takes longer than the limit.
    fn new() -> Self {
        let watch = Self::default();
        let watched = watch.clone();
        std::thread::spawn(move || {
            loop {
                std::thread::sleep(Duration::from_millis(500));
                if let Some((name, since)) = &*watched.0.lock().expect("the watch")
                    && since.elapsed() > LIMIT
                {
                    eprintln!("{name} takes longer than {LIMIT:?}");
                    std::process::abort();
                }
            }
        });
        watch
    }

    fn set(&self, case: Option<String>) {
        *self.0.lock().expect("the watch") = case.map(|name| (name, Instant::now()));
    }
}

fn from_environment(name: &str, usual: u32) -> u32 {
    std::env::var(name).map_or(usual, |text| text.parse().unwrap_or_else(|_| panic!("{name} is no number: {text}")))
}

fn seeds(extensions: &[&str]) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../assets"));
    if let Some(corpus) = corpus() {
        files.extend(files_below(&corpus));
    }
    files.retain(|path| path.extension().is_some_and(|e| extensions.contains(&e.to_string_lossy().as_ref())));
    files.retain(|path| path.metadata().is_ok_and(|m| m.len() <= LARGEST_SEED) && beside(path) <= LARGEST_FOLDER);
    files.into_iter().map(|path| (path.clone(), std::fs::read(&path).expect("a seed"))).collect()
}

/// Bytes of the files in a file's folder.
fn beside(file: &Path) -> u64 {
    let entries = file.parent().and_then(|folder| std::fs::read_dir(folder).ok());
    entries.into_iter().flatten().flatten().filter_map(|entry| Some(entry.metadata().ok()?.len())).sum()
}

/// The most memory that this process ever held; `None` where the system does not report it.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<u64>().ok()? << 10)
}

/// Runs cases until all are done; a case's bytes are kept when it panics.
fn run(
    kind: &str,
    seeds: &[(PathBuf, Vec<u8>)],
    change: impl Fn(&mut Random, &[u8], &[u8]) -> Vec<u8>,
    attempt: impl Fn(&Path, &[u8]) -> bool,
) {
    assert!(!seeds.is_empty());
    let (cases, first) = (from_environment("SURELIGHT_FUZZ_CASES", SLICE), from_environment("SURELIGHT_FUZZ_SEED", 0));
    let watch = Watch::new();
    let (mut accepted, mut failures, mut slowest) = (0, Vec::new(), (Duration::ZERO, String::new()));
    for case in 0..cases {
        let mut random = Random::new(Random::new(u64::from(first) << 32 | u64::from(case)).bits());
        let [(path, seed), (_, other)] = [0; 2].map(|_| &seeds[random.index(seeds.len())]);
        let damaged = change(&mut random, seed, other);
        let name = format!("{kind} case {case} of seed {first}, from {}", path.display());
        watch.set(Some(name.clone()));
        let started = Instant::now();
        match catch_unwind(AssertUnwindSafe(|| attempt(path, &damaged))) {
            Ok(loads) => accepted += u32::from(loads),
            Err(_) => {
                let kept = std::env::temp_dir().join(format!("surelight-fuzz-{kind}-{first}-{case}"));
                std::fs::write(&kept, &damaged).expect("a file");
                failures.push(format!("{name}: kept as {}", kept.display()));
            }
        }
        slowest = slowest.max((started.elapsed(), name));
        watch.set(None);
    }
    let memory = peak_memory();
    let (longest, slowest) = slowest;
    println!(
        "{kind}: {cases} cases from {} seeds, {accepted} load; memory at most {:?} MiB; {longest:.2?} for {slowest}",
        seeds.len(),
        memory.map(|m| m >> 20)
    );
    assert!(failures.is_empty(), "{failures:#?}");
    assert!(longest < LIMIT, "{slowest} took {longest:?}");
    assert!(memory.is_none_or(|m| m < MAX_MEMORY), "{memory:?} bytes");
    // Were nothing ever accepted, only the outermost check would have been tried.
    assert!(accepted >= cases / 25, "only {accepted} of {cases} cases load");
}

#[test]
fn damaged_scenes_load_or_are_refused() {
    let load = |path: &Path, file: &[u8]| {
        let Ok(scene) = load_bytes(file, path, &LoadOptions::default()) else { return false };
        check(&scene);
        if scene.triangle_count() < 200_000 {
            let camera = scene.cameras.first().cloned().unwrap_or_else(|| scene.frame_camera(1.0));
            // Refusing is right, too.
            let _ = Prepared::new(&scene, &camera, &Settings::new(16, 16));
        }
        true
    };
    run("scene", &seeds(&["glb", "gltf"]), document, load);
}

#[test]
fn damaged_environments_load_or_are_refused() {
    // Most damaged maps of the corpus fail at once, whatever is changed besides.
    let mut seeds = seeds(&["exr", "hdr"]);
    seeds.retain(|(path, _)| load_environment(path).is_ok());
    seeds.push((PathBuf::from("run-length.hdr"), run_length_hdr()));
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("map");
    let load = |_: &Path, damaged: &[u8]| {
        std::fs::write(&file, damaged).expect("a file");
        let Ok(map) = load_environment(&file) else { return false };
        assert_eq!(map.texels.len(), map.width as usize * map.height as usize);
        assert!(map.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
        true
    };
    run("environment", &seeds, bytes, load);
}

/// 16 × 8 texels: each channel of a row a run of eight and eight single bytes.
fn run_length_hdr() -> Vec<u8> {
    let mut file = b"#?RADIANCE\nEXPOSURE=2.0\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n".to_vec();
    for row in 0..8 {
        file.extend([2, 2, 0, 16]);
        for channel in 0..4 {
            file.extend([128 + 8, 100 + row, 8]);
            file.extend((0..8).map(|i| 90 + 10 * channel + i));
        }
    }
    file
}

#[test]
fn the_seed_of_run_lengths_is_valid() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    std::fs::write(file.path(), run_length_hdr()).expect("a file");
    let map = load_environment(file.path()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((map.width, map.height), (16, 8));
}
