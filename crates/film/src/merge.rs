//! Joining the parts of a render: which belong together, the range that they cover, and the missing
//! parts.
//!
//! A part is a box: a rectangle of pixels times a range of samples. Parts that do not overlap and
//! fill a box are as good as that box rendered in one go, since totals do not depend on how they
//! were added up.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::identity::{Compatibility, Difference, difference};
use crate::{Film, Metadata, ReadError, RenderPart, Window, read_part, read_part_header};

/// A part, known by its header.
#[derive(Debug, Clone)]
pub struct PartFile {
    /// The file.
    pub path: PathBuf,
    /// Its metadata.
    pub metadata: Metadata,
    /// Its pixels.
    pub window: Window,
}

impl PartFile {
    /// Reads the header.
    ///
    /// # Errors
    /// Where the file is missing, damaged or no part of a render.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (metadata, window) = read_part_header(path)?;
        Ok(Self { path: path.to_owned(), metadata, window })
    }

    fn part(&self) -> RenderPart {
        self.metadata.part.clone().unwrap_or_default()
    }

    fn bounds(&self) -> Bounds {
        Bounds { edges: self.window.edges(), samples: self.metadata.sample_range }
    }
}

/// A rectangle of pixels times a range of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Bounds {
    edges: [u32; 4],
    samples: [u64; 2],
}

impl Bounds {
    /// Pixels times samples.
    fn volume(&self) -> u128 {
        let [x0, y0, x1, y1] = self.edges.map(u128::from);
        (x1 - x0) * (y1 - y0) * u128::from(self.samples[1] - self.samples[0])
    }

    fn common(&self, other: &Self) -> Option<Self> {
        let [a, b] = [self.edges, other.edges];
        let edges = [a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].min(b[3])];
        let samples = [self.samples[0].max(other.samples[0]), self.samples[1].min(other.samples[1])];
        let some = edges[0] < edges[2] && edges[1] < edges[3] && samples[0] < samples[1];
        some.then_some(Self { edges, samples })
    }

    fn around(&self, other: &Self) -> Self {
        let [a, b] = [self.edges, other.edges];
        let edges = [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
        let samples = [self.samples[0].min(other.samples[0]), self.samples[1].max(other.samples[1])];
        Self { edges, samples }
    }

    /// A box within this one that none of `parts` overlaps. Between two neighbouring edges, all
    /// points are equivalent.
    fn uncovered_box(&self, parts: &[Self]) -> Option<Self> {
        let samples = cuts(parts.iter().flat_map(|p| p.samples), self.samples);
        for samples in samples.windows(2).map(|w| [w[0], w[1]]) {
            let at = |part: &&Self| part.samples[0] <= samples[0] && samples[1] <= part.samples[1];
            let here: Vec<_> = parts.iter().filter(at).collect();
            let rows = cuts(here.iter().flat_map(|p| [p.edges[1], p.edges[3]]), [self.edges[1], self.edges[3]]);
            for y in rows.windows(2) {
                let mut row: Vec<_> = here.iter().filter(|p| p.edges[1] <= y[0] && y[1] <= p.edges[3]).collect();
                row.sort_by_key(|p| p.edges[0]);
                let mut x = self.edges[0];
                for part in row {
                    if part.edges[0] > x {
                        return Some(Self { edges: [x, y[0], part.edges[0], y[1]], samples });
                    }
                    x = x.max(part.edges[2]);
                }
                if x < self.edges[2] {
                    return Some(Self { edges: [x, y[0], self.edges[2], y[1]], samples });
                }
            }
        }
        None
    }
}

/// The places where anything changes, ends included, in order.
fn cuts<T: Copy + Ord>(all: impl Iterator<Item = T>, [first, last]: [T; 2]) -> Vec<T> {
    let mut cuts: Vec<T> = all.filter(|&x| first < x && x < last).chain([first, last]).collect();
    cuts.sort_unstable();
    cuts.dedup();
    cuts
}

