//! Machine files: TOML; mm, degrees, mm/min, degrees/min, mm/s², degrees/s². `docs/formats.md` lists the
//! keys.

use std::path::Path;

use super::InputError;
use super::source::{name_of, quote_for_message, read_bytes};
use super::table::{Located, NumberRange, TomlDocument, TomlTable};
use crate::error::ErrorCode;
use crate::geometry::{Point, Vector};
use crate::machine::{
    AxisSide, LINEAR_NAMES, LinearAxis, LinkSettings, MachineTable, MachineTool, OutputKind, PartPlacement,
    RotaryAxis, TurnLink,
};
use crate::setup::Setup;

/// The machines that come with the program: name and text.
const BUILT_IN: [(&str, &str); 5] = [
    ("ac-trunnion", include_str!("../../assets/machines/ac-trunnion.toml")),
    ("bc-trunnion", include_str!("../../assets/machines/bc-trunnion.toml")),
    ("b-head-c-table", include_str!("../../assets/machines/b-head-c-table.toml")),
    ("bc-head", include_str!("../../assets/machines/bc-head.toml")),
    ("nutating-table", include_str!("../../assets/machines/nutating-table.toml")),
];

/// Largest length in a machine file, mm.
const MAX_LENGTH: f64 = 100_000.0;
const LENGTH: NumberRange = NumberRange::Between(0.0, MAX_LENGTH);
const POSITIVE: NumberRange = NumberRange::Above(0.0, 1e6);
const SECONDS: NumberRange = NumberRange::Between(0.0, 10_000.0);
/// Range of a limited rotary axis, degrees.
const MAX_ANGLE: f64 = 3600.0;
/// Smallest sine of the angle between both rotary axes, and between the second one and the tool.
const MIN_SINE: f64 = 0.05;

/// Names of the machines that come with the program.
pub fn built_in_names() -> impl Iterator<Item = &'static str> {
    BUILT_IN.iter().map(|(name, _)| *name)
}

/// Whether a machine of that name comes with the program.
pub fn is_built_in(name: &str) -> bool {
    built_in_names().any(|known| known == name)
}

/// The machine of `setup`, whose file is located: `None` where it names none, and where the file is gone, as
/// of a plan that was sent without it.
///
/// # Errors
/// When the file is there and is not that of a machine.
pub fn machine_of_setup(setup: &Setup) -> Result<Option<MachineTool>, InputError> {
    match setup.machine.file.as_deref() {
        Some(name) if is_built_in(name) || Path::new(name).exists() => {
            read_machine(Path::new(name)).map(Some)
        }
        _ => Ok(None),
    }
}

/// The machine of that name among those of the program, or read from the file of that name.
///
/// # Errors
/// When the name is neither that of a machine nor of a file, or the file is not valid.
pub fn read_machine(name_or_path: &Path) -> Result<MachineTool, InputError> {
    let name = name_of(name_or_path);
    if let Some((_, text)) = BUILT_IN.iter().find(|(known, _)| *known == name) {
        return read_machine_bytes(&name, text.as_bytes());
    }
    if !name_or_path.exists() && !name.contains(['/', '\\', '.']) {
        let known: Vec<&str> = built_in_names().collect();
        let what = format!("unknown machine {}", quote_for_message(&name));
        return Err(InputError::new(
            ErrorCode::UnknownName,
            "",
            0,
            what,
            format!("use {}, or a machine file", known.join(", ")),
        ));
    }
    read_machine_bytes(&name, &read_bytes(name_or_path)?)
}

