//! The setup file: TOML; lengths in mm, angles in degrees, feed rates in mm/min, spindle speeds in rev/min.
//!
//! Every key is optional; absent keys keep the values of the default setup, [`Setup::for_part`]. An unknown
//! key is an error that names the nearest known key.
//!
//! ```toml
//! version = 2                # of the file format; absent: that of the program
//! part = "impeller"          # the only part this setup applies to
//! [stock]                    # hub_allowance, blade_allowance, safety_distance, inlet_extension, blank,
//!                            # material
//! hub_allowance = 0.5
//! [clearance]                # shank, holder
//! holder = 1.0
//! [[tool]]                   # see `tool_file`
//! diameter = 30.0            # the only required key of a tool
//! [plunge]                   # axis, step, stepover, wall_scallop, max_axis_change, max_tilt, rest,
//!                            # goal, max_stock, max_time, lift, peck, adapt_feed
//! axis = "monotone"
//! [[plunge.section]]         # tool, from, to, cutting_direction, rest
//! tool = 1
//! from = 1.0
//! to = 0.6
//! [flank]                    # tool, layer_depth, scallop_height
//! layer_depth = 3.0
//! [machine]                  # file, max_axis_tilt
//! max_axis_tilt = 95.0
//! ```

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::InputError;
use super::blank_file::{blank_name, is_stl, read_blank, read_blank_file};
use super::machine_file::{built_in_names, read_machine};
use super::source::{name_of, quote_for_message, read_bytes};
use super::table::{NumberRange, RenamedKeys, TomlDocument, TomlTable, degrees_text, nearest, quoted};
use super::tool_file::{
    ALLOWANCE, LENGTH, MAX_NUMBER, RATE, check_count, name, read_tool_tables, write_tools,
};
use crate::error::{ErrorCode, UserError};
use crate::part::{BlankFile, BlankShape, Meridional, MeridionalOutline};
use crate::setup::{
    AllowanceSetup, AxisPolicy, ClearanceSetup, CutDirection, FlankSetup, FlankStrategy, Goal, Machine,
    PlungeSetup, SectionKind, SectionSetup, Setup, SetupPlace, Tool,
};

const MINUTES: NumberRange = NumberRange::Above(0.0, 100_000.0);
const ANGLE: NumberRange = NumberRange::Above(0.0, 90.0);
/// Smallest tilt that a machine must reach for a plan, rad.
const MIN_AXIS_TILT: f64 = 0.02;
const HALF_TURN: NumberRange = NumberRange::Above(0.0, 180.0);

/// Version of the file format, key `version`: 2 since keys were renamed. Newer files are rejected.
const VERSION: u32 = 2;
/// `[plunge]`, `[[plunge.section]]` and `[flank]`: keys that were renamed in version 2.
const RENAMED_IN_PLUNGE: RenamedKeys = &[("stepover", "row_spacing")];
const RENAMED_IN_SECTION: RenamedKeys = &[("cutting_direction", "feed")];
const RENAMED_IN_FLANK: RenamedKeys = &[("scallop_height", "allowed_error")];

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
/// let typo = b"[stock]\nhub_allowence = 1";
/// let error = vanecut::io::setup_file::read_setup_bytes("my.toml", typo).unwrap_err();
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
    let document = TomlDocument::new(name, bytes, ErrorCode::SetupFile)?;
    let tree = document.parse()?;
    setup_of_table(&document.root(&tree), defaults)
}

/// Reads a setup from the table `root` of a document, as [`read_setup_with_defaults`] does from a file.
///
/// # Errors
/// When a key is unknown, or a value is outside its range.
pub(crate) fn setup_of_table(root: &TomlTable<'_>, defaults: &Setup) -> Result<Setup, InputError> {
    root.check_keys(&["version", "part", "stock", "clearance", "tool", "plunge", "flank", "machine"])?;
    if let Some(version) = root.whole("version", 1, u32::MAX)?
        && version.value > VERSION
    {
        let what = format!("the setup has version {}, this program reads up to {VERSION}", version.value);
        return Err(root
            .fault_at(version.at, what, "read it with a newer vanecut")
            .with_code(ErrorCode::NewerFile));
    }
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
    setup.tools = read_tool_tables(root, setup.allowances.cutting_data())?;
    if let Some(table) = root.table("plunge")? {
        plunge(&table.with_renamed_keys(RENAMED_IN_PLUNGE), &setup.tools, &mut setup.plunge)?;
    }
    if let Some(table) = root.table("flank")? {
        flank(&table.with_renamed_keys(RENAMED_IN_FLANK), &mut setup.flank)?;
    }
    if let Some(table) = root.table("machine")? {
        machine(&table, &mut setup.machine)?;
    }
    Ok(setup)
}

