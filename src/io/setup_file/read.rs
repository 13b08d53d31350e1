//! Reading a setup: all tables but `[plunge]`, and the line that a fault found in planning refers to.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::VERSION;
use super::keys::{
    CLEARANCE_KEYS, FLANK_KEYS, MACHINE_KEYS, RENAMED_IN_FLANK, RENAMED_IN_PLUNGE, STOCK_KEYS,
};
use super::plunge::plunge;
use crate::error::{ErrorCode, UserError};
use crate::io::InputError;
use crate::io::blank_file::{is_stl, read_blank, read_blank_file};
use crate::io::machine_file::{built_in_names, is_built_in, read_machine};
use crate::io::source::{name_of, quote_for_message, read_bytes};
use crate::io::table::{NumberRange, TomlDocument, TomlTable, nearest_note};
use crate::io::tool_file::{ALLOWANCE, LENGTH, MAX_NUMBER, RATE, name, read_tool_tables};
use crate::part::{BlankFile, BlankShape, Meridional, MeridionalOutline};
use crate::setup::{
    AllowanceSetup, ChannelOrder, ChannelSequence, ChannelSetup, FlankSetup, FlankStrategy, Machine, Setup,
    SetupPlace,
};

/// Smallest tilt that a machine must reach for a plan, rad.
const MIN_AXIS_TILT: f64 = 0.02;
const HALF_TURN: NumberRange = NumberRange::Above(0.0, 180.0);

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
    root.check_keys(&[
        "version",
        "part",
        "stock",
        "clearance",
        "tool",
        "plunge",
        "flank",
        "channels",
        "machine",
    ])?;
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
        table.check_keys(&CLEARANCE_KEYS.map(|(key, _)| key))?;
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
    if let Some(table) = root.table("channels")? {
        channels(&table, &mut setup.channels)?;
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
    table.check_keys(&STOCK_KEYS.map(|(key, _)| key))?;
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

/// Reads `[machine]`. A machine without `max_axis_tilt` beside it gives its own; with both the file is not
/// read: setups within plans stay readable where the machine file is not.
fn machine(table: &TomlTable<'_>, machine: &mut Machine) -> Result<(), InputError> {
    table.check_keys(&MACHINE_KEYS.map(|(key, _)| key))?;
    let file = table.string("file")?;
    if let Some(angle) = table.number("max_axis_tilt", HALF_TURN)? {
        machine.max_axis_tilt_rad = angle.value.to_radians();
    } else if let Some(file) = &file {
        let is_built_in = is_built_in(file.value);
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

fn flank(table: &TomlTable<'_>, flank: &mut FlankSetup) -> Result<(), InputError> {
    table.check_keys(&FLANK_KEYS.map(|(key, _)| key))?;
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
    flank.approach_feed_mm_per_min = table.number("approach_feed", RATE)?.map(|x| x.value);
    Ok(())
}

fn channels(table: &TomlTable<'_>, channels: &mut ChannelSetup) -> Result<(), InputError> {
    table.check_keys(&["order", "sequence"])?;
    if let Some(order) = table.string("order")? {
        channels.order = parse_channel_order(order.value).map_err(|error| table.locate(order.at, error))?;
    }
    if let Some(sequence) = table.string("sequence")? {
        channels.sequence =
            parse_channel_sequence(sequence.value).map_err(|error| table.locate(sequence.at, error))?;
    }
    Ok(())
}

/// The order of the channels with this name, from a file or the command line.
///
/// # Errors
/// When no order has this name: what is wrong, and what to do.
pub fn parse_channel_order(name: &str) -> Result<ChannelOrder, UserError> {
    ChannelOrder::ALL.into_iter().find(|order| order.name() == name).ok_or_else(|| {
        let what = "an order of channels";
        unknown_name(name, what, &ChannelOrder::ALL.map(ChannelOrder::name))
    })
}

/// The sequence of channels with this name, from a file or the command line.
///
/// # Errors
/// When no sequence has this name: what is wrong, and what to do.
pub fn parse_channel_sequence(name: &str) -> Result<ChannelSequence, UserError> {
    ChannelSequence::ALL.into_iter().find(|sequence| sequence.name() == name).ok_or_else(|| {
        let what = "a sequence of channels";
        unknown_name(name, what, &ChannelSequence::ALL.map(ChannelSequence::name))
    })
}

/// The error of a `name` that is not `what`: one of `known`.
fn unknown_name(name: &str, what: &str, known: &[&str]) -> UserError {
    let choices: Vec<String> = known.iter().map(|known| format!("\"{known}\"")).collect();
    let message = format!("{} is not {what}", quote_for_message(name));
    UserError::new(ErrorCode::UnknownName, message, format!("use {}", choices.join(" or ")))
}

/// The flank milling strategy with this name.
///
/// # Errors
/// When no strategy has this name: what is wrong, and what to do.
pub fn parse_flank_strategy(name: &str) -> Result<FlankStrategy, UserError> {
    FlankStrategy::ALL.into_iter().find(|scheme| scheme.name() == name).ok_or_else(|| {
        let near = nearest_note(name, &FlankStrategy::ALL.map(FlankStrategy::name));
        UserError::new(
            ErrorCode::UnknownName,
            format!("{} is not a flank strategy", quote_for_message(name)),
            format!("use \"isoparametric\", \"layers\", \"regions\" or \"balanced\"{near}"),
        )
    })
}
