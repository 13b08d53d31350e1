//! The pictures of both sides, on the device of the window. Each side has its own, created when it is first
//! shown.

use std::cell::OnceCell;
use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use glam::Vec3;

use crate::app::model::planned::{PerSide, Side};
use crate::app::tasks::part_meshes::PartMeshes;
use crate::app::views::picture::SidePicture;
use crate::gpu::device::Gpu;
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::residual::ResidualKernel;
use crate::gpu::view::ViewTargets;

/// What computes the stock that the views draw.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PreviewSource {
    /// The compute kernel on the graphics device, from whose buffer the floor is drawn.
    #[default]
    Device,
    /// The core, whose heights are uploaded.
    Core,
}

/// Environment variable; `cpu` makes the core compute the stock that the views draw.
const PREVIEW_VARIABLE: &str = "VANECUT_PREVIEW";

/// The pictures of both sides, on the window's device.
pub struct Pictures {
    egui: RenderState,
    gpu: Gpu,
    mesh: Option<PartMeshes>,
    sides: PerSide<Option<SidePicture>>,
    source: PreviewSource,
    /// Whether pictures are only drawn by [`Self::draw_waiting`].
    wait: bool,
    /// The kernel, compiled when the first part is shown; `None` inside if the device rejected it.
    kernel: OnceCell<Option<Arc<ResidualKernel>>>,
}

impl Pictures {
    /// Pictures on the window's device; allocates nothing yet.
    pub fn new(egui: &RenderState) -> Self {
        let gpu = Gpu::from_parts(egui.device.clone(), egui.queue.clone(), egui.adapter.get_info());
        let wants_core = std::env::var_os(PREVIEW_VARIABLE).is_some_and(|value| value == "cpu");
        let source = if wants_core { PreviewSource::Core } else { PreviewSource::Device };
        Self {
            egui: egui.clone(),
            gpu,
            mesh: None,
            sides: PerSide::default(),
            source,
            wait: false,
            kernel: OnceCell::new(),
        }
    }

    /// What computes the drawn stock, for the status bar.
    pub fn preview_name(&self) -> String {
        let rejected = matches!(self.kernel.get(), Some(None));
        let failed = self.sides.iter().flatten().any(|picture| !picture.draws_device_stock());
        if self.source == PreviewSource::Core || rejected || failed {
            return "Preview: CPU".to_owned();
        }
        // Drivers append versions in brackets.
        let name = &self.gpu.info.name;
        format!("Preview: GPU ({})", name.split(" (").next().unwrap_or(name))
    }

    /// Name and driver of the device.
    pub fn device_name(&self) -> String {
        let info = &self.gpu.info;
        format!("{}, {} {}", info.name, info.driver, info.driver_info).trim_end_matches([' ', ',']).to_owned()
    }

    /// Sets what computes the drawn stock.
    pub fn set_preview_source(&mut self, source: PreviewSource) {
        self.source = source;
        self.sides = PerSide::default();
    }

    /// From now on pictures are only drawn by [`Self::draw_waiting`]: those of a window that is seldom looked
    /// at.
    pub fn wait_to_draw(&mut self) {
        self.wait = true;
        for picture in self.sides.iter_mut().flatten() {
            picture.wait();
        }
    }

    /// Draws the pictures that wait.
    pub fn draw_waiting(&mut self) {
        for picture in self.sides.iter_mut().flatten() {
            picture.draw_waiting();
        }
    }

    /// The kernel, if it is to draw.
    fn kernel(&self) -> Option<Arc<ResidualKernel>> {
        if self.source == PreviewSource::Core {
            return None;
        }
        self.kernel.get_or_init(|| ResidualKernel::new(&self.gpu).ok().map(Arc::new)).clone()
    }

    /// Loads a part.
    pub fn set_part(&mut self, mesh: PartMeshes) {
        self.mesh = Some(mesh);
        self.sides = PerSide::default();
    }

    /// The meshes of the loaded part.
    pub fn mesh(&self) -> Option<&PartMeshes> {
        self.mesh.as_ref()
    }

    /// Framing of the standard views; `None` while no part is loaded.
    pub fn framing(&self) -> Option<&ViewTargets> {
        let with_sections = self.sides.iter().flatten().map(|picture| picture.framing());
        with_sections
            .max_by_key(|framing| framing.sections.len())
            .or(self.mesh.as_ref().map(|m| &m.fine.framing))
    }

    /// Points across the floor of the current channel at `s`, with their normals; `None` while no part is
    /// loaded.
    pub fn floor_line(&self, s: f64) -> Option<Vec<(Vec3, Vec3)>> {
        self.mesh.as_ref().map(|mesh| mesh.fine.floor_line(s)).filter(|line| !line.is_empty())
    }

    /// The picture of a side; `None` while no part is loaded.
    pub fn side(&mut self, side: Side) -> Option<&mut SidePicture> {
        if self.sides[side].is_none() {
            let mesh = self.mesh.as_ref()?;
            let mut picture = SidePicture::new(&self.egui, &self.gpu, mesh, self.kernel());
            if self.wait {
                picture.wait();
            }
            self.sides[side] = Some(picture);
        }
        self.sides[side].as_mut()
    }

    /// A picture of triangles that are not yet a part.
    pub fn picture_of_mesh(&self, mesh: PartMesh) -> SidePicture {
        let mesh = Arc::new(mesh);
        let meshes = PartMeshes { fine: Arc::clone(&mesh), draft: mesh };
        SidePicture::new(&self.egui, &self.gpu, &meshes, None)
    }

    /// Errors that the device reported since the last call. Polls it first, to detect a loss before drawing.
    pub fn take_errors(&self) -> Vec<String> {
        // A failing device reports it through its errors.
        let _ = self.gpu.device.poll(wgpu::PollType::Poll);
        self.gpu.take_errors()
    }

    /// Waits until the device has finished drawing; used for timing only.
    pub fn wait(&self) {
        // A failing device reports it through its errors.
        let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
    }
}
