//! The drawn scene: GPU buffers of one part with its plan, and the display options.

use std::str::FromStr;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

use super::camera::{Camera, ViewRay};
use super::cutters::{self, CutterChoice, CutterFilter, CutterSet, DrawnCutter};
use super::device::Gpu;
use super::mesh::{Mesh, MeshHit, Segment, rotate_about_z};
use super::part_mesh::{BladeMesh, PartMesh};
use super::stock_floor::DrawnStock;
use super::view::{ViewTarget, ViewTargets};
use crate::error::UserError;
use crate::palette::{ColourMap, Rgb, Theme};

/// Quantity shown as colours on the floor of the active channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloorColours {
    /// Height of stock left above the finished hub.
    #[default]
    Residual,
    /// Contact depth of the cores that end there.
    Interference,
    /// Other values per corner of the floor, set by [`Scene::set_values`].
    Values,
    /// Residual stock on the walls of the channel, set by [`Scene::set_values`]; the walls replace the
    /// blades.
    Walls,
    /// No colours.
    Plain,
}

/// Display options of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneOptions {
    /// Hub of the wheel, with its body.
    pub show_hub: bool,
    /// Blades.
    pub show_blades: bool,
    /// Shroud, transparent.
    pub show_shroud: bool,
    /// Which cutters are shown.
    pub show_cutters: CutterFilter,
    /// Axes of the shown cutters, from tip to retract point.
    pub show_axes: bool,
    /// Holders of the cutters drawn at full length.
    pub show_holders: bool,
    /// Rapids from retract point to retract point.
    pub show_links: bool,
    /// Colours of the floor.
    pub show_floor_colours: FloorColours,
    /// The stock as a solid, instead of hub and blades; see [`Scene::set_solid`].
    pub show_solid: bool,
    /// The machine; see [`Scene::set_machine`].
    pub show_machine: bool,
    /// Draws stock raised by its height instead of as flat colours on the hub.
    pub relief: bool,
    /// Draws the walls of the active channel transparent where they hide it.
    pub cut_away: bool,
    /// Values at the ends of the colour table, mm.
    pub range_mm: (f32, f32),
    /// Colour table of floor and wall values.
    pub map: ColourMap,
    /// Light or dark.
    pub theme: Theme,
    /// Shows only positions before this one, the last of them at full length.
    pub up_to: Option<usize>,
    /// Selected position.
    pub selected: Option<usize>,
    /// Drawn length, in diameters, of sound cutters that are neither selected nor last; faulty ones are
    /// longer.
    pub cutter_stub: f32,
    /// Physical pixels per logical point, so that lines keep their width on high-density screens.
    pub pixel_scale: f32,
    /// Section plane; the part beyond it is not drawn.
    pub section: Option<SectionPlane>,
    /// Borders between sections.
    pub show_borders: bool,
    /// Leaves the background transparent.
    pub transparent: bool,
    /// Draft quality for speed: coarser meshes, cutters with fewer facets.
    pub draft: bool,
}

/// A plane that clips the part (world frame).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPlane {
    /// Unit normal; the side it points to is clipped away.
    pub normal: Vec3,
    /// Distance of the plane from the origin along the normal, mm.
    pub offset: f32,
}

impl SectionPlane {
    /// Interval of a ray (mm along it) that is not clipped; `None` when all of it is.
    fn unclipped_interval(&self, ray: &ViewRay) -> Option<(f32, f32)> {
        let (height, slope) = (self.normal.dot(ray.origin) - self.offset, self.normal.dot(ray.direction));
        if slope.abs() < 1e-9 {
            return (height <= 0.0).then_some((0.0, f32::INFINITY));
        }
        let at = -height / slope;
        if slope > 0.0 { (at > 0.0).then_some((0.0, at)) } else { Some((at.max(0.0), f32::INFINITY)) }
    }
}

