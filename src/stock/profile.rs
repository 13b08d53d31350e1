//! Profile of a tabulated wall in the plane of a cutter's axis, and how near the flank of the cutter can come
//! to it there.

use super::overhang::{LEVELS, ROWS, WallTable};
use crate::geometry::{Point, Vector};

/// The flank of a cutter.
pub(super) struct CutterFlank {
    /// Unit axis (f, d, z).
    pub(super) axis: [f64; 3],
    /// tan φ.
    pub(super) tan_phi: f64,
    /// R plus the blade allowance, mm.
    pub(super) reach: f64,
    /// Height of the near end of the rim above the centre of the bottom, mm. Every contact of the flank with
    /// a wall is higher by as much than the point of the axis opposite to it.
    pub(super) rise: f64,
}

/// How a wall's level lies to the plane of an axis and e.
#[derive(Clone, Copy, Debug)]
enum LevelMeeting {
    /// It crosses the plane.
    Crossing(LevelCrossing),
    /// It ends at an edge of the blade beside the plane: the point of the edge (f, d, z), and v.
    Edge([f64; 3], f64),
}

/// Where a wall's level crosses the plane of an axis and e, and the wall's slope there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LevelCrossing {
    /// Coordinate across the wall, mm.
    pub(super) d: f64,
    /// Height, mm.
    z: f64,
    /// Hub 0 … tip 1.
    v: f64,
    /// Differences along the level, for the slope along the wall.
    step: [f64; 3],
}

/// Frame of a wall's foot: T along the wall, e across it into the channel, n along the hub normal.
pub(super) struct WallFootFrame {
    /// Origin, mm.
    pub(super) foot: Point,
    /// T.
    pub(super) along: Vector,
    /// e.
    pub(super) across: Vector,
    /// n.
    pub(super) normal: Vector,
}

impl WallFootFrame {
    /// Coordinates (f, d, z) of a point, mm.
    fn local(&self, point: &Point) -> [f64; 3] {
        let p = point - self.foot;
        [p.dot(&self.along), p.dot(&self.across), p.dot(&self.normal)]
    }

    /// Crossing of level `level` of `face` with the plane f = `slope`·z + `at`. Searches from table row
    /// `row`, and sets it to the row found as a warm start. `None` where the blade does not reach the plane.
    pub(super) fn cross_level(
        &self,
        face: &WallTable,
        level: usize,
        plane: [f64; 2],
        row: &mut usize,
    ) -> Option<LevelCrossing> {
        match self.meet_level(face, level, plane, row)? {
            LevelMeeting::Crossing(crossing) => Some(crossing),
            LevelMeeting::Edge(..) => None,
        }
    }

    /// As [`Self::cross_level`]; where the blade ends before the plane, the point of its edge that is nearest
    /// to it on the level, and `row` stays.
    fn meet_level(
        &self,
        face: &WallTable,
        level: usize,
        [slope, at]: [f64; 2],
        row: &mut usize,
    ) -> Option<LevelMeeting> {
        let side = |row: usize| {
            let node = &face.row(row)[level];
            let p = self.local(&node.point);
            (p[0] - slope * p[2] - at, p, node)
        };
        let mut here_row = *row;
        let mut here = side(here_row);
        // The last place on the blade, towards the plane.
        let mut edge = None;
        loop {
            if here.2.is_on_blade() {
                edge = Some(LevelMeeting::Edge(here.1, here.2.v));
            }
            let next = if here.0 > 0.0 { here_row.checked_sub(1) } else { Some(here_row + 1) };
            let Some(next) = next.filter(|&next| next < ROWS) else { return edge };
            let there = side(next);
            if !here.0.is_finite() || !there.0.is_finite() {
                return edge;
            }
            let step: [f64; 3] = std::array::from_fn(|k| there.1[k] - here.1[k]);
            let between = |share: f64| {
                let place = std::array::from_fn(|k| here.1[k] + step[k] * share);
                (place, here.2.v + (there.2.v - here.2.v) * share)
            };
            if here.2.is_on_blade() && !there.2.is_on_blade() {
                let (place, v) = between(here.2.share_to_edge(there.2));
                edge = Some(LevelMeeting::Edge(place, v));
            }
            if (here.0 > 0.0) != (there.0 > 0.0) {
                if !(here.2.is_on_blade() && there.2.is_on_blade()) {
                    return edge;
                }
                let ([_, d, z], v) = between(here.0 / (here.0 - there.0));
                *row = here_row;
                return Some(LevelMeeting::Crossing(LevelCrossing { d, z, v, step }));
            }
            (here_row, here) = (next, there);
        }
    }
}

