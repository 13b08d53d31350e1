//! The 3D pictures: the renderer draws into its own texture, which egui shows as an image; unchanged pictures
//! are not drawn again. Each side has its own picture, created when it is first shown.

use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use egui::{TextureId, Vec2};
use glam::Vec3;

use crate::gpu::camera::Camera;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::flank::{self, FlankColours};
use crate::gpu::floor::value_mesh;
use crate::gpu::mesh::{Mesh, Segment};
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::renderer::{Picture as Pixels, Renderer, draft_size};
use crate::gpu::scene::{Scene, SceneOptions};
use crate::gpu::view::ViewTargets;
use crate::io::flank_file::{shown_passes, shown_walls};
use crate::job::flank::FlankOutcome;
use crate::part::Impeller;
use crate::setup::AxisPolicy;
use crate::stock::FloorGrid;

use super::planned::{DisplayPlan, Side};
use super::preview::PreviewCutters;
use super::view3d::ViewHit;

/// Values on the floor of the current channel.
#[derive(Clone, Debug)]
pub enum FloorValues {
    /// Residual stock of the whole plan.
    Final,
    /// Stock after part of the positions: heights per cell, mm.
    Heights(Arc<Vec<f32>>),
    /// Residual stock minus that of another policy's plan.
    MoreThan(AxisPolicy),
}

/// Content of a picture besides the part.
#[derive(Clone, Debug)]
pub struct Content {
    /// The set of plans.
    pub planned: Arc<DisplayPlan>,
    /// Policy of the shown plan.
    pub policy: AxisPolicy,
    /// Values on the floor.
    pub floor: FloorValues,
}

impl PartialEq for Content {
    /// Plans and heights are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        let floor = match (&self.floor, &other.floor) {
            (FloorValues::Final, FloorValues::Final) => true,
            (FloorValues::Heights(a), FloorValues::Heights(b)) => Arc::ptr_eq(a, b),
            (FloorValues::MoreThan(a), FloorValues::MoreThan(b)) => a == b,
            _ => false,
        };
        floor && self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }
}

/// Meshes of a part: fine for still pictures, coarse while the camera moves.
#[derive(Clone, Debug)]
pub struct PartMeshes {
    fine: Arc<PartMesh>,
    draft: Arc<PartMesh>,
}

impl PartMeshes {
    /// Tessellates a part.
    pub fn new(part: &Impeller) -> Self {
        Self { fine: Arc::new(PartMesh::new(part)), draft: Arc::new(PartMesh::draft(part)) }
    }
}

/// The pictures of both sides, on the window's device.
pub struct Pictures {
    egui: RenderState,
    gpu: Gpu,
    mesh: Option<PartMeshes>,
    sides: [Option<SidePicture>; 2],
}

impl Pictures {
    /// Pictures on the window's device; allocates nothing yet.
    pub fn new(egui: &RenderState) -> Self {
        let gpu = Gpu::from_parts(egui.device.clone(), egui.queue.clone(), egui.adapter.get_info());
        Self { egui: egui.clone(), gpu, mesh: None, sides: [None, None] }
    }

    /// Name of the device for the status bar.
    pub fn device_name(&self) -> String {
        if self.gpu.is_software() { "software Vulkan".to_owned() } else { self.gpu.info.name.clone() }
    }

    /// Loads a part.
    pub fn set_part(&mut self, mesh: PartMeshes) {
        self.mesh = Some(mesh);
        self.sides = [None, None];
    }

    /// The meshes of the loaded part.
    pub fn mesh(&self) -> Option<&PartMeshes> {
        self.mesh.as_ref()
    }

    /// Framing of the standard views; `None` while no part is loaded.
    pub fn framing(&self) -> Option<&ViewTargets> {
        let with_sections = self.sides.iter().flatten().map(|picture| picture.scene.framing());
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
        let slot = &mut self.sides[side as usize];
        if slot.is_none() {
            *slot = Some(SidePicture::new(&self.egui, &self.gpu, self.mesh.as_ref()?));
        }
        slot.as_mut()
    }

