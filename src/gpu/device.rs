//! The graphics device: choice of the adapter, and recording of its errors.
//!
//! Only Vulkan is used. Without a graphics card the same code runs on Mesa's software driver (lavapipe), so
//! that a machine without a screen draws the same pictures.

use crate::error::{ErrorCode, UserError};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// Environment variable that selects the software driver when set to `software`.
pub const GPU_VARIABLE: &str = "VANECUT_GPU";

/// Errors of opening or using the device.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.explained())]
pub enum GpuError {
    /// No Vulkan loader or no Vulkan driver was found.
    NoVulkan,
    /// The software driver was requested, and only other drivers are installed.
    NoSoftware,
    /// The environment variable has an unknown value.
    UnknownChoice(String),
    /// The adapter exists, but its device cannot be opened.
    Open {
        /// Name of the adapter.
        name: String,
        /// The driver's reason.
        source: wgpu::RequestDeviceError,
    },
    /// The device rejected or failed an operation.
    Failed(String),
    /// The input needs larger buffers than the device has.
    TooLarge {
        /// Content of the buffer.
        what: &'static str,
        /// Requested size, bytes.
        bytes: u64,
        /// Largest allowed size, bytes.
        limit: u64,
    },
}

impl GpuError {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        let (what, help) = match self {
            Self::NoVulkan => (
                "no Vulkan driver was found".to_owned(),
                "install one, on Debian: apt install libvulkan1 mesa-vulkan-drivers (the latter includes a \
                 software driver that needs no graphics card)",
            ),
            Self::NoSoftware => (
                format!("{GPU_VARIABLE}=software requires a software Vulkan driver, but none is installed"),
                "on Debian: apt install mesa-vulkan-drivers",
            ),
            Self::UnknownChoice(word) => {
                (format!("{GPU_VARIABLE} is {word:?}"), "set it to \"software\" or unset it")
            }
            Self::Open { name, source } => {
                (format!("the graphics device {name} could not be opened: {source}"), "")
            }
            Self::Failed(what) => (format!("the graphics device failed: {what}"), ""),
            Self::TooLarge { what, bytes, limit } => {
                let what = format!("{what} needs a buffer of {bytes} bytes");
                let limit = format!("the graphics device allows {limit}");
                return UserError::new(ErrorCode::GraphicsDevice, what, limit);
            }
        };
        UserError::new(ErrorCode::GraphicsDevice, what, help)
    }
}

impl From<GpuError> for UserError {
    fn from(error: GpuError) -> Self {
        error.explained()
    }
}

/// Prefix of the message that records the loss of the device.
pub const DEVICE_LOST_PREFIX: &str = "device lost";

/// Errors outside of any error scope. Bounded, as an error repeated in every frame must not fill memory.
#[derive(Debug, Default)]
struct ErrorLog {
    messages: Mutex<VecDeque<String>>,
}

impl ErrorLog {
    const MAX_MESSAGES: usize = 32;

    fn record(&self, message: String) {
        let mut messages = self.messages.lock().unwrap_or_else(PoisonError::into_inner);
        if messages.len() == Self::MAX_MESSAGES {
            messages.pop_front();
        }
        messages.push_back(message);
    }

    fn take(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).drain(..).collect()
    }
}

/// An open device with its queue. Cheap to clone; clones share device, queue and recorded errors.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// Name, type and driver of the adapter.
    pub info: wgpu::AdapterInfo,
    errors: Arc<ErrorLog>,
}

impl Gpu {
    /// Opens a device without a window.
    ///
    /// # Errors
    /// [`GpuError::NoVulkan`], [`GpuError::NoSoftware`] or [`GpuError::UnknownChoice`] when there is no
    /// suitable adapter, [`GpuError::Open`] when the driver refuses.
    pub fn headless() -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: wgpu::Backends::VULKAN,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::VULKAN));
        let adapter = pick_adapter(&adapters)?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))
            .map_err(|source| GpuError::Open { name: info.name.clone(), source })?;
        Ok(Self::from_parts(device, queue, info))
    }

    /// Wraps a device that was opened elsewhere, e.g. by the window. Its uncaptured errors are then recorded
    /// instead of ending the program.
    pub fn from_parts(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let errors = Arc::new(ErrorLog::default());
        let log = errors.clone();
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| log.record(error.to_string())));
        let log = errors.clone();
        // Also called when the device is dropped; that message is never read.
        device.set_device_lost_callback(move |_, message| {
            let message = format!("{DEVICE_LOST_PREFIX}: {message}");
            log.record(message.trim_end_matches([':', ' ']).to_owned());
        });
        Self { device, queue, info, errors }
    }

    /// Creates a buffer with contents. Unlike wgpu's own helper it does not panic on a lost device.
    pub fn filled_buffer(&self, label: &str, contents: &[u8], usage: wgpu::BufferUsages) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            // Of an empty buffer no slice can be bound, not even to draw nothing.
            size: (contents.len() as u64).max(wgpu::COPY_BUFFER_ALIGNMENT),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// Errors recorded since the last call, oldest first; at most the last 32.
    pub fn take_errors(&self) -> Vec<String> {
        self.errors.take()
    }

    /// Whether the adapter is a software driver.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }
}

