//! The heightfield of stock left on the hub: CPU counterpart of `shaders/residual.wgsl`.
//!
//! Every cell has a ray P + h·n from the finished hub along its normal. A plunge removes the cylinder from
//! its tip upwards, and the cell keeps the lowest height at which its ray enters one. Both kernels do the
//! same operations in the same order on f32; keep it so, a test compares them.

use rayon::prelude::*;

use super::bounds::{RowBounds, RowStock};
use super::field_cutter::FieldCutter;
use super::grid::FloorGrid;
use super::meeting::{FAR, LaneRow, Meeting, MeetingRow, greatest, larger, mask, smaller};
use super::tiles::{TILE, TileBins};
use super::trace::{PositionTrace, TraceSums, VolumeUnit, whole_units_between};

mod cache;

pub use cache::FieldCache;

/// Depth above which a cell counts as contact of the core, mm. The kernel gets it as a constant.
pub const CONTACT_TOLERANCE: f32 = crate::cutting::contact::CONTACT_TOLERANCE as f32;
/// Height by which a cell must drop to count as cut, mm. The kernel gets it as a constant.
pub const CUT_TOLERANCE: f32 = 1e-4;

/// Heights of stock above the finished hub after some positions were cut.
#[derive(Clone, Debug, PartialEq)]
pub struct ResidualField {
    /// Height along the hub normal per cell, mm; the blank's height where nothing was cut.
    pub heights: Vec<f32>,
    /// Per position, in cutting order. Only cells of the floor count.
    pub traces: Vec<PositionTrace>,
}

/// Applies `cutters` in cutting order to every cell of `grid`.
///
/// For the state after k positions pass `&cutters[..k]`.
pub fn residual_field(grid: &FloorGrid, cutters: &[FieldCutter]) -> ResidualField {
    let bins = TileBins::new(grid, cutters);
    let mut heights = vec![0.0; grid.rows * grid.columns];
    if heights.is_empty() {
        return ResidualField { heights, traces: vec![PositionTrace::default(); cutters.len()] };
    }
    let unit = VolumeUnit::from_grid(grid);
    // One task per row of tiles, as a row is one contiguous piece of the heights.
    let seen: Vec<Vec<TraceSums>> = heights
        .par_chunks_mut(TILE * grid.columns)
        .enumerate()
        .map(|(down, heights)| {
            let mut seen = Vec::new();
            for across in 0..bins.across {
                let mut tile = Tile::load(grid, unit, down, across, true);
                seen.extend(bins.cutters_of(down, across).iter().map(|&k| tile.cut(&cutters[k as usize])));
                store(&tile.height, heights, across, grid.columns);
            }
            seen
        })
        .collect();
    let traces = traces(&bins, cutters.len(), unit, seen.iter().flatten());
    ResidualField { heights, traces }
}

/// The traces of `count` cutters, from what each tile has `seen` of its cutters, tile by tile.
///
/// Integer sums and maxima do not depend on how tiles were distributed over threads.
fn traces<'a>(
    bins: &TileBins,
    count: usize,
    unit: VolumeUnit,
    seen: impl Iterator<Item = &'a TraceSums>,
) -> Vec<PositionTrace> {
    let mut sums = vec![TraceSums::default(); count];
    for (&k, part) in bins.list.iter().zip(seen) {
        sums[k as usize].add(part);
    }
    sums.iter().map(|sums| sums.trace(unit)).collect()
}

/// Writes the heights of a tile to a row of tiles.
fn store(tile: &[LaneRow<f32>; TILE], heights: &mut [f32], across: usize, columns: usize) {
    let first = across * TILE;
    let lanes = TILE.min(columns - first);
    for (line, row) in heights.chunks_exact_mut(columns).zip(tile) {
        line[first..first + lanes].copy_from_slice(&row[..lanes]);
    }
}

/// The cells of one tile, by component, so that a row of them fits vector registers.
struct Tile {
    point: [[LaneRow<f32>; TILE]; 3],
    normal: [[LaneRow<f32>; TILE]; 3],
    blank: [LaneRow<f32>; TILE],
    height: [LaneRow<f32>; TILE],
    floor: [LaneRow<u32>; TILE],
    /// Units of volume per mm of height; 0 off the floor.
    units: [LaneRow<f32>; TILE],
    /// Number of floor cells per row.
    floor_cells: LaneRow<u32>,
    stock: RowStock,
    bounds: RowBounds,
    /// Whether the cells that a cutter sweeps are counted, also where it removes nothing.
    counts_swept: bool,
}