impl Default for SceneOptions {
    fn default() -> Self {
        Self {
            show_hub: true,
            show_blades: true,
            show_shroud: false,
            show_cutters: CutterFilter::All,
            show_axes: false,
            show_holders: false,
            show_links: false,
            show_floor_colours: FloorColours::Residual,
            show_solid: false,
            show_machine: false,
            relief: false,
            cut_away: true,
            range_mm: (0.0, 4.0),
            map: ColourMap::Cividis,
            theme: Theme::Light,
            up_to: None,
            selected: None,
            cutter_stub: 0.15,
            pixel_scale: 1.0,
            section: None,
            show_borders: false,
            transparent: false,
            draft: false,
        }
    }
}

impl FromStr for FloorColours {
    type Err = UserError;

    fn from_str(word: &str) -> Result<Self, UserError> {
        Ok(match word {
            "residual" => Self::Residual,
            "interference" => Self::Interference,
            "plain" => Self::Plain,
            _ => {
                let help = "use residual, interference, plain or solid";
                return Err(super::unknown_colours(word, help));
            }
        })
    }
}

impl SceneOptions {
    /// Default options for a picture of `colours`. Cutters are shown for interference only; elsewhere they
    /// would hide the floor.
    pub fn for_colours(colours: FloorColours) -> Self {
        let show_cutters = match colours {
            FloorColours::Interference => CutterFilter::All,
            FloorColours::Residual | FloorColours::Values | FloorColours::Walls | FloorColours::Plain => {
                CutterFilter::Hidden
            }
        };
        Self { show_floor_colours: colours, show_cutters, ..Self::default() }
    }

    /// Which cutters are drawn with these options, and how.
    pub fn cutter_choice(&self) -> CutterChoice {
        CutterChoice {
            filter: self.show_cutters,
            up_to: self.up_to,
            selected: self.selected,
            stub: self.cutter_stub,
        }
    }
}

/// Instance of a surface rotated about Z. 16 bytes, matches `SurfaceIn` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SurfaceInstance {
    turn: [f32; 2],
    kind: u32,
    flags: u32,
}

/// Kinds of surface, in the order of the shader's greys.
const HUB: u32 = 0;
const FLOOR: u32 = 1;
const BLADE: u32 = 2;
const WALL: u32 = 3;
const SHROUD: u32 = 4;
/// Flag: faces the active channel.
const INNER: u32 = 1;
/// Flag: lies on the hub.
const ON_HUB: u32 = 2;

/// Draw group of a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DrawGroup {
    /// Drawn with the hub; a closed surface.
    Hub,
    /// Drawn with the hub, on which it lies.
    Floor,
    /// Drawn with the blades.
    Blades,
    /// Drawn with the blades; transparent when walls are cut away.
    CutAway,
    /// Never drawn; closes the blades at the hub for the parity test.
    Foot,
    /// Drawn with the shroud.
    Shroud,
}

/// One indexed draw call: a range of indices with a range of instances.
#[derive(Clone, Debug)]
pub(super) struct SurfaceDraw {
    pub layer: DrawGroup,
    pub indices: std::ops::Range<u32>,
    pub base_vertex: i32,
    pub instances: std::ops::Range<u32>,
}

/// Vertex and index buffer. Clones share them.
#[derive(Clone, Debug)]
pub(super) struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub count: u32,
}

impl MeshBuffers {
    fn new(gpu: &Gpu, mesh: &Mesh) -> Self {
        Self {
            vertices: vertex_buffer(gpu, "floor corners", &mesh.vertices),
            indices: index_buffer(gpu, "floor triangles", &mesh.indices),
            count: mesh.indices.len() as u32,
        }
    }
}

pub(super) fn vertex_buffer<T: Pod>(gpu: &Gpu, label: &str, contents: &[T]) -> wgpu::Buffer {
    gpu.filled_buffer(label, bytemuck::cast_slice(contents), wgpu::BufferUsages::VERTEX)
}

pub(super) fn index_buffer(gpu: &Gpu, label: &str, indices: &[u32]) -> wgpu::Buffer {
    gpu.filled_buffer(label, bytemuck::cast_slice(indices), wgpu::BufferUsages::INDEX)
}