/// Device descriptor for `adapter`: default limits, with buffers as large as it allows.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let offered = adapter.limits();
    wgpu::DeviceDescriptor {
        label: Some("vanecut"),
        required_limits: wgpu::Limits {
            max_buffer_size: offered.max_buffer_size,
            max_storage_buffer_binding_size: offered.max_storage_buffer_binding_size,
            ..wgpu::Limits::default()
        },
        ..Default::default()
    }
}

/// Picks the adapter to use: a discrete card, else an integrated one, else the software driver; Vulkan only.
/// [`GPU_VARIABLE`] set to `software` allows only the software driver.
///
/// # Errors
/// [`GpuError::NoVulkan`] or [`GpuError::NoSoftware`] when no adapter is suitable,
/// [`GpuError::UnknownChoice`] when the variable has another value.
pub fn pick_adapter(adapters: &[wgpu::Adapter]) -> Result<wgpu::Adapter, GpuError> {
    let software = match std::env::var(GPU_VARIABLE) {
        Ok(value) if value == "software" => true,
        Ok(value) if !value.is_empty() => return Err(GpuError::UnknownChoice(value)),
        _ => false,
    };
    pick(adapters, software)
}

/// Picks the software driver, whatever other adapters there are.
///
/// # Errors
/// [`GpuError::NoVulkan`] when no Vulkan driver is installed, [`GpuError::NoSoftware`] when none is a
/// software driver.
pub fn pick_software(adapters: &[wgpu::Adapter]) -> Result<wgpu::Adapter, GpuError> {
    pick(adapters, true)
}

fn pick(adapters: &[wgpu::Adapter], software: bool) -> Result<wgpu::Adapter, GpuError> {
    let best = adapters
        .iter()
        .filter_map(|adapter| {
            let info = adapter.get_info();
            Some((rank(info.backend, info.device_type, software)?, adapter))
        })
        .min_by_key(|(rank, _)| *rank);
    match best {
        Some((_, adapter)) => Ok(adapter.clone()),
        None if software && adapters.iter().any(|a| a.get_info().backend == wgpu::Backend::Vulkan) => {
            Err(GpuError::NoSoftware)
        }
        None => Err(GpuError::NoVulkan),
    }
}

/// Rank of an adapter, best first; `None` if it must not be used.
fn rank(backend: wgpu::Backend, device_type: wgpu::DeviceType, software: bool) -> Option<u8> {
    if backend != wgpu::Backend::Vulkan || (software && device_type != wgpu::DeviceType::Cpu) {
        return None;
    }
    Some(match device_type {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::{Backend, DeviceType};

    #[test]
    fn real_cards_come_before_software_and_gl_is_never_taken() {
        let order =
            [DeviceType::DiscreteGpu, DeviceType::IntegratedGpu, DeviceType::VirtualGpu, DeviceType::Cpu];
        let ranks = order.map(|t| rank(Backend::Vulkan, t, false).expect("usable"));
        assert!(ranks.is_sorted(), "{ranks:?}");
        assert_eq!(rank(Backend::Gl, DeviceType::DiscreteGpu, false), None, "GL draws other pixels");
        assert_eq!(rank(Backend::Vulkan, DeviceType::DiscreteGpu, true), None, "software was asked for");
        assert!(rank(Backend::Vulkan, DeviceType::Cpu, true).is_some(), "software was asked for");
    }

    #[test]
    fn a_lost_device_says_so_once() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        gpu.device.destroy();
        gpu.device.poll(wgpu::PollType::Poll).expect("polls");
        let errors = gpu.take_errors();
        assert!(errors.len() == 1 && errors[0].starts_with(DEVICE_LOST_PREFIX), "{errors:?}");
    }

    #[test]
    fn errors_are_recorded_and_do_not_panic() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let _ = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("wrong on purpose"),
            size: 16,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE,
            mapped_at_creation: false,
        });
        let errors = gpu.take_errors();
        assert_eq!(errors.len(), 1, "{errors:?}");
        assert!(gpu.take_errors().is_empty(), "taken once");
    }
}
