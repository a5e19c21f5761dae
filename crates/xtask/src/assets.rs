//! `assets/`: made by code, committed small, and checked against the code.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use surelight_scenes::{Entry, GALLERY, extensions, glb, spheres, torture};

/// No committed scene may be larger.
const MAX_BYTES: usize = 300 * 1024;

/// No committed scene of the torture list may be larger.
const MAX_TORTURE_BYTES: usize = 100 * 1024;

/// Folder of the torture list's scenes in `assets/`.
const TORTURE: &str = "torture";

/// Folder of the files for one extension each.
const EXTENSIONS: &str = "gltf";

/// A file of `assets/`: its name and its bytes.
type File = (String, Vec<u8>);

/// Arguments of `cargo xtask assets`.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Fail when a file in assets/ differs from the generated one, and write nothing
    #[arg(long)]
    check: bool,
}

/// Writes or checks the generated files.
pub(crate) fn run(folder: &Path, arguments: &Arguments) -> Result<(), String> {
    if arguments.check { check(folder) } else { write(folder) }
}

/// Writes every generated file.
fn write(folder: &Path) -> Result<(), String> {
    for (name, bytes) in generate()? {
        let path = folder.join(&name);
        let subfolder = path.parent().unwrap_or(folder);
        fs::create_dir_all(subfolder).map_err(|e| format!("{} cannot be made: {e}", subfolder.display()))?;
        fs::write(&path, &bytes).map_err(|e| format!("{} cannot be written: {e}", path.display()))?;
        println!("{name}: {} bytes", bytes.len());
    }
    Ok(())
}

/// Fails when a committed file differs from the generated one, or when there is a scene that no
/// code generates.
fn check(folder: &Path) -> Result<(), String> {
    let files = generate()?;
    let mut wrong = Vec::new();
    for (name, bytes) in &files {
        match fs::read(folder.join(name)) {
            Ok(found) if found == *bytes => {}
            Ok(_) => wrong.push(format!("{name} differs")),
            Err(e) => wrong.push(format!("{name} cannot be read ({e})")),
        }
    }
    // Compressed files in gltf/ are other encoders' work.
    for prefix in ["", "torture/"] {
        let Ok(entries) = fs::read_dir(folder.join(prefix)) else { continue };
        for entry in entries.flatten() {
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if name.ends_with(".glb") && !files.iter().any(|(n, _)| *n == name) {
                wrong.push(format!("{name} is made by no code"));
            }
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
        let (bytes, row) = scene_file(entry, MAX_BYTES)?;
        table.push_str(&row);
        files.push((format!("{}.glb", entry.name), bytes));
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
    let mut plates = String::new();
    for file in extensions::FILES {
        let (bytes, row) = scene_file(&file.entry, MAX_TORTURE_BYTES)?;
        plates.push_str(&row);
        files.push((format!("{EXTENSIONS}/{}.glb", file.entry.name), bytes));
    }
    files.push((format!("{EXTENSIONS}/README.md"), extensions_readme(&plates).into_bytes()));
    let mut cases = String::new();
    for case in torture::cases() {
        let Entry { name, shows, known, .. } = case.entry;
        let row = if case.file {
            let (bytes, row) = scene_file(&case.entry, MAX_TORTURE_BYTES)?;
            files.push((format!("{TORTURE}/{name}.glb"), bytes));
            row
        } else {
            format!("| {name}, as a generator alone | {shows} | {known} | | |\n")
        };
        let _ = write!(cases, "| {} {row}", case.number);
    }
    files.push((format!("{TORTURE}/README.md"), torture_readme(&cases).into_bytes()));
    Ok(files)
}

/// A scene's file and its row of the table.
fn scene_file(entry: &Entry, max_bytes: usize) -> Result<(Vec<u8>, String), String> {
    let Entry { name, shows, known, build } = entry;
    let scene = build();
    let bytes = glb::encode(&scene, known).map_err(|e| format!("{name}: {e}"))?;
    if bytes.len() > max_bytes {
        return Err(format!("{name}.glb takes {} bytes; the limit is {max_bytes}", bytes.len()));
    }
    let row = format!("| {name}.glb | {shows} | {known} | {} | {} |\n", scene.triangle_count(), bytes.len());
    Ok((bytes, row))
}

fn extensions_readme(table: &str) -> String {
    format!(
        "# Files for one extension each

The files in the table are made by `cargo xtask assets` from `crates/scenes/src/extensions.rs`, and
compared with their closed forms by `tests/torture/bsdf/extensions.rs`. The view is at normal
incidence, under a white sky (`--sky 1,1,1`) unless the file has a light. The other files, `basisu`,
`draco` and `meshopt-*`, were made by other encoders ([gltf.md](../../docs/gltf.md)). Beside them are
the plain meshes or colours that they must equal.

| file | shows | known | triangles | bytes |
|---|---|---|---:|---:|
{table}"
    )
}

fn torture_readme(table: &str) -> String {
    format!(
        "# The torture list's scenes

Made by `cargo xtask assets` from `crates/scenes/src/torture/`. Tests of the same names are in
`tests/torture/` ([testing](../../docs/testing.md)). A glTF file cannot contain a sky: where a case
needs one, the table gives the option that sets it.

| case | file | shows | known in closed form | triangles | bytes |
|---:|---|---|---|---:|---:|
{table}"
    )
}

fn readme(table: &str) -> String {
    format!(
        "# Generated scenes

Made by `cargo xtask assets` from `crates/scenes/src/`, this table included.
`cargo xtask assets --check` fails when a file differs from the code. Each scene states its closed
form, here and in `asset.extras.notes` of the file. Conventions: metres, +Y up, fronts
counter-clockwise; emitters black and one-sided; radiance in linear Rec. 709.

| file | shows | known in closed form | triangles | bytes |
|---|---|---|---:|---:|
{table}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn committed_files_are_what_the_code_makes() {
        check(&crate::repository().join("assets")).expect("assets/ is up to date");
    }

    #[test]
    fn check_finds_missing_changed_and_foreign_files() {
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
