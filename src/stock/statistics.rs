//! Statistics of a heightfield: mean, 95th percentile, greatest height, uncut share.

use super::grid::FloorGrid;

/// Share of the blank's height at and above which a cell counts as uncut.
pub(crate) const UNCUT_SHARE_OF_BLANK: f32 = 0.999;
/// Low bits of a height that do not select its bin: a bin is about a hundredth of a height wide.
const BIN_SHIFT: u32 = 16;

/// Statistics of the residual stock, weighted by the area of the cells.
///
/// Heights are those of *cut* cells: stock that no plunge reaches is as high as the channel and would
/// dominate the rest; it is reported in `uncut_share`. Inaccessible floor says nothing about a plan and is
/// reported separately, in `unreachable_share`.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ResidualStatistics {
    /// Mean height, mm.
    pub mean: f32,
    /// Height below which 95 % of the cut area lies, mm.
    pub p95: f32,
    /// Greatest height, mm.
    pub max: f32,
    /// Uncut share of the reachable area, 0…1.
    pub uncut_share: f32,
    /// Inaccessible share of the floor, 0…1.
    pub unreachable_share: f32,
    /// Reachable area evaluated, mm².
    pub area: f32,
    /// Stock over it, cut or not, mm³.
    pub volume: f64,
}

/// Stock above the allowance of the hub.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExcessStock {
    /// On the reachable floor, cut or not, mm³.
    pub volume: f64,
    /// Height above the allowance that 95 % of the cut area stays below, mm.
    pub p95: f64,
}

impl ResidualStatistics {
    /// What is left above an `allowance` of the hub, mm, which every cutter leaves.
    pub fn excess_above(&self, allowance: f64) -> ExcessStock {
        let volume = self.volume - f64::from(self.area) * allowance;
        ExcessStock { volume: volume.max(0.0), p95: (f64::from(self.p95) - allowance).max(0.0) }
    }
}

/// Statistics of `heights`, one per cell of `grid`, over the floor in the rows that `in_question` selects.
/// All zero where there is none.
pub fn statistics(
    grid: &FloorGrid,
    heights: &[f32],
    in_question: impl Fn(usize) -> bool,
) -> ResidualStatistics {
    statistics_of_channels(grid, &[(heights, 1)], in_question)
}

/// As [`statistics`], over channels with the same floor: heights of its cells, and the number of channels
/// that have them. `area` is that of all channels.
pub fn statistics_of_channels(
    grid: &FloorGrid,
    channels: &[(&[f32], usize)],
    in_question: impl Fn(usize) -> bool,
) -> ResidualStatistics {
    let (mut cut_volume, mut cut_area, mut area, mut floor_area) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    let mut volume = 0.0;
    let mut max = 0.0_f32;
    let mut cut = Vec::with_capacity(channels.iter().map(|channel| channel.0.len()).sum());
    let cells = |row: usize| row * grid.columns..(row + 1) * grid.columns;
    let rows = || (0..grid.rows).filter(|&row| in_question(row)).flat_map(cells);
    for (heights, times, cell) in channels.iter().flat_map(|&(h, n)| rows().map(move |cell| (h, n, cell))) {
        if !grid.floor[cell] {
            continue;
        }
        let (height, blank, weight) =
            (heights[cell], grid.blank_heights[cell], grid.areas[cell] * times as f32);
        floor_area += f64::from(weight);
        if !grid.reachable[cell] {
            continue;
        }
        area += f64::from(weight);
        volume += f64::from(height) * f64::from(weight);
        if blank > 0.0 && height >= UNCUT_SHARE_OF_BLANK * blank {
            continue;
        }
        cut_area += f64::from(weight);
        cut_volume += f64::from(height) * f64::from(weight);
        max = max.max(height);
        cut.push((height, weight));
    }
    let share = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    ResidualStatistics {
        mean: share(cut_volume, cut_area) as f32,
        p95: percentile(&cut, 0.95 * cut_area),
        max,
        uncut_share: share(area - cut_area, area) as f32,
        unreachable_share: share(floor_area - area, floor_area) as f32,
        area: area as f32,
        volume,
    }
}

