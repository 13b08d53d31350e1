//! The 3D pictures: the renderer draws into its own texture, which egui shows as an image; unchanged pictures
//! are not drawn again. Each side has its own picture, created when it is first shown.

use std::cell::OnceCell;
use std::sync::Arc;

use eframe::egui_wgpu::RenderState;
use egui::{TextureId, Vec2};
use glam::Vec3;

use crate::drawing::cutters::cutter_set;
use crate::drawing::flank::{self, FlankColours};
use crate::drawing::floor::{contact_mesh, floor_meshes, value_mesh};
use crate::gpu::camera::Camera;
use crate::gpu::device::{Gpu, GpuError};
use crate::gpu::mesh::{Mesh, Segment};
use crate::gpu::part_mesh::PartMesh;
use crate::gpu::renderer::{Picture as Pixels, Renderer, draft_size};
use crate::gpu::residual::ResidualKernel;
use crate::gpu::scene::{Scene, SceneOptions};
use crate::gpu::stock_floor::{StockFloor, StockState};
use crate::gpu::view::ViewTargets;
use crate::io::flank_file::{shown_passes, shown_walls};
use crate::job::flank::FlankOutcome;
use crate::setup::AxisPolicy;

use crate::app::model::checked::CheckedProgram;
use crate::app::model::cutter_colours::{CutterClass, CutterColours};
use crate::app::model::machine::PlanOnMachine;
use crate::app::model::planned::{DisplayPlan, PerSide, Side};
use crate::app::model::preview::ShownCutters;
use crate::app::model::solid::SolidColours;
use crate::app::tasks::part_meshes::PartMeshes;
use crate::app::tasks::solid::SolidPicture;
use crate::app::views::view3d::ViewHit;

/// Content of a picture besides the part.
#[derive(Clone, Debug)]
pub struct Content {
    /// The set of plans.
    pub planned: Arc<DisplayPlan>,
    /// Policy of the shown plan.
    pub policy: AxisPolicy,
    /// Number of positions cut; `None`: all.
    pub cut: Option<usize>,
    /// Heights of stock per cell after n positions, mm, as the core computes them; `None`: those of the
    /// whole plan.
    pub heights: Option<Arc<Vec<f32>>>,
    /// Policy whose stock is subtracted from that of the whole plan, for a difference.
    pub more_than: Option<AxisPolicy>,
}

impl Content {
    /// Whether the same is drawn, apart from where its heights come from. Plans are immutable, so pointer
    /// equality suffices.
    fn same_picture(&self, other: &Self) -> bool {
        self.same_plan(other) && self.cut == other.cut && self.more_than == other.more_than
    }

    fn same_plan(&self, other: &Self) -> bool {
        self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }

    fn same_heights(&self, other: &Self) -> bool {
        match (&self.heights, &other.heights) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }

    /// Value of a cell of the plan's grid: stock, or a difference of stock, mm.
    fn value(&self, cell: usize) -> Option<f32> {
        let left = |policy| self.planned.result(policy).field.heights.get(cell).copied();
        match (self.more_than, &self.heights) {
            (Some(other), _) => Some(left(self.policy)? - left(other)?),
            (None, Some(heights)) => heights.get(cell).copied(),
            (None, None) => left(self.policy),
        }
    }

    /// The stock to draw on the device, and the one to subtract from it.
    fn stock_states(&self) -> Option<(StockState, Option<StockState>)> {
        let whole = |policy| {
            let program = Arc::clone(self.planned.program(policy)?);
            Some(StockState { count: program.cutters.len(), program })
        };
        let shown = whole(self.policy)?;
        match self.more_than {
            Some(other) => Some((shown, Some(whole(other)?))),
            None => Some((StockState { count: self.cut.unwrap_or(shown.count), ..shown }, None)),
        }
    }
}

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

/// Rays that the kernel may intersect with cutters for a picture in motion on a software driver. Meant for 30
/// pictures a second on two cores; `vanecut bench` prints meetings and times of each resolution.
const MEETINGS_IN_MOTION: usize = 2_000_000;

