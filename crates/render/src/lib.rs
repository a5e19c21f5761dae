//! Traces light paths on the device: upload, specialised kernels, progressive loop.
//!
//! This is the only crate that knows wgpu. From a scene to pixels: [`Prepared::new`] builds the BVH and decides what the kernel
//! must contain, [`Renderer::new`] composes and compiles it and uploads the scene, [`render`] traces until a [`Goal`] is met. Who is in a
//! hurry compiles while the BVH is built: [`Prepared::with_work`], [`PrecompiledKernel::compile`], [`Renderer::with_kernel`].

mod accumulator;
mod adaptive;
mod counts;
mod device;
mod dispatch;
mod error;
pub mod instrument;
mod integrate;
mod kernel;
mod kernel_set;
mod lanes;
mod layouts;
mod noise;
mod particles;
mod pass;
mod precise;
mod precompiled;
mod probe;
mod progression;
mod progressive;
mod renderer;
mod resume;
mod scene_on_device;
mod stopwatch;
mod tile;
mod trial;
mod upload;

pub use counts::{Counts, Observer};
pub use device::{AdapterChoice, AdapterInfo, Device};
pub use error::RenderError;
pub use integrate::{Formula, FormulaError, Grid, Integrand, MOST_DIMENSIONS, Sampled};
pub use kernel::Checks;
pub use layouts::host_layouts;
pub use precompiled::PrecompiledKernel;
pub use probe::{Probe, run_probe};
pub use progression::{CheckpointSink, Outcome, Progress, Watch};
pub use progressive::{Goal, render, render_from};
pub use renderer::Renderer;
pub use resume::ResumeState;
pub use trial::{Trial, best_trial, judge_trials};

// What is rendered is part of this crate's interface.
pub use surelight_prepare::{
    Blueprint, CameraModel, Composed, Constant, Cut, Directions, Estimator, Instrument, Integrator, KernelKey,
    KeyError, Origin, Part, Parts, Points, PrepareError, Prepared, RecordLayout, Row, Sampler, Settings, SharedPaths,
    Surroundings, TABLE, Unreachable, compose, compose_modules, material_fields, may_have_caustics, path_kernel,
    shader_modules, sheen_albedos,
};
