//! Fusion tool libraries: `{"data": [tool, …], "version": …}`, lengths in the unit of each tool, holders in
//! a unit of their own.
//!
//! Segments run from the cutter or the collet towards the spindle. Segments of a holder beyond its gauge
//! length are in the spindle and are left out. An expression prevails over the number beside it.

use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::Value;

use super::expression::Expressions;
use super::fusion_units::{holder_unit_mm, unit_mm};
use super::json::{elements, json_text, tool_tree};
use super::left_out::LeftOutTools;
use super::library::{
    AssumedInsert, LibraryTool, OVERHANG_DIAMETERS, ToolLibrary, check_tool, note_missing_rates,
    number_tools, rated, round_lengths, short_name, too_many,
};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{Source, quote_for_message};
use crate::io::table::NumberRange;
use crate::io::tool_file::{
    CUTTING_SPEED, FEED_PER_TOOTH, MAX_NUMBER, MAX_SEGMENTS, MAX_TEETH, MAX_TOOLS, PLUNGE_FEED, SPINDLE,
};
use crate::setup::{MissingRates, Tool, ToolAssembly};

/// Largest number of entries of all kinds.
const MAX_ENTRIES: usize = 4 * MAX_TOOLS;

/// Mills by their type, with the insert width that is assumed: cutters with inserts have a core, solid ones
/// cut to the centre.
const MILLS: [(&str, AssumedInsert); 6] = [
    ("flat end mill", AssumedInsert::ToCentre),
    ("ball end mill", AssumedInsert::ToCentre),
    ("bull nose end mill", AssumedInsert::WithCore),
    ("face mill", AssumedInsert::WithCore),
    ("tapered mill", AssumedInsert::ToCentre),
    ("lollipop mill", AssumedInsert::ToCentre),
];
/// Mills that end in a ball, whatever their corner radius says.
const BALLS: [&str; 2] = ["ball end mill", "lollipop mill"];

/// What an entry of a library is.
enum FusionEntry {
    Mill(Box<LibraryTool>),
    Holder,
    /// Neither, or one that cannot be taken over.
    Other(OtherEntry),
}

/// An entry that is left out.
struct OtherEntry {
    shown: String,
    why: String,
    is_mill: bool,
    number: Option<u32>,
}

/// Reads a library.
///
/// # Errors
/// When the bytes are not JSON of this form, or no mill in it can be taken over. One with impossible sizes
/// beside others is left out, with a note.
pub(super) fn read(name: &str, bytes: &[u8]) -> Result<ToolLibrary, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let text = json_text(name, bytes)?;
    let data = elements(text, "data", MAX_ENTRIES + 1);
    let data = data.ok_or_else(|| fault("has no list `data`".to_owned(), "give a tool library of Fusion"))?;
    if data.len() > MAX_ENTRIES {
        let what = format!("more than {MAX_ENTRIES} entries");
        return Err(fault(what, "split the library").with_code(ErrorCode::FileTooLarge));
    }
    let mut library = ToolLibrary::default();
    let mut left_out = LeftOutTools::default();
    let mut holders = 0;
    // The first error of a mill. It becomes the error of the library if no mill can be read.
    let mut refused = None;
    let entries: Vec<FusionEntry> = data.par_iter().enumerate().map(entry).collect();
    for found in entries {
        match found {
            FusionEntry::Mill(tool) => library.tools.push(Arc::new(*tool)),
            FusionEntry::Holder => holders += 1,
            FusionEntry::Other(OtherEntry { shown, why, is_mill, number }) => {
                library.other_numbers.extend(number);
                if is_mill {
                    refused
                        .get_or_insert_with(|| fault(format!("{shown}: {why}"), "correct it in the library"));
                }
                left_out.add(shown, why);
            }
        }
    }
    library.notes.extend(left_out.notes());
    if holders > 0 {
        library.notes.push(format!("{holders} holders without a tool are left out"));
    }
    too_many(name, library.tools.len())?;
    if library.tools.is_empty() {
        let none = "contains no end mill or face mill".to_owned();
        return Err(refused.unwrap_or_else(|| fault(none, "give a library with end mills or face mills")));
    }
    number_tools(&mut library);
    round_lengths(&mut library);
    Ok(library)
}

