//! The film: the statistics of every pixel's radiance and of its error, and the files that store
//! them.
//!
//! A render is a sequence of *batches*: independent estimates of the whole image, each of a known
//! number of samples. [`Film`] keeps wide totals and second moments of them, from which it gives
//! mean, variance of the mean and degrees of freedom of every pixel. [`write_exr`] stores those as
//! layers, [`write_png`] a tone-mapped picture of the mean. Both files are written beside their
//! target and renamed, so that a target is either complete or untouched.
//!
//! Pixels are counted row by row from the top left: index `y * width + x`.
//! Radiance is linear Rec. 709 (W·sr⁻¹·m⁻² or nit, as the scene's emitters are given).
//!
//! ```
//! use surelight_film::{BatchSum, Film};
//!
//! // Two pixels, four batches of two samples each.
//! let mut film = Film::new(2, 1);
//! for batch in [1.0, 2.0, 3.0, 4.0] {
//!     film.add_batch(2, &[0, 1], &[BatchSum::constant(2, [batch; 3]), BatchSum::constant(2, [1.0; 3])])?;
//! }
//! assert_eq!(film.mean(0), [2.5; 3]);
//! // Batch means 1, 2, 3, 4 have the variance 5/3, and their mean a quarter of it.
//! let variance = film.variance_of_mean(0).unwrap_or_default()[0];
//! assert!((variance - 5.0 / 12.0).abs() < 1e-12);
//! assert_eq!(film.variance_of_mean(1), Some([0.0; 3]));
//! # Ok::<(), surelight_film::FilmError>(())
//! ```

mod atomic;
mod batch;
pub mod compare;
mod double_double;
mod error;
mod exposure;
mod exr;
mod extend;
mod film;
mod identity;
mod merge;
mod metadata;
mod moments;
mod part;
mod png;
mod png_text;
mod precision;
pub mod settings;
mod stats;
mod tail;
mod tonemap;
mod words;

pub use atomic::{check_writable, follow_links, remove_leftovers, write_file};
pub use batch::BatchSum;
pub use double_double::DoubleDouble;
pub use error::{FilmError, ReadError, WriteError, io_cause};
pub use exposure::{AutoExposure, ExposureRecord, Loss, LostPixels};
pub use exr::{ExrImage, encode_exr, read_exr, read_exr_header, write_exr};
pub use extend::read_finished;
pub use film::{Features, Film, Window};
pub use identity::{Compatibility, Difference, difference};
pub use merge::{MergeError, MergePlan, Missing, PartFile};
pub use metadata::{Metadata, RenderPart};
pub use moments::PixelMoments;
pub use part::{read_part, read_part_header};
pub use png::{Display, encode_png, write_png, write_rgb8_png};
pub use png_text::write_png_with_exposure;
pub use precision::{Bound, CERTIFIED_SHARE, Convergence, LUMINANCE_FLOOR, PRECISE_SHARE, Precision};
pub use settings::RenderSettings;
pub use stats::ErrorSummary;
pub(crate) use stats::luminance;
pub use tail::{Certificate, HEAVY, MIN_CERTIFIED_SAMPLES, MIN_PROVISIONAL_SAMPLES};
pub use tonemap::{ToneMap, linear_to_srgb, to_u8};
