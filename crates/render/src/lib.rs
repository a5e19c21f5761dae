//! Traces light paths on the device: upload, specialised kernels, progressive loop.
//!
//! This is the only crate that knows wgpu.

mod compose;
mod device;
mod error;
mod features;

pub use compose::{Composed, Constant, compose};
pub use device::{AdapterChoice, AdapterInfo, Device};
pub use error::RenderError;
pub use features::Features;