/// The mills among the texts of entries, by index, as [`read`] numbers them, and the numbers of all tools.
pub(super) fn mills_of_entries(entries: &[&str]) -> (Vec<(usize, LibraryTool)>, BTreeSet<u32>) {
    let found: Vec<FusionEntry> = entries.par_iter().enumerate().map(entry).collect();
    let mut library = ToolLibrary::default();
    let mut indices = Vec::new();
    for (index, found) in found.into_iter().enumerate() {
        match found {
            FusionEntry::Mill(tool) => {
                library.tools.push(Arc::new(*tool));
                indices.push(index);
            }
            FusionEntry::Other(other) => library.other_numbers.extend(other.number),
            FusionEntry::Holder => {}
        }
    }
    number_tools(&mut library);
    round_lengths(&mut library);
    let mut numbers = library.other_numbers;
    numbers.extend(library.tools.iter().map(|entry| entry.tool.number));
    let tools = library.tools.into_iter().map(Arc::unwrap_or_clone);
    (indices.into_iter().zip(tools).collect(), numbers)
}

/// Reads the text of the entry at an index.
fn entry((index, text): (usize, &&str)) -> FusionEntry {
    let place = index + 1;
    let unreadable = |why: String| {
        FusionEntry::Other(OtherEntry { shown: format!("entry {place}"), why, is_mill: true, number: None })
    };
    let tree = match tool_tree(text) {
        Ok(tree) if tree.is_object() => tree,
        Ok(_) => return unreadable("it is not a tool".to_owned()),
        Err(why) => return unreadable(why),
    };
    let kind = string(&tree, "type").unwrap_or_default();
    let other = |why: String, is_mill: bool| {
        let number = post_number(&tree, "number").filter(|number| *number > 0);
        FusionEntry::Other(OtherEntry { shown: shown(&tree, place), why, is_mill, number })
    };
    let Some((_, insert)) = MILLS.iter().find(|(mill, _)| *mill == kind) else {
        if kind == "holder" {
            return FusionEntry::Holder;
        }
        return other(format!("{} is not a mill", quote_for_message(kind)), false);
    };
    match mill(&tree, kind, *insert).and_then(|tool| check_tool(&tool).map(|()| tool)) {
        Ok(tool) => FusionEntry::Mill(Box::new(tool)),
        Err(why) => other(why, true),
    }
}

/// An entry in messages: by number and name of its tool, without a number by its `place` in the list.
fn shown(entry: &Value, place: usize) -> String {
    let number = entry.pointer("/post-process/number").and_then(Value::as_u64).filter(|number| *number > 0);
    let what = number.map_or_else(|| format!("entry {place}"), |number| format!("tool {number}"));
    let name = string(entry, "description").map(str::trim).filter(|name| !name.is_empty());
    name.map_or(what.clone(), |name| format!("{what} ({})", quote_for_message(name)))
}

/// A number of the tool in programs, up to [`MAX_NUMBER`].
fn post_number(entry: &Value, key: &str) -> Option<u32> {
    let value = entry.get("post-process")?.get(key)?.as_u64()?;
    u32::try_from(value).ok().filter(|value| *value <= MAX_NUMBER)
}

fn string<'v>(value: &'v Value, key: &str) -> Option<&'v str> {
    value.get(key).and_then(Value::as_str)
}

/// A number; absent when there is none or it is not positive.
fn number(value: Option<&Value>, key: &str) -> Result<Option<f64>, String> {
    let Some(value) = value.and_then(|value| value.get(key)) else { return Ok(None) };
    match value {
        Value::Null => Ok(None),
        _ => match value.as_f64() {
            Some(x) if x.is_finite() => Ok(Some(x)),
            _ => Err(format!("`{key}` is not a number")),
        },
    }
}

/// Lengths of a tool: their keys, and their names in expressions.
const LENGTHS: [(&str, &str); 8] = [
    ("DC", "tool_diameter"),
    ("RE", "tool_cornerRadius"),
    ("LCF", "tool_fluteLength"),
    ("LB", "tool_bodyLength"),
    ("OAL", "tool_overallLength"),
    ("shoulder-length", "tool_shoulderLength"),
    ("shoulder-diameter", "tool_shoulderDiameter"),
    ("SFDM", "tool_shaftDiameter"),
];

/// The expressions of a tool whose unit is `mm`, with the numbers that they may name.
fn expressions_of<'v>(entry: &'v Value, geometry: &'v Value, mm: f64) -> Expressions<'v> {
    let stored = |key: &str| geometry.get(key).and_then(Value::as_f64);
    let lengths = LENGTHS.into_iter().filter_map(|(key, name)| Some((name, stored(key)? * mm)));
    let gauge = || {
        let holder = entry.get("holder")?;
        let length = holder.get("gaugeLength")?.as_f64()? * holder_unit_mm(holder, geometry, mm).ok()?.0;
        Some(("tool_holderGaugeLength", length))
    };
    let teeth = stored("NOF").map(|teeth| ("tool_numberOfFlutes", teeth));
    Expressions::new(entry.get("expressions"), mm).with_numbers(lengths.chain(gauge()), teeth)
}

