//! Shared by all readers: file bytes and text within limits, numbers, and quoting of file contents in
//! messages.

use std::borrow::Cow;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::InputError;
use crate::error::ErrorCode;
use crate::part::{CurveDescription, Meridional};

/// Maximum file size, bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// The same of a program, bytes: that of all channels of a large wheel, milled by its flanks, has 80 MiB.
pub const MAX_PROGRAM_BYTES: usize = 512 << 20;
/// Maximum number of points in a file.
pub const MAX_POINTS: usize = 1_000_000;
/// Maximum number of moves of a program.
pub const MAX_MOVES: usize = 4_000_000;
/// Maximum absolute coordinate, mm.
pub const MAX_COORDINATE: f64 = 1e6;
/// Maximum number of triangles of a mesh, all instances together.
pub const MAX_TRIANGLES: usize = 8_000_000;
/// Maximum number of blades.
pub const MAX_BLADES: usize = 1_000;
/// Points closer than this are merged, mm. Chained curves repeat the point at a joint to within 1e-9 m.
pub const JOINT: f64 = 5e-6;

/// What to do about a file that ends too early.
pub const TRUNCATED: &str = "the file seems cut off: export or copy it again";

/// The file being read, for the location of errors.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// File as the user named it.
    pub file: &'a str,
    /// Code of the errors that have none of their own: that of the format.
    pub code: ErrorCode,
}

impl<'a> Source<'a> {
    /// The file `file`; `code` is that of its format.
    pub fn new(file: &'a str, code: ErrorCode) -> Self {
        Self { file, code }
    }

    /// An error at `line` (0: none) of this file.
    pub fn fault(&self, line: usize, what: impl Into<String>, help: impl Into<String>) -> InputError {
        InputError::new(self.code, self.file, line, what, help)
    }

    /// The error of a file that ends too early.
    pub fn cut_off(&self, line: usize, what: impl Into<String>) -> InputError {
        self.fault(line, what, TRUNCATED).with_code(ErrorCode::FileCutOff)
    }

    /// The error of a JSON file that is not `what`, with its article: it ends too early, or is another file.
    pub fn not_json(&self, error: &serde_json::Error, what: &str, help: &str) -> InputError {
        let message = format!("this is not {what} ({error})");
        let is_empty = (error.line(), error.column()) == (1, 0);
        if error.is_eof() && !is_empty {
            self.cut_off(error.line(), message)
        } else {
            self.fault(error.line(), message, help)
        }
    }

    /// Parses a finite number with |x| ≤ 1e6.
    ///
    /// # Errors
    /// When `token` is not such a number.
    pub fn number(&self, line: usize, token: &str) -> Result<f64, InputError> {
        number(token)
            .map_err(|fault| self.fault(line, fault.message, fault.help).with_code(ErrorCode::InvalidNumber))
    }

    /// Parses a length: the number times `scale`, in mm.
    ///
    /// # Errors
    /// When `token` is not a number, or the length exceeds 1,000,000 mm.
    pub fn length(&self, line: usize, token: &str, scale: f64) -> Result<f64, InputError> {
        let mm = self.number(line, token)? * scale;
        if mm.abs() > MAX_COORDINATE {
            let what = format!("{} is more than 1,000,000 mm", quote_for_message(token));
            let error = self.fault(line, what, "check the number and the units of the file");
            return Err(error.with_code(ErrorCode::InvalidNumber));
        }
        Ok(mm)
    }

    /// Parses a number of blades.
    ///
    /// # Errors
    /// When `token` is not a whole number from 1 to [`MAX_BLADES`].
    pub fn blades(&self, line: usize, token: &str) -> Result<usize, InputError> {
        match number(token) {
            Ok(n) if n.fract() == 0.0 && (1.0..=MAX_BLADES as f64).contains(&n) => Ok(n as usize),
            _ => {
                let what = format!("{} is not a valid number of blades", quote_for_message(token));
                let help = format!("give a whole number from 1 to {MAX_BLADES}");
                Err(self.fault(line, what, help).with_code(ErrorCode::BladeCount))
            }
        }
    }

