//! Runs kernels over tiles of the image and adds what they find to a film, when all of it is there.

use std::time::{Duration, Instant};

use surelight_film::{Features as FilmFeatures, Film, FilmError, Window};

use surelight_prepare::{KernelKey, Part, Prepared, RecordLayout, View, compose, path_kernel};

use crate::{
    adaptive::{LOOK, LOOK_SEED, Shares, least_share},
    ahead::Ahead,
    device::Device,
    dispatch::{Dispatcher, LONGEST, Sliced},
    error::RenderError,
    kernel::{Checks, Kernel, Program, Resource},
    particles::Particles,
    pass::{FeaturePixel, GROUP, Pass, Run, Tile},
    resources::scene_resources,
    schedule::{Counts, Observer, PATH_ENTRY, cpu_threads, side, usual_lanes},
    upload::Uploader,
};

/// Root module of the kernel for first-hit features.
const FEATURE_KERNEL: &str = "package::kernel::first_hit";

/// Rays of a pixel that albedo and normal are averaged over.
const FEATURE_SAMPLES: u32 = 16;

/// A scene on a device, with its compiled kernels.
pub struct Renderer<'a> {
    dispatcher: Dispatcher<'a>,
    /// What the kernel contains.
    key: KernelKey,
    /// The WGSL of the path kernel and, where there is one, of the light tracing kernel.
    pub wgsl: String,
    /// Bytes of device memory in use.
    pub device_bytes: u64,
    /// Seconds spent composing, compiling and uploading.
    pub compile_seconds: f64,
    /// Of these, seconds of uploading the scene.
    pub upload_seconds: f64,
    paths: Sliced,
    feature_kernel: Kernel,
    particles: Option<Particles>,
    view: wgpu::Buffer,
    pass_buffer: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// Sums of coverage, 4 bytes for 16 of `sums`, where coverage is counted.
    coverage_sums: Option<wgpu::Buffer>,
    feature_pixels: wgpu::Buffer,
    /// Where the kernel is adaptive, pixels' shares of the samples, and where it reads them.
    shares: Option<(Shares, wgpu::Buffer)>,
    readback: wgpu::Buffer,
    /// Pixels of the whole picture.
    size: [u32; 2],
    threads: u32,
    most_lanes: u32,
    walks: u32,
    seed: u32,
    most_batches: u32,
    /// What has been done so far.
    pub counts: Counts,
}

impl<'a> Renderer<'a> {
    /// Composes and compiles the scene's kernel and uploads what it reads.
    pub fn new(device: &'a Device, prepared: &Prepared) -> Result<Self, RenderError> {
        Self::with_checks(device, prepared, Checks::default())
    }

    /// Likewise, choosing whether accesses are checked.
    pub fn with_checks(device: &'a Device, prepared: &Prepared, checks: Checks) -> Result<Self, RenderError> {
        Self::build(device, prepared, checks, usual_lanes(device), None)
    }

    /// Likewise, with a kernel that was compiled before; where it is not the scene's, it is dropped and the right one compiled.
    pub fn with_kernel(device: &'a Device, prepared: &Prepared, ahead: Ahead) -> Result<Self, RenderError> {
        Self::build(device, prepared, Checks::default(), usual_lanes(device), Some(ahead))
    }

    /// Likewise, choosing about how many lanes are traced at once: one row of 8×8 blocks at least. The picture is the same.
    pub fn with_lanes(device: &'a Device, prepared: &Prepared, lanes: u32) -> Result<Self, RenderError> {
        Self::build(device, prepared, Checks::default(), lanes, None)
    }

