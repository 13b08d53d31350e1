//! A program from anywhere, checked against the part: its faults with their places.

use std::path::PathBuf;
use std::sync::Arc;

use super::preview::ShownCutters;
use crate::geometry::{Point, Vector};
use crate::gpu::mesh::Segment;
use crate::part::Impeller;
use crate::setup::Setup;
use crate::verify::Fault;

/// What is checked, and against what.
#[derive(Clone, Debug)]
pub struct CheckRequest {
    /// The program.
    pub path: PathBuf,
    /// Machine that NC code was posted for, by name.
    pub machine: String,
    /// The part.
    pub part: Arc<Impeller>,
    /// Allowances, tools and machine.
    pub setup: Setup,
}

impl CheckRequest {
    /// Whether another request gives the same findings for the same file.
    pub fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (&self.setup, &other.setup);
        self.path == other.path
            && self.machine == other.machine
            && Arc::ptr_eq(&self.part, &other.part)
            && (&a.allowances, &a.tools, &a.machine) == (&b.allowances, &b.tools, &b.machine)
    }
}

/// A tool of the program at a place, in the frame of the part.
#[derive(Clone, Debug)]
pub struct FaultPlace {
    /// Tip of the tool, mm.
    pub tip: Point,
    /// Unit axis, tip to holder.
    pub axis: Vector,
    /// Radius of the cutter, mm.
    pub radius: f64,
    /// The tool there.
    pub cutter: ShownCutters,
}

/// A fault with what the window shows of it.
#[derive(Clone, Debug)]
pub struct ProgramFinding {
    /// The fault.
    pub fault: Fault,
    /// Where the tool is at its line; `None` where that line is not a move.
    pub place: Option<FaultPlace>,
    /// Text of its line.
    pub text: String,
}

/// A figure of a checked program: name, value, meaning.
pub type ProgramFigure = (&'static str, String, &'static str);

/// A program with its findings.
#[derive(Clone, Debug)]
pub struct CheckedProgram {
    /// What was checked.
    pub request: CheckRequest,
    /// "Plunge program" or "Flank program".
    pub kind: &'static str,
    /// The faults, by line.
    pub findings: Vec<ProgramFinding>,
    /// The faults in words, by kind, the most serious first.
    pub summary: String,
    /// Figures.
    pub figures: Vec<ProgramFigure>,
    /// Remarks that are not faults, those of the reader with their line.
    pub notes: Vec<String>,
    /// Its moves as lines.
    pub lines: Vec<Segment>,
    /// Estimated time of the whole program, s.
    pub time: f64,
    /// Whether no accessible floor beyond the limit stays uncut.
    pub is_complete: bool,
}

impl CheckedProgram {
    /// Name of the file.
    pub fn name(&self) -> String {
        self.request.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}
