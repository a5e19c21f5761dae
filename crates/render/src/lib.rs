//! Traces light paths on the device: upload, specialised kernels, progressive loop.
//!
//! This is the only crate that knows wgpu. From a scene to pixels: [`Prepared::new`] builds the BVH and decides what the kernel
//! must contain, [`Renderer::new`] composes and compiles it and uploads the scene, [`render`] traces until a [`Goal`] is met. Who is in a
//! hurry compiles while the BVH is built: [`Prepared::with_work`], [`Ahead::compile`], [`Renderer::with_kernel`].

mod adaptive;
mod ahead;
mod device;
mod dispatch;
mod error;
mod integrate;
mod kernel;
mod noise;
mod particles;
mod pass;
mod precise;
mod probe;
mod progression;
mod progressive;
mod renderer;
mod resources;
mod schedule;
mod standing;
mod stopwatch;
mod trial;
mod twins;
mod upload;

pub use ahead::Ahead;
pub use device::{AdapterChoice, AdapterInfo, Device};
pub use error::RenderError;
pub use integrate::{Formula, FormulaError, Grid, Integrand, MOST_DIMENSIONS, Sampled};
pub use kernel::Checks;
pub use probe::{Probe, run_probe};
pub use progression::{Keeper, Outcome, Progress, Watch};
pub use progressive::{Goal, render, render_from};
pub use renderer::Renderer;
pub use schedule::{Counts, Observer};
pub use standing::Standing;
pub use trial::{Trial, best_trial, judge_trials};
pub use twins::host_layouts;

// What is rendered is part of this crate's interface.
pub use surelight_prepare::{
    ActiveClipPlanes, Blueprint, CameraModel, Composed, Constant, Directions, EnvironmentKind, Estimator, Instrument,
    Integrator, KernelKey, KeyError, Origin, Part, Parts, PathReuse, PointSet, PrepareError, Prepared, RecordLayout,
    Row, Sampler, Settings, TABLE, Unreachable, compose, compose_modules, material_fields, may_have_caustics,
    path_kernel, shader_modules, sheen_albedos,
};
