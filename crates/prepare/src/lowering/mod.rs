//! Lowering of kernels for drivers that run them on a CPU.
//!
//! Shaders are written for GPUs. Two things cost a CPU driver so much that a pass over the composed
//! kernel's syntax tree replaces them, and nothing else in the program depends on it:
//!
//! - It executes both sides of every `if`, masked by lane; only loops skip work ([`branches`]).
//! - It reads a word of a storage buffer lane by lane, a texel of an image four times as fast
//!   ([`images`]).
//!
//! The result is WGSL like any other: it is validated, printed and shipped as text.

pub(crate) mod branches;
pub(crate) mod images;
