//! Traces light paths on the device: upload, specialised kernels, progressive loop.
//!
//! This is the only crate that depends on wgpu. From a scene to pixels: [`Prepared::new`] builds
//! the BVH and decides the kernel's parts, [`Renderer::new`] composes and compiles it and uploads
//! the scene, [`render`] traces until a [`Goal`] is reached. To compile while the BVH is built:
//! [`Prepared::with_work`], [`PrecompiledKernel::compile`], [`Renderer::with_kernel`].
//!
//! ```no_run
//! use surelight_film::Film;
//! use surelight_prepare::{Prepared, Settings};
//! use surelight_render::{AdapterChoice, Device, Goal, Renderer, render};
//!
//! let scene = surelight_scenes::cornell_box::cornell_box();
//! let settings = Settings::new(256, 256);
//! let prepared = Prepared::new(&scene, &scene.cameras[0], &settings)?;
//! let device = Device::new(&AdapterChoice::Best)?;
//! let mut renderer = Renderer::new(&device, &prepared)?;
//! let mut film = Film::new(settings.width, settings.height);
//! let goal = Goal { spp: Some(64), ..Goal::default() };
//! render(&mut renderer, &mut film, &goal, &mut |progress| progress.spp < 64)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Prepared::new`]: surelight_prepare::Prepared::new
//! [`Prepared::with_work`]: surelight_prepare::Prepared::with_work

mod accumulator;
mod adaptive;
mod counts;
mod device;
mod device_loss;
mod dispatch;
mod error;
pub mod instrument;
mod integrate;
mod kernel;
mod kernel_set;
mod lanes;
mod noise;
mod pacing;
mod particles;
mod pass;
mod precise;
mod precompiled;
mod probe;
mod progressive;
mod renderer;
mod resume;
mod sampling;
mod scene_on_device;
mod stopwatch;
mod tile;
mod trial;
mod upload;

pub use counts::{Counts, Observer};
pub use device::{AdapterChoice, AdapterInfo, Device};
pub use error::RenderError;
pub use integrate::{Formula, FormulaError, Grid, Integrand, MAX_DIMENSIONS, Sampled};
pub use kernel::Checks;
pub use pacing::{CheckpointSink, Outcome, Progress, Watch};
pub use precompiled::PrecompiledKernel;
pub use probe::{Probe, run_probe};
pub use progressive::{Goal, render, render_from};
pub use renderer::Renderer;
pub use resume::ResumeState;
pub use sampling::{BatchSizes, End, FinishedPass, NextPass, PassVisitor, Position, Schedule, sample, sample_batches};
pub use trial::{Trial, best_trial, judge_trials};
