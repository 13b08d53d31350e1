//! The stock on the floor of a channel, computed and drawn on the device: the kernel writes the heights into
//! a buffer that the renderer reads as a vertex attribute, so they never pass through memory.

use std::sync::Arc;

use super::device::{Gpu, GpuError};
use super::mesh::Vertex;
use super::mesh_buffers::{MeshBuffers, index_buffer, vertex_buffer};
use super::residual::{DeviceField, DeviceFloor, ResidualKernel};
use crate::stock::{FieldProgram, FloorLevel, FloorLevels};

/// The stock after part of a plan's plunges.
#[derive(Clone, Debug)]
pub struct StockState {
    /// The plunges, sorted into tiles.
    pub program: Arc<FieldProgram>,
    /// Number of plunges that were made.
    pub count: usize,
}

impl PartialEq for StockState {
    /// Programs are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        self.count == other.count && Arc::ptr_eq(&self.program, &other.program)
    }
}

/// Buffers of a floor with its stock, as the renderer draws them.
#[derive(Clone, Debug)]
pub struct DrawnStock {
    /// Corners, whose value is the height of the blank, and triangles.
    pub(super) mesh: MeshBuffers,
    /// Height of the stock per corner.
    pub(super) heights: wgpu::Buffer,
    /// Height per corner that is subtracted from it, for a difference.
    pub(super) less: Option<wgpu::Buffer>,
}

/// A field on the device, and the state that its heights have.
#[derive(Debug)]
struct Computed {
    program: Arc<FieldProgram>,
    count: Option<usize>,
    field: DeviceField,
}

/// One resolution of the floor on the device.
#[derive(Debug)]
struct LevelBuffers {
    mesh: MeshBuffers,
    cells: DeviceFloor,
    /// The shown stock, and the one that is subtracted from it.
    computed: [Option<Computed>; 2],
}

impl LevelBuffers {
    fn new(gpu: &Gpu, level: &FloorLevel) -> Result<Self, GpuError> {
        let grid = &level.grid;
        let corner = |cell: usize| Vertex {
            position: grid.points[cell],
            value: grid.blank_heights[cell],
            normal: grid.normals[cell],
            uncut: 0.0,
        };
        let corners: Vec<Vertex> = (0..grid.points.len()).map(corner).collect();
        let triangles = level.triangles.as_flattened();
        let mesh = MeshBuffers {
            vertices: vertex_buffer(gpu, "floor cells", &corners),
            indices: index_buffer(gpu, "floor triangles", triangles),
            count: triangles.len() as u32,
        };
        Ok(Self { mesh, cells: DeviceFloor::new(gpu, grid, None)?, computed: [None, None] })
    }

    /// Heights of a state; submits their computation unless a slot has them already.
    fn heights(
        &mut self,
        gpu: &Gpu,
        kernel: &ResidualKernel,
        level: usize,
        slot: usize,
        state: &StockState,
    ) -> Result<wgpu::Buffer, GpuError> {
        let slot = &mut self.computed[slot];
        let program = &state.program;
        let known = slot.take().filter(|known| Arc::ptr_eq(&known.program, program));
        let computed = match known {
            Some(known) => slot.insert(known),
            None => {
                let field = kernel.field(gpu, &self.cells, &program.cutters, &program.bins[level])?;
                slot.insert(Computed { program: Arc::clone(program), count: None, field })
            }
        };
        // All counts beyond the last plunge are the same state.
        let count = state.count.min(program.cutters.len());
        if computed.count != Some(count) {
            kernel.compute(gpu, &computed.field, count);
            computed.count = Some(count);
        }
        Ok(computed.field.heights().clone())
    }
}

/// The floor of a channel with its stock; keeps the buffers of the resolutions that were drawn.
#[derive(Debug)]
pub struct StockFloor {
    kernel: Arc<ResidualKernel>,
    floor: Option<Arc<FloorLevels>>,
    levels: Vec<Option<LevelBuffers>>,
}

impl StockFloor {
    /// Without buffers yet.
    pub fn new(kernel: Arc<ResidualKernel>) -> Self {
        Self { kernel, floor: None, levels: Vec::new() }
    }

    /// Submits what the heights of `state` need at a resolution, less those of `less`, which must be over the
    /// same floor; returns the buffers to draw. `None` where there is nothing to draw.
    ///
    /// # Errors
    /// [`GpuError`] when floor or plunges do not fit the device, or it fails.
    pub fn show(
        &mut self,
        gpu: &Gpu,
        level: usize,
        state: &StockState,
        less: Option<&StockState>,
    ) -> Result<Option<DrawnStock>, GpuError> {
        let floor = &state.program.floor;
        if less.is_some_and(|less| !Arc::ptr_eq(floor, &less.program.floor)) {
            return Ok(None);
        }
        if self.floor.as_ref().is_none_or(|known| !Arc::ptr_eq(known, floor)) {
            self.levels = floor.levels().iter().map(|_| None).collect();
            self.floor = Some(Arc::clone(floor));
        }
        let level = level.min(floor.finest());
        let shape = &floor.levels()[level];
        if shape.triangles.is_empty() {
            return Ok(None);
        }
        let kernel = Arc::clone(&self.kernel);
        gpu.in_error_scope(|| -> Result<_, GpuError> {
            let slot = &mut self.levels[level];
            let buffers = match slot.take() {
                Some(known) => slot.insert(known),
                None => slot.insert(LevelBuffers::new(gpu, shape)?),
            };
            let heights = buffers.heights(gpu, &kernel, level, 0, state)?;
            let less = less.map(|less| buffers.heights(gpu, &kernel, level, 1, less)).transpose()?;
            Ok(Some(DrawnStock { mesh: buffers.mesh.clone(), heights, less }))
        })?
    }
}
