//! Accumulates samples into batch sums, tile by tile: the buffers of a pass, its dispatches, and
//! the transfer of its sums to the film.

use std::time::{Duration, Instant};

use surelight_film::{BatchSum, Features as FilmFeatures, Film, FilmError};
use surelight_prepare::{KernelKey, Part, RecordLayout, path_kernel};

use crate::{
    adaptive::Shares,
    counts::{Counts, Monitor},
    dispatch::{Dispatcher, MAX_DURATION, Slices},
    error::RenderError,
    kernel::{Kernel, Resource, Resources},
    kernel_set::CompiledShader,
    lanes::{driver_threads, pixels_per_side},
    pass::{BatchRange, FeaturePixel, GROUP, Pass, warm_up},
    tile::Tile,
    upload::Uploader,
};

/// Rays per pixel over which albedo and normal are averaged.
const FEATURE_SAMPLES: u32 = 16;

/// Maximum number of batches in one pass.
const MAX_BATCHES: u64 = 16;

/// The sums of a tile's pixels, batch after batch, in order of its lanes.
pub(crate) struct TileSums {
    pub(crate) tile: Tile,
    pub(crate) sums: Vec<BatchSum>,
    /// Sums of coverage, where it is recorded.
    coverage: Option<Vec<f32>>,
}

/// The state of passes on the device.
pub(crate) struct Accumulator {
    slices: Slices,
    pass_buffer: wgpu::Buffer,
    sums: wgpu::Buffer,
    /// Sums of coverage, 4 bytes for each 16 of `sums`, where coverage is recorded.
    coverage_sums: Option<wgpu::Buffer>,
    feature_pixels: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Pixels of the whole image.
    size: [u32; 2],
    /// Pixels along a side of the square that a lane works on.
    side: u32,
    /// Threads of a CPU driver, among which workgroups are distributed.
    pub(crate) threads: u32,
    /// Maximum number of lanes traced at once.
    pub(crate) max_lanes: u32,
    /// Maximum number of batches in one pass.
    pub(crate) max_batches: u32,
    /// Traversals of each ray: more than 1 to measure the time of traversal.
    pub(crate) traversals_per_ray: u32,
}

impl Accumulator {
    /// Makes the buffers for an image of `size` pixels, with about `lanes` lanes at once, and
    /// adds them to the resources.
    pub(crate) fn new(
        dispatcher: &Dispatcher<'_>,
        up: &mut Uploader<'_>,
        resources: &mut Resources,
        key: &KernelKey,
        paths: &CompiledShader,
        size: [u32; 2],
        lanes: u32,
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        let info = &dispatcher.device.info;
        let side = pixels_per_side(key);
        let threads = driver_threads(dispatcher.device);
        let state_bytes = RecordLayout::of(&paths.shader, path_kernel(key).1).map_or(256, |l| l.span);
        let lane_limit = (info.max_binding / u64::from(state_bytes)).min(u64::from(u32::MAX)) as u32;
        // GPUs: as many pixels in flight as with one pixel per lane.
        let lanes = if info.is_cpu { lanes } else { lanes / (side * side) }.min(lane_limit);
        let max_lanes_of = |tiles: &[Tile]| tiles.iter().map(|t| t.lanes(threads)).max().unwrap_or(GROUP);
        let max_lanes = max_lanes_of(&Tile::bands([0, 0], size, lanes, side));
        let feature_lanes = max_lanes_of(&Tile::bands([0, 0], size, max_lanes, 1));
        let feature_bytes = size_of::<FeaturePixel>() as u64 * u64::from(feature_lanes);
        let pixels = u64::from(side * side * max_lanes);
        let max_batches = (info.max_binding / (16 * pixels)).clamp(1, MAX_BATCHES) as u32;
        let sum_bytes = pixels * 16 * u64::from(max_batches);

        let storage = U::STORAGE | U::COPY_SRC | U::COPY_DST;
        let pass_buffer = up.buffer("the pass", &[Pass::default()], U::UNIFORM | U::COPY_DST)?;
        let states = up.zeros("path states", u64::from(max_lanes) * u64::from(state_bytes), U::STORAGE)?;
        let sums = up.zeros("batch sums", sum_bytes, storage)?;
        let coverage_sums = match key.has(Part::Transparent) {
            true => Some(up.zeros("sums of coverage", sum_bytes / 4, storage)?),
            false => None,
        };
        let feature_pixels = up.zeros("first-hit features", feature_bytes, storage)?;
        let readback = up.zeros("the copy of batch sums", sum_bytes.max(feature_bytes), U::MAP_READ | U::COPY_DST)?;
        let buffers = [
            ("pass_info", Some(&pass_buffer)),
            ("states", Some(&states)),
            ("batch_sums", Some(&sums)),
            ("coverage_sums", coverage_sums.as_ref()),
            ("feature_pixels", Some(&feature_pixels)),
        ];
        for (name, buffer) in buffers {
            if let Some(buffer) = buffer {
                resources.insert(name.into(), Resource::Buffer(buffer.clone()));
            }
        }
        // No watchdog ends a CPU driver's dispatches; interrupts wait for them.
        let max_duration = if info.is_cpu { 4 * MAX_DURATION } else { MAX_DURATION };
        let slices = Slices::new(pass_buffer.clone(), |counts| &mut counts.paths, max_duration);
        Ok(Self {
            slices,
            pass_buffer,
            sums,
            coverage_sums,
            feature_pixels,
            readback,
            size,
            side,
            threads,
            max_lanes,
            max_batches,
            traversals_per_ray: 1,
        })
    }

