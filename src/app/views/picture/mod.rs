//! A 3D picture: the renderer draws into its own texture, which egui shows as an image; an unchanged picture
//! is not drawn again.

mod coloured;
mod content;
mod load;
mod shown_flank;

use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use egui::{TextureId, Vec2};
use glam::Vec3;

use crate::app::model::checked::CheckedProgram;
use crate::app::model::machine::ShownMachine;
use crate::app::model::preview::ShownCutters;
use crate::app::model::solid::SolidColours;
use crate::app::tasks::part_meshes::PartMeshes;
use crate::app::tasks::solid::SolidPicture;
use crate::app::views::view3d::ViewHit;
use crate::drawing::flank::FlankColours;
use crate::gpu::camera::Camera;
use crate::gpu::cutters::DrawnChannel;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::mesh::Segment;
use crate::gpu::renderer::{Picture as Pixels, Renderer, draft_size};
use crate::gpu::residual::ResidualKernel;
use crate::gpu::scene::{Scene, SceneOptions};
use crate::gpu::stock_floor::{StockFloor, StockState};
use crate::gpu::view::ViewTargets;
use coloured::ColouredCutters;
pub use content::Content;
pub use shown_flank::ShownFlank;

/// Rays that the kernel may intersect with cutters for a picture in motion on a software driver. Meant for 30
/// pictures a second on two cores; `vanecut bench` prints meetings and times of each resolution.
const MEETINGS_IN_MOTION: usize = 2_000_000;

/// Inputs of a drawn picture; a picture is drawn again when they change.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drawn {
    camera: Camera,
    options: SceneOptions,
    size: [u32; 2],
    samples: u32,
    generation: u64,
}

/// A picture that is drawn when it is looked at.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    camera: Camera,
    options: SceneOptions,
    size: [u32; 2],
    moving: bool,
}

/// A picture of one side.
pub struct SidePicture {
    egui: RenderState,
    gpu: Gpu,
    /// Created at the first drawing, so that the window opens before the pipelines are built.
    renderer: Option<Renderer>,
    scene: Scene,
    content: Option<Content>,
    preview: Option<ShownCutters>,
    flank: Option<ShownFlank>,
    program: Option<Arc<CheckedProgram>>,
    borders: Vec<Segment>,
    channels: Vec<DrawnChannel>,
    /// Colours of the cutters, and which are left out.
    coloured: Option<ColouredCutters>,
    /// The stock as a solid.
    solid: Option<Arc<SolidPicture>>,
    /// The machine that is drawn.
    machine: Option<ShownMachine>,
    /// Computes and draws the stock on the device; `None` where the core's heights are drawn.
    stock_floor: Option<StockFloor>,
    /// Texture id in egui, and the generation of the renderer's texture it refers to.
    texture: Option<(TextureId, u64)>,
    drawn: Option<Drawn>,
    /// Whether pictures wait for [`Self::draw_waiting`], and the one that does.
    waits: bool,
    waiting: Option<Waiting>,
    generation: u64,
}

impl SidePicture {
    pub(super) fn new(
        egui: &RenderState,
        gpu: &Gpu,
        mesh: &PartMeshes,
        kernel: Option<Arc<ResidualKernel>>,
    ) -> Self {
        Self {
            egui: egui.clone(),
            gpu: gpu.clone(),
            renderer: None,
            scene: Scene::new(gpu, Arc::clone(&mesh.fine)).with_draft(gpu, &mesh.draft),
            content: None,
            preview: None,
            flank: None,
            program: None,
            borders: Vec::new(),
            channels: Vec::new(),
            coloured: None,
            solid: None,
            machine: None,
            stock_floor: kernel.map(StockFloor::new),
            texture: None,
            drawn: None,
            waits: false,
            waiting: None,
            generation: 0,
        }
    }

    /// From now on a picture is only drawn by [`Self::draw_waiting`].
    pub(super) fn wait(&mut self) {
        self.waits = true;
    }

    /// Draws the picture that waits, if one does.
    pub(super) fn draw_waiting(&mut self) {
        if let Some(Waiting { camera, options, size, moving }) = self.waiting.take() {
            self.draw(camera, options, size, moving);
        }
    }

