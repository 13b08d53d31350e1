//! Deviation of the surface that a cutter sweeps along a wall, with the axis interpolated from station to
//! station as a controller does.

use rayon::prelude::*;

use super::bounds::{bend_of_distance, lower_bound_between};
use super::fit::{AxisLine, OffsetSide};
use crate::geometry::{Point, Vector, search};

/// Maximum number of iterations that move positions off the wall where the swept cutter cuts too deep.
pub(super) const CORRECTIONS: usize = 8;
/// Tolerance of distances, mm.
pub(super) const DISTANCE_TOLERANCE: f64 = 1e-5;
/// Distance kept from the limit, mm.
pub(super) const MARGIN: f64 = 3.0 * DISTANCE_TOLERANCE;
/// Tolerance of the search along a segment between two axes, as a share of it.
const SHARE_TOLERANCE: f64 = 1e-3;
/// On a bowed wall every n-th axis is a seed of the search for the nearest.
const SEED_STEP: usize = 8;

/// Swept deviation of a wall, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviationMap {
    /// u of the columns, inlet to outlet, on the flank itself.
    pub u: Vec<f64>,
    /// v of the rows, from the lowest that the cylinder cuts (0 is the hub) to 1 at the tip.
    pub v: Vec<f64>,
    /// Stock left above the allowance at `u[i]`, `v[j]` at index `i · v.len() + j`, mm; negative for overcut,
    /// 0 where only the corner cuts. Of a program NaN where it does not mill the wall.
    pub deviation: Vec<f64>,
}

impl DeviationMap {
    /// Maximum overcut: depth cut below the allowance, mm; 0 where there is none.
    pub fn max_overcut(&self) -> f64 {
        self.deviation.iter().fold(0.0, |most, &d| f64::max(most, -d))
    }

    /// Maximum undercut: stock left above the allowance, mm.
    pub fn max_undercut(&self) -> f64 {
        self.deviation.iter().fold(0.0, |most, &d| f64::max(most, d))
    }
}

/// Moves positions off the wall until neither they nor those between them cut too deep. `spare` is the margin
/// of an axis before it does, mm.
pub(super) fn correct_overcuts(
    face: &OffsetSide,
    places: &[f64],
    lines: &mut [AxisLine],
    spare: impl Fn(&AxisLine, &MapColumn) -> f64 + Sync,
) {
    for _ in 0..CORRECTIONS {
        // At the stations and half way between them.
        let spares: Vec<f64> = (0..2 * lines.len() - 1)
            .into_par_iter()
            .map(|k| {
                let column = MapColumn::half(places, k);
                let i = column.station;
                if k % 2 == 0 {
                    spare(&lines[i], &column)
                } else {
                    spare(&lines[i].towards(&lines[i + 1], 0.5), &column)
                }
            })
            .collect();
        let segments: Vec<f64> = (0..lines.len() - 1)
            .map(|i| lowest_of_parabola(spares[2 * i], spares[2 * i + 1], spares[2 * i + 2]))
            .collect();
        if segments.iter().all(|&d| d > -DISTANCE_TOLERANCE) {
            return;
        }
        push_off(face, places, lines, &segments);
    }
}

/// Moves both positions of every segment with a negative spare off the wall by what it lacks.
pub(super) fn push_off(face: &OffsetSide, places: &[f64], lines: &mut [AxisLine], spares: &[f64]) {
    for (i, line) in lines.iter_mut().enumerate() {
        let around = [i.checked_sub(1), Some(i)].into_iter().flatten().filter_map(|k| spares.get(k));
        let out = -around.fold(0.0, |a, &b| f64::min(a, b));
        if out > 0.0 {
            line.shift(face, places[i], out);
        }
    }
}

/// Minimum over [0, 1] of the parabola with these values at 0, ½ and 1.
fn lowest_of_parabola(start: f64, middle: f64, end: f64) -> f64 {
    let least = start.min(middle).min(end);
    let (slope, bend) = (4.0 * middle - 3.0 * start - end, 2.0 * (start - 2.0 * middle + end));
    let at = -0.5 * slope / bend;
    if bend > 0.0 && at > 0.0 && at < 1.0 { least.min(start + 0.5 * slope * at) } else { least }
}

/// A column of a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct MapColumn {
    pub(super) u: f64,
    /// The station before it or at it.
    pub(super) station: usize,
    /// Share of the distance to the next station.
    pub(super) share: f64,
}

