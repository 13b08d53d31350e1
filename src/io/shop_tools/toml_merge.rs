//! Writing tools into a library of our own that exists: its other tools stay, with their comments.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::fusion_merge::MergedLibrary;
use super::library::{free_number, is_moved, move_tool};
use super::toml_write::write_toml;
use super::{LibraryTool, ToolLibrary};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::Source;
use crate::io::tool_file::read_tools_bytes;
use crate::setup::Tool;

/// First line of a tool.
const HEADER: &str = "[[tool]]";
/// Difference up to which two diameters count as equal, mm.
const SAME_DIAMETER: f64 = 1e-6;

/// Writes the tools of `library` into the TOML library `existing`, whose name in messages is `name`.
///
/// A tool replaces the one with its number if that has its name or its diameter. A tool whose number another
/// one has is added under a free number, which `notes` name. No tool is removed.
///
/// # Errors
/// When `existing` is not a tool library, or not written in tables of its own for each tool.
pub fn merge_toml(name: &str, existing: &[u8], library: &ToolLibrary) -> Result<MergedLibrary, InputError> {
    let fault = |what: &str| {
        Source::new(name, ErrorCode::FileNotWritten).fault(0, what, "name another file to write")
    };
    if existing.trim_ascii().is_empty() {
        return Ok(MergedLibrary::of_new_file(write_toml(library), library));
    }
    let text = String::from_utf8_lossy(existing);
    let mut blocks = blocks_of(&text);
    if blocks.len() < 2 || !blocks[0].tool.is_empty() {
        return Err(fault("already exists and is not a tool library"));
    }
    let known = read_tools_bytes(name, existing)?;
    if blocks.iter().filter(|block| block.starts_with_header()).count() != known.len() {
        return Err(fault("exists, and its tools are not in tables of their own"));
    }
    let mut numbers: BTreeSet<u32> = known.iter().map(|tool| tool.number).collect();
    numbers.extend(library.tools.iter().map(|entry| entry.tool.number));
    let mut merged = MergedLibrary::default();
    let mut added = ToolLibrary::default();
    let mut is_taken = vec![false; known.len()];
    let place_of = |tool: &Tool| known.iter().position(|there| there.number == tool.number);
    let mut own_place = |entry: &Arc<LibraryTool>| {
        let found = place_of(&entry.tool).filter(|&index| is_same(&known[index], &entry.tool));
        found.inspect(|&index| is_taken[index] = true)
    };
    // All of them first: none is that of a tool that was moved.
    let own: Vec<Option<usize>> = library.tools.iter().map(&mut own_place).collect();
    for (entry, mut found) in library.tools.iter().zip(own) {
        let mut entry = Arc::clone(entry);
        if found.is_none() && place_of(&entry.tool).is_some() {
            let mut others = known.iter().zip(&is_taken);
            found = others.position(|(tool, is_taken)| !is_taken && is_moved(tool, &entry.tool));
            let number = found.map_or_else(|| free_number(&numbers), |index| known[index].number);
            numbers.insert(number);
            merged.notes.push(move_tool(Arc::make_mut(&mut entry), number));
        }
        match found {
            None => added.tools.push(Arc::clone(&entry)),
            Some(index) => {
                is_taken[index] = true;
                if known[index] != entry.tool {
                    let one = ToolLibrary { tools: vec![Arc::clone(&entry)], ..ToolLibrary::default() };
                    let tool = blocks.iter_mut().filter(|block| block.starts_with_header()).nth(index);
                    if let Some(block) = tool {
                        block.tool = write_toml(&one);
                    }
                    merged.changed += 1;
                }
            }
        }
        merged.library.tools.push(entry);
    }
    merged.added = added.tools.len();
    merged.kept = known.len() - merged.changed;
    merged.text = blocks.into_iter().flat_map(|block| [block.tool, block.between]).collect();
    if merged.added > 0 {
        let end = merged.text.trim_end().len();
        merged.text.truncate(end);
        merged.text += "\n\n";
        merged.text += &write_toml(&added);
    }
    Ok(merged)
}

/// Whether a tool may replace another one of its number.
fn is_same(there: &Tool, tool: &Tool) -> bool {
    there.assembly.name.is_some() && there.assembly.name == tool.assembly.name
        || (there.diameter - tool.diameter).abs() <= SAME_DIAMETER
}