/// Converts one mill of this `kind`, whose insert width is assumed.
fn mill(entry: &Value, kind: &str, insert: AssumedInsert) -> Result<LibraryTool, String> {
    let mut notes = Vec::new();
    let mm = unit_mm(entry, "it")?;
    let geometry = entry.get("geometry").filter(|g| g.is_object()).ok_or("it has no `geometry`")?;
    let expressions = expressions_of(entry, geometry, mm);
    let mut length = |key: &str, name: &str| -> Result<Option<f64>, String> {
        let stored = number(Some(geometry), key)?.map(|x| x * mm);
        if expressions.has(name) {
            match expressions.length(name) {
                Some(value) => return Ok(Some(value)),
                None => notes.push(format!("the expression {name} cannot be computed: its number is taken")),
            }
        }
        Ok(stored)
    };
    let positive = |x: Option<f64>| x.filter(|x| *x > 0.0);
    let mut diameter = length("DC", "tool_diameter")?.ok_or("it has no diameter `DC`")?;
    if diameter <= 0.0 {
        return Err(format!("its diameter is {diameter} mm"));
    }
    let corner = length("RE", "tool_cornerRadius")?;
    // Where a tapered ball has less than half of the diameter as radius, that is the diameter further up.
    let ball = corner.filter(|_| string(entry, "tapered-type") == Some("tapered_ball"));
    let tip = ball.map(|corner| 2.0 * corner).filter(|tip| *tip > 0.0 && *tip < 0.999 * diameter);
    let has_wider_end = tip.is_some();
    diameter = tip.unwrap_or(diameter);
    let radius = 0.5 * diameter;
    let mut flute = positive(length("LCF", "tool_fluteLength")?);
    let body = positive(length("LB", "tool_bodyLength")?);
    let shoulder = positive(length("shoulder-length", "tool_shoulderLength")?);
    let neck = positive(length("shoulder-diameter", "tool_shoulderDiameter")?);
    let shaft = positive(length("SFDM", "tool_shaftDiameter")?);
    let taper = expressions.value("tool_taperAngle").or(number(Some(geometry), "TA")?);
    let taper = taper.filter(|angle| *angle > 0.0);
    if has_wider_end {
        notes.push("diameter at the tip assumed: that of its ball".to_owned());
    }
    let corner = corner_radius(kind, corner, radius, &mut notes);
    if taper.is_some() {
        notes.push("tapered: plans leave it out, they know cylindrical cutters only".to_owned());
    }
    let overhang = body.unwrap_or_else(|| {
        notes.push("stick-out assumed: 4 diameters, as the library has no body length".to_owned());
        OVERHANG_DIAMETERS * diameter
    });
    if let Some(long) = flute.filter(|flute| *flute > overhang) {
        notes.push(format!("the flutes, {long} mm, are longer than the stick-out, {overhang} mm: cut to it"));
        flute = Some(overhang);
    }
    let is_centre_cutting = geometry.get("CSP").and_then(Value::as_bool) == Some(true);
    let insert = if is_centre_cutting { AssumedInsert::ToCentre } else { insert };
    let insert_width = insert.width(radius);
    notes.push(insert.note().to_owned());
    let segments = entry.get("shaft").and_then(|shaft| shaft.get("segments"));
    let rows = segments.map(|rows| read_segments(rows, mm)).transpose()?.unwrap_or_default();
    // The neck reaches from the flutes to the shoulder; above it are the segments of the shaft, or its
    // diameter.
    let mut shank: Vec<[f64; 2]> = Vec::new();
    let end_of_flutes = flute.unwrap_or(0.0);
    let end_of_neck = shoulder.unwrap_or(end_of_flutes).min(overhang);
    if end_of_neck > end_of_flutes && flute.is_some() {
        shank.push([neck.unwrap_or(diameter), end_of_neck - end_of_flutes]);
    }
    if flute.is_some() {
        if rows.is_empty() {
            if let Some(shaft) = shaft.filter(|_| overhang > end_of_neck) {
                shank.push([shaft, overhang - end_of_neck]);
            }
        } else {
            shank.extend(rows.iter().map(|[lower, upper, length]| [lower.max(*upper), *length]));
            if rows.iter().any(|[lower, upper, _]| lower != upper) {
                notes.push("cones of the shaft are taken as cylinders of their larger diameter".to_owned());
            }
        }
    }
    let holder = match entry.get("holder").filter(|holder| holder.is_object()) {
        Some(holder) => read_holder(holder, holder_unit_mm(holder, geometry, mm)?, &mut notes)?,
        None => Vec::new(),
    };
    let teeth = expressions.number_of("tool_numberOfFlutes");
    let teeth = teeth.filter(|n| (1.0..=f64::from(MAX_TEETH)).contains(n)).map(|n| n as u32);
    let preset = preset_of(entry, mm, &expressions, &mut notes)?;
    let missing_rates =
        MissingRates { plunge_feed: preset.plunge_feed.is_none(), spindle: preset.spindle.is_none() };
    let tool = Tool {
        number: post_number(entry, "number").unwrap_or(0),
        diameter,
        corner_radius: corner,
        insert_width,
        overhang,
        plunge_feed: preset.plunge_feed.unwrap_or(0.0),
        spindle: preset.spindle.unwrap_or(0.0),
        assembly: ToolAssembly {
            name: string(entry, "description").and_then(short_name),
            description: description_of(entry),
            material: string(entry, "BMC").filter(|material| *material != "unspecified").and_then(short_name),
            flute_length: flute,
            teeth,
            taper_rad: taper.map(f64::to_radians),
            shank,
            holder,
            length_offset: post_number(entry, "length-offset"),
            diameter_offset: post_number(entry, "diameter-offset"),
            feed_per_tooth: preset.feed_per_tooth,
            cutting_speed: preset.cutting_speed,
            missing_rates,
        },
    };
    note_missing_rates(&tool, &mut notes);
    Ok(rated(LibraryTool { tool, notes }))
}

