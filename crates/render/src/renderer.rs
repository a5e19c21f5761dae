//! A scene on a device with its kernels: traces batches of samples and adds complete ones to a
//! film.

use std::time::Instant;

use surelight_film::{Film, Window};
use surelight_prepare::{KernelKey, Prepared};

use crate::{
    accumulator::Accumulator,
    adaptive::{PILOT, PILOT_SEED, Shares, SharesOnDevice, min_share},
    counts::{Counts, Monitor, Observer},
    device::Device,
    dispatch::Dispatcher,
    error::RenderError,
    kernel::{Checks, Resources},
    kernel_set::{CompiledSet, KernelSet},
    lanes::default_lanes,
    particles::Particles,
    pass::BatchRange,
    precompiled::PrecompiledKernel,
    scene_on_device::SceneOnDevice,
    upload::Uploader,
};

/// Options for making a renderer, for measurements and tests.
#[derive(Default)]
pub(crate) struct Options {
    pub(crate) checks: Checks,
    /// Approximate number of lanes traced at once.
    pub(crate) lanes: Option<u32>,
    pub(crate) precompiled: Option<PrecompiledKernel>,
}

/// A scene on a device, with its compiled kernels.
pub struct Renderer<'a> {
    dispatcher: Dispatcher<'a>,
    scene: SceneOnDevice,
    kernels: KernelSet,
    pub(crate) accumulator: Accumulator,
    /// Where particles are traced from the lights.
    particles: Option<Particles>,
    /// Where the kernel is adaptive, pixels' shares of the samples.
    shares: Option<SharesOnDevice>,
    key: KernelKey,
    /// The WGSL of the path kernel and, where there is one, of the light tracing kernel.
    pub wgsl: String,
    /// Bytes of device memory in use.
    pub device_bytes: u64,
    /// Seconds spent composing, compiling and uploading.
    pub compile_seconds: f64,
    /// Of these, seconds of uploading the scene.
    pub upload_seconds: f64,
    /// Work done so far.
    pub counts: Counts,
}

impl<'a> Renderer<'a> {
    /// Composes and compiles the scene's kernels and uploads their arrays.
    pub fn new(device: &'a Device, prepared: &Prepared) -> Result<Self, RenderError> {
        Self::with_options(device, prepared, Options::default())
    }

    /// The same with a precompiled path kernel. Where it is not the scene's, it is dropped and the
    /// right one is compiled.
    pub fn with_kernel(
        device: &'a Device,
        prepared: &Prepared,
        precompiled: PrecompiledKernel,
    ) -> Result<Self, RenderError> {
        Self::with_options(device, prepared, Options { precompiled: Some(precompiled), ..Options::default() })
    }

    pub(crate) fn with_options(device: &'a Device, prepared: &Prepared, options: Options) -> Result<Self, RenderError> {
        let started = Instant::now();
        let Options { checks, lanes, precompiled } = options;
        let blueprint = prepared.blueprint().on_images(device.reads_images());
        let key = blueprint.key();
        let compiled = CompiledSet::new(device, prepared, &blueprint, checks, precompiled)?;

        let (mut up, mut resources) = (Uploader::new(device), Resources::new());
        let scene = SceneOnDevice::upload(&mut up, &mut resources, prepared, &key, &compiled.paths.shader)?;
        let dispatcher = Dispatcher::new(device, &mut up, &mut resources)?;
        let lanes = lanes.unwrap_or_else(|| default_lanes(device));
        let accumulator =
            Accumulator::new(&dispatcher, &mut up, &mut resources, &key, &compiled.paths, scene.size, lanes)?;
        let shares = SharesOnDevice::new(&mut up, &mut resources, &key, scene.size)?;
        let particles = match prepared.light_tracing().zip(compiled.particles.as_ref()) {
            Some((tracing, compiled)) => {
                Some(Particles::new(device, &mut up, &mut resources, &key, compiled, &tracing, scene.size)?)
            }
            None => None,
        };
        let kernels = compiled.bind(device, &resources)?;
        accumulator.warm_up(&dispatcher, &kernels.paths)?;
        if let Some((particles, kernel)) = particles.as_ref().zip(kernels.particles.as_ref()) {
            particles.warm_up(&dispatcher, kernel)?;
        }
        Ok(Self {
            dispatcher,
            upload_seconds: scene.upload_seconds,
            scene,
            kernels,
            accumulator,
            particles,
            shares,
            key,
            wgsl: compiled.wgsl(),
            device_bytes: up.bytes,
            compile_seconds: started.elapsed().as_secs_f64(),
            counts: Counts::default(),
        })
    }

