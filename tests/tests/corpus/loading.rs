//! Every valid file loads with the triangles that the index states, and no malformed one panics or
//! hangs.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use surelight_scene::{LoadOptions, load, load_environment};

use crate::{corpus, files_below};

/// No file may take longer.
pub(crate) const LIMIT: Duration = Duration::from_secs(10);

/// Result of loading a file: triangles (or texels) and warnings, or the message.
type Outcome = Result<(usize, Vec<String>), String>;

/// Loads in a separate thread; `None` when the thread panicked, and a panic of this test when it
/// hangs.
fn attempt(path: &Path) -> Option<Outcome> {
    let (sender, receiver) = mpsc::channel();
    let owned = path.to_path_buf();
    let thread = std::thread::spawn(move || {
        let kind = owned.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let outcome = if matches!(kind.as_deref(), Some("exr" | "hdr")) {
            load_environment(&owned).map(|map| {
                assert!(map.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
                (map.texels.len(), Vec::new())
            })
        } else {
            load(&owned, &LoadOptions::default()).map(|scene| {
                check(&scene);
                (scene.triangle_count(), scene.warnings)
            })
        };
        let _ = sender.send(outcome.map_err(|e| e.to_string()));
    });
    match receiver.recv_timeout(LIMIT) {
        Ok(outcome) => Some(outcome),
        Err(mpsc::RecvTimeoutError::Disconnected) => {
            assert!(thread.join().is_err());
            None
        }
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{} takes longer than {LIMIT:?}", path.display()),
    }
}

/// The promises of the data model's documentation.
pub(crate) fn check(scene: &surelight_scene::Scene) {
    assert_eq!(scene.validate(), Ok(()));
    for mesh in &scene.meshes {
        assert!(mesh.normals.iter().flatten().all(|v| v.is_normalized()));
        let tangents = mesh.tangents.iter().flatten();
        assert!(tangents.clone().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0));
        assert!(mesh.uvs.iter().flatten().all(|uv| uv.is_finite()));
        assert!(mesh.colors.iter().flatten().all(|c| c.is_finite()));
        let material = &scene.materials[mesh.material];
        assert!(mesh.tangents.is_some() || material.normal_texture.is_none());
        for (texture, what) in [
            (&material.base_color_texture, "base colour"),
            (&material.metallic_roughness_texture, "metallic-roughness"),
            (&material.emissive_texture, "emissive"),
        ] {
            if let Some(texture) = texture {
                assert!((texture.uv_set as usize) < mesh.uvs.len(), "{what}");
            }
        }
    }
    for material in &scene.materials {
        assert!(material.emissive.iter().all(|c| c.is_finite() && *c >= 0.0));
        assert!((0.0..=1.0).contains(&material.roughness) && (0.0..=1.0).contains(&material.metallic));
    }
    let framed = scene.frame_camera(1.5);
    assert!(framed.to_world.is_finite());
}

/// File → (stored, placed) triangles, from the tables of INDEX.md.
fn index(corpus: &Path) -> Vec<(PathBuf, usize)> {
    let text = std::fs::read_to_string(corpus.join("INDEX.md")).expect("INDEX.md");
    let mut section = "";
    let mut files = Vec::new();
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            section = name.trim();
        }
        if !["materials", "geometry", "textures", "scenes"].contains(&section) {
            continue;
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, file, _, _, _, triangles, ..] = cells[..] else { continue };
        if !(file.ends_with(".glb") || file.ends_with(".gltf")) {
            continue;
        }
        // "stored / placed" where they differ.
        let placed = triangles.rsplit('/').next().and_then(|n| n.trim().parse().ok()).expect(line);
        files.push((corpus.join(section).join(file), placed));
    }
    files
}