    /// Submits the computation of the stock on the device, for a picture that is drawn next. A device that
    /// cannot do it leaves the picture to the core.
    fn compute_stock(&mut self, moving: bool) {
        let Some(floor) = &mut self.stock_floor else { return };
        let last = self.content.as_ref().and_then(Content::stock_states);
        // Cutters of a running plan, over the floor of the plan that is shown.
        let preview = self.preview.as_ref().and_then(|preview| preview.program.clone()).filter(|program| {
            last.as_ref().is_some_and(|(last, _)| Arc::ptr_eq(&program.floor, &last.program.floor))
        });
        let states = match preview {
            Some(program) => Some((StockState { count: program.cutters.len(), program }, None)),
            None => last,
        };
        let Some((state, less)) = states else {
            self.scene.set_stock(None);
            return;
        };
        let finest = state.program.floor.finest();
        let level = if moving && self.gpu.is_software() {
            state.program.finest_within(MEETINGS_IN_MOTION)
        } else {
            finest
        };
        match floor.show(&self.gpu, level, &state, less.as_ref()) {
            Ok(stock) => self.scene.set_stock(stock),
            Err(_) => {
                // Loaded again in the next frame, with the heights of the core.
                (self.stock_floor, self.content) = (None, None);
                self.scene.set_stock(None);
                self.generation += 1;
            }
        }
    }

    /// Grows with every change of what is drawn, apart from camera and options.
    pub fn generation(&self) -> u64 {
        self.generation
    }

    /// Framing of the standard views.
    pub fn framing(&self) -> &ViewTargets {
        self.scene.framing()
    }

    fn shows_walls(&self) -> bool {
        self.flank.as_ref().is_some_and(|flank| flank.colours == FlankColours::Walls)
    }

