//! Executes the words of an NC program and runs the positions through the machine's chain of axes.

use super::words::NcWord;
use super::{AxisOverrun, Dialect, MAX_OVERRUNS, NcReading, ReadContext};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::io::InputError;
use crate::io::source::{self, Source};
use crate::machine::{LINEAR_NAMES, MachineTool, Pose, gauge_length, mixed_angles};
use crate::setup::{CutDirection, SectionKind};
use crate::toolpath::{ClProgram, ClRow, ClSection, ClTool, Motion, Move};

/// Rounding of distances by four decimals of mm and degrees, mm.
const ROUNDING: f64 = 1e-3;
/// A rate this near to that of links, or a block this near to the machine's fastest, is a rapid.
const RAPID_SHARE: f64 = 0.99;
const RAPID_TIME: f64 = 1.05;
/// Stray of the axis in joint space above which positions are added, rad.
const MAX_STRAY: f64 = 0.1 * std::f64::consts::PI / 180.0;
/// Stray of the tip above which positions are added, mm.
const MAX_TIP_STRAY: f64 = 0.02;
/// Turn of a rotary axis between added positions, rad, and their largest number.
const ADDED_TURN: f64 = 2.0 * std::f64::consts::PI / 180.0;
const MAX_ADDED: usize = 400;
/// Largest number of tools, sections and rows.
const MAX_LISTED: usize = 10_000;

/// What the coordinates of a block mean.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CoordinateMode {
    /// Positions of the axes, counted from the program's zero.
    Joints,
    /// The tip in program coordinates.
    Tip,
    /// The tip in a tilted plane, by the directions of its X, Y, Z.
    Plane([Vector; 3]),
}

