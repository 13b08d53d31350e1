//! Writes the motion of a machine as an NC program.

use super::format::NumberFormat;
use super::plane::TiltedPlane;
use super::post::{Dialect, Post};
use crate::error::{ErrorCode, UserError};
use crate::geometry::{Point, Vector};
use crate::io::apt::section_words;
use crate::io::source::quote_for_message;
use crate::machine::{
    LINEAR_NAMES, MachineProgram, MachineStep, MachineTool, OutputKind, Pose, StepMotion, gauge_length,
};
use crate::toolpath::{ClProgram, ClTool, shortened_part_name};

/// Largest block number after `N`, after which numbers begin again: controls take six digits, and nothing in
/// a program refers to a block.
const MAX_BLOCK_NUMBER: u32 = 999_999;
/// Longest name of a program in its head.
const MAX_NAME: usize = 24;
/// Shortest time of a block, s: its inverse time in 1/min keeps below a million, which is what words may
/// hold.
const MIN_BLOCK_S: f64 = 1e-4;
/// Least time of a block under feed, as a multiple of that at rapid rates.
const SLOWER: f64 = 1.25;

/// A program as text.
#[derive(Clone, Debug)]
pub struct NcProgram {
    /// Its text.
    pub text: String,
    /// Number of blocks: lines that are not comments only.
    pub blocks: usize,
    /// Number of moves under feed: those of the program that move, and what is added between them to keep
    /// the machine on its course.
    pub positions: usize,
    /// Largest distance of a tip as written from the one meant, mm: rounding.
    pub rounding_error: f64,
}

impl NcProgram {
    /// Number of its blocks, in words: comments are lines of the file, but the control skips them.
    pub fn block_words(&self) -> String {
        format!("{} blocks without comments", self.blocks)
    }
}

/// Writes `motion` of `program` on `machine` by `post`, with the comments `remarks` in its head.
///
/// ```
/// use vanecut::io::{apt::read_apt_bytes, machine_file::read_machine, nc::{read_post, write_nc}};
/// use vanecut::machine::{MotionOptions, PlacedPart, machine_program};
/// use vanecut::monitor::Monitor;
/// let text = b"LOADTL/1\nCUTTER/20\nSPINDL/1200,CLW\nRAPID\nGOTO/0,0,50,0,0,1\n\
///     FEDRAT/300,MMPM\nGOTO/0,0,9,0,0,1\nFINI";
/// let program = read_apt_bytes("plunge.apt", text)?;
/// let machine = read_machine("ac-trunnion".as_ref())?;
/// let post = read_post(&machine.control)?;
/// let options = MotionOptions::new(machine.output, post.format.angle_decimals);
/// let placed = PlacedPart::new(&machine.part, true);
/// let motion = machine_program(&machine, &placed, &program, &options, &Monitor::default());
/// let motion = motion.map_err(|fault| fault.explained())?;
/// let written = write_nc(&program, &machine, &motion, &post, machine.output, &[])?;
/// assert!(written.text.lines().count() > 3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the control does not take `output`, a tool has no number or spindle speed, or the work offset has no
/// number where the control selects it by one.
pub fn write_nc(
    program: &ClProgram,
    machine: &MachineTool,
    motion: &MachineProgram,
    post: &Post,
    output: OutputKind,
    remarks: &[String],
) -> Result<NcProgram, UserError> {
    check(program, motion, post, output)?;
    check_preset(machine, post)?;
    let mut writer = NcWriter {
        program,
        machine,
        post,
        output,
        text: String::with_capacity(motion.steps.len() * 48),
        number: post.format.numbers.map_or(0, |(first, _)| first),
        blocks: 0,
        positions: 0,
        said: Modal::default(),
        plane: TiltedPlane::default(),
        is_plane_on: false,
        rounding_error: 0.0,
        row: 0,
    };
    writer.group("start", None, None);
    remarks.iter().for_each(|remark| writer.comment(remark));
    writer.sections();
    let mut before: Option<&MachineStep> = None;
    for step in &motion.steps {
        writer.rows_until(step.source);
        if step.motion == StepMotion::Approach {
            writer.approach(before, step);
        } else {
            writer.step(before, step);
        }
        before = Some(step);
    }
    if let Some(last) = before {
        writer.depart(last);
    }
    writer.group("end", before, None);
    let NcWriter { text, blocks, positions, rounding_error, .. } = writer;
    Ok(NcProgram { text, blocks, positions, rounding_error })
}