/// Reads a machine from bytes; `name` is the file name used in messages.
///
/// # Errors
/// When the bytes are not TOML, a key is unknown or missing, or a value is out of its range.
pub fn read_machine_bytes(name: &str, bytes: &[u8]) -> Result<MachineTool, InputError> {
    let document = TomlDocument::new(name, bytes, ErrorCode::MachineFile)?;
    let tree = document.parse()?;
    let root = document.root(&tree);
    root.check_keys(&[
        "name",
        "control",
        "output",
        "tool_change_time",
        "holder_length",
        "block_time",
        "corner_time",
        "linear",
        "rotary",
        "table",
        "part",
        "links",
    ])?;
    let linear = linear_axes(&root)?;
    let rotary = rotary_axes(&root)?;
    let slowest = linear.iter().map(|axis| axis.rapid).fold(f64::INFINITY, f64::min);
    let output = match root.string("output")? {
        None => OutputKind::TcpAngles,
        Some(text) => OutputKind::of_name(text.value).ok_or_else(|| {
            let what = format!("unknown output {}", quote_for_message(text.value));
            root.fault_at(text.at, what, "use tcp-angles, tcp-vectors, plane or joints")
                .with_code(ErrorCode::UnknownName)
        })?,
    };
    Ok(MachineTool {
        name: text_of(&root, "name")?.unwrap_or("machine").to_owned(),
        control: required(&root, "control", text_of(&root, "control")?)?.to_owned(),
        output,
        linear,
        rotary,
        tool_change_s: root.number_or("tool_change_time", SECONDS, 15.0)?,
        holder_length: root.number_or("holder_length", LENGTH, 100.0)?,
        block_time_s: root.number_or("block_time", SECONDS, 0.001)?,
        corner_time_s: root.number_or("corner_time", NumberRange::Above(0.0, 10.0), 0.01)?,
        table: table_of(&root)?,
        part: placement(&root)?,
        links: links(&root, slowest)?,
    })
}

fn required<T>(table: &TomlTable<'_>, key: &str, value: Option<T>) -> Result<T, InputError> {
    value.ok_or_else(|| {
        table
            .fault(format!("{} has no `{key}`", table.shown()), format!("give `{key}`"))
            .with_code(ErrorCode::MissingKey)
    })
}

fn text_of<'t>(table: &TomlTable<'t>, key: &str) -> Result<Option<&'t str>, InputError> {
    let Some(text) = table.string(key)? else { return Ok(None) };
    if text.value.chars().any(char::is_control) || text.value.chars().count() > 80 {
        return Err(table.fault_at(text.at, format!("`{key}` is not one short line"), "shorten it"));
    }
    Ok(Some(text.value))
}

fn linear_axes(root: &TomlTable<'_>) -> Result<[LinearAxis; 3], InputError> {
    let table = required(root, "linear", root.table("linear")?)?;
    table.check_keys(&["x", "y", "z"])?;
    let mut axes = Vec::with_capacity(3);
    for name in LINEAR_NAMES {
        let key = name.to_ascii_lowercase().to_string();
        let axis = required(&table, &key, table.table(&key)?)?;
        axis.check_keys(&["limits", "rapid", "acceleration", "jerk"])?;
        let limits = required(&axis, "limits", range_of(&axis, "limits", MAX_LENGTH)?)?;
        axes.push(LinearAxis {
            limits,
            rapid: required(&axis, "rapid", axis.number("rapid", POSITIVE)?)?.value,
            acceleration: axis.number_or("acceleration", POSITIVE, 2000.0)?,
            jerk: axis.number("jerk", POSITIVE)?.map_or(f64::INFINITY, |x| x.value),
        });
    }
    axes.try_into()
        .map_err(|_| table.fault("needs x, y and z", "give all three").with_code(ErrorCode::MissingKey))
}

/// A list of a lower and a higher number.
fn range_of(table: &TomlTable<'_>, key: &str, largest: f64) -> Result<Option<(f64, f64)>, InputError> {
    let Some(Located { value, at }) = table.numbers(key)? else { return Ok(None) };
    match value.as_slice() {
        [low, high] if low < high && low.abs() <= largest && high.abs() <= largest => Ok(Some((*low, *high))),
        _ => Err(table
            .fault_at(
                at,
                format!("`{key}` are not two numbers, the lower one first"),
                format!("give [low, high] within ±{largest}"),
            )
            .with_code(ErrorCode::ValueType)),
    }
}

fn triple(table: &TomlTable<'_>, key: &str) -> Result<Option<Located<Vector>>, InputError> {
    let Some(Located { value, at }) = table.numbers(key)? else { return Ok(None) };
    match value.as_slice() {
        [x, y, z] if value.iter().all(|c| c.abs() <= MAX_LENGTH) => {
            Ok(Some(Located { value: Vector::new(*x, *y, *z), at }))
        }
        _ => Err(table
            .fault_at(at, format!("`{key}` is not three numbers"), "give [x, y, z]")
            .with_code(ErrorCode::ValueType)),
    }
}

