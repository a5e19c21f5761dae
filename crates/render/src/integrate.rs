//! Integrals of a user's formula over a box, evaluated on the device in f32: random sampling in
//! independent replicates, and the grids of quadrature rules. The host adds up more than 64 terms
//! in f64.

mod formula;
mod grid;

use std::time::{Duration, Instant};

use surelight_prepare::{
    Constant, KernelKey, PointSet, Sampler, compose_with,
    shared::{INTEGRATION_CHUNK as CHUNK, IntegrationTask, WORKGROUP_LANES as GROUP},
};

use crate::{
    device::Device,
    error::RenderError,
    kernel::{Checks, Kernel, Resource, Resources},
    upload::Uploader,
};

pub use self::formula::{Formula, FormulaError, MAX_DIMENSIONS};
pub use self::grid::Grid;

const ROOT: &str = "package::kernel::integrate";
/// Lanes of one dispatch: its results are 8 bytes per lane.
const MAX_LANES: u32 = 1 << 20;
/// Target duration of a dispatch: a shorter one grows, a longer one shrinks.
const SHORT: Duration = Duration::from_millis(40);
const LONG: Duration = Duration::from_millis(200);
/// Maximum number of nodes over all axes.
const MAX_NODES: usize = 1 << 24;

/// A formula on a box, compiled for a device.
pub struct Integrand<'a> {
    device: &'a Device,
    bounds: Vec<[f64; 2]>,
    samplers: Vec<(Sampler, Kernel)>,
    nodes_kernel: Kernel,
    task: wgpu::Buffer,
    nodes: wgpu::Buffer,
    results: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Lanes of a dispatch, adapted to the duration of the previous ones.
    lanes: u32,
}

/// The results of sampling.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sampled {
    /// The estimate of each replicate: independent and identically distributed.
    pub replicates: Vec<f64>,
    /// Means of up to 64 samples, times the volume, for a test of the tail; at most 2^18 of them.
    pub chunks: Vec<f64>,
    /// Values that were not finite, counted as 0.
    pub non_finite: u64,
    /// Evaluations of the formula.
    pub evaluations: u64,
}

/// Maximum number of chunk means that are kept.
const MAX_CHUNKS: u32 = 1 << 18;

impl<'a> Integrand<'a> {
    /// Compiles the formula for each sampler. `bounds`: lower and upper bound of each dimension of
    /// the formula.
    pub fn new(
        device: &'a Device,
        formula: &Formula,
        bounds: &[[f64; 2]],
        max_nodes: usize,
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        assert_eq!(formula.dimensions(), bounds.len(), "a formula and a box of different dimensions");
        let mut up = Uploader::new(device);
        let bytes = u64::from(MAX_LANES) * 8;
        let task = up.buffer("the task", &[IntegrationTask::default()], U::UNIFORM | U::COPY_DST)?;
        let nodes = up.zeros("nodes", 4 * max_nodes.clamp(64, MAX_NODES) as u64, U::STORAGE | U::COPY_DST)?;
        let results = up.zeros("the results", bytes, U::STORAGE | U::COPY_SRC)?;
        let readback = up.zeros("the results' copy", bytes, U::MAP_READ | U::COPY_DST)?;
        let mut resources = Resources::new();
        for (name, buffer) in [("task", &task), ("nodes", &nodes), ("results", &results)] {
            resources.insert(name.into(), Resource::Buffer(buffer.clone()));
        }
        let (module, _) = formula.module();
        let constants = [Constant { name: "DIMENSIONS", value: bounds.len() as u32 }];
        let kernel = |sampler: Sampler, entry: &str| {
            let key = KernelKey::of_points(PointSet::new(sampler, false));
            let shader = compose_with(ROOT, &key, &constants, Some(("package::integrand", &module)))?;
            // A user's formula may index out of bounds.
            Kernel::new(device, &shader, entry, Checks::Full, &resources)
        };
        let all = [Sampler::Independent, Sampler::Stratified, Sampler::Sobol];
        let samplers =
            all.into_iter().map(|s| Ok((s, kernel(s, "integrate_samples")?))).collect::<Result<_, RenderError>>()?;
        let nodes_kernel = kernel(Sampler::Sobol, "integrate_nodes")?;
        let mut integrand = Self {
            device,
            bounds: bounds.to_vec(),
            samplers,
            nodes_kernel,
            task,
            nodes,
            results,
            readback,
            lanes: 1 << 10,
        };
        // Drivers compile at the first dispatch.
        for sampler in all {
            integrand.sample(sampler, 1, 1, 0, 0)?;
        }
        integrand.nodes(&vec![vec![0.0]; bounds.len()], 1, &mut |_, _| {})?;
        Ok(integrand)
    }