impl MapColumn {
    /// The `k`-th of the columns at the stations and half way between them.
    pub(super) fn half(places: &[f64], k: usize) -> Self {
        let (station, share) = (k / 2, 0.5 * (k % 2) as f64);
        let next = places.get(station + 1).copied().unwrap_or(places[station]);
        Self { u: places[station] + (next - places[station]) * share, station, share }
    }

    /// Linear interpolation of values given at the stations.
    pub(super) fn interpolate(&self, at_stations: &[f64]) -> f64 {
        let here = at_stations[self.station];
        let next = at_stations.get(self.station + 1).copied().unwrap_or(here);
        // A weighted mean, not a difference: infinite values at both stations must not give NaN.
        if self.share == 0.0 { here } else { here * (1.0 - self.share) + next * self.share }
    }
}

/// Deviation at `rows` (v) of every column where `counts` holds, mm, and the segment between two of the
/// stations' `lines` that is nearest.
pub(super) fn deviations(
    face: &OffsetSide,
    lines: &[AxisLine],
    columns: &[MapColumn],
    rows: &[f64],
    counts: impl Fn(&MapColumn, usize) -> bool + Sync,
) -> Vec<Option<(f64, usize)>> {
    let axes: Vec<Vector> = lines.iter().map(AxisLine::axis).collect();
    let (axes, counts) = (&axes, &counts);
    let is_bowed = !face.side.is_ruled();
    columns
        .par_iter()
        .flat_map_iter(|column| {
            rows.iter().enumerate().map(move |(row, &v)| {
                counts(column, row).then(|| {
                    let (distance, segment) =
                        nearest(lines, axes, column.station, &face.side.point(column.u, v), is_bowed);
                    (distance - face.reach, segment)
                })
            })
        })
        .collect()
}

/// Distance of `point` from the nearest axis, mm, and the segment that holds it. Descends from the station
/// `from`, on a bowed wall from a nearer seed, then minimises over the two adjacent segments. On a bowed wall
/// those at `from` are searched as well: where axes turn much from one station to the next, one between them
/// may be nearer than those of all stations.
fn nearest(lines: &[AxisLine], axes: &[Vector], from: usize, point: &Point, is_bowed: bool) -> (f64, usize) {
    let last = lines.len() - 1;
    let at = |i: usize| lines[i].distance(point, &axes[i]);
    let mut here = (from, at(from));
    if is_bowed {
        for i in (0..=last).step_by(SEED_STEP) {
            let distance = at(i);
            if distance < here.1 {
                here = (i, distance);
            }
        }
    }
    for step in [-1isize, 1] {
        while let Some(i) = here.0.checked_add_signed(step).filter(|&i| i <= last) {
            let distance = at(i);
            if distance >= here.1 {
                break;
            }
            here = (i, distance);
        }
    }
    let within = |i: usize| {
        let (a, b) = (&lines[i], &lines[i + 1]);
        let along = |share: f64| {
            let low = a.low + (b.low - a.low) * share;
            let axis = axes[i] + (axes[i + 1] - axes[i]) * share;
            let d = point - low;
            let height = d.dot(&axis);
            (d.norm_squared() - height * height / axis.norm_squared()).max(0.0)
        };
        search::minimum(along, 0.0, 1.0, SHARE_TOLERANCE).1.sqrt()
    };
    // No less than the distance in a segment, without a search.
    let bound = |i: usize| {
        let (low, turn) = (lines[i + 1].low - lines[i].low, axes[i + 1] - axes[i]);
        let end = |k: usize| {
            let (axis, d) = (&axes[k], point - lines[k].low);
            let height = d.dot(axis);
            let away = d - axis * height;
            let distance = away.norm();
            (distance, -away.dot(&(low + turn * height)) / distance.max(1e-12))
        };
        let travel = low.norm();
        let far = (point - lines[i].low).norm() + travel;
        lower_bound_between([end(i), end(i + 1)], bend_of_distance(travel, turn.norm(), far))
    };
    let around = |i: usize| [i.checked_sub(1), Some(i).filter(|&i| i < last)].into_iter().flatten();
    let own = (is_bowed && from != here.0).then(|| around(from)).into_iter().flatten();
    let mut least = (here.1, here.0.min(last - 1));
    for i in around(here.0).chain(own) {
        if bound(i) >= least.0 {
            continue;
        }
        let distance = within(i);
        if distance < least.0 {
            least = (distance, i);
        }
    }
    least
}