    /// A picture of triangles that are not yet a part.
    pub fn picture_of_mesh(&self, mesh: PartMesh) -> SidePicture {
        let mesh = Arc::new(mesh);
        SidePicture::new(&self.egui, &self.gpu, &PartMeshes { fine: Arc::clone(&mesh), draft: mesh })
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

/// Inputs of a drawn picture; a picture is drawn again when they change.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drawn {
    camera: Camera,
    options: SceneOptions,
    size: [u32; 2],
    samples: u32,
    generation: u64,
}

/// A picture of one side.
pub struct SidePicture {
    egui: RenderState,
    gpu: Gpu,
    /// Created at the first drawing, so that the window opens before the pipelines are built.
    renderer: Option<Renderer>,
    scene: Scene,
    content: Option<Content>,
    coming: Option<PreviewCutters>,
    flank: Option<(Arc<FlankOutcome>, FlankColours)>,
    borders: Vec<Segment>,
    /// Floor grid and its shown values, for the value under the cursor.
    floor: Option<(Arc<FloorGrid>, Vec<f32>)>,
    /// Texture id in egui, and the generation of the renderer's texture it refers to.
    texture: Option<(TextureId, u64)>,
    drawn: Option<Drawn>,
    generation: u64,
}

impl SidePicture {
    fn new(egui: &RenderState, gpu: &Gpu, mesh: &PartMeshes) -> Self {
        Self {
            egui: egui.clone(),
            gpu: gpu.clone(),
            renderer: None,
            scene: Scene::from_mesh(gpu, Arc::clone(&mesh.fine)).with_draft(gpu, &mesh.draft),
            content: None,
            coming: None,
            flank: None,
            borders: Vec::new(),
            floor: None,
            texture: None,
            drawn: None,
            generation: 0,
        }
    }

    /// Loads the content; does nothing if it is loaded already.
    pub fn load(&mut self, content: Option<Content>) {
        if self.content == content {
            return;
        }
        let same_plan =
            self.content.as_ref().zip(content.as_ref()).is_some_and(|(old, new)| {
                old.policy == new.policy && Arc::ptr_eq(&old.planned, &new.planned)
            });
        let plan = content.as_ref().map(|content| content.planned.plan(content.policy));
        if !same_plan {
            self.scene.set_plan(plan);
        }
        self.floor = content.as_ref().map(|content| {
            let planned = &content.planned;
            let left = |policy| planned.result(policy).field.heights.as_slice();
            let heights = match &content.floor {
                FloorValues::Final => left(content.policy).to_vec(),
                FloorValues::Heights(heights) => heights.to_vec(),
                FloorValues::MoreThan(other) => {
                    left(content.policy).iter().zip(left(*other)).map(|(a, b)| a - b).collect()
                }
            };
            (Arc::clone(&planned.outcome.grid), heights)
        });
        let floor = self.floor.as_ref().map(|(grid, heights)| (&**grid, heights.as_slice()));
        if self.shows_walls() {
            // Walls replace the floor; `load_flank` loads the floor again afterwards.
            self.content = content;
            self.generation += 1;
            return;
        }
        let is_heights = |content: &Option<Content>| {
            content.as_ref().is_some_and(|content| !matches!(content.floor, FloorValues::MoreThan(_)))
        };
        match (floor, content.as_ref().map(|content| &content.floor)) {
            (Some((grid, values)), Some(FloorValues::MoreThan(_))) => {
                if let Some(mesh) = value_mesh(grid, values) {
                    self.scene.set_values(&self.gpu, mesh);
                }
            }
            (Some((grid, heights)), _) if same_plan && is_heights(&self.content) => {
                self.scene.set_heights(&self.gpu, grid, heights);
            }
            (floor, _) => self.scene.set_floor(&self.gpu, floor, plan),
        }
        self.content = content;
        self.generation += 1;
    }