/// The pictures of both sides, on the window's device.
pub struct Pictures {
    egui: RenderState,
    gpu: Gpu,
    mesh: Option<PartMeshes>,
    sides: PerSide<Option<SidePicture>>,
    source: PreviewSource,
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
            kernel: OnceCell::new(),
        }
    }

    /// What computes the drawn stock, for the status bar.
    pub fn preview_name(&self) -> String {
        let rejected = matches!(self.kernel.get(), Some(None));
        let failed = self.sides.iter().flatten().any(|picture| picture.stock_floor.is_none());
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
        if self.sides[side].is_none() {
            let mesh = self.mesh.as_ref()?;
            self.sides[side] = Some(SidePicture::new(&self.egui, &self.gpu, mesh, self.kernel()));
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

/// Inputs of a drawn picture; a picture is drawn again when they change.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Drawn {
    camera: Camera,
    options: SceneOptions,
    size: [u32; 2],
    samples: u32,
    generation: u64,
}

/// Colours of the cutters of a plan, and the classes that are left out.
#[derive(Clone, Debug)]
struct ColouredCutters {
    colours: CutterColours,
    hidden: Vec<CutterClass>,
    planned: Arc<DisplayPlan>,
    policy: AxisPolicy,
}

impl PartialEq for ColouredCutters {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        (self.colours, &self.hidden, self.policy) == (other.colours, &other.hidden, other.policy)
            && Arc::ptr_eq(&self.planned, &other.planned)
    }
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
    flank: Option<(Arc<FlankOutcome>, FlankColours)>,
    program: Option<Arc<CheckedProgram>>,
    borders: Vec<Segment>,
    /// Colours of the cutters, and which are left out.
    coloured: Option<ColouredCutters>,
    /// The stock as a solid.
    solid: Option<Arc<SolidPicture>>,
    /// The plan on the machine that is drawn, and the number of plunges cut.
    machine: Option<(Arc<PlanOnMachine>, Option<usize>)>,
    /// Computes and draws the stock on the device; `None` where the core's heights are drawn.
    stock_floor: Option<StockFloor>,
    /// Texture id in egui, and the generation of the renderer's texture it refers to.
    texture: Option<(TextureId, u64)>,
    drawn: Option<Drawn>,
    generation: u64,
}

