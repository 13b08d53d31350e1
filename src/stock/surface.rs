//! Triangulation of the floor of a grid for drawing.

use super::FloorGrid;
use crate::mesh::grid_triangles;

/// Largest number of lines along s and across of a surface that shows every plunge.
pub const MAX_LINES: (usize, usize) = (257, 129);

/// Distance below the blank's height within which a cell still counts as uncut, mm. The shader gets it too.
pub const UNCUT_TOLERANCE: f32 = 1e-3;

/// The floor as triangles with some of its cells as vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct FloorSurface {
    /// Cells that are vertices, row by row.
    pub cells: Vec<usize>,
    /// Three indices into `cells` each, counter-clockwise seen along −s × λ. Cells outside the floor
    /// (under a splitter, within the allowance of a wall) have none.
    pub triangles: Vec<[u32; 3]>,
}

impl FloorSurface {
    /// The floor, thinned to at most `most` lines along s and across. The outermost lines are kept.
    pub fn new(grid: &FloorGrid, most: (usize, usize)) -> Self {
        let (rows, columns) = (thinned_lines(grid.rows, most.0), thinned_lines(grid.columns, most.1));
        let cell = |i: usize, j: usize| rows[i] * grid.columns + columns[j];
        let floor = |i: usize, j: usize| grid.floor[cell(i, j)];
        let keep =
            |i: usize, j: usize| floor(i, j) && floor(i + 1, j) && floor(i, j + 1) && floor(i + 1, j + 1);
        let cells = (0..rows.len()).flat_map(|i| (0..columns.len()).map(move |j| (i, j)));
        Self {
            cells: cells.map(|(i, j)| cell(i, j)).collect(),
            triangles: grid_triangles(rows.len(), columns.len(), keep),
        }
    }
}

/// At most `most` of `count` lines, evenly spaced; the outermost are kept.
pub(super) fn thinned_lines(count: usize, most: usize) -> Vec<usize> {
    let kept = count.min(most);
    let step = |i: usize| if kept > 1 { i * (count - 1) / (kept - 1) } else { 0 };
    (0..kept).map(step).collect()
}

/// Whether no position has taken anything off a cell with that height of stock.
pub fn is_uncut(grid: &FloorGrid, cell: usize, height: f32) -> bool {
    height >= grid.blank_heights[cell] - UNCUT_TOLERANCE
}

/// Colour range that is robust to outliers: lowest height to the 98th percentile of cut cells, mm. (0, 1)
/// without cut cells.
pub fn fitting_range(grid: &FloorGrid, heights: &[f32]) -> (f32, f32) {
    let mut cut: Vec<f32> = heights
        .iter()
        .enumerate()
        .filter(|&(cell, &height)| grid.floor[cell] && !is_uncut(grid, cell, height))
        .map(|(_, height)| *height)
        .collect();
    if cut.is_empty() {
        return (0.0, 1.0);
    }
    cut.sort_by(f32::total_cmp);
    let low = cut[0];
    let high = cut[(cut.len() - 1) * 98 / 100];
    (low, high.max(low + 1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_grids_are_thinned_and_keep_their_corners() {
        let surface = FloorSurface::new(&FloorGrid::flat(600, 400), MAX_LINES);
        assert_eq!(surface.triangles.len(), 256 * 128 * 2);
        assert_eq!((surface.cells[0], surface.cells.last()), (0, Some(&(600 * 400 - 1))));
    }

    #[test]
    fn cells_without_floor_are_left_out() {
        let mut grid = FloorGrid::flat(4, 4);
        grid.floor[5] = false;
        assert_eq!(FloorSurface::new(&grid, MAX_LINES).triangles.len(), (9 - 4) * 2);
    }

    #[test]
    fn the_range_ignores_uncut_cells_and_outliers() {
        let grid = FloorGrid::flat(10, 20);
        let mut heights: Vec<f32> = (0..200).map(|k| 0.5 + k as f32 * 0.01).collect();
        heights[0] = 20.0;
        heights[1] = 15.0;
        let (low, high) = fitting_range(&grid, &heights);
        assert!((low - 0.52).abs() < 1e-6 && high < 2.5, "{low} {high}");
        assert_eq!(fitting_range(&grid, &[20.0; 200]), (0.0, 1.0));
    }
}