    fn build(
        device: &'a Device,
        prepared: &Prepared,
        checks: Checks,
        wanted: u32,
        ahead: Option<Ahead>,
    ) -> Result<Self, RenderError> {
        let started = Instant::now();
        let blueprint = prepared.blueprint().on_images(device.reads_images());
        let key = blueprint.key();
        let side = side(&key);
        let (shader, program) = match ahead.filter(|ahead| ahead.is_of(device, &blueprint)) {
            Some(ahead) => (ahead.shader, ahead.program),
            None => {
                let shader = compose(path_kernel(&key).0, &key, &blueprint.constants)?;
                let program = Program::new(device, &shader, PATH_ENTRY, checks)?;
                (shader, program)
            }
        };
        let feature_shader = compose(FEATURE_KERNEL, &key.first_hits(), &blueprint.constants)?;

        let mut up = Uploader::new(device);
        let uploading = Instant::now();
        let mut resources = scene_resources(&mut up, prepared, &key, &shader)?;
        let upload_seconds = uploading.elapsed().as_secs_f64();
        let [width, height] = prepared.view().size;
        let threads = if device.info.is_cpu { cpu_threads() } else { 1 };
        let state_bytes = RecordLayout::of(&shader, path_kernel(&key).1).map_or(256, |l| l.span);
        let lane_limit = (device.info.max_binding / u64::from(state_bytes)).min(u64::from(u32::MAX)) as u32;
        // Where there are many lanes, as many pixels as otherwise are in work at once.
        let wanted = if device.info.is_cpu { wanted } else { wanted / (side * side) };
        let tiles = Tile::bands([0, 0], [width, height], wanted.min(lane_limit), side);
        let most_of = |tiles: &[Tile]| tiles.iter().map(|t| t.lanes(threads)).max().unwrap_or(GROUP);
        let most_lanes = most_of(&tiles);
        let feature_bytes = 32 * u64::from(most_of(&Tile::bands([0, 0], [width, height], most_lanes, 1)));
        let pixels = u64::from(side * side * most_lanes);
        let most_batches = (device.info.max_binding / (16 * pixels)).clamp(1, 16) as u32;

        use wgpu::BufferUsages as U;
        let storage = U::STORAGE | U::COPY_SRC | U::COPY_DST;
        let lanes = u64::from(most_lanes);
        let view = up.buffer("the view", &[prepared.view()], U::UNIFORM | U::COPY_DST)?;
        let pass_buffer = up.buffer("the pass", &[Pass::default()], U::UNIFORM | U::COPY_DST)?;
        let dispatcher = Dispatcher::new(device, &mut up, &mut resources)?;
        let states = up.zeros("path states", lanes * u64::from(state_bytes), U::STORAGE)?;
        let sum_bytes = pixels * 16 * u64::from(most_batches);
        let sums = up.zeros("batch sums", sum_bytes, storage)?;
        let coverage_sums = match key.has(Part::Transparent) {
            true => Some(up.zeros("sums of coverage", sum_bytes / 4, storage)?),
            false => None,
        };
        let feature_pixels = up.zeros("first-hit features", feature_bytes, storage)?;
        let readback = up.zeros("the copy of batch sums", sum_bytes.max(feature_bytes), U::MAP_READ | U::COPY_DST)?;
        for (name, buffer) in [
            ("view", &view),
            ("pass_info", &pass_buffer),
            ("states", &states),
            ("batch_sums", &sums),
            ("feature_pixels", &feature_pixels),
        ] {
            resources.insert(name.into(), Resource::Buffer(buffer.clone()));
        }
        if let Some(buffer) = &coverage_sums {
            resources.insert("coverage_sums".into(), Resource::Buffer(buffer.clone()));
        }
        let mut shares = None;
        if key.has(Part::Adaptive) {
            let even = Shares::even([width, height]);
            let buffer = up.buffer("shares of the samples", &even.quarters, U::STORAGE | U::COPY_DST)?;
            resources.insert("quarters".into(), Resource::Buffer(buffer.clone()));
            shares = Some((even, buffer));
        }
        // Nobody kills a CPU driver's dispatches; interrupts wait for them.
        let longest = if device.info.is_cpu { 4 * LONGEST } else { LONGEST };
        let kernel = program.bind(device, &resources)?;
        let paths = Sliced::new(kernel, pass_buffer.clone(), |counts| &mut counts.paths, longest);
        let feature_kernel = Kernel::new(device, &feature_shader, "trace_features", checks, &resources)?;
        let particles = Particles::new(device, &mut up, prepared, &key, &mut resources, threads, checks)?;
        let (particles, emit_wgsl) = particles.unzip();
        let mut renderer = Self {
            dispatcher,
            key,
            wgsl: shader.wgsl + &emit_wgsl.unwrap_or_default(),
            device_bytes: up.bytes,
            compile_seconds: 0.0,
            upload_seconds,
            paths,
            feature_kernel,
            particles,
            view,
            pass_buffer,
            sums,
            coverage_sums,
            feature_pixels,
            shares,
            readback,
            size: [width, height],
            threads,
            most_lanes,
            walks: 1,
            seed: prepared.view().seed,
            most_batches,
            counts: Counts::default(),
        };
        renderer.warm_up(&tiles[0])?;
        renderer.compile_seconds = started.elapsed().as_secs_f64();
        Ok(renderer)
    }

    /// What the kernel contains.
    pub fn key(&self) -> KernelKey {
        self.key
    }

