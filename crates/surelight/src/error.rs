//! Errors that end a command: one sentence on standard error and an exit code.

use std::path::{Path, PathBuf};

use surelight_film::WriteError;

use crate::parse::{STANDARD_OUTPUT, is_dash};

/// Anything that ends a command with exit code 1.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// The scene or an environment could not be read.
    #[error(transparent)]
    Load(#[from] surelight_scene::LoadError),
    /// The device or the renderer.
    #[error(transparent)]
    Render(#[from] surelight_render::RenderError),
    /// An image could not be read.
    #[error(transparent)]
    Read(#[from] surelight_film::ReadError),
    /// Images that cannot be compared.
    #[error("{files} cannot be compared: {cause}")]
    Compare {
        /// Their names, in quotes.
        files: String,
        /// Why.
        cause: surelight_film::compare::CompareError,
    },
    /// A race or its report.
    #[error(transparent)]
    Bench(#[from] surelight_bench::BenchError),
    /// An image could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Some of the images of a render could not be written.
    #[error("{}", outputs_sentence(failed, saved, checkpoint.as_deref()))]
    Outputs {
        /// The outputs that could not be written, and why.
        failed: Vec<WriteError>,
        /// The outputs that were written.
        saved: Vec<PathBuf>,
        /// The checkpoint to resume from.
        checkpoint: Option<PathBuf>,
    },
    /// A formula that is not one.
    #[error(transparent)]
    Formula(#[from] surelight_render::FormulaError),
    /// A region that reaches beyond its image.
    #[error("the region reaches beyond the image, which has {width}x{height} pixels; --size chooses another")]
    Region {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A checkpoint of another render.
    #[error(
        "the checkpoint \"{}\" is of another render: {} is {} there and {} here; use the same value, or leave out --resume to start over",
        path.display(), difference.what, difference.first, difference.second
    )]
    Resume {
        /// The checkpoint.
        path: PathBuf,
        /// The difference of the renders.
        difference: surelight_film::Difference,
    },
    /// A device that fails while it traces.
    #[error("{cause}{saved}")]
    Tracing {
        /// The cause.
        #[source]
        cause: surelight_render::RenderError,
        /// A clause that lists saved files.
        saved: String,
    },
    /// Parts that cannot be merged.
    #[error(transparent)]
    Merge(#[from] surelight_film::MergeError),
    /// A vector without length.
    #[error("{0} needs a direction, but all its coordinates are 0")]
    NoDirection(&'static str),
    /// A place where nothing can be written, found before rendering.
    #[error("\"{}\" cannot be written: {cause}", path.display())]
    Output {
        /// The file to write.
        path: PathBuf,
        /// The cause.
        cause: String,
    },
    /// Standard output, where an image cannot go.
    #[error("standard output cannot be written: {0}")]
    Stdout(&'static str),
    /// A camera that the file lacks.
    #[error("there is no camera \"{wanted}\" in \"{}\": {available}", path.display())]
    UnknownCamera {
        /// The scene.
        path: PathBuf,
        /// The requested camera.
        wanted: String,
        /// The cameras of the file.
        available: String,
    },
    /// Options that do not fit the camera.
    #[error("{0}")]
    Camera(&'static str),
    /// An image that does not fit into memory.
    #[error(
        "an image of {width}x{height} pixels needs {gib:.1} GiB of memory, more than is available; choose a smaller --size, or render parts with --crop"
    )]
    Memory {
        /// Pixels a row.
        width: u32,
        /// Rows.
        height: u32,
        /// The memory needed.
        gib: f64,
    },
    /// Ctrl-C before there was anything to keep.
    #[error("interrupted before the first sample was done; nothing was written")]
    Interrupted,
    /// Standard output or the terminal.
    #[error("the result could not be written to standard output: {}", surelight_film::io_cause(_0))]
    Print(std::io::Error),
}

impl From<surelight_prepare::PrepareError> for Error {
    fn from(error: surelight_prepare::PrepareError) -> Self {
        Self::Render(error.into())
    }
}

/// Every file that could not be written with its cause, then all that were.
fn outputs_sentence(failed: &[WriteError], saved: &[PathBuf], checkpoint: Option<&Path>) -> String {
    let failed: Vec<_> = failed
        .iter()
        .map(|error| match is_dash(&error.path) {
            true => format!("{STANDARD_OUTPUT} could not be written: {}", error.cause),
            false => format!("the file \"{}\" could not be written: {}", error.path.display(), error.cause),
        })
        .collect();
    let saved: Vec<_> = saved.iter().filter(|path| !is_dash(path)).cloned().collect();
    let saved = crate::saved::list(&saved);
    let remedy =
        checkpoint.map_or_else(String::new, |path| format!("; --resume continues from \"{}\"", path.display()));
    failed.join("; ") + &saved + &remedy
}

/// A message in the form for use after "error: ": on one line, no capital article, no full stop.
pub(crate) fn sentence(message: &str) -> String {
    let line = message.lines().map(str::trim).collect::<Vec<_>>().join(" ");
    let line = line.strip_suffix('.').unwrap_or(&line);
    match line.strip_prefix("The ") {
        Some(rest) => format!("the {rest}"),
        None => line.to_owned(), // it may begin with a file's name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn written_and_failed_outputs_are_one_sentence() {
        let error = |name: &str| WriteError { path: name.into(), cause: "the disk is full".into() };
        let files = |names: &[&str]| names.iter().map(PathBuf::from).collect::<Vec<_>>();
        for (failed, saved, checkpoint, text) in [
            (vec!["a.exr"], files(&[]), None, "the file \"a.exr\" could not be written: the disk is full"),
            (
                vec!["a.exr", "b.png"],
                files(&["c.png"]),
                None,
                "the file \"a.exr\" could not be written: the disk is full; \
                 the file \"b.png\" could not be written: the disk is full; \"c.png\" was saved",
            ),
            (
                vec!["a.exr"],
                files(&["b.png", "c.png"]),
                Some(PathBuf::from("a.checkpoint.exr")),
                "the file \"a.exr\" could not be written: the disk is full; \"b.png\", \"c.png\" were saved; \
                 --resume continues from \"a.checkpoint.exr\"",
            ),
        ] {
            let failed = failed.into_iter().map(error).collect();
            assert_eq!(Error::Outputs { failed, saved, checkpoint }.to_string(), text);
        }
    }

    #[test]
    fn messages_have_one_form() {
        assert_eq!(sentence("The file \"a\" is gone."), "the file \"a\" is gone");
        assert_eq!(sentence("GPU lost:\n  timeout"), "GPU lost: timeout");
        assert_eq!(sentence("Box  One.glb is cut short."), "Box  One.glb is cut short");
        assert_eq!(sentence(""), "");
    }
}
