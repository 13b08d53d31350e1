//! A program from anywhere, checked against the part: its faults with their places.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::SystemTime;

use super::boundary::Boundary;
use super::listing::ProgramListing;
use super::preview::ShownCutters;
use super::units::DisplayUnits;
use crate::geometry::{Point, Vector};
use crate::gpu::mesh::Segment;
use crate::io::program_file::NcMachine;
use crate::part::{Impeller, Workpiece};
use crate::setup::{Setup, Tool};
use crate::toolpath::ClProgram;
use crate::verify::Fault;

/// What is checked, and against what.
#[derive(Clone, Debug)]
pub struct CheckRequest {
    /// The program.
    pub path: PathBuf,
    /// Machine that NC code was posted for, by name.
    pub machine: String,
    /// Its control, or the file of its post; `None`: that of the machine.
    pub control: Option<String>,
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
            && (&self.machine, &self.control) == (&other.machine, &other.control)
            && Arc::ptr_eq(&self.part, &other.part)
            && (&a.allowances, &a.clearances) == (&b.allowances, &b.clearances)
            && Tool::cut_alike(&a.tools, &b.tools)
            && a.machine == b.machine
    }
}

/// What changes with a file that is written again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileStamp {
    /// When it was written last.
    pub written: SystemTime,
    /// Its size, bytes.
    pub size: u64,
}

/// What became of the file of a program since it was checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileChange {
    /// Nothing, as far as is known.
    #[default]
    None,
    /// It was written again.
    Written,
    /// It was moved, renamed or deleted.
    Gone,
}

impl FileChange {
    /// The change in words; `None` without one.
    pub fn words(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Written => Some("The file was written again after this check: check it again"),
            Self::Gone => Some("The file is no longer there; it has been moved or deleted since this check"),
        }
    }
}

/// Why a check may not hold any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StaleCheck {
    /// The program could not be checked again.
    NotChecked,
    /// This became of its file.
    File(FileChange),
    /// The setup was edited.
    SetupEdited,
}

impl StaleCheck {
    /// The reason, as a sentence without full stop.
    pub fn words(self) -> &'static str {
        match self {
            Self::NotChecked => "The program could not be checked again: this is the check before",
            Self::File(change) => change.words().unwrap_or_default(),
            Self::SetupEdited => "The setup was edited after this check",
        }
    }

    /// The reason and what to do, for the status bar.
    pub fn brief_words(self) -> &'static str {
        match self {
            Self::NotChecked => "Not checked again: check again (F7)",
            Self::File(FileChange::Gone) => "The file of the program is no longer there",
            Self::File(_) => "File written again: check again (F7)",
            Self::SetupEdited => "Setup edited: check again (F7)",
        }
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
    /// Index of the first move of its line.
    pub first_move: Option<usize>,
    /// Text of its line.
    pub text: String,
}

/// A figure of a checked program: name, value, meaning.
pub type ProgramFigure = (&'static str, FigureValue, &'static str);

/// Value of a figure of a program; lengths in mm.
#[derive(Clone, Debug, PartialEq)]
pub enum FigureValue {
    /// A number of things, or a share, as it is written.
    Text(String),
    /// A length.
    Length(f64),
    /// Mean and 95th percentile of residual stock.
    Residual(f64, f64),
}

impl FigureValue {
    /// The value as it is written with `units`.
    pub fn text(&self, units: DisplayUnits) -> String {
        match *self {
            Self::Text(ref text) => text.clone(),
            Self::Length(mm) => units.known_length(mm, 3),
            Self::Residual(mean, p95) if mean.is_finite() => {
                format!("{} {}", units.pair(mean, p95, 2), units.length_unit())
            }
            Self::Residual(..) => "-".to_owned(),
        }
    }
}

/// A program with its findings.
#[derive(Clone, Debug)]
pub struct CheckedProgram {
    /// What was checked.
    pub request: CheckRequest,
    /// The file as it was read; `None` where the system does not say.
    pub stamp: Option<FileStamp>,
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
    /// The program itself.
    pub program: ClProgram,
    /// Part and blank that it was checked against.
    pub workpiece: Arc<Workpiece>,
    /// The machine of NC code, with the rotary positions that the code names; `None` for APT.
    pub on_machine: Option<NcMachine>,
    /// Its text, with line and time of each move.
    pub listing: Arc<ProgramListing>,
    /// Its moves as lines.
    pub lines: Vec<Segment>,
    /// Time of the whole program from feed rates and rapids, s.
    pub time_estimate: f64,
    /// Time on the machine that NC code was posted for, or of APT on that of the setup, s; `None` without
    /// one, and where it cannot run the program.
    pub machine_time: Option<f64>,
    /// Whether no accessible floor beyond the limit stays uncut.
    pub is_complete: bool,
}

impl CheckedProgram {
    /// Time of the whole program, s: on the machine, where that is known.
    pub fn time_s(&self) -> f64 {
        self.machine_time.unwrap_or(self.time_estimate)
    }

    /// Time after the first `count` moves, s, from feed rates and rapids.
    pub fn time_after(&self, count: usize) -> f64 {
        self.listing.time_after(count).unwrap_or(0.0)
    }

    /// Indices of the first moves of each tool, or of each section that the program names.
    pub fn boundaries(&self, of: Boundary) -> Vec<usize> {
        let Self { program: ClProgram { moves, rows, .. }, .. } = self;
        match of {
            Boundary::Tool => {
                let begins = |k: &usize| *k == 0 || moves[*k].tool != moves[*k - 1].tool;
                (0..moves.len()).filter(begins).collect()
            }
            Boundary::Section => {
                let begins = |k: &usize| *k == 0 || rows[*k].section != rows[*k - 1].section;
                (0..rows.len()).filter(begins).map(|k| rows[k].first_move).collect()
            }
        }
    }

    /// Name of the file.
    pub fn name(&self) -> String {
        self.request.path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    }
}
