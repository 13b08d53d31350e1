//! CPU twin of `shaders/residual.wgsl`: same inputs, same arithmetic, same results.

use super::grid::FloorGrid;

/// One plunge as the kernels see it: a cylinder from the tip upwards. 48 bytes, matches the WGSL struct.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "gpu", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct CutterGpu {
    /// Tip M: centre of the bottom, mm.
    pub tip: [f32; 3],
    /// Radius R, mm.
    pub radius: f32,
    /// Unit axis, tip → holder.
    pub axis: [f32; 3],
    /// Core radius R − w, mm.
    pub core_radius: f32,
    /// Corner radius, mm.
    pub corner_radius: f32,
    /// Padding.
    pub pad: [f32; 3],
}

/// What the heightfield saw of one position.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionTrace {
    /// Greatest height of stock in the core above its bottom, mm along the tool axis.
    pub contact_depth: f32,
    /// Cells in which the core meets stock.
    pub contact_cells: u32,
    /// Cells the cutter sweeps over.
    pub swept_cells: u32,
    /// Cells in which it removes stock; the rest of the swept cells is cut in air.
    pub cut_cells: u32,
}

/// Heights of stock above the finished hub after some positions were cut.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualField {
    /// Height along the hub normal per cell, mm; the blank's height where nothing was cut.
    pub heights: Vec<f32>,
    /// Per position, in cutting order.
    pub traces: Vec<PositionTrace>,
}

/// Walks `cutters` in cutting order over every cell of `grid`.
pub fn residual_field(_grid: &FloorGrid, _cutters: &[CutterGpu]) -> ResidualField {
    todo!()
}
