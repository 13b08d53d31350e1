//! A library of tools that was read, and what all readers do with its entries.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::left_out;
use crate::error::ErrorCode;
use crate::geometry::without_conversion_error;
use crate::io::InputError;
use crate::io::source::Source;
use crate::io::tool_file::{MAX_NAME, MAX_NUMBER, MAX_TOOLS, WrittenRates, read_tools_bytes, write_tool};
use crate::setup::Tool;
use crate::setup::cutting_data::fill_rates;

/// Difference up to which two lengths count as equal, mm: formats round them.
const SAME_LENGTH: f64 = 1e-6;
/// Overhang in cutter diameters where a library has none.
pub(super) const OVERHANG_DIAMETERS: f64 = 4.0;

/// A tool of a library.
#[derive(Clone, Debug, PartialEq)]
pub struct LibraryTool {
    /// The tool; rates that the library does not give follow from its cutting data, without a material.
    pub tool: Tool,
    /// What was assumed, or could not be taken over.
    pub notes: Vec<String>,
}

/// A library that was read. Copies share the tools that they have in common: libraries of makers have many
/// thousand.
#[derive(Clone, Debug, Default)]
pub struct ToolLibrary {
    /// The mills, in file order.
    pub tools: Vec<Arc<LibraryTool>>,
    /// Entries that are not mills, and other remarks on the whole.
    pub notes: Vec<String>,
    /// Numbers of the tools that are left out.
    pub other_numbers: BTreeSet<u32>,
}

impl PartialEq for ToolLibrary {
    /// Shared tools are not compared one by one.
    fn eq(&self, other: &Self) -> bool {
        let same = |(a, b): (&Arc<LibraryTool>, &Arc<LibraryTool>)| Arc::ptr_eq(a, b) || a == b;
        self.tools.len() == other.tools.len()
            && self.tools.iter().zip(&other.tools).all(same)
            && (&self.notes, &self.other_numbers) == (&other.notes, &other.other_numbers)
    }
}

impl ToolLibrary {
    /// The least number above those of all tools, those that are left out too; where none is left there, the
    /// least free one.
    pub fn free_number(&self) -> u32 {
        let own = self.tools.iter().map(|entry| entry.tool.number);
        free_number(&own.chain(self.other_numbers.iter().copied()).collect())
    }

    /// All remarks on tools and on the whole, few lines also for thousands of tools.
    pub fn remarks(&self) -> Vec<String> {
        let remarks = self.tools.iter().flat_map(|entry| {
            let (number, notes) = (entry.tool.number.to_string(), entry.notes.iter());
            notes.map(move |note| (number.clone(), note.as_str()))
        });
        let mut lines = left_out::in_few_lines(remarks);
        lines.extend(self.notes.iter().cloned());
        lines
    }
}

/// Rounds lengths and rates to 1e-9, as 3 in are 76.2 mm and not 76.199…: people read converted numbers.
pub(super) fn round_lengths(library: &mut ToolLibrary) {
    let round = |mm: &mut f64| *mm = without_conversion_error(*mm);
    for LibraryTool { tool, .. } in library.tools.iter_mut().map(Arc::make_mut) {
        [&mut tool.diameter, &mut tool.corner_radius, &mut tool.insert_width, &mut tool.overhang]
            .into_iter()
            .for_each(round);
        let missing = tool.assembly.missing_rates;
        // Rates that are missing follow from others.
        Some(&mut tool.plunge_feed).filter(|_| !missing.plunge_feed).into_iter().for_each(round);
        Some(&mut tool.spindle).filter(|_| !missing.spindle).into_iter().for_each(round);
        let assembly = &mut tool.assembly;
        [&mut assembly.feed_per_tooth, &mut assembly.cutting_speed].into_iter().flatten().for_each(round);
        tool.assembly.flute_length.iter_mut().for_each(round);
        tool.assembly.shank.iter_mut().flatten().for_each(round);
        tool.assembly.holder.iter_mut().flatten().for_each(round);
        fill_rates(tool, None);
    }
}

