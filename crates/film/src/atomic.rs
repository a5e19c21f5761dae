//! Files that are either complete or not there.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::WriteError;
use crate::error::io_cause;

/// Suffix of the names of files that are being written.
const SUFFIX: &str = ".part";

/// Links from link to link beyond which they are taken for a circle, as on Linux.
const MAX_LINKS: usize = 40;

/// Writes `bytes` to `path`: into a new file beside it, synchronised to disk, then renamed over it.
///
/// On failure the target is as it was and nothing is left beside it. A link is followed, so that
/// the file it names is made or replaced and not the link. A target that is not a plain file, such
/// as a pipe or `/dev/null`, is written to directly.
///
/// # Errors
/// A sentence that names the target and the cause.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let fail = |cause: String| WriteError::new(path, cause);
    match locate(path).map_err(fail)? {
        Some(target) => {
            let temporary = create_beside(&target).map_err(fail)?;
            replace(&target, temporary, bytes)
        }
        None => fs::OpenOptions::new().write(true).open(path).and_then(|mut file| file.write_all(bytes)),
    }
    .map_err(|error| fail(io_cause(&error)))
}

/// Finds out whether [`write_file`] can write to `path`, as far as that is known before there are
/// bytes. Nothing stays behind.
///
/// # Errors
/// A sentence that names the target and the cause.
pub fn check_writable(path: &Path) -> Result<(), WriteError> {
    let fail = |cause: String| WriteError::new(path, cause);
    if let Some(target) = locate(path).map_err(fail)? {
        if fs::metadata(&target).is_ok_and(|meta| meta.permissions().readonly()) {
            return Err(fail("it is write-protected".into()));
        }
        create_beside(&target).map_err(fail)?;
    }
    Ok(())
}

