//! Runs kernels over tiles of the image, in dispatches short enough for any driver, and checks that no work is lost.

use std::time::{Duration, Instant};

use surelight_film::{BatchSum, Features as FilmFeatures, Film};

use crate::{
    ahead::Ahead,
    compose::compose,
    device::Device,
    error::RenderError,
    features::Features,
    kernel::{Checks, Kernel, Program, Resource},
    particles::Particles,
    pass::{Control, FeaturePixel, GROUP, Pass, Tile},
    prepare::{Prepared, View},
    reflect::RecordLayout,
    resources::scene_resources,
    schedule::{
        Counts, LEAST_BUDGET, LONGEST_DISPATCH, MOST_BUDGET, Observer, PATH_ENTRY, SHORTEST_DISPATCH, cpu_threads,
        path_kernel, side, usual_lanes,
    },
    stopwatch::{self, Stopwatch},
    upload::Uploader,
};

/// Root module of the kernel for first-hit features.
const FEATURE_KERNEL: &str = "package::kernel::features";

/// Bytes of the record that a dispatch reports with.
const CONTROL_BYTES: u64 = size_of::<Control>() as u64;

/// Rays of a pixel that albedo and normal are averaged over.
const FEATURE_SAMPLES: u32 = 16;

/// A scene on a device, with its compiled kernels.
pub struct Renderer<'a> {
    pub(crate) device: &'a Device,
    /// What the kernel contains.
    pub features: Features,
    /// The WGSL of the path kernel and, where there is one, of the light tracing kernel.
    pub wgsl: String,
    /// Bytes of device memory in use.
    pub device_bytes: u64,
    /// Seconds spent composing, compiling and uploading.
    pub compile_seconds: f64,
    /// Of these, seconds of uploading the scene.
    pub upload_seconds: f64,
    kernel: Kernel,
    feature_kernel: Kernel,
    pub(crate) particles: Option<Particles>,
    view: wgpu::Buffer,
    pass_buffer: wgpu::Buffer,
    control: wgpu::Buffer,
    control_readback: wgpu::Buffer,
    stopwatch: Option<Stopwatch>,
    sums: wgpu::Buffer,
    feature_pixels: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Pixels of the whole picture.
    pub(crate) size: [u32; 2],
    pub(crate) threads: u32,
    most_lanes: u32,
    budget: u32,
    dispatch: [Duration; 2],
    walks: u32,
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
        let blueprint = prepared.blueprint().on(device);
        let features = blueprint.features;
        let side = side(&features);
        let (shader, program) = match ahead.filter(|ahead| ahead.is_of(device, &blueprint)) {
            Some(ahead) => (ahead.shader, ahead.program),
            None => {
                let shader = compose(path_kernel(&features).0, &features, &blueprint.constants)?;
                let program = Program::new(device, &shader, PATH_ENTRY, checks)?;
                (shader, program)
            }
        };
        let feature_shader =
            compose(FEATURE_KERNEL, &Features { shared_paths: false, ..features }, &blueprint.constants)?;

        let mut up = Uploader::new(device);
        let uploading = Instant::now();
        let mut resources = scene_resources(&mut up, prepared, &features, &shader)?;
        let upload_seconds = uploading.elapsed().as_secs_f64();
        let [width, height] = prepared.view.size;
        let threads = if device.info.is_cpu { cpu_threads() } else { 1 };
        let state_bytes = RecordLayout::of(&shader, path_kernel(&features).1).map_or(256, |l| l.span);
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
        let view = up.buffer("the view", &[prepared.view], U::UNIFORM | U::COPY_DST)?;
        let pass_buffer = up.buffer("the pass", &[Pass::default()], U::UNIFORM | U::COPY_DST)?;
        let control = up.buffer("the control record", &[Control::default()], storage)?;
        let control_readback =
            up.zeros("the control record's copy", CONTROL_BYTES + stopwatch::BYTES, U::MAP_READ | U::COPY_DST)?;
        let states = up.zeros("path states", lanes * u64::from(state_bytes), U::STORAGE)?;
        let sum_bytes = pixels * 16 * u64::from(most_batches);
        let sums = up.zeros("batch sums", sum_bytes, storage)?;
        let feature_pixels = up.zeros("first-hit features", feature_bytes, storage)?;
        let readback = up.zeros("the copy of batch sums", sum_bytes.max(feature_bytes), U::MAP_READ | U::COPY_DST)?;
        for (name, buffer) in [
            ("view", &view),
            ("pass_info", &pass_buffer),
            ("control", &control),
            ("states", &states),
            ("batch_sums", &sums),
            ("feature_pixels", &feature_pixels),
        ] {
            resources.insert(name.into(), Resource::Buffer(buffer.clone()));
        }
        let kernel = program.bind(device, &resources)?;
        let feature_kernel = Kernel::new(device, &feature_shader, "trace_features", checks, &resources)?;
        let particles = Particles::new(device, &mut up, prepared, &features, &mut resources, threads, checks)?;
        let (particles, emit_wgsl) = particles.unzip();
        let mut renderer = Self {
            device,
            features,
            wgsl: shader.wgsl + &emit_wgsl.unwrap_or_default(),
            device_bytes: up.bytes,
            compile_seconds: 0.0,
            upload_seconds,
            kernel,
            feature_kernel,
            particles,
            view,
            pass_buffer,
            control,
            control_readback,
            stopwatch: Stopwatch::new(device)?,
            sums,
            feature_pixels,
            readback,
            size: [width, height],
            threads,
            most_lanes,
            budget: 512,
            // Nobody kills a CPU driver's dispatches; interrupts wait for them.
            dispatch: [SHORTEST_DISPATCH, if device.info.is_cpu { 4 * LONGEST_DISPATCH } else { LONGEST_DISPATCH }],
            walks: 1,
            most_batches,
            counts: Counts::default(),
        };
        renderer.warm_up(&tiles[0])?;
        renderer.warm_up_particles()?;
        renderer.compile_seconds = started.elapsed().as_secs_f64();
        Ok(renderer)
    }

    /// Drivers compile at the first dispatch: one that has nothing to do.
    fn warm_up(&mut self, tile: &Tile) -> Result<(), RenderError> {
        let pass = Pass { size: tile.size, samples: 1, lanes: GROUP * self.threads, restart: 1, ..self.pass_of(tile) };
        self.dispatch(&pass)?;
        Ok(())
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
    pub fn set_seed(&self, seed: u32) {
        let offset = std::mem::offset_of!(View, seed) as u64;
        self.device.queue.write_buffer(&self.view, offset, bytemuck::bytes_of(&seed));
    }

    /// Walks every ray so many times from here on, if the kernel was made with the feature `repeat_walk`. The picture stays the same, so that what it
    /// costs more is the walk's.
    pub fn set_walks(&mut self, walks: u32) {
        self.walks = walks.max(1);
    }

    /// How long a dispatch should last, at least and at most, as far as the work left and the limit on a lane's iterations let it. Pictures stay the
    /// same; it is for measurements.
    pub fn set_dispatch(&mut self, least: Duration, most: Duration) {
        self.dispatch = [least, most];
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
    /// so nothing at all is added.
    pub fn trace(
        &mut self,
        film: &mut Film,
        first_batch: u32,
        batches: u32,
        samples: u32,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        let mut results = Vec::new();
        for tile in self.tiles_of(film, side(&self.features))? {
            let pass = Pass { first_batch, batches, samples, ..self.pass_of(&tile) };
            if !self.trace_tile(&pass, observer)? {
                return Ok(false);
            }
            let started = Instant::now();
            results.push((tile, self.read_sums(&pass)?));
            self.counts.read_seconds += started.elapsed().as_secs_f64();
        }
        if !self.trace_particles(&mut results, first_batch, batches, samples, observer)? {
            return Ok(false);
        }
        let started = Instant::now();
        for (tile, sums) in results {
            let lanes = tile.lanes(self.threads);
            let pixels = tile.pixels(lanes, &film.window());
            for batch in sums.chunks_exact(pixels.len()) {
                if pixels.iter().zip(batch).any(|(&p, s)| p != u32::MAX && !s.is_written()) {
                    return Err(RenderError::LostWork { message: "some pixels lack samples after a pass".into() });
                }
                film.add_batch(samples, &pixels, batch)
                    .map_err(|e| RenderError::LostWork { message: format!("a batch does not fit the film: {e}") })?;
            }
        }
        self.counts.film_seconds += started.elapsed().as_secs_f64();
        Ok(true)
    }

    /// The film's part of the picture, cut into tiles that the buffers hold.
    fn tiles_of(&self, film: &Film, side: u32) -> Result<Vec<Tile>, RenderError> {
        let window = film.window();
        if window.whole != self.size {
            let [[width, height], [w, h]] = [self.size, window.whole];
            let message = format!("the film is of an image of {w}x{h} pixels, the view of one of {width}x{height}");
            return Err(RenderError::LostWork { message });
        }
        Ok(Tile::bands(window.corner, window.size, self.most_lanes, side))
    }

    /// Dispatches until every lane of the tile has its samples.
    fn trace_tile(&mut self, pass: &Pass, observer: &mut Observer<'_>) -> Result<bool, RenderError> {
        self.clear_sums(pass)?;
        let mut restart = 1;
        loop {
            let started = Instant::now();
            let budget = self.budget;
            let (report, on_device) = self.dispatch(&Pass { budget, restart, ..*pass })?;
            let seconds = started.elapsed();
            self.counts.device_seconds += on_device.unwrap_or(seconds.as_secs_f64());
            self.counts.trace_seconds += seconds.as_secs_f64();
            self.counts.dispatches += 1;
            self.counts.rays += u64::from(report.rays);
            self.counts.paths += u64::from(report.paths);
            self.counts.dropped += u64::from(report.dropped);
            self.counts.truncated += u64::from(report.truncated);
            restart = 0;
            let [shortest, longest] = self.dispatch;
            if seconds < shortest && report.unfinished > 0 {
                self.budget = (2 * budget).min(MOST_BUDGET);
            } else if seconds > longest {
                self.budget = (budget / 2).max(LEAST_BUDGET);
            }
            if !observer(&self.counts) {
                return Ok(false);
            }
            if report.unfinished == 0 {
                return Ok(true);
            }
        }
    }

    /// One dispatch, and its seconds by the device's clock; afterwards every workgroup must have reported.
    fn dispatch(&self, pass: &Pass) -> Result<(Control, Option<f64>), RenderError> {
        self.run_pass(pass, &self.kernel)
    }

    fn run_pass(&self, pass: &Pass, kernel: &Kernel) -> Result<(Control, Option<f64>), RenderError> {
        self.run(kernel, pass.lanes / GROUP, &self.pass_buffer, bytemuck::bytes_of(pass))
    }

    /// Likewise of any kernel, whose pass is to be written to a buffer.
    pub(crate) fn run(
        &self,
        kernel: &Kernel,
        workgroups: u32,
        pass_buffer: &wgpu::Buffer,
        pass: &[u8],
    ) -> Result<(Control, Option<f64>), RenderError> {
        let device = self.device;
        let watch = self.stopwatch.as_ref();
        device.scoped("a dispatch", || {
            device.queue.write_buffer(pass_buffer, 0, pass);
            device.queue.write_buffer(&self.control, 0, bytemuck::bytes_of(&Control::default()));
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            kernel.record(&mut encoder, workgroups, watch.map(Stopwatch::around));
            encoder.copy_buffer_to_buffer(&self.control, 0, &self.control_readback, 0, CONTROL_BYTES);
            if let Some(watch) = watch {
                watch.record(&mut encoder, &self.control_readback, CONTROL_BYTES);
            }
            device.queue.submit([encoder.finish()]);
        })?;
        let size = CONTROL_BYTES + watch.map_or(0, |_| stopwatch::BYTES);
        let (report, timestamps) = device.read(&self.control_readback, size, |bytes| {
            let (control, timestamps) = bytes.split_at(size_of::<Control>());
            let timestamps = (!timestamps.is_empty()).then(|| bytemuck::pod_read_unaligned::<[u64; 2]>(timestamps));
            (bytemuck::pod_read_unaligned::<Control>(control), timestamps)
        })?;
        if report.workgroups != workgroups {
            let message = format!("{} of {workgroups} workgroups reported back", report.workgroups);
            return Err(RenderError::LostWork { message });
        }
        Ok((report, watch.zip(timestamps).and_then(|(watch, ends)| watch.seconds(ends))))
    }

    /// Bytes of a pass's batch sums.
    fn sum_bytes(&self, pass: &Pass) -> u64 {
        16 * u64::from(pass.batches) * u64::from(pass.lanes) * u64::from(side(&self.features).pow(2))
    }

    /// Wipes what an earlier tile left, so that a batch that is not written shows.
    fn clear_sums(&self, pass: &Pass) -> Result<(), RenderError> {
        let device = self.device;
        device.scoped("clearing batch sums", || {
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&self.sums, 0, Some(self.sum_bytes(pass)));
            device.queue.submit([encoder.finish()]);
        })
    }

    /// The tile's sums, batch after batch, lane after lane.
    fn read_sums(&self, pass: &Pass) -> Result<Vec<BatchSum>, RenderError> {
        self.read(&self.sums, self.sum_bytes(pass))
    }

    fn read<T: bytemuck::AnyBitPattern + bytemuck::NoUninit>(
        &self,
        from: &wgpu::Buffer,
        size: u64,
    ) -> Result<Vec<T>, RenderError> {
        let device = self.device;
        device.scoped("a copy", || {
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(from, 0, &self.readback, 0, size);
            device.queue.submit([encoder.finish()]);
        })?;
        device.read(&self.readback, size, |bytes| bytemuck::pod_collect_to_vec(bytes))
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
                self.counts.truncated += u64::from(self.run_pass(&ray, &self.feature_kernel)?.0.truncated);
            }
            let records: Vec<FeaturePixel> =
                self.read(&self.feature_pixels, u64::from(pass.lanes) * size_of::<FeaturePixel>() as u64)?;
            for (pixel, r) in tile.pixels(pass.lanes, &window).into_iter().zip(records) {
                if pixel != u32::MAX {
                    let i = pixel as usize;
                    all.albedo[i] = r.albedo.map(|sum| sum / FEATURE_SAMPLES as f32);
                    all.depth[i] = r.depth;
                    all.normal[i] = r.normal.map(|sum| sum / FEATURE_SAMPLES as f32);
                }
            }
        }
        film.set_features(all).map_err(|e| RenderError::LostWork { message: e.to_string() })
    }
}
