//! The heightfield for programs that follow each other and differ little.
//!
//! A tile depends on the cutters that reach it alone, in their order. As far as these are those of the
//! program before, their effect is taken over, and the tile goes on from the last heights kept within that
//! part.

use std::sync::Arc;

use rayon::prelude::*;

use super::{ResidualField, RowStock, TILE, Tile, TileBins, VolumeUnit, store, traces};
use crate::stock::field_cutter::FieldCutter;
use crate::stock::grid::FloorGrid;
use crate::stock::meeting::LaneRow;
use crate::stock::trace::TraceSums;

/// Number of equal parts of a tile's cutters; its heights after each are kept.
const KEPT_PARTS: usize = 16;

/// A floor with what is known of the last program cut into it.
pub struct FieldCache {
    grid: Arc<FloorGrid>,
    unit: VolumeUnit,
    cutters: Vec<FieldCutter>,
    bins: TileBins,
    tiles: Vec<KeptTile>,
    /// Number of parts of a tile's cutters after each of which its heights are kept.
    parts: usize,
}

impl FieldCache {
    /// `grid` before any program.
    pub fn new(grid: FloorGrid) -> Self {
        Self::with_parts(grid, KEPT_PARTS)
    }

    /// `grid` for one program: only the final heights of its tiles are kept.
    pub fn for_one(grid: FloorGrid) -> Self {
        Self::with_parts(grid, 1)
    }

    fn with_parts(grid: FloorGrid, parts: usize) -> Self {
        let (unit, bins) = (VolumeUnit::from_grid(&grid), TileBins::new(&grid, &[]));
        let tiles = vec![KeptTile::default(); bins.down * bins.across];
        Self { grid: Arc::new(grid), unit, cutters: Vec::new(), bins, tiles, parts }
    }

    /// The floor.
    pub fn grid(&self) -> &Arc<FloorGrid> {
        &self.grid
    }

    /// The same as [`super::residual_field`] of the floor and `cutters`, but that no swept cells are counted:
    /// where a cutter removes nothing it need not be known what it sweeps.
    pub fn residual_field(&mut self, cutters: Vec<FieldCutter>) -> ResidualField {
        let grid = &*self.grid;
        let bins = TileBins::new(grid, &cutters);
        let mut heights = vec![0.0; grid.rows * grid.columns];
        let row_length = (TILE * grid.columns).max(1);
        let rows = heights.par_chunks_mut(row_length).zip(self.tiles.par_chunks_mut(bins.across.max(1)));
        rows.enumerate().for_each(|(down, (heights, tiles))| {
            for (across, tile) in tiles.iter_mut().enumerate() {
                let (known, new) = (self.bins.cutters_of(down, across), bins.cutters_of(down, across));
                let same = |(a, b): &(&u32, &u32)| self.cutters[**a as usize] == cutters[**b as usize];
                let alike = known.iter().zip(new).take_while(same).count();
                tile.cut((alike, self.parts), new.iter().map(|&k| &cutters[k as usize]), || {
                    Tile::load(grid, self.unit, down, across, false)
                });
                if let Some(last) = tile.kept.last() {
                    store(&last.heights, heights, across, grid.columns);
                }
            }
        });
        let seen = self.tiles.iter().flat_map(|tile| &tile.seen);
        let traces = traces(&bins, cutters.len(), self.unit, seen);
        (self.bins, self.cutters) = (bins, cutters);
        ResidualField { heights, traces }
    }
}

/// A tile after the last program.
#[derive(Clone, Debug, Default)]
struct KeptTile {
    /// Effect of each of its cutters.
    seen: Vec<TraceSums>,
    /// Its heights on the way, in order, those at the end last.
    kept: Vec<KeptHeights>,
}

/// Heights of a tile after its first cutters.
#[derive(Clone, Debug)]
struct KeptHeights {
    /// Number of these cutters.
    made: usize,
    heights: [LaneRow<f32>; TILE],
}