/// Removes temporary files of programs that were killed while they wrote to `path`. No other
/// program may be writing to it now.
pub fn remove_leftovers(path: &Path) {
    let Ok(Some(target)) = locate(path) else { return };
    let prefix = temporary_prefix(&target);
    let Ok(entries) = fs::read_dir(folder_of(&target)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(&prefix) && name.ends_with(SUFFIX) {
            // One that cannot be removed does no harm.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The path at the end of a chain of symbolic links, whether there is a file or not; other paths
/// unchanged.
///
/// # Errors
/// Where the links lead in a circle or cannot be read.
pub fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut end = path.to_owned();
    for _ in 0..MAX_LINKS {
        if !fs::symlink_metadata(&end).is_ok_and(|meta| meta.is_symlink()) {
            return Ok(end);
        }
        end = folder_of(&end).join(fs::read_link(&end)?);
    }
    Err(io::Error::other("its symbolic links lead in a circle"))
}

/// The file to make or replace; `None` where `path` is a device or a pipe.
fn locate(path: &Path) -> Result<Option<PathBuf>, String> {
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => return Err("it is a folder".into()),
        Ok(meta) if !meta.is_file() => return Ok(None),
        Err(error) if error.kind() == ErrorKind::InvalidFilename => {
            return Err("its name is too long for the file system".into());
        }
        _ => {}
    }
    let target = follow_links(path).map_err(|error| io_cause(&error))?;
    match target.file_name() {
        Some(_) => Ok(Some(target)),
        None => Err("the path names no file".into()),
    }
}

fn folder_of(target: &Path) -> PathBuf {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// A new file in the folder of `target`, which is removed when dropped.
fn create_beside(target: &Path) -> Result<NamedTempFile, String> {
    let prefix = temporary_prefix(target);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    // A temporary file is private by default; an image is an ordinary file under the user's umask.
    #[cfg(unix)]
    let builder = builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(existing_mode(target)));
    let folder = folder_of(target);
    builder.tempfile_in(&folder).map_err(|error| folder_cause(&folder, &error))
}

/// The prefix of temporary names of `target`: a hash of its name, which may be as long as a name
/// can be.
fn temporary_prefix(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default().as_encoded_bytes();
    // The same in every run, so that leftovers are found.
    format!(".surelight-{:016x}.", xxhash_rust::xxh3::xxh3_64(name))
}

fn folder_cause(folder: &Path, error: &io::Error) -> String {
    let folder = folder.display();
    match error.kind() {
        ErrorKind::NotFound => format!("the folder \"{folder}\" does not exist"),
        ErrorKind::NotADirectory => format!("\"{folder}\" is not a folder"),
        ErrorKind::PermissionDenied => format!("the folder \"{folder}\" is write-protected"),
        ErrorKind::ReadOnlyFilesystem => format!("the folder \"{folder}\" is on a read-only file system"),
        ErrorKind::StorageFull => format!("the disk of the folder \"{folder}\" is full"),
        ErrorKind::InvalidFilename => format!("the path of the folder \"{folder}\" is too long"),
        kind => format!("no file can be made in the folder \"{folder}\" ({kind})"),
    }
}

fn replace(target: &Path, mut temporary: NamedTempFile, bytes: &[u8]) -> io::Result<()> {
    // Dropping the temporary on any error below removes it.
    temporary.write_all(bytes).map_err(without_path)?;
    temporary.as_file().sync_all()?;
    temporary.persist(target).map_err(|error| error.error)?;
    sync_folder(&folder_of(target));
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
        let path = folder.path().join("image.exr");
        let [own, other] = [&path, &folder.path().join("other.exr")].map(|path| temporary_prefix(path));
        let names = ["image.exr", &format!("{own}x7.part"), &format!("{own}txt"), &format!("{other}x7.part")];
        for name in names {
            fs::write(folder.path().join(name), b"").unwrap();
        }
        remove_leftovers(&path);
        let mut left = [names[0], names[2], names[3]];
        left.sort_unstable();
        assert_eq!(entries(folder.path()), left);
    }

    /// The longest name a file can have is written; a longer one is refused, before and after.
    #[cfg(target_os = "linux")]
    #[test]
    fn names_may_be_as_long_as_the_file_system_allows() {
        let folder = tempfile::tempdir().unwrap();
        for length in [243, 255] {
            let path = folder.path().join("n".repeat(length));
            check_writable(&path).unwrap();
            write_file(&path, b"x").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"x");
            fs::remove_file(&path).unwrap();
        }
        let path = folder.path().join("n".repeat(256));
        for result in [check_writable(&path), write_file(&path, b"x")] {
            let text = result.unwrap_err().to_string();
            assert!(text.ends_with("its name is too long for the file system."), "{text}");
        }
        assert!(entries(folder.path()).is_empty());
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

    #[cfg(unix)]
    #[test]
    fn the_file_that_a_link_names_is_made() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("far")).unwrap();
        symlink("far/second", at("first")).unwrap();
        symlink("frame.exr", at("far/second")).unwrap();
        check_writable(&at("first")).unwrap();
        assert_eq!(entries(&at("far")), ["second"]);
        write_file(&at("first"), b"x").unwrap();
        assert_eq!(fs::read(at("far/frame.exr")).unwrap(), b"x");
        assert!(["first", "far/second"].iter().all(|link| at(link).is_symlink()));

        symlink("gone/frame.exr", at("lost")).unwrap();
        symlink("circle", at("circle")).unwrap();
        for (link, words) in [("lost", "gone\" does not exist"), ("circle", "lead in a circle")] {
            for result in [check_writable(&at(link)), write_file(&at(link), b"x")] {
                let text = result.unwrap_err().to_string();
                assert!(text.contains(words), "{text}");
            }
            assert!(at(link).is_symlink());
        }
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_is_reported() {
        // The device that is always full is not a plain file: written directly, never replaced.
        let path = Path::new("/dev/full");
        if path.exists() {
            let text = write_file(path, b"x").unwrap_err().to_string();
            assert_eq!(text, "The file \"/dev/full\" could not be written: the disk is full.");
            assert!(!fs::metadata(path).unwrap().is_file());
        }
    }
}
