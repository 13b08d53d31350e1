//! The largest cylinder between two walls: the maximum tool diameter with the best axis.
//!
//! The axis runs from a point on the hub at given s to a point on the shroud. Free are the angles of both
//! ends about Z and the s of the upper end. Both ends stay between the walls: in a wrapped passage the ascent
//! could otherwise move the axis past the ends of the walls, into open space. Beyond the trailing edge the
//! walls are extended straight, so that the result at the rim is that of the passage as well.
//!
//! Each start is improved by damped Newton ascent of a smooth minimum (log-sum-exp) of the clearances.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{CutterSolid, Point, Vector, search, wrap_angle};
use crate::part::{BladeSide, Impeller, NearestOnSide, Passage, SideProbe};

/// The walls in thirds of their height: within a third the nearest point moves smoothly with the axis.
const THIRDS: [(f64, f64); 3] = [(0.0, 0.34), (0.34, 0.67), (0.67, 1.0)];
/// Starts of the s of the upper end, relative to the foot: between overhanging walls there are several local
/// optima.
const STARTS: [f64; 3] = [0.0, 0.25, -0.25];
/// Starts of the upper end between the walls.
const STARTS_ACROSS: [f64; 3] = [0.5, 0.2, 0.8];
/// Maximum difference of s between upper end and foot.
const MAX_S_OFFSET: f64 = 0.4;
/// Length of the extension of the walls beyond the trailing edge, in u.
const RUN_ON: f64 = 0.4;

/// The largest cylinder at one station.
#[derive(Clone, Copy, Debug)]
pub struct LargestCutter {
    /// s of the foot of its axis on the hub.
    pub s: f64,
    /// Diameter, mm.
    pub diameter: f64,
    /// Width of the passage on the hub at s, mm: the diameter of the largest ball between the walls with its
    /// centre there, an upper bound on the diameter.
    pub section_width: f64,
    /// Foot of the axis on the hub, in the frame of the part.
    pub foot: Point,
    /// Unit axis, hub → shroud, in the frame of the part.
    pub axis: Vector,
}

/// Two facing walls, prepared for the search.
#[derive(Debug)]
pub struct WallPair<'a> {
    part: &'a Impeller,
    passage: &'a Passage,
    walls: [FacingWall; 2],
}

/// A wall with its nose, extended beyond its trailing edge.
#[derive(Debug)]
struct FacingWall {
    /// The blade side; without a round tail extended itself.
    whole: SideProbe,
    /// The second half of the flank of a side with a round tail, extended.
    flank: Option<SideProbe>,
    /// +1 where ∂S/∂u × ∂S/∂v points into the passage.
    sign: f64,
}

impl FacingWall {
    /// `ahead` is the sign of the angle about Z from the wall into the passage.
    fn new(side: &BladeSide, flank: &BladeSide, ahead: f64) -> Self {
        // A blade is never so steep to the circumference that this sign is ambiguous.
        let (p, pu, pv) = side.derivatives(0.5, 0.5);
        let around = Vector::new(-p.y, p.x, 0.0) * ahead;
        let sign = if pu.cross(&pv).dot(&around) < 0.0 { -1.0 } else { 1.0 };
        let end = flank.u_range().1;
        if side.has_round_tail() {
            let flank = SideProbe::new(flank, 0.5, end + RUN_ON);
            Self { whole: SideProbe::new(side, 0.0, 1.0), flank: Some(flank), sign }
        } else {
            Self { whole: SideProbe::new(side, 0.0, 1.0 + RUN_ON), flank: None, sign }
        }
    }

    /// The nearer of side and flank, by `distance`.
    fn nearest(&self, distance: impl Fn(&SideProbe) -> NearestOnSide) -> (&BladeSide, NearestOnSide) {
        let whole = (self.whole.side(), distance(&self.whole));
        let flank = self.flank.as_ref().map(|probe| (probe.side(), distance(probe)));
        match flank {
            Some(flank) if flank.1.distance < whole.1.distance => flank,
            _ => whole,
        }
    }
}

/// The free parameters of an axis: angle of the foot, angle of the upper end, s of the upper end.
type AxisParameters = Vector3<f64>;

/// Signed clearance of an axis from a third of a wall, mm, and its gradient in the three parameters, each
/// measured in mm at the end it moves.
#[derive(Clone, Copy, Debug)]
struct WallClearance {
    distance: f64,
    gradient: Vector3<f64>,
}