/// Surfaces and edges of the wheel at one level of detail.
#[derive(Debug)]
pub(super) struct WheelBuffers {
    pub surfaces: MeshBuffers,
    pub instances: wgpu::Buffer,
    pub pieces: Vec<SurfaceDraw>,
    pub edges: wgpu::Buffer,
    pub edge_count: u32,
}

impl WheelBuffers {
    fn new(gpu: &Gpu, part: &PartMesh) -> Self {
        let mut builder = WheelBuilder::default();
        let still = |kind, flags| SurfaceInstance { turn: [1.0, 0.0], kind, flags };
        builder.add(DrawGroup::Hub, &part.hub, &[still(HUB, 0)]);
        builder.add(DrawGroup::Floor, &part.floor, &[still(FLOOR, ON_HUB)]);
        builder.add_blade(&part.main, 2);
        for splitter in &part.splitters {
            builder.add_blade(splitter, 1);
        }
        builder.add(DrawGroup::Shroud, &part.shroud, &[still(SHROUD, 0)]);
        Self {
            surfaces: MeshBuffers::new(gpu, &builder.mesh),
            instances: vertex_buffer(gpu, "surface copies", &builder.instances),
            pieces: builder.pieces,
            edges: vertex_buffer(gpu, "edges", &part.edges),
            edge_count: part.edges.len() as u32,
        }
    }
}

/// The floor of the active channel with a value per corner.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorMeshes {
    /// For still pictures, and under the cursor.
    pub fine: Mesh,
    /// For pictures in motion, if it is coarser.
    pub draft: Option<Mesh>,
}

/// Floor of the active channel with its values.
#[derive(Debug)]
pub(super) struct FloorBuffers {
    pub residual: MeshBuffers,
    /// The same, coarser, if there is one.
    pub draft: Option<MeshBuffers>,
    mesh: Mesh,
}

/// A surface hit by a picking ray.
#[derive(Clone, Copy)]
struct SurfaceHit {
    /// Distance along the ray, mm.
    distance: f32,
    value: Option<f32>,
    on_section: bool,
}

/// The ray rotated by −`angle` about Z, which is cheaper than rotating a blade.
fn rotated_back(ray: &ViewRay, angle: f64) -> ViewRay {
    ViewRay { origin: rotate_about_z(ray.origin, -angle), direction: rotate_about_z(ray.direction, -angle) }
}

/// One part with its plan, on the GPU.
#[derive(Debug)]
pub struct Scene {
    part: Arc<PartMesh>,
    fine: WheelBuffers,
    draft: Option<WheelBuffers>,
    /// Passes or moves of a flank plan.
    pub(super) paths: Option<(wgpu::Buffer, u32)>,
    /// Borders between sections.
    pub(super) borders: Option<(wgpu::Buffer, u32)>,
    pub(super) floor: Option<FloorBuffers>,
    /// Stock on the floor that the device computed; drawn instead of the heights of `floor`.
    pub(super) stock: Option<DrawnStock>,
    /// The floor with the contact of all cores.
    pub(super) contact: Option<MeshBuffers>,
    /// The stock as a solid, for drawing and picking.
    solid: Option<(MeshBuffers, Arc<Mesh>)>,
    /// The machine, and the distance of its farthest corner from the origin, mm.
    machine: Option<(MeshBuffers, f32)>,
    pub(super) cutters: Vec<DrawnCutter>,
    /// Cutters of a plan preview. They are drawn instead of `cutters` and cannot be picked.
    pub(super) preview: Option<Arc<[DrawnCutter]>>,
    framing: ViewTargets,
}

/// Result of picking a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// Nearest surface point of the part, or of a cutter if that is nearer, mm.
    pub point: Vec3,
    /// Index of the position whose cutter is under the pixel.
    pub position: Option<usize>,
    /// Value there, if the surface has values ([`FloorColours::Walls`]).
    pub value: Option<f32>,
    /// Whether the point is on material cut by the section plane.
    pub on_section: bool,
}

