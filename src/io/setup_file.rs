//! The setup file: TOML; lengths in mm, angles in degrees, feed rates in mm/min, spindle speeds in rev/min.
//!
//! Every key is optional; absent keys keep the values of the default setup, [`Setup::for_part`]. An unknown
//! key is an error that names the nearest known key.
//!
//! ```toml
//! part = "impeller"          # the only part this setup applies to
//! [stock]                    # hub_allowance, blade_allowance, safety_distance, inlet_extension, material
//! hub_allowance = 0.5
//! [clearance]                # shank, holder
//! holder = 1.0
//! [[tool]]                   # see `tool_file`
//! diameter = 30.0            # the only required key of a tool
//! [plunge]                   # axis, step, row_spacing, wall_scallop, max_axis_change, max_tilt, rest
//! axis = "monotone"
//! [[plunge.section]]         # tool, from, to, feed, rest
//! tool = 1
//! from = 1.0
//! to = 0.6
//! [flank]                    # tool, layer_depth, allowed_error
//! layer_depth = 3.0
//! [machine]                  # max_axis_tilt
//! max_axis_tilt = 95.0
//! ```

use std::fmt::Write;
use std::path::Path;

use super::InputError;
use super::source::{name_of, read_bytes};
use super::table::{NumberRange, TomlDocument, TomlTable, degrees_text, nearest, quoted};
use super::tool_file::{
    ALLOWANCE, LENGTH, MAX_NUMBER, RATE, check_count, name, read_tool_tables, write_tools,
};
use crate::setup::{
    AllowanceSetup, AxisPolicy, ClearanceSetup, CutDirection, FlankSetup, FlankStrategy, PlungeSetup,
    SectionSetup, Setup, SetupPlace, Tool,
};

const ANGLE: NumberRange = NumberRange::Above(0.0, 90.0);
const HALF_TURN: NumberRange = NumberRange::Above(0.0, 180.0);

/// Maximum number of sections in a setup.
const MAX_SECTIONS: usize = 100;

/// Reads a setup file; absent keys keep the values of `defaults`.
///
/// # Errors
/// When the file cannot be read or is not a valid setup.
pub fn read_setup(path: &Path, defaults: &Setup) -> Result<Setup, InputError> {
    read_setup_with_defaults(&name_of(path), &read_bytes(path)?, defaults)
}

/// Reads a setup from bytes over [`Setup::default`]; see [`read_setup_with_defaults`].
///
/// ```
/// let setup = vanecut::io::setup_file::read_setup_bytes("my.toml", b"[stock]\nhub_allowance = 0.8")?;
/// assert_eq!(setup.allowances.hub_allowance, 0.8);
/// let error = vanecut::io::setup_file::read_setup_bytes("my.toml", b"[stock]\nhub_allowence = 1").unwrap_err();
/// assert!(error.to_string().starts_with("my.toml:2: "));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// When the bytes are not a valid setup.
pub fn read_setup_bytes(name: &str, bytes: &[u8]) -> Result<Setup, InputError> {
    read_setup_with_defaults(name, bytes, &Setup::default())
}

/// Reads a setup from bytes; `name` is the file name used in messages. Absent keys keep the values of
/// `defaults`.
///
/// # Errors
/// When the bytes are not TOML, a key is unknown, or a value is outside its range.
pub fn read_setup_with_defaults(name: &str, bytes: &[u8], defaults: &Setup) -> Result<Setup, InputError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Ok(defaults.clone());
    }
    let document = TomlDocument::new(name, bytes)?;
    let tree = document.parse()?;
    setup_of_table(&document.root(&tree), defaults)
}

/// Reads a setup from the table `root` of a document, as [`read_setup_with_defaults`] does from a file.
///
/// # Errors
/// When a key is unknown, or a value is outside its range.
pub(crate) fn setup_of_table(root: &TomlTable<'_>, defaults: &Setup) -> Result<Setup, InputError> {
    root.check_keys(&["part", "stock", "clearance", "tool", "plunge", "flank", "machine"])?;
    let mut setup =
        Setup { part: root.string("part")?.map(|part| part.value.to_owned()), ..defaults.clone() };
    if let Some(table) = root.table("stock")? {
        stock(&table, &mut setup.allowances)?;
    }
    if let Some(table) = root.table("clearance")? {
        table.check_keys(&["shank", "holder"])?;
        setup.clearances.shank = table.number_or("shank", ALLOWANCE, setup.clearances.shank)?;
        setup.clearances.holder = table.number_or("holder", ALLOWANCE, setup.clearances.holder)?;
    }
    setup.tools = read_tool_tables(root)?;
    if let Some(table) = root.table("plunge")? {
        plunge(&table, &setup.tools, &mut setup.plunge)?;
    }
    if let Some(table) = root.table("flank")? {
        flank(&table, &mut setup.flank)?;
    }
    if let Some(table) = root.table("machine")? {
        table.check_keys(&["max_axis_tilt"])?;
        if let Some(angle) = table.number("max_axis_tilt", HALF_TURN)? {
            setup.machine.max_axis_tilt_rad = angle.value.to_radians();
        }
    }
    Ok(setup)
}