    /// The image for a view of `size` physical pixels; draws only if something changed. While `moving`, it
    /// draws a coarse mesh without anti-aliasing, for speed.
    pub fn show(
        &mut self,
        camera: Camera,
        options: SceneOptions,
        size: [u32; 2],
        moving: bool,
    ) -> Option<TextureId> {
        if !self.waits {
            return self.draw(camera, options, size, moving);
        }
        self.waiting = Some(Waiting { camera, options, size, moving });
        if self.texture.is_none() {
            self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu)).reserve(&self.gpu, size.into());
            self.register_texture(wgpu::FilterMode::Nearest);
        }
        self.texture.map(|(id, _)| id)
    }

    fn draw(
        &mut self,
        camera: Camera,
        options: SceneOptions,
        size: [u32; 2],
        moving: bool,
    ) -> Option<TextureId> {
        let samples = if moving { 1 } else { 4 };
        let options = SceneOptions { draft: moving, ..options };
        let whole = size;
        let size = if moving { draft_size(&self.gpu, size.into()).to_array() } else { size };
        let coarse = size != whole;
        let look = Drawn { camera, options, size, samples, generation: self.generation };
        if self.drawn == Some(look) {
            return self.texture.map(|(id, _)| id);
        }
        self.compute_stock(moving);
        let look = Drawn { generation: self.generation, ..look };
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu));
        renderer.render(&self.gpu, &self.scene, &camera, &options, size.into(), samples);
        self.drawn = Some(look);
        self.register_texture(if coarse { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest });
        self.texture.map(|(id, _)| id)
    }

    /// Tells egui of the texture of the renderer, unless it knows it.
    fn register_texture(&mut self, filter: wgpu::FilterMode) {
        let Some(renderer) = &self.renderer else { return };
        let Some(view) = renderer.view() else { return };
        let device = &self.egui.device;
        let mut egui = self.egui.renderer.write();
        let id = match self.texture {
            Some((id, of)) if of == renderer.generation() => id,
            Some((id, _)) => {
                egui.update_egui_texture_from_wgpu_texture(device, view, filter, id);
                id
            }
            None => egui.register_native_texture(device, view, filter),
        };
        self.texture = Some((id, renderer.generation()));
    }

    /// Whether anything was drawn yet, or waits to be.
    pub fn has_drawn(&self) -> bool {
        self.drawn.is_some() || self.waiting.is_some()
    }

    /// Whether the stock that is drawn is computed on the device.
    pub fn draws_device_stock(&self) -> bool {
        self.stock_floor.is_some()
    }

    /// Whether the processor draws.
    pub fn is_on_software(&self) -> bool {
        self.gpu.is_software()
    }

    /// Whether the last picture was drawn coarsely.
    pub fn is_draft(&self) -> bool {
        self.drawn.is_some_and(|look| look.samples < 4)
    }

    /// The view drawn finely at `size` pixels.
    ///
    /// # Errors
    /// [`GpuError`] when the device fails.
    pub fn export(
        &mut self,
        camera: &Camera,
        options: &SceneOptions,
        size: [u32; 2],
    ) -> Result<Pixels, GpuError> {
        self.compute_stock(false);
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu));
        renderer.render(&self.gpu, &self.scene, camera, options, size.into(), 4);
        // The renderer replaced the texture on the screen.
        self.drawn = None;
        renderer.read_rgba(&self.gpu)
    }

    /// Index of the position whose cutter is at `at`, in points from the view's corner.
    ///
    /// # Errors
    /// [`GpuError`] when the device fails.
    pub fn pick(
        &mut self,
        camera: &Camera,
        options: &SceneOptions,
        at: glam::Vec2,
        size: Vec2,
    ) -> Result<Option<usize>, GpuError> {
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu));
        renderer.pick(&self.gpu, &self.scene, camera, options, at, glam::vec2(size.x, size.y))
    }

    /// What the ray through `at` hits, in points from the view's corner.
    pub fn hit(&self, camera: &Camera, options: &SceneOptions, at: glam::Vec2, size: Vec2) -> ViewHit {
        let Some(pick) = self.scene.pick(camera, options, at, glam::vec2(size.x, size.y)) else {
            return ViewHit::default();
        };
        // The cap of the section plane is inside the material: it has no residual stock.
        let stock = if pick.on_section || self.shows_walls() {
            None
        } else if options.show_solid && self.solid.is_some() {
            let by_value = self.solid.as_ref().is_some_and(|s| s.request.colours == SolidColours::Distance);
            pick.value.filter(|_| by_value)
        } else {
            self.stock_at(pick.point)
        };
        ViewHit { point: Some(pick.point), stock, deviation: pick.value, position: pick.position }
    }

    /// Stock on the hub near `point`, mm; `None` off the channel floor.
    pub fn stock_at(&self, point: Vec3) -> Option<f32> {
        let content = self.content.as_ref()?;
        let grid = &content.planned.outcome.grid;
        // Coarse-to-fine search for the nearest cell: every fourth cell in both directions, then those around
        // the best.
        let far = |k: usize| Vec3::from_array(grid.points[k]).distance_squared(point);
        const STRIDE: usize = 4;
        let (mut best, mut nearest) = (None, f32::INFINITY);
        for i in (0..grid.rows).step_by(STRIDE) {
            for j in (0..grid.columns).step_by(STRIDE) {
                let distance = far(i * grid.columns + j);
                if distance < nearest {
                    (best, nearest) = (Some((i, j)), distance);
                }
            }
        }
        let (i, j) = best?;
        let around = |k: usize, n: usize| k.saturating_sub(STRIDE)..(k + STRIDE + 1).min(n);
        let cells = around(i, grid.rows).flat_map(|i| around(j, grid.columns).map(move |j| (i, j)));
        let cell = cells.map(|(i, j)| i * grid.columns + j).min_by(|&a, &b| far(a).total_cmp(&far(b)))?;
        // Beyond a few cell widths the point is on another part of the wheel.
        let near = 16.0 * grid.areas[cell].max(1e-6);
        let value = content.value(cell).filter(|value| value.is_finite());
        value.filter(|_| far(cell) <= near && grid.floor[cell])
    }
}

impl Drop for SidePicture {
    fn drop(&mut self) {
        if let Some((id, _)) = self.texture {
            self.egui.renderer.write().free_texture(&id);
        }
    }
}