/// The comment of an entry, or its maker and order number.
fn description_of(entry: &Value) -> Option<String> {
    let comment = entry.get("post-process").and_then(|post| string(post, "comment")).and_then(short_name);
    comment.or_else(|| {
        let known = ["vendor", "product-id"].map(|key| string(entry, key).unwrap_or_default().trim());
        short_name(&known.join(" "))
    })
}

/// Corner radius of a mill of this `kind` that the library gives as `given`, mm. What differs is noted.
fn corner_radius(kind: &str, given: Option<f64>, radius: f64, notes: &mut Vec<String>) -> f64 {
    let is_ball = BALLS.contains(&kind);
    let given = given.filter(|corner| *corner != 0.0);
    let corner = match given {
        _ if is_ball => radius,
        Some(corner) => corner.clamp(0.0, radius),
        None => 0.0,
    };
    match given {
        None if is_ball => {
            notes.push("corner radius assumed: half of the diameter, as it is a ball".to_owned());
        }
        None if kind == "bull nose end mill" => {
            notes.push("corner radius assumed: a sharp corner, as the library has none".to_owned());
        }
        Some(given) if (given - corner).abs() > 1e-3 * radius => {
            notes.push(format!(
                "corner radius {given} mm does not fit a {kind} of this size: {corner} mm taken"
            ));
        }
        _ => {}
    }
    corner
}

/// Segments as `[lower diameter, upper diameter, length]`, mm; those without length are left out.
fn read_segments(rows: &Value, mm: f64) -> Result<Vec<[f64; 3]>, String> {
    let rows = rows.as_array().ok_or("`segments` is not a list")?;
    if rows.len() > MAX_SEGMENTS {
        return Err(format!("{} segments, more than {MAX_SEGMENTS}", rows.len()));
    }
    let mut segments = Vec::with_capacity(rows.len());
    for row in rows {
        let field = |key: &str| -> Result<f64, String> {
            number(Some(row), key)?.map(|x| x * mm).ok_or_else(|| format!("a segment has no `{key}`"))
        };
        let segment = [field("lower-diameter")?, field("upper-diameter")?, field("height")?];
        if segment.iter().any(|x| *x < 0.0) {
            return Err(format!("a segment has the negative size {segment:?}"));
        }
        if segment[2] > 0.0 && segment[0].max(segment[1]) > 0.0 {
            // A tip without diameter would not be a valid segment.
            segments.push([segment[0].max(1e-3), segment[1].max(1e-3), segment[2]]);
        }
    }
    Ok(segments)
}

