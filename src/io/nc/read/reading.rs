//! What reading a program needs, and what comes of it.

use crate::machine::{MachineTool, MoveAngles, PlacedPart};
use crate::setup::Tool;
use crate::toolpath::ClProgram;

/// A position of a program beyond the limits of the machine.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisOverrun {
    /// Line of the program.
    pub line: usize,
    /// Letter of the axis.
    pub letter: char,
    /// Its position, mm or degrees.
    pub value: f64,
    /// Its limits, mm or degrees.
    pub limits: (f64, f64),
}

/// A program read back.
#[derive(Clone, Debug, Default)]
pub struct NcReading {
    /// Its moves, in the part frame. Between two blocks that turn the tool far, positions are added, as the
    /// axes run linearly in joint space.
    pub program: ClProgram,
    /// Positions beyond limits.
    pub overruns: Vec<AxisOverrun>,
    /// Rotary positions at each move.
    pub angles: Vec<MoveAngles>,
}

/// What a program does not say itself.
#[derive(Clone, Copy, Debug)]
pub struct ReadContext<'a> {
    /// The machine.
    pub machine: &'a MachineTool,
    /// How the part lies on it.
    pub placed: PlacedPart,
    /// Tools by number; a comment `TOOL n D= R= W= L=` in the program comes first.
    pub tools: &'a [Tool],
}
