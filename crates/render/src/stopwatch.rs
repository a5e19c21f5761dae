//! Seconds of a dispatch by the device's timestamps.

use std::ops::Range;

use crate::{device::Device, error::RenderError};

/// Timestamps of a dispatch's beginning and end, 8 bytes each.
pub(crate) const BYTES: u64 = 16;

/// Two timestamp queries around a dispatch, on a device that has them.
///
/// The host's wait for a dispatch includes the transfer to the device and back; the device takes
/// these timestamps at the beginning and the end of the pass.
pub(crate) struct Stopwatch {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Nanoseconds per tick.
    period: f64,
}

impl Stopwatch {
    /// `None` where the adapter has no timestamp queries.
    pub(crate) fn new(device: &Device) -> Result<Option<Self>, RenderError> {
        if !device.info.timestamps {
            return Ok(None);
        }
        device.scoped("timestamp queries", || {
            let queries = device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("a dispatch"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            });
            let resolved = device.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("timestamps"),
                size: BYTES,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            Some(Self { queries, resolved, period: f64::from(device.queue.get_timestamp_period()) })
        })
    }

    /// The timestamps of a compute pass.
    pub(crate) fn around(&self) -> wgpu::ComputePassTimestampWrites<'_> {
        wgpu::ComputePassTimestampWrites {
            query_set: &self.queries,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        }
    }

    /// Copies both timestamps into `target`, once the pass is done.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, target: &wgpu::Buffer, offset: u64) {
        const BOTH: Range<u32> = 0..2;
        encoder.resolve_query_set(&self.queries, BOTH, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, target, offset, BYTES);
    }

    /// Seconds between two timestamps; `None` where the driver wrote none, or wrote decreasing
    /// ones.
    pub(crate) fn seconds(&self, [begun, ended]: [u64; 2]) -> Option<f64> {
        (begun > 0 && ended >= begun).then(|| (ended - begun) as f64 * self.period * 1e-9)
    }
}
