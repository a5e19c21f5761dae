//! Particles from the lights: runs the light tracing kernel over a batch and adds the particles'
//! contributions to the batch's sums.
//!
//! A batch emits one particle for every few samples of all pixels of the whole image, regardless of
//! the crop: particles are numbered by the image, and those that land outside of the crop are
//! dropped. Sums are integers, so that the order of particles, crops, tiles and interruptions
//! change no bit.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use surelight_film::{BatchSum, Window};
use surelight_prepare::{KernelKey, LightTracing, RecordLayout};

use crate::{
    accumulator::{TileSums, lost_samples},
    adaptive::Shares,
    counts::Monitor,
    device::Device,
    dispatch::{Dispatcher, MAX_DURATION, Slices},
    error::RenderError,
    kernel::{Kernel, Resource, Resources},
    kernel_set::CompiledShader,
    lanes::driver_threads,
    pass::{BatchRange, EmissionPass, GROUP},
    tile::Tile,
    upload::{MIB, Uploader},
};

/// Approximate maximum number of particles in one sequence: they have 32-bit numbers.
const SEQUENCE: u64 = 1 << 31;

/// Particles in flight on a GPU.
const GPU_LANES: u32 = 1 << 18;
/// Particles in flight per thread of a CPU driver.
const CPU_LANES_PER_THREAD: u32 = 1 << 9;

/// Fixed-point units that a particle of typical flux adds to the sum of a pixel, and the square
/// root of those it adds to the sum of squares.
const UNITS: f64 = (1u32 << 20) as f64;
const ROOT_UNITS: f64 = (1u32 << 12) as f64;

/// Bytes read at once.
const READ_BYTES: u64 = 1 << 24;

/// The contribution of a batch's particles to a pixel. In the kernel it is an array of words in
/// this order.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct Splat {
    /// Red, green, blue and squared luminance in fixed point, the lower word first.
    sums: [[u32; 2]; 4],
    /// Bits of an f32.
    largest: u32,
}

const SPLAT_BYTES: u64 = size_of::<Splat>() as u64;
const _: () = assert!(SPLAT_BYTES == 4 * surelight_prepare::shared::SPLAT_WORDS as u64);

/// The buffers of light tracing, and the scale of its sums.
pub(crate) struct Particles {
    slices: Slices,
    splats: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Pixels that `splats` has room for.
    room: u64,
    lanes: u32,
    threads: u32,
    /// Pixels of the whole image.
    size: [u32; 2],
    one_sequence: bool,
    /// Contribution of a particle of typical flux to a pixel.
    usual_contribution: f64,
    /// Camera samples, over all pixels, per emitted particle.
    samples_per_particle: u64,
}

impl Particles {
    /// Makes the buffers for an image of `size` pixels, and adds them to the resources.
    pub(crate) fn new(
        device: &Device,
        up: &mut Uploader<'_>,
        resources: &mut Resources,
        key: &KernelKey,
        compiled: &CompiledShader,
        tracing: &LightTracing,
        size: [u32; 2],
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        let [width, height] = size.map(u64::from);
        let room = (width * height).min(device.info.max_binding / SPLAT_BYTES).max(1);
        let threads = driver_threads(device);
        let lanes = if device.info.is_cpu { CPU_LANES_PER_THREAD.saturating_mul(threads) } else { GPU_LANES };
        let lanes = lanes.next_multiple_of(GROUP * threads);
        let particle_bytes = RecordLayout::of(&compiled.shader, "Particle").map_or(256, |l| l.span);
        let pass = up.buffer("the pass of particles", &[EmissionPass::default()], U::UNIFORM | U::COPY_DST)?;
        let particles = up.zeros("particles", u64::from(lanes) * u64::from(particle_bytes), U::STORAGE)?;
        let splats = up.zeros("particles' sums", room * SPLAT_BYTES, U::STORAGE | U::COPY_SRC | U::COPY_DST)?;
        let read_bytes = (room * SPLAT_BYTES).min(READ_BYTES);
        let readback = up.zeros("the copy of particles' sums", read_bytes, U::MAP_READ | U::COPY_DST)?;
        for (name, buffer) in [("emission_pass", &pass), ("particles", &particles), ("splats", &splats)] {
            resources.insert(name.into(), Resource::Buffer(buffer.clone()));
        }
        Ok(Self {
            slices: Slices::new(pass, |counts| &mut counts.particles, MAX_DURATION),
            splats,
            readback,
            room,
            lanes,
            threads,
            size,
            one_sequence: key.is_one_sequence(),
            usual_contribution: tracing.usual,
            samples_per_particle: tracing.samples_per_particle.into(),
        })
    }

