//! Particles from the lights: runs the light tracing kernel over a batch and brings what they left in pixels to the batch's sums.
//!
//! A batch sends out a particle for every few samples of all pixels of the whole image, whatever part of it is traced: they are
//! numbered by the image, and what lands outside of the part is dropped. Sums are of integers, so that neither the order of particles nor
//! crops, tiles and interruptions change a bit.

use std::time::Instant;

use bytemuck::{Pod, Zeroable};
use surelight_film::BatchSum;

use surelight_prepare::{KernelKey, Prepared, RecordLayout, compose};

use crate::{
    adaptive::Shares,
    device::Device,
    dispatch::{Dispatcher, LONGEST, Sliced},
    error::RenderError,
    kernel::{Checks, Kernel, Resource, Resources},
    pass::{EmissionPass, GROUP, Run, Tile},
    schedule::{Counts, Observer},
    upload::{MIB, Uploader},
};

/// Root module of the light tracing kernel.
pub(crate) const EMIT_KERNEL: &str = "package::kernel::light_tracing";

/// Particles of one sequence, at most about: they are numbered by 32 bits.
const SEQUENCE: u64 = 1 << 31;

/// Particles traced at once by a GPU.
const GPU_LANES: u32 = 1 << 18;
/// By each thread of a CPU driver.
const CPU_LANES_A_THREAD: u32 = 1 << 9;

/// Units of the sums that a particle of the usual flux brings to a pixel, and the root of those of squares.
const UNITS: f64 = (1u32 << 20) as f64;
const ROOT_UNITS: f64 = (1u32 << 12) as f64;

/// Bytes read at once.
const READ_BYTES: u64 = 1 << 24;

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
    sliced: Sliced,
    splats: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Pixels that `splats` has room for.
    room: u64,
    lanes: u32,
    threads: u32,
    /// Pixels of the whole picture.
    size: [u32; 2],
    one_scramble: bool,
    /// What a particle of the usual flux brings to a pixel.
    usual: f64,
    /// Of every so many samples of a pixel one sends out a particle.
    samples_per_particle: u64,
}

impl Particles {
    /// `None` where no light is traced from the lights. Also gives the kernel's WGSL.
    pub(crate) fn new(
        device: &Device,
        up: &mut Uploader<'_>,
        prepared: &Prepared,
        key: &KernelKey,
        resources: &mut Resources,
        threads: u32,
        checks: Checks,
    ) -> Result<Option<(Self, String)>, RenderError> {
        use wgpu::BufferUsages as U;
        let Some(tracing) = prepared.light_tracing() else { return Ok(None) };
        let shader = compose(EMIT_KERNEL, key, &prepared.constants())?;
        let [width, height] = prepared.view().size.map(u64::from);
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
        let particles = Self {
            sliced: Sliced::new(kernel, pass, |counts| &mut counts.particles, LONGEST),
            splats,
            readback,
            room,
            lanes,
            threads,
            size: prepared.view().size,
            one_scramble: key.is_one_sequence(),
            usual: tracing.usual,
            samples_per_particle: tracing.samples_per_particle.into(),
        };
        Ok(Some((particles, shader.wgsl)))
    }

    /// What a unit of the sums stands for, and of the sums of squares.
    fn units(&self) -> [f64; 2] {
        [self.usual / UNITS, (self.usual / ROOT_UNITS).powi(2)]
    }

    /// A batch's pass over some of one sequence's particles.
    fn pass_of(&self, tile: &Tile) -> EmissionPass {
        EmissionPass {
            corner: tile.corner,
            size: tile.size,
            lanes: self.lanes,
            worth: (1.0 / self.a_sample() as f64) as f32,
            quantum: (UNITS / self.usual) as f32,
            square_quantum: (ROOT_UNITS / self.usual) as f32,
            ..EmissionPass::default()
        }
    }

    /// Particles that one sample of every pixel sends out.
    fn a_sample(&self) -> u64 {
        (u64::from(self.size[0]) * u64::from(self.size[1])).div_ceil(self.samples_per_particle)
    }

    /// Has the driver compile.
    pub(crate) fn warm_up(&self, dispatcher: &Dispatcher<'_>) -> Result<(), RenderError> {
        let lanes = GROUP * self.threads;
        let pass = EmissionPass { size: [1, 1], lanes, restart: 1, ..EmissionPass::default() };
        self.sliced.warm_up(dispatcher, lanes / GROUP, &pass)
    }

