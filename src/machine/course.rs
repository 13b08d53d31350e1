//! A move in joint space: both rotary axes run linearly, while the program means the tool's axis to turn
//! evenly and the tip to stay on a line.

use super::model::MachineTool;
use crate::geometry::{Point, Vector};

/// A pose of the tool in program coordinates, with the rotary positions (rad) that bring it about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Tip, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Rotary positions, rad.
    pub angles: [f64; 2],
}

/// Places along a move at which it is sampled.
const SAMPLES: [f64; 3] = [0.25, 0.5, 0.75];

/// The unit vector a `share` of the way from `a` to `b` on the great circle through both.
pub fn even_turn(a: &Vector, b: &Vector, share: f64) -> Vector {
    let angle = a.angle(b);
    if angle < 1e-9 {
        return (a * (1.0 - share) + b * share).normalize();
    }
    // Half a turn has no great circle of its own: sin is kept from zero, and the result is a unit vector.
    let sin = angle.sin().max(1e-9);
    let mixed = a * (((1.0 - share) * angle).sin() / sin) + b * ((share * angle).sin() / sin);
    mixed.try_normalize(1e-9).unwrap_or(*a)
}

/// Rotary positions a `share` of the way from one pair to another.
pub fn mixed_angles(a: &[f64; 2], b: &[f64; 2], share: f64) -> [f64; 2] {
    [a[0] + (b[0] - a[0]) * share, a[1] + (b[1] - a[1]) * share]
}

impl MachineTool {
    /// Largest angle between the axis of the tool in joint space and one that turns evenly, rad, between two
    /// directions with their rotary positions.
    pub fn axis_stray(&self, from: (&Vector, [f64; 2]), to: (&Vector, [f64; 2])) -> f64 {
        if from.1 == to.1 {
            return 0.0;
        }
        let at = |share: f64| {
            let axis = self.tool_axis(&mixed_angles(&from.1, &to.1, share));
            axis.cross(&even_turn(from.0, to.0, share)).norm().min(1.0).asin()
        };
        // A stray of more than a right angle is no stray of a sine: look at the cosine too.
        let behind = SAMPLES.into_iter().any(|share| {
            let axis = self.tool_axis(&mixed_angles(&from.1, &to.1, share));
            axis.dot(&even_turn(from.0, to.0, share)) < 0.0
        });
        if behind { std::f64::consts::PI } else { SAMPLES.into_iter().map(at).fold(0.0, f64::max) }
    }

    /// Largest distance of the tip from the straight line between two poses when all five axes run linearly
    /// with a tool of `length` mm, mm.
    pub fn tip_stray(&self, from: &Pose, to: &Pose, length: f64) -> f64 {
        if from.angles == to.angles {
            return 0.0;
        }
        let a = Vector::from(self.joints(&from.tip, &from.angles, length));
        let b = Vector::from(self.joints(&to.tip, &to.angles, length));
        let line = to.tip - from.tip;
        let squared = line.norm_squared();
        let distance = |share: f64| {
            let joints = a + (b - a) * share;
            let tip = self.tip(&joints.into(), &mixed_angles(&from.angles, &to.angles, share), length);
            let along =
                if squared > 0.0 { ((tip - from.tip).dot(&line) / squared).clamp(0.0, 1.0) } else { 0.0 };
            (tip - (from.tip + line * along)).norm()
        };
        SAMPLES.into_iter().map(distance).fold(0.0, f64::max)
    }
}
