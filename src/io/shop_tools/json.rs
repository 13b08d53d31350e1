//! JSON of tool libraries: checked as a whole, and read one tool after the other, so that the memory for a
//! library of many thousand tools is that of its text and of the tools that are kept.

use serde::de::IgnoredAny;
use serde_json::Value;

use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{Source, text_up_to};

/// Largest size of a library, bytes: makers publish some of 30 MB.
pub const MAX_LIBRARY_BYTES: usize = 256 << 20;
/// Largest number of separators in the JSON of one tool: this bounds the memory of its tree.
const MAX_TOOL_ITEMS: usize = 100_000;

/// The text of a file that is valid JSON.
///
/// # Errors
/// When it is not.
pub fn json_text<'t>(name: &str, bytes: &'t [u8]) -> Result<&'t str, InputError> {
    let source = Source::new(name, ErrorCode::ToolFile);
    let text = text_up_to(source, bytes, MAX_LIBRARY_BYTES)?;
    match serde_json::from_str::<IgnoredAny>(text) {
        Ok(_) => Ok(text),
        Err(error) => {
            Err(source.fault(error.line(), format!("not valid JSON: {error}"), "export the library again"))
        }
    }
}

/// The tree of one tool.
///
/// # Errors
/// What is wrong with it.
pub fn tool_tree(text: &str) -> Result<Value, String> {
    let items = text.bytes().filter(|b| matches!(b, b',' | b'[' | b'{' | b':')).count();
    if items > MAX_TOOL_ITEMS {
        return Err(format!("it holds more than {MAX_TOOL_ITEMS} values"));
    }
    serde_json::from_str(text).map_err(|error| format!("it is not valid JSON: {error}"))
}

/// The texts of the elements of the list `key` of the object that `text` is, at most `most` of them; `None`
/// where `text` is not an object, or has no such list. `text` must be valid JSON.
pub fn elements<'t>(text: &'t str, key: &str, most: usize) -> Option<Vec<&'t str>> {
    let mut cursor = JsonCursor { bytes: text.as_bytes(), at: 0 };
    if !cursor.takes(b'{') {
        return None;
    }
    while !cursor.takes(b'}') {
        let name = cursor.value();
        cursor.takes(b':');
        if text.get(name)?.trim_matches('"') != key {
            cursor.value();
            cursor.takes(b',');
            continue;
        }
        if !cursor.takes(b'[') {
            return None;
        }
        let mut found = Vec::new();
        while found.len() < most && !cursor.takes(b']') {
            found.push(text.get(cursor.value())?);
            cursor.takes(b',');
        }
        return Some(found);
    }
    None
}

/// A place in valid JSON.
struct JsonCursor<'t> {
    bytes: &'t [u8],
    at: usize,
}

impl JsonCursor<'_> {
    fn skip_blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// Passes `sign`, and blanks before it, if it comes next; the end of the text passes as any sign.
    fn takes(&mut self, sign: u8) -> bool {
        self.skip_blanks();
        let is_next = self.bytes.get(self.at).is_none_or(|next| *next == sign);
        self.at += usize::from(is_next);
        is_next
    }

    /// Passes a value; returns its range.
    fn value(&mut self) -> std::ops::Range<usize> {
        self.skip_blanks();
        let from = self.at.min(self.bytes.len());
        let mut depth = 0usize;
        while let Some(&byte) = self.bytes.get(self.at) {
            match byte {
                b'"' => self.skip_string(),
                b'{' | b'[' => depth += 1,
                b'}' | b']' if depth == 0 => break,
                b'}' | b']' => depth -= 1,
                b',' | b':' if depth == 0 => break,
                _ if depth == 0 && byte.is_ascii_whitespace() => break,
                _ => {}
            }
            self.at += 1;
            if depth == 0 && matches!(byte, b'"' | b'}' | b']') {
                break;
            }
        }
        from..self.at.min(self.bytes.len())
    }

    /// From the quote that begins a string to the one that ends it.
    fn skip_string(&mut self) {
        self.at += 1;
        while let Some(&byte) = self.bytes.get(self.at).filter(|byte| **byte != b'"') {
            self.at += if byte == b'\\' { 2 } else { 1 };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_those_that_a_whole_parse_finds() {
        let text = r#" {"version": 36, "x": {"data": [1, {"y": "]}"}]}, "e": "a\"b\\", "n": null,
            "data" : [ {"a": [1, 2, {"b": "}, \" ["}]} , 7, "se]ven\\", [], {}, true,-1.5e3 ] , "z": [[]]}"#;
        let tree: Value = serde_json::from_str(text).expect("valid");
        let found = elements(text, "data", 100).expect("a list");
        let parsed: Vec<Value> = found.iter().map(|text| tool_tree(text).expect("valid")).collect();
        assert_eq!(Value::Array(parsed), tree["data"]);
        assert_eq!(elements(text, "data", 2).map(|found| found.len()), Some(2));
        for text in ["[]", "{}", "3", "{\"data\": 3}", "{\"data\": {\"data\": []}}", "\"data\""] {
            assert_eq!(elements(text, "data", 9), None, "{text}");
        }
        assert_eq!(elements("{\"data\": []}", "data", 9), Some(Vec::new()));
    }
}
