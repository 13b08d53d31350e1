//! JSON of tool libraries: checked as a whole, and read one tool after the other, so that the memory for a
//! library of many thousand tools is that of its text and of the tools that are kept.

use std::fmt::Write;
use std::ops::Range;

use serde::de::IgnoredAny;
use serde_json::{Map, Value};

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

/// `text` with the values of `tree` in place of its own. What is the same stays as it is written, and keys
/// keep their order; new ones follow the last one. `text` must be valid JSON.
pub fn with_values(text: &str, tree: &Value) -> String {
    if serde_json::from_str::<Value>(text).is_ok_and(|known| known == *tree) {
        return text.to_owned();
    }
    let edited = match tree {
        Value::Object(values) => object_with(text, values),
        Value::Array(values) => list_with(text, values),
        _ => None,
    };
    edited.unwrap_or_else(|| tree.to_string())
}

/// [`with_values`] of an object; `None` where `text` is another value, has nothing to keep, or a key twice.
fn object_with(text: &str, values: &Map<String, Value>) -> Option<String> {
    let mut cursor = JsonCursor { bytes: text.as_bytes(), at: 0 };
    if !cursor.takes(b'{') {
        return None;
    }
    let mut members: Vec<(String, Range<usize>, Range<usize>)> = Vec::new();
    while !cursor.takes(b'}') {
        let name = cursor.value();
        cursor.takes(b':');
        let key = serde_json::from_str(text.get(name.clone())?).ok()?;
        if members.iter().any(|(known, ..)| *known == key) {
            return None;
        }
        members.push((key, name, cursor.value()));
        cursor.takes(b',');
    }
    let ((_, first, _), (_, name, value)) = (members.first()?, members.last()?);
    let mut out = text.get(..first.start)?.to_owned();
    let colon = text.get(name.end..value.start)?;
    let (mut comma, mut count) = (", ", 0);
    for (index, (key, name, value)) in members.iter().enumerate() {
        if let Some(before) = index.checked_sub(1) {
            comma = text.get(members[before].2.end..name.start)?;
        }
        let Some(now) = values.get(key) else { continue };
        if count > 0 {
            out.push_str(comma);
        }
        count += 1;
        out.push_str(text.get(name.start..value.start)?);
        out.push_str(&with_values(text.get(value.clone())?, now));
    }
    for (key, now) in values.iter().filter(|(key, _)| members.iter().all(|(known, ..)| known != *key)) {
        if count > 0 {
            out.push_str(comma);
        }
        count += 1;
        let _ = write!(out, "{}{colon}{now}", Value::from(key.as_str()));
    }
    out.push_str(text.get(value.end..)?);
    Some(out)
}

/// [`with_values`] of a list; `None` where `text` is another value, or a list of another length.
fn list_with(text: &str, values: &[Value]) -> Option<String> {
    let mut cursor = JsonCursor { bytes: text.as_bytes(), at: 0 };
    if !cursor.takes(b'[') {
        return None;
    }
    let (mut out, mut from) = (String::with_capacity(text.len()), 0);
    let mut values = values.iter();
    while !cursor.takes(b']') {
        let value = cursor.value();
        out.push_str(text.get(from..value.start)?);
        out.push_str(&with_values(text.get(value.clone())?, values.next()?));
        from = value.end;
        cursor.takes(b',');
    }
    out.push_str(text.get(from..)?);
    values.next().is_none().then_some(out)
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
    fn value(&mut self) -> Range<usize> {
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

    #[test]
    fn only_what_is_edited_is_written_anew() {
        let text = r#"{"b": 1.50, "a" :{"y":[1, 2.0,{"k": null}], "x":"\u00e9"},
 "c" : [ ] }"#;
        let edited = |edit: fn(&mut Value)| {
            let mut tree = tool_tree(text).expect("valid");
            edit(&mut tree);
            let written = with_values(text, &tree);
            assert_eq!(tool_tree(&written).expect("valid"), tree, "{written}");
            written
        };
        assert_eq!(edited(|_| {}), text);
        assert_eq!(edited(|tree| tree["a"]["y"][2]["k"] = 7.into()), text.replace("null", "7"));
        let added = edited(|tree| tree["n\""] = "new".into());
        assert_eq!(added, text.replace("[ ] }", "[ ],\n \"n\\\"\" : \"new\" }"));
        let removed = edited(|tree| drop(tree.as_object_mut().expect("an object").remove("b")));
        assert_eq!(removed, text.replace("\"b\": 1.50, ", ""));
        assert_eq!(edited(|tree| tree["c"] = 3.into()), text.replace("[ ]", "3"));
        // Nothing to keep, or of two values of a key one that is meant.
        assert_eq!(with_values("{}", &serde_json::json!({"a": 1})), r#"{"a":1}"#);
        assert_eq!(with_values(r#"{"a": 1, "a": 2}"#, &serde_json::json!({"a": 1})), r#"{"a":1}"#);
        assert_eq!(with_values("[1]", &serde_json::json!([1, 2])), "[1,2]");
    }
}