/// The missing parts of the whole: one rectangle as an example, and their total share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Missing {
    /// Samples: the first, and the one after the last.
    pub samples: [u64; 2],
    /// Pixels: x0, y0, x1, y1, the last two outside.
    pub edges: [u32; 4],
    /// Whether these are all pixels of the image.
    pub all_pixels: bool,
    /// Share of the whole render that is missing in all, 0 to 1.
    pub share: f64,
}

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { samples: [first, end], edges: [x0, y0, x1, y1], .. } = self;
        write!(f, "samples {first}..{end} of ")?;
        if self.all_pixels { write!(f, "all pixels") } else { write!(f, "the pixels {x0},{y0},{x1},{y1}") }?;
        write!(f, " are missing ({:.3} % of the render is)", 100.0 * self.share)
    }
}

/// Parts that cannot be joined.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// Nothing to join.
    #[error("there is nothing to merge")]
    Nothing,
    /// Two parts of two renders.
    #[error("\"{}\" and \"{}\" are not of one render: {} is {} in the first and {} in the second{}", first.display(), second.display(), difference.what, difference.first, difference.second, remedy(*mixed))]
    Different {
        /// A part.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Their difference.
        difference: Box<Difference>,
        /// Whether they differ in adapter, driver or kernel alone, and can be mixed.
        mixed: bool,
    },
    /// A part of a render whose samples were not counted beforehand: another one may have cut them
    /// into other batches.
    #[error("\"{}\" is of a render without a set number of samples (--spp), which cannot be joined with others", path.display())]
    Open {
        /// The part.
        path: PathBuf,
    },
    /// Samples that come twice.
    #[error("\"{}\" and \"{}\" both hold the samples {}..{} of the pixels {},{},{},{}; they would be added twice", first.display(), second.display(), samples[0], samples[1], edges[0], edges[1], edges[2], edges[3])]
    Overlap {
        /// A part.
        first: PathBuf,
        /// Another.
        second: PathBuf,
        /// Samples in both.
        samples: [u64; 2],
        /// Pixels in both.
        edges: [u32; 4],
    },
    /// A hole between the parts.
    #[error("the parts leave a hole: {0}")]
    Hole(Missing),
    /// A file that cannot be read, or has changed.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A film that does not fit: the file has changed since its header was read.
    #[error("\"{}\" has changed while it was read", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
}

fn remedy(mixed: bool) -> &'static str {
    if mixed { "; --mixed merges them all the same: means and error bars hold, bits do not" } else { "" }
}

/// Parts that belong together and fill a rectangle of pixels times a range of samples.
#[derive(Debug, Clone)]
pub struct MergePlan {
    parts: Vec<PartFile>,
    /// Pixels that the parts make up.
    pub window: Window,
    /// Samples that they make up.
    pub samples: [u64; 2],
    /// The missing parts of the whole render; `None`: nothing.
    pub missing: Option<Missing>,
}

