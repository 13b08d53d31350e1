//! Reads APT programs of any CAM system.
//!
//! A statement is a word, optionally `/` and a list: `GOTO/x,y,z,i,j,k`. Case and blanks are ignored.
//! `$$` starts a comment, a trailing `$` continues on the next line; `PARTNO`, `PPRINT` and `REMARK` take
//! their line literally. `RAPID` applies to the next `GOTO` only. A `GOTO` of three numbers keeps the last
//! axis (initially 0, 0, 1), whether `MULTAX` is on or off. `TRACUT` and `TRANS` are applied. Other
//! statements that move or transform are errors; unknown words are reported as warnings. The NX (`TLDATA`,
//! `TOOL PATH`, `LOAD/TOOL`, `FEDRAT/MMPM,150.`) and Creo (`LOADTL/1,LENGTH,120.`, `$$-> CUTTER / 30.`)
//! dialects are supported.

mod tools;

use std::path::Path;

use super::super::InputError;
use super::super::source;
use super::super::source::{
    MAX_COORDINATE, MAX_MOVES, MAX_POINTS, MAX_PROGRAM_BYTES, Source, TRUNCATED, name_of, program_text,
    quote_for_message, read_bytes_up_to,
};
use super::transform::Transform;
use super::words::{WordEffect, classify_word};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::setup::{CutDirection, SectionKind};
use crate::toolpath::{ClProgram, ClRow, ClSection, ClWarning, MAX_WARNINGS, Motion, Move};

const MM_PER_INCH: f64 = 25.4;
/// Maximum number of list words that are read: more than any supported statement needs.
const MAX_WORDS: usize = 64;
/// Maximum number of tools in a program.
const MAX_TOOLS: usize = 1_000;
/// Maximum number of distinct unknown words that are reported.
const MAX_UNKNOWN: usize = 50;
/// Tolerance on the length of a unit axis, for rounding in the file.
const AXIS_TOLERANCE: f64 = 1e-3;

/// Reads a CL program from a file. Oddities that do not prevent reading go to [`ClProgram::warnings`].
///
/// # Errors
/// When the file cannot be read, or as [`read_apt_bytes`].
pub fn read_apt(path: &Path) -> Result<ClProgram, InputError> {
    read_apt_bytes(&name_of(path), &read_bytes_up_to(path, MAX_PROGRAM_BYTES)?)
}

/// Reads a CL program from bytes; `name` is the file name used in messages.
///
/// ```
/// let text = b"LOADTL/1\nCUTTER/10\nRAPID\nGOTO/0,0,50,0,0,1\nFEDRAT/300,MMPM\nGOTO/0,0,20,0,0,1\nFINI";
/// let program = vanecut::io::apt::read_apt_bytes("one.apt", text)?;
/// assert_eq!((program.tools[0].diameter, program.moves.len()), (10.0, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When a number or an axis is invalid, a statement moves or transforms in an unsupported way, or the
/// program has no moves.
pub fn read_apt_bytes(name: &str, bytes: &[u8]) -> Result<ClProgram, InputError> {
    let source = Source::new(name, ErrorCode::AptStatement);
    let text = program_text(source, bytes)?;
    let mut reader = Reader::new(source);
    let mut lines = text.lines().enumerate();
    let mut last = 0;
    while let Some((at, line)) = lines.next() {
        last = at + 1;
        if literal(line) {
            reader.literal(at + 1, line.trim());
            continue;
        }
        let mut statement = String::new();
        let mut open = gather(&mut statement, line);
        while open {
            let Some((at, line)) = lines.next() else { break };
            last = at + 1;
            open = gather(&mut statement, line);
        }
        if reader.statement(at + 1, &statement)? {
            reader.ended = true;
            break;
        }
    }
    reader.finish(last)
}

/// Appends a line without its comment; returns whether the statement continues on the next line.
fn gather(statement: &mut String, line: &str) -> bool {
    let line = line.trim();
    // Creo writes the cutter in a comment.
    let line = line.strip_prefix("$$->").filter(|rest| starts_with_word(rest, "CUTTER")).unwrap_or(line);
    let line = line.find("$$").map_or(line, |at| line.get(..at).unwrap_or(line)).trim_end();
    match line.strip_suffix('$') {
        Some(line) => {
            statement.push_str(line);
            true
        }
        None => {
            statement.push_str(line);
            false
        }
    }
}

