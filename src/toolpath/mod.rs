//! Toolpaths as data: tools, moves, sections and rows of a cutter-location program.
//!
//! Positions are in the part frame, rotation axis Z, in mm; feed rates in mm/min, spindle speeds in
//! rev/min. Tool axes are unit vectors from tip to holder.

mod channels;
mod min_rapids;
mod travel;

pub use channels::{ChannelStep, OpenedPlaces, order_steps};
pub use min_rapids::min_rapid_length;
pub use travel::Travel;

use crate::geometry::{Point, Vector};
use crate::setup::{CutDirection, SectionKind, Setup, Tool};

/// Rapid feed rate assumed for time estimates, mm/min.
pub const RAPID_MM_PER_MIN: f64 = 10_000.0;
/// Time of a tool change including the approach with the next tool, s.
pub const TOOL_CHANGE_S: f64 = 120.0;
/// Consecutive moves under feed across the axis that are a pass along a curve: plunge programs position and
/// lift their tools under feed, but not in that many moves.
const PASS_MOVES: usize = 8;
/// Distance across the axis below which a move still counts as one along it, mm, and as a share of its
/// length; programs have a few decimals.
const AXIAL_TOLERANCE: f64 = 1e-4;
/// Turn of the axis that such a move may have, rad.
const AXIAL_TURN_RAD: f64 = 1e-5;
/// Maximum number of warnings that the reader collects.
pub const MAX_WARNINGS: usize = 100;

/// What the part name of a program ends in whose plan was stopped.
pub const UNFINISHED: &str = "UNFINISHED";
/// Warning of a reader that finds it.
const UNFINISHED_WARNING: &str =
    "the program is marked as unfinished: the calculation of its plan was stopped, and cuts may be missing";

/// The first characters of a part name, `most` at most; what marks an unfinished plan stays.
pub fn shortened_part_name(name: &str, most: usize) -> String {
    let (name, mark) = match name.strip_suffix(UNFINISHED) {
        Some(name) => (name, UNFINISHED),
        None => (name, ""),
    };
    name.chars().take(most.saturating_sub(mark.len())).collect::<String>() + mark
}

/// A tool as a CL program describes it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ClTool {
    /// Tool number; 0 when the program gives none.
    pub number: u32,
    /// Diameter, mm; 0 when the program gives none.
    pub diameter: f64,
    /// Corner radius, mm.
    pub corner_radius: f64,
    /// Radial width of the bottom cutting edges, mm (`PPRINT/INSERT WIDTH n w`).
    pub insert_width: Option<f64>,
    /// Free length from the tip to the holder, mm.
    pub overhang: Option<f64>,
    /// First feed rate used with the tool, mm/min. The writer uses the feed rates of the moves.
    pub feed_mm_per_min: Option<f64>,
    /// Spindle speed, rev/min.
    pub spindle_rpm: Option<f64>,
    /// Number of its length offset in the control; absent: that of the tool.
    pub length_offset: Option<u32>,
}

impl ClTool {
    /// The tool as a program describes it.
    pub fn from_tool(tool: &Tool) -> Self {
        Self {
            number: tool.number,
            diameter: tool.diameter,
            corner_radius: tool.corner_radius,
            insert_width: Some(tool.insert_width),
            overhang: Some(tool.overhang),
            feed_mm_per_min: Some(tool.plunge_feed),
            spindle_rpm: Some(tool.spindle),
            length_offset: tool.assembly.length_offset,
        }
    }

    /// Number of its length offset in the control.
    pub fn length_offset_number(&self) -> u32 {
        self.length_offset.unwrap_or(self.number)
    }

    /// The tool with what the program does not say from the tool of the same number and diameter in `setup`,
    /// or else assumed: edges over 0.9 of the radius, four diameters of overhang. Where both give the insert
    /// width or the overhang, the lesser holds: a tool that is shorter than the program's collides, and one
    /// that is longer is not what was programmed.
    pub fn completed(&self, setup: &Setup) -> Tool {
        let same = |t: &&Tool| t.number == self.number && (t.diameter - self.diameter).abs() < 1e-6;
        let known = setup.tools.iter().find(same);
        let lesser = |ours: Option<f64>, shop: Option<f64>| ours.into_iter().chain(shop).reduce(f64::min);
        let insert_width =
            lesser(self.insert_width, known.map(|t| t.insert_width)).unwrap_or(0.9 * self.diameter / 2.0);
        let overhang = lesser(self.overhang, known.map(|t| t.overhang)).unwrap_or(4.0 * self.diameter);
        Tool {
            number: self.number,
            diameter: self.diameter,
            corner_radius: self.corner_radius,
            insert_width: insert_width.min(self.diameter / 2.0),
            overhang,
            plunge_feed: self.feed_mm_per_min.or(known.map(|t| t.plunge_feed)).unwrap_or(300.0),
            spindle: self.spindle_rpm.or(known.map(|t| t.spindle)).unwrap_or(1200.0),
            assembly: known.map(|t| t.assembly.clone()).unwrap_or_default(),
        }
    }
}

/// Rapid or feed motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Rapid motion.
    Rapid,
    /// Feed motion at a feed rate in mm/min; `None` when the program gives none.
    Feed(Option<f64>),
}

/// A linear move to a position.
#[derive(Clone, Debug, PartialEq)]
pub struct Move {
    /// Rapid or feed.
    pub motion: Motion,
    /// Tip of the tool (centre of its bottom) at the end of the move, mm.
    pub tip: Point,
    /// Unit tool axis, tip → holder.
    pub axis: Vector,
    /// Index into [`ClProgram::tools`]; `None` before any tool is loaded.
    pub tool: Option<usize>,
    /// Line of the file; 0 when the program was not read from a file.
    pub line: usize,
}

