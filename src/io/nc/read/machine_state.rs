//! Executes the words of an NC program and runs the positions through the machine's chain of axes.

mod motion;
mod place;
mod retract;

use super::words::{NcWord, leading_number};
use super::{Dialect, NcReading, ReadContext};
use crate::error::ErrorCode;
use crate::geometry::Vector;
use crate::io::InputError;
use crate::io::source::{self, Source};
use crate::machine::MachineTool;
use crate::setup::{CutDirection, SectionKind};
use crate::toolpath::{ClProgram, ClRow, ClSection, ClTool};
use place::{CoordinateMode, Place, RetractedTool};

/// Rounding of distances by four decimals of mm and degrees, mm.
const ROUNDING: f64 = 1e-3;
/// Largest number of tools, sections and rows.
const MAX_LISTED: usize = 10_000;

/// What a program has said, once and for all that follows.
#[derive(Clone, Copy, Default)]
struct Said {
    millimetres: bool,
    offset: bool,
    is_called: bool,
    orientation: bool,
    interpolation: bool,
}

/// The state of a control.
pub(super) struct NcState<'a> {
    source: Source<'a>,
    dialect: Dialect,
    context: &'a ReadContext<'a>,
    out: NcReading,
    frame: CoordinateMode,
    at: [Option<f64>; 3],
    angles: [Option<f64>; 2],
    vector: Option<Vector>,
    rapid: Option<bool>,
    rate: Option<f64>,
    inverse: Option<bool>,
    incremental: Option<bool>,
    length_on: bool,
    spindle_on: bool,
    speed: Option<f64>,
    next_tool: Option<u32>,
    tool: Option<usize>,
    /// Tools that comments describe.
    described: Vec<ClTool>,
    /// Where the tool stands, unless it is retracted or that is not known.
    before: Option<Place>,
    retracted: Option<RetractedTool>,
    /// Whether the axes still have to turn into the tilted plane.
    awaits_swivel: bool,
    said: Said,
    ended: bool,
}

impl<'a> NcState<'a> {
    pub fn new(source: Source<'a>, dialect: Dialect, context: &'a ReadContext<'a>) -> Self {
        let part = source::stem_of(source.file);
        Self {
            source,
            dialect,
            context,
            out: NcReading {
                program: ClProgram { part, rounding: ROUNDING, ..ClProgram::default() },
                ..NcReading::default()
            },
            frame: CoordinateMode::Joints,
            at: [None; 3],
            angles: [None; 2],
            vector: None,
            rapid: None,
            rate: None,
            inverse: None,
            incremental: None,
            length_on: false,
            spindle_on: false,
            speed: None,
            next_tool: None,
            tool: None,
            described: Vec::new(),
            before: None,
            retracted: None,
            awaits_swivel: false,
            said: Said::default(),
            ended: false,
        }
    }