/// Line of the setup file that a planning error at `place` refers to; 0 if there is none.
pub fn line_of_place(bytes: &[u8], place: &SetupPlace) -> usize {
    let found = || -> Result<Option<usize>, InputError> {
        let document = TomlDocument::new("", bytes, ErrorCode::SetupFile)?;
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
        let plunge = root.table("plunge")?.map(|table| table.with_renamed_keys(RENAMED_IN_PLUNGE));
        let flank = root.table("flank")?.map(|table| table.with_renamed_keys(RENAMED_IN_FLANK));
        Ok(match *place {
            SetupPlace::Whole => None,
            SetupPlace::Part => root.line_of("part"),
            SetupPlace::Stock(key) => root.table("stock")?.and_then(|stock| stock.line_of(key)),
            SetupPlace::Plunge(key) => plunge.and_then(|plunge| plunge.line_of(key)),
            SetupPlace::Flank(key) => flank.and_then(|flank| flank.line_of(key)),
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
        "blank",
        "blank_outline",
        "material",
    ])?;
    stock.hub_allowance = table.number_or("hub_allowance", ALLOWANCE, stock.hub_allowance)?;
    stock.blade_allowance = table.number_or("blade_allowance", ALLOWANCE, stock.blade_allowance)?;
    stock.safety_distance = table.number_or("safety_distance", ALLOWANCE, stock.safety_distance)?;
    stock.inlet_extension = table.number_or("inlet_extension", ALLOWANCE, stock.inlet_extension)?;
    if let Some(shape) = blank(table)? {
        stock.blank = shape;
    }
    stock.material = name(table, "material")?.or(stock.material.take());
    Ok(())
}

/// Reads the shape of the blank. With `blank_outline` beside the file that is the outline, and the file is
/// not needed: setups within plans stay readable where it is not. Its mesh is taken where it still has that
/// outline.
fn blank(table: &TomlTable<'_>) -> Result<Option<BlankShape>, InputError> {
    let rows = table.rows::<2>("blank_outline")?;
    let Some(name) = table.string("blank")? else {
        return match rows {
            None => Ok(None),
            Some(rows) => {
                let what = "`blank_outline` is given without the file in `blank`";
                Err(table.fault_at(rows.at, what, "add `blank`, or remove `blank_outline`"))
            }
        };
    };
    if let Some(rows) = rows {
        let points: Vec<Meridional> =
            rows.value.iter().map(|row| Meridional { r: row.value[0], z: row.value[1] }).collect();
        let outline = MeridionalOutline::new(&points).map_err(|fault| {
            let UserError { message, help, .. } = fault.explained();
            table.fault_at(rows.at, format!("`blank_outline`: {message}"), help)
        })?;
        let path = table.folder().join(name.value);
        let is_mesh = is_stl(&path) && path.is_file();
        let known = is_mesh.then(|| read_blank_file(name.value, &path).ok()).flatten();
        let mesh = known.filter(|file| file.outline == outline).and_then(|file| file.mesh);
        let file = BlankFile { name: name.value.to_owned(), path, outline, mesh };
        return Ok(Some(BlankShape::File(Arc::new(file))));
    }
    let shape = read_blank(name.value, table.folder())?;
    let missing = || {
        let what = format!("no blank file {}", quote_for_message(name.value));
        let help = "give \"edges\", \"turned\", or a file (.stl, or lines of r z)";
        table.fault_at(name.at, what, help).with_code(ErrorCode::UnknownName)
    };
    Ok(Some(shape.ok_or_else(missing)?))
}

fn plunge(table: &TomlTable<'_>, tools: &[Tool], plunge: &mut PlungeSetup) -> Result<(), InputError> {
    table.check_keys(&[
        "axis",
        "step",
        "stepover",
        "wall_scallop",
        "max_axis_change",
        "max_tilt",
        "goal",
        "max_stock",
        "max_time",
        "lift",
        "peck",
        "adapt_feed",
        "rest",
        "section",
    ])?;
    if let Some(axis) = table.string("axis")? {
        plunge.axis = parse_axis_policy(axis.value).map_err(|error| table.locate(axis.at, error))?;
    }
    plunge.step = table.number("step", LENGTH)?.map(|step| step.value);
    plunge.stepover = table.number("stepover", LENGTH)?.map(|stepover| stepover.value);
    plunge.wall_scallop = table.number_or("wall_scallop", LENGTH, plunge.wall_scallop)?;
    if let Some(angle) = table.number("max_axis_change", ANGLE)? {
        plunge.max_axis_change_rad = angle.value.to_radians();
    }
    if let Some(angle) = table.number("max_tilt", ANGLE)? {
        plunge.max_tilt_rad = angle.value.to_radians();
    }
    plunge.goal = goal(table)?.unwrap_or(plunge.goal);
    plunge.lift = table.number("lift", ALLOWANCE)?.map(|lift| lift.value).filter(|lift| *lift > 0.0);
    plunge.peck = table.number("peck", LENGTH)?.map(|peck| peck.value);
    if let Some(adapt) = table.boolean("adapt_feed")? {
        plunge.adapt_feed = adapt.value;
    }
    if let Some(rest) = table.boolean("rest")? {
        plunge.rest = rest.value;
    }
    let sections: Vec<_> =
        table.tables("section")?.into_iter().map(|t| t.with_renamed_keys(RENAMED_IN_SECTION)).collect();
    check_count(&sections, MAX_SECTIONS, "sections")?;
    plunge.sections = sections.iter().map(|table| section(table, tools)).collect::<Result<_, _>>()?;
    check_section_order(&plunge.sections, &sections)
}

/// Checks that sections above the shroud come first, and those for the rest after others.
fn check_section_order(sections: &[SectionSetup], tables: &[TomlTable<'_>]) -> Result<(), InputError> {
    let is_opening = |section: &SectionSetup| section.kind == SectionKind::Opening;
    let first = sections.iter().position(|section| !is_opening(section)).unwrap_or(sections.len());
    let wrong = |index: usize, what: &str, help: &str| {
        let table = &tables[index];
        Err(table.fault(format!("{} {what}", table.shown()), help).with_code(ErrorCode::SectionOrder))
    };
    if sections.get(first).is_some_and(|section| section.kind == SectionKind::Rest) {
        let help = "put it after the sections whose residual stock it removes";
        return wrong(first, "is rest milling, but no section comes before it", help);
    }
    match sections.iter().skip(first).position(is_opening) {
        Some(after) => wrong(
            first + after,
            "is above the shroud, but comes after one that is not",
            "put it first: the tools of the others pass through what it removes",
        ),
        None => Ok(()),
    }
}

/// Reads `[machine]`. A machine without `max_axis_tilt` beside it gives its own; with both the file is not
/// read: setups within plans stay readable where the machine file is not.
fn machine(table: &TomlTable<'_>, machine: &mut Machine) -> Result<(), InputError> {
    table.check_keys(&["file", "max_axis_tilt"])?;
    let file = table.string("file")?;
    if let Some(angle) = table.number("max_axis_tilt", HALF_TURN)? {
        machine.max_axis_tilt_rad = angle.value.to_radians();
    } else if let Some(file) = &file {
        let is_built_in = built_in_names().any(|name| name == file.value);
        let path = if is_built_in { PathBuf::from(file.value) } else { table.folder().join(file.value) };
        if !is_built_in && !path.is_file() {
            let known: Vec<&str> = built_in_names().collect();
            let what = format!("no machine file {}", quote_for_message(file.value));
            let help = format!("give a file beside the setup, or {}", known.join(", "));
            return Err(table.fault_at(file.at, what, help).with_code(ErrorCode::FileUnreadable));
        }
        machine.max_axis_tilt_rad = read_machine(&path)?.max_axis_tilt_rad();
        if machine.max_axis_tilt_rad < MIN_AXIS_TILT {
            let what = format!("{} does not reach the part's axis", quote_for_message(file.value));
            return Err(table.fault_at(
                file.at,
                what,
                "lay the part the other way round, or give max_axis_tilt",
            ));
        }
    }
    machine.file = file.map(|file| file.value.to_owned()).or(machine.file.take());
    Ok(())
}

/// Reads what a plan is for; `None` where the table does not say.
fn goal(table: &TomlTable<'_>) -> Result<Option<Goal>, InputError> {
    let (stock, time) = (table.number("max_stock", LENGTH)?, table.number("max_time", MINUTES)?);
    let max_time_min = time.map(|minutes| minutes.value);
    let Some(goal) = table.string("goal")? else {
        return match stock {
            Some(stock) => {
                let what = "`max_stock` is given without `goal = \"time\"`";
                Err(table
                    .fault_at(stock.at, what, "add the goal, or remove `max_stock`")
                    .with_code(ErrorCode::ConflictingKeys))
            }
            None => Ok(max_time_min.map(|_| Goal::Stock { max_time_min })),
        };
    };
    let limit = |name: &str, given: bool| match given {
        true => Err(table
            .fault_at(goal.at, format!("`{name}` does not fit this goal"), format!("remove `{name}`"))
            .with_code(ErrorCode::ConflictingKeys)),
        false => Ok(()),
    };
    Ok(Some(match goal.value {
        "stock" => {
            limit("max_stock", stock.is_some())?;
            Goal::Stock { max_time_min }
        }
        "time" => {
            limit("max_time", time.is_some())?;
            let needed = || {
                table
                    .fault_at(goal.at, "the goal \"time\" needs a limit of stock", "add `max_stock`")
                    .with_code(ErrorCode::MissingKey)
            };
            Goal::Time { max_stock: stock.ok_or_else(needed)?.value }
        }
        "balance" => {
            limit("max_stock", stock.is_some())?;
            limit("max_time", time.is_some())?;
            Goal::Balance
        }
        other => {
            let what = format!("{} is not a goal", quote_for_message(other));
            return Err(table
                .fault_at(goal.at, what, "use \"stock\", \"time\" or \"balance\"")
                .with_code(ErrorCode::UnknownName));
        }
    }))
}

/// The axis policy with this name, from a file or the command line.
///
/// # Errors
/// When no policy has this name: what is wrong, and what to do.
pub fn parse_axis_policy(name: &str) -> Result<AxisPolicy, UserError> {
    match AxisPolicy::ALL.into_iter().find(|policy| policy.name() == name) {
        Some(policy) => Ok(policy),
        None => {
            let other = name;
            let near = nearest(other, &AxisPolicy::ALL.map(AxisPolicy::name));
            Err(UserError::new(
                ErrorCode::UnknownName,
                format!("{} is not an axis policy", quote_for_message(other)),
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
    table.check_keys(&["tool", "from", "to", "cutting_direction", "rest", "opening"])?;
    let needed = |key: &str| {
        table
            .fault(format!("{} has no `{key}`", table.shown()), "give tool, from (outlet end) and to")
            .with_code(ErrorCode::MissingKey)
    };
    let tool = table.whole("tool", 1, MAX_NUMBER)?.ok_or_else(|| needed("tool"))?;
    if !tools.iter().any(|known| known.number == tool.value) {
        let numbers: Vec<String> = tools.iter().take(20).map(|tool| tool.number.to_string()).collect();
        let help = match numbers.is_empty() {
            true => format!("add a [[tool]] with number = {}", tool.value),
            false => format!("use one of the tools {}", numbers.join(", ")),
        };
        return Err(table
            .fault_at(tool.at, format!("there is no tool {}", tool.value), help)
            .with_code(ErrorCode::UndefinedTool));
    }
    let s = NumberRange::Between(0.0, 1.0);
    let from = table.number("from", s)?.ok_or_else(|| needed("from"))?;
    let to = table.number("to", s)?.ok_or_else(|| needed("to"))?;
    if from.value <= to.value {
        let what = format!("the section runs from {} to {}", from.value, to.value);
        let help = "`from` is the outlet end (1 at the rim) and must be greater than `to`";
        return Err(table.fault_at(to.at, what, help).with_code(ErrorCode::SectionOrder));
    }
    let cut_direction = match table.string("cutting_direction")? {
        None => None,
        Some(direction) => Some(match direction.value {
            "outlet_to_inlet" | "inward" => CutDirection::OutletToInlet,
            "inlet_to_outlet" | "outward" => CutDirection::InletToOutlet,
            other => {
                let what = format!("{} is not a cutting direction", quote_for_message(other));
                let help = "use \"outlet_to_inlet\" or \"inlet_to_outlet\"";
                return Err(table.fault_at(direction.at, what, help).with_code(ErrorCode::UnknownName));
            }
        }),
    };
    let rest = table.boolean("rest")?.is_some_and(|rest| rest.value);
    let opening = table.boolean("opening")?.filter(|opening| opening.value);
    let kind = match (rest, opening) {
        (true, Some(opening)) => {
            let what = "a section is either for the rest or above the shroud";
            return Err(table.fault_at(opening.at, what, "remove `rest` or `opening`"));
        }
        (true, None) => SectionKind::Rest,
        (false, Some(_)) => SectionKind::Opening,
        (false, None) => SectionKind::Rows,
    };
    Ok(SectionSetup { tool: tool.value, from: from.value, to: to.value, cut_direction, kind })
}

fn flank(table: &TomlTable<'_>, flank: &mut FlankSetup) -> Result<(), InputError> {
    table.check_keys(&[
        "tool",
        "scheme",
        "layer_depth",
        "scallop_height",
        "extension",
        "feed",
        "slot_feed",
        "wall_feed",
        "ramp_feed",
    ])?;
    if let Some(scheme) = table.string("scheme")? {
        flank.strategy =
            parse_flank_strategy(scheme.value).map_err(|error| table.locate(scheme.at, error))?;
    }
    // The tool number is not checked against the tools: a setup for plunging may not list the flank tool yet.
    flank.tool = table.whole("tool", 1, MAX_NUMBER)?.map(|tool| tool.value);
    flank.layer_depth = table.number_or("layer_depth", LENGTH, flank.layer_depth)?;
    flank.scallop_height = table.number_or("scallop_height", LENGTH, flank.scallop_height)?;
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
pub fn parse_flank_strategy(name: &str) -> Result<FlankStrategy, UserError> {
    FlankStrategy::ALL.into_iter().find(|scheme| scheme.name() == name).ok_or_else(|| {
        let near = nearest(name, &FlankStrategy::ALL.map(FlankStrategy::name)).unwrap_or("");
        UserError::new(
            ErrorCode::UnknownName,
            format!("{} is not a flank strategy", quote_for_message(name)),
            format!(
                "use \"isoparametric\", \"layers\", \"regions\" or \"balanced\" \
                 (the nearest name is `{near}`)"
            ),
        )
    })
}

/// Writes a setup file. It reads back equal: angles that were read from degrees exactly, other angles to the
/// last bit of an f64. A blank from a file is written with its outline, so that the text does not depend on
/// that file; see [`write_setup_beside`].
pub fn write_setup(setup: &Setup) -> String {
    let mut out = String::new();
    // `write!` to a `String` cannot fail.
    let _ = write_to(&mut out, setup, true);
    out
}

/// Writes a setup file that is to be saved at `path`: as [`write_setup`], but a blank from a file is written
/// as the path of that file, relative to the setup where it is in the same folder or below.
pub fn write_setup_beside(setup: &Setup, path: &Path) -> String {
    let mut out = String::new();
    let _ = write_to(&mut out, &beside(setup, path), false);
    out
}

/// The file of a machine that the setup at `path` names: absolute, so that it is found from anywhere. Machines
/// that come with the program keep their names.
pub fn locate_machine(setup: &mut Setup, path: &Path) {
    let Some(file) = setup.machine.file.as_deref() else { return };
    if !built_in_names().any(|name| name == file) {
        let file = path.parent().unwrap_or(Path::new("")).join(file);
        let file = std::path::absolute(&file).unwrap_or(file);
        setup.machine.file = Some(file.to_string_lossy().into_owned());
    }
}

/// `setup` with the files of its blank and its machine named as seen from a file at `path`.
pub(super) fn beside(setup: &Setup, path: &Path) -> Setup {
    let mut setup = setup.clone();
    if let Some(file) = setup.machine.file.as_deref().map(Path::new).filter(|file| file.is_absolute()) {
        setup.machine.file = Some(relative(file, path).to_string_lossy().into_owned());
    }
    if let BlankShape::File(file) = &setup.allowances.blank {
        let name = relative(&file.path, path).to_string_lossy().into_owned();
        setup.allowances.blank = BlankShape::File(Arc::new(BlankFile { name, ..BlankFile::clone(file) }));
    }
    setup
}

/// `file` relative to the folder of `path`, if it is in that folder or below; else absolute.
pub(super) fn relative(file: &Path, path: &Path) -> PathBuf {
    let (Some(whole), Some(own)) = (std::path::absolute(file).ok(), std::path::absolute(path).ok()) else {
        return file.to_owned();
    };
    let beside = own.parent().and_then(|folder| whole.strip_prefix(folder).ok().map(Path::to_owned));
    beside.unwrap_or(whole)
}

fn write_to(out: &mut String, setup: &Setup, with_outline: bool) -> std::fmt::Result {
    writeln!(out, "version = {VERSION}")?;
    if let Some(part) = &setup.part {
        writeln!(out, "part = {}", quoted(part))?;
    }
    let stock = &setup.allowances;
    writeln!(out, "\n[stock]")?;
    writeln!(out, "hub_allowance = {:?}", stock.hub_allowance)?;
    writeln!(out, "blade_allowance = {:?}", stock.blade_allowance)?;
    writeln!(out, "safety_distance = {:?}", stock.safety_distance)?;
    writeln!(out, "inlet_extension = {:?}", stock.inlet_extension)?;
    if stock.blank != BlankShape::Edges {
        writeln!(out, "blank = {}", quoted(blank_name(&stock.blank)))?;
    }
    if let BlankShape::File(file) = &stock.blank
        && with_outline
    {
        let points = file.outline.points();
        let rows = points.iter().chain(points.first()).map(|p| format!("[{:?}, {:?}]", p.r, p.z));
        writeln!(out, "blank_outline = [{}]", rows.collect::<Vec<_>>().join(", "))?;
    }
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
    if let Some(stepover) = plunge.stepover {
        writeln!(out, "stepover = {stepover:?}")?;
    }
    writeln!(out, "wall_scallop = {:?}", plunge.wall_scallop)?;
    writeln!(out, "max_axis_change = {}", degrees_text(plunge.max_axis_change_rad))?;
    writeln!(out, "max_tilt = {}", degrees_text(plunge.max_tilt_rad))?;
    match plunge.goal {
        Goal::Stock { max_time_min: None } => {}
        Goal::Stock { max_time_min: Some(minutes) } => {
            writeln!(out, "goal = \"stock\"\nmax_time = {minutes:?}")?;
        }
        Goal::Time { max_stock } => writeln!(out, "goal = \"time\"\nmax_stock = {max_stock:?}")?,
        Goal::Balance => writeln!(out, "goal = \"balance\"")?,
    }
    if let Some(lift) = plunge.lift {
        writeln!(out, "lift = {lift:?}")?;
    }
    if let Some(peck) = plunge.peck {
        writeln!(out, "peck = {peck:?}")?;
    }
    if !plunge.adapt_feed {
        writeln!(out, "adapt_feed = false")?;
    }
    if !plunge.rest {
        writeln!(out, "rest = false")?;
    }
    for section in &plunge.sections {
        writeln!(out, "\n[[plunge.section]]\ntool = {}", section.tool)?;
        writeln!(out, "from = {:?}\nto = {:?}", section.from, section.to)?;
        match section.cut_direction {
            Some(CutDirection::OutletToInlet) => writeln!(out, "cutting_direction = \"outlet_to_inlet\"")?,
            Some(CutDirection::InletToOutlet) => writeln!(out, "cutting_direction = \"inlet_to_outlet\"")?,
            None => {}
        }
        match section.kind {
            SectionKind::Rows => {}
            SectionKind::Rest => writeln!(out, "rest = true")?,
            SectionKind::Opening => writeln!(out, "opening = true")?,
        }
    }
    writeln!(out, "\n[flank]")?;
    if let Some(tool) = setup.flank.tool {
        writeln!(out, "tool = {tool}")?;
    }
    writeln!(out, "scheme = \"{}\"", setup.flank.strategy.name())?;
    writeln!(out, "layer_depth = {:?}", setup.flank.layer_depth)?;
    writeln!(out, "scallop_height = {:?}", setup.flank.scallop_height)?;
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
        writeln!(out, "\n[machine]")?;
        if let Some(file) = &setup.machine.file {
            writeln!(out, "file = {}", quoted(file))?;
        }
        writeln!(out, "max_axis_tilt = {}", degrees_text(setup.machine.max_axis_tilt_rad))?;
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
        assert_eq!(setup.plunge.sections[0].cut_direction, Some(CutDirection::InletToOutlet));
        assert_eq!((setup.plunge.rest, setup.plunge.sections[0].kind), (false, SectionKind::Rows));
        assert_eq!(setup.plunge.sections[1].kind, SectionKind::Rest);
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
            ("\"outward\"", "\"across\"", 23, "outlet_to_inlet"),
            (
                "feed = \"outward\"",
                "cutting_direction = \"inlet_to_outlet\"\nfeed = \"outward\"",
                24,
                "former name",
            ),
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