    /// Sends out the particles of a run, and adds what they leave to the sums of tiles, which hold batch after batch. Returns false when
    /// the observer stopped it.
    pub(crate) fn trace(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        run: Run,
        shares: Option<&Shares>,
        results: &mut [(Tile, Vec<BatchSum>)],
        counts: &mut Counts,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        // Tiles are bands of one width, from the top: as many of them at once as there is room for.
        let mut rest = results;
        while let Some((first, _)) = rest.first() {
            let (corner, width) = (first.corner, first.size[0]);
            let mut rows = 0;
            let fits = |(tile, _): &&(Tile, Vec<BatchSum>)| {
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
            let height = now.iter().map(|(tile, _)| tile.size[1]).sum();
            let band = Tile { corner, size: [width, height], side: 1 };
            for k in 0..run.batches {
                if !self.trace_batch(dispatcher, &band, run, k, counts, observer)? {
                    return Ok(false);
                }
                let began = Instant::now();
                let splats = self.read_splats(dispatcher.device, band.size)?;
                counts.read_seconds += began.elapsed().as_secs_f64();
                for (tile, sums) in now.iter_mut() {
                    let share = |pixel: [u32; 2]| {
                        shares.map_or(1.0, |s| f64::from(s.samples(pixel, run.samples)) / f64::from(run.samples))
                    };
                    self.add_splats(&band, &splats, share, tile, sums, k as usize)?;
                }
            }
        }
        Ok(true)
    }

    /// The particles of one batch, the `k`th of a run.
    fn trace_batch(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        band: &Tile,
        run: Run,
        k: u32,
        counts: &mut Counts,
        observer: &mut Observer<'_>,
    ) -> Result<bool, RenderError> {
        dispatcher.device.clear(&self.splats, None)?;
        let Run { first_batch, samples, .. } = run;
        let (replicate, first_sample) =
            if self.one_scramble { (0, first_batch + k * samples) } else { (first_batch + k, 0) };
        let a_sample = self.a_sample();
        // Samples of a pixel in one sequence.
        let each = (SEQUENCE / a_sample).clamp(1, u64::from(u32::MAX)) as u32;
        let length = (u64::from(samples.min(each)) * a_sample).min(u64::from(u32::MAX)) as u32;
        let batch = EmissionPass { replicate, length, ..self.pass_of(band) };
        let mut sample = first_sample;
        let end = first_sample + samples;
        while sample < end {
            let (sequence, at) = (sample / each, sample % each);
            let these = (each - at).min(end - sample);
            let count = (u64::from(these) * a_sample) as u32;
            let first = (u64::from(at) * a_sample) as u32;
            let slice = |budget, restart| EmissionPass { sequence, first, count, budget, restart, ..batch };
            match self.sliced.run(dispatcher, self.lanes / GROUP, slice, counts, observer)? {
                None => return Ok(false),
                Some(done) if done != u64::from(count) => {
                    let message = format!("{done} of {count} particles came to their end");
                    return Err(RenderError::LostWork { message });
                }
                Some(_) => sample += these,
            }
        }
        Ok(true)
    }

    /// What the last batch left in a band's pixels, row after row.
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

    /// Adds what a batch's particles left to the sums that a tile's paths have brought.
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
        let of_band = surelight_film::Window { whole: self.size, corner: band.corner, size: band.size };
        let batch = sums.iter_mut().skip(batch * lanes as usize);
        for (sum, pixel) in batch.zip(tile.pixels(lanes, &of_band)) {
            let Some(splat) = splats.get(pixel as usize) else { continue };
            if !sum.is_written() {
                return Err(RenderError::LostWork { message: "some pixels lack samples after a pass".into() });
            }
            let [red, green, blue, squares] = splat.sums;
            let squares = if squares[1] == u32::MAX { f64::INFINITY } else { wide(squares) * square_unit };
            // A pixel of more samples than others has a larger sum, of which particles are the same part.
            let share = share([band.corner[0] + pixel % band.size[0], band.corner[1] + pixel / band.size[0]]);
            let largest = (share * f64::from(f32::from_bits(splat.largest))) as f32;
            let splat = [red, green, blue].map(|c| share * wide(c) * unit);
            *sum = sum.with_particles(splat, largest, share * share * squares);
        }
        Ok(())
    }
}