    /// The value of one unit of the sums, and of the sums of squares.
    fn units(&self) -> [f64; 2] {
        [self.usual_contribution / UNITS, (self.usual_contribution / ROOT_UNITS).powi(2)]
    }

    /// A batch's pass over some of one sequence's particles.
    fn pass_of(&self, tile: &Tile) -> EmissionPass {
        EmissionPass {
            corner: tile.corner,
            size: tile.size,
            lanes: self.lanes,
            particle_weight: (1.0 / self.per_sample() as f64) as f32,
            quantum: (UNITS / self.usual_contribution) as f32,
            square_quantum: (ROOT_UNITS / self.usual_contribution) as f32,
            ..EmissionPass::default()
        }
    }

    /// Particles emitted for one sample of every pixel.
    fn per_sample(&self) -> u64 {
        (u64::from(self.size[0]) * u64::from(self.size[1])).div_ceil(self.samples_per_particle)
    }

    /// Makes the driver compile the kernel.
    pub(crate) fn warm_up(&self, dispatcher: &Dispatcher<'_>, kernel: &Kernel) -> Result<(), RenderError> {
        let lanes = GROUP * self.threads;
        let pass = EmissionPass { size: [1, 1], lanes, restart: 1, ..EmissionPass::default() };
        self.slices.warm_up(dispatcher, kernel, lanes / GROUP, &pass)
    }

    /// Traces the particles of some batches and adds their contributions to the sums of tiles.
    /// Returns false when the observer stopped it.
    pub(crate) fn trace(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        range: BatchRange,
        shares: Option<&Shares>,
        traced: &mut [TileSums],
        monitor: &mut Monitor<'_, '_>,
    ) -> Result<bool, RenderError> {
        // Tiles are bands of equal width, from the top: as many at once as `splats` can hold.
        let mut rest = traced;
        while let Some(TileSums { tile: first, .. }) = rest.first() {
            let (corner, width) = (first.corner, first.size[0]);
            let mut rows = 0;
            let fits = |TileSums { tile, .. }: &&TileSums| {
                rows += u64::from(tile.size[1]);
                (tile.corner[0], tile.size[0]) == (corner[0], width) && u64::from(width) * rows <= self.room
            };
            let count = rest.iter().take_while(fits).count();
            if count == 0 {
                let info = &dispatcher.device.info;
                let pixels = u64::from(width) * u64::from(first.size[1]);
                return Err(RenderError::TooLarge {
                    what: "particles' sums".into(),
                    needed: (pixels * SPLAT_BYTES).div_ceil(MIB),
                    limit: info.max_binding / MIB,
                    limit_name: "max_storage_buffer_binding_size",
                    adapter: info.name.clone(),
                });
            }
            let (now, later) = rest.split_at_mut(count);
            rest = later;
            let height = now.iter().map(|sums| sums.tile.size[1]).sum();
            let band = Tile { corner, size: [width, height], side: 1 };
            for k in 0..range.batches {
                if !self.trace_batch(dispatcher, kernel, &band, range, k, monitor)? {
                    return Ok(false);
                }
                let began = Instant::now();
                let splats = self.read_splats(dispatcher.device, band.size)?;
                monitor.counts.read_seconds += began.elapsed().as_secs_f64();
                for TileSums { tile, sums, .. } in now.iter_mut() {
                    let share = |pixel: [u32; 2]| {
                        shares.map_or(1.0, |s| f64::from(s.samples(pixel, range.samples)) / f64::from(range.samples))
                    };
                    self.add_splats(&band, &splats, share, tile, sums, k as usize)?;
                }
            }
        }
        Ok(true)
    }

