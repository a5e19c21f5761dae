//! The file that a render can go on from: `NAME.checkpoint.exr` beside the first output.
//!
//! It is written now and then, when the render ends before its goal, and when an output cannot be
//! written; it is removed when the goal is met and all outputs are written.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use surelight_film::{
    Difference, Film, Metadata, difference, read_part, read_part_header, remove_leftovers, write_exr,
};
use surelight_render::{Counts, Standing};

use crate::error::Error;
use crate::parse::{Format, OutputPath};
use crate::{console, fingerprint};

use super::record::Record;

/// The checkpoint of one render.
#[derive(Debug)]
pub(super) struct Checkpoint {
    /// None where no output is a file.
    path: Option<PathBuf>,
    /// Whether the file is of this render: gone on from, or written by it.
    ours: bool,
    /// What went wrong when it was last written.
    pub(super) failure: Option<String>,
}

impl Checkpoint {
    /// Where the checkpoint of a render with these outputs lies: beside the first that is a file.
    pub(super) fn beside(outputs: &[OutputPath]) -> Self {
        let first = outputs.iter().find(|output| !output.is_stdout()).map(|output| &output.path);
        let beside =
            |first: &PathBuf| first.with_file_name(name_of(first.file_stem().unwrap_or(OsStr::new("surelight"))));
        Self { path: first.map(beside), ours: false, failure: None }
    }

    /// The file; there is none where no output is a file.
    pub(super) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The file, where it is of this render.
    pub(super) fn kept(&self) -> Option<PathBuf> {
        self.path.clone().filter(|_| self.ours)
    }

    /// As an output, whose place can be checked.
    pub(super) fn output(&self) -> Option<OutputPath> {
        self.path.clone().map(|path| OutputPath { path, format: Format::Exr })
    }

    /// Finds out before anything else whether there is a checkpoint to go on from, and tells what is not as the user may expect.
    pub(super) fn look(&self, resume: bool, quiet: bool) -> Result<Option<Metadata>, Error> {
        let Some(file) = &self.path else { return Ok(None) };
        if resume {
            remove_leftovers(file); // of a run that was killed while it saved
        }
        if resume && file.exists() {
            let (metadata, _) = read_part_header(file)?;
            return Ok(Some(metadata));
        }
        let path = file.display();
        if resume && !quiet {
            console::note(&format!("note: there is no checkpoint \"{path}\", so the render begins anew"));
        } else if let Ok((metadata, _)) = read_part_header(file)
            && !quiet
        {
            let [first, end] = metadata.sample_range;
            console::note(&format!(
                "note: \"{path}\" holds {} samples a pixel of an earlier render; --resume would go on from it, and a checkpoint of this one will replace it",
                end - first
            ));
        }
        Ok(None)
    }

    /// Reads the film and where it stands, if it is of the render that `record` describes.
    pub(super) fn read(&mut self, record: &mut Record) -> Result<(Film, Standing), Error> {
        let path = self.path.clone().unwrap_or_default();
        let (film, metadata) = read_part(&path)?;
        if let Some(difference) = difference(&metadata, record.beginning()).or_else(|| portion(&metadata, record)) {
            return Err(Error::Resume { path, difference });
        }
        let part = metadata.part.as_ref();
        let standing = Standing {
            first: metadata.sample_range[0] as u32,
            next: metadata.sample_range[1] as u32,
            batch: part.map_or(0, |part| part.next_batch),
            pilot: part.and_then(|part| part.pilot),
        };
        record.after(&metadata);
        self.ours = true;
        Ok((film, standing))
    }

    /// Writes it. A failure is told at the end: the render itself goes on.
    pub(super) fn write(&mut self, record: &Record, film: &Film, standing: &Standing, counts: &Counts) {
        let Some(path) = &self.path else { return };
        let written = write_exr(path, film, &record.metadata(film, standing, counts, true));
        self.ours |= written.is_ok();
        self.failure = written.err().map(|error| error.to_string());
    }

    /// Removes it, where it is of this render.
    pub(super) fn remove(&self) {
        if let Some(path) = self.kept() {
            // Where that fails, what stays is out of date but intact.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// The name of the checkpoint of an output with this stem: the same in every run.
///
/// Where it would be longer than a name may be, a hash takes the place of the stem's end.
fn name_of(stem: &OsStr) -> OsString {
    /// Bytes of a name on most file systems.
    const MAX_NAME: usize = 255;
    const ENDING: &str = ".checkpoint.exr";
    if stem.len() + ENDING.len() <= MAX_NAME {
        return [stem, OsStr::new(ENDING)].into_iter().collect();
    }
    let ending = format!("-{}{ENDING}", fingerprint::of_bytes(stem.as_encoded_bytes()));
    let text = stem.to_string_lossy();
    let kept = text.floor_char_boundary(MAX_NAME - ending.len());
    (text[..kept].to_owned() + &ending).into()
}

/// Whether another portion of the same render was asked for.
fn portion(earlier: &Metadata, record: &Record) -> Option<Difference> {
    let crop = |m: &Metadata| m.crop.map_or("not set".to_owned(), |[a, b, c, d]| format!("{a},{b},{c},{d}"));
    let samples = |m: &Metadata| {
        let asked = m.part.as_ref().and_then(|part| part.asked_samples);
        asked.map_or("not set".to_owned(), |[first, end]| format!("{first}..{end}"))
    };
    let of = |what: &str, value: &dyn Fn(&Metadata) -> String| {
        let (first, second) = (value(earlier), value(record.beginning()));
        (first != second).then(|| Difference { what: what.into(), first, second })
    };
    of("--crop", &crop).or_else(|| of("--samples", &samples))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_lies_beside_the_first_output_that_is_a_file() {
        let dash = || OutputPath { path: "-".into(), format: Format::Exr };
        assert_eq!(Checkpoint::beside(&[dash()]).path(), None);
        for (output, checkpoint) in [
            ("a/b.v2.png", "a/b.v2.checkpoint.exr"),
            ("c.exr", "c.checkpoint.exr"),
            ("/x/y.exr", "/x/y.checkpoint.exr"),
        ] {
            let output = OutputPath { path: output.into(), format: Format::Exr };
            assert_eq!(Checkpoint::beside(&[dash(), output]).path(), Some(Path::new(checkpoint)));
        }
    }

    #[test]
    fn its_name_is_never_too_long() {
        let name = |stem: &str| name_of(OsStr::new(stem)).into_string().unwrap();
        assert_eq!(name(&"a".repeat(240)), "a".repeat(240) + ".checkpoint.exr");
        let (first, second) = (name(&("a".repeat(250) + "1")), name(&("a".repeat(250) + "2")));
        assert_eq!((first.len(), second.len()), (255, 255));
        assert_ne!(first, second, "two renders share a checkpoint");
        let japanese = name(&"日".repeat(83));
        assert!(japanese.starts_with("日日") && japanese.len() > 252 && japanese.len() <= 255, "{japanese}");
    }
}
