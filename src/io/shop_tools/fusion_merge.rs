//! Writing tools into a Fusion library that exists: what Vanecut does not know of it stays, byte for byte.

use std::collections::BTreeSet;
use std::sync::Arc;

use serde_json::{Value, json};

use super::fusion::mills_of_entries;
use super::fusion_units::unit_mm;
use super::fusion_write::{entry_of, write_fusion};
use super::json::{elements, json_text, tool_tree, with_values};
use super::library::{free_number, is_moved, move_tool};
use super::{LibraryTool, ToolLibrary};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::Source;
use crate::setup::{Tool, ToolAssembly};

/// Difference up to which two numbers count as equal, mm, mm/min, rev/min or m/min: formats round them.
const SAME: f64 = 1e-6;

/// A library with tools written into it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MergedLibrary {
    /// The text of the library.
    pub text: String,
    /// Number of its entries that were changed.
    pub changed: usize,
    /// Number of entries that were added.
    pub added: usize,
    /// Number of entries that are as they were, holders and drills among them.
    pub kept: usize,
    /// What was not written as it was given.
    pub notes: Vec<String>,
    /// The tools as they are written, in the order of those given: some under other numbers.
    pub library: ToolLibrary,
}

impl MergedLibrary {
    /// A library that is written as it is, where none is: its `text`.
    pub(super) fn of_new_file(text: String, library: &ToolLibrary) -> Self {
        Self { text, added: library.tools.len(), library: library.clone(), ..Self::default() }
    }
}

/// Writes the tools of `library` into the Fusion library `existing`, whose name in messages is `name`.
///
/// The entry of a tool is the mill with its number and name, or the only one with its number and diameter. In
/// it the values that differ are replaced, in its own unit; the rest of it stays as it is written. A tool
/// without an entry is added at the end. Where another entry has its number, one of a drill for instance, it
/// gets a free one, or that which it got when it was written before; `notes` name it. No entry is removed.
///
/// # Errors
/// When `existing` is not a Fusion library.
pub fn merge_fusion(name: &str, existing: &[u8], library: &ToolLibrary) -> Result<MergedLibrary, InputError> {
    let fault = |what: String| {
        let help = "write to another file, or give a tool library of Fusion";
        Source::new(name, ErrorCode::ToolFile).fault(0, what, help)
    };
    let text = json_text(name, existing)?;
    let entries = elements(text, "data", usize::MAX).ok_or_else(|| fault("has no list `data`".to_owned()))?;
    if entries.is_empty() {
        return Ok(MergedLibrary::of_new_file(write_fusion(library), library));
    }
    let (mills, there) = mills_of_entries(&entries);
    let own = library.tools.iter().map(|entry| entry.tool.number);
    let mut numbers: BTreeSet<u32> = there.iter().copied().chain(own).collect();
    let (mut notes, mut written) = (Vec::new(), Vec::new());
    let mut replaced: Vec<Option<String>> = vec![None; entries.len()];
    let mut added = Vec::new();
    let mut is_taken = vec![false; entries.len()];
    let mut own_entry = |tool: &Arc<LibraryTool>| {
        let found = entry_for(tool, &mills).filter(|(index, _)| !is_taken[*index]);
        found.inspect(|(index, _)| is_taken[*index] = true)
    };
    // All of them first: none is that of a tool that was moved.
    let own: Vec<Option<(usize, &LibraryTool)>> = library.tools.iter().map(&mut own_entry).collect();
    for (entry, mut found) in library.tools.iter().zip(own) {
        let mut entry = Arc::clone(entry);
        if found.is_none() && there.contains(&entry.tool.number) {
            let moved = |(index, known): &&(usize, LibraryTool)| {
                !is_taken[*index] && is_moved(&known.tool, &entry.tool)
            };
            found = mills.iter().find(moved).map(|(index, known)| (*index, known));
            let number = found.map_or_else(|| free_number(&numbers), |(_, known)| known.tool.number);
            numbers.insert(number);
            notes.push(move_tool(Arc::make_mut(&mut entry), number));
        }
        if let Some((index, known)) = found {
            is_taken[index] = true;
            let mut tree = tool_tree(entries[index]).map_err(&fault)?;
            let before = tree.clone();
            change_entry(&mut tree, known, &entry).map_err(&fault)?;
            if tree != before {
                replaced[index] = Some(with_values(entries[index], &tree));
            }
        } else {
            added.push(entry_of(&entry));
        }
        written.push(entry);
    }
    let changed = replaced.iter().flatten().count();
    let counts = (changed, added.len(), entries.len() - changed);
    let added = added.iter().map(|entry| serde_json::to_string_pretty(entry).unwrap_or_default());
    let text = spliced(text, &entries, &replaced, &added.collect::<Vec<_>>())
        .ok_or_else(|| fault("cannot be changed".to_owned()))?;
    let library = ToolLibrary { tools: written, ..library.clone() };
    Ok(MergedLibrary { text, changed: counts.0, added: counts.1, kept: counts.2, notes, library })
}