/// Line of the setup file that a planning error at `place` refers to; 0 if there is none.
pub fn line_of_place(bytes: &[u8], place: &SetupPlace) -> usize {
    let found = || -> Result<Option<usize>, InputError> {
        let document = TomlDocument::new("", bytes)?;
        let tree = document.parse()?;
        let root = document.root(&tree);
        let tool_line = |number: u32| -> Result<Option<usize>, InputError> {
            for (table, place) in root.tables("tool")?.iter().zip(1..) {
                if table.whole("number", 1, MAX_NUMBER)?.map_or(place, |n| n.value) == number {
                    return Ok(Some(table.line()));
                }
            }
            Ok(None)
        };
        let plunge = root.table("plunge")?;
        Ok(match *place {
            SetupPlace::Whole => None,
            SetupPlace::Part => root.line_of("part"),
            SetupPlace::Stock(key) => root.table("stock")?.and_then(|stock| stock.line_of(key)),
            SetupPlace::Plunge(key) => plunge.and_then(|plunge| plunge.line_of(key)),
            SetupPlace::Flank(key) => root.table("flank")?.and_then(|flank| flank.line_of(key)),
            SetupPlace::Tool(number) => tool_line(number)?,
            SetupPlace::Section { index, tool } => {
                let sections = plunge.map_or(Ok(Vec::new()), |plunge| plunge.tables("section"))?;
                match sections.get(index) {
                    Some(section) => Some(section.line()),
                    None => tool_line(tool)?,
                }
            }
        })
    };
    found().ok().flatten().unwrap_or(0)
}

fn stock(table: &TomlTable<'_>, stock: &mut AllowanceSetup) -> Result<(), InputError> {
    table.check_keys(&[
        "hub_allowance",
        "blade_allowance",
        "safety_distance",
        "inlet_extension",
        "material",
    ])?;
    stock.hub_allowance = table.number_or("hub_allowance", ALLOWANCE, stock.hub_allowance)?;
    stock.blade_allowance = table.number_or("blade_allowance", ALLOWANCE, stock.blade_allowance)?;
    stock.safety_distance = table.number_or("safety_distance", ALLOWANCE, stock.safety_distance)?;
    stock.inlet_extension = table.number_or("inlet_extension", ALLOWANCE, stock.inlet_extension)?;
    stock.material = name(table, "material")?.or(stock.material.take());
    Ok(())
}

fn plunge(table: &TomlTable<'_>, tools: &[Tool], plunge: &mut PlungeSetup) -> Result<(), InputError> {
    table.check_keys(&[
        "axis",
        "step",
        "row_spacing",
        "wall_scallop",
        "max_axis_change",
        "max_tilt",
        "rest",
        "section",
    ])?;
    if let Some(axis) = table.string("axis")? {
        plunge.axis =
            parse_axis_policy(axis.value).map_err(|(what, cure)| table.fault_at(axis.at, what, cure))?;
    }
    plunge.step = table.number("step", LENGTH)?.map(|step| step.value);
    plunge.stepover = table.number("row_spacing", LENGTH)?.map(|spacing| spacing.value);
    plunge.wall_scallop = table.number_or("wall_scallop", LENGTH, plunge.wall_scallop)?;
    if let Some(angle) = table.number("max_axis_change", ANGLE)? {
        plunge.max_axis_change_rad = angle.value.to_radians();
    }
    if let Some(angle) = table.number("max_tilt", ANGLE)? {
        plunge.max_tilt_rad = angle.value.to_radians();
    }
    if let Some(rest) = table.boolean("rest")? {
        plunge.rest = rest.value;
    }
    let sections = table.tables("section")?;
    check_count(&sections, MAX_SECTIONS, "sections")?;
    plunge.sections = sections.iter().map(|table| section(table, tools)).collect::<Result<_, _>>()?;
    if let (Some(section), Some(table)) = (plunge.sections.first(), sections.first())
        && section.rest
    {
        let what = format!("{} is rest milling, but no section comes before it", table.shown());
        return Err(table.fault(what, "put it after the sections whose residual stock it removes"));
    }
    Ok(())
}

