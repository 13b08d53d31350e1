//! The `[[tool]]` tables of setups and of tool libraries.
//!
//! ```toml
//! [[tool]]
//! number = 1                 # default: position in the list
//! diameter = 30.0            # the only required key
//! corner_radius = 0.0
//! insert_width = 13.5        # default 0.9 R: core radius 0.1 R
//! overhang = 120.0           # default 4 D
//! plunge_feed = 300.0        # default feed_per_tooth × teeth × spindle, or by the material, or 300
//! spindle = 1200             # default from cutting_speed, or by the material, or 1200
//! name = "D30 Z3"
//! description = "for inserts of 10 mm"
//! material = "carbide"       # of its edges
//! flute_length = 20.0
//! teeth = 3
//! taper = 0.0                # half angle, degrees
//! shank = [[27, 60], [25, 20]]           # [diameter, length], from the cutter towards the spindle
//! holder = [[40, 50, 30], [50, 50, 40]]  # [lower diameter, upper diameter, length]
//! length_offset = 1          # numbers of offsets in the control
//! diameter_offset = 1
//! feed_per_tooth = 0.1       # mm
//! cutting_speed = 180        # m/min
//! ```

use std::collections::HashSet;
use std::fmt::Write;

use super::InputError;
use super::table::{Located, NumberRange, TomlDocument, TomlTable, degrees_text, quoted};
use crate::error::ErrorCode;
use crate::setup::cutting_data::{CuttingData, PLUNGE_FEED_RANGE, SPINDLE_RANGE, usual_feed, usual_spindle};
use crate::setup::{MissingRates, Tool, ToolAssembly};

/// Maximum length in a setup, mm.
pub const MAX_LENGTH: f64 = 10_000.0;
/// Range of lengths.
pub const LENGTH: NumberRange = NumberRange::Above(0.0, MAX_LENGTH);
/// Range of allowances and clearances.
pub const ALLOWANCE: NumberRange = NumberRange::Between(0.0, MAX_LENGTH);
/// Range of feed rates, speeds, spindle speeds and removal rates.
pub const RATE: NumberRange = NumberRange::Above(0.0, 1e6);
/// Maximum number of a tool or an offset.
pub const MAX_NUMBER: u32 = 1_000_000;
/// Maximum number of tools in a setup or library. Makers' libraries hold some ten thousand.
pub const MAX_TOOLS: usize = 50_000;
/// Maximum number of teeth.
pub const MAX_TEETH: u32 = 200;
/// Maximum number of segments of a shank or holder.
pub const MAX_SEGMENTS: usize = 50;
/// Maximum number of characters of a name, a description or a material.
pub const MAX_NAME: usize = 200;
/// Range of half angles of tapered cutters, degrees.
const TAPER: NumberRange = NumberRange::Between(0.0, 60.0);
/// Range of feed per tooth, mm: beyond it a number or its unit is wrong.
pub const FEED_PER_TOOTH: NumberRange = NumberRange::Between(1e-4, 5.0);
/// The same of the cutting speed, m/min.
pub const CUTTING_SPEED: NumberRange = NumberRange::Between(0.1, 1e4);
/// The same of the plunge feed, mm/min.
pub const PLUNGE_FEED: NumberRange = NumberRange::Between(PLUNGE_FEED_RANGE[0], PLUNGE_FEED_RANGE[1]);
/// The same of the spindle speed, rev/min.
pub const SPINDLE: NumberRange = NumberRange::Between(SPINDLE_RANGE[0], SPINDLE_RANGE[1]);

/// Keys of a tool, each with its unit; empty where it has none.
pub(super) const TOOL_KEYS: [(&str, &str); 19] = [
    ("number", ""),
    ("diameter", "mm"),
    ("corner_radius", "mm"),
    ("insert_width", "mm"),
    ("overhang", "mm"),
    ("plunge_feed", "mm/min"),
    ("spindle", "rev/min"),
    ("name", ""),
    ("description", ""),
    ("material", ""),
    ("flute_length", "mm"),
    ("teeth", ""),
    ("taper", "°"),
    ("shank", "mm"),
    ("holder", "mm"),
    ("length_offset", ""),
    ("diameter_offset", ""),
    ("feed_per_tooth", "mm"),
    ("cutting_speed", "m/min"),
];