fn rotary_axes(root: &TomlTable<'_>) -> Result<[RotaryAxis; 2], InputError> {
    let tables = root.tables("rotary")?;
    if tables.len() != 2 {
        let what = format!("has {} rotary axes, not 2", tables.len());
        return Err(root.fault(what, "give two [[rotary]] tables, from the workpiece to the tool"));
    }
    let axes = tables.iter().map(rotary_axis).collect::<Result<Vec<_>, _>>()?;
    let axes: [RotaryAxis; 2] = axes.try_into().map_err(|_| {
        root.fault("needs two rotary axes", "give two [[rotary]] tables").with_code(ErrorCode::MissingKey)
    })?;
    let second = &tables[1];
    if axes[0].letter == axes[1].letter {
        return Err(second.fault("both rotary axes have the same letter", "give A, B or C once each"));
    }
    if axes[0].side == AxisSide::Head && axes[1].side == AxisSide::Table {
        let what = "a head comes before a table";
        return Err(second.fault(what, "list the axes from the workpiece to the tool: tables, then heads"));
    }
    if axes[0].direction.cross(&axes[1].direction).norm() < MIN_SINE {
        return Err(second.fault("both rotary axes are parallel", "give them different directions"));
    }
    if axes[1].direction.cross(&Vector::z()).norm() < MIN_SINE {
        let what = "the axis nearest to the tool is parallel to the tool";
        return Err(second.fault(what, "list the axes from the workpiece to the tool"));
    }
    Ok(axes)
}

fn rotary_axis(table: &TomlTable<'_>) -> Result<RotaryAxis, InputError> {
    table.check_keys(&["letter", "side", "dir", "point", "limits", "rapid", "acceleration", "jerk"])?;
    let letter = required(table, "letter", table.string("letter")?)?;
    let letter = match letter.value {
        "A" => 'A',
        "B" => 'B',
        "C" => 'C',
        other => {
            let what = format!("unknown letter {}", quote_for_message(other));
            return Err(table
                .fault_at(letter.at, what, "use \"A\", \"B\" or \"C\"")
                .with_code(ErrorCode::UnknownName));
        }
    };
    let side = required(table, "side", table.string("side")?)?;
    let side = match side.value {
        "table" => AxisSide::Table,
        "head" => AxisSide::Head,
        other => {
            let what = format!("unknown side {}", quote_for_message(other));
            return Err(table
                .fault_at(side.at, what, "use \"table\" or \"head\"")
                .with_code(ErrorCode::UnknownName));
        }
    };
    let direction = required(table, "dir", triple(table, "dir")?)?;
    let unit = direction.value.try_normalize(1e-3).filter(|_| (direction.value.norm() - 1.0).abs() < 1e-3);
    let Some(unit) = unit else {
        return Err(table.fault_at(direction.at, "`dir` is not a unit vector", "give one of length 1"));
    };
    let point = triple(table, "point")?.map_or(Point::origin(), |p| Point::from(p.value));
    let limits = match table.string("limits") {
        Ok(Some(text)) if text.value == "endless" => None,
        Ok(Some(text)) => {
            let what = format!("unknown limits {}", quote_for_message(text.value));
            return Err(table
                .fault_at(text.at, what, "use \"endless\" or [low, high] in degrees")
                .with_code(ErrorCode::UnknownName));
        }
        Ok(None) => {
            return Err(table
                .fault("the axis has no `limits`", "give \"endless\" or [low, high]")
                .with_code(ErrorCode::MissingKey));
        }
        Err(_) => range_of(table, "limits", MAX_ANGLE)?.map(|(a, b)| (a.to_radians(), b.to_radians())),
    };
    Ok(RotaryAxis {
        letter,
        side,
        direction: unit,
        point,
        limits,
        rapid_rad_per_s: required(table, "rapid", table.number("rapid", POSITIVE)?)?.value.to_radians()
            / 60.0,
        acceleration: table.number_or("acceleration", POSITIVE, 1000.0)?.to_radians(),
        jerk: table.number("jerk", POSITIVE)?.map_or(f64::INFINITY, |x| x.value.to_radians()),
    })
}

