//! Which plunges bound the stock over each cell of the floor, and what would bound it without them.

use rayon::prelude::*;

use super::field_cutter::FieldCutter;
use super::grid::FloorGrid;
use super::meeting::{FAR, Meeting};
use super::tiles::{TILE, TileBins};

/// Height at which a plunge ends the stock of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellEntry {
    /// Height above the finished hub along its normal, mm.
    pub height: f32,
    /// Index of the plunge.
    pub cutter: u32,
}

/// The plunges over every cell of a floor grid, lowest first. Heights are those of
/// [`residual_field`](super::residual_field).
#[derive(Clone, Debug)]
pub struct CellCover {
    /// Start of each cell's part of `entries`, and the number of entries at the end.
    offsets: Vec<usize>,
    entries: Vec<CellEntry>,
}

impl CellCover {
    /// The plunges `cutters` over the cells of `grid`. Only reachable cells of the floor have entries.
    pub fn new(grid: &FloorGrid, cutters: &[FieldCutter]) -> Self {
        let bins = TileBins::new(grid, cutters);
        let of_cell = |cell: usize| -> Vec<CellEntry> {
            if !(grid.floor[cell] && grid.reachable[cell]) {
                return Vec::new();
            }
            let tile = (cell / grid.columns / TILE, cell % grid.columns / TILE);
            let mut entries: Vec<CellEntry> = bins
                .cutters_of(tile.0, tile.1)
                .iter()
                .map(|&cutter| CellEntry { height: entry(grid, cell, &cutters[cutter as usize]), cutter })
                .filter(|entry| entry.height < grid.blank_heights[cell])
                .collect();
            entries.sort_unstable_by(|a, b| a.height.total_cmp(&b.height).then(a.cutter.cmp(&b.cutter)));
            entries
        };
        let lists: Vec<Vec<CellEntry>> =
            (0..grid.rows * grid.columns).into_par_iter().with_min_len(64).map(of_cell).collect();
        let mut offsets = Vec::with_capacity(lists.len() + 1);
        let mut entries = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        offsets.push(0);
        for list in lists {
            entries.extend(list);
            offsets.push(entries.len());
        }
        Self { offsets, entries }
    }

    /// The plunges over `cell`, lowest first.
    pub fn of_cell(&self, cell: usize) -> &[CellEntry] {
        &self.entries[self.offsets[cell]..self.offsets[cell + 1]]
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Whether there are no cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Height at which the ray of `cell` enters `cutter`, mm.
fn entry(grid: &FloorGrid, cell: usize, cutter: &FieldCutter) -> f32 {
    let meeting = Meeting::new(grid.points[cell], grid.normals[cell], cutter);
    let sharp = meeting.entry(cutter.radius * cutter.radius);
    if cutter.corner_radius > 0.0 && sharp < FAR { meeting.corner_entry(sharp, cutter) } else { sharp }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stock::residual_field;

    #[test]
    fn the_lowest_entry_is_the_height_of_the_field() {
        let grid = FloorGrid::flat(40, 40);
        let cutters: Vec<FieldCutter> = (0..30)
            .map(|k| {
                let k = k as f32;
                let axis = [0.02 * (k - 15.0), 0.01 * k, 1.0];
                let length = (axis[0] * axis[0] + axis[1] * axis[1] + 1.0).sqrt();
                FieldCutter {
                    tip: [(7.0 * k) % 40.0, (11.0 * k) % 40.0, 0.3 + 0.02 * k],
                    radius: 6.0,
                    axis: axis.map(|x| x / length),
                    core_radius: 2.0,
                    corner_radius: if k % 2.0 == 0.0 { 0.0 } else { 1.5 },
                }
            })
            .collect();
        let field = residual_field(&grid, &cutters);
        let cover = CellCover::new(&grid, &cutters);
        let mut bounded = 0;
        for (cell, &height) in field.heights.iter().enumerate() {
            let lowest = cover.of_cell(cell).first().map_or(grid.blank_heights[cell], |entry| entry.height);
            assert!((lowest - height).abs() < 1e-4, "cell {cell}: {lowest}, {height} by the field");
            bounded += usize::from(cover.of_cell(cell).len() > 1);
        }
        assert!(bounded > 200, "{bounded} cells with a choice");
    }
}