impl SidePicture {
    fn new(egui: &RenderState, gpu: &Gpu, mesh: &PartMeshes, kernel: Option<Arc<ResidualKernel>>) -> Self {
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
            coloured: None,
            solid: None,
            machine: None,
            stock_floor: kernel.map(StockFloor::new),
            texture: None,
            drawn: None,
            generation: 0,
        }
    }

    /// Colours the cutters of the loaded content, and leaves out those of the hidden classes of these
    /// colours; does nothing if that is so already.
    pub fn load_cutter_colours(&mut self, colours: CutterColours, hidden: &[CutterClass]) {
        let wanted = self.content.as_ref().map(|content| ColouredCutters {
            colours,
            hidden: hidden.to_vec(),
            planned: Arc::clone(&content.planned),
            policy: content.policy,
        });
        if self.coloured == wanted {
            return;
        }
        if let Some(ColouredCutters { hidden, planned, policy, .. }) = &wanted {
            let hid = self.coloured.as_ref().is_some_and(|coloured| !coloured.hidden.is_empty());
            if hid || !hidden.is_empty() {
                let plan = planned.plan(*policy);
                let mut set = cutter_set(plan);
                let is_hidden = |index| colours.class_of(plan, index).is_some_and(|c| hidden.contains(&c));
                set.cutters.retain(|cutter| !is_hidden(cutter.instance.id as usize));
                self.scene.set_cutters(set);
            }
        }
        let of_plan = wanted.as_ref().and_then(|wanted| colours.of_plan(&wanted.planned, wanted.policy));
        self.scene.set_cutter_colours(of_plan.as_deref());
        self.coloured = wanted;
        self.generation += 1;
    }

    /// Loads the content; does nothing if it is loaded already.
    pub fn load(&mut self, content: Option<Content>) {
        let (same_picture, same_plan, same_heights) = match (&self.content, &content) {
            (Some(old), Some(new)) => (old.same_picture(new), old.same_plan(new), old.same_heights(new)),
            (None, None) => (true, true, true),
            _ => (false, false, false),
        };
        let was_difference = self.content.as_ref().is_some_and(|content| content.more_than.is_some());
        self.content = content;
        // Heights of the core that arrive later are not drawn; they are read under the cursor.
        if same_picture && (same_heights || self.stock_floor.is_some()) {
            return;
        }
        self.generation += 1;
        let content = self.content.as_ref();
        let plan = content.map(|content| content.planned.plan(content.policy));
        if !same_plan {
            self.scene.set_cutters(plan.map(cutter_set).unwrap_or_default());
        }
        // Walls replace the floor; `load_flank` loads the floor again afterwards.
        if self.shows_walls() {
            return;
        }
        let grid = content.map(|content| &*content.planned.outcome.grid);
        let contact = || grid.zip(plan).map(|(grid, plan)| contact_mesh(grid, plan));
        if self.stock_floor.is_some() {
            // The stock itself is computed when it is drawn, at the resolution of the picture.
            self.scene.set_floor(&self.gpu, None);
            self.scene.set_contact(&self.gpu, contact().as_ref());
            return;
        }
        let values = content.map(|content| {
            (0..content.planned.outcome.grid.points.len())
                .map(|cell| content.value(cell).unwrap_or_default())
                .collect::<Vec<f32>>()
        });
        let floor = grid.zip(values.as_deref());
        match (floor, content.is_some_and(|content| content.more_than.is_some())) {
            (Some((grid, values)), true) => {
                if let Some(mesh) = value_mesh(grid, values) {
                    self.scene.set_values(&self.gpu, mesh);
                }
            }
            (Some((grid, heights)), false) if same_plan && !was_difference => {
                if let Some(meshes) = floor_meshes(grid, heights) {
                    self.scene.set_heights(&self.gpu, meshes);
                }
            }
            (floor, _) => {
                let meshes = floor.and_then(|(grid, heights)| floor_meshes(grid, heights));
                self.scene.set_floor(&self.gpu, meshes);
                self.scene.set_contact(&self.gpu, contact().as_ref());
            }
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
            self.clear_floor();
            self.content = None;
        }
        self.flank = shown;
        if let Some((outcome, _)) = self.flank.as_ref().filter(|_| self.shows_walls()) {
            let (mesh, _) = flank::wall_deviations(&outcome.workpiece.part, &shown_walls(&outcome.plan));
            self.scene.set_values(&self.gpu, mesh);
        }
        self.generation += 1;
    }

    /// Shows the moves of a checked program, or none; does nothing if they are shown already. Call after
    /// [`Self::load_flank`], whose lines they replace.
    pub fn load_program(&mut self, shown: Option<&Arc<CheckedProgram>>) {
        let same = match (&self.program, shown) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if same {
            return;
        }
        if shown.is_some() || self.flank.is_none() {
            self.scene.set_paths(&self.gpu, shown.map_or(&[], |checked| &checked.lines));
        }
        self.program = shown.cloned();
        self.generation += 1;
    }

    fn clear_floor(&mut self) {
        self.scene.set_floor(&self.gpu, None);
        self.scene.set_contact(&self.gpu, None);
    }

    /// Draws a mesh over the scene, coloured by its values; `None` removes it.
    pub fn highlight(&mut self, mesh: Option<Mesh>) {
        match mesh {
            Some(mesh) => self.scene.set_values(&self.gpu, mesh),
            None => self.clear_floor(),
        }
        self.generation += 1;
    }

    /// Framing of the standard views.
    pub fn framing(&self) -> &ViewTargets {
        self.scene.framing()
    }

    /// Shows these cutters, those of a running plan for example, instead of the plan's; `None`: the plan's.
    pub fn load_preview(&mut self, preview: Option<&ShownCutters>) {
        let same = match (&self.preview, preview) {
            (Some(a), Some(b)) => a.is_same(b),
            (None, None) => true,
            _ => false,
        };
        if !same {
            self.scene.set_preview(preview.map(|preview| Arc::clone(&preview.cutters)));
            self.preview = preview.cloned();
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

    /// Shows the stock as a solid, or nothing of it; see [`SceneOptions::show_solid`].
    pub fn load_solid(&mut self, solid: Option<Arc<SolidPicture>>) {
        let same = match (&self.solid, &solid) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            self.scene.set_solid(&self.gpu, solid.as_ref().map(|solid| Arc::clone(&solid.mesh)));
            self.solid = solid;
            self.generation += 1;
        }
    }

    /// Shows the machine after so many plunges of a plan on it, or none.
    pub fn load_machine(&mut self, machine: Option<(Arc<PlanOnMachine>, Option<usize>)>) {
        let same = match (&self.machine, &machine) {
            (Some((a, cut)), Some((b, wanted))) => Arc::ptr_eq(a, b) && cut == wanted,
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            let mesh = machine.as_ref().and_then(|(plan, cut)| plan.mesh(*cut));
            self.scene.set_machine(&self.gpu, mesh.as_ref());
            self.machine = machine;
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
        self.compute_stock(moving);
        let look = Drawn { generation: self.generation, ..look };
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
