//! One block of a machine's motion.

use super::course::Pose;

/// How a step is moved to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StepMotion {
    /// From the machine's retract position, after a tool change or with a new plane.
    Approach,
    /// Cutting, with a feed rate in mm/min.
    Feed(f64),
    /// Not cutting, at the rate of links, along a straight course of the tip.
    Link,
}

/// Rotary positions (rad) at the end of a move of NC code.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveAngles {
    /// The program names them.
    Named([f64; 2]),
    /// The program gives a direction; the control chooses them.
    Chosen,
    /// Those of a move at the retract position, to it, or of where the way down from it begins. A tool change
    /// has the time of such moves.
    Retract([f64; 2]),
}

impl MoveAngles {
    /// The positions, where they are known.
    pub fn known(self) -> Option<[f64; 2]> {
        match self {
            Self::Named(angles) | Self::Retract(angles) => Some(angles),
            Self::Chosen => None,
        }
    }

    /// Whether the move is one of the retract position.
    pub fn is_retract(self) -> bool {
        matches!(self, Self::Retract(_))
    }
}

/// One block of the machine's motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineStep {
    /// How it is moved to.
    pub motion: StepMotion,
    /// Pose at its end, in program coordinates.
    pub pose: Pose,
    /// Index of the tool in the program.
    pub tool: usize,
    /// Index of the move that it belongs to.
    pub source: usize,
}