    fn volume(&self) -> f64 {
        self.bounds.iter().map(|[a, b]| b - a).product()
    }

    /// Estimates the integral by `replicates` independent sets of `samples` points each. The points
    /// are a pure function of sampler, replicate, index and seed; `first_replicate` is the number
    /// of the first replicate. Fewer than 2^38 points in all.
    pub fn sample(
        &mut self,
        sampler: Sampler,
        replicates: u32,
        samples: u32,
        first_replicate: u32,
        seed: u32,
    ) -> Result<Sampled, RenderError> {
        let chunks = samples.div_ceil(CHUNK);
        let volume = self.volume();
        let mut bounds = [[0.0; 4]; MAX_DIMENSIONS];
        for (bound, [a, b]) in bounds.iter_mut().zip(&self.bounds) {
            *bound = [*a as f32, (b - a) as f32, 0.0, 0.0];
        }
        let Some(index) = self.samplers.iter().position(|(s, _)| *s == sampler) else { return Ok(Sampled::default()) };
        let mut sums = vec![0.0; replicates as usize];
        let mut found = Sampled { evaluations: u64::from(replicates) * u64::from(samples), ..Sampled::default() };
        let total = replicates.saturating_mul(chunks);
        let stride = total.div_ceil(MAX_CHUNKS);
        let mut first = 0;
        while first < total {
            let count = self.lanes.min(total - first);
            let stream = sampler as u32;
            let task =
                IntegrationTask { first, count, samples, chunks, first_replicate, stream, seed, unused: 0, bounds };
            let (pairs, seconds) = self.run(&self.samplers[index].1, &task, 2 * count)?;
            for (pair, number) in pairs.chunks_exact(2).zip(first..) {
                let terms = CHUNK.min(samples - number % chunks * CHUNK);
                // A sum that overflows f32 is lost as a whole.
                let (value, bad) = if pair[0].is_finite() { (pair[0], pair[1] as u64) } else { (0.0, terms.into()) };
                found.non_finite += bad;
                sums[(number / chunks) as usize] += f64::from(value);
                if terms == CHUNK && number.is_multiple_of(stride) {
                    found.chunks.push(f64::from(value) / f64::from(terms) * volume);
                }
            }
            first += count;
            self.adapt(count, seconds);
        }
        found.replicates = sums.into_iter().map(|sum| sum / f64::from(samples) * volume).collect();
        Ok(found)
    }

    /// One dispatch: its results and its duration.
    fn run(&self, kernel: &Kernel, task: &IntegrationTask, floats: u32) -> Result<(Vec<f32>, Duration), RenderError> {
        let (device, size) = (self.device, u64::from(floats) * 4);
        let started = Instant::now();
        device.scoped("a dispatch", || {
            device.queue.write_buffer(&self.task, 0, bytemuck::bytes_of(task));
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            kernel.record(&mut encoder, task.count.div_ceil(GROUP), None);
            encoder.copy_buffer_to_buffer(&self.results, 0, &self.readback, 0, size);
            device.queue.submit([encoder.finish()]);
        })?;
        let values = device.read(&self.readback, size, bytemuck::pod_collect_to_vec)?;
        Ok((values, started.elapsed()))
    }

    fn adapt(&mut self, count: u32, time: Duration) {
        if time > LONG {
            self.lanes = (self.lanes / 2).max(GROUP);
        } else if time < SHORT && count == self.lanes {
            self.lanes = (2 * self.lanes).min(MAX_LANES);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;
    use surelight_prepare::RecordLayout;

    #[test]
    fn every_dimension_composes_and_the_task_is_laid_out_alike() {
        for dimensions in 1..=MAX_DIMENSIONS as u32 {
            let formula = Formula::new(&format!("x{} * e - 2 * pi", dimensions - 1), dimensions as usize).unwrap();
            let constants = [Constant { name: "DIMENSIONS", value: dimensions }];
            let more = Some(("package::integrand", formula.module().0));
            let more = more.as_ref().map(|(path, source)| (*path, source.as_str()));
            let shader = compose_with(ROOT, &KernelKey::default(), &constants, more).unwrap();
            let layout = RecordLayout::of(&shader, "IntegrationTask").unwrap();
            for (field, offset) in [
                ("first", offset_of!(IntegrationTask, first)),
                ("samples", offset_of!(IntegrationTask, samples)),
                ("first_replicate", offset_of!(IntegrationTask, first_replicate)),
                ("seed", offset_of!(IntegrationTask, seed)),
                ("bounds", offset_of!(IntegrationTask, bounds)),
            ] {
                assert_eq!(layout.offsets[field] as usize, offset, "{field}");
            }
            assert_eq!(layout.span as usize, size_of::<IntegrationTask>());
        }
    }
}