/// Reads a tool library: a file with only `[[tool]]` tables, in the format of a setup.
///
/// # Errors
/// When the bytes are not TOML, a key is unknown, or a value is outside its range.
pub fn read_tools_bytes(name: &str, bytes: &[u8]) -> Result<Vec<Tool>, InputError> {
    let document = TomlDocument::new(name, bytes, ErrorCode::ToolFile)?;
    let tree = document.parse()?;
    let root = document.root(&tree);
    root.check_keys(&["tool"])?;
    read_tool_tables(&root, None)
}

/// The `[[tool]]` tables, in file order; what they do not say of speeds and feeds is by the cutting data of
/// `material`, if given.
pub(super) fn read_tool_tables(
    root: &TomlTable<'_>,
    material: Option<&CuttingData>,
) -> Result<Vec<Tool>, InputError> {
    let tables = root.tables("tool")?;
    check_count(&tables, MAX_TOOLS, "tools")?;
    let mut numbers = HashSet::with_capacity(tables.len());
    tables.iter().map(|table| tool(table, &mut numbers, material)).collect()
}

/// Returns an error at the first table beyond `max_count`.
pub(super) fn check_count(tables: &[TomlTable<'_>], max_count: usize, what: &str) -> Result<(), InputError> {
    match tables.get(max_count) {
        Some(table) => Err(table
            .fault(format!("more than {max_count} {what}"), format!("give at most {max_count}"))
            .with_code(ErrorCode::FileTooLarge)),
        None => Ok(()),
    }
}

/// A name, if the key is present.
pub(super) fn name(table: &TomlTable<'_>, key: &str) -> Result<Option<String>, InputError> {
    let Some(text) = table.string(key)? else { return Ok(None) };
    if text.value.chars().count() > MAX_NAME {
        let what = format!("`{key}` has more than {MAX_NAME} characters");
        return Err(table.fault_at(text.at, what, "give a shorter one"));
    }
    Ok(Some(text.value.to_owned()))
}

/// Reads one tool; `numbers` are those of the tools before it.
fn tool(
    table: &TomlTable<'_>,
    numbers: &mut HashSet<u32>,
    material: Option<&CuttingData>,
) -> Result<Tool, InputError> {
    table.check_keys(&TOOL_KEYS.map(|(key, _)| key))?;
    let given = table.whole("number", 1, MAX_NUMBER)?;
    let number = given.map_or(numbers.len() as u32 + 1, |n| n.value);
    let at = |at: Option<usize>, what: String, help: &str| match at {
        Some(at) => table.fault_at(at, what, help),
        None => table.fault(what, help).with_code(ErrorCode::ConflictingKeys),
    };
    if !numbers.insert(number) {
        let what = format!("two tools have the number {number}");
        return Err(at(given.map(|n| n.at), what, "give each tool its own number"));
    }
    let diameter = table
        .number("diameter", LENGTH)?
        .ok_or_else(|| {
            table
                .fault(format!("tool {number} has no `diameter`"), "add diameter = … in mm")
                .with_code(ErrorCode::MissingKey)
        })?
        .value;
    let radius = diameter / 2.0;
    let within_radius = |key: &str, range: NumberRange, default: f64| {
        let value = table.number(key, range)?;
        match value.filter(|v| v.value > radius) {
            Some(v) => {
                let what = format!("`{key}` {} is larger than the radius {radius}", v.value);
                Err(table
                    .fault_at(v.at, what, format!("give at most {radius}"))
                    .with_code(ErrorCode::ValueRange))
            }
            None => Ok(value.map_or(default, |v| v.value)),
        }
    };
    let overhang = table.number_or("overhang", NumberRange::Above(0.0, 10.0 * MAX_LENGTH), 4.0 * diameter)?;
    let mut assembly = assembly(table, overhang)?;
    let spindle = match table.number("spindle", SPINDLE)? {
        Some(given) => (given.value, false),
        None => {
            let speed = usual_spindle(diameter, &assembly, material);
            let what = format!("`cutting_speed` makes {speed:.3e} rev/min of a diameter of {diameter}");
            within(table, SPINDLE, speed, (what, "spindle"))?
        }
    };
    let feed = match table.number("plunge_feed", PLUNGE_FEED)? {
        Some(given) => (given.value, false),
        None => {
            let feed = usual_feed(diameter, &assembly, spindle.0, material);
            let what = format!("feed per tooth, teeth and spindle make a feed rate of {feed:.3e} mm/min");
            within(table, PLUNGE_FEED, feed, (what, "plunge_feed"))?
        }
    };
    assembly.missing_rates = MissingRates { plunge_feed: feed.1, spindle: spindle.1 };
    Ok(Tool {
        number,
        diameter,
        corner_radius: within_radius("corner_radius", ALLOWANCE, 0.0)?,
        insert_width: within_radius("insert_width", LENGTH, 0.9 * radius)?,
        overhang,
        plunge_feed: feed.0,
        spindle: spindle.0,
        assembly,
    })
}

/// A rate that follows from others, marked as not given.
fn within(
    table: &TomlTable<'_>,
    range: NumberRange,
    value: f64,
    (what, key): (String, &str),
) -> Result<(f64, bool), InputError> {
    match range.check(value) {
        Ok(()) => Ok((value, true)),
        Err(_) => {
            Err(table.fault(what, format!("correct them, or give {key}")).with_code(ErrorCode::ValueRange))
        }
    }
}

/// Shank, holder and library data of a tool whose holder begins `overhang` mm above the tip.
fn assembly(table: &TomlTable<'_>, overhang: f64) -> Result<ToolAssembly, InputError> {
    let flute_length = table.number("flute_length", LENGTH)?;
    if let Some(flute) = flute_length.as_ref().filter(|flute| flute.value > overhang) {
        let what = format!("`flute_length` {} is longer than the overhang {overhang}", flute.value);
        return Err(table.fault_at(flute.at, what, "give a longer overhang, or shorter flutes"));
    }
    let shank = segments::<2>(table, "shank", |[diameter, length]| {
        LENGTH.check(diameter).and(LENGTH.check(length)).map_err(|help| format!("both numbers: {help}"))
    })?;
    let total: f64 = shank.value.iter().map(|[_, length]| length).sum();
    if flute_length.is_none() && total >= overhang {
        let what =
            format!("the shank is {total} long, and no flute length is left of the overhang {overhang}");
        return Err(table.fault_at(
            shank.at,
            what,
            "give flute_length, a shorter shank or a longer overhang",
        ));
    }
    let holder = segments::<3>(table, "holder", |[lower, upper, length]| {
        let diameters = LENGTH.check(lower).and(LENGTH.check(upper));
        diameters.and(LENGTH.check(length)).map_err(|help| format!("all three numbers: {help}"))
    })?;
    Ok(ToolAssembly {
        name: name(table, "name")?,
        description: name(table, "description")?,
        material: name(table, "material")?,
        flute_length: flute_length.map(|x| x.value),
        teeth: table.whole("teeth", 1, MAX_TEETH)?.map(|n| n.value),
        taper_rad: table.number("taper", TAPER)?.map(|angle| angle.value.to_radians()),
        shank: shank.value,
        holder: holder.value,
        length_offset: table.whole("length_offset", 0, MAX_NUMBER)?.map(|n| n.value),
        diameter_offset: table.whole("diameter_offset", 0, MAX_NUMBER)?.map(|n| n.value),
        feed_per_tooth: table.number("feed_per_tooth", FEED_PER_TOOTH)?.map(|x| x.value),
        cutting_speed: table.number("cutting_speed", CUTTING_SPEED)?.map(|x| x.value),
        missing_rates: MissingRates::default(),
    })
}

/// The rows of `shank` or `holder`, checked one by one; empty when the key is absent.
fn segments<const N: usize>(
    table: &TomlTable<'_>,
    key: &str,
    check: impl Fn([f64; N]) -> Result<(), String>,
) -> Result<Located<Vec<[f64; N]>>, InputError> {
    let Some(rows) = table.rows::<N>(key)? else { return Ok(Located { value: Vec::new(), at: 0 }) };
    if rows.value.len() > MAX_SEGMENTS {
        let what = format!("`{key}` has more than {MAX_SEGMENTS} segments");
        return Err(table
            .fault_at(rows.at, what, format!("give at most {MAX_SEGMENTS}"))
            .with_code(ErrorCode::FileTooLarge));
    }
    for (index, row) in rows.value.iter().enumerate() {
        check(row.value).map_err(|help| {
            let what = format!("segment {} of `{key}` is {:?}", index + 1, row.value);
            table.fault_at(row.at, what, help).with_code(ErrorCode::ValueRange)
        })?;
    }
    Ok(Located { value: rows.value.iter().map(|row| row.value).collect(), at: rows.at })
}

/// Which rates of tools are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WrittenRates {
    /// Those that are given: others follow from material and cutting data again when they are read.
    Given,
    /// All, for what must not change with cutting data.
    All,
}