    /// A meridional curve through `points` (mm), with repeated points removed.
    ///
    /// # Errors
    /// When fewer than two distinct points remain.
    pub fn curve(
        &self,
        line: usize,
        what: &str,
        mut points: Vec<Meridional>,
    ) -> Result<CurveDescription, InputError> {
        points.dedup_by(|a, b| (a.r - b.r).hypot(a.z - b.z) < JOINT);
        if points.len() < 2 {
            let what = format!("the {what} has {} distinct point(s)", points.len());
            let error = self.fault(line, what, "give two or more, inlet to outlet");
            return Err(error.with_code(ErrorCode::FlowCurve));
        }
        Ok(CurveDescription::Points(points))
    }
}

/// Why a text is not a number that is read.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberFault {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: &'static str,
    /// The number, where it is one that is too large or too small.
    pub value: Option<f64>,
}

/// Parses a finite number with |x| ≤ 1e6.
///
/// # Errors
/// When `token` is not such a number: what is wrong with it.
pub fn number(token: &str) -> Result<f64, NumberFault> {
    let fault = |words: &str, help: &'static str, value: Option<f64>| {
        Err(NumberFault { message: format!("{} is {words}", quote_for_message(token)), help, value })
    };
    match token.parse::<f64>() {
        Err(_) => fault("not a number", FINITE, None),
        Ok(x) if !x.is_finite() => fault("not a finite number", FINITE, None),
        Ok(x) if x > MAX_COORDINATE => fault("too large", WITHIN, Some(x)),
        Ok(x) if x < -MAX_COORDINATE => fault("too small", WITHIN, Some(x)),
        Ok(x) => Ok(x),
    }
}

const FINITE: &str = "give a finite number";
const WITHIN: &str = "give a number from -1,000,000 to 1,000,000";

/// Quotes file contents for a message: one line, at most 40 characters, in backquotes.
pub fn quote_for_message(token: &str) -> String {
    let mut text = String::new();
    for c in token.chars().take(40) {
        match c {
            // Inches, as tools are named; the backquotes end the text.
            '"' | '\'' => text.push(c),
            _ => text.extend(c.escape_debug()),
        }
    }
    if token.chars().nth(40).is_some() {
        text.push('…');
    }
    format!("`{text}`")
}

/// Whether two paths name one file.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    one_name_of(a) == one_name_of(b)
}

/// The name of a file that is the same by whatever way it is opened.
pub(crate) fn one_name_of(path: &Path) -> PathBuf {
    let file = std::fs::canonicalize(path).or_else(|_| std::path::absolute(path));
    file.unwrap_or_else(|_| path.to_owned())
}

/// Name of a path in messages.
pub fn name_of(path: &Path) -> String {
    path.display().to_string()
}

/// File name without folder and extension: the name of a part whose file does not name it.
pub fn stem_of(file: &str) -> String {
    Path::new(file).file_stem().map_or_else(|| "part".to_owned(), |s| s.to_string_lossy().into_owned())
}

/// Reads a file of at most [`MAX_BYTES`] bytes.
///
/// # Errors
/// As [`read_bytes_up_to`].
pub fn read_bytes(path: &Path) -> Result<Vec<u8>, InputError> {
    read_bytes_up_to(path, MAX_BYTES)
}

/// Reads a file of at most `limit` bytes.
///
/// # Errors
/// When the path is not a regular file, the file cannot be read, or it is larger than `limit`.
pub fn read_bytes_up_to(path: &Path, limit: usize) -> Result<Vec<u8>, InputError> {
    let name = name_of(path);
    let source = Source::new(&name, ErrorCode::FileUnreadable);
    let unreadable = |error: std::io::Error| {
        let help = match error.kind() {
            std::io::ErrorKind::NotFound => "check the path",
            std::io::ErrorKind::PermissionDenied => "check its permissions",
            _ => "check the file and its disk",
        };
        source.fault(0, format!("cannot be read: {error}"), help)
    };
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(source.fault(0, "is a folder", "name a file in it"));
    }
    if !metadata.is_file() {
        return Err(source.fault(0, "is not a regular file", "name a file"));
    }
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(limit as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    check_size(source, &bytes, limit)?;
    Ok(bytes)
}