/// An oddity in a program that does not prevent reading it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ClWarning {
    /// Line of the file.
    pub line: usize,
    /// What was found and how it was interpreted.
    pub message: String,
}

/// A section of the plan in the program: `PPRINT/SECTION n FROM s TO s D d INWARD [REST|OPENING]`.
#[derive(Clone, Debug, PartialEq)]
pub struct ClSection {
    /// s at the outlet end.
    pub from: f64,
    /// s at the inlet end.
    pub to: f64,
    /// Diameter of its tool, mm.
    pub diameter: f64,
    /// Cutting direction of its rows.
    pub feed: CutDirection,
    /// What it cuts.
    pub kind: SectionKind,
}

/// Start of a row of plunges: `PPRINT/ROW section row`, both counted from 1.
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
    /// Sections of the plan it was written from; empty for other programs.
    pub sections: Vec<ClSection>,
    /// Rows of that plan, in cutting order.
    pub rows: Vec<ClRow>,
    /// Rounding of distances by the file's numbers, mm; 0: that of six decimals.
    pub rounding: f64,
    /// Lines of the moves under feed while the program has stopped the spindle.
    pub stopped_spindle_lines: Vec<usize>,
    /// Warnings of the reader, by line; at most [`MAX_WARNINGS`].
    pub warnings: Vec<ClWarning>,
    /// Whether its file ends without the statement that ends a program.
    pub is_cut_off: bool,
}

impl ClProgram {
    /// Whether its part name says that the calculation of its plan was stopped.
    pub fn is_unfinished(&self) -> bool {
        self.part.ends_with(UNFINISHED)
    }

    /// What it is where it may lack moves, as an end of a sentence about it; `None` where it is whole.
    pub fn incomplete_words(&self) -> Option<&'static str> {
        match (self.is_unfinished(), self.is_cut_off) {
            (true, _) => Some("is unfinished"),
            (false, true) => Some("seems cut off"),
            (false, false) => None,
        }
    }

    /// Takes the name of the part from a line of the program's file, with a warning where it is that of an
    /// unfinished plan.
    pub fn name_part(&mut self, line: usize, name: &str) {
        name.clone_into(&mut self.part);
        if self.is_unfinished() {
            self.warnings.insert(0, ClWarning { line, message: UNFINISHED_WARNING.to_owned() });
        }
    }
}

impl Move {
    /// Whether the tool moves along its own axis from `before` to here, without turning.
    pub fn is_axial_from(&self, before: &Self) -> bool {
        is_axial(&(self.tip - before.tip), &before.axis, &self.axis)
    }
}

/// Whether a tool whose tip moves by `travel` (mm) while its unit axis turns from one to the other moves
/// along its axis, without turning.
pub fn is_axial(travel: &Vector, from_axis: &Vector, to_axis: &Vector) -> bool {
    let across = (travel - to_axis * travel.dot(to_axis)).norm();
    across < AXIAL_TOLERANCE * (1.0 + travel.norm()) && from_axis.angle(to_axis) < AXIAL_TURN_RAD
}

impl ClProgram {
    /// Whether the program mills along curves, alone or beside plunges: most of its moves under feed do not
    /// plunge along the axis, or a pass of them does not.
    pub fn mills_along_curves(&self) -> bool {
        let (mut along, mut across, mut pass) = (0usize, 0usize, 0usize);
        for pair in self.moves.windows(2) {
            if !matches!(pair[1].motion, Motion::Feed(_)) || pair[0].tool != pair[1].tool {
                pass = 0;
                continue;
            }
            if pair[1].is_axial_from(&pair[0]) {
                (along, pass) = (along + 1, 0);
            } else {
                (across, pass) = (across + 1, pass + 1);
            }
            if pass == PASS_MOVES {
                return true;
            }
        }
        across > along
    }
}

impl ClProgram {
    /// How often a tool is loaded.
    pub fn tool_loads(&self) -> usize {
        let tools = self.moves.iter().filter_map(|step| step.tool);
        let mut loaded = None;
        tools.filter(|&tool| loaded.replace(tool) != Some(tool)).count()
    }

    /// Indices of the moves with which plunges begin, in programs as the planner writes them: each of these
    /// is a rapid to a plunge, the first of a tool or after the rapid out of the plunge before. The rapid
    /// that may follow, down to where the feed begins, belongs to the same plunge.
    pub fn plunge_starts(&self) -> Vec<usize> {
        let moves = &self.moves;
        let is_rapid = |k: usize| moves[k].motion == Motion::Rapid;
        let is_first = |k: usize| k == 0 || moves[k - 1].tool != moves[k].tool;
        let begins = |&k: &usize| is_first(k) || is_rapid(k - 1) && !is_first(k - 1) && !is_rapid(k - 2);
        (0..moves.len()).filter(|&k| is_rapid(k)).filter(begins).collect()
    }

    /// The values at the ends of the plunges, of one value for `each_move`. A plunge ends before the next one
    /// starts.
    pub fn at_plunge_ends(&self, each_move: &[f64]) -> Vec<f64> {
        let ends = self.plunge_starts().into_iter().skip(1).chain([self.moves.len()]);
        ends.filter_map(|end| each_move.get(end.checked_sub(1)?).copied()).collect()
    }
}