/// The least number above the `taken` ones; where that is too large, the least free one.
pub(super) fn free_number(taken: &BTreeSet<u32>) -> u32 {
    let above = taken.last().map_or(1, |last| last.saturating_add(1));
    if above <= MAX_NUMBER {
        return above;
    }
    (1..=MAX_NUMBER).find(|number| !taken.contains(number)).unwrap_or(MAX_NUMBER)
}

/// Puts tools under numbers of their own: a tool without one, or with one that is taken, gets a free one.
pub(super) fn number_tools(library: &mut ToolLibrary) {
    let given = library.tools.iter().map(|entry| entry.tool.number);
    let mut given: BTreeSet<u32> = given.chain(library.other_numbers.iter().copied()).collect();
    let mut taken = BTreeSet::new();
    for LibraryTool { tool, notes, .. } in library.tools.iter_mut().map(Arc::make_mut) {
        if tool.number == 0 || !taken.insert(tool.number) {
            notes.push(match tool.number {
                0 => "no number in the library: a free one given".to_owned(),
                _ => "its number is taken by another tool: a free one given".to_owned(),
            });
            tool.renumber(free_number(&given));
            given.insert(tool.number);
            taken.insert(tool.number);
        }
    }
}

/// Gives a tool, whose number another tool of a file has, the number `to`; returns a note that says so.
pub(super) fn move_tool(entry: &mut LibraryTool, to: u32) -> String {
    let was = entry.tool.number;
    entry.tool.renumber(to);
    format!("tool {was}: another tool there has its number: it is tool {to}")
}

/// Whether the tool that is `there` is `tool` under another number, as it was written before: a tool without
/// a name is not known again.
pub(super) fn is_moved(there: &Tool, tool: &Tool) -> bool {
    let size = |tool: &Tool| [tool.diameter, tool.corner_radius, tool.overhang];
    let same = size(there).iter().zip(size(tool)).all(|(a, b)| (a - b).abs() <= SAME_LENGTH);
    let name = &tool.assembly.name;
    there.number != tool.number && name.is_some() && there.assembly.name == *name && same
}

/// A description cut to the length of a name; `None` when it is empty.
pub(super) fn short_name(text: &str) -> Option<String> {
    let name: String = text.trim().chars().filter(|c| !c.is_control()).take(MAX_NAME).collect();
    (!name.is_empty()).then_some(name)
}

/// A tool with the rates that it lacks, as in a setup without a material.
pub(super) fn rated(mut entry: LibraryTool) -> LibraryTool {
    fill_rates(&mut entry.tool, None);
    entry
}

/// The insert width of a mill whose library has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AssumedInsert {
    /// Its edges reach to the centre.
    ToCentre,
    /// They leave a core, as inserts do.
    WithCore,
}

impl AssumedInsert {
    const ALL: [Self; 2] = [Self::ToCentre, Self::WithCore];

    /// The width for a cutter of this `radius`, mm.
    pub(super) fn width(self, radius: f64) -> f64 {
        match self {
            Self::ToCentre => radius,
            Self::WithCore => 0.9 * radius,
        }
    }

    /// What is noted of it.
    pub(super) fn note(self) -> &'static str {
        match self {
            Self::ToCentre => "insert width assumed: the cutter cuts to its centre",
            Self::WithCore => "insert width assumed: 0.45 of the diameter",
        }
    }

    /// Whether it is the width of `tool`.
    fn is_of(self, tool: &Tool) -> bool {
        (tool.insert_width - self.width(tool.radius())).abs() <= 1e-6
    }
}

/// What is noted where a library does not know holders.
pub(super) const UNKNOWN_HOLDER: &str = "the holder is unknown";
/// What is noted of a rate that a library does not give.
const MISSING_RATE: &str = "in the library: by `material` of the setup; without one";

