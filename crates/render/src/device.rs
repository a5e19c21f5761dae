//! Selects and opens an adapter with all its limits, and catches its errors.

use bytemuck::{AnyBitPattern, NoUninit};

use crate::{
    device_loss::LossWatch,
    error::{RenderError, Source},
};

/// Which adapter to use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The most capable: discrete, integrated, virtual, then software.
    #[default]
    Best,
    /// The one at this index in [`Device::list`].
    Index(usize),
    /// The first whose name contains this text, regardless of case.
    Name(String),
}

/// Maximum number of a scene's read-only arrays: the bindings of group 0 except the view.
const SCENE_ARRAYS: u32 = 14;

/// Properties of an adapter.
#[derive(Clone, Debug)]
pub struct AdapterInfo {
    /// Device name.
    pub name: String,
    /// Driver name and version.
    pub driver: String,
    /// `Vulkan`, `Metal` or `Dx12`.
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `VirtualGpu`, `Cpu` or `Other`.
    pub kind: String,
    /// Whether it is a software driver.
    pub is_cpu: bool,
    /// Maximum bytes of one buffer binding.
    pub max_binding: u64,
    /// Maximum texels along a side of an image.
    pub max_image_side: u32,
    /// Whether it supports timestamp queries.
    pub timestamps: bool,
}

/// An open device and its queue.
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    /// Its description.
    pub info: AdapterInfo,
    pub(crate) limits: wgpu::Limits,
    images: bool,
    loss: LossWatch,
}

fn instance() -> wgpu::Instance {
    wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends: wgpu::Backends::PRIMARY,
        flags: wgpu::InstanceFlags::empty(),
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    })
}

fn describe(adapter: &wgpu::Adapter) -> AdapterInfo {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    AdapterInfo {
        name: info.name,
        driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        backend: backend_name(info.backend).to_owned(),
        kind: kind_name(info.device_type).to_owned(),
        is_cpu: info.device_type == wgpu::DeviceType::Cpu,
        max_binding: limits.max_storage_buffer_binding_size.min(limits.max_buffer_size),
        max_image_side: limits.max_texture_dimension_2d,
        timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
    }
}

/// The name of a backend in reports.
fn backend_name(backend: wgpu::Backend) -> &'static str {
    match backend {
        wgpu::Backend::Noop => "Noop",
        wgpu::Backend::Vulkan => "Vulkan",
        wgpu::Backend::Metal => "Metal",
        wgpu::Backend::Dx12 => "Dx12",
        wgpu::Backend::Gl => "Gl",
        wgpu::Backend::BrowserWebGpu => "BrowserWebGpu",
    }
}

fn kind_name(kind: wgpu::DeviceType) -> &'static str {
    match kind {
        wgpu::DeviceType::DiscreteGpu => "DiscreteGpu",
        wgpu::DeviceType::IntegratedGpu => "IntegratedGpu",
        wgpu::DeviceType::VirtualGpu => "VirtualGpu",
        wgpu::DeviceType::Cpu => "Cpu",
        wgpu::DeviceType::Other => "Other",
    }
}

fn adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY))
}

impl Device {
    /// All adapters of this machine.
    pub fn list() -> Vec<AdapterInfo> {
        adapters(&instance()).iter().map(describe).collect()
    }

