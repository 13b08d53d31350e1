//! The floor of a channel at several resolutions, and a plan's plunges sorted into the tiles of each: what a
//! device needs to compute and draw the stock after any number of plunges.
//!
//! Sorting takes milliseconds, so a planner's thread does it once per plan. The state after k plunges needs
//! no sorting of its own: the list of a tile is in cutting order, and the kernel stops at k.

use std::sync::Arc;

use super::field_cutter::FieldCutter;
use super::grid::FloorGrid;
use super::surface::{FloorSurface, thinned_lines};
use super::tiles::{TILE, TileBins};

/// Largest number of grid lines along s and across of each resolution, coarsest first. The last keeps every
/// cell.
const LINES: [(usize, usize); 4] = [(65, 25), (129, 65), (257, 129), (usize::MAX, usize::MAX)];

/// The floor at one resolution.
#[derive(Clone, Debug)]
pub struct FloorLevel {
    /// Its cells: some or all of those of the whole grid.
    pub grid: FloorGrid,
    /// Triangles between the cells, three indices each; see [`FloorSurface::triangles`].
    pub triangles: Vec<[u32; 3]>,
}

/// The floor at several resolutions.
#[derive(Clone, Debug)]
pub struct FloorLevels {
    source: Arc<FloorGrid>,
    levels: Vec<FloorLevel>,
}

impl FloorLevels {
    /// All resolutions of a grid. A small grid has fewer of them.
    pub fn new(grid: &Arc<FloorGrid>) -> Self {
        let mut levels: Vec<FloorLevel> = Vec::new();
        for lines in LINES {
            let thin = grid.thinned(lines);
            let same =
                |known: &FloorLevel| (known.grid.rows, known.grid.columns) == (thin.rows, thin.columns);
            if levels.last().is_none_or(|known| !same(known)) {
                let triangles = FloorSurface::new(&thin, lines).triangles;
                levels.push(FloorLevel { grid: thin, triangles });
            }
        }
        Self { source: Arc::clone(grid), levels }
    }

    /// Whether these are the resolutions of `grid`.
    pub fn is_of(&self, grid: &Arc<FloorGrid>) -> bool {
        Arc::ptr_eq(&self.source, grid)
    }

    /// The resolutions, coarsest first; never empty.
    pub fn levels(&self) -> &[FloorLevel] {
        &self.levels
    }

    /// The index of the finest resolution.
    pub fn finest(&self) -> usize {
        self.levels.len() - 1
    }
}

/// The plunges of a plan, in cutting order, sorted into the tiles of every resolution of a floor.
#[derive(Clone, Debug)]
pub struct FieldProgram {
    /// The floor.
    pub floor: Arc<FloorLevels>,
    /// The plunges.
    pub cutters: Vec<FieldCutter>,
    /// Their tiles, per resolution.
    pub bins: Vec<TileBins>,
}

impl FieldProgram {
    /// Sorts `cutters` into the tiles of `floor`, on the calling thread alone, as listeners of planning jobs
    /// need it.
    pub fn new(floor: &Arc<FloorLevels>, cutters: Vec<FieldCutter>) -> Self {
        let bins =
            floor.levels().iter().map(|level| TileBins::on_one_thread(&level.grid, &cutters)).collect();
        Self { floor: Arc::clone(floor), cutters, bins }
    }

    /// Work of the kernel at a resolution: number of rays that it intersects with cutters.
    pub fn meetings(&self, level: usize) -> usize {
        self.bins.get(level).map_or(0, |bins| bins.list.len() * TILE * TILE)
    }

    /// The finest resolution at which the kernel has at most `most` rays to intersect with cutters; the
    /// coarsest if none.
    pub fn finest_within(&self, most: usize) -> usize {
        (0..self.bins.len()).rev().find(|&level| self.meetings(level) <= most).unwrap_or(0)
    }
}

impl FloorGrid {
    /// The grid with at most `most` of its lines along s and across, evenly spaced, the outermost kept. Areas
    /// grow accordingly.
    fn thinned(&self, most: (usize, usize)) -> Self {
        self.picked(&thinned_lines(self.rows, most.0), &thinned_lines(self.columns, most.1))
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::tests::saddle;
    use super::super::residual_field;
    use super::*;

    fn plunge(x: f32, y: f32) -> FieldCutter {
        FieldCutter { tip: [x, y, 41.0], radius: 4.0, axis: [0.0, 0.0, 1.0], ..Default::default() }
    }

    #[test]
    fn a_coarse_level_has_the_heights_of_the_whole_grid_in_its_cells() {
        let grid = Arc::new(saddle(300, 90));
        let floor = Arc::new(FloorLevels::new(&grid));
        let sizes: Vec<_> = floor.levels().iter().map(|l| (l.grid.rows, l.grid.columns)).collect();
        assert_eq!(sizes, [(65, 25), (129, 65), (257, 90), (300, 90)]);
        let cutters: Vec<_> = (0..9).map(|k| plunge(160.0 + 5.0 * k as f32, k as f32 - 4.0)).collect();
        let whole = residual_field(&grid, &cutters).heights;
        for level in floor.levels() {
            let heights = residual_field(&level.grid, &cutters).heights;
            let lines = (thinned_lines(300, level.grid.rows), thinned_lines(90, level.grid.columns));
            let cells = lines.0.iter().flat_map(|i| lines.1.iter().map(move |j| i * 90 + j));
            assert!(cells.zip(&heights).all(|(cell, &height)| whole[cell] == height));
            let area = |grid: &FloorGrid| grid.areas.iter().sum::<f32>();
            assert!((area(&level.grid) / area(&grid) - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn a_small_grid_has_one_level_and_work_grows_with_the_level() {
        let small = FloorLevels::new(&Arc::new(FloorGrid::flat(10, 10)));
        assert_eq!((small.levels().len(), small.finest()), (1, 0));
        let floor = Arc::new(FloorLevels::new(&Arc::new(saddle(300, 90))));
        let program = FieldProgram::new(&floor, (0..20).map(|k| plunge(155.0 + k as f32, 0.0)).collect());
        let work: Vec<usize> = (0..=floor.finest()).map(|level| program.meetings(level)).collect();
        assert!(work.is_sorted(), "{work:?}");
        assert_eq!(program.finest_within(work[1]), 1);
        assert_eq!(program.finest_within(usize::MAX), 3);
        assert_eq!(program.finest_within(0), 0, "never less than the coarsest");
    }
}