    /// The contents of the kernel.
    pub fn key(&self) -> KernelKey {
        self.key
    }

    /// Maximum number of batches in one call of [`Self::trace`].
    pub fn max_batches(&self) -> u32 {
        self.accumulator.max_batches
    }

    /// Maximum number of lanes traced at once.
    pub fn lanes(&self) -> u32 {
        self.accumulator.max_lanes
    }

    /// Changes the seed: samples from now on are independent of the earlier ones.
    pub fn set_seed(&mut self, seed: u32) {
        self.scene.set_seed(self.dispatcher.device, seed);
    }

    /// Where the kernel is adaptive, estimates each block's share of the samples from a pilot of
    /// four samples per pixel of the whole image, which are discarded. From then on each block of
    /// 8×8 pixels gets a quarter to eight times the requested samples; before, all get the same.
    /// When at least 256 are `planned`, no pixel gets fewer than 256. Returns false when the
    /// observer stopped it.
    ///
    /// The shares depend on the scene, the settings, the seed and the plan alone, so that crops and
    /// parts of a render agree.
    pub fn adapt(&mut self, planned: Option<u32>, observer: &mut Observer<'_>) -> Result<bool, RenderError> {
        let size = self.scene.size;
        if !self.set_shares(Shares::even(size)) {
            return Ok(true);
        }
        let (counts, seed) = (self.counts, self.scene.seed());
        let mut film = Film::new(size[0], size[1]);
        self.set_seed(seed ^ PILOT_SEED);
        let finished = self.trace(&mut film, 0, PILOT[0], PILOT[1], observer);
        self.set_seed(seed);
        self.counts = counts;
        let finished = finished?;
        if finished {
            self.set_shares(Shares::by_noise(&film, min_share(planned)));
        }
        Ok(finished)
    }

    /// Returns false where the kernel is not adaptive.
    fn set_shares(&mut self, shares: Shares) -> bool {
        let Some(on_device) = &mut self.shares else { return false };
        on_device.set(self.dispatcher.device, shares);
        true
    }

    /// Mean over a window's pixels of samples per requested sample.
    pub fn mean_share(&self, window: &Window) -> f64 {
        self.shares.as_ref().map_or(1.0, |on_device| on_device.shares.mean(window))
    }

    /// Traces `batches` batches of `samples` samples per pixel and adds them to the film, which may
    /// be of a crop. `first_batch` is the number of the first (with one sequence: of its first
    /// sample). After [`Self::adapt`] some pixels have more samples, others fewer. Returns false
    /// when the observer stopped it: as these batches are incomplete, nothing is added.
    ///
    /// [`crate::sample`] traces any number of batches.
    pub fn trace(
        &mut self,
        film: &mut Film,
        first_batch: u32,
        batches: u32,
        samples: u32,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        let range = BatchRange { first: first_batch, batches, samples };
        let (dispatcher, kernels) = (&self.dispatcher, &self.kernels);
        let monitor = &mut Monitor { counts: &mut self.counts, observer };
        let Some(mut traced) = self.accumulator.trace(dispatcher, &kernels.paths, film, range, monitor)? else {
            return Ok(false);
        };
        let shares = self.shares.as_ref().map(|on_device| &on_device.shares);
        if let Some((particles, kernel)) = self.particles.as_mut().zip(kernels.particles.as_ref())
            && !particles.trace(dispatcher, kernel, range, shares, &mut traced, monitor)?
        {
            return Ok(false);
        }
        let started = Instant::now();
        self.accumulator.add_to_film(film, traced, samples, shares)?;
        self.counts.film_seconds += started.elapsed().as_secs_f64();
        Ok(true)
    }

    /// Albedo and normal of first hits, averaged over a pixel, and depth through its centre.
    pub fn trace_features(&mut self, film: &mut Film) -> Result<(), RenderError> {
        let (dispatcher, kernel) = (&self.dispatcher, &self.kernels.features);
        let features = self.accumulator.trace_features(dispatcher, kernel, film, &mut self.counts)?;
        Ok(film.set_features(features)?)
    }
}
