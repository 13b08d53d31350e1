//! The stock on the floor as plunges are left out of a plan.

use crate::stock::cover::CellCover;
use crate::stock::statistics::UNCUT_SHARE_OF_BLANK;
use crate::stock::{FieldCutter, FloorGrid};

/// Bands of the floor along s whose stock is kept within its limit on its own: small sections are not to pay
/// for large ones.
const BANDS: usize = 8;

/// Cost of stock of `height` mm over one mm² beyond `allowance`: its square, so that few thick places weigh
/// more than many thin ones, as the 95th percentile has it.
fn cost_per_area(height: f32, allowance: f32) -> f64 {
    let excess = f64::from((height - allowance).max(0.0));
    excess * excess
}

/// The floor of a channel with the plunges that are still in the plan.
pub(super) struct ThinnedFloor<'a> {
    grid: &'a FloorGrid,
    cover: CellCover,
    allowance: f32,
    /// Cells over which each plunge sweeps.
    cells_of: Vec<Vec<u32>>,
    /// Whether each plunge is in the plan.
    kept: Vec<bool>,
    reachable_area: f64,
    uncut_area: f64,
    /// Stock above the allowance on the floor that is cut, by band, mm³, and before any plunge was left out.
    volumes: [f64; BANDS],
    first_volumes: [f64; BANDS],
}

/// The band of `cell` along s.
fn band(grid: &FloorGrid, cell: usize) -> usize {
    cell / grid.columns * BANDS / grid.rows
}

/// What leaving a plunge out does to the floor.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FloorChange {
    /// Rise of the cost of the stock, mm⁴.
    pub cost: f64,
    /// Area that is cut no more, mm².
    pub uncut_area: f64,
    /// Volume of the stock that stays more, by band of the floor, mm³.
    pub volumes: [f64; BANDS],
}

impl<'a> ThinnedFloor<'a> {
    /// The floor `grid` after all of `cutters`; `allowance` is the stock that must stay, mm.
    pub fn new(grid: &'a FloorGrid, cutters: &[FieldCutter], allowance: f64) -> Self {
        let cover = CellCover::new(grid, cutters);
        let mut cells_of = vec![Vec::new(); cutters.len()];
        let (mut reachable_area, mut uncut_area, mut volumes) = (0.0, 0.0, [0.0; BANDS]);
        for cell in 0..cover.len() {
            if !(grid.floor[cell] && grid.reachable[cell]) {
                continue;
            }
            let entries = cover.of_cell(cell);
            for entry in entries {
                cells_of[entry.cutter as usize].push(cell as u32);
            }
            let area = f64::from(grid.areas[cell]);
            reachable_area += area;
            let height = entries.first().map_or(f32::INFINITY, |entry| entry.height);
            if height >= UNCUT_SHARE_OF_BLANK * grid.blank_heights[cell] {
                uncut_area += area;
            } else {
                volumes[band(grid, cell)] += area * (f64::from(height) - allowance);
            }
        }
        let kept = vec![true; cutters.len()];
        let (first_volumes, allowance) = (volumes, allowance as f32);
        Self { grid, cover, allowance, cells_of, kept, reachable_area, uncut_area, volumes, first_volumes }
    }

    /// What changes when `plunge` is left out.
    pub fn change_without(&self, plunge: usize) -> FloorChange {
        let mut change = FloorChange::default();
        for &cell in &self.cells_of[plunge] {
            let cell = cell as usize;
            let mut left = self.cover.of_cell(cell).iter().filter(|entry| self.kept[entry.cutter as usize]);
            let Some(lowest) = left.next().filter(|lowest| lowest.cutter as usize == plunge) else {
                continue;
            };
            let blank = self.grid.blank_heights[cell];
            let next = left.next().map_or(blank, |entry| entry.height);
            let area = f64::from(self.grid.areas[cell]);
            let rise = cost_per_area(next, self.allowance) - cost_per_area(lowest.height, self.allowance);
            change.cost += area * rise;
            change.volumes[self.band_of(cell)] += area * f64::from(next - lowest.height);
            if next >= UNCUT_SHARE_OF_BLANK * blank && lowest.height < UNCUT_SHARE_OF_BLANK * blank {
                change.uncut_area += area;
            }
        }
        change
    }

    /// Leaves `plunge` out, which makes `change`.
    pub fn leave_out(&mut self, plunge: usize, change: &FloorChange) {
        self.uncut_area += change.uncut_area;
        for (volume, more) in self.volumes.iter_mut().zip(change.volumes) {
            *volume += more;
        }
        self.kept[plunge] = false;
    }

    /// Share of the reachable floor that would be uncut with `more` mm² beside what is uncut already.
    pub fn uncut_share_with(&self, more: f64) -> f64 {
        if self.reachable_area > 0.0 { (self.uncut_area + more) / self.reachable_area } else { 0.0 }
    }

    /// Largest share by which the stock above the allowance on a band of the floor rises with `change`,
    /// compared to the whole plan.
    pub fn rise_with(&self, change: &FloorChange) -> f64 {
        let rise = |band: usize| match self.first_volumes[band] {
            first if first > 0.0 => (self.volumes[band] + change.volumes[band]) / first - 1.0,
            _ => 0.0,
        };
        (0..BANDS).map(rise).fold(0.0, f64::max)
    }

    fn band_of(&self, cell: usize) -> usize {
        band(self.grid, cell)
    }

    /// Height of the stock over every cell after the plunges that `is_kept`, mm.
    pub fn heights(&self, is_kept: impl Fn(usize) -> bool) -> Vec<f32> {
        (0..self.cover.len())
            .map(|cell| {
                let mut entries = self.cover.of_cell(cell).iter();
                let lowest = entries.find(|entry| is_kept(entry.cutter as usize));
                lowest.map_or(self.grid.blank_heights[cell], |entry| entry.height)
            })
            .collect()
    }
}
