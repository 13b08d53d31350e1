//! The 3D picture: the renderer draws into a texture of our own, egui shows it as an image, and nothing
//! is drawn again while nothing changed.

use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use egui::{TextureId, Vec2};
use glam::Vec3;

use crate::gpu::camera::Camera;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::renderer::Renderer;
use crate::gpu::scene::{Scene, SceneOptions};
use crate::gpu::view::Framing;
use crate::residual::FloorGrid;

use super::planned::{Planned, Side};
use super::view3d::Hit;

/// Everything a picture depends on besides what is loaded.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    camera: Camera,
    options: SceneOptions,
    size: [u32; 2],
    samples: u32,
    generation: u64,
}

/// The picture.
pub struct Picture {
    egui: RenderState,
    gpu: Gpu,
    /// Built when first needed: the window stands before the pipelines do.
    renderer: Option<Renderer>,
    scene: Option<Scene>,
    /// What the scene's floor shows, for the value under the cursor.
    floor: Option<(Arc<FloorGrid>, Vec<f32>)>,
    /// What egui knows the picture as, and which of the renderer's textures that is.
    texture: Option<(TextureId, u64)>,
    drawn: Option<Look>,
    generation: u64,
}

impl Picture {
    /// A picture on the window's device; builds nothing yet.
    pub fn new(egui: &RenderState) -> Self {
        let gpu = Gpu::from_parts(egui.device.clone(), egui.queue.clone(), egui.adapter.get_info());
        Self {
            egui: egui.clone(),
            gpu,
            renderer: None,
            scene: None,
            floor: None,
            texture: None,
            drawn: None,
            generation: 0,
        }
    }

    /// Name of the device for the status bar.
    pub fn device_name(&self) -> String {
        if self.gpu.is_software() { "software Vulkan".to_owned() } else { self.gpu.info.name.clone() }
    }

    /// Loads a part.
    pub fn set_part(&mut self, mesh: PartMesh) {
        self.scene = Some(Scene::from_mesh(&self.gpu, mesh));
        self.floor = None;
        self.generation += 1;
    }

    /// Loads one side of a plan, or none.
    pub fn set_plan(&mut self, planned: Option<(&Planned, Side)>) {
        let Some(scene) = &mut self.scene else { return };
        let plan = planned.map(|(planned, side)| planned.plan(side));
        scene.set_plan(plan);
        let field = planned.map(|(planned, side)| &planned.result(side).field.heights);
        let grid = planned.map(|(planned, _)| &planned.outcome.grid);
        scene.set_floor(&self.gpu, grid.zip(field).map(|(grid, field)| (&**grid, field.as_slice())), plan);
        self.floor = grid.zip(field).map(|(grid, field)| (Arc::clone(grid), field.clone()));
        self.generation += 1;
    }

    /// What the standard views aim at; `None` while no part is loaded.
    pub fn framing(&self) -> Option<&Framing> {
        self.scene.as_ref().map(Scene::framing)
    }

    /// The image to show for a view of `size` physical pixels; draws only if something changed. While
    /// `moving`, with one sample per pixel: a fast picture beats a smooth one under the hand.
    pub fn show(
        &mut self,
        camera: Camera,
        options: SceneOptions,
        size: [u32; 2],
        moving: bool,
    ) -> Option<TextureId> {
        let scene = self.scene.as_ref()?;
        let samples = if moving { 1 } else { 4 };
        let look = Look { camera, options, size, samples, generation: self.generation };
        if self.drawn == Some(look) {
            return self.texture.map(|(id, _)| id);
        }
        let renderer = self.renderer.get_or_insert_with(|| Renderer::new(&self.gpu));
        renderer.render(&self.gpu, scene, &camera, &options, size.into(), samples);
        self.drawn = Some(look);
        let view = renderer.view()?;
        let (device, filter) = (&self.egui.device, wgpu::FilterMode::Nearest);
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

    /// Whether there is a picture at all.
    pub fn has_drawn(&self) -> bool {
        self.drawn.is_some()
    }

    /// Whether the picture on the screen is the fast one.
    pub fn is_draft(&self) -> bool {
        self.drawn.is_some_and(|look| look.samples < 4)
    }

    /// Waits until the device has drawn what it was given; for measuring only.
    pub fn wait(&self) {
        // A device that fails says so in its errors; there is nothing to measure then.
        let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
    }

    /// The picture as it was last shown: width, height, RGBA.
    ///
    /// # Errors
    /// [`GpuError`] when nothing was drawn yet or the device fails.
    pub fn read(&self) -> Result<(u32, u32, Vec<u8>), GpuError> {
        let nothing = || GpuError::Failed("no picture was drawn yet".to_owned());
        let picture = self.renderer.as_ref().ok_or_else(nothing)?.read_rgba(&self.gpu)?;
        Ok((picture.width, picture.height, picture.rgba))
    }

    /// What is at a place of the view, in points from its corner.
    pub fn hit(&self, camera: &Camera, options: &SceneOptions, at: glam::Vec2, size: Vec2) -> Hit {
        let Some(scene) = &self.scene else { return Hit::default() };
        let Some(pick) = scene.pick(camera, options, at, glam::vec2(size.x, size.y)) else {
            return Hit::default();
        };
        Hit { point: Some(pick.point), stock: self.stock_at(pick.point), position: pick.position }
    }

    /// Stock on the hub at a point of the hub, mm.
    fn stock_at(&self, point: Vec3) -> Option<f32> {
        let (grid, heights) = self.floor.as_ref()?;
        // Every fourth cell either way finds the neighbourhood; the best cell is one of those around.
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
        // Further away than a few cells, the point is on another part of the wheel.
        let near = 16.0 * grid.areas[cell].max(1e-6);
        (far(cell) <= near && grid.floor[cell]).then(|| heights[cell]).filter(|h| h.is_finite())
    }

    /// Faults the device reported since the last look.
    pub fn take_errors(&self) -> Vec<String> {
        self.gpu.take_errors()
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        if let Some((id, _)) = self.texture {
            self.egui.renderer.write().free_texture(&id);
        }
    }
}