    /// Shows the passes of a flank plan, or none; does nothing if they are shown already.
    pub fn load_flank(&mut self, shown: Option<(Arc<FlankOutcome>, FlankColours)>) {
        let same = match (&self.flank, &shown) {
            (Some((a, colours)), Some((b, wanted))) => Arc::ptr_eq(a, b) && colours == wanted,
            (None, None) => true,
            _ => false,
        };
        if same {
            return;
        }
        let lines = shown.as_ref().map(|(outcome, colours)| {
            let plan = &outcome.plan;
            flank::toolpath_lines(&shown_passes(plan), &plan.moves, plan.layout.layers.len(), *colours)
        });
        self.scene.set_paths(&self.gpu, &lines.unwrap_or_default());
        if self.shows_walls() {
            // Forces the floor to be loaded again.
            self.scene.set_floor(&self.gpu, None, None);
            self.content = None;
        }
        self.flank = shown;
        if let Some((outcome, _)) = self.flank.as_ref().filter(|_| self.shows_walls()) {
            let (mesh, _) = flank::wall_deviations(&outcome.part, &shown_walls(&outcome.plan));
            self.scene.set_values(&self.gpu, mesh);
        }
        self.generation += 1;
    }

    /// Draws a mesh over the scene, coloured by its values; `None` removes it.
    pub fn highlight(&mut self, mesh: Option<Mesh>) {
        match mesh {
            Some(mesh) => self.scene.set_values(&self.gpu, mesh),
            None => self.scene.set_floor(&self.gpu, None, None),
        }
        self.generation += 1;
    }

    /// Framing of the standard views.
    pub fn framing(&self) -> &ViewTargets {
        self.scene.framing()
    }

    /// Shows the preview cutters of a running plan instead of the plan's; `None`: no preview.
    pub fn load_preview(&mut self, coming: Option<&PreviewCutters>) {
        let same = match (&self.coming, coming) {
            (Some(a), Some(b)) => Arc::ptr_eq(&a.plan, &b.plan) && a.is_checked == b.is_checked,
            (None, None) => true,
            _ => false,
        };
        if !same {
            self.scene.set_preview(coming.map(|c| &*c.plan), coming.is_some_and(|c| c.is_checked));
            self.coming = coming.cloned();
            self.generation += 1;
        }
    }

    /// Shows section borders as lines on the floor.
    pub fn load_borders(&mut self, lines: Vec<Segment>) {
        if self.borders != lines {
            self.scene.set_borders(&self.gpu, &lines);
            self.borders = lines;
            self.generation += 1;
        }
    }

    fn shows_walls(&self) -> bool {
        self.flank.as_ref().is_some_and(|(_, colours)| *colours == FlankColours::Walls)
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
        let samples = if moving { 1 } else { 4 };
        let options = SceneOptions { draft: moving, ..options };
        let whole = size;
        let size = if moving { draft_size(&self.gpu, size.into()).to_array() } else { size };
        let coarse = size != whole;
        let look = Drawn { camera, options, size, samples, generation: self.generation };
        if self.drawn == Some(look) {
            return self.texture.map(|(id, _)| id);
        }
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu));
        renderer.render(&self.gpu, &self.scene, &camera, &options, size.into(), samples);
        self.drawn = Some(look);
        let view = renderer.view()?;
        let filter = if coarse { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
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
        self.texture.map(|(id, _)| id)
    }

    /// Whether anything was drawn yet.
    pub fn has_drawn(&self) -> bool {
        self.drawn.is_some()
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
        let on_hub = !pick.on_section && !self.shows_walls();
        let stock = if on_hub { self.stock_at(pick.point) } else { None };
        ViewHit { point: Some(pick.point), stock, deviation: pick.value, position: pick.position }
    }

    /// Stock on the hub near `point`, mm; `None` off the channel floor.
    pub fn stock_at(&self, point: Vec3) -> Option<f32> {
        let (grid, heights) = self.floor.as_ref()?;
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
        (far(cell) <= near && grid.floor[cell]).then(|| heights[cell]).filter(|h| h.is_finite())
    }
}

impl Drop for SidePicture {
    fn drop(&mut self) {
        if let Some((id, _)) = self.texture {
            self.egui.renderer.write().free_texture(&id);
        }
    }
}
