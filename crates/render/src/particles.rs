//! Particles from the lights: runs the light tracing kernel over a batch and brings what they left in pixels to the batch's sums.
//!
//! A batch sends out a particle for every four samples of all pixels of the whole image, whatever part of it is traced: they are
//! numbered by the image, and what lands outside of the part is dropped. Sums are of integers, so that neither the order of particles nor
//! crops, tiles and interruptions change a bit.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use surelight_film::BatchSum;

use crate::{
    compose::compose,
    device::Device,
    error::RenderError,
    features::Features,
    kernel::{Checks, Kernel, Resource, Resources},
    pass::{GROUP, Tile},
    prepare::Prepared,
    reflect::RecordLayout,
    renderer::Renderer,
    schedule::{LEAST_BUDGET, LONGEST_DISPATCH, MOST_BUDGET, Observer, SHORTEST_DISPATCH},
    upload::Uploader,
};

/// Root module of the light tracing kernel.
pub(crate) const EMIT_KERNEL: &str = "package::kernel::emit";

/// Particles of one sequence, at most about: they are numbered by 32 bits.
const SEQUENCE: u64 = 1 << 31;

/// Particles traced at once by a GPU.
const GPU_LANES: u32 = 1 << 18;
/// By each thread of a CPU driver.
const CPU_LANES_A_THREAD: u32 = 1 << 9;

/// Of every so many samples of a pixel one sends out a particle.
const SAMPLES_A_PARTICLE: u64 = 4;

/// Units of the sums that a particle of the usual flux brings to a pixel, and the root of those of squares.
const UNITS: f64 = (1u32 << 20) as f64;
const ROOT_UNITS: f64 = (1u32 << 12) as f64;

/// Bytes read at once.
const READ_BYTES: u64 = 1 << 24;

/// Twin of `EmissionPass` in `shaders/kernel/emit.wesl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(crate) struct EmissionPass {
    pub(crate) corner: [u32; 2],
    pub(crate) size: [u32; 2],
    pub(crate) replicate: u32,
    pub(crate) sequence: u32,
    pub(crate) first: u32,
    pub(crate) count: u32,
    pub(crate) length: u32,
    pub(crate) budget: u32,
    pub(crate) lanes: u32,
    pub(crate) restart: u32,
    pub(crate) worth: f32,
    pub(crate) quantum: f32,
    pub(crate) square_quantum: f32,
    pub(crate) unused: u32,
}

/// What a batch's particles left in a pixel. The kernel's is an array of words in this order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Splat {
    /// Red, green, blue and squared luminances in fixed point, the lower word first.
    sums: [[u32; 2]; 4],
    /// Bits of an f32.
    largest: u32,
}

const SPLAT_BYTES: u64 = size_of::<Splat>() as u64;

/// The light tracing kernel with its buffers.
pub(crate) struct Particles {
    kernel: Kernel,
    pass: wgpu::Buffer,
    splats: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Pixels that `splats` has room for.
    room: u64,
    lanes: u32,
    budget: u32,
    /// What a particle of the usual flux brings to a pixel.
    usual: f64,
}

impl Particles {
    /// `None` where no light is traced from the lights. Also gives the kernel's WGSL.
    pub(crate) fn new(
        device: &Device,
        up: &mut Uploader<'_>,
        prepared: &Prepared,
        features: &Features,
        resources: &mut Resources,
        threads: u32,
        checks: Checks,
    ) -> Result<Option<(Self, String)>, RenderError> {
        use wgpu::BufferUsages as U;
        let Some(caustics) = &prepared.caustics else { return Ok(None) };
        let shader = compose(EMIT_KERNEL, features, &prepared.constants())?;
        let [width, height] = prepared.view.size.map(u64::from);
        let room = (width * height).min(device.info.max_binding / SPLAT_BYTES).max(1);
        let wanted = if device.info.is_cpu { CPU_LANES_A_THREAD.saturating_mul(threads) } else { GPU_LANES };
        let lanes = wanted.next_multiple_of(GROUP * threads);
        let particle_bytes = RecordLayout::of(&shader, "Particle").map_or(256, |l| l.span);
        let pass = up.buffer("the pass of particles", &[EmissionPass::default()], U::UNIFORM | U::COPY_DST)?;
        let particles = up.zeros("particles", u64::from(lanes) * u64::from(particle_bytes), U::STORAGE)?;
        let splats = up.zeros("particles' sums", room * SPLAT_BYTES, U::STORAGE | U::COPY_SRC | U::COPY_DST)?;
        let read_bytes = (room * SPLAT_BYTES).min(READ_BYTES);
        let readback = up.zeros("the copy of particles' sums", read_bytes, U::MAP_READ | U::COPY_DST)?;
        for (name, buffer) in [("emission_pass", &pass), ("particles", &particles), ("splats", &splats)] {
            resources.insert(name.into(), Resource::Buffer(buffer.clone()));
        }
        let kernel = Kernel::new(device, &shader, "trace_particles", checks, resources)?;
        let particles = Self { kernel, pass, splats, readback, room, lanes, budget: 512, usual: caustics.usual };
        Ok(Some((particles, shader.wgsl)))
    }

