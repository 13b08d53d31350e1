//! Syntax of the exchange structure.

use super::{Exchange, Instance, Record, Value};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{Source, TRUNCATED, line_at, quote_for_message};

/// Application protocols that the message about another schema names.
const READABLE: &str = "export it as AP203, AP214 or AP242";
/// Deepest nesting of lists and typed values; schemas use up to 5.
const MAX_DEPTH: usize = 32;
/// Largest number of values in a file, which bounds its memory to about 1 GB.
const MAX_VALUES: usize = 20_000_000;
/// Beginnings of the schema names that are read, in capitals.
const SCHEMAS: [&str; 6] =
    ["CONFIG_CONTROL", "AUTOMOTIVE_DESIGN", "AP203", "AP214", "AP242", "CONFIGURATION_CONTROL"];

/// A fault of the syntax.
struct SyntaxFault {
    /// Byte at which it was found.
    at: usize,
    /// The instance it is in.
    id: Option<u32>,
    what: String,
    /// Whether it is about the schema of the file.
    is_schema: bool,
}

impl SyntaxFault {
    fn new(at: usize, id: Option<u32>, what: impl Into<String>) -> Self {
        Self { at, id, what: what.into(), is_schema: false }
    }
}

/// A position in the file, and how many values were read.
struct ExchangeParser<'a> {
    bytes: &'a [u8],
    at: usize,
    values: usize,
}

