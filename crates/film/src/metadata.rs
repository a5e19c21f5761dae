//! What a file says about the render that made it.

use serde::{Deserialize, Serialize};

use crate::Part;

/// Contents of the JSON text attribute `surelight` of an EXR.
///
/// Keys of `settings` are written in alphabetical order, so equal metadata are equal bytes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// Version of Surelight.
    pub version: String,
    /// Hash of the scene as loaded.
    pub scene_hash: String,
    /// Options that shape the picture, by name.
    pub settings: serde_json::Map<String, serde_json::Value>,
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
    /// Options in force that bias the picture.
    pub biased: Vec<String>,
    /// Samples that were not finite and were left out.
    pub dropped_samples: u64,
    /// Of a part of a render: what it takes to go on, or to join it with others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<Part>,
}