/// `text` with some of its `entries` replaced, and others added after the last one; `None` where they are not
/// parts of it.
fn spliced(text: &str, entries: &[&str], replaced: &[Option<String>], added: &[String]) -> Option<String> {
    let offset = |entry: &str| (entry.as_ptr() as usize).checked_sub(text.as_ptr() as usize);
    let mut out = String::with_capacity(text.len() + added.iter().map(String::len).sum::<usize>());
    let mut from = 0;
    for (entry, replaced) in entries.iter().zip(replaced) {
        let at = offset(entry)?;
        out.push_str(text.get(from..at)?);
        out.push_str(replaced.as_deref().unwrap_or(entry));
        from = at + entry.len();
    }
    for entry in added {
        out.push_str(",\n");
        out.push_str(entry);
    }
    out.push_str(text.get(from..)?);
    Some(out)
}

/// The entry of a tool, by index, and what it holds.
fn entry_for<'m>(tool: &LibraryTool, mills: &'m [(usize, LibraryTool)]) -> Option<(usize, &'m LibraryTool)> {
    let named = |other: &&(usize, LibraryTool)| {
        other.1.tool.number == tool.tool.number && other.1.tool.assembly.name == tool.tool.assembly.name
    };
    let sized = |other: &&(usize, LibraryTool)| {
        let (other, tool) = (&other.1.tool, &tool.tool);
        other.number == tool.number && (other.diameter - tool.diameter).abs() <= SAME
    };
    let numbered = || {
        let mut ours = mills.iter().filter(sized);
        ours.next().filter(|_| ours.next().is_none())
    };
    mills.iter().find(named).or_else(numbered).map(|(index, known)| (*index, known))
}

/// Changes the values of an entry that differ between the tool that it holds and the `wanted` one.
fn change_entry(entry: &mut Value, known: &LibraryTool, wanted: &LibraryTool) -> Result<(), String> {
    let mm = unit_mm(entry, "it")?;
    let (was, now) = (&known.tool, &wanted.tool);
    let (old, new) = (&was.assembly, &now.assembly);
    let mut changes = EntryChanges { entry, mm };
    changes.length("DC", "tool_diameter", Some(was.diameter), Some(now.diameter));
    changes.length("RE", "tool_cornerRadius", Some(was.corner_radius), Some(now.corner_radius));
    // A tool without flute length and shank has edges up to the holder: the flute length of the entry stays.
    let flutes = |tool: &Tool| {
        let ToolAssembly { flute_length, shank, .. } = &tool.assembly;
        (flute_length.is_some() || !shank.is_empty()).then(|| tool.assembly.flutes_end(tool.overhang))
    };
    let (old_flutes, new_flutes) = (flutes(was), flutes(now));
    changes.length("LCF", "tool_fluteLength", old_flutes, new_flutes);
    if differs(Some(was.overhang), Some(now.overhang)) {
        changes.length("LB", "tool_bodyLength", Some(was.overhang), Some(now.overhang));
        changes.move_gauge_line(now.overhang - was.overhang);
    }
    let degrees = |taper: Option<f64>| taper.map(f64::to_degrees);
    changes.number("TA", "tool_taperAngle", (degrees(old.taper_rad), degrees(new.taper_rad)));
    let teeth = |teeth: Option<u32>| teeth.map(f64::from);
    changes.number("NOF", "tool_numberOfFlutes", (teeth(old.teeth), teeth(new.teeth)));
    if let Some(name) = new.name.as_ref().filter(|_| old.name != new.name) {
        changes.set(&["description"], json!(name));
        changes.forget_expression("tool_description");
    }
    if let Some(text) = new.description.as_ref().filter(|_| old.description != new.description) {
        changes.set(&["post-process", "comment"], json!(text));
        changes.forget_expression("tool_comment");
    }
    if let Some(material) = new.material.as_ref().filter(|_| old.material != new.material) {
        changes.set(&["BMC"], json!(material));
        changes.forget_expression("tool_material");
    }
    for (key, was, now) in [
        ("length-offset", old.length_offset, new.length_offset),
        ("diameter-offset", old.diameter_offset, new.diameter_offset),
    ] {
        if let Some(now) = now.filter(|_| was != now) {
            changes.set(&["post-process", key], json!(now));
        }
    }
    // Segments stand on the flutes; the entry gives the neck by the height of its shoulder.
    let stands_elsewhere = differs(old_flutes, new_flutes) && !new.shank.is_empty();
    if stands_elsewhere || !same_shank(&old.shank, &new.shank) {
        changes.shank(now);
    }
    if !same_rows(&old.holder, &new.holder) {
        changes.holder(wanted)?;
    }
    let rates = |tool: &LibraryTool| {
        let Tool { spindle, plunge_feed, assembly, .. } = &tool.tool;
        let known = |is_missing: bool, rate: f64| Some(rate).filter(|_| !is_missing);
        [
            known(assembly.missing_rates.spindle, *spindle),
            known(assembly.missing_rates.plunge_feed, *plunge_feed),
            assembly.feed_per_tooth,
            assembly.cutting_speed,
        ]
    };
    changes.rates(rates(known), rates(wanted));
    Ok(())
}

