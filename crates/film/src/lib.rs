//! The film: what every pixel knows about its radiance and about its own error,
//! and the files that carry it.
//!
//! A render arrives as *batches*: independent estimates of the whole image, each of a
//! known number of samples. [`Film`] keeps wide totals and second moments of them, from
//! which it gives mean, variance of the mean and degrees of freedom of every pixel.
//! [`write_exr`] stores those as layers, [`write_png`] a tone-mapped picture of the mean.
//! Both files are written beside their target and renamed, so that a target is either
//! complete or untouched.
//!
//! Pixels are counted row by row from the top left: index `y * width + x`.
//! Radiance is linear Rec. 709 (W·sr⁻¹·m⁻² or nit, as the scene's emitters are given).

mod atomic;
pub mod compare;
mod error;
mod exr;
mod film;
mod metadata;
mod moments;
mod png;
mod stats;
mod tonemap;

pub use atomic::write_file;
pub use error::{FilmError, ReadError, WriteError};
pub use exr::{ExrImage, encode_exr, read_exr, write_exr};
pub use film::{Features, Film};
pub use metadata::Metadata;
pub use moments::{DoubleDouble, PixelMoments};
pub use png::{Display, encode_png, write_png, write_rgb8_png};
pub use stats::ErrorSummary;
pub use tonemap::{ToneMap, linear_to_srgb, to_u8};
