//! Cutter-location programs in APT (ISO 4343): the data, a writer and a tolerant reader.
//!
//! Frame of the part, rotation axis Z; mm, mm/min, rev/min; the axis is a unit vector from tip to
//! holder.

mod program;
mod read;
mod transform;
mod words;
mod write;

pub use read::{read_apt, read_apt_bytes};
pub use write::write_apt;

use crate::geometry::{Point, Vector};
use crate::part::Feed;

/// A cutter as a CL program describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClTool {
    /// Number in the machine's magazine; 0 when the program names none.
    pub number: u32,
    /// Diameter, mm; 0 when the program gives none.
    pub diameter: f64,
    /// Corner radius, mm.
    pub corner_radius: f64,
    /// Radial width of the bottom edges, mm (`PPRINT/INSERT WIDTH n w`).
    pub insert_width: Option<f64>,
    /// Free length from the tip to the holder, mm.
    pub overhang: Option<f64>,
    /// First feed used with the tool, mm/min. The writer takes feeds from the moves.
    pub feed: Option<f64>,
    /// Spindle speed, rev/min.
    pub spindle: Option<f64>,
}

/// How a move is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// At rapid speed.
    Rapid,
    /// At a feed in mm/min; `None` when the program gives none.
    Feed(Option<f64>),
}

/// A straight move to a position.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Rapid or feed.
    pub motion: Motion,
    /// Tip of the cutter (centre of its bottom) at the end of the move, mm.
    pub tip: Point,
    /// Unit axis, tip → holder.
    pub axis: Vector,
    /// Index into [`ClProgram::tools`]; `None` before any tool is loaded.
    pub tool: Option<usize>,
    /// Line of the file, 0 when the program comes from no file.
    pub line: usize,
}

/// Something in a program that is worth knowing but does not stop its reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClWarning {
    /// Line of the file.
    pub line: usize,
    /// What was found and how it was taken.
    pub what: String,
}

/// A section of the plan that a program was written from: `PPRINT/SECTION n FROM s TO s D d INWARD [REST]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ClSection {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// Diameter of its cutter, mm.
    pub diameter: f64,
    /// Direction of its rows.
    pub feed: Feed,
    /// Whether it cuts only what the sections before it left thick.
    pub rest: bool,
}

/// Where a row of plunges begins: `PPRINT/ROW n m`, both counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClRow {
    /// Index of its first move.
    pub first_move: usize,
    /// Index into [`ClProgram::sections`].
    pub section: usize,
    /// Number within the section, from 0.
    pub row: usize,
}

/// A cutter-location program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClProgram {
    /// Name of the part (`PARTNO`).
    pub part: String,
    /// Tools in the order of their first use.
    pub tools: Vec<ClTool>,
    /// Moves in cutting order.
    pub moves: Vec<Move>,
    /// Sections of the plan it was written from; none of other programs.
    pub sections: Vec<ClSection>,
    /// Rows of that plan, in cutting order.
    pub rows: Vec<ClRow>,
    /// What the reader noticed, by line; at most [`MAX_WARNINGS`].
    pub warnings: Vec<ClWarning>,
}

/// Most warnings that a reader collects.
pub const MAX_WARNINGS: usize = 100;

#[cfg(test)]
mod tests;