    /// Sets the target range for the duration of a dispatch.
    pub(crate) fn set_dispatch_durations(&mut self, min: Duration, max: Duration) {
        self.slices.set_durations(min, max);
    }

    /// Makes the driver compile the path kernel.
    pub(crate) fn warm_up(&self, dispatcher: &Dispatcher<'_>, kernel: &Kernel) -> Result<(), RenderError> {
        self.slices.warm_up(dispatcher, kernel, self.threads, &warm_up(self.threads))
    }

    /// Traces batches of the film's pixels and reads their sums back; `None` when the observer
    /// stopped it.
    pub(crate) fn trace(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        film: &Film,
        range: BatchRange,
        monitor: &mut Monitor<'_, '_>,
    ) -> Result<Option<Vec<TileSums>>, RenderError> {
        // A pass without samples writes nothing and would be reported as lost work.
        if range.samples == 0 {
            return Err(FilmError::NoSamples.into());
        }
        let tiles = self.tiles_of(film, self.side)?;
        if range.batches == 0 {
            return Ok(Some(Vec::new()));
        }
        let mut traced = Vec::new();
        for tile in tiles {
            let BatchRange { first: first_batch, batches, samples } = range;
            let pass = Pass { first_batch, batches, samples, ..self.pass_of(&tile) };
            let bytes = self.sum_bytes(&pass);
            if bytes > self.sums.size() {
                return Err(RenderError::TooManyBatches { batches, limit: self.max_batches });
            }
            // Clears the sums of the previous tile, so that a batch that is not written is
            // detected.
            dispatcher.device.clear(&self.sums, Some(bytes))?;
            if let Some(sums) = &self.coverage_sums {
                dispatcher.device.clear(sums, Some(bytes / 4))?;
            }
            let slice = |budget, restart| Pass { budget, restart, ..pass };
            if self.slices.run(dispatcher, kernel, pass.lanes / GROUP, slice, monitor)?.is_none() {
                return Ok(None);
            }
            let started = Instant::now();
            let sums = dispatcher.device.fetch(&self.sums, 0, bytes, &self.readback)?;
            let coverage = match &self.coverage_sums {
                Some(sums) => Some(dispatcher.device.fetch(sums, 0, bytes / 4, &self.readback)?),
                None => None,
            };
            traced.push(TileSums { tile, sums, coverage });
            monitor.counts.read_seconds += started.elapsed().as_secs_f64();
        }
        Ok(Some(traced))
    }