fn starts_with_word(text: &str, word: &str) -> bool {
    let text = text.trim_start();
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
        && !text.get(word.len()..).is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_alphanumeric()))
}

fn literal(line: &str) -> bool {
    ["PARTNO", "PPRINT", "REMARK"].iter().any(|word| starts_with_word(line, word))
}

struct Reader<'a> {
    source: Source<'a>,
    program: ClProgram,
    /// Length of the program's unit, mm.
    unit_mm: f64,
    tip: Point,
    axis: Vector,
    rapid: bool,
    feed_mm_per_min: Option<f64>,
    tool: Option<usize>,
    /// Whether the current tool has moved; a `CUTTER` of another size then starts a new tool.
    used: bool,
    /// Whether the current tool was given a number.
    numbered: bool,
    spindle_rpm: Option<f64>,
    /// Whether the program has stopped the spindle.
    spindle_stopped: bool,
    insert_widths: Vec<(u32, f64)>,
    transform: Transform,
    /// List of the first `MSYS`: the frame of all positions.
    frame: Option<Vec<String>>,
    /// The last statement that moved the cutter to an unknown position: its line and word.
    unknown_position: Option<(usize, String)>,
    /// Unknown words: the word, its first line, and its number of occurrences.
    unknown: Vec<(String, usize, usize)>,
    ended: bool,
}

impl<'a> Reader<'a> {
    fn new(source: Source<'a>) -> Self {
        Self {
            source,
            program: ClProgram::default(),
            unit_mm: 1.0,
            tip: Point::origin(),
            axis: Vector::z(),
            rapid: false,
            feed_mm_per_min: None,
            tool: None,
            used: false,
            numbered: false,
            spindle_rpm: None,
            spindle_stopped: false,
            insert_widths: Vec::new(),
            transform: Transform::default(),
            frame: None,
            unknown_position: None,
            unknown: Vec::new(),
            ended: false,
        }
    }

    fn warn(&mut self, line: usize, what: &str) {
        if self.program.warnings.len() < MAX_WARNINGS {
            self.program.warnings.push(ClWarning { line, message: what.to_owned() });
        }
    }

    /// Reads `PARTNO name`, `PPRINT/INSERT WIDTH n w`, `PPRINT/SECTION …` and `PPRINT/ROW n m`; other
    /// literal lines are comments.
    fn literal(&mut self, line: usize, text: &str) {
        let (word, rest) = text.split_at_checked(6).unwrap_or((text, ""));
        let rest = rest.trim_start().trim_start_matches('/').trim();
        if word.eq_ignore_ascii_case("PARTNO") {
            if self.program.part.is_empty() {
                self.program.name_part(line, rest);
            }
            return;
        }
        if !word.eq_ignore_ascii_case("PPRINT") {
            return;
        }
        let words: Vec<String> =
            rest.split_whitespace().take(MAX_WORDS).map(str::to_ascii_uppercase).collect();
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        match *words.as_slice() {
            ["INSERT", "WIDTH", ref list @ ..] => self.insert_width(line, list),
            ["SECTION", _, "FROM", from, "TO", to, "D", d, feed, ref rest @ ..] => {
                let feed =
                    if feed == "OUTWARD" { CutDirection::InletToOutlet } else { CutDirection::OutletToInlet };
                let numbers = [from, to, d].map(source::number);
                if let [Ok(from), Ok(to), Ok(diameter)] = numbers
                    && self.program.sections.len() < MAX_TOOLS
                {
                    let kind = SectionKind::from_words(rest);
                    let diameter = diameter * self.unit_mm;
                    self.program.sections.push(ClSection { from, to, diameter, feed, kind });
                }
            }
            ["ROW", section, row] => {
                let number = |word: &str| word.parse::<usize>().ok()?.checked_sub(1);
                if let (Some(section), Some(row)) = (number(section), number(row))
                    && self.program.rows.len() < MAX_POINTS
                {
                    let first_move = self.program.moves.len();
                    self.program.rows.push(ClRow { first_move, section, row });
                }
            }
            _ => {}
        }
    }