/// A point of an edge of the blade beside the plane of an axis and e.
#[derive(Clone, Copy, Debug, Default)]
struct EdgePoint {
    /// Distance from the plane, mm.
    aside: f64,
    /// Coordinates of its projection onto the plane, mm.
    d: f64,
    z: f64,
}

/// Profile of a wall in the plane of an axis and e, between hub and tip, from below upwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct WallProfile {
    /// Number of points.
    pub(super) count: usize,
    /// Coordinates of the points, mm.
    z: [f64; LEVELS],
    d: [f64; LEVELS],
    /// ∂w/∂f and ∂w/∂z.
    slopes: [[f64; 2]; LEVELS],
    /// Points of an edge of the blade at levels that end beside the plane, and their number. The flank has to
    /// clear them as well: beside an outlet under a wall that leans over it there is nothing else above.
    edges: [EdgePoint; LEVELS],
    edge_count: usize,
}

impl WallProfile {
    /// Profile of `face` in the plane f = `slope`·z of `frame`, whose foot is in table row `row`, with edges
    /// up to `reach` mm beside the plane.
    pub(super) fn of(
        frame: &WallFootFrame,
        face: &WallTable,
        (slope, reach): (f64, f64),
        mut row: usize,
    ) -> Self {
        let mut crossings = [LevelCrossing::default(); LEVELS];
        let mut count = 0;
        let (mut edges, mut edge_count) = ([EdgePoint::default(); LEVELS], 0);
        for level in 0..LEVELS {
            let mut here = match frame.meet_level(face, level, [slope, 0.0], &mut row) {
                Some(LevelMeeting::Crossing(crossing)) => crossing,
                Some(LevelMeeting::Edge([f, d, z], v)) => {
                    let length = 1.0 + slope * slope;
                    let aside = (f - slope * z) / length.sqrt();
                    if v <= 1.0 && aside.abs() < reach {
                        edges[edge_count] = EdgePoint { aside, d, z: (slope * f + z) / length };
                        edge_count += 1;
                    }
                    continue;
                }
                None => continue,
            };
            if count > 0 && here.v > 1.0 {
                // Clip the profile at the tip.
                let below = crossings[count - 1];
                let share = ((1.0 - below.v) / (here.v - below.v)).clamp(0.0, 1.0);
                here.d = below.d + (here.d - below.d) * share;
                here.z = below.z + (here.z - below.z) * share;
                here.v = 1.0;
            }
            if here.v > 1.0 || (count > 0 && here.z <= crossings[count - 1].z) {
                break;
            }
            crossings[count] = here;
            count += 1;
            if here.v >= 1.0 {
                break;
            }
        }
        let zeros = [0.0; LEVELS];
        let mut profile = Self { count, z: zeros, d: zeros, slopes: [[0.0; 2]; LEVELS], edges, edge_count };
        for k in 0..count {
            let (below, above) = (&crossings[k.saturating_sub(1)], &crossings[(k + 1).min(count - 1)]);
            let rise = above.z - below.z;
            let in_plane = if rise > 0.0 { (above.d - below.d) / rise } else { 0.0 };
            // The level leaves the plane: its change of d beyond the slope in the plane gives the slope along
            // f.
            let [f, d, z] = crossings[k].step;
            let out = f - slope * z;
            let by_f = if out.abs() > 1e-9 { (d - in_plane * z) / out } else { 0.0 };
            (profile.z[k], profile.d[k]) = (crossings[k].z, crossings[k].d);
            profile.slopes[k] = [by_f, in_plane - slope * by_f];
        }
        profile
    }