/// A position with what is needed to go on from it.
#[derive(Clone, Copy)]
struct Place {
    pose: Pose,
    /// Whether `pose.angles` are known.
    by_angles: bool,
    joints: [f64; 3],
    frame_is_joints: bool,
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
    inverse: bool,
    incremental: bool,
    length_on: bool,
    spindle_on: bool,
    speed: Option<f64>,
    next_tool: Option<u32>,
    tool: Option<usize>,
    /// Tools that comments describe.
    described: Vec<ClTool>,
    before: Option<Place>,
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
            inverse: false,
            incremental: false,
            length_on: false,
            spindle_on: false,
            speed: None,
            next_tool: None,
            tool: None,
            described: Vec::new(),
            before: None,
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
        let home = words.contains(&NcWord::Home);
        let mut moved = false;
        let mut rate_here = false;
        let mut direction = [None; 3];
        self.modes(line, words)?;
        for word in words {
            match word {
                NcWord::Linear(axis, x) if !home => {
                    if self.incremental {
                        return Err(self.source.fault(line, "incremental moves are not read", "use G90"));
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
            self.go_home(line)?;
        } else if moved {
            self.motion(line, rate_here)?;
        }
        if words.contains(&NcWord::End) {
            self.check_free(line, "the program ends")?;
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
                    if *on != self.inverse {
                        self.rate = None;
                    }
                    self.inverse = *on;
                }
                NcWord::Incremental(on) => self.incremental = *on,
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
                    self.set_frame(CoordinateMode::Plane(*frame));
                    self.angles = [None; 2];
                }
                NcWord::PlaneOff if matches!(self.frame, CoordinateMode::Plane(_)) => {
                    self.set_frame(CoordinateMode::Joints);
                }
                NcWord::Tool(number) => self.next_tool = Some(*number),
                NcWord::Change => self.change_tool(line)?,
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

    fn set_frame(&mut self, frame: CoordinateMode) {
        let retracted = self.at[2].is_none();
        self.frame = frame;
        self.at = [None; 3];
        self.vector = None;
        if !retracted {
            self.before = None;
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
        let tool = self.tool.and_then(|tool| self.out.program.tools.get(tool)).map(|tool| tool.number);
        if tool.is_some_and(|tool| f64::from(tool) != number) {
            let what = format!("H{number} is not the length offset of tool {}", tool.unwrap_or_default());
            return Err(self.source.fault(line, what, "give the H of the tool's number"));
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

    fn go_home(&mut self, line: usize) -> Result<(), InputError> {
        self.check_free(line, "the tool goes to its retract position")?;
        self.at = [None; 3];
        self.before = None;
        Ok(())
    }

    fn change_tool(&mut self, line: usize) -> Result<(), InputError> {
        self.check_free(line, "the tool is changed")?;
        if self.at[2].is_some() {
            let what = "the tool is changed where it stands";
            return Err(self.source.fault(line, what, "retract it before"));
        }
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
                ..ClTool::of(tool)
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
            (t.number, t.diameter, t.corner_radius, t.overhang)
                == (tool.number, tool.diameter, tool.corner_radius, tool.overhang)
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

    /// A block that moves.
    fn motion(&mut self, line: usize, rate_here: bool) -> Result<(), InputError> {
        let Some(rapid) = self.rapid else {
            return Err(self.source.fault(line, "a move without G0 or G1 before it", "give one of them"));
        };
        let [Some(x), Some(y), Some(z)] = self.at else {
            // Above the part only single axes may be positioned, and not while the control holds the tip.
            if self.frame == CoordinateMode::Tip && self.at != [None; 3] {
                let what = "the first position after TCP is on is not given whole";
                return Err(self.source.fault(line, what, "give X, Y and Z in one block"));
            }
            return Ok(());
        };
        let Some(tool) = self.tool else {
            return Err(self
                .source
                .fault(line, "a move before the first tool", "change to a tool before")
                .with_code(ErrorCode::ProgramTool));
        };
        if !self.length_on {
            return Err(self.source.fault(line, "a move without the tool's length", "give G43 or D1 before"));
        }
        if self.inverse && !rapid && !rate_here {
            return Err(self.source.fault(line, "no F in a block of inverse time", "give F in each block"));
        }
        let place = self.place(line, [x, y, z], tool)?;
        let rapid = rapid || self.is_fast(&place);
        if !rapid && !self.spindle_on {
            return Err(self.source.fault(line, "a cut while the spindle stands", "start it with M3"));
        }
        let rate = match (self.inverse, self.rate) {
            (true, Some(per_minute)) => {
                let travel = self.before.map_or(0.0, |b| (place.pose.tip - b.pose.tip).norm());
                Some(travel * per_minute).filter(|rate| *rate > 0.0)
            }
            (_, rate) => rate.filter(|rate| *rate > 0.0),
        };
        let motion = if rapid { Motion::Rapid } else { Motion::Feed(rate) };
        self.add(line, motion, place, tool)
    }

    /// The pose of a block, checked against the limits.
    fn place(&mut self, line: usize, at: [f64; 3], tool: usize) -> Result<Place, InputError> {
        let machine = self.machine();
        let length = self.out.program.tools.get(tool).map_or(0.0, |tool| gauge_length(machine, tool));
        let whole = || self.source.fault(line, "the position of a rotary axis is not known", "give both");
        let angles = match self.angles {
            [Some(a), Some(b)] => Some([a, b]),
            _ => None,
        };
        let (pose, joints, by_angles) = match (self.frame, angles) {
            (CoordinateMode::Joints, angles) => {
                let angles = angles.ok_or_else(whole)?;
                let zero = machine.zero(length);
                let joints: [f64; 3] = std::array::from_fn(|i| at[i] + zero[i]);
                let tip = machine.tip(&joints, &angles, length);
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, joints, true)
            }
            (CoordinateMode::Tip, Some(angles)) => {
                let tip = Point::from(Vector::from(at));
                let joints = machine.joints(&tip, &angles, length);
                (Pose { tip, axis: machine.tool_axis(&angles), angles }, joints, true)
            }
            (CoordinateMode::Tip, None) => {
                let axis = self.vector.ok_or_else(whole)?;
                (Pose { tip: Point::from(Vector::from(at)), axis, angles: [0.0; 2] }, [0.0; 3], false)
            }
            (CoordinateMode::Plane([x, y, z]), _) => {
                let tip = Point::from(x * at[0] + y * at[1] + z * at[2]);
                (Pose { tip, axis: z, angles: [0.0; 2] }, [0.0; 3], false)
            }
        };
        if by_angles {
            self.check_limits(line, &joints, &pose.angles);
        }
        Ok(Place { pose, by_angles, joints, frame_is_joints: self.frame == CoordinateMode::Joints })
    }

    fn check_limits(&mut self, line: usize, joints: &[f64; 3], angles: &[f64; 2]) {
        let machine = self.machine();
        let mut found = Vec::new();
        if let Some(axis) = machine.linear_axis_beyond(joints) {
            found.push((LINEAR_NAMES[axis], joints[axis], machine.linear[axis].limits));
        }
        for (axis, angle) in machine.rotary.iter().zip(angles) {
            if let Some((low, high)) = axis.limits.filter(|_| !axis.allows(*angle)) {
                found.push((axis.letter, angle.to_degrees(), (low.to_degrees(), high.to_degrees())));
            }
        }
        for (letter, value, limits) in found {
            if self.out.overruns.len() < MAX_OVERRUNS {
                self.out.overruns.push(AxisOverrun { line, letter, value, limits });
            }
        }
    }

    /// Whether a block under G1 runs as fast as links do.
    fn is_fast(&self, place: &Place) -> bool {
        let machine = self.machine();
        let Some(rate) = self.rate else { return false };
        if !self.inverse {
            return rate >= RAPID_SHARE * machine.links.rate;
        }
        let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) else { return false };
        let linear =
            (0..3).map(|i| 60.0 * (place.joints[i] - before.joints[i]).abs() / machine.linear[i].rapid);
        let turn = |i: usize| (place.pose.angles[i] - before.pose.angles[i]).abs();
        let rotary = (0..2).map(|i| turn(i) / machine.rotary[i].rapid_rad_per_s);
        60.0 / rate.max(1e-9) <= RAPID_TIME * linear.chain(rotary).fold(1e-6, f64::max)
    }

    /// Adds a move, and positions before it where the axes leave the even course between two blocks.
    fn add(&mut self, line: usize, motion: Motion, place: Place, tool: usize) -> Result<(), InputError> {
        if let Some(before) = self.before.filter(|b| b.by_angles && place.by_angles) {
            let machine = self.machine();
            let length = self.out.program.tools.get(tool).map_or(0.0, |tool| gauge_length(machine, tool));
            let (a, b) = (&before.pose, &place.pose);
            let joints = place.frame_is_joints && before.frame_is_joints;
            let strays = machine.axis_stray((&a.axis, a.angles), (&b.axis, b.angles)) > MAX_STRAY
                || joints && machine.tip_stray(a, b, length) > MAX_TIP_STRAY;
            if strays {
                let turn = (0..2).map(|i| (b.angles[i] - a.angles[i]).abs()).fold(0.0, f64::max);
                let steps = ((turn / ADDED_TURN).ceil() as usize).clamp(2, MAX_ADDED);
                for k in 1..steps {
                    let share = k as f64 / steps as f64;
                    let angles = mixed_angles(&a.angles, &b.angles, share);
                    let tip = if joints {
                        let at = std::array::from_fn(|i| {
                            before.joints[i] + (place.joints[i] - before.joints[i]) * share
                        });
                        machine.tip(&at, &angles, length)
                    } else {
                        a.tip + (b.tip - a.tip) * share
                    };
                    self.push(line, motion, tip, machine.tool_axis(&angles), tool, Some(angles))?;
                }
            }
        }
        let angles = place.by_angles.then_some(place.pose.angles);
        self.push(line, motion, place.pose.tip, place.pose.axis, tool, angles)?;
        self.before = Some(place);
        Ok(())
    }

    fn push(
        &mut self,
        line: usize,
        motion: Motion,
        tip: Point,
        axis: Vector,
        tool: usize,
        angles: Option<[f64; 2]>,
    ) -> Result<(), InputError> {
        if self.out.program.moves.len() >= source::MAX_POINTS {
            return Err(self
                .source
                .fault(line, "the program has more than 1,000,000 moves", "split it")
                .with_code(ErrorCode::FileTooLarge));
        }
        let placed = &self.context.placed;
        if let (Motion::Feed(rate), Some(cutter)) = (motion, self.out.program.tools.get_mut(tool)) {
            cutter.feed_mm_per_min = cutter.feed_mm_per_min.or(rate);
        }
        self.out.program.moves.push(Move {
            motion,
            tip: placed.point_in_part(&tip),
            axis: placed.vector_in_part(&axis),
            tool: Some(tool),
            line,
        });
        self.out.angles.push(angles);
        Ok(())
    }
}
