//! What the lines of all dialects say.

use crate::geometry::Vector;
use crate::io::source::{number, quote_for_message};

/// One thing that a block says.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum NcWord {
    /// Moves are rapid.
    Rapid,
    /// Moves are under feed.
    Feed,
    /// A linear axis, by index.
    Linear(usize, f64),
    /// A rotary axis, by letter, degrees.
    Rotary(char, f64),
    /// A component of the tool's direction.
    Direction(usize, f64),
    /// Feed rate: mm/min, or 1/min in inverse time.
    Rate(f64),
    /// Feed per minute (false) or inverse time (true).
    InverseTime(bool),
    /// The control holds the tip; the tool's direction is given by rotary axes.
    TipByAngles,
    /// The control holds the tip; the tool's direction is given by a vector.
    TipByVector,
    /// The control does not hold the tip any more.
    TipOff,
    /// The length of the tool counts (true), or not.
    Length(bool),
    /// The number of the length offset.
    LengthOffset(f64),
    /// A tilted plane: directions of its X, Y, Z.
    Plane([Vector; 3]),
    /// The rotary axes turn the tool square to the tilted plane.
    Swivel,
    /// No tilted plane.
    PlaneOff,
    /// The axis words of this block are machine coordinates: the tool goes to its retract position.
    Home,
    /// The same by way of the position that the axis words name (G28).
    HomeOver,
    /// Incremental (true) or absolute coordinates.
    Incremental(bool),
    /// Tool by number, in the spindle after the next change.
    Tool(u32),
    /// The tool is changed.
    Change,
    /// Lengths are in mm.
    Millimetres,
    /// The work offset by its number, `None` where that says nothing.
    Offset(Option<f64>),
    /// The work offset as the number of a preset.
    Preset(f64),
    /// The tool turns as its rotary axes do, or as a vector does; said of the coordinates that count.
    Orientation,
    /// The same of how it turns from one position to the next.
    Interpolation,
    /// Spindle speed, rev/min.
    Speed(f64),
    /// The spindle turns, or stands.
    Spindle(bool),
    /// A comment.
    Comment(String),
    /// End of the program.
    End,
    /// End of a program that no other one calls; `IsMain` where its last block is still to come.
    MainEnd,
    /// See `MainEnd`.
    IsMain,
    /// The program returns to the one that calls it, and ends; `IsCalled` where it goes on.
    Return,
    /// See `Return`.
    IsCalled,
    /// A block whose contents do not move anything.
    Nothing,
}

/// What is wrong with a line, and what to do.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NcFault {
    pub what: String,
    pub help: &'static str,
}

/// A fault of a line.
pub(super) fn fault<T>(what: impl Into<String>, help: &'static str) -> Result<T, NcFault> {
    Err(NcFault { what: what.into(), help })
}

/// The fault of a text that begins with no letter where a word should begin.
pub(super) fn no_letter<T>(rest: &str) -> Result<T, NcFault> {
    fault(format!("a word begins with a letter, not with {}", quote_for_message(rest)), UNKNOWN)
}

/// What to do about a word that is not read.
pub(super) const UNKNOWN: &str = "give a program as `vanecut post` writes it, or APT";

/// What to do about a spindle that turns backwards.
pub(super) const FORWARDS: &str = "start it with M3";

/// A number at the start of `text`, and what follows it. A comma is taken as a point where `comma`.
pub(super) fn leading_number(text: &str, comma: bool) -> Result<(f64, &str), NcFault> {
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || (comma && c == ',');
    let sign = usize::from(text.starts_with(['+', '-']));
    let digits = text.get(sign..).unwrap_or_default();
    let end = sign + digits.find(|c| !is_part(c)).unwrap_or(digits.len());
    let (token, rest) = text.split_at(end);
    let plain = if comma { token.replace(',', ".") } else { token.to_owned() };
    match number(plain.strip_prefix('+').unwrap_or(&plain)) {
        Ok(x) => Ok((x, rest)),
        Err(_) => fault(format!("{} is not a number", quote_for_message(token)), "correct the number"),
    }
}

/// A whole number that is not negative, such as a tool's.
pub(super) fn whole(x: f64) -> Result<u32, NcFault> {
    if x.fract() == 0.0 && (0.0..=1e6).contains(&x) {
        Ok(x as u32)
    } else {
        fault(format!("{x} is not a whole number"), "correct the number")
    }
}