impl Scene {
    /// Uploads the meshes of a part; no plan yet.
    pub fn new(gpu: &Gpu, part: Arc<PartMesh>) -> Self {
        let framing = part.framing.clone();
        let fine = WheelBuffers::new(gpu, &part);
        Self {
            fine,
            draft: None,
            paths: None,
            borders: None,
            floor: None,
            stock: None,
            contact: None,
            solid: None,
            machine: None,
            cutters: Vec::new(),
            preview: None,
            framing,
            part,
        }
    }

    /// Adds a coarser mesh of the same part for pictures in motion.
    pub fn with_draft(mut self, gpu: &Gpu, draft: &PartMesh) -> Self {
        self.draft = Some(WheelBuffers::new(gpu, draft));
        self
    }

    /// The wheel at the level of detail of `options`.
    pub(super) fn wheel(&self, options: &SceneOptions) -> &WheelBuffers {
        self.draft.as_ref().filter(|_| options.draft).unwrap_or(&self.fine)
    }

    /// Sets the cutters of a plan.
    pub fn set_cutters(&mut self, set: CutterSet) {
        self.cutters = set.cutters;
        let frame = |section| section_frame(&self.cutters, section, &self.framing);
        self.framing.sections = (0..set.sections).map(frame).collect();
    }

    /// Colours the cutters of the plan, by position, instead of by their state; `None`: by their state.
    pub fn set_cutter_colours(&mut self, colours: Option<&[Rgb]>) {
        for cutter in &mut self.cutters {
            let index = cutter.instance.id as usize;
            cutter.instance.set_colour(colours.and_then(|colours| colours.get(index)).copied());
        }
    }

    /// Shows the cutters of a plan preview instead of the plan's, or removes it.
    pub fn set_preview(&mut self, cutters: Option<Arc<[DrawnCutter]>>) {
        self.preview = cutters;
    }

    /// Sets the floor with the height of stock at its corners, mm, or removes it.
    pub fn set_floor(&mut self, gpu: &Gpu, floor: Option<FloorMeshes>) {
        self.floor = floor.map(|floor| FloorBuffers {
            residual: MeshBuffers::new(gpu, &floor.fine),
            draft: floor.draft.map(|draft| MeshBuffers::new(gpu, &draft)),
            mesh: floor.fine,
        });
    }

    /// Sets the floor with the contact depth of all cores of a plan at its corners, mm, independent of
    /// [`SceneOptions::up_to`], or removes it.
    pub fn set_contact(&mut self, gpu: &Gpu, mesh: Option<&Mesh>) {
        self.contact = mesh.filter(|mesh| !mesh.indices.is_empty()).map(|mesh| MeshBuffers::new(gpu, mesh));
    }

    /// Sets the stock as a solid, closed and with corners by [`super::mesh::Vertex::painted`], or removes it.
    /// See [`SceneOptions::show_solid`].
    pub fn set_solid(&mut self, gpu: &Gpu, solid: Option<Arc<Mesh>>) {
        let some = solid.filter(|mesh| !mesh.indices.is_empty());
        self.solid = some.map(|mesh| (MeshBuffers::new(gpu, &mesh), mesh));
    }

    /// Sets the machine, with corners by [`super::mesh::Vertex::painted`], or removes it. It cannot be picked.
    pub fn set_machine(&mut self, gpu: &Gpu, mesh: Option<&Mesh>) {
        let reach =
            |mesh: &Mesh| mesh.vertices.iter().map(|v| Vec3::from(v.position).length()).fold(0.0, f32::max);
        let some = mesh.filter(|mesh| !mesh.indices.is_empty());
        self.machine = some.map(|mesh| (MeshBuffers::new(gpu, mesh), reach(mesh)));
    }