impl KeptTile {
    /// Makes its cuts those of `cutters`, of which the first `alike` are made already, and keeps its heights
    /// after each of `parts`; `uncut` is the tile before the first one.
    fn cut<'a>(
        &mut self,
        (alike, parts): (usize, usize),
        cutters: impl ExactSizeIterator<Item = &'a FieldCutter>,
        uncut: impl FnOnce() -> Tile,
    ) {
        let count = cutters.len();
        self.kept.retain(|kept| kept.made <= alike);
        let start = self.kept.last();
        let made = start.map_or(0, |kept| kept.made);
        self.seen.truncate(made);
        if start.is_some() && made == count {
            return;
        }
        let mut tile = uncut();
        if let Some(start) = start {
            tile.height = start.heights;
            tile.stock = RowStock::new(&tile.height);
        }
        let interval = count.div_ceil(parts);
        let mut next = made + interval;
        for (k, cutter) in cutters.enumerate().skip(made) {
            self.seen.push(tile.cut(cutter));
            if k + 1 == next {
                self.kept.push(KeptHeights { made: next, heights: tile.height });
                next += interval;
            }
        }
        if self.kept.last().is_none_or(|last| last.made < count) {
            self.kept.push(KeptHeights { made: count, heights: tile.height });
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::residual_field;
    use super::super::tests::{any_cutter, saddle};
    use super::*;

    /// The field with no swept cells counted.
    fn without_swept(grid: &FloorGrid, cutters: &[FieldCutter]) -> ResidualField {
        let mut field = residual_field(grid, cutters);
        field.traces.iter_mut().for_each(|trace| trace.swept_cells = 0);
        field
    }

    proptest! {
        /// A cache that has seen other programs gives what each program has by itself.
        #[test]
        fn programs_after_others_are_as_by_themselves(
            grid in prop_oneof![Just(saddle(50, 37)), Just(saddle(3, 16))],
            first in prop::collection::vec(any_cutter(), 0..60),
            edits in prop::collection::vec(
                (0.0..1.0_f64, 0..4_usize, prop::collection::vec(any_cutter(), 0..3)),
                1..8,
            ),
        ) {
            let mut cache = FieldCache::new(grid.clone());
            let mut cutters = first;
            let once = FieldCache::for_one(grid.clone()).residual_field(cutters.clone());
            prop_assert_eq!(once, without_swept(&grid, &cutters));
            prop_assert_eq!(cache.residual_field(cutters.clone()), without_swept(&grid, &cutters));
            for (place, removed, added) in edits {
                let from = (place * cutters.len() as f64) as usize;
                let to = (from + removed).min(cutters.len());
                cutters.splice(from..to, added);
                prop_assert_eq!(cache.residual_field(cutters.clone()), without_swept(&grid, &cutters));
            }
        }
    }

    #[test]
    fn a_tile_goes_on_from_the_last_heights_before_a_change() {
        let grid = saddle(16, 16);
        let load = || Tile::load(&grid, VolumeUnit::from_grid(&grid), 0, 0, false);
        let cutter = |lift: f32| FieldCutter {
            tip: [180.0, 0.0, 45.0 - lift],
            radius: 5.0,
            axis: [0.0, 0.0, 1.0],
            ..FieldCutter::default()
        };
        let mut cutters: Vec<FieldCutter> = (0..64).map(|k| cutter(0.1 * k as f32)).collect();
        let mut tile = KeptTile::default();
        tile.cut((0, KEPT_PARTS), cutters.iter(), load);
        let made: Vec<usize> = tile.kept.iter().map(|kept| kept.made).collect();
        assert_eq!(made, (1..=16).map(|part| 4 * part).collect::<Vec<_>>());
        // Only what is cut from place 40 on counts: cutters before it that differ are not looked at.
        let whole = tile.kept[15].heights;
        cutters[..40].fill(cutter(-100.0));
        tile.cut((41, KEPT_PARTS), cutters.iter(), load);
        assert_eq!((tile.seen.len(), tile.kept[15].heights), (64, whole));
    }
}