/// Checks what the control cannot do without.
fn check(
    program: &ClProgram,
    motion: &MachineProgram,
    post: &Post,
    output: OutputKind,
) -> Result<(), UserError> {
    if !post.on.contains_key(&output) {
        let known: Vec<&str> = post.outputs().map(OutputKind::name).collect();
        let (name, output) = (&post.name, output.name());
        let what = format!("the control {name} does not take {output}");
        return Err(UserError::new(ErrorCode::ControlOutput, what, format!("use {}", known.join(" or "))));
    }
    for (index, tool) in program.tools.iter().enumerate() {
        if !motion.steps.iter().any(|step| step.tool == index) {
            continue;
        }
        let place = if tool.diameter > 0.0 { format!(" of {:.3} mm", tool.diameter) } else { String::new() };
        if tool.number == 0 {
            let what = format!("a tool{place} has no number");
            let help = "give the program LOADTL before it is used";
            return Err(UserError::new(ErrorCode::ProgramTool, what, help));
        }
        if tool.spindle_rpm.is_none() {
            let what = format!("tool {}{place} has no spindle speed", tool.number);
            return Err(UserError::new(ErrorCode::ProgramTool, what, "give the program SPINDL"));
        }
    }
    Ok(())
}

/// Checks that the work offset of the machine has a number where the post asks for it.
fn check_preset(machine: &MachineTool, post: &Post) -> Result<(), UserError> {
    let mut blocks = post.blocks.values().chain(post.on.values()).chain(post.off.values()).flatten();
    if machine.part.preset_number().is_some() || !blocks.any(|block| block.contains("{preset}")) {
        return Ok(());
    }
    let name = quote_for_message(&machine.part.offset_name);
    let what = format!("the control {} selects presets by number, but the work offset is {name}", post.name);
    let help = "set `offset` in the machine file to the preset number, or to G54 … G59 for presets 1 to 6";
    Err(UserError::new(ErrorCode::UnknownName, what, help))
}

/// The words that hold until others replace them.
#[derive(Default)]
struct Modal {
    /// Words as last written: linear and rotary axes, feed.
    words: [String; 6],
    feed_move: bool,
    inverse: bool,
}

struct NcWriter<'a> {
    program: &'a ClProgram,
    machine: &'a MachineTool,
    post: &'a Post,
    output: OutputKind,
    text: String,
    number: u32,
    blocks: usize,
    positions: usize,
    said: Modal,
    plane: TiltedPlane,
    is_plane_on: bool,
    rounding_error: f64,
    /// Rows of the plan already named.
    row: usize,
}