impl MergePlan {
    /// Checks the parts' headers: they are of one render, do not overlap and leave no hole.
    /// With [`Compatibility::Estimator`], adapters may differ.
    ///
    /// # Errors
    /// A sentence that names the files and the conflict.
    pub fn new(parts: Vec<PartFile>, sameness: Compatibility) -> Result<Self, MergeError> {
        let first = parts.first().ok_or(MergeError::Nothing)?;
        let whole = first.window.whole;
        for other in &parts[1..] {
            let size = |part: &PartFile| format!("{}x{}", part.window.whole[0], part.window.whole[1]);
            let sizes = (other.window.whole != whole).then(|| Difference {
                what: "--size".into(),
                first: size(first),
                second: size(other),
            });
            if let Some(found) = difference(&first.metadata, &other.metadata, sameness).or(sizes.clone()) {
                let estimator = difference(&first.metadata, &other.metadata, Compatibility::Estimator).or(sizes);
                return Err(MergeError::Different {
                    first: first.path.clone(),
                    second: other.path.clone(),
                    mixed: estimator.is_none(),
                    difference: Box::new(found),
                });
            }
        }
        if parts.len() > 1 && first.part().planned_samples.is_none() {
            return Err(MergeError::Open { path: first.path.clone() });
        }
        let boxes: Vec<Bounds> = parts.iter().map(PartFile::bounds).collect();
        for (i, a) in boxes.iter().enumerate() {
            if let Some((j, common)) = boxes[..i].iter().enumerate().find_map(|(j, b)| Some((j, a.common(b)?))) {
                return Err(MergeError::Overlap {
                    first: parts[j].path.clone(),
                    second: parts[i].path.clone(),
                    samples: common.samples,
                    edges: common.edges,
                });
            }
        }
        let around = boxes[1..].iter().fold(boxes[0], |around, other| around.around(other));
        // Without a planned number, the parts at hand are the whole.
        let end = first.part().planned_samples.unwrap_or(around.samples[1]).max(around.samples[1]);
        let all = Bounds { edges: Window::all(whole[0], whole[1]).edges(), samples: [0, end] };
        let filled: u128 = boxes.iter().map(Bounds::volume).sum();
        let lacking = |uncovered_box: Bounds| Missing {
            samples: uncovered_box.samples,
            edges: uncovered_box.edges,
            all_pixels: uncovered_box.edges == all.edges,
            share: (all.volume() - filled) as f64 / all.volume().max(1) as f64,
        };
        if let Some(uncovered_box) = around.uncovered_box(&boxes) {
            return Err(MergeError::Hole(lacking(uncovered_box)));
        }
        let missing = all.uncovered_box(&boxes).map(lacking);
        let [x0, y0, x1, y1] = around.edges;
        let window = Window { whole, corner: [x0, y0], size: [x1 - x0, y1 - y0] };
        Ok(Self { parts, window, samples: around.samples, missing })
    }

    /// Adapters and drivers of the parts in alphabetical order; none where all are the same.
    fn adapters(&self) -> Vec<String> {
        let of = |file: &PartFile| match file.metadata.mixed.as_slice() {
            [] => vec![format!("{}, driver {}", file.metadata.device, file.metadata.driver)],
            several => several.to_vec(),
        };
        let all: BTreeSet<String> = self.parts.iter().flat_map(of).collect();
        if all.len() > 1 { all.into_iter().collect() } else { Vec::new() }
    }

    /// Reads the parts one after the other into one film. Complete, it is the film of the whole
    /// render, and its metadata are those of the whole; otherwise it is a larger part.
    ///
    /// # Errors
    /// Where a file cannot be read or has changed meanwhile.
    pub fn join(self) -> Result<(Film, Metadata), MergeError> {
        let mut film = Film::of_window(self.window);
        let mut sum = RenderPart::default();
        let mut dropped = 0;
        for file in &self.parts {
            let (part, metadata) = read_part(&file.path)?;
            let changed = || MergeError::Changed { path: file.path.clone() };
            if metadata != file.metadata {
                return Err(changed());
            }
            film.merge(&part).map_err(|_| changed())?;
            let done = file.part();
            sum.paths += done.paths;
            sum.rays += done.rays;
            sum.truncated += done.truncated;
            sum.seconds += done.seconds;
            dropped += metadata.dropped_samples;
        }
        let first = &self.parts[0];
        let part = RenderPart {
            asked_samples: Some(self.samples),
            paths: sum.paths,
            rays: sum.rays,
            truncated: sum.truncated,
            seconds: sum.seconds,
            ..first.part()
        };
        let metadata = Metadata {
            mixed: self.adapters(),
            sample_range: self.samples,
            crop: (!self.window.is_all()).then(|| self.window.edges()),
            batches: film.degrees_of_freedom(0).round() as u32 + 1,
            dropped_samples: dropped,
            exposure: None, // of the parts
            part: self.missing.is_some().then_some(part),
            ..first.metadata.clone()
        };
        Ok((film, metadata))
    }
}

#[cfg(test)]
mod tests;
