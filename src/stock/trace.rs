//! Effect of each position on the floor, summed over its cells.
//!
//! Removed volume is summed as a whole number of fixed units: integer sums do not depend on the order, so the
//! result does not depend on how cells are distributed over threads or workgroups.

use rayon::prelude::*;

use super::grid::FloorGrid;

/// Largest number of units of all stock over the floor.
const MAX_UNITS: f64 = (1_u32 << 31) as f64;
/// Largest number of units of the stock over one cell.
const MAX_UNITS_OF_CELL: f64 = (1_u32 << 22) as f64;

/// Effect of one position on the heightfield.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionTrace {
    /// Greatest height of stock in the core above its bottom, mm along the tool axis.
    pub contact_depth: f32,
    /// Cells in which the core meets stock.
    pub contact_cells: u32,
    /// Cells the cutter sweeps over.
    pub swept_cells: u32,
    /// Cells in which it removes stock; the other swept cells are air cuts.
    pub cut_cells: u32,
    /// Volume it removes over the floor, mm³: drop in height times area of the cell on the hub. As rays
    /// spread above a convex hub and close in above a hollow one, it is an estimate, best near the hub.
    pub removed_volume: f32,
}

/// A [`PositionTrace`] as the kernels accumulate it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TraceSums {
    /// Greatest depth of contact, mm.
    pub(crate) contact_depth: f32,
    pub(crate) contact_cells: u32,
    pub(crate) swept_cells: u32,
    pub(crate) cut_cells: u32,
    /// Removed volume in units of [`VolumeUnit`].
    pub(crate) removed_units: u32,
}

impl TraceSums {
    /// Adds the sums over another part of the grid for the same position.
    pub(crate) fn add(&mut self, other: &Self) {
        self.contact_depth = self.contact_depth.max(other.contact_depth);
        self.contact_cells += other.contact_cells;
        self.swept_cells += other.swept_cells;
        self.cut_cells += other.cut_cells;
        self.removed_units += other.removed_units;
    }

    pub(crate) fn trace(&self, unit: VolumeUnit) -> PositionTrace {
        PositionTrace {
            contact_depth: self.contact_depth,
            contact_cells: self.contact_cells,
            swept_cells: self.swept_cells,
            cut_cells: self.cut_cells,
            removed_volume: self.removed_units as f32 * unit.0,
        }
    }
}

/// Size of the units in which the kernels sum up removed volume, mm³; a power of two.
///
/// It is the smallest for which all stock over the floor is at most 2³¹ units and that over one cell at
/// most 2²². So the sum of one position fits in 32 bits with one bit to spare for rounding, for any cutter
/// and any number of cells, and single precision resolves every unit of a cell. The stock of a channel, some
/// 500 cm³, has units of 2⁻¹² mm³ from 64 × 64 cells on. The stock of each cell is rounded to whole
/// units before and after a cut, so a rounding error added to one position is subtracted from the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VolumeUnit(f32);

impl VolumeUnit {
    /// The smallest unit for the stock of `grid`.
    pub(crate) fn from_grid(grid: &FloorGrid) -> Self {
        // Row by row: sums in a fixed order give both kernels the same unit.
        let rows: Vec<[f64; 2]> =
            (0..grid.rows).into_par_iter().with_min_len(16).map(|row| stock_of_row(grid, row)).collect();
        let stock: f64 = rows.iter().map(|[sum, _]| sum).sum();
        let greatest = rows.iter().map(|[_, greatest]| *greatest).fold(0.0, f64::max);
        let least = (stock / MAX_UNITS).max(greatest / MAX_UNITS_OF_CELL);
        // Without stock any unit will do; the lower limit keeps it representable.
        let exponent = if least > 0.0 { least.log2().ceil().max(-100.0) } else { 0.0 };
        Self(exponent.exp2() as f32)
    }

    /// Units of stock per mm of height over the area of one cell, mm².
    pub(crate) fn per_height(self, area: f32) -> f32 {
        area / self.0
    }
}

/// Whole units between two volumes of stock over one cell, in units and each rounded, ties to even.
///
/// From 2²³ to 2²⁴ single precision represents exactly the whole numbers, and their bit patterns are
/// consecutive. A cast would do, but it is not vectorised.
#[inline(always)]
pub(crate) fn whole_units_between(above: f32, below: f32) -> u32 {
    const FIRST_WHOLE: f32 = (1 << 23) as f32;
    (above + FIRST_WHOLE).to_bits() - (below + FIRST_WHOLE).to_bits()
}

/// Volume of the blank over one row of the floor, and over the cell with most of it, mm³.
fn stock_of_row(grid: &FloorGrid, row: usize) -> [f64; 2] {
    let (mut sum, mut greatest) = (0.0, 0.0);
    for cell in row * grid.columns..(row + 1) * grid.columns {
        if grid.floor[cell] {
            let stock = f64::from(grid.blank_heights[cell]) * f64::from(grid.areas[cell]);
            sum += stock;
            greatest = if stock > greatest { stock } else { greatest };
        }
    }
    [sum, greatest]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(cells: usize, height: f32, area: f32) -> FloorGrid {
        FloorGrid {
            rows: cells,
            columns: cells,
            points: vec![[0.0; 3]; cells * cells],
            normals: vec![[0.0, 0.0, 1.0]; cells * cells],
            blank_heights: vec![height; cells * cells],
            areas: vec![area; cells * cells],
            floor: (0..cells * cells).map(|cell| cell % 2 == 0).collect(),
            reachable: vec![true; cells * cells],
        }
    }

    #[test]
    fn all_stock_fits_the_range() {
        for cells in [2, 24, 64, 512] {
            for (height, area) in [(1e-3, 1e-4), (20.0, 0.012), (60.0, 3.0), (500.0, 100.0)] {
                let grid = grid(cells, height, area);
                let of_cell = f64::from(height) * f64::from(VolumeUnit::from_grid(&grid).per_height(area));
                let of_all = of_cell * (cells * cells / 2) as f64;
                let filled = (of_cell / MAX_UNITS_OF_CELL).max(of_all / MAX_UNITS);
                assert!((0.5..=1.0).contains(&filled), "{cells}², {height} × {area}: {filled}");
            }
        }
    }

    #[test]
    fn whole_units_round_ties_to_even() {
        let most = MAX_UNITS_OF_CELL as f32;
        for volume in [0.0, 0.49, 0.5, 0.51, 1.0, 1.5, 2.5, 1234.5, 99_999.7, most - 0.5, most] {
            assert_eq!(whole_units_between(volume, 0.0), volume.round_ties_even() as u32, "{volume}");
            assert_eq!(whole_units_between(most, volume), most as u32 - volume.round_ties_even() as u32);
        }
    }
}