/// Whether the second value is another one than the first; one that is not known changes nothing.
fn differs(was: Option<f64>, now: Option<f64>) -> bool {
    now.is_some_and(|now| was.is_none_or(|was| (was - now).abs() > SAME))
}

/// Whether two shanks are equal; the last segment runs on to the holder, however long it is.
fn same_shank(a: &[[f64; 2]], b: &[[f64; 2]]) -> bool {
    let without_end = |rows: &[[f64; 2]]| {
        let mut rows = rows.to_vec();
        rows.last_mut().into_iter().for_each(|[_, length]| *length = 0.0);
        rows
    };
    same_rows(&without_end(a), &without_end(b))
}

fn same_rows<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> bool {
    a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= SAME)
}

/// A number as files hold it: 12.7 / 25.4 is 0.5.
fn rounded(x: f64) -> f64 {
    (x * 1e9).round() / 1e9
}

/// An entry that is changed, and the size of its unit, mm.
struct EntryChanges<'e> {
    entry: &'e mut Value,
    mm: f64,
}

impl EntryChanges<'_> {
    /// Sets the value at a path of keys; objects are made where they are not there.
    fn set(&mut self, path: &[&str], value: Value) {
        let mut place = &mut *self.entry;
        for key in path {
            if !place.is_object() {
                *place = json!({});
            }
            let Some(object) = place.as_object_mut() else { return };
            place = object.entry(*key).or_insert(Value::Null);
        }
        *place = value;
    }

    /// Removes an expression: Fusion would compute the number beside it anew.
    fn forget_expression(&mut self, name: &str) {
        if let Some(expressions) = self.entry.get_mut("expressions").and_then(Value::as_object_mut) {
            expressions.remove(name);
        }
    }

    /// A length of the geometry, mm, where it differs.
    fn length(&mut self, key: &str, expression: &str, was: Option<f64>, now: Option<f64>) {
        if let Some(now) = now.filter(|_| differs(was, now)) {
            self.set(&["geometry", key], json!(rounded(now / self.mm)));
            self.forget_expression(expression);
        }
    }

    /// A number of the geometry without unit, where it differs.
    fn number(&mut self, key: &str, expression: &str, (was, now): (Option<f64>, Option<f64>)) {
        if let Some(now) = now.filter(|_| differs(was, now)) {
            let value = if now.fract() == 0.0 { json!(now as u64) } else { json!(rounded(now)) };
            self.set(&["geometry", key], value);
            self.forget_expression(expression);
        }
    }

    /// Moves the gauge line by some mm, where the entry gives its distance from the tip.
    fn move_gauge_line(&mut self, by: f64) {
        let moved = by / self.mm;
        if let Some(length) = self.entry.pointer("/geometry/assemblyGaugeLength").and_then(Value::as_f64) {
            self.set(&["geometry", "assemblyGaugeLength"], json!(rounded(length + moved)));
        }
        self.forget_expression("tool_assemblyGaugeLength");
    }

    /// Neck and shank of `tool` as segments of the shaft, which then begin at the flutes.
    fn shank(&mut self, tool: &Tool) {
        let mm = self.mm;
        let row = |&[diameter, length]: &[f64; 2]| {
            let [diameter, height] = [diameter, length].map(|x| rounded(x / mm));
            json!({"height": height, "lower-diameter": diameter, "upper-diameter": diameter})
        };
        let rows: Vec<Value> = tool.assembly.shank.iter().map(row).collect();
        self.set(&["shaft"], json!({"type": "shaft", "segments": rows}));
        let flute = rounded(tool.assembly.flutes_end(tool.overhang) / mm);
        self.set(&["geometry", "shoulder-length"], json!(flute));
        self.forget_expression("tool_shoulderLength");
    }

    /// The holder of `wanted`, up to its gauge line; what the entry has in the spindle stays.
    fn holder(&mut self, wanted: &LibraryTool) -> Result<(), String> {
        let rows = &wanted.tool.assembly.holder;
        if rows.is_empty() {
            self.entry.as_object_mut().and_then(|entry| entry.remove("holder"));
            return Ok(());
        }
        let Some(holder) = self.entry.get("holder").filter(|holder| holder.is_object()) else {
            self.set(&["holder"], entry_of(wanted)["holder"].take());
            return Ok(());
        };
        let mm = if holder.get("unit").is_some() { unit_mm(holder, "its holder")? } else { self.mm };
        let gauge = holder.get("gaugeLength").and_then(Value::as_f64).filter(|gauge| *gauge > 0.0);
        let mut up = 0.0;
        let old = holder.get("segments").and_then(Value::as_array).cloned().unwrap_or_default();
        let in_the_spindle = old.into_iter().filter(|row| {
            let from = up;
            up += row.get("height").and_then(Value::as_f64).unwrap_or(0.0);
            gauge.is_some_and(|gauge| from >= gauge - 1e-3 / mm)
        });
        let row = |row: &[f64; 3]| {
            let [lower, upper, height] = row.map(|x| rounded(x / mm));
            json!({"height": height, "lower-diameter": lower, "upper-diameter": upper})
        };
        let segments: Vec<Value> = rows.iter().map(row).chain(in_the_spindle).collect();
        let length: f64 = rows.iter().map(|[_, _, length]| length).sum();
        self.set(&["holder", "segments"], Value::Array(segments));
        self.set(&["holder", "gaugeLength"], json!(rounded(length / mm)));
        Ok(())
    }

    /// Spindle speed, plunge feed, feed per tooth and cutting speed of the preset that is read.
    fn rates(&mut self, was: [Option<f64>; 4], now: [Option<f64>; 4]) {
        let mm = self.mm;
        let feet = if mm > 1.0 { 0.3048 } else { 1.0 };
        let keys = [
            ("n", "tool_spindleSpeed", 1.0),
            ("v_f_plunge", "tool_feedPlunge", mm),
            ("f_z", "tool_feedPerTooth", mm),
            ("v_c", "tool_surfaceSpeed", feet),
        ];
        if !was.iter().zip(&now).any(|(was, now)| differs(*was, *now)) {
            return;
        }
        if !self.entry.get("start-values").is_some_and(Value::is_object) {
            self.set(&["start-values", "presets"], json!([{"name": "Vanecut"}]));
        }
        let Some(start) = self.entry.get_mut("start-values").and_then(Value::as_object_mut) else { return };
        // As they are read: the first of the list, or of old files the one under `*` or any other name.
        let preset = match start.get("presets") {
            Some(Value::Array(list)) if list.is_empty() => {
                start.insert("presets".to_owned(), json!([{"name": "Vanecut"}]));
                start.get_mut("presets").and_then(|list| list.get_mut(0))
            }
            Some(_) => start.get_mut("presets").and_then(|list| list.get_mut(0)),
            None if start.contains_key("*") => start.get_mut("*"),
            None => start.values_mut().find(|value| value.is_object()),
        };
        let Some(preset) = preset.and_then(Value::as_object_mut) else { return };
        for ((key, expression, unit), (was, now)) in keys.into_iter().zip(was.into_iter().zip(now)) {
            let Some(now) = now.filter(|_| differs(was, now)) else { continue };
            preset.insert(key.to_owned(), json!(rounded(now / unit)));
            if let Some(expressions) = preset.get_mut("expressions").and_then(Value::as_object_mut) {
                expressions.remove(expression);
            }
        }
    }
}