    /// The machine, if these options show it.
    pub(super) fn machine(&self, options: &SceneOptions) -> Option<&MeshBuffers> {
        self.machine.as_ref().filter(|_| options.show_machine).map(|(buffers, _)| buffers)
    }

    /// `camera` with a depth range that holds what these options show beside the part.
    pub(super) fn enclosing(&self, camera: &Camera, options: &SceneOptions) -> Camera {
        let (centre, radius) = camera.bounds;
        let reach = self.machine.as_ref().filter(|_| options.show_machine).map_or(0.0, |(_, reach)| *reach);
        Camera { bounds: (centre, radius.max(centre.length() + reach)), ..*camera }
    }

    /// The solid, if these options show it.
    pub(super) fn solid(&self, options: &SceneOptions) -> Option<&MeshBuffers> {
        self.solid.as_ref().filter(|_| options.show_solid).map(|(buffers, _)| buffers)
    }

    /// Sets stock on the floor that the device computed, or removes it. While it is set, it is drawn for
    /// [`FloorColours::Residual`], or a difference for [`FloorColours::Values`], instead of other heights.
    pub fn set_stock(&mut self, stock: Option<DrawnStock>) {
        self.stock = stock;
    }

    /// Replaces the floor by surfaces with a value per corner, see [`FloorColours::Values`].
    pub fn set_values(&mut self, gpu: &Gpu, mesh: Mesh) {
        self.floor = Some(FloorBuffers { residual: MeshBuffers::new(gpu, &mesh), draft: None, mesh });
    }

    /// Replaces the corners of the floor, e.g. while scrubbing. `meshes` are of the same grid as those of
    /// [`Self::set_floor`]; nothing happens before that call or when the sizes differ.
    pub fn set_heights(&mut self, gpu: &Gpu, meshes: FloorMeshes) {
        let Some(floor) = &mut self.floor else { return };
        if meshes.fine.vertices.len() == floor.mesh.vertices.len() {
            gpu.queue.write_buffer(&floor.residual.vertices, 0, bytemuck::cast_slice(&meshes.fine.vertices));
            floor.mesh = meshes.fine;
            if let Some((draft, mesh)) = floor.draft.as_ref().zip(meshes.draft) {
                gpu.queue.write_buffer(&draft.vertices, 0, bytemuck::cast_slice(&mesh.vertices));
            }
        }
    }

    /// Sets lines in the channel, such as passes; an empty slice removes them.
    pub fn set_paths(&mut self, gpu: &Gpu, lines: &[Segment]) {
        let buffer = || (vertex_buffer(gpu, "paths", lines), lines.len() as u32);
        self.paths = (!lines.is_empty()).then(buffer);
    }

    /// Sets the borders between sections, as lines; see [`SceneOptions::show_borders`].
    pub fn set_borders(&mut self, gpu: &Gpu, lines: &[Segment]) {
        let buffer = || (vertex_buffer(gpu, "borders", lines), lines.len() as u32);
        self.borders = (!lines.is_empty()).then(buffer);
    }

    /// Targets of the standard views.
    pub fn framing(&self) -> &ViewTargets {
        &self.framing
    }

    /// Number of triangles of the part.
    pub fn triangles(&self) -> usize {
        self.part.triangles()
    }

    /// Picks the surface or cutter under a pixel of a picture of `size` by ray casting, if any.
    pub fn pick(&self, camera: &Camera, options: &SceneOptions, pixel: Vec2, size: Vec2) -> Option<Pick> {
        let ray = camera.ray(pixel, size);
        let surface = self.surface_under(&ray, options);
        let choice = options.cutter_choice();
        let shown = self.cutters.iter().filter(|_| self.preview.is_none());
        let cutter = shown
            .filter_map(|c| choice.instance(c))
            .filter_map(|i| Some((cutters::ray_distance(&i, &ray)?, i.id as usize)))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let at = |distance: f32| ray.origin + ray.direction * distance;
        match cutter {
            Some((distance, id)) if surface.is_none_or(|s| distance <= s.distance) => {
                Some(Pick { point: at(distance), position: Some(id), value: None, on_section: false })
            }
            _ => surface.map(|s| Pick {
                point: at(s.distance),
                position: None,
                value: s.value,
                on_section: s.on_section,
            }),
        }
    }

