//! The grid of cells over a channel's hub floor.

/// Cells over the hub floor of one channel, `rows` along s (row 0 at s = 0, the leading edge;
/// last row at s = 1, the rim) times `columns` along λ (0 suction wall → 1 pressure wall).
/// Cell (i, j) is at index `i * columns + j` of every list. f32, mm.
#[derive(Clone, Debug)]
pub struct FloorGrid {
    /// Number of cells along s.
    pub rows: usize,
    /// Number of cells along λ.
    pub columns: usize,
    /// Foot of each cell's ray on the finished hub.
    pub points: Vec<[f32; 3]>,
    /// Unit normal of the hub at the foot, into the channel.
    pub normals: Vec<[f32; 3]>,
    /// Height of the blank above the foot along the normal: what is there before any cut.
    pub blank_heights: Vec<f32>,
    /// Area of each cell, mm².
    pub areas: Vec<f32>,
    /// Whether the cell belongs to the floor (not under a splitter, not within the blade allowance).
    pub floor: Vec<bool>,
}