/// The lines of a tool, and the empty lines and comments between it and the next one.
#[derive(Default)]
struct ToolBlock {
    tool: String,
    between: String,
}

impl ToolBlock {
    fn starts_with_header(&self) -> bool {
        self.tool.lines().any(|line| line.trim_start().starts_with(HEADER))
    }
}

/// The text in blocks, in order; the first one is what stands above the first tool.
fn blocks_of(text: &str) -> Vec<ToolBlock> {
    let mut blocks = vec![ToolBlock::default()];
    for line in text.split_inclusive('\n') {
        let content = line.trim();
        if content.starts_with(HEADER) {
            blocks.push(ToolBlock::default());
        }
        // The list is never empty.
        let Some(block) = blocks.last_mut() else { break };
        if content.is_empty() || content.starts_with('#') {
            block.between.push_str(line);
        } else {
            // Comments within a tool are part of it.
            let between = std::mem::take(&mut block.between);
            block.tool.push_str(&between);
            block.tool.push_str(line);
        }
    }
    blocks
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHOP: &str = "# Magazine 1\n\n[[tool]] # the long one\nnumber = 1\ndiameter = 6\noverhang = 40\n\n\
                        # for the outlet\n[[tool]]\nnumber = 2\n# reground\ndiameter = 9.8\n\n";

    fn library(text: &str) -> ToolLibrary {
        let tools = read_tools_bytes("new.toml", text.as_bytes()).expect("a library").into_iter();
        let entry = |tool| LibraryTool { tool, notes: Vec::new() }.into();
        ToolLibrary { tools: tools.map(entry).collect(), ..ToolLibrary::default() }
    }

    #[test]
    fn tools_that_are_there_stay() {
        let new = library(
            "[[tool]]\nnumber = 1\ndiameter = 6\noverhang = 44\n[[tool]]\nnumber = 2\nname = \"new\"\ndiameter = 12\n\
             [[tool]]\nnumber = 3\ndiameter = 4\n",
        );
        let merged = merge_toml("shop.toml", SHOP.as_bytes(), &new).expect("merges");
        assert_eq!((merged.changed, merged.added, merged.kept), (1, 2, 1));
        assert_eq!(merged.notes, ["tool 2: another tool there has its number: it is tool 4"]);
        let tools = library(&merged.text).tools;
        let sizes: Vec<_> = tools.iter().map(|t| (t.tool.number, t.tool.diameter)).collect();
        assert_eq!(sizes, [(1, 6.0), (2, 9.8), (4, 12.0), (3, 4.0)]);
        assert_eq!(tools[0].tool.overhang, 44.0);
        for kept in ["# Magazine 1", "# for the outlet", "number = 2\n# reground\ndiameter = 9.8\n"] {
            assert!(merged.text.contains(kept), "{kept} in {}", merged.text);
        }
        // What is written once more changes nothing, by its number there or its own.
        let twice = merge_toml("shop.toml", merged.text.as_bytes(), &new).expect("merges");
        assert_eq!((twice.text, twice.changed, twice.added, twice.kept), (merged.text.clone(), 0, 0, 4));
        let numbers: Vec<u32> = twice.library.tools.iter().map(|entry| entry.tool.number).collect();
        assert_eq!(numbers, [1, 4, 3]);
        let again = library(&merged.text);
        let twice = merge_toml("shop.toml", merged.text.as_bytes(), &again).expect("merges");
        assert_eq!((twice.text, twice.changed, twice.added, twice.kept), (merged.text, 0, 0, 4));
    }

    #[test]
    fn other_files_are_refused() {
        let new = library("[[tool]]\nnumber = 1\ndiameter = 6\n");
        let inline = "[[tool]]\nnumber = 9\ndiameter = 3\nname = '''\n[[tool]]\n'''\n";
        for other in ["name = \"pump6\"\nblades = 6\n", inline] {
            let error = merge_toml("p.toml", other.as_bytes(), &new).expect_err(other);
            assert!(error.to_string().contains("p.toml"), "{error}");
        }
        assert_eq!(merge_toml("e.toml", b"\n", &new).expect("writes").text, write_toml(&new));
    }
}