/// Segments of a holder up to its gauge line, with its unit and what was assumed of that.
fn read_holder(
    holder: &Value,
    (mm, assumed): (f64, Option<String>),
    notes: &mut Vec<String>,
) -> Result<Vec<[f64; 3]>, String> {
    let Some(rows) = holder.get("segments") else { return Ok(Vec::new()) };
    notes.extend(assumed);
    let mut segments = read_segments(rows, mm)?;
    let Some(gauge) = number(Some(holder), "gaugeLength")?.map(|x| x * mm).filter(|x| *x > 0.0) else {
        return Ok(segments);
    };
    let (mut up, mut kept) = (0.0, 0);
    for segment in &mut segments {
        // A segment that the gauge line crosses by more than rounding is cut there.
        if up >= gauge - 1e-3 {
            break;
        }
        if up + segment[2] > gauge + 1e-3 {
            let share = (gauge - up) / segment[2];
            segment[1] = segment[0] + (segment[1] - segment[0]) * share;
            segment[2] = gauge - up;
        }
        up += segment[2];
        kept += 1;
    }
    if kept < segments.len() {
        notes.push(match segments.len() - kept {
            1 => "the holder segment beyond the gauge line is left out".to_owned(),
            more => format!("{more} holder segments beyond the gauge line are left out"),
        });
        segments.truncate(kept);
    }
    Ok(segments)
}

/// Cutting data of a preset.
#[derive(Default)]
struct Preset {
    spindle: Option<f64>,
    plunge_feed: Option<f64>,
    feed_per_tooth: Option<f64>,
    cutting_speed: Option<f64>,
}

/// The first preset: of the list `presets`, or of old files the one under `*` or any other name.
fn preset_of(
    entry: &Value,
    mm: f64,
    of_tool: &Expressions,
    notes: &mut Vec<String>,
) -> Result<Preset, String> {
    let Some(start) = entry.get("start-values").and_then(Value::as_object) else {
        return Ok(Preset::default());
    };
    let chosen = match start.get("presets") {
        Some(Value::Array(presets)) => {
            if presets.len() > 1 {
                let name = presets.first().and_then(|p| string(p, "name")).unwrap_or_default();
                let count = presets.len();
                notes.push(format!("of {count} presets the first is taken: {}", quote_for_message(name)));
            }
            presets.first()
        }
        Some(_) => return Err("`presets` is not a list".to_owned()),
        None => start.get("*").or_else(|| start.values().find(|value| value.is_object())),
    };
    let Some(preset) = chosen else { return Ok(Preset::default()) };
    // Inch libraries have feet per minute.
    let feet = if mm > 1.0 { 0.3048 } else { 1.0 };
    let stored = |key: &str, factor: f64| preset.get(key).and_then(Value::as_f64).map(|x| x * factor);
    let rates = [
        ("tool_spindleSpeed", stored("n", 1.0)),
        ("tool_feedCutting", stored("v_f", mm)),
        ("tool_feedPlunge", stored("v_f_plunge", mm)),
        ("tool_surfaceSpeed", stored("v_c", feet)),
        ("tool_numberOfFlutes", of_tool.number_of("tool_numberOfFlutes")),
    ];
    let lengths = [
        ("tool_feedPerTooth", stored("f_z", mm)),
        ("tool_feedPerRevolution", stored("f_n", mm)),
        ("tool_diameter", of_tool.number_of("tool_diameter")),
    ];
    let known = |(name, value): (&'static str, Option<f64>)| Some((name, value?));
    let expressions = Expressions::new(preset.get("expressions"), mm)
        .with_numbers(lengths.into_iter().filter_map(known), rates.into_iter().filter_map(known));
    let mut taken = |key: &str,
                     name: &str,
                     factor: f64,
                     (range, unit): (NumberRange, &str)|
     -> Result<Option<f64>, String> {
        let mut value = number(Some(preset), key)?.map(|x| x * factor);
        if expressions.has(name) {
            let is_length = name == "tool_feedPerTooth";
            match if is_length { expressions.length(name) } else { expressions.value(name) } {
                Some(found) => value = Some(found),
                None => {
                    notes.push(format!("the expression {name} cannot be computed: its number is taken"));
                }
            }
        }
        // Fusion writes 0 where nothing is given.
        let Some(value) = value.filter(|value| *value != 0.0) else { return Ok(None) };
        if range.check(value).is_err() {
            notes.push(format!("`{key}` is left out: {value} {unit} is impossible"));
            return Ok(None);
        }
        Ok(Some(value))
    };
    Ok(Preset {
        spindle: taken("n", "tool_spindleSpeed", 1.0, (SPINDLE, "rev/min"))?,
        plunge_feed: taken("v_f_plunge", "tool_feedPlunge", mm, (PLUNGE_FEED, "mm/min"))?,
        feed_per_tooth: taken("f_z", "tool_feedPerTooth", mm, (FEED_PER_TOOTH, "mm a tooth"))?,
        cutting_speed: taken("v_c", "tool_surfaceSpeed", feet, (CUTTING_SPEED, "m/min"))?,
    })
}
