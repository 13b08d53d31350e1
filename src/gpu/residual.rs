//! The residual heightfield on the graphics device; the CPU implementation is
//! [`crate::stock::residual_field`].
//!
//! [`ResidualKernel::run`] reads heights and traces back. For pictures nothing is read back: a
//! [`DeviceField`] keeps its heights in a buffer that the renderer draws from, and the state after any number
//! of plunges is one run of the kernel over the same buffers.
//!
//! On a software driver ([`Gpu::is_software`]) the CPU implementation gives the same result several times
//! faster.

use std::sync::mpsc;

use bytemuck::{Pod, Zeroable};

use super::device::{Gpu, GpuError};
use crate::stock::field::{CONTACT_TOLERANCE, CUT_TOLERANCE};
use crate::stock::meeting::{CORNER_STEPS, CORNER_TOLERANCE, FAR, MIN_COSINE, MIN_SQUARED_SINE};
use crate::stock::tiles::TILE;
use crate::stock::trace::{TraceSums, VolumeUnit};
use crate::stock::{FieldCutter, FloorGrid, PositionTrace, ResidualField, TileBins};

/// A cutter in the layout of the shader's struct: tip and R, axis and core radius, corner radius and padding.
type PackedCutter = [f32; 12];

fn pack_cutter(c: &FieldCutter) -> PackedCutter {
    let ([x, y, z], [i, j, k]) = (c.tip, c.axis);
    [x, y, z, c.radius, i, j, k, c.core_radius, c.corner_radius, 0.0, 0.0, 0.0]
}

/// A trace in the layout of the shader's struct; the depth is the bit pattern of a float.
type PackedTrace = [u32; 5];

fn unpack_trace([depth, contact_cells, swept_cells, cut_cells, removed_units]: PackedTrace) -> TraceSums {
    TraceSums { contact_depth: f32::from_bits(depth), contact_cells, swept_cells, cut_cells, removed_units }
}

/// `Grid` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GridUniform {
    rows: u32,
    columns: u32,
    tiles_across: u32,
    limit: u32,
}

/// `Cell` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct PackedCell {
    foot: [f32; 3],
    blank: f32,
    normal: [f32; 3],
    units: f32,
}

/// The kernel of `shaders/residual.wgsl`, compiled for one device.
#[derive(Debug)]
pub struct ResidualKernel {
    layout: wgpu::BindGroupLayout,
    /// Computes heights only.
    heights: wgpu::ComputePipeline,
    /// Computes heights and traces.
    traced: wgpu::ComputePipeline,
}

/// The cells of a floor on the device.
#[derive(Debug)]
pub struct DeviceFloor {
    grid: GridUniform,
    tiles_down: u32,
    cells: wgpu::Buffer,
}

/// Plunges over a floor on the device, with the heights of stock that they leave.
#[derive(Debug)]
pub struct DeviceField {
    grid: GridUniform,
    tiles_down: u32,
    uniform: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    heights: wgpu::Buffer,
    traces: wgpu::Buffer,
}

impl DeviceField {
    /// Heights per cell, mm, an f32 each, as the last [`ResidualKernel::compute`] left them; usable as a
    /// vertex buffer.
    pub fn heights(&self) -> &wgpu::Buffer {
        &self.heights
    }
}

impl DeviceFloor {
    /// Uploads the cells of `grid`, which must have some. `unit` is that of the volumes of traces; without it
    /// only heights can be computed.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if they do not fit the device.
    pub(crate) fn new(gpu: &Gpu, grid: &FloorGrid, unit: Option<VolumeUnit>) -> Result<Self, GpuError> {
        let units = |cell: usize| unit.map_or(0.0, |unit| unit.per_height(grid.areas[cell]));
        let cells: Vec<PackedCell> = (0..grid.rows * grid.columns)
            .map(|cell| PackedCell {
                foot: grid.points[cell],
                blank: grid.blank_heights[cell],
                normal: grid.normals[cell],
                units: if grid.floor[cell] { units(cell) } else { -1.0 },
            })
            .collect();
        let (down, across) = (grid.rows.div_ceil(TILE), grid.columns.div_ceil(TILE));
        let tiles = u64::from(gpu.device.limits().max_compute_workgroups_per_dimension);
        check_size("a row of tiles", down.max(across) as u64, tiles)?;
        Ok(Self {
            grid: GridUniform {
                rows: grid.rows as u32,
                columns: grid.columns as u32,
                tiles_across: across as u32,
                limit: 0,
            },
            tiles_down: down as u32,
            cells: storage_buffer(gpu, "the floor grid", &cells)?,
        })
    }
}