    /// Traces the particles of one batch, the `k`th of the range.
    fn trace_batch(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        band: &Tile,
        range: BatchRange,
        k: u32,
        monitor: &mut Monitor<'_, '_>,
    ) -> Result<bool, RenderError> {
        dispatcher.device.clear(&self.splats, None)?;
        let BatchRange { first, samples, .. } = range;
        let (replicate, first_sample) = if self.one_sequence { (0, first + k * samples) } else { (first + k, 0) };
        let per_sample = self.per_sample();
        // Samples of a pixel in one sequence.
        let each = (SEQUENCE / per_sample).clamp(1, u64::from(u32::MAX)) as u32;
        let length = (u64::from(samples.min(each)) * per_sample).min(u64::from(u32::MAX)) as u32;
        let batch = EmissionPass { replicate, length, ..self.pass_of(band) };
        let mut sample = first_sample;
        let end = first_sample + samples;
        while sample < end {
            let (sequence, at) = (sample / each, sample % each);
            let these = (each - at).min(end - sample);
            let count = (u64::from(these) * per_sample) as u32;
            let first = (u64::from(at) * per_sample) as u32;
            let slice = |budget, restart| EmissionPass { sequence, first, count, budget, restart, ..batch };
            match self.slices.run(dispatcher, kernel, self.lanes / GROUP, slice, monitor)? {
                None => return Ok(false),
                Some(done) if done != u64::from(count) => {
                    let message = format!("{done} of {count} particles were traced to their end");
                    return Err(RenderError::LostWork { message });
                }
                Some(_) => sample += these,
            }
        }
        Ok(true)
    }

    /// The contributions of the last batch to a band's pixels, row after row.
    fn read_splats(&self, device: &Device, size: [u32; 2]) -> Result<Vec<Splat>, RenderError> {
        let end = u64::from(size[0]) * u64::from(size[1]) * SPLAT_BYTES;
        let step = self.readback.size() / SPLAT_BYTES * SPLAT_BYTES;
        let mut splats: Vec<Splat> = Vec::new();
        let mut at = 0;
        while at < end {
            let bytes = step.min(end - at);
            splats.extend(device.fetch::<Splat>(&self.splats, at, bytes, &self.readback)?);
            at += bytes;
        }
        Ok(splats)
    }

    /// Adds a batch's particles to the sums of a tile's paths.
    fn add_splats(
        &self,
        band: &Tile,
        splats: &[Splat],
        share: impl Fn([u32; 2]) -> f64,
        tile: &Tile,
        sums: &mut [BatchSum],
        batch: usize,
    ) -> Result<(), RenderError> {
        let lanes = tile.lanes(self.threads);
        let [unit, square_unit] = self.units();
        let wide = |[low, high]: [u32; 2]| f64::from(high) * 4_294_967_296.0 + f64::from(low);
        let of_band = Window { whole: self.size, corner: band.corner, size: band.size };
        let batch = sums.iter_mut().skip(batch * lanes as usize);
        for (sum, pixel) in batch.zip(tile.pixels(lanes, &of_band)) {
            let Some(splat) = splats.get(pixel as usize) else { continue };
            if !sum.is_written() {
                return Err(lost_samples());
            }
            let [red, green, blue, squares] = splat.sums;
            let squares = if squares[1] == u32::MAX { f64::INFINITY } else { wide(squares) * square_unit };
            // A pixel with a larger share of samples has a larger sum; the fraction from particles
            // is the same.
            let share = share([band.corner[0] + pixel % band.size[0], band.corner[1] + pixel / band.size[0]]);
            let largest = (share * f64::from(f32::from_bits(splat.largest))) as f32;
            let splat = [red, green, blue].map(|c| share * wide(c) * unit);
            *sum = sum.with_particles(splat, largest, share * share * squares);
        }
        Ok(())
    }
}