impl<'a> ExchangeParser<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, values: 0 }
    }

    fn fault<T>(&self, what: impl Into<String>) -> Result<T, SyntaxFault> {
        Err(SyntaxFault::new(self.at, None, what))
    }

    /// Skips blanks and comments, and returns the next byte; 0 at the end.
    fn peek(&mut self) -> u8 {
        loop {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
            self.at += blanks;
            let rest = rest.get(blanks..).unwrap_or_default();
            if !rest.starts_with(b"/*") {
                return rest.first().copied().unwrap_or(0);
            }
            match rest.windows(2).skip(2).position(|w| w == b"*/") {
                Some(end) => self.at += end + 4,
                None => self.at = self.bytes.len(),
            }
        }
    }

    fn eat(&mut self, byte: u8) -> bool {
        let is = self.peek() == byte;
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, byte: u8) -> Result<(), SyntaxFault> {
        if self.eat(byte) {
            return Ok(());
        }
        let found = self.found();
        self.fault(format!("{found} instead of `{}`", char::from(byte)))
    }

    /// The next byte for a message.
    fn found(&mut self) -> String {
        match self.peek() {
            0 if self.at >= self.bytes.len() => "the file ends".to_owned(),
            byte => quote_for_message(&char::from(byte).to_string()),
        }
    }

    /// Whether `word` comes next; it is passed over then.
    fn takes(&mut self, word: &[u8]) -> bool {
        self.peek();
        let is = self.bytes.get(self.at..).is_some_and(|rest| rest.starts_with(word));
        self.at += if is { word.len() } else { 0 };
        is
    }

    fn while_bytes(&mut self, holds: impl Fn(u8) -> bool) -> &'a str {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let word = &rest[..rest.iter().take_while(|b| holds(**b)).count()];
        self.at += word.len();
        // Only ASCII satisfies the callers' conditions.
        std::str::from_utf8(word).unwrap_or_default()
    }

    fn keyword(&mut self) -> Result<&'a str, SyntaxFault> {
        self.peek();
        let word = self.while_bytes(|b| b.is_ascii_alphanumeric() || b"_-!".contains(&b));
        if word.is_empty() {
            let found = self.found();
            return self.fault(format!("{found} instead of a keyword"));
        }
        Ok(word)
    }

    fn number_of_instance(&mut self) -> Result<u32, SyntaxFault> {
        let digits = self.while_bytes(|b| b.is_ascii_digit());
        match digits.parse() {
            Ok(id) => Ok(id),
            Err(_) if digits.is_empty() => {
                let found = self.found();
                self.fault(format!("{found} instead of the number of an instance"))
            }
            Err(_) => self.fault(format!("{} is not the number of an instance", quote_for_message(digits))),
        }
    }

    /// The whole file, behind its first word.
    fn file(&mut self) -> Result<Exchange<'a>, SyntaxFault> {
        self.header()?;
        let mut instances: Vec<Instance<'a>> = Vec::new();
        // AP242 files may have several data sections.
        loop {
            match self.keyword()? {
                "DATA" => {
                    if self.peek() == b'(' {
                        self.list(0)?;
                    }
                    self.expect(b';')?;
                    while self.peek() == b'#' {
                        let at = self.at;
                        self.at += 1;
                        let id = self.number_of_instance()?;
                        let instance =
                            self.instance(id).map_err(|fault| SyntaxFault { id: Some(id), ..fault })?;
                        if instances.last().is_some_and(|last| last.id == id) {
                            return Err(SyntaxFault::new(at, Some(id), "is defined twice"));
                        }
                        instances.extend(instance);
                    }
                    if !self.takes(b"ENDSEC;") {
                        let found = self.found();
                        return self.fault(format!("{found} instead of an instance or ENDSEC"));
                    }
                }
                "ANCHOR" | "REFERENCE" | "SIGNATURE" => match self.find(b"ENDSEC;") {
                    Some(end) => self.at = end,
                    None => {
                        self.at = self.bytes.len();
                        return self.fault("a section lacks ENDSEC");
                    }
                },
                "END-ISO-10303-21" => break,
                other => {
                    return self.fault(format!("{} is not a section", quote_for_message(other)));
                }
            }
        }
        if !instances.is_sorted_by_key(|i| i.id) {
            instances.sort_by_key(|i| i.id);
        }
        if let Some(pair) = instances.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(SyntaxFault::new(0, Some(pair[0].id), "is defined twice"));
        }
        Ok(Exchange { instances })
    }

    /// The byte behind the next occurrence of `word`.
    fn find(&self, word: &[u8]) -> Option<usize> {
        let rest = self.bytes.get(self.at..)?;
        rest.windows(word.len()).position(|w| w == word).map(|at| self.at + at + word.len())
    }

    fn header(&mut self) -> Result<(), SyntaxFault> {
        if !self.takes(b"HEADER;") {
            return self.fault("lacks a header");
        }
        let mut known = false;
        while !self.takes(b"ENDSEC;") {
            let at = self.at;
            let record = self.record()?;
            self.expect(b';')?;
            if record.keyword == "FILE_SCHEMA" {
                let names = record.values.first().and_then(Value::list).unwrap_or_default();
                let name = |value: &Value<'_>| match value {
                    Value::Text(text) => String::from_utf8_lossy(text).to_uppercase(),
                    _ => String::new(),
                };
                let names: Vec<String> = names.iter().map(name).collect();
                known = names.iter().any(|name| SCHEMAS.iter().any(|s| name.trim_start().starts_with(s)));
                if !known {
                    let what = format!("schema {} is not known", quote_for_message(&names.join(", ")));
                    return Err(SyntaxFault { is_schema: true, ..SyntaxFault::new(at, None, what) });
                }
            }
        }
        if known {
            return Ok(());
        }
        let what = "schema is not named in the header (FILE_SCHEMA)";
        Err(SyntaxFault { is_schema: true, ..SyntaxFault::new(self.at, None, what) })
    }

    /// The records of an instance behind its number; `None` for a record that is empty.
    fn instance(&mut self, id: u32) -> Result<Option<Instance<'a>>, SyntaxFault> {
        self.expect(b'=')?;
        let mut records = Vec::with_capacity(1);
        if self.eat(b'(') {
            while !self.eat(b')') {
                records.push(self.record()?);
            }
        } else {
            records.push(self.record()?);
        }
        self.expect(b';')?;
        Ok((!records.is_empty()).then_some(Instance { id, records }))
    }

    fn record(&mut self) -> Result<Record<'a>, SyntaxFault> {
        let keyword = self.keyword()?;
        Ok(Record { keyword, values: self.list(0)? })
    }

    fn list(&mut self, depth: usize) -> Result<Vec<Value<'a>>, SyntaxFault> {
        self.expect(b'(')?;
        if depth > MAX_DEPTH {
            return self.fault(format!("is nested more than {MAX_DEPTH} deep"));
        }
        let mut values = Vec::new();
        if self.eat(b')') {
            return Ok(values);
        }
        loop {
            values.push(self.value(depth)?);
            self.values += 1;
            if self.values > MAX_VALUES {
                return self.fault(format!("the file has more than {MAX_VALUES} values"));
            }
            if !self.eat(b',') {
                self.expect(b')')?;
                values.shrink_to_fit();
                return Ok(values);
            }
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value<'a>, SyntaxFault> {
        Ok(match self.peek() {
            b'#' => {
                self.at += 1;
                Value::Ref(self.number_of_instance()?)
            }
            b'(' => Value::List(self.list(depth + 1)?),
            b'$' | b'*' => {
                self.at += 1;
                Value::Null
            }
            b'\'' => Value::Text(self.text()?),
            b'"' => {
                self.at += 1;
                self.while_bytes(|b| b.is_ascii_hexdigit());
                self.expect(b'"')?;
                Value::Null
            }
            b'.' => {
                self.at += 1;
                let word = self.while_bytes(|b| b.is_ascii_alphanumeric() || b == b'_');
                self.expect(b'.')?;
                Value::Enum(word)
            }
            byte if byte.is_ascii_alphabetic() || byte == b'!' => {
                let keyword = self.keyword()?;
                Value::Typed(Box::new((keyword, self.list(depth + 1)?)))
            }
            _ => {
                let digits = self.while_bytes(|b| b.is_ascii_digit() || b"+-.eE".contains(&b));
                match digits.parse::<f64>() {
                    Ok(x) if x.is_finite() => Value::Number(x),
                    _ if digits.is_empty() => {
                        let found = self.found();
                        return self.fault(format!("{found} instead of a value"));
                    }
                    _ => return self.fault(format!("{} is not a finite number", quote_for_message(digits))),
                }
            }
        })
    }

    /// A string, with its apostrophes still doubled.
    fn text(&mut self) -> Result<&'a [u8], SyntaxFault> {
        self.at += 1;
        let start = self.at;
        loop {
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let Some(end) = rest.iter().position(|b| *b == b'\'') else {
                self.at = self.bytes.len();
                return self.fault("a string does not end");
            };
            self.at += end + 1;
            if self.bytes.get(self.at) == Some(&b'\'') {
                self.at += 1;
            } else {
                return Ok(self.bytes.get(start..self.at - 1).unwrap_or_default());
            }
        }
    }
}

/// Parses a file; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not an exchange structure of a known schema, or two instances have the same number.
pub fn parse<'a>(name: &str, bytes: &'a [u8]) -> Result<Exchange<'a>, InputError> {
    let source = Source::new(name, ErrorCode::StepFile);
    // Editors put a byte order mark in front of text.
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut parser = ExchangeParser::new(bytes);
    if !parser.takes(b"ISO-10303-21;") {
        let what = "is not a STEP file: it does not begin with ISO-10303-21";
        return Err(source
            .fault(0, what, "check that this is the right file")
            .with_code(ErrorCode::FileFormat));
    }
    parser.file().map_err(|fault| {
        let SyntaxFault { at, id, what, is_schema } = fault;
        let place = id.map_or(String::new(), |id| format!("#{id}: "));
        let (code, cure) = match (is_schema, at >= bytes.len()) {
            (true, _) => (ErrorCode::StepFile, READABLE),
            (false, true) => (ErrorCode::FileCutOff, TRUNCATED),
            (false, false) => (ErrorCode::StepFile, "export the file again"),
        };
        let line = line_at(bytes, at.min(bytes.len()));
        source.fault(line, format!("{place}{what}"), cure).with_code(code)
    })
}
