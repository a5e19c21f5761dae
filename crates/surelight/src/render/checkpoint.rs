//! The files that `--resume` continues from: the checkpoint `NAME.checkpoint.exr` beside the first
//! output, or an output that an earlier run finished.
//!
//! A checkpoint is written now and then, when the render ends before its goal, and when an output
//! cannot be written; it is removed when the goal is reached and all outputs are written. It holds
//! every bit. A finished .exr holds means, variances and tails in 24 bits: it is extended, not
//! continued.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use surelight_film::{
    Compatibility, Difference, Film, Metadata, difference, read_finished, read_part_header, remove_leftovers, write_exr,
};
use surelight_render::{Counts, ResumeState};

use crate::error::Error;
use crate::method;
use crate::options::{PathReuse, RenderArgs};
use crate::parse::{Format, OutputPath};
use crate::{console, fingerprint, saved};

use super::record::Record;

/// The checkpoint of one render.
#[derive(Debug)]
pub(super) struct Checkpoint {
    /// None where no output is a file.
    path: Option<PathBuf>,
    /// Whether the file is of this render: continued from, or written by it.
    ours: bool,
    /// The error when it was last written.
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

    /// Finds the render to continue, and prints a note where there is none or one is about to be
    /// replaced.
    pub(super) fn find(&self, outputs: &[OutputPath], resume: bool, quiet: bool) -> Result<Option<Earlier>, Error> {
        let Some(file) = &self.path else { return Ok(None) };
        if resume {
            remove_leftovers(file); // of a run that was killed while it saved
        }
        if resume && file.exists() {
            let (metadata, _) = read_part_header(file)?;
            return Ok(Some(Earlier { path: file.clone(), metadata, finished: false }));
        }
        let is_exr_file = |output: &&OutputPath| output.format == Format::Exr && !output.is_stdout();
        let finished = outputs.iter().filter(|_| resume).filter(is_exr_file).find_map(|output| {
            let metadata = read_exr_metadata(&output.path)?;
            Some(Earlier { path: output.path.clone(), metadata, finished: true })
        });
        if finished.is_some() {
            return Ok(finished);
        }
        let path = file.display();
        if resume && !quiet {
            console::note(&format!(
                "note: there is neither a checkpoint \"{path}\" nor a finished .exr to extend, so the render begins anew"
            ));
        } else if let Ok((metadata, _)) = read_part_header(file)
            && !quiet
        {
            let [first, end] = metadata.sample_range;
            console::note(&format!(
                "note: \"{path}\" holds {} samples per pixel of an earlier render; --resume would continue it, and a checkpoint of this one will replace it",
                end - first
            ));
        }
        Ok(None)
    }

    /// Reads the film of an earlier run and its state, if it is of the render that `record`
    /// describes; `planned`: samples per pixel of this one.
    pub(super) fn read(
        &mut self,
        earlier: &Earlier,
        record: &mut Record,
        planned: Option<u32>,
    ) -> Result<(Film, ResumeState), Error> {
        let (film, metadata) = read_finished(&earlier.path)?;
        let [first, next] = metadata.sample_range.map(|sample| sample as u32);
        let differs =
            |sameness| difference(&metadata, record.beginning(), sameness).or_else(|| portion(&metadata, record));
        let exact = differs(Compatibility::Bits).is_none();
        let (state, extends) = match &metadata.part {
            Some(part) if exact => (ResumeState { first, next, batch: part.next_batch, pilot: part.pilot }, false),
            _ => {
                if let Some(difference) = earlier.difference(record) {
                    return Err(Error::Resume { path: earlier.path.clone(), difference });
                }
                // Batches are numbered from the number of samples on, which no earlier batch has
                // reached.
                (ResumeState { first, next, batch: next, pilot: None }, planned.is_none_or(|planned| planned > next))
            }
        };
        let paths = film.pixels().iter().map(surelight_film::PixelMoments::samples).sum();
        record.after(&metadata, paths, extends);
        self.ours = !earlier.finished;
        Ok((film, state))
    }

