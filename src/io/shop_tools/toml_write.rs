//! Tool libraries in our TOML.

use std::fmt::Write;

use super::{LibraryTool, ToolLibrary};
use crate::io::tool_file::{WrittenRates, write_tool};

/// Writes our TOML; remarks become comments above their tool.
pub fn write_toml(library: &ToolLibrary) -> String {
    let mut out = String::new();
    let comment = |out: &mut String, note: &str| {
        // `write!` to a `String` cannot fail.
        let _ = writeln!(out, "# {}", note.replace(char::is_control, " "));
    };
    library.notes.iter().for_each(|note| comment(&mut out, note));
    for LibraryTool { tool, notes } in library.tools.iter().map(|entry| &**entry) {
        if !out.is_empty() {
            out.push('\n');
        }
        notes.iter().for_each(|note| comment(&mut out, note));
        out.push_str("[[tool]]\n");
        let _ = write_tool(&mut out, tool, WrittenRates::Given);
    }
    out
}
