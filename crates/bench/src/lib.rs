//! Speed against accuracy: races the renderer's methods on a scene and reports which reaches a
//! given error first.
//!
//! A [`Method`] is an integrator, a sampler and further options. [`race`] renders each of
//! them progressively, several times, in turn, and compares every checkpoint with a
//! [`measure::Reference`], whose own noise is subtracted. The measurements are [`data::Data`]:
//! `data.json` and `data.csv` hold all of them, and the whole report is computed from them.
//!
//! ```no_run
//! use std::path::Path;
//! use surelight_bench::report::read_data;
//!
//! // Which method is fastest to an error of 2 %, by its report?
//! let data = read_data(Path::new("report/data.json"))?;
//! for scene in &data.scenes {
//!     if let Some((method, seconds)) = scene.ranking(0.02, false).first() {
//!         println!("{}: {} in {:.1} s", scene.name, scene.methods[*method].name, seconds.value);
//!     }
//! }
//! # Ok::<(), surelight_bench::BenchError>(())
//! ```

pub mod analysis;
mod campaign;
pub mod chart;
pub mod conditions;
pub mod data;
mod error;
pub mod gate;
pub mod map;
pub mod measure;
mod method;
mod overlay;
pub mod paths;
pub mod pictures;
mod plan;
mod race;
mod reference;
pub mod report;
#[cfg(test)]
mod testing;
mod tracer;
mod traversal;
mod trial;
mod variations;

pub use campaign::{WatchAll, campaign};
pub use error::BenchError;
pub use method::{Method, MethodWords};
pub use overlay::{Peer, read_overlay};
pub use plan::{Budget, Plan};
pub use race::{Status, Watch, race};
pub use tracer::Subject;
pub use variations::Variations;