    /// Reads a tool number and the width of its inserts.
    fn insert_width(&mut self, line: usize, words: &[&str]) {
        let number = words.first().and_then(|token| token.parse::<u32>().ok());
        let width = words.get(1).and_then(|token| source::number(token).ok()).filter(|width| *width > 0.0);
        match number.zip(width) {
            // The list is bounded, like the list of tools.
            Some((number, width)) if self.insert_widths.len() < MAX_TOOLS => {
                self.insert_widths.push((number, width * self.unit_mm));
                let here = self.tool.and_then(|index| self.program.tools.get_mut(index));
                if let Some(tool) = here.filter(|tool| tool.number == number) {
                    tool.insert_width = Some(width * self.unit_mm);
                }
            }
            _ => self.warn(line, "INSERT WIDTH without `n w` was ignored"),
        }
    }

    /// Processes one statement; returns true at the end of the program.
    fn statement(&mut self, line: usize, text: &str) -> Result<bool, InputError> {
        let (word, list) = text.split_once('/').unwrap_or((text, ""));
        let word: String = word.split_whitespace().collect::<Vec<_>>().join(" ").to_ascii_uppercase();
        let words: Vec<String> =
            list.split(',').take(MAX_WORDS).map(|w| w.trim().to_ascii_uppercase()).collect();
        if self.program.tools.len() > MAX_TOOLS {
            let what = format!("the program loads more than {MAX_TOOLS} tools");
            return Err(self
                .source
                .fault(line, what, "check that this is the right file")
                .with_code(ErrorCode::FileTooLarge));
        }
        match word.as_str() {
            "FINI" => return Ok(true),
            "RAPID" => self.rapid = true,
            "INCHES" => self.unit_mm = MM_PER_INCH,
            "UNITS" => match words.first().map(String::as_str) {
                Some("MM") => self.unit_mm = 1.0,
                Some("INCHES" | "INCH" | "IN") => self.unit_mm = MM_PER_INCH,
                Some("CM") => self.unit_mm = 10.0,
                other => {
                    let what =
                        format!("{} is not a known unit", quote_for_message(other.unwrap_or_default()));
                    return Err(self.source.fault(line, what, "give UNITS/MM or UNITS/INCHES"));
                }
            },
            "GOTO" => self.goto(line, &words, self.rapid)?,
            "GOHOME" if words.len() >= 3 => self.goto(line, &words, true)?,
            "FROM" => {
                let numbers = self.numbers(line, &word, &words)?;
                self.set_position(line, &word, &numbers)?;
            }
            "GODLTA" => self.godlta(line, &words)?,
            "FEDRAT" => self.fedrat(line, &words)?,
            "SPINDL" => self.spindl(&words),
            "LOADTL" => self.load(&words),
            "LOAD" | "SELECT" if words.first().is_some_and(|w| w == "TOOL") => {
                self.load(words.get(1..).unwrap_or_default());
            }
            "CUTTER" => self.cutter(line, &words, None)?,
            "TLDATA" => {
                let sizes = words.get(1..).unwrap_or_default();
                let length = sizes.get(2).and_then(|w| source::number(w).ok()).filter(|l| *l > 0.0);
                self.cutter(line, sizes, Some(length))?;
            }
            "END-OF-PATH" => self.ended = true,
            "TRACUT" if words.first().is_some_and(|w| w == "NOMORE") => self.transform.clear_matrix(),
            "TRACUT" => {
                let numbers = self.numbers(line, &word, &words)?;
                let help = "give 12 numbers: three rows of a rotation, each with its shift";
                let set = self.transform.set_matrix(&numbers, self.unit_mm);
                set.map_err(|what| self.source.fault(line, what, help))?;
            }
            "TRANS" => self.trans(line, &words)?,
            "ORIGIN" if self.is_zero(&words) => {}
            "MSYS" if *self.frame.get_or_insert_with(|| words.clone()) != words => {
                let help = "export all positions in the coordinates of the part";
                return Err(self.source.fault(line, "MSYS changes the frame of the positions", help));
            }
            _ => self.classify_statement(line, &word, &words)?,
        }
        Ok(false)
    }

