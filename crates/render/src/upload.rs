//! Uploads to the device, within its limits.

use bytemuck::NoUninit;
use wgpu::util::DeviceExt;

use surelight_prepare::IMAGE_WIDTH;

use crate::{device::Device, error::RenderError};

pub(crate) const MIB: u64 = 1 << 20;

/// Minimum bytes of a buffer: a binding must hold one record of its type, even where there is none.
const MIN_BYTES: usize = 256;

/// The height of an image that uses `used` rows: never a power of two. Mesa's CPU driver compiles a
/// kernel again when the height of an image becomes a power of two, and kernels are compiled before
/// heights are known ([`crate::precompiled`]).
pub(crate) fn rows_of(used: u32) -> u32 {
    let used = used.max(3);
    if used.is_power_of_two() { used + 1 } else { used }
}

/// Makes resources and counts their bytes.
pub(crate) struct Uploader<'a> {
    device: &'a Device,
    /// Bytes of everything made so far.
    pub(crate) bytes: u64,
}

impl<'a> Uploader<'a> {
    pub(crate) fn new(device: &'a Device) -> Self {
        Self { device, bytes: 0 }
    }

    /// A buffer that holds `data`; never empty, since an empty buffer cannot be bound.
    pub(crate) fn buffer<T: NoUninit>(
        &mut self,
        what: &str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, RenderError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.check(what, bytes.len() as u64, usage)?;
        let mut padded;
        let contents = if bytes.len() >= MIN_BYTES && bytes.len().is_multiple_of(4) {
            bytes
        } else {
            padded = bytes.to_vec();
            padded.resize(bytes.len().max(MIN_BYTES).next_multiple_of(4), 0);
            &padded
        };
        self.bytes += contents.len() as u64;
        let descriptor = wgpu::util::BufferInitDescriptor { label: Some(what), contents, usage };
        self.device.scoped(what, || self.device.device.create_buffer_init(&descriptor))
    }

    /// A buffer of zeros.
    pub(crate) fn zeros(
        &mut self,
        what: &str,
        size: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, RenderError> {
        self.check(what, size, usage)?;
        self.bytes += size;
        let descriptor =
            wgpu::BufferDescriptor { label: Some(what), size: size.max(16), usage, mapped_at_creation: false };
        self.device.scoped(what, || self.device.device.create_buffer(&descriptor))
    }

    /// An image of `rgba32uint` texels that holds `data`, row after row of 4096.
    pub(crate) fn image<T: NoUninit>(&mut self, what: &str, data: &[T]) -> Result<wgpu::TextureView, RenderError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let row = IMAGE_WIDTH as usize * 16;
        let height = rows_of(bytes.len().div_ceil(row) as u32);
        let limit = self.device.info.max_image_side;
        if height > limit || IMAGE_WIDTH > limit {
            return Err(RenderError::TooLarge {
                what: what.into(),
                needed: bytes.len() as u64 / MIB,
                limit: u64::from(limit) * row as u64 / MIB,
                limit_name: "max_texture_dimension_2d",
                adapter: self.device.info.name.clone(),
            });
        }
        self.bytes += height as u64 * row as u64;
        let size = wgpu::Extent3d { width: IMAGE_WIDTH, height, depth_or_array_layers: 1 };
        self.device.scoped(what, || {
            let texture = self.device.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(what),
                size,
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Uint,
                usage: wgpu::TextureUsages::STORAGE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            });
            let layout = wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row as u32),
                rows_per_image: Some(height),
            };
            let whole = bytes.len() / row;
            let copy = |first_row: u32, rows: u32, data: &[u8]| {
                if rows > 0 {
                    let mut to = texture.as_image_copy();
                    to.origin.y = first_row;
                    self.device.queue.write_texture(to, data, layout, wgpu::Extent3d { height: rows, ..size });
                }
            };
            copy(0, whole as u32, &bytes[..whole * row]);
            let rest = &bytes[whole * row..];
            if !rest.is_empty() {
                let mut last = rest.to_vec();
                last.resize(row, 0);
                copy(whole as u32, 1, &last);
            }
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        })
    }

    fn check(&self, what: &str, size: u64, usage: wgpu::BufferUsages) -> Result<(), RenderError> {
        let limits = &self.device.limits;
        let (limit, limit_name) = if usage.contains(wgpu::BufferUsages::STORAGE) {
            (self.device.info.max_binding, "max_storage_buffer_binding_size")
        } else {
            (limits.max_buffer_size, "max_buffer_size")
        };
        if size <= limit {
            return Ok(());
        }
        Err(RenderError::TooLarge {
            what: what.into(),
            needed: size.div_ceil(MIB),
            limit: limit / MIB,
            limit_name,
            adapter: self.device.info.name.clone(),
        })
    }
}
