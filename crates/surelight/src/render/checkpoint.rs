//! The file that a render can go on from: `NAME.checkpoint.exr` beside the first output.
//!
//! It is written now and then, when the render ends before its goal, and when an output cannot be
//! written; it is removed when the goal is met and all outputs are written.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

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
    path: PathBuf,
    /// Whether the file is of this render: gone on from, or written by it.
    ours: bool,
    /// What went wrong when it was last written.
    pub(super) failure: Option<String>,
}

impl Checkpoint {
    /// Where the checkpoint of a render with these outputs lies.
    pub(super) fn beside(outputs: &[OutputPath]) -> Self {
        let first = outputs.first().map_or_else(PathBuf::new, |output| output.path.clone());
        let name = name_of(first.file_stem().unwrap_or(OsStr::new("surelight")));
        Self { path: first.with_file_name(name), ours: false, failure: None }
    }

    /// The file, where it is of this render.
    pub(super) fn kept(&self) -> Option<PathBuf> {
        self.ours.then(|| self.path.clone())
    }

    /// As an output, whose place can be checked.
    pub(super) fn output(&self) -> OutputPath {
        OutputPath { path: self.path.clone(), format: Format::Exr }
    }

    /// Finds out before anything else whether there is a checkpoint to go on from, and tells what is not as the user may expect.
    pub(super) fn look(&self, resume: bool, quiet: bool) -> Result<Option<Metadata>, Error> {
        if resume {
            remove_leftovers(&self.path); // of a run that was killed while it saved
        }
        if resume && self.path.exists() {
            let (metadata, _) = read_part_header(&self.path)?;
            return Ok(Some(metadata));
        }
        let path = self.path.display();
        if resume && !quiet {
            console::note(&format!("note: there is no checkpoint \"{path}\", so the render begins anew"));
        } else if let Ok((metadata, _)) = read_part_header(&self.path)
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
        let (film, metadata) = read_part(&self.path)?;
        if let Some(difference) = difference(&metadata, record.beginning()).or_else(|| portion(&metadata, record)) {
            return Err(Error::Resume { path: self.path.clone(), difference });
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
        let written = write_exr(&self.path, film, &record.metadata(film, standing, counts, true));
        self.ours |= written.is_ok();
        self.failure = written.err().map(|error| error.to_string());
    }

    /// Removes it, where it is of this render.
    pub(super) fn remove(&self) {
        if self.ours {
            // Where that fails, what stays is out of date but intact.
            let _ = std::fs::remove_file(&self.path);
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
    use std::path::Path;

    use super::*;

    #[test]
    fn it_lies_beside_the_first_output() {
        for (output, checkpoint) in [
            ("a/b.v2.png", "a/b.v2.checkpoint.exr"),
            ("c.exr", "c.checkpoint.exr"),
            ("/x/y.exr", "/x/y.checkpoint.exr"),
        ] {
            let output = OutputPath { path: output.into(), format: Format::Exr };
            assert_eq!(Checkpoint::beside(&[output]).path, Path::new(checkpoint));
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
