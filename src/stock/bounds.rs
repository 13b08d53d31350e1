//! Bounds of a whole row of cells, by which most cutters are decided without evaluating its cells.
//!
//! Most plunges that reach a tile pass over floor that earlier ones cut deeper: they sweep it, remove nothing
//! and have no contact. Where the bounds prove this for a whole row, its cells are skipped. The margins are
//! far above the rounding of single precision, so cell by cell the result would be the same.

use super::field_cutter::FieldCutter;
use super::meeting::{LaneRow, Meeting, dot, greatest, larger, mask, smaller};
use super::tiles::{REACH_MARGIN, TILE};

/// The last lane of a row.
const LAST: usize = TILE - 1;

/// One value per row and lane of a tile.
type TileCells = [LaneRow<f32>; TILE];

/// For each row of a tile its middle ray and bounds on the deviation of the others. Lengths in mm.
#[derive(Clone, Debug)]
pub(super) struct RowBounds {
    /// Foot of the middle ray.
    foot: [LaneRow<f32>; 3],
    /// Direction of the middle ray; not quite a unit vector.
    normal: [LaneRow<f32>; 3],
    /// From the middle foot to that of the last cell.
    span: [LaneRow<f32>; 3],
    /// Greatest distance of a foot from the middle one.
    radius: LaneRow<f32>,
    /// Greatest distance of a foot from the line along `span`.
    bend: LaneRow<f32>,
    /// Greatest difference of a normal from the middle one; no unit.
    spread: LaneRow<f32>,
    min_blank: LaneRow<f32>,
    max_blank: LaneRow<f32>,
}

/// Effect of a cutter on each row of a tile.
pub(super) struct RowVerdicts {
    /// All bits set if the cutter may enter a ray of the row below the blank's surface.
    pub(super) reached: LaneRow<u32>,
    /// All bits set if it certainly enters every ray there.
    pub(super) swept: LaneRow<u32>,
    /// All bits set if it certainly enters no stock: none is removed, and none meets the core.
    pub(super) untouched: LaneRow<u32>,
}

impl RowBounds {
    /// Bounds of the cells with these feet and normals, by component, and heights of the blank.
    pub(super) fn new(points: &[TileCells; 3], normals: &[TileCells; 3], blank: &TileCells) -> Self {
        let middle = |cells: &TileCells| cells.map(|row| 0.5 * (row[0] + row[LAST]));
        let mut bounds = Self {
            foot: points.each_ref().map(middle),
            normal: normals.each_ref().map(middle),
            span: points.each_ref().map(|cells| cells.map(|row| 0.5 * (row[LAST] - row[0]))),
            radius: [0.0; TILE],
            bend: [0.0; TILE],
            spread: [0.0; TILE],
            min_blank: blank.map(|row| row.into_iter().fold(f32::INFINITY, smaller)),
            max_blank: blank.map(|row| row.into_iter().fold(0.0, larger)),
        };
        for row in 0..TILE {
            let (mut from_foot, mut from_line, mut from_normal) = ([0.0; TILE], [0.0; TILE], [0.0; TILE]);
            for axis in 0..3 {
                let (foot, span) = (bounds.foot[axis][row], bounds.span[axis][row]);
                let normal = bounds.normal[axis][row];
                for lane in 0..TILE {
                    let off_foot = points[axis][row][lane] - foot;
                    let off_line = off_foot - lane_parameter(lane) * span;
                    let off_normal = normals[axis][row][lane] - normal;
                    from_foot[lane] += off_foot * off_foot;
                    from_line[lane] += off_line * off_line;
                    from_normal[lane] += off_normal * off_normal;
                }
            }
            bounds.radius[row] = greatest(from_foot).sqrt();
            bounds.bend[row] = greatest(from_line).sqrt();
            bounds.spread[row] = greatest(from_normal).sqrt();
        }
        bounds
    }

    /// Effect of `cutter` on rows with this stock.
    ///
    /// At equal heights the rays of a row are within `reach` of the middle one. So where one of them enters
    /// the cutter, the middle one enters a cutter grown by `reach`; and where the middle one enters a cutter
    /// shrunk by it, all of them are inside.
    pub(super) fn verdicts(&self, cutter: &FieldCutter, stock: &RowStock) -> RowVerdicts {
        let mut verdicts = RowVerdicts { reached: [0; TILE], swept: [0; TILE], untouched: [0; TILE] };
        for row in 0..TILE {
            // No closures over arrays in this innermost loop: not every build inlines them.
            let (foot, normal) = (in_row(&self.foot, row), in_row(&self.normal, row));
            let span = in_row(&self.span, row);
            let ray = Meeting::new(foot, normal, cutter);
            let reach = self.radius[row] + self.max_blank[row] * self.spread[row] + REACH_MARGIN;
            let grown = ray.raised(reach).entry(square(cutter.radius + reach));
            let shrunk = ray.raised(-reach - cutter.corner_radius).entry(square(cutter.radius - reach));
            // A shrunk cutter much thinner than the cutter itself would be lost in rounding.
            let has_core = 2.0 * reach < cutter.radius;
            // Height of the stock above the bottom. Over floor cut before, the feet may rise along the row
            // while the heights fall: only their sum is a useful bound.
            let slope = larger(ray.slope, 0.0);
            let tilt = dot(span, cutter.axis) + slope * stock.tilt[row];
            let top = ray.z + slope * (stock.middle[row] + stock.bulge[row]) + tilt.abs();
            let stray = self.bend[row] + 2.0 * self.spread[row] * stock.highest[row];
            verdicts.reached[row] = mask(grown < self.max_blank[row]);
            verdicts.swept[row] = mask(has_core & (shrunk < self.min_blank[row]));
            let is_below = top + stray < -REACH_MARGIN;
            verdicts.untouched[row] = mask(is_below | (grown > stock.highest[row]));
        }
        verdicts
    }
}

/// For each row of a tile a line above its stock: height `middle` + t·`tilt` + `bulge` at the parameter t
/// from −1, the first cell, to 1, the last one. All in mm.
#[derive(Clone, Debug)]
pub(super) struct RowStock {
    middle: LaneRow<f32>,
    tilt: LaneRow<f32>,
    bulge: LaneRow<f32>,
    /// Greatest height, at least 0.
    highest: LaneRow<f32>,
}

impl RowStock {
    pub(super) fn new(heights: &TileCells) -> Self {
        let zero = [0.0; TILE];
        let mut stock = Self { middle: zero, tilt: zero, bulge: zero, highest: zero };
        for row in 0..TILE {
            stock.set(row, &heights[row]);
        }
        stock
    }

    /// Updates the line above one row from its heights.
    #[inline(always)]
    pub(super) fn set(&mut self, row: usize, heights: &LaneRow<f32>) {
        let (first, last) = (heights[0], heights[LAST]);
        let (middle, tilt) = (0.5 * (first + last), 0.5 * (last - first));
        self.middle[row] = middle;
        self.tilt[row] = tilt;
        self.bulge[row] =
            greatest(std::array::from_fn(|lane| heights[lane] - (middle + lane_parameter(lane) * tilt)));
        self.highest[row] = greatest(*heights);
    }
}

/// The vector of one row.
#[inline(always)]
fn in_row(vectors: &[LaneRow<f32>; 3], row: usize) -> [f32; 3] {
    [vectors[0][row], vectors[1][row], vectors[2][row]]
}

/// Parameter of a lane along its row, −1…1.
#[inline(always)]
fn lane_parameter(lane: usize) -> f32 {
    (2 * lane) as f32 / LAST as f32 - 1.0
}

#[inline(always)]
fn square(x: f32) -> f32 {
    x * x
}
