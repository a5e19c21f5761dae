//! Where images go: default names, and checks before an hour of rendering is spent in vain.

use std::fs;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use crate::error::Error;
use crate::input::SceneSource;
use crate::parse::{Format, OutputPath};

/// The files to write: the requested ones, or the scene's name as .png and .exr in the current
/// folder.
pub(crate) fn choose(scene: &SceneSource, requested: &[OutputPath]) -> Vec<OutputPath> {
    if !requested.is_empty() {
        return requested.to_vec();
    }
    let named = |extension: &str, format| {
        let mut name = scene.stem().to_owned();
        name.push(extension);
        OutputPath { path: PathBuf::from(name), format }
    };
    vec![named(".png", Format::Png), named(".exr", Format::Exr)]
}

/// Finds out now whether the files can be written later. Nothing stays behind.
///
/// `inputs` are files that the render reads: writing over one of them is refused.
pub(crate) fn check(outputs: &[OutputPath], inputs: &[PathBuf]) -> Result<(), Error> {
    for (i, output) in outputs.iter().enumerate() {
        if output.is_stdout() {
            if std::io::stdout().is_terminal() {
                return Err(Error::Stdout("it is a terminal; send it to a file (> FILE) or a program (| PROGRAM)"));
            }
            continue;
        }
        let path = &output.path;
        let fail = |cause: String| Error::Output { path: path.clone(), cause };
        if outputs[..i].iter().any(|other| !other.is_stdout() && same_file(&other.path, path)) {
            return Err(fail("it is given twice".into()));
        }
        if let Some(input) = inputs.iter().find(|input| same_file(input, path)) {
            return Err(fail(format!("the render reads it (as \"{}\"); choose another name", input.display())));
        }
        surelight_film::check_writable(path).map_err(|error| fail(error.cause))?;
    }
    Ok(())
}

/// Whether two paths lead to one file, be it through links; of files not there yet, whether they
/// will.
fn same_file(a: &Path, b: &Path) -> bool {
    let resolve = |path: &Path| {
        fs::canonicalize(path).ok().or_else(|| {
            let path = surelight_film::follow_links(path).ok()?;
            let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(fs::canonicalize(parent).ok()?.join(path.file_name()?))
        })
    };
    resolve(a).is_some_and(|a| Some(a) == resolve(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn png(path: PathBuf) -> OutputPath {
        OutputPath { path, format: Format::Png }
    }

    #[test]
    fn default_names_follow_the_scene() {
        let names: Vec<_> =
            choose(&SceneSource::File("some/where/Box.v2.glb".into()), &[]).into_iter().map(|o| o.path).collect();
        assert_eq!(names, [PathBuf::from("Box.v2.png"), PathBuf::from("Box.v2.exr")]);
    }

    #[test]
    fn unwritable_places_are_found_and_nothing_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("texture.png"), b"x").unwrap();
        fs::create_dir(at("folder.png")).unwrap();

        assert!(check(&[png(at("a.png"))], &[]).is_ok());
        for (outputs, inputs, words) in [
            (vec![png(at("gone/a.png"))], vec![], "does not exist"),
            (vec![png(at("texture.png/a.png"))], vec![], "not a folder"),
            (vec![png(at("folder.png"))], vec![], "it is a folder"),
            (vec![png(at("a.png")), png(at("./a.png"))], vec![], "given twice"),
            (vec![png(at("texture.png"))], vec![at("folder.png/../texture.png")], "reads it"),
        ] {
            let text = check(&outputs, &inputs).unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("frame.png", at("latest.png")).unwrap();
            let text = check(&[png(at("latest.png")), png(at("frame.png"))], &[]).unwrap_err().to_string();
            assert!(text.contains("given twice"), "{text}");
        }
        assert_eq!(fs::read(at("texture.png")).unwrap(), b"x");
    }
}