/// The axis policy with this name, from a file or the command line.
///
/// # Errors
/// When no policy has this name: what is wrong, and what to do.
pub fn parse_axis_policy(name: &str) -> Result<AxisPolicy, (String, String)> {
    match AxisPolicy::ALL.into_iter().find(|policy| policy.name() == name) {
        Some(policy) => Ok(policy),
        None => {
            let other = name;
            let near = nearest(other, &AxisPolicy::ALL.map(AxisPolicy::name));
            Err((
                format!("{} is not an axis policy", super::source::quote_for_message(other)),
                format!(
                    "use \"conventional\", \"monotone\", \"minimal\" or \"staircase\" \
                     (the nearest name is `{}`)",
                    near.unwrap_or("")
                ),
            ))
        }
    }
}

fn section(table: &TomlTable<'_>, tools: &[Tool]) -> Result<SectionSetup, InputError> {
    table.check_keys(&["tool", "from", "to", "feed", "rest"])?;
    let needed = |key: &str| {
        table.fault(format!("{} has no `{key}`", table.shown()), "give tool, from (outlet end) and to")
    };
    let tool = table.whole("tool", 1, MAX_NUMBER)?.ok_or_else(|| needed("tool"))?;
    if !tools.iter().any(|known| known.number == tool.value) {
        let numbers: Vec<String> = tools.iter().take(20).map(|tool| tool.number.to_string()).collect();
        let cure = match numbers.is_empty() {
            true => format!("add a [[tool]] with number = {}", tool.value),
            false => format!("use one of the tools {}", numbers.join(", ")),
        };
        return Err(table.fault_at(tool.at, format!("there is no tool {}", tool.value), cure));
    }
    let s = NumberRange::Between(0.0, 1.0);
    let from = table.number("from", s)?.ok_or_else(|| needed("from"))?;
    let to = table.number("to", s)?.ok_or_else(|| needed("to"))?;
    if from.value <= to.value {
        let what = format!("the section runs from {} to {}", from.value, to.value);
        let cure = "`from` is the outlet end (1 at the rim) and must be greater than `to`";
        return Err(table.fault_at(to.at, what, cure));
    }
    let feed = match table.string("feed")? {
        None => None,
        Some(feed) => Some(match feed.value {
            "inward" => CutDirection::Inward,
            "outward" => CutDirection::Outward,
            other => {
                let what = format!("{} is not a cutting direction", super::source::quote_for_message(other));
                return Err(table.fault_at(feed.at, what, "use \"inward\" or \"outward\""));
            }
        }),
    };
    let rest = table.boolean("rest")?.is_some_and(|rest| rest.value);
    Ok(SectionSetup { tool: tool.value, from: from.value, to: to.value, cut_direction: feed, rest })
}

fn flank(table: &TomlTable<'_>, flank: &mut FlankSetup) -> Result<(), InputError> {
    table.check_keys(&[
        "tool",
        "scheme",
        "layer_depth",
        "allowed_error",
        "extension",
        "feed",
        "slot_feed",
        "wall_feed",
        "ramp_feed",
    ])?;
    if let Some(scheme) = table.string("scheme")? {
        flank.strategy = parse_flank_strategy(scheme.value)
            .map_err(|(what, cure)| table.fault_at(scheme.at, what, cure))?;
    }
    // The tool number is not checked against the tools: a setup for plunging may not list the flank tool yet.
    flank.tool = table.whole("tool", 1, MAX_NUMBER)?.map(|tool| tool.value);
    flank.layer_depth = table.number_or("layer_depth", LENGTH, flank.layer_depth)?;
    flank.scallop_height = table.number_or("allowed_error", LENGTH, flank.scallop_height)?;
    flank.lead_in_out = table.number("extension", ALLOWANCE)?.map(|x| x.value);
    flank.feed_mm_per_min = table.number("feed", RATE)?.map(|x| x.value);
    flank.slot_feed_mm_per_min = table.number("slot_feed", RATE)?.map(|x| x.value);
    flank.wall_feed_mm_per_min = table.number("wall_feed", RATE)?.map(|x| x.value);
    flank.ramp_feed_mm_per_min = table.number("ramp_feed", RATE)?.map(|x| x.value);
    Ok(())
}

