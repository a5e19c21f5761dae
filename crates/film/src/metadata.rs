//! The metadata of a file: the render that made it.

use serde::{Deserialize, Serialize};

use crate::{ExposureRecord, RenderSettings};

/// Contents of the JSON text attribute `surelight` of an EXR. Equal metadata are equal bytes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// Version of Surelight.
    pub version: String,
    /// Hash of the scene as loaded.
    pub scene_hash: String,
    /// Settings that shape the picture; `None` in files of other than a single render, such as the
    /// reference of a benchmark.
    #[serde(deserialize_with = "RenderSettings::read", skip_serializing_if = "Option::is_none")]
    pub settings: Option<RenderSettings>,
    /// Seed of all samples.
    pub seed: u64,
    /// First sample index and the one after the last.
    pub sample_range: [u64; 2],
    /// Part of the image rendered, as x0, y0, x1, y1 with x1 and y1 outside; `None`: the whole.
    pub crop: Option<[u32; 4]>,
    /// Independent estimates that the variance is made of; its degrees of freedom are one less.
    pub batches: u32,
    /// Name of the adapter.
    pub device: String,
    /// Driver and its version.
    pub driver: String,
    /// Options in force that bias the picture, and light that no path finds.
    pub biased: Vec<String>,
    /// Samples that were not finite and were left out.
    pub dropped_samples: u64,
    /// Samples per pixel at which `--resume` extended a render to more than were planned.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub extended_from: Vec<u64>,
    /// Adapters and drivers of the parts, where they differ: means and error bars hold, bits do
    /// not.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mixed: Vec<String>,
    /// Exposure of the PNG, where it follows from the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<ExposureRecord>,
    /// Of a part of a render: the data to resume it, or to join it with others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<RenderPart>,
}

impl Metadata {
    /// Whether the pixels of each 2×2 square share paths.
    pub fn reuses_paths(&self) -> bool {
        self.settings.as_ref().is_some_and(|settings| settings.path_reuse)
    }

    /// Whether the environment is hidden from the camera, and alpha is coverage.
    pub fn is_transparent(&self) -> bool {
        self.settings.as_ref().is_some_and(|settings| settings.transparent)
    }

    /// Whether all batches of a pixel are pieces of one sequence: the estimated variance is then
    /// an upper bound.
    pub fn has_one_sequence(&self) -> bool {
        self.settings.as_ref().is_some_and(|settings| settings.one_sequence)
    }

    /// Refuses settings in another format than this version reads.
    pub(crate) fn check_settings(&self) -> Result<(), String> {
        self.settings.as_ref().map_or(Ok(()), RenderSettings::check)
    }
}

/// The render that an unfinished picture belongs to. Its place and its samples are in
/// [`Metadata::crop`] and [`Metadata::sample_range`].
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct RenderPart {
    /// Pixels a row and rows of the whole image.
    pub size: [u32; 2],
    /// Samples per pixel of the whole render; `None`: no number was set.
    pub planned_samples: Option<u64>,
    /// Samples that this part is to have in the end: the first, and the one after the last.
    pub asked_samples: Option<[u64; 2]>,
    /// Number of the batch that comes after these samples.
    pub next_batch: u32,
    /// With a precision as the goal, the result of its pilot: samples that batches are planned for,
    /// and those before the first evaluation.
    pub pilot: Option<[u32; 2]>,
    /// Hash of the kernel.
    pub kernel: String,
    /// Samples finished, of all pixels.
    pub paths: u64,
    /// Rays traced for them.
    pub rays: u64,
    /// Rays whose traversal was cut short.
    pub truncated: u64,
    /// Seconds of tracing.
    pub seconds: f64,
    /// Hash of the moments, set when they are written.
    pub checksum: String,
}