/// Writes `[[tool]]` tables.
pub(super) fn write_tools(out: &mut String, tools: &[Tool], rates: WrittenRates) -> std::fmt::Result {
    for tool in tools {
        writeln!(out, "\n[[tool]]")?;
        write_tool(out, tool, rates)?;
    }
    Ok(())
}

/// Writes the keys of one tool.
pub(super) fn write_tool(out: &mut String, tool: &Tool, rates: WrittenRates) -> std::fmt::Result {
    let missing = match rates {
        WrittenRates::Given => tool.assembly.missing_rates,
        WrittenRates::All => MissingRates::default(),
    };
    writeln!(out, "number = {}", tool.number)?;
    writeln!(out, "diameter = {:?}", tool.diameter)?;
    writeln!(out, "corner_radius = {:?}", tool.corner_radius)?;
    writeln!(out, "insert_width = {:?}", tool.insert_width)?;
    writeln!(out, "overhang = {:?}", tool.overhang)?;
    if !missing.plunge_feed {
        writeln!(out, "plunge_feed = {:?}", tool.plunge_feed)?;
    }
    if !missing.spindle {
        writeln!(out, "spindle = {:?}", tool.spindle)?;
    }
    let more = &tool.assembly;
    let texts = [("name", &more.name), ("description", &more.description), ("material", &more.material)];
    for (key, text) in texts {
        if let Some(text) = text {
            writeln!(out, "{key} = {}", quoted(text))?;
        }
    }
    let numbers = [
        ("flute_length", more.flute_length),
        ("feed_per_tooth", more.feed_per_tooth),
        ("cutting_speed", more.cutting_speed),
    ];
    for (key, value) in numbers {
        if let Some(value) = value {
            writeln!(out, "{key} = {value:?}")?;
        }
    }
    let counts = [
        ("teeth", more.teeth),
        ("length_offset", more.length_offset),
        ("diameter_offset", more.diameter_offset),
    ];
    for (key, value) in counts {
        if let Some(value) = value {
            writeln!(out, "{key} = {value}")?;
        }
    }
    if let Some(taper) = more.taper_rad {
        writeln!(out, "taper = {}", degrees_text(taper))?;
    }
    if !more.shank.is_empty() {
        writeln!(out, "shank = {:?}", more.shank)?;
    }
    if !more.holder.is_empty() {
        writeln!(out, "holder = {:?}", more.holder)?;
    }
    Ok(())
}