/// The flank milling strategy with this name.
///
/// # Errors
/// When no strategy has this name: what is wrong, and what to do.
pub fn parse_flank_strategy(name: &str) -> Result<FlankStrategy, (String, String)> {
    FlankStrategy::ALL.into_iter().find(|scheme| scheme.name() == name).ok_or_else(|| {
        let near = nearest(name, &FlankStrategy::ALL.map(FlankStrategy::name)).unwrap_or("");
        (
            format!("{} is not a flank strategy", super::source::quote_for_message(name)),
            format!(
                "use \"isoparametric\", \"layers\", \"regions\" or \"balanced\" \
                 (the nearest name is `{near}`)"
            ),
        )
    })
}

/// Writes a setup file. It reads back equal: angles that were read from degrees exactly, other angles to
/// the last bit of an f64.
pub fn write_setup(setup: &Setup) -> String {
    let mut out = String::new();
    // `write!` to a `String` cannot fail.
    let _ = write_to(&mut out, setup);
    out
}

fn write_to(out: &mut String, setup: &Setup) -> std::fmt::Result {
    if let Some(part) = &setup.part {
        writeln!(out, "part = {}\n", quoted(part))?;
    }
    let stock = &setup.allowances;
    writeln!(out, "[stock]")?;
    writeln!(out, "hub_allowance = {:?}", stock.hub_allowance)?;
    writeln!(out, "blade_allowance = {:?}", stock.blade_allowance)?;
    writeln!(out, "safety_distance = {:?}", stock.safety_distance)?;
    writeln!(out, "inlet_extension = {:?}", stock.inlet_extension)?;
    if let Some(material) = &stock.material {
        writeln!(out, "material = {}", quoted(material))?;
    }
    if setup.clearances != ClearanceSetup::default() {
        let ClearanceSetup { shank, holder } = setup.clearances;
        writeln!(out, "\n[clearance]\nshank = {shank:?}\nholder = {holder:?}")?;
    }
    write_tools(out, &setup.tools)?;
    let plunge = &setup.plunge;
    let axis = plunge.axis.name();
    writeln!(out, "\n[plunge]\naxis = \"{axis}\"")?;
    if let Some(step) = plunge.step {
        writeln!(out, "step = {step:?}")?;
    }
    if let Some(spacing) = plunge.stepover {
        writeln!(out, "row_spacing = {spacing:?}")?;
    }
    writeln!(out, "wall_scallop = {:?}", plunge.wall_scallop)?;
    writeln!(out, "max_axis_change = {}", degrees_text(plunge.max_axis_change_rad))?;
    writeln!(out, "max_tilt = {}", degrees_text(plunge.max_tilt_rad))?;
    if !plunge.rest {
        writeln!(out, "rest = false")?;
    }
    for section in &plunge.sections {
        writeln!(out, "\n[[plunge.section]]\ntool = {}", section.tool)?;
        writeln!(out, "from = {:?}\nto = {:?}", section.from, section.to)?;
        match section.cut_direction {
            Some(CutDirection::Inward) => writeln!(out, "feed = \"inward\"")?,
            Some(CutDirection::Outward) => writeln!(out, "feed = \"outward\"")?,
            None => {}
        }
        if section.rest {
            writeln!(out, "rest = true")?;
        }
    }
    writeln!(out, "\n[flank]")?;
    if let Some(tool) = setup.flank.tool {
        writeln!(out, "tool = {tool}")?;
    }
    writeln!(out, "scheme = \"{}\"", setup.flank.strategy.name())?;
    writeln!(out, "layer_depth = {:?}", setup.flank.layer_depth)?;
    writeln!(out, "allowed_error = {:?}", setup.flank.scallop_height)?;
    if let Some(extension) = setup.flank.lead_in_out {
        writeln!(out, "extension = {extension:?}")?;
    }
    let flank = &setup.flank;
    for (key, feed) in [
        ("feed", flank.feed_mm_per_min),
        ("slot_feed", flank.slot_feed_mm_per_min),
        ("wall_feed", flank.wall_feed_mm_per_min),
        ("ramp_feed", flank.ramp_feed_mm_per_min),
    ] {
        if let Some(feed) = feed {
            writeln!(out, "{key} = {feed:?}")?;
        }
    }
    if setup.machine != Setup::default().machine {
        writeln!(out, "\n[machine]\nmax_axis_tilt = {}", degrees_text(setup.machine.max_axis_tilt_rad))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = r#"part = "D 532"
[stock]
hub_allowance = 0.25
[[tool]]
number = 7
diameter = 30.0
insert_width = 10.0
overhang = 120
[[tool]]
diameter = 16
corner_radius = 0.8
[plunge]
axis = "conventional"
step = 8.0
max_axis_change = 4.3
max_tilt = 30
wall_scallop = 0.4
rest = false
[[plunge.section]]
tool = 7
from = 1.0
to = 0.6
feed = "outward"
[[plunge.section]]
tool = 2
from = 0.6
to = 0.0
rest = true
[flank]
tool = 4
"#;

    fn read(text: &str) -> Result<Setup, InputError> {
        read_setup_bytes("s.toml", text.as_bytes())
    }

    #[test]
    fn an_empty_file_is_the_default() {
        assert_eq!(read(" \n").unwrap(), Setup::default());
        assert_eq!(read("# nothing\n").unwrap(), Setup::default());
        assert_eq!(read(&write_setup(&Setup::default())).unwrap(), Setup::default());
    }

    #[test]
    fn reads_every_key_and_fills_in_the_rest() {
        let setup = read(SAMPLE).unwrap();
        assert_eq!(setup.part.as_deref(), Some("D 532"));
        assert_eq!((setup.allowances.hub_allowance, setup.allowances.blade_allowance), (0.25, 0.5));
        assert_eq!((setup.tools[0].number, setup.tools[0].core_radius()), (7, 5.0));
        let second = Tool {
            number: 2,
            diameter: 16.0,
            corner_radius: 0.8,
            insert_width: 7.2,
            overhang: 64.0,
            plunge_feed: 300.0,
            spindle: 1200.0,
            assembly: Default::default(),
        };
        assert_eq!(setup.tools[1], second);
        assert_eq!(setup.plunge.axis, AxisPolicy::Conventional);
        assert_eq!((setup.plunge.step, setup.plunge.stepover), (Some(8.0), None));
        assert_eq!(setup.plunge.max_tilt_rad, 30f64.to_radians());
        assert_eq!(setup.plunge.sections[0].cut_direction, Some(CutDirection::Outward));
        assert_eq!((setup.plunge.rest, setup.plunge.sections[0].rest), (false, false));
        assert!(setup.plunge.sections[1].rest);
        assert_eq!((setup.flank.tool, setup.flank.layer_depth), (Some(4), 3.0));
    }

    #[test]
    fn a_written_setup_reads_back_equal() {
        let setup = read(SAMPLE).unwrap();
        assert_eq!(read(&write_setup(&setup)).unwrap(), setup);
    }

    #[test]
    fn faults_name_their_line() {
        for (from, to, line, words) in [
            ("hub_allowance = 0.25", "hub_allowance = -0.1", 3, "0 to"),
            ("hub_allowance = 0.25", "hub_allowance = nan", 3, "not a finite number"),
            ("hub_allowance = 0.25", "hub_allowance = \"x\"", 3, "not a number"),
            ("hub_allowance", "hub_alowance", 3, "`hub_allowance`"),
            ("[stock]", "[stok]", 2, "`stock`"),
            ("number = 7", "number = 0", 5, "whole number"),
            ("number = 7", "number = 2", 9, "two tools have the number 2"),
            ("diameter = 30.0", "diameter = 0", 6, "greater than 0"),
            ("diameter = 30.0", "diameter = -30", 6, "greater than 0"),
            ("diameter = 30.0", "", 4, "no `diameter`"),
            ("insert_width = 10.0", "insert_width = 15.1", 7, "at most 15"),
            ("corner_radius = 0.8", "corner_radius = 8.5", 11, "at most 8"),
            ("overhang = 120", "overhang = 1e300", 8, "larger than"),
            ("\"conventional\"", "\"monotnoe\"", 13, "`monotone`"),
            ("step = 8.0", "step = 0", 14, "greater than 0"),
            ("max_axis_change = 4.3", "max_axis_change = 91", 15, "at most 90"),
            ("max_tilt = 30", "max_tilt = -1", 16, "greater than 0"),
            ("tool = 7", "tool = 3", 20, "there is no tool 3; use one of the tools 7, 2"),
            ("to = 0.6", "to = 1.0", 22, "outlet end"),
            ("from = 1.0", "from = 1.5", 21, "from 0 to 1"),
            ("\"outward\"", "\"sideways\"", 23, "inward"),
            ("rest = false", "rest = 0", 18, "true or false"),
            ("outward\"", "outward\"\nrest = true", 19, "no section comes before it"),
            ("[[plunge.section]]", "[plunge.section]", 19, "TOML"),
        ] {
            assert!(SAMPLE.contains(from), "{from} must be in the sample");
            let error = read(&SAMPLE.replacen(from, to, 1)).expect_err(to);
            let shown = error.to_string();
            assert!(shown.contains(words), "{from} → {to}: {shown}");
            assert!(error.line.abs_diff(line) <= usize::from(words == "TOML") * 5, "{to}: {shown}");
        }
    }
}
