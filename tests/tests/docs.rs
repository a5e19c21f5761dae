//! README's code compiles and renders, and the links of the documentation lead somewhere.

use std::error::Error;
use std::fs::read_to_string;
use std::path::{Path, PathBuf};

use surelight_film::{Display, Film, write_png};
use surelight_prepare::{Prepared, Settings};
use surelight_render::{AdapterChoice, Device, Goal, Renderer, render};
use surelight_scene::LoadOptions;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The pages of the documentation.
fn pages() -> Vec<PathBuf> {
    let root = repository();
    let mut pages = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "shaders/README.md", "docs/benchmarks/README.md"]
        .map(|name| root.join(name))
        .to_vec();
    let docs = std::fs::read_dir(root.join("docs")).expect("docs/ is there").flatten().map(|entry| entry.path());
    pages.extend(docs.filter(|path| path.extension().is_some_and(|e| e == "md")));
    pages
}

/// The code of README.md's section on embedding, from here to the mark.
fn readme_renders() -> Result<(), Box<dyn Error>> {
    // README.md
    let scene = surelight_scene::load(Path::new("assets/cornell-box.glb"), &LoadOptions::default())?;
    let settings = Settings::new(256, 256);
    let prepared = Prepared::new(&scene, &scene.cameras[0], &settings)?;
    let device = Device::new(&AdapterChoice::Best)?;
    let mut renderer = Renderer::new(&device, &prepared)?;
    let mut film = Film::new(settings.width, settings.height);
    let goal = Goal { spp: Some(64), ..Goal::default() };
    render(&mut renderer, &mut film, &goal, &mut |_| true)?;
    write_png(Path::new("box.png"), &film, &Display::default())?;
    // end
    Ok(())
}

/// The lines between two others, without their indentation.
fn between(text: &str, first: &str, last: &str) -> Vec<String> {
    let lines = text.lines().map(str::trim).skip_while(|line| *line != first).skip(1);
    lines.take_while(|line| *line != last).map(str::to_owned).collect()
}

#[test]
fn readmes_code_renders() {
    let readme = read_to_string(repository().join("README.md")).expect("README.md is there");
    let shown = between(&readme, "```rust", "```");
    assert!(!shown.is_empty() && shown == between(include_str!("docs.rs"), "// README.md", "// end"));

    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("assets")).expect("a folder");
    let scene = "assets/cornell-box.glb";
    std::fs::copy(repository().join(scene), folder.path().join(scene)).expect("a copy");
    std::env::set_current_dir(folder.path()).expect("a folder to work in");
    readme_renders().expect("a picture");
    assert!(folder.path().join("box.png").exists());
}

/// Targets of the links and pictures of a page.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target)
}

/// A heading's anchor, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim_start_matches('#').trim().to_lowercase();
    let kept = kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = read_to_string(&page).expect("a page");
        for target in targets(&text).filter(|target| !target.contains("://")) {
            let (file, fragment) = target.split_once('#').unwrap_or((target, ""));
            let path = if file.is_empty() { page.clone() } else { page.with_file_name(file) };
            let found = match fragment {
                "" => path.exists(),
                _ => read_to_string(&path)
                    .is_ok_and(|text| text.lines().any(|line| line.starts_with('#') && anchor(line) == fragment)),
            };
            if !found {
                broken.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
