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
    /// Height along the normal at which the ray first leaves the stock before any cut, mm: at the outline of
    /// the blank, or at the underside of a blade that leans over the cell, less the blade allowance. 0 under
    /// a blade.
    pub blank_heights: Vec<f32>,
    /// Area of each cell, mm².
    pub areas: Vec<f32>,
    /// Whether the cell belongs to the floor (not under a splitter, not within the blade allowance).
    pub floor: Vec<bool>,
    /// Whether any cutter used there could remove stock from the cell. None can where no more than the hub
    /// allowance stands, as at a slanted edge of the blank, and in the corner under a wall that leans over
    /// the cell (see [`super::reach`]).
    pub reachable: Vec<bool>,
}

#[cfg(test)]
impl FloorGrid {
    /// A level floor of cells 1 mm wide under 20 mm of stock.
    pub(crate) fn flat(rows: usize, columns: usize) -> Self {
        let count = rows * columns;
        Self {
            rows,
            columns,
            points: (0..count).map(|k| [(k / columns) as f32, (k % columns) as f32, 0.0]).collect(),
            normals: vec![[0.0, 0.0, 1.0]; count],
            blank_heights: vec![20.0; count],
            areas: vec![1.0; count],
            floor: vec![true; count],
            reachable: vec![true; count],
        }
    }
}

impl FloorGrid {
    /// Every `stride`-th cell along both directions, each standing for those left out.
    pub fn every(&self, stride: usize) -> Self {
        let lines = |count: usize| -> Vec<usize> { (0..count).step_by(stride.max(1)).collect() };
        self.picked(&lines(self.rows), &lines(self.columns))
    }

    /// The cells where the lines `rows` along s and `columns` across meet; areas grow so that these cells
    /// stand for all.
    pub(super) fn picked(&self, rows: &[usize], columns: &[usize]) -> Self {
        let cells: Vec<usize> =
            rows.iter().flat_map(|i| columns.iter().map(move |j| i * self.columns + j)).collect();
        let growth = (self.rows * self.columns) as f32 / cells.len().max(1) as f32;
        Self {
            rows: rows.len(),
            columns: columns.len(),
            points: cells.iter().map(|&cell| self.points[cell]).collect(),
            normals: cells.iter().map(|&cell| self.normals[cell]).collect(),
            blank_heights: cells.iter().map(|&cell| self.blank_heights[cell]).collect(),
            areas: cells.iter().map(|&cell| self.areas[cell] * growth).collect(),
            floor: cells.iter().map(|&cell| self.floor[cell]).collect(),
            reachable: cells.iter().map(|&cell| self.reachable[cell]).collect(),
        }
    }

    /// s of the middle of row `row`.
    pub fn s_of_row(&self, row: usize) -> f64 {
        (row as f64 + 0.5) / self.rows as f64
    }
}