fn check_size(source: Source<'_>, bytes: &[u8], limit: usize) -> Result<(), InputError> {
    if bytes.len() > limit {
        let what = format!("is larger than {} MiB", limit >> 20);
        return Err(source.fault(0, what, "give a smaller file").with_code(ErrorCode::FileTooLarge));
    }
    Ok(())
}

/// Line (from 1) that contains a byte offset.
pub fn line_at(bytes: &[u8], offset: usize) -> usize {
    1 + bytes.iter().take(offset).filter(|b| **b == b'\n').count()
}

/// The bytes as UTF-8 text, without a byte order mark.
///
/// # Errors
/// When the bytes are empty, too many, contain a NUL, or are not UTF-8.
pub fn text<'a>(source: Source<'_>, bytes: &'a [u8]) -> Result<&'a str, InputError> {
    text_up_to(source, bytes, MAX_BYTES)
}

/// As [`text`], of at most `limit` bytes.
///
/// # Errors
/// As [`text`].
pub fn text_up_to<'a>(source: Source<'_>, bytes: &'a [u8], limit: usize) -> Result<&'a str, InputError> {
    let bytes = checked(source, bytes, limit)?;
    std::str::from_utf8(bytes).map_err(|error| {
        let line = line_at(bytes, error.valid_up_to());
        let help = "check that this is the right file, or save it as UTF-8";
        source.fault(line, "is not UTF-8 text", help).with_code(ErrorCode::NotText)
    })
}

/// As [`text`], but bytes that are not UTF-8 (in names, comments) become U+FFFD.
///
/// # Errors
/// When the bytes are empty, too many, or contain a NUL.
pub fn text_lossy<'a>(source: Source<'_>, bytes: &'a [u8]) -> Result<Cow<'a, str>, InputError> {
    Ok(String::from_utf8_lossy(checked(source, bytes, MAX_BYTES)?))
}

/// The same of a program.
///
/// # Errors
/// As [`text_lossy`].
pub fn program_text<'a>(source: Source<'_>, bytes: &'a [u8]) -> Result<Cow<'a, str>, InputError> {
    Ok(String::from_utf8_lossy(checked(source, bytes, MAX_PROGRAM_BYTES)?))
}

fn checked<'a>(source: Source<'_>, bytes: &'a [u8], limit: usize) -> Result<&'a [u8], InputError> {
    check_size(source, bytes, limit)?;
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Some(offset) = bytes.iter().position(|b| *b == 0) {
        let line = line_at(bytes, offset);
        let error = source.fault(line, "is binary, not text", "check that this is the right file");
        return Err(error.with_code(ErrorCode::NotText));
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        let error = source.fault(0, "is empty", "check that it was written completely");
        return Err(error.with_code(ErrorCode::FileEmpty));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Source<'static> = Source { file: "x.toml", code: ErrorCode::SetupFile };

    #[test]
    fn numbers_are_finite_and_bounded() {
        assert_eq!(number("-1.5e3"), Ok(-1500.0));
        for bad in ["nan", "inf", "1e300", "-1e7", "", "1,5", "0x10"] {
            assert!(number(bad).is_err(), "{bad} must be refused");
        }
        let fault = number("-1e7").expect_err("is refused");
        assert_eq!(fault.message, "`-1e7` is too small");
        assert_eq!((fault.help, fault.value), (WITHIN, Some(-1e7)), "it is a finite number");
        assert_eq!(number("inf").expect_err("is refused").help, FINITE);
    }

    #[test]
    fn messages_stay_one_short_line() {
        assert_eq!(quote_for_message("a\nb"), "`a\\nb`");
        assert!(quote_for_message(&"y".repeat(1000)).len() < 60);
    }

    #[test]
    fn text_refuses_what_is_no_text() {
        assert_eq!(text(HERE, b"").unwrap_err().to_string(), {
            "x.toml: is empty; check that it was written completely"
        });
        assert_eq!(text(HERE, b"a\nb\0").unwrap_err().line, 2);
        assert_eq!(text(HERE, b"a\n\nb\xff").unwrap_err().line, 3);
        assert_eq!(text(HERE, b"\xef\xbb\xbfa").unwrap(), "a");
        assert!(text(HERE, &vec![b'a'; MAX_BYTES + 1]).is_err());
    }
}
