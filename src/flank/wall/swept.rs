//! What a cutter leaves on a wall as it sweeps along it, its axis moved from station to station as a controller does.

use rayon::prelude::*;

use super::fit::{Face, Line};
use super::{CORRECTIONS, SETTLED};
use crate::geometry::{Point, Vector, search};

/// Swept deviation of a wall, mm.
#[derive(Clone, Debug, Default)]
pub struct DeviationMap {
    /// u of the columns, inlet to outlet, on the flank itself.
    pub u: Vec<f64>,
    /// v of the lines, from the lowest that the cylinder cuts (0 is the hub) to 1 at the tip.
    pub v: Vec<f64>,
    /// Stock left above the allowance at `u[i]`, `v[j]` under index `i · v.len() + j`; negative where the cutter cuts
    /// below the allowance, 0 where only its corner comes.
    pub deviation: Vec<f64>,
}

impl DeviationMap {
    /// Greatest cut below the allowance, mm; 0 where there is none.
    pub fn max_overcut(&self) -> f64 {
        self.deviation.iter().fold(0.0, |most, &d| f64::max(most, -d))
    }

    /// Greatest stock left above the allowance, mm.
    pub fn max_undercut(&self) -> f64 {
        self.deviation.iter().fold(0.0, |most, &d| f64::max(most, d))
    }
}

/// Where a segment between two axes is looked at, as its share.
const SHARE_TOLERANCE: f64 = 1e-3;

/// Moves positions off the wall until neither they nor those between them cut too deep; `spare` says how far one is
/// from that.
pub(super) fn settle(
    face: &Face,
    places: &[f64],
    lines: &mut [Line],
    spare: impl Fn(&Line, f64) -> f64 + Sync,
) {
    for _ in 0..CORRECTIONS {
        // At the stations and half way between them.
        let spares: Vec<f64> = (0..2 * lines.len() - 1)
            .into_par_iter()
            .map(|k| {
                let i = k / 2;
                if k % 2 == 0 {
                    spare(&lines[i], places[i])
                } else {
                    spare(&lines[i].towards(&lines[i + 1], 0.5), 0.5 * (places[i] + places[i + 1]))
                }
            })
            .collect();
        let segments: Vec<f64> = (0..lines.len() - 1)
            .map(|i| lowest_of_parabola(spares[2 * i], spares[2 * i + 1], spares[2 * i + 2]))
            .collect();
        if segments.iter().all(|&d| d > -SETTLED) {
            return;
        }
        push_off(face, places, lines, &segments);
    }
}

/// Moves both positions of every segment off the wall by what it lacks, where its spare is below zero.
pub(super) fn push_off(face: &Face, places: &[f64], lines: &mut [Line], spares: &[f64]) {
    for (i, line) in lines.iter_mut().enumerate() {
        let around = [i.checked_sub(1), Some(i)].into_iter().flatten().filter_map(|k| spares.get(k));
        let out = -around.fold(0.0, |a, &b| f64::min(a, b));
        if out > 0.0 {
            let (_, low, _) = face.frame(places[i], 0.0);
            let (_, high, _) = face.frame(places[i], 1.0);
            line.low += low * out;
            line.high += high * out;
        }
    }
}

/// Least value over [0, 1] of the parabola with these values at 0, ½ and 1.
fn lowest_of_parabola(start: f64, middle: f64, end: f64) -> f64 {
    let least = start.min(middle).min(end);
    let (slope, bend) = (4.0 * middle - 3.0 * start - end, 2.0 * (start - 2.0 * middle + end));
    let at = -0.5 * slope / bend;
    if bend > 0.0 && at > 0.0 && at < 1.0 { least.min(start + 0.5 * slope * at) } else { least }
}

/// Deviation over the places `u` × `v` of the wall, and for each the segment between two of the stations' `lines` that comes
/// nearest to it.
pub(super) fn deviation_map(face: &Face, lines: &[Line], u: &[f64], v: &[f64]) -> (DeviationMap, Vec<usize>) {
    let axes: Vec<Vector> = lines.iter().map(Line::axis).collect();
    let (deviation, segments) = u
        .par_iter()
        .flat_map_iter(|&u| {
            let axes = &axes;
            v.iter().map(move |&v| {
                let (distance, segment) = nearest(lines, axes, &face.side.point(u, v));
                (distance - face.reach, segment)
            })
        })
        .unzip();
    (DeviationMap { u: u.to_vec(), v: v.to_vec(), deviation }, segments)
}

/// Distance of `point` from the nearest axis, and the segment that this is in.
fn nearest(lines: &[Line], axes: &[Vector], point: &Point) -> (f64, usize) {
    let last = lines.len() - 1;
    let mut here = (0, f64::INFINITY);
    for (i, (line, axis)) in lines.iter().zip(axes).enumerate() {
        let distance = line.distance(point, axis);
        if distance < here.1 {
            here = (i, distance);
        }
    }
    let mut least = (here.1, here.0.min(last - 1));
    for i in [here.0.checked_sub(1), Some(here.0).filter(|&i| i < last)].into_iter().flatten() {
        let (a, b) = (&lines[i], &lines[i + 1]);
        let along = |share: f64| {
            let low = a.low + (b.low - a.low) * share;
            let axis = axes[i] + (axes[i + 1] - axes[i]) * share;
            let d = point - low;
            let height = d.dot(&axis);
            (d.norm_squared() - height * height / axis.norm_squared()).max(0.0)
        };
        let distance = search::minimum(along, 0.0, 1.0, SHARE_TOLERANCE).1.sqrt();
        if distance < least.0 {
            least = (distance, i);
        }
    }
    least
}