    /// What a unit of the sums stands for, and of the sums of squares.
    fn units(&self) -> [f64; 2] {
        [self.usual / UNITS, (self.usual / ROOT_UNITS).powi(2)]
    }

    /// A batch's pass over some of one sequence's particles.
    fn pass_of(&self, tile: &Tile, image: [u32; 2]) -> EmissionPass {
        EmissionPass {
            corner: tile.corner,
            size: tile.size,
            lanes: self.lanes,
            worth: (1.0 / particles_a_sample(image) as f64) as f32,
            quantum: (UNITS / self.usual) as f32,
            square_quantum: (ROOT_UNITS / self.usual) as f32,
            ..EmissionPass::default()
        }
    }
}

/// Particles that one sample of every pixel sends out.
fn particles_a_sample(image: [u32; 2]) -> u64 {
    (u64::from(image[0]) * u64::from(image[1])).div_ceil(SAMPLES_A_PARTICLE)
}

impl Renderer<'_> {
    /// Drivers compile at the first dispatch: one that has nothing to do.
    pub(crate) fn warm_up_particles(&self) -> Result<(), RenderError> {
        let Some(particles) = &self.particles else { return Ok(()) };
        let lanes = GROUP * self.threads;
        let pass = EmissionPass { size: [1, 1], lanes, restart: 1, ..EmissionPass::default() };
        self.run(&particles.kernel, lanes / GROUP, &particles.pass, bytemuck::bytes_of(&pass))?;
        Ok(())
    }

    /// Sends out the particles of `batches` batches, numbered and counted as in [`Renderer::trace`], and adds what they leave to the
    /// sums of tiles, which hold batch after batch. Returns false when the observer stopped it.
    pub(crate) fn trace_particles(
        &mut self,
        results: &mut [(Tile, Vec<BatchSum>)],
        first_batch: u32,
        batches: u32,
        samples: u32,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        let Some(room) = self.particles.as_ref().map(|p| p.room) else { return Ok(true) };
        // Tiles are bands of one width, from the top: as many of them at once as there is room for.
        let mut rest = results;
        while let Some((first, _)) = rest.first() {
            let (corner, width) = (first.corner, first.size[0]);
            let mut rows = 0;
            let fits = |(tile, _): &&(Tile, Vec<BatchSum>)| {
                rows += u64::from(tile.size[1]);
                (tile.corner[0], tile.size[0]) == (corner[0], width) && u64::from(width) * rows <= room
            };
            let count = rest.iter().take_while(fits).count();
            if count == 0 {
                let message = format!("there is no room for what particles leave in {width} pixels a row");
                return Err(RenderError::LostWork { message });
            }
            let (now, later) = rest.split_at_mut(count);
            rest = later;
            let height = now.iter().map(|(tile, _)| tile.size[1]).sum();
            let band = Tile { corner, size: [width, height], side: 1 };
            for k in 0..batches {
                let (replicate, sample) =
                    if self.features.one_scramble { (0, first_batch + k * samples) } else { (first_batch + k, 0) };
                if !self.trace_batch(&band, replicate, sample, samples, observer)? {
                    return Ok(false);
                }
                let began = Instant::now();
                let splats = self.read_splats(band.size)?;
                self.counts.read_seconds += began.elapsed().as_secs_f64();
                for (tile, sums) in now.iter_mut() {
                    self.add_splats(&band, &splats, tile, sums, k as usize)?;
                }
            }
        }
        Ok(true)
    }

    /// The particles of one batch.
    fn trace_batch(
        &mut self,
        band: &Tile,
        replicate: u32,
        first_sample: u32,
        samples: u32,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        let Some(particles) = &self.particles else { return Ok(true) };
        let device = self.device;
        device.scoped("clearing particles' sums", || {
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(&particles.splats, 0, None);
            device.queue.submit([encoder.finish()]);
        })?;
        let a_sample = particles_a_sample(self.size);
        // Samples of a pixel in one sequence.
        let each = (SEQUENCE / a_sample).clamp(1, u64::from(u32::MAX)) as u32;
        let length = (u64::from(samples.min(each)) * a_sample).min(u64::from(u32::MAX)) as u32;
        let pass = EmissionPass { replicate, length, ..particles.pass_of(band, self.size) };
        let mut sample = first_sample;
        let end = first_sample + samples;
        while sample < end {
            let (sequence, at) = (sample / each, sample % each);
            let run = (each - at).min(end - sample);
            let count = (u64::from(run) * a_sample) as u32;
            let first = (u64::from(at) * a_sample) as u32;
            if !self.trace_run(&EmissionPass { sequence, first, count, ..pass }, observer)? {
                return Ok(false);
            }
            sample += run;
        }
        Ok(true)
    }

    /// Dispatches until all particles of a pass have come to their end.
    fn trace_run(&mut self, pass: &EmissionPass, observer: &mut Observer<'_>) -> Result<bool, RenderError> {
        let (mut restart, mut done) = (1, 0);
        loop {
            let Some(particles) = &self.particles else { return Ok(true) };
            let started = Instant::now();
            let budget = particles.budget;
            let now = EmissionPass { budget, restart, ..*pass };
            let (report, on_device) =
                self.run(&particles.kernel, particles.lanes / GROUP, &particles.pass, bytemuck::bytes_of(&now))?;
            let seconds = started.elapsed();
            self.counts.device_seconds += on_device.unwrap_or(seconds.as_secs_f64());
            self.counts.trace_seconds += seconds.as_secs_f64();
            self.counts.dispatches += 1;
            self.counts.rays += u64::from(report.rays);
            self.counts.particles += u64::from(report.paths);
            self.counts.dropped += u64::from(report.dropped);
            self.counts.truncated += u64::from(report.truncated);
            restart = 0;
            done += u64::from(report.paths);
            if let Some(particles) = &mut self.particles {
                if seconds < SHORTEST_DISPATCH && report.unfinished > 0 {
                    particles.budget = (2 * budget).min(MOST_BUDGET);
                } else if seconds > LONGEST_DISPATCH {
                    particles.budget = (budget / 2).max(LEAST_BUDGET);
                }
            }
            if !observer(&self.counts) {
                return Ok(false);
            }
            if report.unfinished == 0 {
                break;
            }
        }
        if done != u64::from(pass.count) {
            let message = format!("{done} of {} particles came to their end", pass.count);
            return Err(RenderError::LostWork { message });
        }
        Ok(true)
    }

    /// What the last batch left in a band's pixels, row after row.
    fn read_splats(&self, size: [u32; 2]) -> Result<Vec<Splat>, RenderError> {
        let Some(particles) = &self.particles else { return Ok(Vec::new()) };
        let device = self.device;
        let end = u64::from(size[0]) * u64::from(size[1]) * SPLAT_BYTES;
        let step = particles.readback.size() / SPLAT_BYTES * SPLAT_BYTES;
        let mut splats = Vec::new();
        let mut at = 0;
        while at < end {
            let bytes = step.min(end - at);
            device.scoped("a copy", || {
                let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                encoder.copy_buffer_to_buffer(&particles.splats, at, &particles.readback, 0, bytes);
                device.queue.submit([encoder.finish()]);
            })?;
            let read: Vec<Splat> = device.read(&particles.readback, bytes, bytemuck::pod_collect_to_vec)?;
            splats.extend(read);
            at += bytes;
        }
        Ok(splats)
    }

    /// Adds what a batch's particles left to the sums that a tile's paths have brought.
    fn add_splats(
        &self,
        band: &Tile,
        splats: &[Splat],
        tile: &Tile,
        sums: &mut [BatchSum],
        batch: usize,
    ) -> Result<(), RenderError> {
        let Some(particles) = &self.particles else { return Ok(()) };
        let lanes = tile.lanes(self.threads);
        let [unit, square_unit] = particles.units();
        let wide = |[low, high]: [u32; 2]| f64::from(high) * 4_294_967_296.0 + f64::from(low);
        let of_band = surelight_film::Window { whole: self.size, corner: band.corner, size: band.size };
        let batch = sums.iter_mut().skip(batch * lanes as usize);
        for (sum, pixel) in batch.zip(tile.pixels(lanes, &of_band)) {
            let Some(splat) = splats.get(pixel as usize) else { continue };
            if !sum.is_written() {
                return Err(RenderError::LostWork { message: "some pixels lack samples after a pass".into() });
            }
            let [red, green, blue, squares] = splat.sums;
            let squares = if squares[1] == u32::MAX { f64::INFINITY } else { wide(squares) * square_unit };
            *sum =
                sum.with_particles([red, green, blue].map(|c| wide(c) * unit), f32::from_bits(splat.largest), squares);
        }
        Ok(())
    }
}
