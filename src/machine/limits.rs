//! How far a position is beyond the limits of the axes, and how near to the pole.

use std::f64::consts::PI;
use std::fmt;

use super::kinematics::AngleSolution;
use super::model::{LINEAR_NAMES, MachineTool, RotaryAxis};
use crate::geometry::{Point, Vector, wrap_angle};

/// Angle from the pole below which a position counts as near it, rad. There the first rotary axis turns by
/// more than ten times the turn of the tool axis: the tool axis runs on a circle of this radius about it.
pub const NEAR_POLE_RAD: f64 = 5.7 * PI / 180.0;

/// What keeps a machine from a position.
#[derive(Clone, Debug, PartialEq)]
pub enum LimitFault {
    /// No rotary positions point the tool in this direction.
    Unreachable {
        /// Letters of the rotary axes.
        letters: [char; 2],
        /// The direction, tip → holder, in program coordinates.
        axis: Vector,
    },
    /// An axis would have to be beyond its limits.
    Beyond {
        /// Its letter.
        letter: char,
        /// Where it would have to be, mm or rad.
        position: f64,
        /// Its limits, mm or rad.
        limits: (f64, f64),
        /// Whether it is a rotary axis.
        is_rotary: bool,
    },
}

impl LimitFault {
    /// How far the axis would be beyond its limits, mm or rad; `None` where no positions exist.
    pub fn excess(&self) -> Option<f64> {
        match self {
            Self::Unreachable { .. } => None,
            Self::Beyond { position, limits, .. } => Some((limits.0 - position).max(position - limits.1)),
        }
    }
}

impl LimitFault {
    /// Where a linear axis would have to be, and how far that is beyond its limits.
    pub fn where_to(&self) -> String {
        match self {
            Self::Beyond { letter, position, is_rotary: false, .. } => {
                format!("{letter} {position:.1} mm, {:.1} mm beyond", self.excess().unwrap_or_default())
            }
            _ => self.to_string(),
        }
    }

    /// Whether it is of a linear axis, which another place of the part mends.
    pub fn is_of_linear_axis(&self) -> bool {
        matches!(self, Self::Beyond { is_rotary: false, .. })
    }

    /// Whether it is the smaller one: of a linear axis, or by less.
    fn is_less_than(&self, other: &Self) -> bool {
        let key = |fault: &Self| {
            let is_rotary = matches!(fault, Self::Beyond { is_rotary: true, .. });
            (is_rotary, fault.excess().unwrap_or(f64::INFINITY))
        };
        key(self) < key(other)
    }
}

impl fmt::Display for LimitFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreachable { letters: [a, b], axis } => {
                let [x, y, z] = [axis.x, axis.y, axis.z];
                let tilt = axis.angle(&Vector::z()).to_degrees();
                write!(f, "no position of {a} and {b} points the tool along ({x:.4}, {y:.4}, {z:.4}), ")?;
                write!(f, "{tilt:.1}° from the table's normal")
            }
            Self::Beyond { letter, position, limits, is_rotary: true } => {
                let [at, low, high] = [*position, limits.0, limits.1].map(f64::to_degrees);
                let excess = (low - at).max(at - high);
                write!(f, "{letter} would have to be {at:.2}°, {excess:.2}° beyond its limits ")?;
                write!(f, "{low:.0}° … {high:.0}°")
            }
            Self::Beyond { letter, position, limits: (low, high), is_rotary: false } => {
                let excess = (low - position).max(position - high);
                write!(f, "{letter} {position:.1} mm is {excess:.1} mm beyond its limits {low} … {high}")
            }
        }
    }
}

impl RotaryAxis {
    /// Of `angle` (rad) and its whole turns, the one that is the least beyond the limits.
    fn nearest_turn(&self, angle: f64) -> f64 {
        let Some((low, high)) = self.limits else { return angle };
        let middle = 0.5 * (low + high);
        middle + wrap_angle(angle - middle)
    }
}

impl MachineTool {
    /// Angle of the unit vector `axis`, in program coordinates, from the pole, rad: from the line of the
    /// first rotary axis, the one nearest to the workpiece.
    pub fn pole_angle(&self, axis: &Vector) -> f64 {
        let angle = self.rotary[0].direction.angle(axis);
        angle.min(PI - angle)
    }

    /// What keeps the machine from holding a tool of `length` mm along the unit vector `axis` with its tip on
    /// each of `tips`, in program coordinates; `None` where it can. Of its two solutions, that counts which
    /// is the least beyond the limits. At the pole, where the first axis is free, linear axes are not
    /// considered.
    pub fn limit_fault(&self, axis: &Vector, tips: &[Point], length: f64) -> Option<LimitFault> {
        let (solutions, count) = self.solve(axis);
        let mut least: Option<LimitFault> = None;
        for solution in solutions.iter().take(count) {
            let fault = self.solution_fault(solution, tips, length)?;
            if least.as_ref().is_none_or(|known| fault.is_less_than(known)) {
                least = Some(fault);
            }
        }
        let letters = [0, 1].map(|i| self.rotary[i].letter);
        least.or(Some(LimitFault::Unreachable { letters, axis: *axis }))
    }

    fn solution_fault(&self, solution: &AngleSolution, tips: &[Point], length: f64) -> Option<LimitFault> {
        for (axis, wanted) in self.rotary.iter().zip([solution.first, Some(solution.second)]) {
            let Some((wanted, limits)) = wanted.zip(axis.limits) else { continue };
            if axis.turns_within_limits(wanted).next().is_none() {
                let position = axis.nearest_turn(wanted);
                return Some(LimitFault::Beyond { letter: axis.letter, position, limits, is_rotary: true });
            }
        }
        let angles = [solution.first?, solution.second];
        let beyond = |tip: &Point| {
            let joints = self.joints(tip, &angles, length);
            let axis = self.linear_axis_beyond(&joints)?;
            let (letter, position, limits) = (LINEAR_NAMES[axis], joints[axis], self.linear[axis].limits);
            Some(LimitFault::Beyond { letter, position, limits, is_rotary: false })
        };
        let excess = |fault: &LimitFault| fault.excess().unwrap_or_default();
        tips.iter().filter_map(beyond).max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }
}