    /// Whether a list has only zeros.
    fn is_zero(&self, words: &[String]) -> bool {
        let zero = |word: &String| word.is_empty() || source::number(word).is_ok_and(|x| x == 0.0);
        words.iter().all(zero)
    }

    /// `TRANS/x,y,z`: the shift that is added to all following positions.
    fn trans(&mut self, line: usize, words: &[String]) -> Result<(), InputError> {
        let [x, y, z] = *self.numbers(line, "TRANS", words)? else {
            let what = "TRANS does not give a shift by x,y,z";
            return Err(self.source.fault(line, what, "export all positions in the coordinates of the part"));
        };
        self.transform.set_shift(Vector::new(x, y, z) * self.unit_mm);
        Ok(())
    }

    /// Classifies a statement that the reader does not apply; an error if ignoring it would falsify the path.
    fn classify_statement(&mut self, line: usize, word: &str, words: &[String]) -> Result<(), InputError> {
        match classify_word(word, words) {
            WordEffect::Ignored => {}
            WordEffect::Unsupported(help) => {
                let what = format!("{} changes the path and is not supported", quote_for_message(word));
                return Err(self.source.fault(line, what, help));
            }
            WordEffect::UnknownPosition => self.unknown_position = Some((line, word.to_owned())),
            WordEffect::Unknown => {
                let known = self.unknown.iter().position(|(known, ..)| known == word);
                if let Some((.., count)) = known.and_then(|index| self.unknown.get_mut(index)) {
                    *count += 1;
                } else if self.unknown.len() < MAX_UNKNOWN {
                    self.unknown.push((word.to_owned(), line, 1));
                }
            }
        }
        Ok(())
    }

    fn numbers(&self, line: usize, word: &str, words: &[String]) -> Result<Vec<f64>, InputError> {
        // A trailing comma is common.
        let words = match words {
            [list @ .., last] if last.is_empty() => list,
            list => list,
        };
        words.iter().map(|token| self.number(line, word, token)).collect()
    }

    fn number(&self, line: usize, word: &str, token: &str) -> Result<f64, InputError> {
        source::number(token).map_err(|fault| {
            self.source
                .fault(line, format!("{word}: {}", fault.message), "correct or export again")
                .with_code(ErrorCode::InvalidNumber)
        })
    }

    /// Sets tip and axis from 3 or 6 numbers; lengths in the program's unit.
    fn set_position(&mut self, line: usize, word: &str, numbers: &[f64]) -> Result<(), InputError> {
        let (x, y, z) = match *numbers {
            [x, y, z] => (x, y, z),
            [x, y, z, i, j, k] => {
                let axis = Vector::new(i, j, k);
                let length = axis.norm();
                if (length - 1.0).abs() > AXIS_TOLERANCE {
                    let what = if length < 1e-6 {
                        format!("{word}: the axis has no length")
                    } else {
                        format!("{word}: the axis i,j,k has the length {length:.6}, not 1")
                    };
                    let help = "give the direction from tip to holder as a unit vector";
                    return Err(self.source.fault(line, what, help));
                }
                self.axis = axis / length;
                (x, y, z)
            }
            _ => {
                let what = format!("{word} has {} numbers", numbers.len());
                return Err(self.source.fault(line, what, "give x,y,z or x,y,z,i,j,k"));
            }
        };
        self.set_tip(line, Point::new(x, y, z) * self.unit_mm)
    }

    fn set_tip(&mut self, line: usize, tip: Point) -> Result<(), InputError> {
        if tip.coords.amax() > MAX_COORDINATE {
            return Err(self.too_far(line));
        }
        self.tip = tip;
        Ok(())
    }

    fn too_far(&self, line: usize) -> InputError {
        let what = "the position is more than 1,000,000 mm away";
        self.source.fault(line, what, "check the numbers and the units").with_code(ErrorCode::InvalidNumber)
    }