    /// Has the driver compile.
    fn warm_up(&self, tile: &Tile) -> Result<(), RenderError> {
        let pass = Pass { size: tile.size, samples: 1, lanes: GROUP * self.threads, restart: 1, ..self.pass_of(tile) };
        self.paths.warm_up(&self.dispatcher, self.threads, &pass)?;
        self.particles.as_ref().map_or(Ok(()), |particles| particles.warm_up(&self.dispatcher))
    }

    fn pass_of(&self, tile: &Tile) -> Pass {
        Pass {
            corner: tile.corner,
            size: tile.size,
            lanes: tile.lanes(self.threads),
            threads: self.threads,
            walks: self.walks,
            ..Pass::default()
        }
    }

    /// Changes the seed: pictures from here on are independent of those before.
    pub fn set_seed(&mut self, seed: u32) {
        self.seed = seed;
        let offset = std::mem::offset_of!(View, seed) as u64;
        self.dispatcher.device.queue.write_buffer(&self.view, offset, bytemuck::bytes_of(&seed));
    }

    /// Where the kernel is adaptive, looks at the whole picture (four samples a pixel, which are thrown away) and finds which share of the
    /// samples each block of 8×8 pixels is to have from here on, from a quarter of those asked for to eight times as many; before that all
    /// have the same. When at least 256 are `planned`, no pixel gets fewer than these. Returns false when the observer stopped it.
    ///
    /// What is found depends on the scene, the settings, the seed and the plan alone, so that crops and parts of a render agree.
    pub fn adapt(&mut self, planned: Option<u32>, observer: &mut Observer<'_>) -> Result<bool, RenderError> {
        if !self.share_out(Shares::even(self.size)) {
            return Ok(true);
        }
        let (counts, seed) = (self.counts, self.seed);
        let mut film = Film::new(self.size[0], self.size[1]);
        self.set_seed(seed ^ LOOK_SEED);
        let finished = self.trace(&mut film, 0, LOOK[0], LOOK[1], observer);
        self.set_seed(seed);
        self.counts = counts;
        let finished = finished?;
        if finished {
            self.share_out(Shares::by_noise(&film, least_share(planned)));
        }
        Ok(finished)
    }

    /// Returns false where the kernel is not adaptive.
    fn share_out(&mut self, new: Shares) -> bool {
        let Some((shares, buffer)) = &mut self.shares else { return false };
        self.dispatcher.device.queue.write_buffer(buffer, 0, bytemuck::cast_slice(&new.quarters));
        *shares = new;
        true
    }

    /// Samples of a window's pixels, on average, for each one that is asked for.
    pub fn mean_share(&self, window: &Window) -> f64 {
        self.shares.as_ref().map_or(1.0, |(shares, _)| shares.mean(window))
    }

    /// Walks every ray so many times from here on, if the kernel was made with the feature `repeat_walk`. The picture stays the same, so that what it
    /// costs more is the walk's.
    pub fn set_walks(&mut self, walks: u32) {
        self.walks = walks.max(1);
    }

    /// How long a dispatch should last, at least and at most, as far as the work left and the limit on a lane's iterations let it. Pictures stay the
    /// same; it is for measurements.
    pub fn set_dispatch(&mut self, least: Duration, most: Duration) {
        self.paths.set_durations(least, most);
    }

    /// Most batches that one call of [`Self::trace`] can hold.
    pub fn most_batches(&self) -> u32 {
        self.most_batches
    }

    /// Lanes that are traced at once.
    pub fn lanes(&self) -> u32 {
        self.most_lanes
    }