    /// Opens an adapter with all the limits it has.
    pub fn new(choice: &AdapterChoice) -> Result<Self, RenderError> {
        let adapters = adapters(&instance());
        if adapters.is_empty() {
            return Err(RenderError::NoAdapter);
        }
        let infos: Vec<_> = adapters.iter().map(describe).collect();
        let found = match choice {
            AdapterChoice::Best => (0..infos.len()).min_by_key(|&i| rank(adapters[i].get_info().device_type)),
            AdapterChoice::Index(i) => (*i < infos.len()).then_some(*i),
            AdapterChoice::Name(name) => {
                infos.iter().position(|a| a.name.to_lowercase().contains(&name.to_lowercase()))
            }
        };
        let Some(index) = found else {
            let wanted = match choice {
                AdapterChoice::Index(i) => i.to_string(),
                AdapterChoice::Name(name) => name.clone(),
                AdapterChoice::Best => String::new(),
            };
            let available = infos.iter().map(|a| a.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(RenderError::UnknownAdapter { wanted, available });
        };
        Self::open(&adapters[index], infos[index].clone())
    }

    fn open(adapter: &wgpu::Adapter, info: AdapterInfo) -> Result<Self, RenderError> {
        let limits = adapter.limits();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("surelight"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: limits.clone(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::Performance,
            trace: wgpu::Trace::Off,
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|e| RenderError::NoDevice { adapter: info.name.clone(), source: e.into() })?;
        let loss = LossWatch::new(&device);
        // CPU drivers are several times faster at it.
        let images = info.is_cpu && limits.max_storage_textures_per_shader_stage >= SCENE_ARRAYS;
        Ok(Self { device, queue, info, limits, images, loss })
    }

    /// Chooses the storage from which kernels read the scene, for measurements: images or buffers.
    /// The rendered image is the same. Images are chosen only where a kernel can bind enough of
    /// them.
    #[must_use]
    pub fn with_images(self, images: bool) -> Self {
        let images = images && self.limits.max_storage_textures_per_shader_stage >= SCENE_ARRAYS;
        Self { images, ..self }
    }

    /// Whether kernels read the scene from images rather than from buffers.
    pub fn reads_images(&self) -> bool {
        self.images
    }

    /// Runs `work` inside error scopes and turns their errors into a [`RenderError::Device`].
    pub(crate) fn scoped<T>(&self, what: &str, work: impl FnOnce() -> T) -> Result<T, RenderError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.device.push_error_scope(wgpu::ErrorFilter::Internal);
        let value = work();
        for scope in [internal, validation, memory] {
            if let Some(error) = pollster::block_on(scope.pop()) {
                return Err(RenderError::Device { what: what.into(), source: error.into() });
            }
        }
        self.check_lost()?;
        Ok(value)
    }

    /// An error when the driver has dropped the device.
    pub(crate) fn check_lost(&self) -> Result<(), RenderError> {
        self.loss.check(&self.info.name)
    }

    /// Reads the first `size` bytes of a mappable buffer, once all submitted work is done.
    pub(crate) fn read<T>(
        &self,
        buffer: &wgpu::Buffer,
        size: u64,
        read: impl FnOnce(&[u8]) -> T,
    ) -> Result<T, RenderError> {
        let slice = buffer.slice(..size);
        let (send, receive) = std::sync::mpsc::channel();
        slice.map_async(wgpu::MapMode::Read, move |result| {
            // The receiver lives until the wait below has ended.
            let _ = send.send(result);
        });
        self.wait()?;
        let failed = |source: Source| RenderError::Device { what: "reading a buffer".into(), source };
        receive.recv().map_err(|e| failed(e.into()))?.map_err(|e| failed(e.into()))?;
        let view = slice.get_mapped_range().map_err(|e| failed(e.into()))?;
        let value = read(&view);
        drop(view);
        buffer.unmap();
        Ok(value)
    }

    /// Reads `size` bytes of a buffer from `start` on, as records, through a mappable buffer.
    pub(crate) fn fetch<T: AnyBitPattern + NoUninit>(
        &self,
        buffer: &wgpu::Buffer,
        start: u64,
        size: u64,
        readback: &wgpu::Buffer,
    ) -> Result<Vec<T>, RenderError> {
        self.scoped("a copy", || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.copy_buffer_to_buffer(buffer, start, readback, 0, size);
            self.queue.submit([encoder.finish()]);
        })?;
        self.read(readback, size, bytemuck::pod_collect_to_vec)
    }

    /// Zeroes the first `size` bytes of a buffer; all of them for `None`.
    pub(crate) fn clear(&self, buffer: &wgpu::Buffer, size: Option<u64>) -> Result<(), RenderError> {
        self.scoped("clearing a buffer", || {
            let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            encoder.clear_buffer(buffer, 0, size);
            self.queue.submit([encoder.finish()]);
        })
    }

    /// Waits until the device has finished all submitted work.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|e| RenderError::Device { what: "a wait for it".into(), source: e.into() })?;
        self.check_lost()
    }
}

fn rank(kind: wgpu::DeviceType) -> u32 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}