    fn goto(&mut self, line: usize, words: &[String], rapid: bool) -> Result<(), InputError> {
        let numbers = self.numbers(line, "GOTO", words)?;
        self.set_position(line, "GOTO", &numbers)?;
        self.push(line, rapid)
    }

    /// `GODLTA/dx,dy,dz`, or a distance along the axis.
    fn godlta(&mut self, line: usize, words: &[String]) -> Result<(), InputError> {
        let step = match *self.numbers(line, "GODLTA", words)? {
            [x, y, z] => Vector::new(x, y, z),
            [d] => self.axis * d,
            ref other => {
                let what = format!("GODLTA has {} numbers", other.len());
                return Err(self.source.fault(line, what, "give dx,dy,dz or one distance"));
            }
        };
        self.set_tip(line, self.tip + step * self.unit_mm)?;
        self.push(line, self.rapid)
    }

    fn push(&mut self, line: usize, rapid: bool) -> Result<(), InputError> {
        if self.program.moves.len() >= MAX_MOVES {
            return Err(self
                .source
                .fault(line, "holds more than 4,000,000 moves", "split the program")
                .with_code(ErrorCode::FileTooLarge));
        }
        if let Some((away, word)) = self.unknown_position.take() {
            let what = format!("{word} moves the cutter to a position that the program does not give");
            return Err(self.source.fault(away, what, "give that position by GOTO"));
        }
        self.rapid = false;
        self.used = true;
        self.ended = false;
        let motion = if rapid { Motion::Rapid } else { Motion::Feed(self.feed_mm_per_min) };
        if !rapid && self.spindle_stopped {
            self.program.stopped_spindle_lines.push(line);
        }
        if let Motion::Feed(Some(feed)) = motion
            && let Some(tool) = self.tool.and_then(|index| self.program.tools.get_mut(index))
        {
            tool.feed_mm_per_min.get_or_insert(feed);
        }
        let (tip, axis) = self.transform.apply(&self.tip, &self.axis);
        if tip.coords.amax() > MAX_COORDINATE {
            return Err(self.too_far(line));
        }
        self.program.moves.push(Move { motion, tip, axis, tool: self.tool, line });
        Ok(())
    }

    /// `FEDRAT` with number and unit in either order; a plain number is in the program's unit per minute.
    fn fedrat(&mut self, line: usize, words: &[String]) -> Result<(), InputError> {
        let mut rate = None;
        let mut unit = self.unit_mm;
        for word in words {
            match word.as_str() {
                "MMPM" => unit = 1.0,
                "IPM" => unit = MM_PER_INCH,
                "MMPR" => unit = self.spindle_rpm.unwrap_or(0.0),
                "IPR" => unit = self.spindle_rpm.unwrap_or(0.0) * MM_PER_INCH,
                "PERREV" => unit *= self.spindle_rpm.unwrap_or(0.0),
                "RAPID" => self.rapid = true,
                word if rate.is_none() && word.starts_with(|c: char| !c.is_ascii_alphabetic()) => {
                    rate = Some(self.number(line, "FEDRAT", word)?);
                }
                _ => {}
            }
        }
        let Some(rate) = rate else { return Ok(()) };
        self.feed_mm_per_min = Some(rate * unit).filter(|feed| *feed > 0.0 && *feed <= MAX_COORDINATE);
        if self.feed_mm_per_min.is_none() {
            self.warn(line, "this feed rate is not usable and is treated as unknown");
        }
        Ok(())
    }

    fn finish(mut self, last: usize) -> Result<ClProgram, InputError> {
        if self.program.moves.is_empty() {
            return Err(self
                .source
                .fault(last, "the program has no moves", "check that it holds GOTO statements")
                .with_code(ErrorCode::NothingMoves));
        }
        for (word, line, count) in std::mem::take(&mut self.unknown) {
            let times = if count > 1 { format!(", {count} times") } else { String::new() };
            self.warn(line, &format!("{} is not known and was left out{times}", quote_for_message(&word)));
        }
        self.program.warnings.sort_by_key(|warning| warning.line);
        if !self.ended {
            self.warn(last, &format!("FINI is missing: {TRUNCATED}"));
            self.program.is_cut_off = true;
        }
        Ok(self.program)
    }
}