impl<'a> WallPair<'a> {
    /// The walls of `passage`. `low` (a suction side) and `high` (a pressure side) are their blade sides
    /// including noses.
    pub fn new(part: &'a Impeller, passage: &'a Passage, low: &BladeSide, high: &BladeSide) -> Self {
        let ahead = part.pitch().signum();
        let [low_flank, high_flank] = [0, 1].map(|k| passage.walls[k].side());
        let walls = [FacingWall::new(low, low_flank, ahead), FacingWall::new(high, high_flank, -ahead)];
        Self { part, passage, walls }
    }

    /// The largest cylinder with the foot of its axis on the hub at `s`, the best of several starts. `None`
    /// where a wall does not extend to `s`, or when not even a line fits.
    pub fn largest(&self, s: f64) -> Option<LargestCutter> {
        let walls = self.passage.wall_angles(self.part, s, 0.0)?;
        let foot = 0.5 * (walls[0] + walls[1]);
        let starts = STARTS.iter().flat_map(|ahead| {
            let top = self.passage.wall_angles(self.part, s + ahead, 1.0);
            let across = STARTS_ACROSS.iter();
            across.filter_map(move |share| {
                top.map(|[low, high]| AxisParameters::new(foot, low + share * (high - low), s + ahead))
            })
        });
        let (clearance, axis) =
            starts.map(|start| self.best_from(s, walls, start)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (foot, _, direction) = self.line(s, &axis);
        // Past the end of a wall an axis could be clear of it only because nothing is near: bound the
        // clearance by that of the foot.
        let clearance = clearance.min(self.wall_distance(&foot));
        let section_width = self.section_width(s, walls).max(2.0 * clearance);
        let diameter = 2.0 * clearance;
        (clearance > 0.0).then_some(LargestCutter { s, diameter, section_width, foot, axis: direction })
    }

    /// Distance from `point` to the nearer wall, mm.
    fn wall_distance(&self, point: &Point) -> f64 {
        let distance = |wall: &FacingWall| wall.nearest(|probe| probe.nearest_to_point(point)).1.distance;
        distance(&self.walls[0]).min(distance(&self.walls[1]))
    }

    /// Diameter of the largest ball between the walls with its centre on the hub at `s`, mm. Golden section
    /// search: the distance to the nearer wall decreases towards either of them.
    fn section_width(&self, s: f64, [low, high]: [f64; 2]) -> f64 {
        let hub = self.part.hub.point(s);
        let clearance = |share: f64| -self.wall_distance(&hub.at_angle(low + share * (high - low)));
        -2.0 * search::minimum(clearance, 0.0, 1.0, 1e-6).1
    }

    /// `axis` with its ends clamped between the walls, given the angles of the walls at the foot.
    fn clamp_between_walls(&self, s: f64, foot: [f64; 2], axis: AxisParameters) -> AxisParameters {
        let between = |angle: f64, [a, b]: [f64; 2]| angle.clamp(a.min(b), a.max(b));
        let upper = axis.z.clamp(s - MAX_S_OFFSET, s + MAX_S_OFFSET);
        let top = self.passage.wall_angles(self.part, upper, 1.0);
        // Angles of the walls may differ from those of the axis by whole turns.
        let top = top.map(|[low, high]| {
            let near = axis.y + wrap_angle(0.5 * (low + high) - axis.y) - 0.5 * (low + high);
            [low + near, high + near]
        });
        AxisParameters::new(between(axis.x, foot), top.map_or(axis.y, |walls| between(axis.y, walls)), upper)
    }

    /// Local maximum of the minimum clearance from a start axis; returns that clearance and the axis.
    ///
    /// The minimum of six clearances has kinks, so a smooth minimum is maximised instead, sharpened in
    /// stages. The returned clearance is the exact one.
    fn best_from(&self, s: f64, walls: [f64; 2], start: AxisParameters) -> (f64, AxisParameters) {
        let mut axis = self.clamp_between_walls(s, walls, start);
        let mut here = self.clearances(s, &axis);
        let mut best = (min_clearance(&here), axis);
        // Units of the parameters per millimetre.
        let unit = Vector3::new(
            1.0 / self.part.hub.point(s).r.max(1e-6),
            1.0 / self.part.shroud.point(s).r.max(1e-6),
            1.0 / self.part.shroud.length(),
        );
        let size = best.0.abs().max(1e-3 * self.part.rim_radius());
        for sharpness in [1.0, 8.0, 64.0, 512.0].map(|x| x / size) {
            let mut damping = 0.1 * sharpness;
            for _ in 0..10 {
                let Some(step) = ascent(&here, sharpness, damping) else { break };
                let step = step.map(|x| x.clamp(-0.5 * size, 0.5 * size)).component_mul(&unit);
                let next = self.clamp_between_walls(s, walls, axis + step);
                let there = self.clearances(s, &next);
                if smooth_min_clearance(&there, sharpness) > smooth_min_clearance(&here, sharpness) {
                    let moved = (next - axis).component_div(&unit).norm();
                    (axis, here) = (next, there);
                    damping *= 0.2;
                    if min_clearance(&here) > best.0 {
                        best = (min_clearance(&here), axis);
                    }
                    if moved < 1e-4 * size {
                        break;
                    }
                } else {
                    damping *= 6.0;
                    if damping > 1e4 * sharpness {
                        break;
                    }
                }
            }
        }
        best
    }

    /// Foot, upper end and unit direction of an axis.
    fn line(&self, s: f64, axis: &AxisParameters) -> (Point, Point, Vector) {
        let foot = self.part.hub.point(s).at_angle(axis.x);
        let top = self.part.shroud.point(axis.z).at_angle(axis.y);
        (foot, top, (top - foot).normalize())
    }

    fn clearances(&self, s: f64, axis: &AxisParameters) -> [WallClearance; 6] {
        let (foot, top, direction) = self.line(s, axis);
        let height = (top - foot).norm();
        let turn = |p: &Point| {
            let r = p.x.hypot(p.y).max(1e-6);
            Vector::new(-p.y / r, p.x / r, 0.0)
        };
        let along_shroud = self.part.shroud.at(axis.z).tangent.direction_at_angle(axis.y);
        let line = CutterSolid { tip: foot, axis: direction, radius: 0.0, corner_radius: 0.0 };
        std::array::from_fn(|k| {
            let (wall, (from, to)) = (k / 3, THIRDS[k % 3]);
            let (side, near) = self.walls[wall].nearest(|probe| probe.nearest(&line, from, to));
            let up = (near.point - foot).dot(&direction).max(0.0);
            let away = foot + direction * up - near.point;
            let (_, pu, pv) = side.derivatives(near.u, near.v);
            // Beyond the wall the clearance is negative.
            let inside = (pu.cross(&pv) * self.walls[wall].sign).dot(&away) >= 0.0;
            let sign = if inside { 1.0 } else { -1.0 };
            let unit = away.try_normalize(1e-12).unwrap_or_else(Vector::zeros) * sign;
            let share = up / height;
            WallClearance {
                distance: sign * near.distance,
                gradient: Vector3::new(
                    (1.0 - share) * unit.dot(&turn(&foot)),
                    share * unit.dot(&turn(&top)),
                    share * unit.dot(&along_shroud),
                ),
            }
        })
    }
}

fn min_clearance(clearances: &[WallClearance; 6]) -> f64 {
    clearances.iter().map(|c| c.distance).fold(f64::INFINITY, f64::min)
}

/// −ln Σ exp(−k·c) / k: below the minimum clearance by at most ln 6 / k.
fn smooth_min_clearance(clearances: &[WallClearance; 6], sharpness: f64) -> f64 {
    let least = min_clearance(clearances);
    let sum: f64 = clearances.iter().map(|c| (-sharpness * (c.distance - least)).exp()).sum();
    least - sum.ln() / sharpness
}

/// Damped Newton step of the smooth minimum, in mm, from the gradients of the clearances.
fn ascent(clearances: &[WallClearance; 6], sharpness: f64, damping: f64) -> Option<Vector3<f64>> {
    let least = min_clearance(clearances);
    let weights = clearances.map(|c| (-sharpness * (c.distance - least)).exp());
    let total: f64 = weights.iter().sum();
    let mut slope = Vector3::zeros();
    let mut bend = Matrix3::zeros();
    for (c, weight) in clearances.iter().zip(weights) {
        slope += c.gradient * (weight / total);
        bend += c.gradient * c.gradient.transpose() * (weight / total);
    }
    bend -= slope * slope.transpose();
    let step = (bend * sharpness + Matrix3::identity() * damping).try_inverse()? * slope;
    step.iter().all(|x| x.is_finite()).then_some(step)
}
