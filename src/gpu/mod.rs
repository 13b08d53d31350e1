//! Device, compute kernel and renderer. Knows no window.

pub mod device;
pub mod residual;

pub use device::{Gpu, GpuError, device_descriptor, pick_adapter};
pub use residual::ResidualKernel;