#[test]
fn valid_files_load_with_their_triangles() {
    let Some(corpus) = corpus() else { return };
    let files = index(&corpus);
    assert!(files.len() > 60, "INDEX.md lists {} files", files.len());
    let mut failures = Vec::new();
    for (path, expected) in files {
        let short = path.strip_prefix(&corpus).unwrap_or(&path).display().to_string();
        let start = Instant::now();
        let outcome = attempt(&path);
        let ms = start.elapsed().as_millis();
        match outcome {
            Some(Ok((triangles, warnings))) => {
                println!("{ms:5} ms  {triangles:8} triangles  {short}  {warnings:?}");
                if triangles != expected {
                    failures.push(format!("{short}: {triangles} triangles, and the index states {expected}"));
                }
            }
            Some(Err(message)) => {
                println!("{ms:5} ms  refused  {short}: {message}");
                failures.push(message);
            }
            None => failures.push(format!("{short}: panicked")),
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn malformed_files_are_refused_or_load_and_never_panic() {
    let Some(corpus) = corpus() else { return };
    let files = files_below(&corpus.join("malformed"));
    assert!(files.len() > 200, "only {} malformed files", files.len());
    let mut counts: HashMap<&str, usize> = HashMap::new();
    let mut failures = Vec::new();
    for path in files {
        let short = path.strip_prefix(&corpus).unwrap_or(&path).display().to_string();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let kind = match attempt(&path) {
            Some(Ok((size, warnings))) => {
                println!("loads    {short}: {size} triangles or texels, {warnings:?}");
                "loads"
            }
            Some(Err(message)) => {
                println!("refused  {message}");
                // One sentence that names the file.
                if !message.contains(&name) && !message.contains("cannot read") || !message.ends_with('.') {
                    failures.push(format!("{short}: {message:?} does not name the file"));
                }
                "refused"
            }
            None => {
                failures.push(format!("{short}: panicked"));
                "panicked"
            }
        };
        *counts.entry(kind).or_default() += 1;
    }
    println!("{counts:?}");
    assert!(failures.is_empty(), "{failures:#?}");
}

#[test]
fn environment_maps_load() {
    let Some(corpus) = corpus() else { return };
    for path in files_below(&corpus.join("environments")) {
        let start = Instant::now();
        let map = load_environment(&path).unwrap_or_else(|e| panic!("{e}"));
        println!("{:4} ms  {} × {}  {}", start.elapsed().as_millis(), map.width, map.height, path.display());
        assert_eq!(map.texels.len(), map.width as usize * map.height as usize);
        assert!(map.texels.iter().flatten().any(|&c| c > 0.0));
    }
}

#[test]
fn the_asset_generator_loads() {
    let Some(corpus) = corpus() else { return };
    let files = files_below(&corpus.join("geometry/asset-generator"));
    assert!(files.len() > 100, "only {} files", files.len());
    let mut triangles = 0;
    for path in files {
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        // A later version and a required extension: the two that must be refused.
        let must_fail = matches!(name.as_str(), "Compatibility_04" | "Compatibility_05");
        match attempt(&path) {
            Some(Ok((count, warnings))) => {
                assert!(!must_fail, "{name} loads");
                println!("{name}: {count} triangles, {warnings:?}");
                triangles += count;
            }
            Some(Err(message)) => assert!(must_fail, "{message}"),
            None => panic!("{name} panicked"),
        }
    }
    // The index counts 1072; two files of two triangles are refused.
    assert_eq!(triangles, 1068);
}

#[test]
fn generated_tangents_agree_with_the_files_own() {
    let Some(corpus) = corpus() else { return };
    // Its tangents were made by MikkTSpace when it was exported.
    let path = corpus.join("textures/NormalTangentMirrorTest.glb");
    let file = std::fs::read(&path).expect("file");
    // The same file with its tangents under a name that means nothing.
    let mut without = file.clone();
    let key = b"\"TANGENT\"";
    let mut renamed = 0;
    for at in 0..without.len() - key.len() {
        if without[at..].starts_with(key) {
            without[at + 1] = b'_';
            renamed += 1;
        }
    }
    assert!(renamed > 0);
    let load = |bytes: &[u8]| surelight_scene::load_bytes(bytes, &path, &LoadOptions::default()).expect("loads");
    let (own, made) = (load(&file), load(&without));
    let (mut corners, mut agree) = (0_usize, 0_usize);
    for (own, made) in own.meshes.iter().zip(&made.meshes) {
        let (Some(a), Some(b)) = (&own.tangents, &made.tangents) else { continue };
        for (&i, &j) in own.triangles.iter().flatten().zip(made.triangles.iter().flatten()) {
            let (a, b) = (a[i as usize], b[j as usize]);
            assert_eq!(own.positions[i as usize], made.positions[j as usize]);
            corners += 1;
            agree += usize::from(a.w == b.w && a.truncate().dot(b.truncate()) > 0.999);
        }
    }
    println!("{agree} of {corners} corners agree");
    assert!(corners > 1000 && agree as f64 > 0.98 * corners as f64, "{agree} of {corners}");
}
