//! The state from which a render resumes.

use surelight_prepare::Batches;

/// The state of a render, beside its film, from which another run can continue. The default is the
/// beginning of a render.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ResumeState {
    /// The first sample of this part of the render.
    pub first: u32,
    /// The film holds the samples from the first up to this one, which is the next to be traced.
    pub next: u32,
    /// Number of the next batch.
    pub batch: u32,
    /// With a precision, the pilot's estimate: the samples per pixel for which batches are planned,
    /// and those before the first check.
    pub pilot: Option<[u32; 2]>,
}

impl ResumeState {
    /// The state before sample `first` of a render of `spp` samples per pixel.
    ///
    /// # Errors
    /// Where no batch ends there; the error has the nearest samples on either side where one does.
    pub fn before(first: u32, spp: u32) -> Result<Self, [u32; 2]> {
        let (ends, batch) = Batches { planned: Some(spp) }.around(first);
        if ends[0] == first { Ok(Self { first, next: first, batch, pilot: None }) } else { Err(ends) }
    }
}
