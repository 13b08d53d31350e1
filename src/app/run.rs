//! Starting the window: Vulkan only, hardware before the software driver, and a readable error if there is no
//! display or no Vulkan.

use std::path::PathBuf;
use std::sync::Arc;

use eframe::{CreationContext, egui_wgpu};
use egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};

use crate::error::{ErrorCode, UserError};
use crate::gpu::device::{device_descriptor, pick_adapter, pick_software};

use super::App;
use super::control::handover::RecoverySlot;
use super::tasks::engine::Engine;

/// Application id: name of the data folder and of the window to the desktop.
const APP_ID: &str = "vanecut";

/// Reason why the window did not open.
#[derive(Debug, thiserror::Error)]
#[error("{}", self.explained())]
pub enum AppError {
    /// Neither an X11 nor a Wayland display is set.
    NoDisplay,
    /// The display does not respond.
    DeadDisplay(String),
    /// No usable Vulkan driver.
    NoVulkan(String),
    /// Any other error of the window system.
    Window(String),
    /// The device was lost, and the window did not open again.
    Lost {
        /// Error message of the device.
        reason: String,
        /// Reason why the window did not open.
        error: String,
    },
}

impl AppError {
    /// What is wrong and what to do.
    pub fn explained(&self) -> UserError {
        let (what, help) = match self {
            Self::NoDisplay => (
                "no display for the window".to_owned(),
                "set DISPLAY or WAYLAND_DISPLAY, or use the commands without a window (vanecut help)",
            ),
            Self::DeadDisplay(display) => (
                format!("the display {display} cannot be opened"),
                "check DISPLAY or WAYLAND_DISPLAY, or use the commands without a window (vanecut help)",
            ),
            Self::NoVulkan(error) => (
                format!("Vulkan does not start ({error})"),
                "install a driver (on Debian: apt install libvulkan1 mesa-vulkan-drivers)",
            ),
            Self::Window(error) => {
                (format!("the window does not open ({error})"), "see the README for the packages it needs")
            }
            Self::Lost { reason, error } => (
                format!(
                    "the graphics device was lost ({reason}), and the window does not open again ({error})"
                ),
                "the next start offers to recover unsaved changes",
            ),
        };
        UserError::new(ErrorCode::GraphicsDevice, what, help)
    }
}

impl From<AppError> for UserError {
    fn from(error: AppError) -> Self {
        error.explained()
    }
}

/// Opens the window with the file `initial`, and returns when it is closed. When the graphics device is lost,
/// the window opens once more with the software driver and the same state.
///
/// # Errors
/// [`AppError`] when there is no display, no Vulkan, or the window system refuses.
pub fn run(initial: Option<PathBuf>) -> Result<(), AppError> {
    let start = std::time::Instant::now();
    if cfg!(target_os = "linux") && !has_display() {
        return Err(AppError::NoDisplay);
    }
    let way_out = RecoverySlot::default();
    let leave_by = way_out.clone();
    open(None, false, move |cc| {
        let mut app = App::new(cc);
        app.set_start_time(start);
        app.set_recovery_slot(leave_by);
        if let Some(folder) = eframe::storage_dir(APP_ID) {
            app.set_home(folder);
            app.offer_tour();
        }
        if let Some(path) = initial {
            app.open_path(path);
        }
        app
    })?;
    let Some(left) = way_out.take() else { return Ok(()) };
    let reason = left.reason().to_owned();
    eprintln!(
        "vanecut: the graphics device was lost ({reason}); the window opens again with the software driver"
    );
    let again = open(left.size(), true, move |cc| App::resumed(cc, Engine::default(), left));
    again.map_err(|error| AppError::Lost { reason, error: error.to_string() })
}

/// Opens a window of `size` points, with the software driver if `software`, and returns when it is closed.
fn open(
    size: Option<egui::Vec2>,
    software: bool,
    app: impl FnOnce(&CreationContext<'_>) -> App + 'static,
) -> Result<(), AppError> {
    let viewport = egui::ViewportBuilder::default()
        .with_app_id(APP_ID)
        .with_title("Vanecut")
        .with_inner_size(size.unwrap_or(egui::vec2(1280.0, 800.0)))
        .with_min_inner_size([800.0, 500.0]);
    let wgpu_options =
        WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(wgpu_setup(software)), ..Default::default() };
    let options = eframe::NativeOptions { viewport, wgpu_options, ..Default::default() };
    let create = Box::new(move |cc: &CreationContext<'_>| Ok(Box::new(app(cc)) as Box<dyn eframe::App>));
    eframe::run_native("Vanecut", options, create).map_err(|error| match error {
        eframe::Error::Wgpu(error) => AppError::NoVulkan(error.to_string()),
        eframe::Error::WinitEventLoop(_) => AppError::DeadDisplay(display()),
        error => AppError::Window(error.to_string()),
    })
}

fn has_display() -> bool {
    !display().is_empty()
}

/// Display that the environment names; empty if none.
fn display() -> String {
    let named = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].iter().filter_map(std::env::var_os);
    let named: Vec<String> = named.map(|value| value.to_string_lossy().into_owned()).collect();
    named.into_iter().find(|value| !value.is_empty()).unwrap_or_default()
}

/// Device setup for Vulkan only: without a Vulkan driver eframe would silently use OpenGL, which draws
/// different pixels and has no compute shaders.
fn wgpu_setup(software: bool) -> WgpuSetupCreateNew {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::VULKAN;
    setup.native_adapter_selector = Some(Arc::new(move |adapters, surface| {
        let fits = |adapter: &&wgpu::Adapter| surface.is_none_or(|s| adapter.is_surface_supported(s));
        let fitting: Vec<wgpu::Adapter> = adapters.iter().filter(fits).cloned().collect();
        let pick = if software { pick_software } else { pick_adapter };
        pick(&fitting).map_err(|error| error.to_string())
    }));
    setup.device_descriptor = Arc::new(device_descriptor);
    setup
}