/// A storage buffer with contents, which must not be empty.
fn storage_buffer<T: Pod>(gpu: &Gpu, what: &'static str, contents: &[T]) -> Result<wgpu::Buffer, GpuError> {
    let limits = gpu.device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    check_size(what, size_of_val(contents) as u64, limit)?;
    Ok(gpu.filled_buffer(what, bytemuck::cast_slice(contents), wgpu::BufferUsages::STORAGE))
}

fn check_size(what: &'static str, bytes: u64, limit: u64) -> Result<(), GpuError> {
    if bytes > limit { Err(GpuError::TooLarge { what, bytes, limit }) } else { Ok(()) }
}

impl ResidualKernel {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError::Failed`] if the device rejects it.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let device = &gpu.device;
        gpu.in_error_scope(|| {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("residual"),
                source: wgpu::ShaderSource::Wgsl(include_str!("../../shaders/residual.wgsl").into()),
            });
            // In the order of the shader's bindings.
            let storage = |read_only| wgpu::BufferBindingType::Storage { read_only };
            let kinds = [
                wgpu::BufferBindingType::Uniform,
                storage(true),
                storage(true),
                storage(true),
                storage(true),
                storage(false),
                storage(false),
            ];
            let entries: Vec<_> = (0..)
                .zip(kinds)
                .map(|(binding, ty)| wgpu::BindGroupLayoutEntry {
                    binding,
                    visibility: wgpu::ShaderStages::COMPUTE,
                    ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
                    count: None,
                })
                .collect();
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("residual"),
                entries: &entries,
            });
            let pipelines = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("residual"),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = |traced: bool| {
                device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                    label: Some("residual"),
                    layout: Some(&pipelines),
                    module: &module,
                    entry_point: Some("residual_field"),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &[
                            ("TILE", TILE as f64),
                            ("CONTACT_TOLERANCE", f64::from(CONTACT_TOLERANCE)),
                            ("CUT_TOLERANCE", f64::from(CUT_TOLERANCE)),
                            ("FAR", f64::from(FAR)),
                            ("MIN_SQUARED_SINE", f64::from(MIN_SQUARED_SINE)),
                            ("MIN_COSINE", f64::from(MIN_COSINE)),
                            ("CORNER_STEPS", f64::from(CORNER_STEPS)),
                            ("CORNER_TOLERANCE", f64::from(CORNER_TOLERANCE)),
                            ("TRACED", f64::from(u8::from(traced))),
                        ],
                        ..Default::default()
                    },
                    cache: None,
                })
            };
            Self { heights: pipeline(false), traced: pipeline(true), layout }
        })
    }

    /// Uploads `cutters`, in cutting order, with their tiles over `floor`. Nothing is computed yet.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if they do not fit the device.
    pub fn field(
        &self,
        gpu: &Gpu,
        floor: &DeviceFloor,
        cutters: &[FieldCutter],
        bins: &TileBins,
    ) -> Result<DeviceField, GpuError> {
        // Buffers must not be empty; with no plunge in any tile the kernel reads none.
        let mut packed: Vec<PackedCutter> = cutters.iter().map(pack_cutter).collect();
        packed.resize(packed.len().max(1), PackedCutter::default());
        let some = [0];
        let list = if bins.list.is_empty() { &some } else { bins.list.as_slice() };
        let inputs = [
            storage_buffer(gpu, "the cutters", &packed)?,
            storage_buffer(gpu, "the offsets of tiles", &bins.offsets)?,
            storage_buffer(gpu, "the list of cutters per tile", list)?,
        ];
        let buffer = |label, size, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage,
                mapped_at_creation: false,
            })
        };
        let output = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
        let cells = u64::from(floor.grid.rows) * u64::from(floor.grid.columns);
        let heights = buffer("heights", cells * size_of::<f32>() as u64, output | wgpu::BufferUsages::VERTEX);
        let traces_bytes = (packed.len() * size_of::<PackedTrace>()) as u64;
        let traces = buffer("traces", traces_bytes, output | wgpu::BufferUsages::COPY_DST);
        let uniform = buffer(
            "floor grid",
            size_of::<GridUniform>() as u64,
            wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        );
        let buffers = [&uniform, &floor.cells, &inputs[0], &inputs[1], &inputs[2], &heights, &traces];
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("residual"),
            layout: &self.layout,
            entries: &entries,
        });
        let (grid, tiles_down) = (floor.grid, floor.tiles_down);
        Ok(DeviceField { grid, tiles_down, uniform, bindings, heights, traces })
    }

    /// Submits the computation of the stock after the first `count` plunges; does not wait. What is submitted
    /// later, such as a picture, sees its heights.
    pub fn compute(&self, gpu: &Gpu, field: &DeviceField, count: usize) {
        self.submit(gpu, field, count, &self.heights, |_| {});
    }

    fn submit(
        &self,
        gpu: &Gpu,
        field: &DeviceField,
        count: usize,
        pipeline: &wgpu::ComputePipeline,
        after: impl FnOnce(&mut wgpu::CommandEncoder),
    ) {
        let limit = u32::try_from(count).unwrap_or(u32::MAX);
        let uniform = GridUniform { limit, ..field.grid };
        gpu.queue.write_buffer(&field.uniform, 0, bytemuck::bytes_of(&uniform));
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &field.bindings, &[]);
            pass.dispatch_workgroups(field.grid.tiles_across, field.tiles_down, 1);
        }
        after(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
    }

    /// Applies `cutters` in cutting order to every cell of `grid`, and waits for the result.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] if the grid does not fit the device, [`GpuError::Failed`] if it fails.
    pub fn run(
        &self,
        gpu: &Gpu,
        grid: &FloorGrid,
        cutters: &[FieldCutter],
    ) -> Result<ResidualField, GpuError> {
        self.run_first(gpu, grid, cutters, cutters.len())
    }

    /// As [`Self::run`], of the first `count` cutters only; the traces of the others stay zero.
    ///
    /// # Errors
    /// As of [`Self::run`].
    pub fn run_first(
        &self,
        gpu: &Gpu,
        grid: &FloorGrid,
        cutters: &[FieldCutter],
        count: usize,
    ) -> Result<ResidualField, GpuError> {
        if grid.rows * grid.columns == 0 || cutters.is_empty() {
            // Buffers and dispatches must not be empty.
            let traces = vec![PositionTrace::default(); cutters.len()];
            return Ok(ResidualField { heights: grid.blank_heights.clone(), traces });
        }
        let (bins, unit) = (TileBins::new(grid, cutters), VolumeUnit::from_grid(grid));
        let (readback, heights_bytes) = gpu.in_error_scope(|| -> Result<_, GpuError> {
            let floor = DeviceFloor::new(gpu, grid, Some(unit))?;
            let field = self.field(gpu, &floor, cutters, &bins)?;
            let (heights_bytes, traces_bytes) = (field.heights.size(), field.traces.size());
            let readback = gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("residual readback"),
                size: heights_bytes + traces_bytes,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            });
            // wgpu zero-initialises buffers, so the traces of a new field start from zero.
            self.submit(gpu, &field, count, &self.traced, |encoder| {
                encoder.copy_buffer_to_buffer(&field.heights, 0, &readback, 0, heights_bytes);
                encoder.copy_buffer_to_buffer(&field.traces, 0, &readback, heights_bytes, traces_bytes);
            });
            Ok((readback, heights_bytes))
        })??;
        let bytes = gpu.read_buffer(&readback)?;
        let (heights, traces) = bytes.split_at(heights_bytes as usize);
        let heights = heights.chunks_exact(size_of::<f32>()).map(bytemuck::pod_read_unaligned).collect();
        let traces = traces
            .chunks_exact(size_of::<PackedTrace>())
            .map(|b| unpack_trace(bytemuck::pod_read_unaligned(b)).trace(unit))
            .collect();
        Ok(ResidualField { heights, traces })
    }
}

impl Gpu {
    /// Runs `work` in error scopes; returns the first error that the device reports.
    pub(super) fn in_error_scope<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let validation = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let result = work();
        let validation = pollster::block_on(validation.pop());
        let memory = pollster::block_on(memory.pop());
        match validation.or(memory) {
            Some(error) => Err(GpuError::Failed(error.to_string())),
            None => Ok(result),
        }
    }

    /// Waits for the device and copies a mappable buffer out.
    fn read_buffer(&self, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
        let failed = |error: &dyn std::fmt::Display| GpuError::Failed(error.to_string());
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver is dropped only if the wait below failed, which is then reported.
            let _ = sender.send(result);
        });
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        match receiver.recv() {
            Ok(result) => result.map_err(|error| failed(&error))?,
            Err(error) => return Err(failed(&error)),
        }
        let bytes = buffer.get_mapped_range(..).map_err(|error| failed(&error))?.to_vec();
        buffer.unmap();
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stock::field::tests::{any_cutter, saddle};
    use crate::stock::residual_field;
    use proptest::strategy::{Strategy, ValueTree};
    use proptest::test_runner::TestRunner;

    /// How far heights may differ, mm: a card may fuse products and sums, and rounds roots differently.
    /// The software driver has always given equal bits.
    const HEIGHT_TOLERANCE: f32 = 1e-4;

    /// Compares heights and all traces of both kernels. A ray that grazes a wall may be in on one side and
    /// out on the other, which moves the counts of a position by a few cells and its volume by what stands
    /// there.
    fn compare(grid: &FloorGrid, gpu: &ResidualField, cpu: &ResidualField) {
        let greatest = |values: &[f32]| values.iter().copied().fold(0.0, f32::max);
        const GRAZING: u32 = 8;
        let grazing_volume = GRAZING as f32 * greatest(&grid.areas) * greatest(&grid.blank_heights);
        let off = |(a, b): &(&f32, &f32)| (*a - *b).abs() > HEIGHT_TOLERANCE;
        assert_eq!(gpu.heights.len(), cpu.heights.len());
        let grazing = gpu.heights.iter().zip(&cpu.heights).filter(off).count();
        assert!(grazing * 500 <= gpu.heights.len(), "{grazing} cells differ");
        assert_eq!(gpu.traces.len(), cpu.traces.len());
        let mut deep = 0;
        for (a, b) in gpu.traces.iter().zip(&cpu.traces) {
            assert!(a.swept_cells.abs_diff(b.swept_cells) <= GRAZING, "swept: {a:?} {b:?}");
            assert!(a.cut_cells.abs_diff(b.cut_cells) <= GRAZING, "cut: {a:?} {b:?}");
            assert!(a.contact_cells.abs_diff(b.contact_cells) <= GRAZING, "contact cells: {a:?} {b:?}");
            let volume = grazing_volume + HEIGHT_TOLERANCE * greatest(&grid.areas) * a.swept_cells as f32;
            assert!((a.removed_volume - b.removed_volume).abs() <= volume, "volume: {a:?} {b:?}");
            // The deepest point may be on a ray that grazes the core.
            deep += usize::from((a.contact_depth - b.contact_depth).abs() > 10.0 * HEIGHT_TOLERANCE);
        }
        assert!(deep * 50 <= gpu.traces.len(), "{deep} of {} depths of contact differ", gpu.traces.len());
    }

    #[test]
    fn the_kernel_equals_its_cpu_twin_in_heights_and_all_traces() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let kernel = ResidualKernel::new(&gpu).expect("the kernel compiles");
        let grid = saddle(101, 83);
        let mut runner = TestRunner::deterministic();
        // More cutters than one batch of the shader.
        for count in [1, 20, 300] {
            let cutters: Vec<FieldCutter> =
                (0..count).map(|_| any_cutter().new_tree(&mut runner).expect("a cutter").current()).collect();
            let cpu = residual_field(&grid, &cutters);
            let field = kernel.run(&gpu, &grid, &cutters).expect("the kernel runs");
            println!("{}, {count} cutters: equal bits: {}", gpu.info.name, field == cpu);
            compare(&grid, &field, &cpu);
            if count == 300 {
                let sum = |value: fn(&PositionTrace) -> f32| cpu.traces.iter().map(value).sum::<f32>();
                assert!(sum(|t| t.contact_depth) > 1.0 && sum(|t| t.contact_cells as f32) > 100.0);
                assert!(sum(|t| t.removed_volume) > 100.0, "the cutters meet stock, with their cores too");
            }
        }
        assert_eq!(gpu.take_errors(), Vec::<String>::new());
    }

    #[test]
    fn a_range_of_the_same_buffers_is_the_state_after_so_many_plunges() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let kernel = ResidualKernel::new(&gpu).expect("the kernel compiles");
        let grid = saddle(40, 70);
        let mut runner = TestRunner::deterministic();
        let cutters: Vec<FieldCutter> =
            (0..150).map(|_| any_cutter().new_tree(&mut runner).expect("a cutter").current()).collect();
        // Within a batch, at its border, and all.
        for count in [0, 1, 63, 64, 65, 100, 150, 1000] {
            let field = kernel.run_first(&gpu, &grid, &cutters, count).expect("the kernel runs");
            let mut cpu = residual_field(&grid, &cutters[..count.min(150)]);
            cpu.traces.resize(150, PositionTrace::default());
            compare(&grid, &field, &cpu);
        }
    }

    #[test]
    fn nothing_to_cut_leaves_the_blank() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let kernel = ResidualKernel::new(&gpu).expect("the kernel compiles");
        let grid = saddle(17, 5);
        let run = |cutters: &[FieldCutter]| kernel.run(&gpu, &grid, cutters).expect("the kernel runs");
        assert_eq!(run(&[]), residual_field(&grid, &[]));
        let far = FieldCutter { tip: [0.0; 3], radius: 1.0, axis: [0.0, 0.0, 1.0], ..Default::default() };
        assert_eq!(run(&[far]), residual_field(&grid, &[far]));
    }
}