impl Tile {
    fn load(grid: &FloorGrid, unit: VolumeUnit, down: usize, across: usize, counts_swept: bool) -> Self {
        let zero = [[0.0; TILE]; TILE];
        let (mut point, mut normal, mut blank, mut units) = ([zero; 3], [zero; 3], zero, zero);
        let mut floor = [[0; TILE]; TILE];
        for row in 0..TILE {
            for lane in 0..TILE {
                // Beyond the edge of the grid the last cell is repeated, but it does not count as floor and
                // is not stored.
                let (i, j) = (down * TILE + row, across * TILE + lane);
                let cell = i.min(grid.rows - 1) * grid.columns + j.min(grid.columns - 1);
                for axis in 0..3 {
                    point[axis][row][lane] = grid.points[cell][axis];
                    normal[axis][row][lane] = grid.normals[cell][axis];
                }
                blank[row][lane] = grid.blank_heights[cell];
                let is_floor = i < grid.rows && j < grid.columns && grid.floor[cell];
                floor[row][lane] = u32::from(is_floor);
                units[row][lane] = if is_floor { unit.per_height(grid.areas[cell]) } else { 0.0 };
            }
        }
        Self {
            bounds: RowBounds::new(&point, &normal, &blank),
            floor_cells: floor.map(|row| row.iter().sum()),
            stock: RowStock::new(&blank),
            point,
            normal,
            blank,
            height: blank,
            floor,
            units,
            counts_swept,
        }
    }

    /// Removes what `cutter` sweeps.
    fn cut(&mut self, cutter: &FieldCutter) -> TraceSums {
        let mut sums = TraceSums::default();
        let verdicts = self.bounds.verdicts(cutter, &self.stock);
        for row in 0..TILE {
            if verdicts.reached[row] == 0 {
                continue;
            }
            // Where swept cells are not counted, a row is as one that is counted already.
            let sweeps_all = verdicts.swept[row] != 0 || !self.counts_swept;
            if sweeps_all && self.counts_swept {
                sums.swept_cells += self.floor_cells[row];
            }
            if !(sweeps_all && verdicts.untouched[row] != 0) {
                self.cut_row(row, cutter, sweeps_all, &mut sums);
            }
        }
        sums
    }

    /// Removes what `cutter` sweeps from one row; counts the cells it sweeps unless it `sweeps_all`.
    ///
    /// Loops over the lanes hold no branches, so that the compiler turns each into vector instructions.
    fn cut_row(&mut self, row: usize, cutter: &FieldCutter, sweeps_all: bool, sums: &mut TraceSums) {
        let squared_radius = cutter.radius * cutter.radius;
        let squared_core = cutter.core_radius * cutter.core_radius;
        let mut meetings = MeetingRow::default();
        let mut entries = [FAR; TILE];
        let mut touched = 0;
        let (blank, floor, units) = (self.blank[row], self.floor[row], self.units[row]);
        let height = self.height[row];
        for lane in 0..TILE {
            let meeting = Meeting::new(
                [self.point[0][row][lane], self.point[1][row][lane], self.point[2][row][lane]],
                [self.normal[0][row][lane], self.normal[1][row][lane], self.normal[2][row][lane]],
                cutter,
            );
            entries[lane] = meeting.entry(squared_radius);
            touched |= mask(entries[lane] < height[lane]);
            meetings.set(lane, meeting);
        }
        // Where the cutter enters no stock, its core does not either.
        if sweeps_all && touched == 0 {
            return;
        }
        if cutter.corner_radius > 0.0 {
            // A rounded corner only delays the entry: cells that the sharp cutter enters too late do not
            // change.
            let limit = if sweeps_all { height } else { blank };
            if cutter.corner_radius >= cutter.radius {
                for lane in 0..TILE {
                    let sharp = entries[lane];
                    let ball = meetings.get(lane).ball_entry(smaller(sharp, limit[lane]), cutter.radius);
                    entries[lane] = if sharp < limit[lane] { ball } else { sharp };
                }
            } else {
                for lane in 0..TILE {
                    if entries[lane] < limit[lane] {
                        entries[lane] = meetings.get(lane).corner_entry(entries[lane], cutter);
                    }
                }
            }
        }
        if !sweeps_all {
            sums.swept_cells += total(|lane| floor[lane] & mask(entries[lane] < blank[lane]));
        }
        if touched == 0 {
            return;
        }
        let mut core = 0;
        for lane in 0..TILE {
            core |= floor[lane] & mask(meetings.get(lane).may_touch(squared_core, height[lane]));
        }
        if core != 0 {
            let depths: LaneRow<f32> = std::array::from_fn(|lane| {
                let depth = meetings.get(lane).contact_depth(squared_core, height[lane]);
                if floor[lane] != 0 { depth } else { 0.0 }
            });
            sums.contact_depth = larger(sums.contact_depth, greatest(depths));
            sums.contact_cells += total(|lane| floor[lane] & mask(depths[lane] > CONTACT_TOLERANCE));
        }
        let left: LaneRow<f32> = std::array::from_fn(|lane| smaller(height[lane], entries[lane]));
        sums.cut_cells += total(|lane| floor[lane] & mask(height[lane] - left[lane] > CUT_TOLERANCE));
        sums.removed_units +=
            total(|lane| whole_units_between(height[lane] * units[lane], left[lane] * units[lane]));
        self.height[row] = left;
        self.stock.set(row, &left);
    }
}

/// The sum over the lanes of a row.
#[inline(always)]
fn total(value: impl Fn(usize) -> u32) -> u32 {
    (0..TILE).map(value).sum()
}

#[cfg(test)]
#[path = "field_tests.rs"]
pub(crate) mod tests;