fn table_of(root: &TomlTable<'_>) -> Result<Option<MachineTable>, InputError> {
    let Some(table) = root.table("table")? else { return Ok(None) };
    table.check_keys(&["radius", "top"])?;
    let radius =
        required(&table, "radius", table.number("radius", NumberRange::Above(0.0, MAX_LENGTH))?)?.value;
    let top = table.number_or("top", NumberRange::Between(-MAX_LENGTH, MAX_LENGTH), 0.0)?;
    Ok(Some(MachineTable { radius, top }))
}

fn placement(root: &TomlTable<'_>) -> Result<PartPlacement, InputError> {
    let mut part = PartPlacement {
        inlet_up: true,
        clock_rad: 0.0,
        origin: Point::origin(),
        offset_name: "G54".to_owned(),
    };
    let Some(table) = root.table("part")? else { return Ok(part) };
    table.check_keys(&["inlet", "clock", "origin", "offset"])?;
    if let Some(inlet) = table.string("inlet")? {
        part.inlet_up = match inlet.value {
            "up" => true,
            "down" => false,
            other => {
                let what = format!("unknown inlet {}", quote_for_message(other));
                return Err(table
                    .fault_at(inlet.at, what, "use \"up\" or \"down\"")
                    .with_code(ErrorCode::UnknownName));
            }
        };
    }
    part.clock_rad = table.number_or("clock", NumberRange::Between(-360.0, 360.0), 0.0)?.to_radians();
    if let Some(origin) = triple(&table, "origin")? {
        part.origin = Point::from(origin.value);
    }
    if let Some(offset) = text_of(&table, "offset")? {
        part.offset_name = offset.to_owned();
    }
    Ok(part)
}

fn links(root: &TomlTable<'_>, slowest: f64) -> Result<LinkSettings, InputError> {
    let mut links = LinkSettings { turn: TurnLink::Feed, clearance: 20.0, rate: slowest, retract_z: 0.0 };
    let Some(table) = root.table("links")? else { return Ok(links) };
    table.check_keys(&["turn", "clearance", "feed", "retract"])?;
    if let Some(turn) = table.string("turn")? {
        links.turn = match turn.value {
            "feed" => TurnLink::Feed,
            "clear" => TurnLink::Clear,
            other => {
                let what = format!("unknown link {}", quote_for_message(other));
                return Err(table
                    .fault_at(turn.at, what, "use \"feed\" or \"clear\"")
                    .with_code(ErrorCode::UnknownName));
            }
        };
    }
    links.clearance = table.number_or("clearance", NumberRange::Between(1.0, 1000.0), links.clearance)?;
    links.rate = table.number_or("feed", POSITIVE, links.rate)?;
    let everywhere = NumberRange::Between(-MAX_LENGTH, MAX_LENGTH);
    links.retract_z = table.number_or("retract", everywhere, links.retract_z)?;
    Ok(links)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_machines_are_sound() {
        for name in built_in_names() {
            let machine = read_machine(Path::new(name)).unwrap();
            assert!(machine.linear.iter().all(|axis| axis.jerk.is_finite()), "{name} has jerk");
            assert!(machine.tool_change_s > 0.0);
        }
    }

    #[test]
    fn faults_name_their_line() {
        let text = BUILT_IN[0].1;
        for (from, to, what) in [
            ("side = \"table\"", "side = \"tabel\"", "unknown side `tabel`"),
            ("letter = \"A\"", "letter = \"C\"", "the same letter"),
            ("rapid = ", "rapit = ", "unknown key `rapit`"),
            ("inlet = \"up\"", "inlet = 3", "not a text"),
            ("dir = [0, 0, -1]", "dir = [0, 0, -2]", "not a unit vector"),
            ("dir = [-1, 0, 0]", "dir = [0, 0, 1]", "parallel"),
            ("limits = [-120, 120]", "limits = [120, -120]", "not two numbers, the lower one first"),
        ] {
            let changed = text.replacen(from, to, 1);
            assert_ne!(changed, text, "{from}");
            let error = read_machine_bytes("m.toml", changed.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("m.toml:") && error.contains(what), "{error}");
            assert!(!error.contains('\n'));
        }
    }
}
