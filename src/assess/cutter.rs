//! The largest cylinder between two walls: how thick a cutter may be, with the best axis it can have.
//!
//! The axis runs from a point on the hub at given s to a point on the shroud. Free are the angles of both
//! ends about Z and the s of the upper end, that is both leans and the tilt along the flow.

use nalgebra::{Matrix3, Vector3};

use crate::geometry::{CutterSolid, Point, Vector};
use crate::part::{BladeSide, Impeller, SideProbe};

/// The largest cylinder at one station.
#[derive(Clone, Copy, Debug)]
pub struct LargestCutter {
    /// s of the foot of its axis on the hub.
    pub s: f64,
    /// Diameter, mm.
    pub diameter: f64,
    /// Foot of the axis on the hub.
    pub foot: Point,
    /// Unit axis, hub → shroud.
    pub axis: Vector,
}

/// Two facing walls, ready for the search.
#[derive(Debug)]
pub struct WallPair<'a> {
    part: &'a Impeller,
    walls: [SideProbe; 2],
    /// +1 where ∂S/∂u × ∂S/∂v points into the passage.
    signs: [f64; 2],
}

/// An axis by what is free: angle of the foot, angle of the upper end, s of the upper end.
type Axis = Vector3<f64>;

/// Clearance of an axis from a third of a wall, mm, and how it answers to the three freedoms, each
/// measured in mm at the end it moves.
#[derive(Clone, Copy, Debug)]
struct Clearance {
    distance: f64,
    slope: Vector3<f64>,
}

/// The walls in thirds of their height: in each the nearest place moves steadily with the axis.
const THIRDS: [(f64, f64); 3] = [(0.0, 0.34), (0.34, 0.67), (0.67, 1.0)];
/// Where the upper end starts, as s ahead of the foot: between overhanging walls there is more than one best axis.
const STARTS: [f64; 3] = [0.0, 0.25, -0.25];
/// How far from that of the foot the s of the upper end may be.
const MOST_TILT: f64 = 0.4;

impl<'a> WallPair<'a> {
    /// The passage between `low` (a suction side) and `high` (a pressure side), both whole, noses included.
    pub fn new(part: &'a Impeller, low: &BladeSide, high: &BladeSide) -> Self {
        let middle = |side: &BladeSide| side.point(0.5, 0.5);
        let across = middle(high) - middle(low);
        let sign = |side: &BladeSide, into: Vector| {
            let (_, pu, pv) = side.derivatives(0.5, 0.5);
            if pu.cross(&pv).dot(&into) < 0.0 { -1.0 } else { 1.0 }
        };
        Self {
            part,
            walls: [low, high].map(|side| SideProbe::new(side, 0.0, 1.0)),
            signs: [sign(low, across), sign(high, -across)],
        }
    }

    /// The largest cylinder whose axis stands on the hub at `s`. `walls_at` gives the angles of the walls at (s, η),
    /// between which the searches begin: upright, and leaning over towards either end of the channel. `None` when not
    /// even a line fits.
    pub fn largest(&self, s: f64, walls_at: impl Fn(f64, f64) -> Option<[f64; 2]>) -> Option<LargestCutter> {
        let middle = |s: f64, eta: f64| walls_at(s, eta).map(|[low, high]| 0.5 * (low + high));
        let foot = middle(s, 0.0)?;
        let starts =
            STARTS.iter().filter_map(|ahead| Some(Axis::new(foot, middle(s + ahead, 1.0)?, s + ahead)));
        let (clearance, axis) =
            starts.map(|start| self.best_from(s, start)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        let (foot, _, direction) = self.line(s, &axis);
        (clearance > 0.0).then_some(LargestCutter { s, diameter: 2.0 * clearance, foot, axis: direction })
    }

    /// Climbs from an axis to one whose least clearance is largest; returns that clearance and the axis.
    ///
    /// The least of six clearances has kinks, so a smooth minimum takes its place that is sharpened step by step.
    /// The clearance returned is the true one.
    fn best_from(&self, s: f64, start: Axis) -> (f64, Axis) {
        let mut axis = start;
        let mut here = self.clearances(s, &axis);
        let mut best = (least(&here), axis);
        // Millimetres to the units of the freedoms.
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
                let mut next = axis + step;
                next.z = next.z.clamp(s - MOST_TILT, s + MOST_TILT);
                let there = self.clearances(s, &next);
                if smooth_least(&there, sharpness) > smooth_least(&here, sharpness) {
                    let moved = (next - axis).component_div(&unit).norm();
                    (axis, here) = (next, there);
                    damping *= 0.2;
                    if least(&here) > best.0 {
                        best = (least(&here), axis);
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
    fn line(&self, s: f64, axis: &Axis) -> (Point, Point, Vector) {
        let foot = self.part.hub.point(s).at_angle(axis.x);
        let top = self.part.shroud.point(axis.z).at_angle(axis.y);
        (foot, top, (top - foot).normalize())
    }

    fn clearances(&self, s: f64, axis: &Axis) -> [Clearance; 6] {
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
            let near = self.walls[wall].nearest(&line, from, to);
            let up = (near.point - foot).dot(&direction).max(0.0);
            let away = foot + direction * up - near.point;
            let (_, pu, pv) = self.walls[wall].side().derivatives(near.u, near.v);
            // Beyond the wall the clearance counts below zero.
            let inside = (pu.cross(&pv) * self.signs[wall]).dot(&away) >= 0.0;
            let sign = if inside { 1.0 } else { -1.0 };
            let unit = away.try_normalize(1e-12).unwrap_or_else(Vector::zeros) * sign;
            let share = up / height;
            Clearance {
                distance: sign * near.distance,
                slope: Vector3::new(
                    (1.0 - share) * unit.dot(&turn(&foot)),
                    share * unit.dot(&turn(&top)),
                    share * unit.dot(&along_shroud),
                ),
            }
        })
    }
}

fn least(clearances: &[Clearance; 6]) -> f64 {
    clearances.iter().map(|c| c.distance).fold(f64::INFINITY, f64::min)
}

/// −ln Σ exp(−k·c) / k: below the least clearance by at most ln 6 / k.
fn smooth_least(clearances: &[Clearance; 6], sharpness: f64) -> f64 {
    let least = least(clearances);
    let sum: f64 = clearances.iter().map(|c| (-sharpness * (c.distance - least)).exp()).sum();
    least - sum.ln() / sharpness
}

/// Damped Newton step of the smooth minimum, in mm, from the slopes of the clearances.
fn ascent(clearances: &[Clearance; 6], sharpness: f64, damping: f64) -> Option<Vector3<f64>> {
    let least = least(clearances);
    let weights = clearances.map(|c| (-sharpness * (c.distance - least)).exp());
    let total: f64 = weights.iter().sum();
    let mut slope = Vector3::zeros();
    let mut bend = Matrix3::zeros();
    for (c, weight) in clearances.iter().zip(weights) {
        slope += c.slope * (weight / total);
        bend += c.slope * c.slope.transpose() * (weight / total);
    }
    bend -= slope * slope.transpose();
    let step = (bend * sharpness + Matrix3::identity() * damping).try_inverse()? * slope;
    step.iter().all(|x| x.is_finite()).then_some(step)
}
