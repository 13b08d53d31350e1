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
