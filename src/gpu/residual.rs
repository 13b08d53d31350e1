//! The residual heightfield on the graphics device; the CPU implementation is
//! [`crate::stock::residual_field`].
//!
//! On a software driver ([`Gpu::is_software`]) the CPU implementation gives the same result several times
//! faster.

use std::sync::mpsc;

use bytemuck::{Pod, Zeroable};
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::device::{Gpu, GpuError};
use crate::stock::field::{CONTACT_TOLERANCE, CUT_TOLERANCE};
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

/// The kernel of `shaders/residual.wgsl`, compiled for one device.
#[derive(Debug)]
pub struct ResidualKernel {
    pipeline: wgpu::ComputePipeline,
}

/// `Grid` of the shader.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct GridUniform {
    rows: u32,
    columns: u32,
    tiles_across: u32,
    pad: u32,
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

impl ResidualKernel {
    /// Compiles the kernel.
    ///
    /// # Errors
    /// [`GpuError::Failed`] if the device rejects it.
    pub fn new(gpu: &Gpu) -> Result<Self, GpuError> {
        let pipeline = gpu.in_error_scope(|| {
            let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("residual"),
                source: wgpu::ShaderSource::Wgsl(include_str!("../../shaders/residual.wgsl").into()),
            });
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("residual"),
                layout: None,
                module: &module,
                entry_point: Some("residual_field"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[
                        ("CONTACT_TOLERANCE", f64::from(CONTACT_TOLERANCE)),
                        ("CUT_TOLERANCE", f64::from(CUT_TOLERANCE)),
                    ],
                    ..Default::default()
                },
                cache: None,
            })
        })?;
        Ok(Self { pipeline })
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
        let unit = VolumeUnit::of(grid);
        let cells: Vec<PackedCell> = (0..grid.rows * grid.columns)
            .map(|cell| PackedCell {
                foot: grid.points[cell],
                blank: grid.blank_heights[cell],
                normal: grid.normals[cell],
                units: if grid.floor[cell] { unit.per_height(grid.areas[cell]) } else { -1.0 },
            })
            .collect();
        if cells.is_empty() || cutters.is_empty() {
            // Buffers and dispatches must not be empty.
            let traces = vec![PositionTrace::default(); cutters.len()];
            return Ok(ResidualField { heights: grid.blank_heights.clone(), traces });
        }
        let mut bins = TileBins::new(grid, cutters);
        if bins.list.is_empty() {
            bins.list.push(0);
        }
        let limits = gpu.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let tiles = limits.max_compute_workgroups_per_dimension as usize;
        for (what, bytes, limit) in [
            ("the floor grid", size_of_val(cells.as_slice()) as u64, limit),
            ("the list of cutters per tile", size_of_val(bins.list.as_slice()) as u64, limit),
            ("a row of tiles", bins.down.max(bins.across) as u64, tiles as u64),
        ] {
            if bytes > limit {
                return Err(GpuError::TooLarge { what, bytes, limit });
            }
        }
        let heights_bytes = (cells.len() * size_of::<f32>()) as u64;
        let packed: Vec<PackedCutter> = cutters.iter().map(pack_cutter).collect();
        let traces_bytes = (cutters.len() * size_of::<PackedTrace>()) as u64;

        let readback = gpu.in_error_scope(|| {
            let input = |label, contents, usage| {
                gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
            };
            let output = |label, size, usage| {
                gpu.device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size,
                    usage,
                    mapped_at_creation: false,
                })
            };
            let storage = wgpu::BufferUsages::STORAGE;
            let uniform = GridUniform {
                rows: grid.rows as u32,
                columns: grid.columns as u32,
                tiles_across: bins.across as u32,
                pad: 0,
            };
            // wgpu zero-initialises buffers; traces start from zero.
            let heights = output("heights", heights_bytes, storage | wgpu::BufferUsages::COPY_SRC);
            let traces = output("traces", traces_bytes, storage | wgpu::BufferUsages::COPY_SRC);
            let readback = output(
                "residual readback",
                heights_bytes + traces_bytes,
                wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            );
            let buffers = [
                input("floor grid", bytemuck::bytes_of(&uniform), wgpu::BufferUsages::UNIFORM),
                input("cells", bytemuck::cast_slice(&cells), storage),
                input("cutters", bytemuck::cast_slice(&packed), storage),
                input("tile offsets", bytemuck::cast_slice(&bins.offsets), storage),
                input("tile cutters", bytemuck::cast_slice(&bins.list), storage),
                heights,
                traces,
            ];
            let entries: Vec<_> = buffers
                .iter()
                .zip(0..)
                .map(|(buffer, binding)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("residual"),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &entries,
            });
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            {
                let mut pass = encoder.begin_compute_pass(&Default::default());
                pass.set_pipeline(&self.pipeline);
                pass.set_bind_group(0, &bindings, &[]);
                pass.dispatch_workgroups(bins.across as u32, bins.down as u32, 1);
            }
            encoder.copy_buffer_to_buffer(&buffers[5], 0, &readback, 0, heights_bytes);
            encoder.copy_buffer_to_buffer(&buffers[6], 0, &readback, heights_bytes, traces_bytes);
            gpu.queue.submit([encoder.finish()]);
            readback
        })?;

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
    fn in_error_scope<T>(&self, work: impl FnOnce() -> T) -> Result<T, GpuError> {
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

    #[test]
    fn the_kernel_equals_its_cpu_twin() {
        let gpu = Gpu::headless().expect("a Vulkan driver");
        let kernel = ResidualKernel::new(&gpu).expect("the kernel compiles");
        let grid = saddle(101, 83);
        let greatest = |values: &[f32]| values.iter().copied().fold(0.0, f32::max);
        let grazing_volume = 8.0 * greatest(&grid.areas) * greatest(&grid.blank_heights);
        let mut runner = TestRunner::deterministic();
        // More cutters than one batch of the shader.
        for count in [1, 20, 300] {
            let cutters: Vec<FieldCutter> =
                (0..count).map(|_| any_cutter().new_tree(&mut runner).expect("a cutter").current()).collect();
            let cpu = residual_field(&grid, &cutters);
            let field = kernel.run(&gpu, &grid, &cutters).expect("the kernel runs");
            println!("{}, {count} cutters: equal bits: {}", gpu.info.name, field == cpu);
            // A ray that grazes a wall may be in on one side and out on the other.
            let off = |(a, b): &(&f32, &f32)| (*a - *b).abs() > HEIGHT_TOLERANCE;
            let grazing = field.heights.iter().zip(&cpu.heights).filter(off).count();
            assert!(grazing * 500 <= field.heights.len(), "{grazing} cells differ");
            for (a, b) in field.traces.iter().zip(&cpu.traces) {
                assert!(a.swept_cells.abs_diff(b.swept_cells) <= 8, "{a:?} {b:?}");
                let swept_area = greatest(&grid.areas) * a.swept_cells as f32;
                let tolerance = grazing_volume + HEIGHT_TOLERANCE * swept_area;
                assert!((a.removed_volume - b.removed_volume).abs() <= tolerance, "{a:?} {b:?}");
            }
        }
        assert_eq!(gpu.take_errors(), Vec::<String>::new());
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
