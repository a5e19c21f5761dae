//! Dispatches that are short enough for every driver: a single one, or as many as the work takes;
//! and the check that none is lost.

use std::time::{Duration, Instant};

use bytemuck::NoUninit;

use crate::{
    counts::{Counts, Monitor},
    device::Device,
    error::RenderError,
    kernel::{Kernel, Resource, Resources},
    pass::Control,
    stopwatch::{self, Stopwatch},
    upload::Uploader,
};

/// Bytes of the record in which a dispatch reports its work.
const CONTROL_BYTES: u64 = size_of::<Control>() as u64;

/// Target duration of a dispatch: long enough to be efficient, too short for any watchdog.
const MIN_DURATION: Duration = Duration::from_millis(50);
pub(crate) const MAX_DURATION: Duration = Duration::from_millis(200);

/// Loop iterations after which a lane starts no further step.
///
/// Some CPU drivers silently end every loop of an invocation after 65,535 iterations. They execute
/// eight lanes in lockstep and count the iterations of all of them together. Each lane keeps to its
/// budget, so the eight take at most 8 · 4,096 iterations before the last step, and the last step
/// takes at most the limit of a traversal, 32,768.
const MIN_BUDGET: u32 = 64;
const FIRST_BUDGET: u32 = 512;
const MAX_BUDGET: u32 = 4096;

/// Runs kernels that report to one control record.
pub(crate) struct Dispatcher<'a> {
    pub(crate) device: &'a Device,
    control: wgpu::Buffer,
    readback: wgpu::Buffer,
    stopwatch: Option<Stopwatch>,
}

impl<'a> Dispatcher<'a> {
    /// Makes the control record, and adds it to the resources.
    pub(crate) fn new(
        device: &'a Device,
        up: &mut Uploader<'_>,
        resources: &mut Resources,
    ) -> Result<Self, RenderError> {
        use wgpu::BufferUsages as U;
        let control = up.buffer("the control record", &[Control::default()], U::STORAGE | U::COPY_SRC | U::COPY_DST)?;
        let bytes = CONTROL_BYTES + stopwatch::BYTES;
        let readback = up.zeros("the control record's copy", bytes, U::MAP_READ | U::COPY_DST)?;
        resources.insert("control".into(), Resource::Buffer(control.clone()));
        Ok(Self { device, control, readback, stopwatch: Stopwatch::new(device)? })
    }

    /// Writes a pass to its buffer and dispatches it. Returns its report and its seconds by the
    /// device's timestamps. An error where a workgroup has not reported.
    pub(crate) fn run<P: NoUninit>(
        &self,
        kernel: &Kernel,
        workgroups: u32,
        pass_buffer: &wgpu::Buffer,
        pass: &P,
    ) -> Result<(Control, Option<f64>), RenderError> {
        let device = self.device;
        let watch = self.stopwatch.as_ref();
        device.scoped("a dispatch", || {
            device.queue.write_buffer(pass_buffer, 0, bytemuck::bytes_of(pass));
            device.queue.write_buffer(&self.control, 0, bytemuck::bytes_of(&Control::default()));
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            kernel.record(&mut encoder, workgroups, watch.map(Stopwatch::around));
            encoder.copy_buffer_to_buffer(&self.control, 0, &self.readback, 0, CONTROL_BYTES);
            if let Some(watch) = watch {
                watch.record(&mut encoder, &self.readback, CONTROL_BYTES);
            }
            device.queue.submit([encoder.finish()]);
        })?;
        let size = CONTROL_BYTES + watch.map_or(0, |_| stopwatch::BYTES);
        let (report, timestamps) = device.read(&self.readback, size, |bytes| {
            let (control, timestamps) = bytes.split_at(size_of::<Control>());
            let timestamps = (!timestamps.is_empty()).then(|| bytemuck::pod_read_unaligned::<[u64; 2]>(timestamps));
            (bytemuck::pod_read_unaligned::<Control>(control), timestamps)
        })?;
        if report.workgroups != workgroups {
            let message = format!("{} of {workgroups} workgroups reported", report.workgroups);
            return Err(RenderError::LostWork { message });
        }
        Ok((report, watch.zip(timestamps).and_then(|(watch, ends)| watch.seconds(ends))))
    }
}

/// Dispatches a kernel slice by slice: a lane that has used up its budget of loop iterations
/// continues in the next dispatch.
pub(crate) struct Slices {
    pass_buffer: wgpu::Buffer,
    /// Selects the counter of the lanes' finished work.
    counted: fn(&mut Counts) -> &mut u64,
    budget: u32,
    /// Target range for the duration of a dispatch.
    durations: [Duration; 2],
}

impl Slices {
    /// Slices whose dispatches should last at most `max_duration`.
    pub(crate) fn new(pass_buffer: wgpu::Buffer, counted: fn(&mut Counts) -> &mut u64, max_duration: Duration) -> Self {
        Self { pass_buffer, counted, budget: FIRST_BUDGET, durations: [MIN_DURATION, max_duration] }
    }

    /// Sets the target range for the duration of a dispatch, as far as the remaining work and the
    /// limits of the budget allow.
    pub(crate) fn set_durations(&mut self, min: Duration, max: Duration) {
        self.durations = [min, max];
    }

    /// Dispatches an empty pass: drivers compile at the first dispatch.
    pub(crate) fn warm_up<P: NoUninit>(
        &self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        workgroups: u32,
        pass: &P,
    ) -> Result<(), RenderError> {
        dispatcher.run(kernel, workgroups, &self.pass_buffer, pass)?;
        Ok(())
    }

    /// Dispatches until no lane has work left. `pass` makes a pass from a budget and a flag: lanes
    /// restart (1) or continue (0). Counts the work, and returns the amount finished; `None` when
    /// the observer stopped it.
    pub(crate) fn run<P: NoUninit>(
        &mut self,
        dispatcher: &Dispatcher<'_>,
        kernel: &Kernel,
        workgroups: u32,
        pass: impl Fn(u32, u32) -> P,
        monitor: &mut Monitor<'_, '_>,
    ) -> Result<Option<u64>, RenderError> {
        let (mut restart, mut finished) = (1, 0);
        loop {
            let started = Instant::now();
            let slice = pass(self.budget, restart);
            let (report, on_device) = dispatcher.run(kernel, workgroups, &self.pass_buffer, &slice)?;
            let duration = started.elapsed();
            let counts = &mut *monitor.counts;
            counts.device_seconds += on_device.unwrap_or(duration.as_secs_f64());
            counts.trace_seconds += duration.as_secs_f64();
            counts.dispatches += 1;
            counts.rays += u64::from(report.rays);
            counts.dropped += u64::from(report.dropped);
            counts.truncated += u64::from(report.truncated);
            *(self.counted)(counts) += u64::from(report.paths);
            finished += u64::from(report.paths);
            restart = 0;
            self.adapt(duration, report.unfinished > 0);
            if !(monitor.observer)(monitor.counts) {
                return Ok(None);
            }
            if report.unfinished == 0 {
                return Ok(Some(finished));
            }
        }
    }

    /// Doubles the budget after a short dispatch that left work unfinished, and halves it after a
    /// long one.
    fn adapt(&mut self, duration: Duration, work_is_left: bool) {
        let [min, max] = self.durations;
        if duration < min && work_is_left {
            self.budget = (2 * self.budget).min(MAX_BUDGET);
        } else if duration > max {
            self.budget = (self.budget / 2).max(MIN_BUDGET);
        }
    }
}