    /// Writes it. A failure is reported at the end: the render itself continues.
    pub(super) fn write(&mut self, record: &Record, film: &Film, state: &ResumeState, counts: &Counts) {
        let Some(path) = &self.path else { return };
        let written = write_exr(path, film, &record.metadata(film, state, counts, true));
        if written.is_ok() {
            self.ours = true;
            saved::add(path);
        }
        self.failure = written.err().map(|error| error.to_string());
    }

    /// Removes it, where it is of this render.
    pub(super) fn remove(&self) {
        if let Some(path) = self.kept() {
            // Where that fails, the file that remains is out of date but intact.
            let _ = std::fs::remove_file(path);
        }
    }
}

/// A render that `--resume` continues.
#[derive(Debug)]
pub(super) struct Earlier {
    /// The file that holds it.
    path: PathBuf,
    /// Its metadata.
    metadata: Metadata,
    /// Whether it is a finished image instead of a checkpoint.
    finished: bool,
}

impl Earlier {
    /// The options, with the decisions of the earlier run where they leave a choice.
    pub(super) fn decided(&self, args: &RenderArgs) -> RenderArgs {
        let mut args = args.clone();
        let settings = self.metadata.settings.as_ref().filter(|settings| settings.is_current());
        if let (method::Integrator::Auto, Some(settings)) = (args.method.integrator, settings) {
            args.method.integrator = settings.integrator.into();
        }
        if args.shared_paths == PathReuse::Auto {
            args.shared_paths = if self.reuses_paths() { PathReuse::On } else { PathReuse::Off };
        }
        args
    }

    /// The source of the samples, as the summary names it.
    pub(super) fn source(&self) -> String {
        if self.finished { self.path.display().to_string() } else { "a checkpoint".to_owned() }
    }

    /// Whether pixels use one another's paths.
    pub(super) fn reuses_paths(&self) -> bool {
        self.metadata.reuses_paths()
    }

    /// Why the render of `record` cannot extend it.
    pub(super) fn difference(&self, record: &Record) -> Option<Difference> {
        let of_plan = || {
            let part = self.metadata.part.as_ref().filter(|part| part.asked_samples.is_some())?;
            let spp = |spp: Option<u64>| spp.map_or("not set".to_owned(), |spp| spp.to_string());
            let now = record.beginning().part.as_ref().and_then(|part| part.planned_samples);
            (part.planned_samples != now).then(|| Difference {
                what: "--spp".into(),
                first: spp(part.planned_samples),
                second: spp(now),
            })
        };
        difference(&self.metadata, record.beginning(), Compatibility::Plan)
            .or_else(|| portion(&self.metadata, record))
            .or_else(of_plan)
    }

    /// Whether the render of `record` can extend it. A finished image of another render is no
    /// error: this render replaces it, and says so.
    pub(super) fn is_of(&self, record: &Record, quiet: bool) -> bool {
        let Some(Difference { what, first, second }) = self.difference(record).filter(|_| self.finished) else {
            return true;
        };
        if !quiet {
            console::note(&format!(
                "note: \"{}\" is of another render ({what} is {first} there and {second} here), so this one begins anew",
                self.path.display()
            ));
        }
        false
    }
}

/// The metadata of a render, if the file is one.
fn read_exr_metadata(path: &Path) -> Option<Metadata> {
    if let Ok((metadata, _)) = read_part_header(path) {
        return Some(metadata);
    }
    surelight_film::read_exr_header(path).ok()?.surelight_metadata().filter(|m| m.settings.is_some())
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

/// The difference where another portion of the same render is requested.
fn portion(earlier: &Metadata, record: &Record) -> Option<Difference> {
    let crop = |m: &Metadata| m.crop.map_or("not set".to_owned(), |[a, b, c, d]| format!("{a},{b},{c},{d}"));
    let samples = |m: &Metadata| {
        let requested = m.part.as_ref().and_then(|part| part.asked_samples);
        requested.map_or("not set".to_owned(), |[first, end]| format!("{first}..{end}"))
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