    /// Nearest surface of the part as drawn, including the section plane where it cuts material.
    fn surface_under(&self, whole: &ViewRay, options: &SceneOptions) -> Option<SurfaceHit> {
        let kept =
            options.section.map_or(Some((0.0, f32::INFINITY)), |plane| plane.unclipped_interval(whole));
        let (start, end) = kept?;
        // Start the ray where it enters the unclipped side of the section plane.
        let ray = ViewRay { origin: whole.origin + whole.direction * start, ..*whole };
        if start > 0.0 && self.is_inside(&ray, options) {
            return Some(SurfaceHit { distance: start, value: None, on_section: true });
        }
        let mut nearest: Option<SurfaceHit> = None;
        let mut near = |hit: Option<MeshHit>, has_value: bool| {
            let Some(hit) = hit else { return };
            let distance = start + hit.distance;
            if distance <= end && nearest.is_none_or(|n| distance < n.distance) {
                let value = has_value.then_some(hit.value);
                nearest = Some(SurfaceHit { distance, value, on_section: false });
            }
        };
        if let Some((_, mesh)) = self.solid.as_ref().filter(|_| options.show_solid) {
            near(mesh.hit(&ray), true);
            return nearest;
        }
        if options.show_hub {
            near(self.part.hub.hit(&ray), false);
        }
        let walls = self.floor.as_ref().filter(|_| options.show_floor_colours == FloorColours::Walls);
        if let Some(walls) = walls {
            near(walls.mesh.hit(&ray), true);
        }
        let blades = self.blades().filter(|_| options.show_blades);
        for (blade, lit) in blades {
            for (k, &angle) in blade.rotations_rad.iter().enumerate() {
                let back = rotated_back(&ray, angle);
                for (side, mesh) in [&blade.suction, &blade.pressure].into_iter().enumerate() {
                    if k >= lit || !options.cut_away {
                        near(mesh.hit(&back), false);
                    } else if lit == 2 && side == k {
                        // Walls drawn transparent cannot be picked; surfaces behind them can.
                        near(mesh.hit(&back).filter(|hit| hit.normal.dot(back.direction) < 0.0), false);
                    }
                }
            }
        }
        nearest
    }

    /// Whether a ray begins inside the shown hub or blades. Both are closed, so it then crosses an odd number
    /// of their faces: the parity rule with which the renderer fills the section plane.
    fn is_inside(&self, ray: &ViewRay, options: &SceneOptions) -> bool {
        let odd = |count: usize| count % 2 == 1;
        if let Some((_, mesh)) = self.solid.as_ref().filter(|_| options.show_solid) {
            return odd(mesh.crossings(ray));
        }
        let in_blades = || {
            let of = |blade: &BladeMesh| -> usize {
                let faces = [&blade.suction, &blade.pressure, &blade.closing, &blade.foot];
                let copies = blade.rotations_rad.iter().map(|&angle| rotated_back(ray, angle));
                copies.map(|back| faces.iter().map(|mesh| mesh.crossings(&back)).sum::<usize>()).sum()
            };
            self.blades().map(|(blade, _)| of(blade)).sum()
        };
        options.show_hub && odd(self.part.hub.crossings(ray)) || options.show_blades && odd(in_blades())
    }

    fn blades(&self) -> impl Iterator<Item = (&BladeMesh, usize)> {
        std::iter::once((&self.part.main, 2)).chain(self.part.splitters.iter().map(|s| (s, 1)))
    }
}