impl NcWriter<'_> {
    fn format(&self) -> &NumberFormat {
        &self.post.format
    }

    fn tool(&self, step: &MachineStep) -> ClTool {
        self.program.tools.get(step.tool).cloned().unwrap_or_default()
    }

    /// Starts a block: its number.
    fn begin(&mut self, text: &str) {
        if self.post.dialect == Dialect::Heidenhain {
            self.text.push_str(&format!("{} ", self.number));
            self.number += 1;
        } else if let Some((first, step)) =
            self.post.format.numbers.filter(|_| !is_unnumbered(self.post.dialect, text))
        {
            self.text.push_str(&format!("N{} ", self.number));
            let next = self.number.saturating_add(step);
            self.number = if next > MAX_BLOCK_NUMBER { first } else { next };
        }
    }

    /// A whole block.
    fn line(&mut self, text: &str) {
        self.begin(text);
        self.text.push_str(text);
        self.text.push('\n');
        self.blocks += usize::from(!text.starts_with(['(', ';', '*', '%']));
    }

    fn comment(&mut self, text: &str) {
        let text: String = text
            .chars()
            .map(|c| {
                if c.is_ascii_alphanumeric() || " .,=+-_/".contains(c) { c.to_ascii_uppercase() } else { ' ' }
            })
            .collect();
        match self.post.dialect {
            Dialect::Heidenhain | Dialect::Siemens => self.line(&format!("; {text}")),
            _ => self.line(&format!("({text})")),
        }
    }

    /// A group of the post, or the blocks that switch an output on or off.
    fn group(&mut self, group: &str, step: Option<&MachineStep>, lines: Option<&[String]>) {
        let post = self.post;
        let lines = lines.or_else(|| post.blocks.get(group).map(Vec::as_slice)).unwrap_or_default();
        let letters: String = self.program.part.chars().filter(char::is_ascii_alphanumeric).collect();
        let name = shortened_part_name(&letters.to_ascii_uppercase(), MAX_NAME);
        let name = if name.is_empty() { "VANECUT".to_owned() } else { name };
        for line in lines {
            let mut filled = line.clone();
            let mut put = |word: &str, value: &dyn Fn(&Self) -> String| {
                let braces = format!("{{{word}}}");
                if filled.contains(&braces) {
                    filled = filled.replace(&braces, &value(self));
                }
            };
            put("name", &|_| name.clone());
            put("number", &|_| "1000".to_owned());
            put("machine", &|w| comment_text(&w.machine.name));
            put("offset", &|w| w.machine.part.offset_name.clone());
            // Checked before.
            put("preset", &|w| w.machine.part.preset_number().map_or_else(String::new, |n| n.to_string()));
            put("retract", &|w| w.axis_word(2, w.machine.links.retract_z));
            if let Some(step) = step {
                put("tool", &|w| w.tool(step).number.to_string());
                put("length_offset", &|w| w.tool(step).length_offset_number().to_string());
                put("diameter", &|w| w.format().text(w.tool(step).diameter, 3));
                put("spindle", &|w| format!("{:.0}", w.tool(step).spindle_rpm.unwrap_or_default()));
                put("x", &|w| w.axis_word(0, w.above(step)[0]));
                put("y", &|w| w.axis_word(1, w.above(step)[1]));
                put("angles", &|w| {
                    let words = [0, 1].map(|i| w.angle_word(i, step.pose.angles[i]));
                    words.join(" ")
                });
                for (i, word) in ["p1", "p2", "p3"].into_iter().enumerate() {
                    put(word, &|w| {
                        w.format().text(w.plane.angles[i].to_degrees(), w.format().angle_decimals)
                    });
                }
            }
            self.line(&filled);
            self.is_plane_on |= line.contains("{p1}");
        }
    }

    /// Where X and Y stand above the approach, as the control takes them there: of the joints, or once a
    /// plane is on, in the plane.
    fn above(&self, step: &MachineStep) -> [f64; 3] {
        if self.is_plane_on {
            return self.plane.coordinates(&step.pose.tip).coords.into();
        }
        self.joints(step)
    }

    /// Positions of the linear axes, counted from the program's zero.
    fn joints(&self, step: &MachineStep) -> [f64; 3] {
        let length = gauge_length(self.machine, &self.tool(step));
        let zero = self.machine.zero(length);
        let joints = self.machine.joints(&step.pose.tip, &step.pose.angles, length);
        std::array::from_fn(|i| joints[i] - zero[i])
    }

    fn axis_word(&self, axis: usize, x: f64) -> String {
        let mut word = String::new();
        self.format().push(&mut word, LINEAR_NAMES[axis].encode_utf8(&mut [0; 4]), x, self.format().decimals);
        word
    }

    fn angle_word(&self, axis: usize, angle: f64) -> String {
        let mut word = String::new();
        let letter = self.machine.rotary[axis].letter;
        let format = self.format();
        format.push(&mut word, letter.encode_utf8(&mut [0; 4]), angle.to_degrees(), format.angle_decimals);
        word
    }

    /// Names the sections of the plan as comments.
    fn sections(&mut self) {
        let program = self.program;
        for (index, section) in program.sections.iter().enumerate() {
            self.comment(&section_words(index, section));
        }
    }

    /// Names the rows of the plan as comments.
    fn rows_until(&mut self, source: usize) {
        while let Some(row) = self.program.rows.get(self.row).filter(|row| row.first_move <= source) {
            self.comment(&format!("ROW {} {}", row.section + 1, row.row + 1));
            self.row += 1;
        }
    }

    /// From the retract position to `step`, after a tool change or a change of the plane.
    fn approach(&mut self, before: Option<&MachineStep>, step: &MachineStep) {
        if let Some(before) = before {
            self.depart(before);
        }
        let post = self.post;
        if before.is_none_or(|before| before.tool != step.tool) {
            if before.is_none() {
                self.group("retract", Some(step), None);
            }
            let tool = self.tool(step);
            let offset = tool.length_offset.map_or_else(String::new, |offset| format!(" H={offset}"));
            self.comment(&format!(
                "TOOL {} D={} R={} W={} L={}{offset}",
                tool.number,
                tool.diameter,
                tool.corner_radius,
                tool.insert_width.unwrap_or(0.5 * tool.diameter),
                tool.overhang.unwrap_or_default()
            ));
            self.group("tool", Some(step), None);
        }
        if self.output == OutputKind::Plane {
            self.plane = TiltedPlane::across(post.dialect, &step.pose.axis, post.format.angle_decimals);
        }
        self.is_plane_on = false;
        let on = post.on.get(&self.output).map(Vec::as_slice).unwrap_or_default();
        if let Some(above) = self.above_when_called(step) {
            let turns_not = |line: &&String| !line.contains("{x}") && !line.contains("{y}");
            let on: Vec<String> = on.iter().filter(turns_not).cloned().collect();
            self.group("on", Some(step), Some(on.as_slice()));
            self.said = Modal::default();
            self.step(None, &above);
            self.step(Some(&above), step);
        } else {
            self.group("on", Some(step), Some(on));
            self.said = Modal::default();
            self.step(None, step);
        }
        self.group("ready", Some(step), None);
    }

    /// Where a called program begins, unless it gives joints: above the approach, at the upper limit of Z.
    /// The offset turns from call to call, and positions of the axes in X and Y before TCP or a plane is on
    /// would turn with it.
    fn above_when_called(&self, step: &MachineStep) -> Option<MachineStep> {
        if !self.post.is_called || self.output == OutputKind::Joints {
            return None;
        }
        let length = gauge_length(self.machine, &self.tool(step));
        let [x, y, z] = self.machine.joints(&step.pose.tip, &step.pose.angles, length);
        let top = self.machine.linear[2].limits.1.max(z);
        let tip = self.machine.tip(&[x, y, top], &step.pose.angles, length);
        Some(MachineStep { pose: Pose { tip, ..step.pose }, ..*step })
    }

    /// To the retract position.
    fn depart(&mut self, before: &MachineStep) {
        let post = self.post;
        if self.said.inverse {
            self.line("G94");
        }
        self.group("leave", Some(before), None);
        self.group("off", Some(before), post.off.get(&self.output).map(Vec::as_slice));
        self.group("retract", Some(before), None);
    }

    /// A block of motion.
    fn step(&mut self, before: Option<&MachineStep>, step: &MachineStep) {
        let format = &self.post.format;
        let pose = &step.pose;
        let at: Point = match self.output {
            OutputKind::TcpAngles | OutputKind::TcpVectors => pose.tip,
            OutputKind::Plane => self.plane.coordinates(&pose.tip),
            OutputKind::Joints => Point::from(Vector::from(self.joints(step))),
        };
        // All linear axes first, then the rotary ones or the vector.
        let mut words: [String; 6] = Default::default();
        for i in 0..3 {
            words[i] = self.axis_word(i, at[i]);
        }
        let scale = 10f64.powi(format.decimals as i32);
        let rounded = at.map(|x| (x * scale).round() / scale - x);
        self.rounding_error = self.rounding_error.max(rounded.coords.norm());
        let mut vector = String::new();
        match self.output {
            OutputKind::TcpAngles | OutputKind::Joints => {
                for i in 0..2 {
                    words[3 + i] = self.angle_word(i, pose.angles[i]);
                }
            }
            OutputKind::TcpVectors => {
                let names = match self.post.dialect {
                    Dialect::Heidenhain => ["TX", "TY", "TZ"],
                    Dialect::Siemens => ["A3=", "B3=", "C3="],
                    _ => ["I", "J", "K"],
                };
                for i in 0..3 {
                    vector.push(' ');
                    format.push(&mut vector, names[i], pose.axis[i], format.vector_decimals);
                }
            }
            OutputKind::Plane => {}
        }
        let (rate, inverse) = self.rate(before, step);
        words[5] = match inverse {
            Some(per_minute) => format.text(per_minute, 4),
            None => format.text(rate, format.feed_decimals),
        };
        let fresh = before.is_none();
        let changed: [bool; 6] = std::array::from_fn(|i| fresh || words[i] != self.said.words[i]);
        let turns = self.output == OutputKind::TcpVectors
            && (fresh || before.is_some_and(|before| before.pose.axis != pose.axis));
        if !changed[..5].iter().any(|c| *c) && !turns {
            return;
        }
        let mut line = String::with_capacity(80);
        let klartext = self.post.dialect == Dialect::Heidenhain;
        if klartext {
            line.push_str(if self.output == OutputKind::TcpVectors { "LN" } else { "L" });
        } else {
            if inverse.is_some() != self.said.inverse {
                line.push_str(if inverse.is_some() { "G93 " } else { "G94 " });
            }
            if !self.said.feed_move || inverse.is_some() != self.said.inverse {
                line.push_str("G1");
            }
        }
        for i in 0..5 {
            // A block with a vector names its place whole.
            if (changed[i] || (turns && i < 3)) && !words[i].is_empty() {
                line.push(' ');
                line.push_str(&words[i]);
            }
        }
        if turns {
            line.push_str(&vector);
        }
        if klartext {
            line.push_str(" R0");
        }
        if changed[5] || inverse.is_some() || inverse.is_some() != self.said.inverse {
            line.push_str(" F");
            line.push_str(words[5].trim_start_matches('+'));
        }
        let line = line.trim_start().to_owned();
        self.line(&line);
        self.positions += usize::from(matches!(step.motion, StepMotion::Feed(_)));
        self.said = Modal { words, feed_move: true, inverse: inverse.is_some() };
    }

    /// Feed rate of a block in mm/min, and its inverse time in 1/min where the control does not hold the tip
    /// and the tool turns.
    fn rate(&self, before: Option<&MachineStep>, step: &MachineStep) -> (f64, Option<f64>) {
        let rate = match step.motion {
            StepMotion::Feed(rate) => rate,
            StepMotion::Link | StepMotion::Approach => self.machine.links.rate,
        };
        let Some(before) = before.filter(|b| b.pose.angles != step.pose.angles) else { return (rate, None) };
        if self.output != OutputKind::Joints {
            return (rate, None);
        }
        let travel = (step.pose.tip - before.pose.tip).norm();
        let (from, to) = (self.joints(before), self.joints(step));
        let linear = (0..3).map(|i| 60.0 * (to[i] - from[i]).abs() / self.machine.linear[i].rapid);
        let turn = |i: usize| (step.pose.angles[i] - before.pose.angles[i]).abs();
        let rotary = (0..2).map(|i| turn(i) / self.machine.rotary[i].rapid_rad_per_s);
        let fastest = linear.chain(rotary).fold(MIN_BLOCK_S, f64::max);
        let seconds = match step.motion {
            // Under feed no axis runs at its rapid: that is how a reader tells cuts from links.
            StepMotion::Feed(_) => {
                (60.0 * travel / rate).max(SLOWER * fastest).max(self.machine.block_time_s)
            }
            _ => fastest,
        };
        (rate, Some(60.0 / seconds))
    }
}

/// Whether a line takes no block number: frames and names of programs, and comments.
fn is_unnumbered(dialect: Dialect, text: &str) -> bool {
    text.starts_with(['%', '(', ';']) || dialect != Dialect::Siemens && text.starts_with('O')
}

/// `text` without what ends a comment, in capitals.
fn comment_text(text: &str) -> String {
    let plain = text.chars().filter(|c| c.is_ascii() && !c.is_control() && !"();".contains(*c));
    plain.map(|c| c.to_ascii_uppercase()).collect()
}
