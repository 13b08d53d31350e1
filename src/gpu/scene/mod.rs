//! The drawn scene: GPU buffers of one part with its plan.

mod options;
mod ray_pick;
mod wheel;

use std::sync::Arc;

use glam::Vec3;

use super::camera::Camera;
use super::cutters::{CutterSet, DrawnChannel, DrawnCutter};
use super::device::Gpu;
use super::mesh::{Mesh, Segment};
use super::mesh_buffers::{MeshBuffers, vertex_buffer};
use super::part_mesh::PartMesh;
use super::stock_floor::DrawnStock;
use super::view::{ViewTarget, ViewTargets};
use crate::palette::Rgb;
pub use options::{FloorColours, SceneOptions, SectionPlane};
pub use ray_pick::Pick;
pub use wheel::SurfaceInstance;
pub(super) use wheel::{DrawGroup, WheelBuffers};

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

/// The stock as a solid: its triangles for picking, and in buffers for drawing, maybe with fewer for pictures
/// in motion.
#[derive(Debug)]
struct SolidBuffers {
    mesh: Arc<Mesh>,
    fine: MeshBuffers,
    draft: Option<MeshBuffers>,
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
    solid: Option<SolidBuffers>,
    /// The machine, and the distance of its farthest corner from the origin, mm.
    machine: Option<(MeshBuffers, f32)>,
    pub(super) cutters: Vec<DrawnCutter>,
    /// Channels beside the first in which the cutters are drawn, too. They cannot be picked.
    pub(super) channels: Vec<DrawnChannel>,
    /// Cutters of a plan preview. They are drawn instead of `cutters` and cannot be picked.
    pub(super) preview: Option<Arc<[DrawnCutter]>>,
    framing: ViewTargets,
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
            channels: Vec::new(),
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

    /// Draws the cutters in these channels, too.
    pub fn set_channels(&mut self, channels: Vec<DrawnChannel>) {
        self.channels = channels;
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
        self.solid = some.map(|mesh| SolidBuffers { fine: MeshBuffers::new(gpu, &mesh), draft: None, mesh });
    }

    /// Adds coarser triangles of the same solid for pictures in motion.
    pub fn set_solid_draft(&mut self, gpu: &Gpu, draft: &Mesh) {
        if let Some(solid) = &mut self.solid {
            solid.draft = Some(MeshBuffers::new(gpu, draft));
        }
    }

    /// Sets the machine, with corners by [`super::mesh::Vertex::painted`], or removes it. It cannot be
    /// picked.
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
        let solid = self.solid.as_ref().filter(|_| options.show_solid)?;
        Some(solid.draft.as_ref().filter(|_| options.draft).unwrap_or(&solid.fine))
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