/// View target of a section: a sphere about the cutters' tips, seen along their mean axis.
fn section_frame(cutters: &[DrawnCutter], section: usize, framing: &ViewTargets) -> ViewTarget {
    let of_section = || cutters.iter().filter(|c| c.section == section).map(|c| &c.instance);
    let count = of_section().count();
    if count == 0 {
        return framing.channel;
    }
    let tips = || of_section().map(|i| Vec3::from_array(i.tip));
    let center = tips().sum::<Vec3>() / count as f32;
    let axis = of_section().map(|i| Vec3::from_array(i.axis)).sum::<Vec3>();
    let reach =
        of_section().map(|i| Vec3::from_array(i.tip).distance(center) + 1.5 * i.radius).fold(0.0, f32::max);
    let outward = Vec3::new(center.x, center.y, 0.0).normalize_or_zero();
    let from = axis.normalize_or(framing.channel.from) + outward * 0.35;
    ViewTarget { center, radius: reach, from: from.normalize_or(framing.channel.from) }
}

/// Collects surfaces into shared buffers.
#[derive(Default)]
struct WheelBuilder {
    mesh: Mesh,
    instances: Vec<SurfaceInstance>,
    pieces: Vec<SurfaceDraw>,
}

impl WheelBuilder {
    fn load(&mut self, mesh: &Mesh) -> (std::ops::Range<u32>, i32) {
        let base_vertex = self.mesh.vertices.len() as i32;
        let first = self.mesh.indices.len() as u32;
        self.mesh.vertices.extend_from_slice(&mesh.vertices);
        self.mesh.indices.extend_from_slice(&mesh.indices);
        (first..self.mesh.indices.len() as u32, base_vertex)
    }

    fn add_instances(
        &mut self,
        layer: DrawGroup,
        loaded: &(std::ops::Range<u32>, i32),
        copies: &[SurfaceInstance],
    ) {
        if copies.is_empty() {
            return;
        }
        let first = self.instances.len() as u32;
        self.instances.extend_from_slice(copies);
        self.pieces.push(SurfaceDraw {
            layer,
            indices: loaded.0.clone(),
            base_vertex: loaded.1,
            instances: first..self.instances.len() as u32,
        });
    }

    fn add(&mut self, layer: DrawGroup, mesh: &Mesh, copies: &[SurfaceInstance]) {
        let loaded = self.load(mesh);
        self.add_instances(layer, &loaded, copies);
    }

    /// Adds a blade row whose first `lit` copies belong to the active channel: 2 walls, or 1 splitter inside
    /// it.
    fn add_blade(&mut self, blade: &BladeMesh, lit: usize) {
        let copy = |k: usize, kind, flags| SurfaceInstance {
            turn: [blade.rotations_rad[k].cos() as f32, blade.rotations_rad[k].sin() as f32],
            kind,
            flags,
        };
        let lit = lit.min(blade.rotations_rad.len());
        let pale: Vec<SurfaceInstance> =
            (lit..blade.rotations_rad.len()).map(|k| copy(k, BLADE, 0)).collect();
        for (side, mesh) in [&blade.suction, &blade.pressure].into_iter().enumerate() {
            let loaded = self.load(mesh);
            self.add_instances(DrawGroup::Blades, &loaded, &pale);
            for k in 0..lit {
                // Wall 0 bounds the channel with its suction side, wall 1 with its pressure side.
                if lit == 2 && side == k {
                    self.add_instances(DrawGroup::Blades, &loaded, &[copy(k, WALL, INNER)]);
                } else {
                    self.add_instances(DrawGroup::CutAway, &loaded, &[copy(k, WALL, 0)]);
                }
            }
        }
        let loaded = self.load(&blade.closing);
        self.add_instances(DrawGroup::Blades, &loaded, &pale);
        let near: Vec<SurfaceInstance> = (0..lit).map(|k| copy(k, WALL, 0)).collect();
        self.add_instances(DrawGroup::Blades, &loaded, &near);
        let foot = self.load(&blade.foot);
        let all: Vec<SurfaceInstance> = (0..blade.rotations_rad.len()).map(|k| copy(k, BLADE, 0)).collect();
        self.add_instances(DrawGroup::Foot, &foot, &all);
    }
}
