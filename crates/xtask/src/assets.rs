//! `assets/`: made by code, committed small, and checked against the code.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use surelight_scene::procedural::{GALLERY, spheres};
use surelight_scene::write_glb;

/// No committed scene may be larger.
const MOST_BYTES: usize = 300 * 1024;

/// A file of `assets/`: its name and its bytes.
type File = (String, Vec<u8>);

/// Writes every generated file.
pub(crate) fn write(folder: &Path) -> Result<(), String> {
    for (name, bytes) in generate()? {
        let path = folder.join(&name);
        fs::write(&path, &bytes).map_err(|e| format!("{} cannot be written: {e}", path.display()))?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}

/// Fails when a committed file differs from the generated one, or when a scene lies there that no code makes.
pub(crate) fn check(folder: &Path) -> Result<(), String> {
    let files = generate()?;
    let mut wrong = Vec::new();
    for (name, bytes) in &files {
        match fs::read(folder.join(name)) {
            Ok(found) if found == *bytes => {}
            Ok(_) => wrong.push(format!("{name} differs")),
            Err(e) => wrong.push(format!("{name} cannot be read ({e})")),
        }
    }
    let entries = fs::read_dir(folder).map_err(|e| format!("{} cannot be listed: {e}", folder.display()))?;
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".glb") && !files.iter().any(|(n, _)| *n == name) {
            wrong.push(format!("{name} is made by no code"));
        }
    }
    if wrong.is_empty() {
        println!("assets/: {} files are as the code makes them", files.len());
        return Ok(());
    }
    wrong.sort();
    Err(format!("assets/ is out of date: {}. Run `cargo xtask assets` and commit the result.", wrong.join(", ")))
}

fn generate() -> Result<Vec<File>, String> {
    let mut files = Vec::new();
    let mut table = String::new();
    for entry in GALLERY {
        let scene = (entry.build)();
        let bytes = write_glb(&scene, entry.known).map_err(|e| format!("{}: {e}", entry.name))?;
        if bytes.len() > MOST_BYTES {
            return Err(format!("{}.glb takes {} bytes; the limit is {MOST_BYTES}", entry.name, bytes.len()));
        }
        let (name, shows, known) = (entry.name, entry.shows, entry.known);
        let (triangles, size) = (scene.triangle_count(), bytes.len());
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| {name}.glb | {shows} | {known} | {triangles} | {size} |");
        files.push((format!("{name}.glb"), bytes));
    }
    let sky = crate::sky::exr(&spheres::sky())?;
    let _ = writeln!(
        table,
        "| sky.exr | A late-afternoon sky, 128 × 64, for spheres.glb. | {} | | {} |",
        spheres::SKY_KNOWN,
        sky.len()
    );
    files.push(("sky.exr".to_owned(), sky));
    files.push(("README.md".to_owned(), readme(&table).into_bytes()));
    Ok(files)
}

fn readme(table: &str) -> String {
    format!(
        "# Generated scenes

Made by `cargo xtask assets` from `crates/scene/src/procedural/` (this table too); `cargo xtask assets --check` fails
when a file differs from the code. Each says what is known about it, here and in `asset.extras.notes` of the file.
Conventions: metres, +Y up, fronts counter-clockwise; emitters black and one-sided; radiance in linear Rec. 709.

| file | shows | known in closed form | triangles | bytes |
|---|---|---|---:|---:|
{table}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_finds_what_is_missing_changed_or_foreign() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        assert!(check(folder.path()).expect_err("nothing is there").contains("cornell-box.glb cannot be read"));
        write(folder.path()).expect("the files can be written");
        check(folder.path()).expect("they are as written");

        let furnace = folder.path().join("furnace.glb");
        let mut bytes = fs::read(&furnace).expect("it is there");
        let last = bytes.len() - 1;
        bytes[last] ^= 1;
        fs::write(&furnace, bytes).expect("it can be written");
        fs::write(folder.path().join("teapot.glb"), b"").expect("it can be written");
        let message = check(folder.path()).expect_err("two files are wrong");
        assert!(message.contains("furnace.glb differs, teapot.glb is made by no code"), "{message}");
    }
}