impl LibraryTool {
    /// Replaces the tool of this entry by `tool`. A value that changes was entered by the user: the note that
    /// it is missing or assumed is removed. An assumed insert width that was not entered follows another
    /// diameter.
    pub fn replace(&mut self, mut tool: Tool) {
        let before = &self.tool;
        let is_noted = |words: &str| self.notes.iter().any(|note| note.contains(words));
        let is_assumed = |insert: &AssumedInsert| is_noted(insert.note());
        if let Some(insert) = AssumedInsert::ALL.into_iter().find(is_assumed)
            && tool.diameter != before.diameter
            && tool.insert_width == before.insert_width.min(tool.radius())
        {
            tool.insert_width = insert.width(tool.radius());
        }
        let mut given = vec![MISSING_RATE];
        given.extend((!tool.assembly.holder.is_empty()).then_some(UNKNOWN_HOLDER));
        given.extend(AssumedInsert::ALL.iter().filter(|insert| !insert.is_of(&tool)).map(|i| i.note()));
        let sizes = [
            ("stick-out assumed", before.overhang, tool.overhang),
            ("corner radius assumed", before.corner_radius, tool.corner_radius),
        ];
        given.extend(sizes.iter().filter(|(_, old, new)| old != new).map(|(note, ..)| *note));
        self.notes.retain(|note| !given.iter().any(|given| note.contains(given)));
        note_missing_rates(&tool, &mut self.notes);
        self.tool = tool;
    }
}

/// Notes what rates a library does not give, where they do not follow from what it gives.
pub(super) fn note_missing_rates(tool: &Tool, notes: &mut Vec<String>) {
    let more = &tool.assembly;
    let missing = more.missing_rates;
    let spindle = missing.spindle && more.cutting_speed.is_none();
    let feed = missing.plunge_feed && (more.feed_per_tooth.is_none() || more.teeth.is_none());
    let [missing, otherwise] = match (feed, spindle) {
        (true, true) => ["neither plunge feed nor spindle speed", "300 mm/min, 1200 rev/min"],
        (true, false) => ["no plunge feed", "300 mm/min"],
        (false, true) => ["no spindle speed", "1200 rev/min"],
        (false, false) => return,
    };
    notes.push(format!("{missing} {MISSING_RATE} {otherwise}"));
}

/// Checks the sizes of a tool as the reader of setups does: writes it and reads it back.
///
/// # Errors
/// What is out of range, and what to do.
pub(super) fn check_tool(entry: &LibraryTool) -> Result<(), String> {
    let mut text = String::from("[[tool]]\n");
    let tool = Tool { number: entry.tool.number.max(1), ..entry.tool.clone() };
    // `write!` to a `String` cannot fail.
    let _ = write_tool(&mut text, &tool, WrittenRates::Given);
    read_tools_bytes("", text.as_bytes())
        .map(|_| ())
        .map_err(|error| format!("{}; {}", error.message, error.help))
}

/// Error of a library with too many tools.
pub(super) fn too_many(name: &str, count: usize) -> Result<(), InputError> {
    if count <= MAX_TOOLS {
        return Ok(());
    }
    let what = format!("{count} tools, more than {MAX_TOOLS}");
    Err(Source::new(name, ErrorCode::ToolFile)
        .fault(0, what, "split the library")
        .with_code(ErrorCode::FileTooLarge))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inches_become_the_numbers_that_people_write() {
        let mut tool = Tool {
            number: 1,
            diameter: 3.0 * 25.4,
            corner_radius: 0.0,
            insert_width: 0.5 * 25.4,
            overhang: 0.7 * 25.4,
            plunge_feed: 300.0,
            spindle: 1000.0,
            assembly: Default::default(),
        };
        tool.assembly.holder = vec![[0.1 * 25.4, 3.0 * 25.4, 1.1 * 25.4]];
        assert_ne!(tool.diameter, 76.2, "by the multiplication alone");
        let mut library = ToolLibrary {
            tools: vec![Arc::new(LibraryTool { tool, notes: Vec::new() })],
            ..Default::default()
        };
        round_lengths(&mut library);
        let tool = &library.tools[0].tool;
        assert_eq!((tool.diameter, tool.overhang), (76.2, 17.78));
        assert_eq!(tool.assembly.holder, [[2.54, 76.2, 27.94]]);
    }
}