    /// Adds the traced batches to the film. `samples`: of a batch's pixel, unless it has another
    /// share of them.
    pub(crate) fn add_to_film(
        &self,
        film: &mut Film,
        traced: Vec<TileSums>,
        samples: u32,
        shares: Option<&Shares>,
    ) -> Result<(), RenderError> {
        for TileSums { tile, sums, coverage } in traced {
            let pixels = tile.pixels(tile.lanes(self.threads), &film.window());
            for (k, batch) in sums.chunks_exact(pixels.len()).enumerate() {
                if pixels.iter().zip(batch).any(|(&p, s)| p != u32::MAX && !s.is_written()) {
                    return Err(lost_samples());
                }
                let samples = |x, y| shares.map_or(samples, |shares| shares.samples([x, y], samples));
                match &coverage {
                    Some(coverage) => {
                        let coverage = &coverage[k * pixels.len()..][..pixels.len()];
                        film.add_covered_batch(samples, &pixels, batch, coverage)?
                    }
                    None => film.add_uneven_batch(samples, &pixels, batch)?,
                };
            }
        }
        Ok(())
    }

    /// Albedo and normal of first hits, averaged over a pixel, and depth through its centre.
    pub(crate) fn trace_features(
        &self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        film: &Film,
        counts: &mut Counts,
    ) -> Result<FilmFeatures, RenderError> {
        let window = film.window();
        let count = film.pixels().len();
        let mut all =
            FilmFeatures { albedo: vec![[0.0; 3]; count], normal: vec![[0.0; 3]; count], depth: vec![0.0; count] };
        for tile in self.tiles_of(film, 1)? {
            let pass = Pass { samples: FEATURE_SAMPLES, ..self.pass_of(&tile) };
            for i in 0..=FEATURE_SAMPLES {
                let ray = Pass { first_batch: i, restart: u32::from(i == 0), ..pass };
                let (report, _) = dispatcher.run(kernel, pass.lanes / GROUP, &self.pass_buffer, &ray)?;
                counts.truncated += u64::from(report.truncated);
            }
            let bytes = u64::from(pass.lanes) * size_of::<FeaturePixel>() as u64;
            let records: Vec<FeaturePixel> = dispatcher.device.fetch(&self.feature_pixels, 0, bytes, &self.readback)?;
            for (pixel, r) in tile.pixels(pass.lanes, &window).into_iter().zip(records) {
                if pixel != u32::MAX {
                    let i = pixel as usize;
                    all.albedo[i] = r.albedo.map(|sum| sum / FEATURE_SAMPLES as f32);
                    all.depth[i] = r.depth;
                    all.normal[i] = r.normal.map(|sum| sum / FEATURE_SAMPLES as f32);
                }
            }
        }
        Ok(all)
    }

    /// The film's window of the image, cut into tiles that fit the buffers.
    fn tiles_of(&self, film: &Film, side: u32) -> Result<Vec<Tile>, RenderError> {
        let window = film.window();
        if window.whole != self.size {
            return Err(RenderError::FilmSize { film: window.whole, view: self.size });
        }
        Ok(Tile::bands(window.corner, window.size, self.max_lanes, side))
    }

    fn pass_of(&self, tile: &Tile) -> Pass {
        Pass {
            corner: tile.corner,
            size: tile.size,
            lanes: tile.lanes(self.threads),
            threads: self.threads,
            walks: self.traversals_per_ray,
            ..Pass::default()
        }
    }

    /// Bytes of a pass's batch sums.
    fn sum_bytes(&self, pass: &Pass) -> u64 {
        16 * u64::from(pass.batches) * u64::from(pass.lanes) * u64::from(self.side.pow(2))
    }
}

/// The error for samples that a pass did not write.
pub(crate) fn lost_samples() -> RenderError {
    RenderError::LostWork { message: "some pixels lack samples after a pass".into() }
}
