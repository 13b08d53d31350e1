//! Where the tool stands, and what coordinates mean.

use crate::geometry::Vector;
use crate::machine::Pose;

/// What the coordinates of a block mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CoordinateMode {
    /// Positions of the axes, counted from the program's zero.
    Joints,
    /// The tip in program coordinates.
    Tip,
    /// The tip in a tilted plane, by the directions of its X, Y, Z.
    Plane([Vector; 3]),
}

/// A position with what is needed to go on from it.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub pose: Pose,
    /// Whether the program names `pose.angles`; else the control chooses them.
    pub by_angles: bool,
    /// Machine coordinates X Y Z; `None` where no rotary positions lead there.
    pub joints: Option<[f64; 3]>,
    /// Whether all axes run linearly to it.
    pub is_joint_move: bool,
}

/// The axes at the retract position, in machine coordinates; what the program did not say yet is not known.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RetractedTool {
    /// X and Y, mm.
    pub xy: [Option<f64>; 2],
    /// Z, mm.
    pub z: f64,
    /// Rotary positions, rad.
    pub angles: [Option<f64>; 2],
}

impl RetractedTool {
    /// All axes, if they are known.
    pub fn axes(&self) -> Option<([f64; 3], [f64; 2])> {
        let ([Some(x), Some(y)], [Some(first), Some(second)]) = (self.xy, self.angles) else { return None };
        Some(([x, y, self.z], [first, second]))
    }
}
