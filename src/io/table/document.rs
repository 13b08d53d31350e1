//! The text of a TOML document: bounds on its size, parsing, lines of byte offsets.

use toml::Spanned;
use toml::de::DeTable;

use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{self, Source};

/// Maximum number of list items in a document: 1,000,000 points of three numbers have 4,000,000.
const MAX_ITEMS: usize = 5_000_000;
/// Maximum number of keys, headers and tables: each needs far more memory than a number.
const MAX_KEYS: usize = 200_000;
/// The same of setups and tool libraries: 50,000 tools with all their keys have 900,000.
const MAX_TOOL_KEYS: usize = 1_000_000;

/// Maximum number of separators and runs of blanks in a document: this bounds the parser's own memory.
/// 1,000,000 points on a line each have 9,000,000.
const MAX_TOKENS: usize = 12_000_000;

/// Checks by counting separators that the tree of a document will be small enough to build.
fn check_weight(source: Source<'_>, text: &str) -> Result<(), InputError> {
    let (mut items, mut keys, mut tokens) = (0_usize, 0_usize, 0_usize);
    for line in text.lines() {
        tokens += 1;
        let line = line.trim_start();
        // A comment, or text within a string of several lines: no keys.
        let has_keys = !line.starts_with('#');
        let keys_before = keys;
        // A header has no comma; a row of numbers has one.
        keys += usize::from(line.starts_with('[') && !line.contains(','));
        let mut before = b' ';
        let mut dots_in_word = 0;
        for byte in line.bytes() {
            match byte {
                b',' | b'[' => items += 1,
                b'=' | b'{' => keys += 1,
                // A single dot after a digit is a decimal point; other dots separate the parts of a key.
                b'.' => {
                    dots_in_word += 1;
                    keys += usize::from(dots_in_word > 1 || !before.is_ascii_digit());
                }
                byte if byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b' ') => {}
                _ => dots_in_word = 0,
            }
            if matches!(byte, b',' | b'[') {
                dots_in_word = 0;
            }
            let in_word = byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'_' | b'+' | 0x80..);
            tokens += usize::from(!in_word && (byte != b' ' || before != b' '));
            before = byte;
        }
        if !has_keys {
            keys = keys_before;
        }
    }
    if items > MAX_ITEMS || tokens > MAX_TOKENS {
        return Err(source
            .fault(0, "holds more than 1,000,000 points", "give fewer points")
            .with_code(ErrorCode::FileTooLarge));
    }
    let has_tools = matches!(source.code, ErrorCode::SetupFile | ErrorCode::ToolFile);
    let (most, shown) = match has_tools {
        true => (MAX_TOOL_KEYS, "holds more than 1,000,000 keys"),
        false => (MAX_KEYS, "holds more than 200,000 keys"),
    };
    if keys > most {
        return Err(source
            .fault(0, shown, "check that this is the right file")
            .with_code(ErrorCode::FileTooLarge));
    }
    Ok(())
}

/// Text of a document and the offsets of its line ends.
pub struct TomlDocument<'a> {
    source: Source<'a>,
    text: &'a str,
    newlines: Vec<usize>,
}

impl<'a> TomlDocument<'a> {
    /// Checks the bytes and finds the line ends; `code` is that of errors that have none of their own.
    ///
    /// # Errors
    /// When the bytes are not text, or the document is too large.
    pub fn new(file: &'a str, bytes: &'a [u8], code: ErrorCode) -> Result<Self, InputError> {
        let source = Source::new(file, code);
        let text = source::text(source, bytes)?;
        check_weight(source, text)?;
        let newlines = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at).collect();
        Ok(Self { source, text, newlines })
    }

    /// Parses the document.
    ///
    /// # Errors
    /// When the text is not valid TOML.
    pub fn parse(&self) -> Result<Spanned<DeTable<'a>>, InputError> {
        DeTable::parse(self.text).map_err(|error| {
            // No TOML begins with it.
            if self.text.trim_start().starts_with('{') {
                let help = "give a .toml file; `vanecut convert` makes one of a tool library";
                return self.fault(0, "is JSON, not TOML", help).with_code(ErrorCode::InvalidToml);
            }
            let at = error.span().map_or(self.text.len(), |span| span.start);
            if let Some(word) = self.bare_word(at) {
                let help = "give a number, true or false, or a text in quotes";
                return self
                    .fault(at, format!("{word} is not a value"), help)
                    .with_code(ErrorCode::InvalidToml);
            }
            let what = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
            self.fault(at, format!("invalid TOML: {what}"), "correct the line")
                .with_code(ErrorCode::InvalidToml)
        })
    }

    /// The word without quotes that stands for a value, on the line of the byte offset `at`. The parser takes
    /// such a word for the beginning of `nan`, `inf`, `true` or `false`.
    fn bare_word(&self, at: usize) -> Option<&'a str> {
        let before = self.text.get(..at)?;
        let start = before.rfind('\n').map_or(0, |end| end + 1);
        let line = self.text.get(start..)?.lines().next()?;
        let value = line.split_once('=')?.1.split('#').next()?.trim();
        let is_word = value.starts_with(|c: char| c.is_alphabetic())
            && value.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | ' '));
        (is_word && value != "true" && value != "false").then_some(value)
    }

    /// Name of the file, or of what the document is from.
    pub(super) fn file(&self) -> &'a str {
        self.source.file
    }

    /// Line of a byte offset.
    pub fn line(&self, at: usize) -> usize {
        1 + self.newlines.partition_point(|n| *n < at)
    }

    /// An error at a byte offset.
    pub fn fault(&self, at: usize, what: impl Into<String>, help: impl Into<String>) -> InputError {
        self.source.fault(self.line(at), what, help)
    }

    /// The error of a value at a byte offset that is of another type than its key takes.
    pub(super) fn value_type_fault(
        &self,
        at: usize,
        what: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        self.fault(at, what, help).with_code(ErrorCode::ValueType)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_too_large_to_build_are_refused() {
        for (piece, times) in [("[1],", 3_000_000), ("a.b.c=1\n", 70_000), ("# \n", 6_000_000)] {
            let text = piece.repeat(times);
            let error = TomlDocument::new("f", text.as_bytes(), ErrorCode::PartFile).err().expect(piece);
            assert_eq!(error.code, ErrorCode::FileTooLarge, "{error}");
        }
        for (times, is_refused) in [(70_000, false), (340_000, true)] {
            let text = "a.b.c=1\n".repeat(times);
            assert_eq!(TomlDocument::new("f", text.as_bytes(), ErrorCode::ToolFile).is_err(), is_refused);
        }
    }

    #[test]
    fn json_is_named_instead_of_its_first_sign() {
        let document =
            TomlDocument::new("shop.json", b"\n{\"data\": []}", ErrorCode::SetupFile).expect("text");
        let error = document.parse().expect_err("it is no TOML");
        assert_eq!((error.code, error.message.as_str()), (ErrorCode::InvalidToml, "is JSON, not TOML"));
        assert!(error.help.contains("vanecut convert"), "{error}");
    }
}
