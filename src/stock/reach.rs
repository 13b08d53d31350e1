//! Inaccessible floor: the corner under a wall that leans over the channel.
//!
//! Beside such a wall the flank of a cutter follows the wall, its bottom rests on the far end of its rim, and
//! the near end is 2R·sin β above the hub; the floor within about 2R·sin β·tan β of the wall's foot
//! stays under stock in every plan. Here the border of this strip is found for the actual wall, row by row:
//! by search over the poses of the cutter (`corner.rs`).
//!
//! Axes are within the largest angle that plans may incline them by from the isoparametric one. Holder, steps
//! between positions, contact of the core and the corner radius are ignored: floor reported as inaccessible
//! is so for every plan, and floor that a plan leaves without being reported counts as uncut. Only rays that
//! end under a blade can be inaccessible.

use rayon::prelude::*;

use super::corner::{CornerLimit, InaccessibleStrip, ReachCutter, WallCorner};
use super::floor_source::{CutterStretch, FloorSource};
use super::overhang::{BladesOverFloor, ROWS, WallTables, rows_beside, s_of_row};

/// Inaccessible floor at one row of the tables, per wall.
type InaccessibleStrips = Vec<InaccessibleStrip>;

/// Inaccessible floor along s.
#[derive(Debug)]
pub(super) struct InaccessibleTables {
    stretches: Vec<(CutterStretch, Vec<InaccessibleStrips>)>,
}

impl InaccessibleTables {
    pub(super) fn new(source: &FloorSource, walls: &WallTables) -> Self {
        let stretch = |&stretch: &CutterStretch| {
            let cutter = ReachCutter {
                radius: stretch.radius,
                hub_allowance: source.stock.hub_allowance,
                blade_allowance: source.stock.blade_allowance,
                max_tilt_rad: source.max_tilt_rad,
            };
            let rows = (0..ROWS).into_par_iter().map(|row| {
                // Rows are interpolated in pairs. Further from the range of the cutter they are not used.
                if stretch.distance_to(s_of_row(row)) > 1.0 / ROWS as f64 {
                    return vec![InaccessibleStrip::NONE; walls.faces.len()];
                }
                let over = walls.blades_over(s_of_row(row));
                let strip = |face| {
                    WallCorner::new(source.workpiece, walls, (face, row), &over, &cutter)
                        .map_or(InaccessibleStrip::NONE, |corner| corner.inaccessible_strip())
                };
                (0..walls.faces.len()).map(strip).collect()
            });
            (stretch, rows.collect())
        };
        Self { stretches: source.cutters.iter().map(stretch).collect() }
    }

    /// The cutter that reaches furthest at `s`: the smallest of those nearest to it.
    pub(super) fn cutter_at(&self, s: f64) -> Option<&CutterStretch> {
        self.stretch_at(s).map(|(stretch, _)| stretch)
    }

    fn stretch_at(&self, s: f64) -> Option<&(CutterStretch, Vec<InaccessibleStrips>)> {
        let order = |a: &CutterStretch, b: &CutterStretch| {
            a.distance_to(s).total_cmp(&b.distance_to(s)).then(a.radius.total_cmp(&b.radius))
        };
        self.stretches.iter().min_by(|a, b| order(&a.0, &b.0))
    }

    /// What keeps the cutter at `s` from getting nearer to wall `face`.
    pub(super) fn limit_at(&self, s: f64, face: usize) -> CornerLimit {
        let (first, second, share) = rows_beside(s);
        // The row whose strip is interpolated here with the larger weight, if it has one.
        let strip = |(_, rows): &(_, Vec<InaccessibleStrips>)| {
            let weight = |row: usize, share: f64| (rows[row][face].angle * share, rows[row][face].limit);
            let (a, b) = (weight(first, 1.0 - share), weight(second, share));
            if a.0 >= b.0 { a.1 } else { b.1 }
        };
        self.stretch_at(s).map_or(CornerLimit::Cutter, strip)
    }

    /// Inaccessible ranges of the floor at `s`; they apply only to floor under a blade.
    pub(super) fn inaccessible_ranges(&self, s: f64, over: &BladesOverFloor) -> InaccessibleRanges {
        let Some((_, rows)) = self.stretch_at(s) else { return InaccessibleRanges::default() };
        let (first, second, share) = rows_beside(s);
        let range = |(face, &foot): (usize, &f64)| {
            let [from, to] = [first, second].map(|row| rows[row][face].angle);
            let reach = from + (to - from) * share;
            // The first wall and the far sides of splitters open towards the second wall.
            if face == 0 || face > 1 && face % 2 == 1 { (foot, foot + reach) } else { (foot - reach, foot) }
        };
        InaccessibleRanges { ranges: over.feet.iter().enumerate().map(range).collect() }
    }
}

/// Ranges of angles at one s, counted as in [`BladesOverFloor`].
#[derive(Clone, Debug, Default)]
pub(super) struct InaccessibleRanges {
    ranges: Vec<(f64, f64)>,
}

impl InaccessibleRanges {
    pub(super) fn contains(&self, angle: f64) -> bool {
        self.face_over(angle).is_some()
    }

    /// Number of the wall in whose corner the angle is.
    pub(super) fn face_over(&self, angle: f64) -> Option<usize> {
        self.ranges.iter().position(|range| angle > range.0 && angle < range.1)
    }
}
