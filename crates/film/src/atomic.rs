//! Files that are either complete or not there.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::WriteError;
use crate::error::io_cause;

/// What the names of files end in that are being written.
const SUFFIX: &str = ".part";

/// Writes `bytes` to `path`: into a new file beside it, synchronised to disk, then renamed over it.
///
/// On failure the target is as it was and nothing is left beside it. A link is followed, so that
/// the file it names is replaced and not the link. A target that is not a plain file, such as a
/// pipe or `/dev/null`, is written to directly.
///
/// # Errors
/// A sentence that names the target and the cause.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let fail = |cause: String| WriteError::new(path, cause);
    let target = match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => return Err(fail("it is a folder".into())),
        Ok(meta) if !meta.is_file() => {
            return fs::OpenOptions::new()
                .write(true)
                .open(path)
                .and_then(|mut file| file.write_all(bytes))
                .map_err(|error| fail(io_cause(&error)));
        }
        Ok(_) => fs::canonicalize(path).map_err(|error| fail(io_cause(&error)))?,
        Err(_) => path.to_owned(),
    };
    let Some(name) = target.file_name() else {
        return Err(fail("the path names no file".into()));
    };
    let folder = folder_of(&target);
    if !folder.is_dir() {
        return Err(fail(format!("the folder \"{}\" does not exist", folder.display())));
    }
    write_beside(&target, &folder, &name.to_string_lossy(), bytes).map_err(|error| fail(io_cause(&error)))
}

/// Removes what programs left that were killed while they wrote to `path`. No other program may be writing to it now.
pub fn remove_leftovers(path: &Path) {
    let Some(name) = path.file_name() else { return };
    let prefix = format!(".{}.", name.to_string_lossy());
    let Ok(entries) = fs::read_dir(folder_of(path)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(&prefix) && name.ends_with(SUFFIX) {
            // One that cannot be removed harms nobody.
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

fn write_beside(target: &Path, folder: &Path, name: &str, bytes: &[u8]) -> io::Result<()> {
    let prefix = format!(".{name}.");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    // A temporary file is private by default; an image is an ordinary file under the user's umask.
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(existing_mode(target)));
    // Dropping the temporary on any error below removes it.
    let mut temporary = builder.tempfile_in(folder).map_err(without_path)?;
    temporary.write_all(bytes).map_err(without_path)?;
    temporary.as_file().sync_all()?;
    temporary.persist(target).map_err(|error| error.error)?;
    sync_folder(folder);
    Ok(())
}

/// `tempfile` adds the random name to its errors, which means nothing to a reader.
fn without_path(error: io::Error) -> io::Error {
    match error.raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code),
        None => io::Error::new(error.kind(), error.kind().to_string()),
    }
}

#[cfg(unix)]
fn existing_mode(target: &Path) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    fs::metadata(target).map_or(0o666, |meta| meta.permissions().mode() & 0o777)
}

/// Makes the rename durable. Some file systems refuse to synchronise a folder; the image is
/// complete all the same, so that is no error.
fn sync_folder(folder: &Path) {
    if cfg!(unix)
        && let Ok(folder) = File::open(folder)
    {
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn replaces_and_leaves_nothing_beside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        write_file(&path, b"one").unwrap();
        write_file(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(entries(folder.path()), ["image.exr"]);
    }

    #[test]
    fn leftovers_of_one_target_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["image.exr", ".image.exr.x7.part", ".image.exr.part.txt", ".other.exr.x7.part"] {
            fs::write(folder.path().join(name), b"").unwrap();
        }
        remove_leftovers(&folder.path().join("image.exr"));
        assert_eq!(entries(folder.path()), [".image.exr.part.txt", ".other.exr.x7.part", "image.exr"]);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gone").join("image.png");
        let text = write_file(&path, b"x").unwrap_err().to_string();
        assert!(text.contains("image.png") && text.contains("gone\" does not exist"), "{text}");
        assert!(entries(folder.path()).is_empty());
    }

    #[test]
    fn a_folder_is_no_target() {
        let folder = tempfile::tempdir().unwrap();
        let text = write_file(folder.path(), b"x").unwrap_err().to_string();
        assert!(text.ends_with("it is a folder."), "{text}");
    }

    #[cfg(unix)]
    #[test]
    fn an_image_is_an_ordinary_file_and_a_link_survives() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, b"").unwrap();
        let path = folder.path().join("image.png");
        write_file(&path, b"one").unwrap();
        let mode = |p: &Path| fs::metadata(p).unwrap().permissions().mode();
        assert_eq!(mode(&path), mode(&plain));

        let link = folder.path().join("link.png");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        write_file(&link, b"two").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&path).unwrap(), b"two");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_told() {
        // The device that is always full is not a plain file: written directly, never replaced.
        let path = Path::new("/dev/full");
        if path.exists() {
            let text = write_file(path, b"x").unwrap_err().to_string();
            assert_eq!(text, "The file \"/dev/full\" could not be written: the disk is full.");
            assert!(!fs::metadata(path).unwrap().is_file());
        }
    }
}