    /// Whether it has too few points for a slope.
    pub(super) fn is_empty(&self) -> bool {
        self.count + self.edge_count < 2
    }

    /// Greatest dw/dz in the plane, from the lowest point and locally.
    pub(super) fn steepest(&self) -> f64 {
        let slope = |a: usize, b: usize| (self.d[b] - self.d[a]) / (self.z[b] - self.z[a]);
        let locally = (1..self.count).map(|k| slope(k - 1, k).max(slope(0, k)));
        let [d, z] = if self.count > 0 { [self.d[0], self.z[0]] } else { [0.0; 2] };
        let edges = self.edges().filter(|edge| edge.z > z).map(|edge| (edge.d - d) / (edge.z - z));
        locally.chain(edges).fold(0.0, f64::max)
    }

    fn edges(&self) -> impl Iterator<Item = &EdgePoint> {
        self.edges[..self.edge_count].iter()
    }

    /// Distance in d that the flank needs between the wall's point `k` and the axis at equal height, mm.
    fn flank_distance(&self, k: usize, flank: &CutterFlank) -> f64 {
        let ([f, z], axis) = (self.slopes[k], &flank.axis);
        let through = axis[1] - f * axis[0] - z * axis[2];
        flank.reach * (1.0 + f * f + z * z - through * through).max(0.0).sqrt()
    }

    /// Change of d of the axis relative to the wall between the height of the wall's point `k` and that of
    /// the point of the axis opposite to it, mm.
    fn axis_gain(&self, k: usize, flank: &CutterFlank) -> f64 {
        let [f, z] = self.slopes[k];
        (flank.tan_phi - z - f * flank.axis[0] / flank.axis[2]) * flank.rise
    }

    /// Least d of the axis at z = 0 that keeps the flank clear of the wall at and above z = `from`, mm.
    pub(super) fn nearest_axis(&self, flank: &CutterFlank, from: f64) -> f64 {
        let at = |k: usize| {
            self.d[k] + self.flank_distance(k, flank) + self.axis_gain(k, flank) - flank.tan_phi * self.z[k]
        };
        let mut most = f64::NEG_INFINITY;
        for k in 0..self.count {
            if self.z[k] >= from {
                if k > 0 && self.z[k - 1] < from {
                    let share = (from - self.z[k - 1]) / (self.z[k] - self.z[k - 1]);
                    most = most.max(at(k - 1) + (at(k) - at(k - 1)) * share);
                }
                most = most.max(at(k));
            }
        }
        let edges = self.edges().filter(|edge| edge.z >= from);
        edges.map(|edge| edge.place(flank, 1.0)).fold(most, f64::max)
    }

    /// Greatest d of the axis at z = 0 that keeps the flank clear of this opposite wall at and above z =
    /// `from`, mm.
    pub(super) fn furthest_axis(&self, flank: &CutterFlank, from: f64) -> f64 {
        let edges = self.edges().filter(|edge| edge.z >= from).map(|edge| edge.place(flank, -1.0));
        (0..self.count)
            .filter(|&k| self.z[k] >= from)
            .map(|k| {
                self.d[k]
                    - self.flank_distance(k, flank)
                    - self.axis_gain(k, flank)
                    - flank.tan_phi * self.z[k]
            })
            .chain(edges)
            .fold(f64::INFINITY, f64::min)
    }
}

impl EdgePoint {
    /// d of the axis at z = 0 with which the flank touches the point, on the side `side` (±1) of it, mm.
    fn place(&self, flank: &CutterFlank, side: f64) -> f64 {
        let slope = flank.axis[0] / flank.axis[2];
        // The cylinder is cut at `aside` from its axis; in the plane that strip is inclined by φ.
        let half = (flank.reach * flank.reach - self.aside * self.aside).max(0.0).sqrt();
        let across = half * (1.0 + flank.tan_phi * flank.tan_phi / (1.0 + slope * slope)).sqrt();
        self.d + side * across - flank.tan_phi * self.z
    }
}
