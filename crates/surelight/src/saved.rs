//! Files that this run has saved: a failure leaves them behind.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

static SAVED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Notes that a file is saved.
pub(crate) fn add(path: &Path) {
    if let Ok(mut saved) = SAVED.lock()
        && !saved.iter().any(|other| other == path)
    {
        saved.push(path.to_owned());
    }
}

/// The clause "; … were saved", empty where nothing was.
pub(crate) fn clause() -> String {
    SAVED.lock().map_or_else(|_| String::new(), |saved| list(&saved))
}

/// Clause that lists these files.
pub(crate) fn list(saved: &[PathBuf]) -> String {
    let names: Vec<_> = saved.iter().map(|path| format!("\"{}\"", path.display())).collect();
    match names.as_slice() {
        [] => String::new(),
        [one] => format!("; {one} was saved"),
        several => format!("; {} were saved", several.join(", ")),
    }
}
