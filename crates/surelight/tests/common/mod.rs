//! Runs the built program in a temporary folder.

// Each test file uses a part of this.
#![allow(dead_code)]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The Cornell box of the repository.
pub(crate) fn cornell_box() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/cornell-box.glb").canonicalize().unwrap()
}

/// An empty folder that a program runs in, and the results of its runs.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The program, ready to run here.
    pub(crate) fn command<S: AsRef<OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_surelight"));
        command.args(args).current_dir(self.0.path());
        command
    }

    /// Runs the program here with arguments separated by spaces; `{box}` is the Cornell box.
    pub(crate) fn run(&self, line: &str) -> Ran {
        let scene = cornell_box();
        let args = line.split_whitespace().map(|word| match word {
            "{box}" => scene.as_os_str(),
            other => OsStr::new(other),
        });
        Ran::from(self.command(args).output().unwrap())
    }

    /// Names of the files here, in order.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// The result of a run.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

impl Ran {
    /// The run ended well.
    #[track_caller]
    pub(crate) fn succeeded(self) -> Self {
        assert_eq!(self.code, Some(0), "{self:#?}");
        self
    }

    /// The run failed with one sentence on standard error that holds all of `words`, and nothing
    /// else.
    #[track_caller]
    pub(crate) fn failed_with(&self, words: &[&str]) {
        assert_eq!(self.code, Some(1), "{self:#?}");
        assert_eq!(self.stdout, "", "{self:#?}");
        let lines: Vec<_> = self.stderr.lines().collect();
        assert_eq!(lines.len(), 1, "one sentence is expected: {self:#?}");
        assert!(lines[0].starts_with("error: "), "{self:#?}");
        assert!(!lines[0].contains("panicked") && !lines[0].contains("defect"), "{self:#?}");
        for word in words {
            assert!(lines[0].contains(word), "{word:?} is missing: {self:#?}");
        }
    }
}