/// Weighted percentile: the least height at which the weights of all cells up to it sum to `target`. Heights
/// are 0 or more.
fn percentile(cells: &[(f32, f32)], target: f64) -> f32 {
    // Bucket selection: the bits of non-negative floating-point numbers are ordered like the numbers, so the
    // leading ones select one of a few thousand bins.
    let drawer = |height: f32| (height.max(0.0).to_bits() >> BIN_SHIFT) as usize;
    let mut weights = vec![0.0; drawer(f32::INFINITY) + 1];
    for &(height, weight) in cells {
        weights[drawer(height)] += f64::from(weight);
    }
    let mut below = 0.0;
    let reached = |weight: &f64| {
        below += weight;
        below >= target
    };
    let Some(found) = weights.iter().position(reached) else {
        return cells.iter().map(|cell| cell.0).fold(0.0, f32::max);
    };
    below -= weights[found];
    let mut inside: Vec<(f32, f32)> = cells.iter().copied().filter(|c| drawer(c.0) == found).collect();
    inside.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    for (height, weight) in &inside {
        below += f64::from(*weight);
        if below >= target {
            return *height;
        }
    }
    inside.last().map_or(0.0, |cell| cell.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(blank_heights: Vec<f32>, areas: Vec<f32>) -> FloorGrid {
        let cells = areas.len();
        FloorGrid {
            rows: 1,
            columns: cells,
            points: vec![[0.0; 3]; cells],
            normals: vec![[0.0, 0.0, 1.0]; cells],
            blank_heights,
            areas,
            floor: vec![true; cells],
            reachable: vec![true; cells],
        }
    }

    #[test]
    fn figures_of_a_ramp() {
        // 1, 2, … 100 in an order that is not sorted.
        let heights: Vec<f32> = (0..100).map(|i| (i * 37 % 100 + 1) as f32).collect();
        let grid = grid(vec![200.0; 100], vec![2.0; 100]);
        let figures = statistics(&grid, &heights, |_| true);
        assert_eq!((figures.mean, figures.p95, figures.max), (50.5, 95.0, 100.0));
        assert_eq!((figures.uncut_share, figures.area), (0.0, 200.0));
    }

    #[test]
    fn large_cells_weigh_more() {
        let grid = grid(vec![10.0; 3], vec![1.0, 1.0, 98.0]);
        let figures = statistics(&grid, &[3.0, 5.0, 1.0], |_| true);
        assert_eq!(figures.p95, 1.0, "98 % of the area is at 1 mm");
        assert!((figures.mean - 1.06).abs() < 1e-6, "{figures:?}");
    }

    #[test]
    fn uncut_cells_are_distinguished_and_what_is_no_floor_left_out() {
        let mut grid = grid(vec![10.0, 10.0, 10.0, 0.0], vec![1.0; 4]);
        grid.floor[2] = false;
        let figures = statistics(&grid, &[9.995, 1.0, 7.0, 0.0], |_| true);
        assert_eq!((figures.max, figures.area), (1.0, 3.0));
        assert!((figures.volume - (9.995 + 1.0)).abs() < 1e-6, "uncut cells hold stock, too: {figures:?}");
        assert!((figures.uncut_share - 1.0 / 3.0).abs() < 1e-6, "no blank, nothing uncut: {figures:?}");
    }

    #[test]
    fn inaccessible_cells_are_distinguished_whether_cut_or_not() {
        let mut grid = grid(vec![10.0, 10.0, 10.0, 3.0], vec![1.0, 1.0, 1.0, 2.0]);
        grid.reachable[3] = false;
        let figures = statistics(&grid, &[10.0, 1.0, 2.0, 3.0], |_| true);
        assert_eq!((figures.mean, figures.max, figures.area), (1.5, 2.0, 3.0));
        assert!((figures.uncut_share - 1.0 / 3.0).abs() < 1e-6, "of the reachable floor: {figures:?}");
        assert!((figures.unreachable_share - 0.4).abs() < 1e-6, "{figures:?}");
    }

    #[test]
    fn nothing_to_look_at_gives_zeros() {
        let mut grid = grid(vec![10.0], vec![1.0]);
        assert_eq!(statistics(&grid, &[10.0], |_| true).uncut_share, 1.0);
        assert_eq!(statistics(&grid, &[10.0], |_| false), ResidualStatistics::default());
        grid.reachable[0] = false;
        let figures = statistics(&grid, &[10.0], |_| true);
        assert_eq!((figures.uncut_share, figures.unreachable_share), (0.0, 1.0));
    }
}