    /// Traces `batches` batches of `samples` samples a pixel, the first of them numbered `first_batch` (with one scramble: by the
    /// number of its first sample), and adds them to the film, which may be of a crop. Returns false when the observer stopped it: the film then has none of these batches for some of its tiles' pixels,
    /// so nothing at all is added. After [`Self::adapt`] some pixels have more samples, others fewer.
    pub fn trace(
        &mut self,
        film: &mut Film,
        first_batch: u32,
        batches: u32,
        samples: u32,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        // A pass without samples would write nothing, as if the driver had lost it.
        if samples == 0 {
            return Err(FilmError::NoSamples.into());
        }
        let tiles = self.tiles_of(film, side(&self.key))?;
        if batches == 0 {
            return Ok(true);
        }
        let (mut results, mut coverage) = (Vec::new(), Vec::new());
        for tile in tiles {
            let pass = Pass { first_batch, batches, samples, ..self.pass_of(&tile) };
            let bytes = self.sum_bytes(&pass);
            if bytes > self.sums.size() {
                return Err(RenderError::TooManyBatches { batches, limit: self.most_batches });
            }
            // What an earlier tile left is wiped, so that a batch that is not written shows.
            self.dispatcher.device.clear(&self.sums, Some(bytes))?;
            if let Some(sums) = &self.coverage_sums {
                self.dispatcher.device.clear(sums, Some(bytes / 4))?;
            }
            let slice = |budget, restart| Pass { budget, restart, ..pass };
            let groups = pass.lanes / GROUP;
            if self.paths.run(&self.dispatcher, groups, slice, &mut self.counts, observer)?.is_none() {
                return Ok(false);
            }
            let started = Instant::now();
            results.push((tile, self.dispatcher.device.fetch(&self.sums, 0, bytes, &self.readback)?));
            if let Some(sums) = &self.coverage_sums {
                coverage.push(self.dispatcher.device.fetch::<f32>(sums, 0, bytes / 4, &self.readback)?);
            }
            self.counts.read_seconds += started.elapsed().as_secs_f64();
        }
        if let Some(particles) = &mut self.particles {
            let run = Run { first_batch, batches, samples };
            let shares = self.shares.as_ref().map(|(shares, _)| shares);
            if !particles.trace(&self.dispatcher, run, shares, &mut results, &mut self.counts, observer)? {
                return Ok(false);
            }
        }
        let started = Instant::now();
        let mut coverage = coverage.into_iter();
        for (tile, sums) in results {
            let coverage = coverage.next();
            let lanes = tile.lanes(self.threads);
            let pixels = tile.pixels(lanes, &film.window());
            for (k, batch) in sums.chunks_exact(pixels.len()).enumerate() {
                if pixels.iter().zip(batch).any(|(&p, s)| p != u32::MAX && !s.is_written()) {
                    return Err(RenderError::LostWork { message: "some pixels lack samples after a pass".into() });
                }
                let samples =
                    |x, y| self.shares.as_ref().map_or(samples, |(shares, _)| shares.samples([x, y], samples));
                let added = match &coverage {
                    Some(coverage) => {
                        let coverage = &coverage[k * pixels.len()..][..pixels.len()];
                        film.add_covered_batch(samples, &pixels, batch, coverage)
                    }
                    None => film.add_uneven_batch(samples, &pixels, batch),
                };
                added?;
            }
        }
        self.counts.film_seconds += started.elapsed().as_secs_f64();
        Ok(true)
    }

    /// The film's part of the picture, cut into tiles that the buffers hold.
    fn tiles_of(&self, film: &Film, side: u32) -> Result<Vec<Tile>, RenderError> {
        let window = film.window();
        if window.whole != self.size {
            return Err(RenderError::FilmSize { film: window.whole, view: self.size });
        }
        Ok(Tile::bands(window.corner, window.size, self.most_lanes, side))
    }

    /// Bytes of a pass's batch sums.
    fn sum_bytes(&self, pass: &Pass) -> u64 {
        16 * u64::from(pass.batches) * u64::from(pass.lanes) * u64::from(side(&self.key).pow(2))
    }

    /// Albedo and normal of first hits, averaged over a pixel, and depth through its centre.
    pub fn trace_features(&mut self, film: &mut Film) -> Result<(), RenderError> {
        let window = film.window();
        let count = film.pixels().len();
        let mut all =
            FilmFeatures { albedo: vec![[0.0; 3]; count], normal: vec![[0.0; 3]; count], depth: vec![0.0; count] };
        for tile in self.tiles_of(film, 1)? {
            let pass = Pass { samples: FEATURE_SAMPLES, ..self.pass_of(&tile) };
            for i in 0..=FEATURE_SAMPLES {
                let ray = Pass { first_batch: i, restart: u32::from(i == 0), ..pass };
                let groups = pass.lanes / GROUP;
                let (report, _) = self.dispatcher.run(&self.feature_kernel, groups, &self.pass_buffer, &ray)?;
                self.counts.truncated += u64::from(report.truncated);
            }
            let bytes = u64::from(pass.lanes) * size_of::<FeaturePixel>() as u64;
            let records: Vec<FeaturePixel> =
                self.dispatcher.device.fetch(&self.feature_pixels, 0, bytes, &self.readback)?;
            for (pixel, r) in tile.pixels(pass.lanes, &window).into_iter().zip(records) {
                if pixel != u32::MAX {
                    let i = pixel as usize;
                    all.albedo[i] = r.albedo.map(|sum| sum / FEATURE_SAMPLES as f32);
                    all.depth[i] = r.depth;
                    all.normal[i] = r.normal.map(|sum| sum / FEATURE_SAMPLES as f32);
                }
            }
        }
        Ok(film.set_features(all)?)
    }
}