    fn machine(&self) -> &'a MachineTool {
        self.context.machine
    }

    /// The program read, after its last line.
    ///
    /// # Errors
    /// When the end of the program was not reached.
    pub fn finish(self, lines: usize) -> Result<NcReading, InputError> {
        if !self.ended {
            let what = "the program has no end";
            return Err(self
                .source
                .fault(lines, what, "it seems cut off: write or copy it again")
                .with_code(ErrorCode::FileCutOff));
        }
        Ok(self.out)
    }

    /// Executes a block.
    ///
    /// # Errors
    /// When it asks for what a control does not do.
    pub fn block(&mut self, line: usize, words: &[NcWord]) -> Result<(), InputError> {
        if self.ended && words.iter().any(|w| !matches!(w, NcWord::Nothing | NcWord::Comment(_))) {
            return Err(self.source.fault(
                line,
                "the program goes on after its end",
                "give one program a file",
            ));
        }
        let home = words.iter().any(|word| matches!(word, NcWord::Home | NcWord::HomeOver));
        let mut moved = false;
        let mut rate_here = false;
        let mut direction = [None; 3];
        self.modes(line, words)?;
        for word in words {
            match word {
                NcWord::Linear(axis, x) if !home => {
                    if self.incremental != Some(false) {
                        return Err(self.source.fault(
                            line,
                            "the move is not absolute",
                            "give G90 before it",
                        ));
                    }
                    if !self.said.millimetres {
                        return Err(self.source.fault(
                            line,
                            "the unit of lengths is not said",
                            "give mm: G21 or G71",
                        ));
                    }
                    (self.at[*axis], moved) = (Some(*x), true);
                }
                NcWord::Rotary(letter, degrees) => {
                    let Some(axis) = self.machine().rotary.iter().position(|axis| axis.letter == *letter)
                    else {
                        let what = format!("the machine has no axis {letter}");
                        return Err(self.source.fault(
                            line,
                            what,
                            "verify with the machine it is posted for",
                        ));
                    };
                    if self.incremental != Some(false) {
                        return Err(self.source.fault(
                            line,
                            "the turn is not absolute",
                            "give G90 before it",
                        ));
                    }
                    (self.angles[axis], moved) = (Some(degrees.to_radians()), true);
                    self.vector = None;
                }
                NcWord::Direction(axis, x) => (direction[*axis], moved) = (Some(*x), true),
                NcWord::Rate(rate) => (self.rate, rate_here) = (Some(*rate), true),
                _ => {}
            }
        }
        if let [Some(x), Some(y), Some(z)] = direction {
            self.set_vector(line, Vector::new(x, y, z))?;
        } else if direction.iter().any(Option::is_some) {
            let what = "the direction of the tool is not whole";
            return Err(self.source.fault(line, what, "give all three components"));
        }
        if home {
            self.go_home(line, words)?;
        } else if moved {
            self.motion(line, rate_here)?;
        }
        if words.iter().any(|word| matches!(word, NcWord::End | NcWord::MainEnd | NcWord::Return)) {
            self.check_free(line, "the program ends")?;
            self.check_retracted(line, "the program ends")?;
            self.ended = true;
        }
        Ok(())
    }

    fn set_vector(&mut self, line: usize, v: Vector) -> Result<(), InputError> {
        if self.frame != CoordinateMode::Tip {
            let what = "a direction of the tool while the control does not hold the tip";
            return Err(self.source.fault(line, what, "switch TCP on before"));
        }
        let Some(unit) = v.try_normalize(1e-6).filter(|_| (v.norm() - 1.0).abs() < 1e-3) else {
            return Err(self.source.fault(
                line,
                "the direction of the tool is not a unit vector",
                "correct it",
            ));
        };
        self.vector = Some(unit);
        self.angles = [None; 2];
        Ok(())
    }

    /// Modes, tool, spindle and comments of a block.
    fn modes(&mut self, line: usize, words: &[NcWord]) -> Result<(), InputError> {
        for word in words {
            match word {
                NcWord::Comment(text) => self.comment(text),
                NcWord::Rapid => self.rapid = Some(true),
                NcWord::Feed => self.rapid = Some(false),
                NcWord::InverseTime(on) => {
                    if self.inverse.is_some_and(|before| before != *on) {
                        self.rate = None;
                    }
                    self.inverse = Some(*on);
                }
                NcWord::Incremental(on) => self.incremental = Some(*on),
                NcWord::Millimetres => self.said.millimetres = true,
                NcWord::Offset(number) => self.offset(line, *number)?,
                NcWord::Preset(number) => self.preset(line, *number)?,
                NcWord::Orientation => self.said.orientation = true,
                NcWord::Interpolation => self.said.interpolation = true,
                NcWord::IsCalled | NcWord::Return => self.said.is_called = true,
                NcWord::MainEnd | NcWord::IsMain => self.end_main(line)?,
                NcWord::Length(on) => self.set_length(*on),
                NcWord::LengthOffset(number) => self.length_offset(line, *number)?,
                NcWord::TipByAngles => {
                    let needs_offset = matches!(self.dialect, Dialect::Fanuc | Dialect::Haas);
                    let offset = words.iter().any(|w| matches!(w, NcWord::LengthOffset(_)));
                    if needs_offset && !offset {
                        return Err(self.source.fault(line, "the length offset H is missing", "give H"));
                    }
                    if needs_offset {
                        self.length_on = true;
                    }
                    self.set_frame(CoordinateMode::Tip);
                }
                NcWord::TipByVector if self.dialect == Dialect::Fanuc => {
                    self.length_on = true;
                    self.set_frame(CoordinateMode::Tip);
                }
                NcWord::TipByVector if self.frame != CoordinateMode::Tip => {
                    let what = "a vector while the control does not hold the tip";
                    return Err(self.source.fault(line, what, "switch TCP on before"));
                }
                NcWord::TipOff => {
                    if matches!(self.dialect, Dialect::Fanuc | Dialect::Haas) {
                        self.length_on = false;
                    }
                    // What ends TCP does not end a tilted plane.
                    if self.frame == CoordinateMode::Tip {
                        self.set_frame(CoordinateMode::Joints);
                    }
                }
                NcWord::Plane(frame) => {
                    self.check_retracted(line, "the plane is tilted")?;
                    self.set_frame(CoordinateMode::Plane(*frame));
                    self.angles = [None; 2];
                    self.awaits_swivel = true;
                }
                NcWord::Swivel => {
                    if let CoordinateMode::Plane([_, _, z]) = self.frame {
                        self.awaits_swivel = false;
                        self.swivel(line, &z)?;
                    }
                }
                NcWord::PlaneOff if matches!(self.frame, CoordinateMode::Plane(_)) => {
                    self.set_frame(CoordinateMode::Joints);
                }
                NcWord::Tool(number) => self.next_tool = Some(*number),
                NcWord::Change => {
                    self.change_tool(line)?;
                    // The speed may stand before the change in its block.
                    if !words.iter().any(|word| matches!(word, NcWord::Speed(_))) {
                        self.speed = None;
                    }
                }
                NcWord::Speed(speed) => {
                    self.speed = Some(*speed);
                    if let Some(tool) = self.tool.and_then(|tool| self.out.program.tools.get_mut(tool)) {
                        tool.spindle_rpm.get_or_insert(*speed);
                    }
                }
                NcWord::Spindle(on) => self.spindle_on = *on,
                _ => {}
            }
        }
        Ok(())
    }

    /// What coordinates mean from here on; the axes stay where they are.
    fn set_frame(&mut self, frame: CoordinateMode) {
        self.frame = frame;
        self.at = [None; 3];
        self.vector = None;
        self.awaits_swivel = false;
        (self.said.orientation, self.said.interpolation) = (false, false);
    }

    /// The spindle stops, and a program that no other one calls has chosen the work offset itself.
    fn end_main(&mut self, line: usize) -> Result<(), InputError> {
        self.spindle_on = false;
        if self.said.offset || self.said.is_called {
            return Ok(());
        }
        let what = "the program chooses no work offset";
        Err(self.source.fault(line, what, "give that of the machine file before the first move"))
    }

    /// The work offset has to be that of the machine file.
    fn offset(&mut self, line: usize, number: Option<f64>) -> Result<(), InputError> {
        self.said.offset = true;
        let name = self.machine().part.offset_name.trim();
        let wanted = name.strip_prefix(['G', 'g']).and_then(|rest| leading_number(rest, false).ok());
        match wanted.map(|(wanted, _)| wanted).zip(number) {
            Some((wanted, number)) if (wanted - number).abs() > 1e-6 => {
                let what = format!("G{number} is not the work offset {name} of the machine file");
                Err(self.source.fault(line, what, "give that, or correct `offset` of the machine file"))
            }
            _ => Ok(()),
        }
    }

    /// The preset has to be that of the machine file, as far as that has a number.
    fn preset(&mut self, line: usize, number: f64) -> Result<(), InputError> {
        self.said.offset = true;
        match self.machine().part.preset_number() {
            Some(wanted) if (f64::from(wanted) - number).abs() > 1e-6 => {
                let what = format!("preset {number} is not the preset {wanted} of the machine file");
                Err(self.source.fault(line, what, "give that, or correct `offset` of the machine file"))
            }
            _ => Ok(()),
        }
    }

    fn set_length(&mut self, on: bool) {
        if self.length_on != on && self.frame == CoordinateMode::Joints {
            self.at[2] = None;
        }
        self.length_on = on;
    }

    /// The length offset has to be that of the tool.
    fn length_offset(&self, line: usize, number: f64) -> Result<(), InputError> {
        let tool = self.tool.and_then(|tool| self.out.program.tools.get(tool));
        if let Some(tool) = tool.filter(|tool| f64::from(tool.length_offset_number()) != number) {
            let what = format!("H{number} is not the length offset of tool {}", tool.number);
            let help = format!("give H{}, or the tool its length_offset", tool.length_offset_number());
            return Err(self.source.fault(line, what, help));
        }
        Ok(())
    }

    /// Checks that neither TCP nor a plane is on.
    fn check_free(&self, line: usize, when: &str) -> Result<(), InputError> {
        match self.frame {
            CoordinateMode::Joints => Ok(()),
            CoordinateMode::Tip => {
                let what = format!("{when} while the control holds the tip");
                Err(self.source.fault(line, what, "switch TCP off before"))
            }
            CoordinateMode::Plane(_) => {
                let what = format!("{when} in a tilted plane");
                Err(self.source.fault(line, what, "switch the plane off before"))
            }
        }
    }

    fn change_tool(&mut self, line: usize) -> Result<(), InputError> {
        self.check_free(line, "the tool is changed")?;
        self.check_retracted(line, "the tool is changed")?;
        let Some(number) = self.next_tool.filter(|number| *number > 0) else {
            return Err(self
                .source
                .fault(line, "the tool change has no tool number", "give T before M6")
                .with_code(ErrorCode::ProgramTool));
        };
        let known = |tool: &&ClTool| tool.number == number;
        let tool = self.described.iter().rev().find(known).cloned();
        let tool = tool.or_else(|| {
            self.context.tools.iter().find(|tool| tool.number == number).map(|tool| ClTool {
                feed_mm_per_min: None,
                spindle_rpm: None,
                ..ClTool::from_tool(tool)
            })
        });
        let Some(tool) = tool else {
            let what = format!("tool {number} is not known");
            return Err(self
                .source
                .fault(line, what, "give it in the setup as [[tool]]")
                .with_code(ErrorCode::ProgramTool));
        };
        let same = |t: &ClTool| {
            (t.number, t.diameter, t.corner_radius, t.overhang, t.length_offset)
                == (tool.number, tool.diameter, tool.corner_radius, tool.overhang, tool.length_offset)
        };
        let tools = &mut self.out.program.tools;
        self.tool = tools.iter().position(same);
        if self.tool.is_none() {
            if tools.len() >= MAX_LISTED {
                return Err(self.source.fault(line, "the program has too many tools", "split it"));
            }
            tools.push(tool);
            self.tool = Some(tools.len() - 1);
        }
        self.spindle_on = false;
        self.length_on = false;
        self.rate = None;
        Ok(())
    }

    /// Tools, sections and rows that our posts name in comments.
    fn comment(&mut self, text: &str) {
        let words: Vec<&str> = text.split_whitespace().take(16).collect();
        let program = &mut self.out.program;
        match words.as_slice() {
            ["TOOL", number, values @ ..] => {
                let value = |name: &str| {
                    let text = values.iter().find_map(|v| v.strip_prefix(name)?.strip_prefix('='))?;
                    source::number(text).ok()
                };
                if let (Ok(number), Some(diameter), true) =
                    (number.parse(), value("D"), self.described.len() < MAX_LISTED)
                {
                    self.described.push(ClTool {
                        number,
                        diameter,
                        corner_radius: value("R").unwrap_or(0.0),
                        insert_width: value("W"),
                        overhang: value("L"),
                        feed_mm_per_min: None,
                        spindle_rpm: None,
                        length_offset: value("H").map(|number| number as u32),
                    });
                }
            }
            ["SECTION", _, "FROM", from, "TO", to, "D", diameter, feed, rest @ ..]
                if program.sections.len() < MAX_LISTED =>
            {
                if let [Ok(from), Ok(to), Ok(diameter)] = [from, to, diameter].map(|x| source::number(x)) {
                    let feed = if *feed == "OUTWARD" {
                        CutDirection::InletToOutlet
                    } else {
                        CutDirection::OutletToInlet
                    };
                    program.sections.push(ClSection {
                        from,
                        to,
                        diameter,
                        feed,
                        kind: SectionKind::from_words(rest),
                    });
                }
            }
            ["ROW", section, row] if program.rows.len() < source::MAX_POINTS => {
                let number = |word: &str| word.parse::<usize>().ok()?.checked_sub(1);
                if let (Some(section), Some(row)) = (number(section), number(row)) {
                    let first_move = program.moves.len();
                    program.rows.push(ClRow { first_move, section, row });
                }
            }
            _ => {}
        }
    }
}
