//! Reads NC programs of the dialects that posts write, by the grammar of the controls.
//!
//! One file per grammar turns a line into [`Word`](words::NcWord)s; `machine_state` executes them block by
//! block and runs what they say through the machine's chain of axes.

mod iso;
mod klartext;
mod machine_state;
mod reading;
mod sinumerik;
mod words;

use super::post::Dialect;
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{self, Source};
use crate::toolpath::UNFINISHED;
use machine_state::NcState;
pub use reading::{AxisOverrun, NcReading, ReadContext};
use words::{NcFault, NcWord};

/// Largest number of lines.
const MAX_LINES: usize = 2_000_000;
/// Number of lines of the head, which has the name of the program.
const HEAD_LINES: usize = 10;

/// Whether the bytes look like APT rather than NC code.
pub fn is_apt(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes.get(..bytes.len().min(4000)).unwrap_or_default()).to_uppercase();
    ["PARTNO", "GOTO/", "LOADTL", "MULTAX"].iter().any(|word| text.contains(word))
}

/// Reads a program; `name` is the file name used in messages.
///
/// # Errors
/// When a line is not of the dialect, or what it says is not allowed there: with its line.
pub fn read_nc(
    name: &str,
    bytes: &[u8],
    dialect: Dialect,
    context: &ReadContext<'_>,
) -> Result<NcReading, InputError> {
    let source = Source::new(name, ErrorCode::NcBlock);
    let whole = source::program_text(source, bytes)?;
    let mut state = NcState::new(source, dialect, context);
    let mut words = Vec::with_capacity(16);
    let (mut lines, mut unfinished) = (0, None);
    for (line, text) in (1..).zip(whole.lines()) {
        lines = line;
        if line > MAX_LINES {
            return Err(source
                .fault(line, "the program is longer than 2,000,000 lines", "split it")
                .with_code(ErrorCode::FileTooLarge));
        }
        if line <= HEAD_LINES && unfinished.is_none() && text.contains(UNFINISHED) {
            unfinished = Some(line);
        }
        words.clear();
        read_words(dialect, text, &mut words).map_err(|fault| {
            let help = match help_of_another(dialect, &whole, line) {
                Some(other) => format!("{}; {other}", fault.help),
                None => fault.help.to_owned(),
            };
            source.fault(line, fault.what, help)
        })?;
        state.block(line, &words)?;
    }
    let mut reading = state.finish(lines)?;
    if let Some(line) = unfinished {
        reading.program.name_part(line, UNFINISHED);
    }
    Ok(reading)
}

/// Reads one line by the grammar of a dialect.
fn read_words(dialect: Dialect, text: &str, words: &mut Vec<NcWord>) -> Result<(), NcFault> {
    match dialect {
        Dialect::Heidenhain => klartext::words(text, words),
        Dialect::Siemens => sinumerik::words(text, words),
        Dialect::Fanuc | Dialect::Haas | Dialect::LinuxCnc => iso::words(dialect, text, words),
    }
}

/// What to do where a line is not of `dialect`, but the program up to well behind that line is of others;
/// `None` where it is of no other either.
fn help_of_another(dialect: Dialect, text: &str, line: usize) -> Option<String> {
    /// Number of lines behind the faulty one that have to be of the other dialect, too.
    const BEHIND: usize = 2000;
    let reads = |other: &Dialect| {
        let mut words = Vec::with_capacity(16);
        text.lines().take(line + BEHIND).all(|text| {
            words.clear();
            read_words(*other, text, &mut words).is_ok()
        })
    };
    let others = Dialect::ALL.into_iter().filter(|other| *other != dialect);
    let names: Vec<&str> = others.filter(reads).map(Dialect::name).collect();
    (!names.is_empty()).then(|| {
        let (own, names) = (dialect.name(), names.join(" or "));
        format!("this seems to be a program for {names}, not for {own}: choose its control to read it")
    })
}
