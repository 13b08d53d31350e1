//! Fusion tool libraries: `{"data": [tool, …], "version": …}`, lengths in the unit of each tool, holders in
//! a unit of their own.
//!
//! Segments run from the cutter or the collet towards the spindle. Segments of a holder beyond its gauge
//! length are in the spindle and are left out. An expression prevails over the number beside it.

use serde_json::{Map, Value, json};

use super::expression::Expressions;
use super::{
    LibraryTool, MAX_SEGMENTS, OVERHANG_DIAMETERS, ToolLibrary, check_tool, number_tools, parse_json, rate,
    round_lengths, short_name, too_many,
};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::hash::{FNV_START, fnv1a};
use crate::io::source::{Source, quote_for_message};
use crate::io::tool_file::{MAX_NUMBER, MAX_TEETH};
use crate::setup::{Tool, ToolAssembly};

/// Mills by their type, with the insert width in radii that is assumed: cutters with inserts have a core,
/// solid ones cut to the centre.
const MILLS: [(&str, f64); 7] = [
    ("flat end mill", 1.0),
    ("ball end mill", 1.0),
    ("bull nose end mill", 0.9),
    ("face mill", 0.9),
    ("tapered mill", 1.0),
    ("radius mill", 0.9),
    ("lollipop mill", 1.0),
];

/// Reads a library.
///
/// # Errors
/// When the bytes are not JSON of this form, or no mill in it can be taken over. One with impossible sizes beside
/// others is left out, with a note.
pub(super) fn read(name: &str, bytes: &[u8]) -> Result<ToolLibrary, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let tree = parse_json(name, bytes)?;
    let data = tree.get("data").and_then(Value::as_array);
    let data = data.ok_or_else(|| fault("has no list `data`".to_owned(), "give a tool library of Fusion"))?;
    let mut library = ToolLibrary::default();
    let mut holders = 0;
    // The first error of a mill. It becomes the error of the library if no mill can be read.
    let mut refused = None;
    for (index, entry) in data.iter().enumerate() {
        let kind = string(entry, "type").unwrap_or_default();
        let title = string(entry, "description").unwrap_or_default();
        let shown = format!("tool {} ({})", index + 1, quote_for_message(title));
        if !entry.is_object() {
            return Err(fault(format!("entry {} is not a tool", index + 1), "export the library again"));
        }
        let Some((_, width)) = MILLS.iter().find(|(mill, _)| *mill == kind) else {
            if kind == "holder" {
                holders += 1;
            } else {
                library.leave_out(&shown, &format!("{} is not a mill", quote_for_message(kind)));
            }
            continue;
        };
        let checked = mill(entry, *width).and_then(|tool| check_tool(&tool.tool).map(|()| tool));
        match checked {
            Ok(tool) => library.tools.push(tool),
            Err(what) => {
                library.leave_out(&shown, &what);
                refused.get_or_insert_with(|| fault(format!("{shown}: {what}"), "correct it in the library"));
            }
        }
    }
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

fn string<'v>(value: &'v Value, key: &str) -> Option<&'v str> {
    value.get(key).and_then(Value::as_str)
}

/// Size of a unit in mm.
fn unit_mm(value: &Value, whose: &str) -> Result<f64, String> {
    match value.get("unit") {
        None => Err(format!("{whose} has no `unit`")),
        Some(unit) => match unit.as_str() {
            Some("millimeters" | "mm" | "metric") => Ok(1.0),
            Some("inches" | "in" | "inch") => Ok(25.4),
            other => {
                let shown = quote_for_message(other.unwrap_or("?"));
                Err(format!("{whose} has the unit {shown}, neither millimeters nor inches"))
            }
        },
    }
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

/// Converts one mill, whose insert width is assumed to be `width` radii.
fn mill(entry: &Value, width: f64) -> Result<LibraryTool, String> {
    let mut notes = Vec::new();
    let mm = unit_mm(entry, "it")?;
    let geometry = entry.get("geometry").filter(|g| g.is_object()).ok_or("it has no `geometry`")?;
    let expressions = Expressions::new(entry.get("expressions"), mm);
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
    let diameter = length("DC", "tool_diameter")?.ok_or("it has no diameter `DC`")?;
    if diameter <= 0.0 {
        return Err(format!("its diameter is {diameter} mm"));
    }
    let radius = 0.5 * diameter;
    let corner = length("RE", "tool_cornerRadius")?.unwrap_or(0.0);
    let mut flute = positive(length("LCF", "tool_fluteLength")?);
    let body = positive(length("LB", "tool_bodyLength")?);
    let shoulder = positive(length("shoulder-length", "tool_shoulderLength")?);
    let neck = positive(length("shoulder-diameter", "tool_shoulderDiameter")?);
    let shaft = positive(length("SFDM", "tool_shaftDiameter")?);
    let taper = number(Some(geometry), "TA")?.filter(|angle| *angle > 0.0);
    let overhang = body.unwrap_or_else(|| {
        notes.push("overhang assumed: 4 diameters, as the library has no body length".to_owned());
        OVERHANG_DIAMETERS * diameter
    });
    if let Some(long) = flute.filter(|flute| *flute > overhang) {
        notes.push(format!("the flutes, {long} mm, are longer than the overhang {overhang} mm: cut to it"));
        flute = Some(overhang);
    }
    let centre_cutting = width >= 1.0 || geometry.get("CSP").and_then(Value::as_bool) == Some(true);
    let insert_width = if centre_cutting { radius } else { width * radius };
    notes.push(match centre_cutting {
        true => "insert width assumed: the cutter cuts to its centre".to_owned(),
        false => format!("insert width assumed: {insert_width} mm, 0.45 of the diameter"),
    });
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
        Some(holder) => read_holder(holder, &mut notes)?,
        None => Vec::new(),
    };
    let post = entry.get("post-process");
    let whole = |key: &str, most: u32| -> Option<u32> {
        let value = post.and_then(|post| post.get(key)).and_then(Value::as_u64)?;
        u32::try_from(value).ok().filter(|value| *value <= most)
    };
    let teeth =
        geometry.get("NOF").and_then(Value::as_f64).filter(|n| (1.0..=f64::from(MAX_TEETH)).contains(n));
    let teeth = teeth.map(|n| n as u32);
    let preset = preset_of(entry, mm, &mut notes)?;
    Ok(LibraryTool {
        tool: Tool {
            number: whole("number", MAX_NUMBER).unwrap_or(0),
            diameter,
            corner_radius: corner.clamp(0.0, radius),
            insert_width,
            overhang,
            plunge_feed: preset.plunge_feed.unwrap_or_else(|| {
                notes.push("plunge feed assumed: 300 mm/min".to_owned());
                300.0
            }),
            spindle: preset.spindle.unwrap_or_else(|| {
                notes.push("spindle speed assumed: 1200 rev/min".to_owned());
                1200.0
            }),
            assembly: ToolAssembly {
                name: string(entry, "description").and_then(short_name),
                flute_length: flute,
                teeth,
                taper_rad: taper.map(f64::to_radians),
                shank,
                holder,
                length_offset: whole("length-offset", MAX_NUMBER),
                diameter_offset: whole("diameter-offset", MAX_NUMBER),
                feed_per_tooth: preset.feed_per_tooth.filter(|x| (0.0..=100.0).contains(x)),
                cutting_speed: preset.cutting_speed.filter(|x| (0.0..=1e5).contains(x)),
            },
        },
        notes,
    })
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

/// Segments of a holder up to its gauge line.
fn read_holder(holder: &Value, notes: &mut Vec<String>) -> Result<Vec<[f64; 3]>, String> {
    let mm = unit_mm(holder, "its holder")?;
    let Some(rows) = holder.get("segments") else { return Ok(Vec::new()) };
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
        notes.push(format!("{} holder segments beyond the gauge line are left out", segments.len() - kept));
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
fn preset_of(entry: &Value, mm: f64, notes: &mut Vec<String>) -> Result<Preset, String> {
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
    let expressions = Expressions::new(preset.get("expressions"), mm);
    let mut taken = |key: &str, name: &str, factor: f64| -> Result<Option<f64>, String> {
        let stored = number(Some(preset), key)?.map(|x| x * factor);
        if expressions.has(name) {
            match expressions.value(name) {
                Some(value) => return Ok(rate(Some(value))),
                None => notes.push(format!("the expression {name} cannot be computed: its number is taken")),
            }
        }
        Ok(rate(stored))
    };
    // Inch libraries have feet per minute.
    let feet = if mm > 1.0 { 0.3048 } else { 1.0 };
    Ok(Preset {
        spindle: taken("n", "tool_spindleSpeed", 1.0)?,
        plunge_feed: taken("v_f_plunge", "tool_feedPlunge", mm)?,
        feed_per_tooth: taken("f_z", "tool_feedPerTooth", mm)?,
        cutting_speed: taken("v_c", "tool_surfaceSpeed", feet)?,
    })
}

/// Writes a library in mm. Tools without a name are called by number and diameter; Fusion has no insert
/// width.
pub fn write_fusion(library: &ToolLibrary) -> String {
    let data: Vec<Value> = library.tools.iter().map(|tool| entry_of(&tool.tool)).collect();
    let mut text = serde_json::to_string_pretty(&json!({"data": data, "version": 36})).unwrap_or_default();
    text.push('\n');
    text
}

/// An identifier made from the content of a tool, in the form of a UUID: equal tools get equal ones.
fn guid_of(text: &str) -> String {
    // Two hashes make 128 bits; any other start serves for the second one.
    let [a, b] = [FNV_START, 0x9ae1_6a3b_2f90_404f].map(|start| fnv1a(start, text.bytes()));
    format!(
        "{:08x}-{:04x}-8{:03x}-8{:03x}-{:012x}",
        a >> 32,
        (a >> 16) & 0xffff,
        a & 0xfff,
        (b >> 48) & 0xfff,
        b & 0xffff_ffff_ffff
    )
}

fn entry_of(tool: &Tool) -> Value {
    let more = &tool.assembly;
    let description =
        more.name.clone().unwrap_or_else(|| format!("tool {} D {}", tool.number, tool.diameter));
    let kind = if tool.corner_radius >= tool.radius() {
        "ball end mill"
    } else if more.taper_rad.is_some_and(|taper| taper > 0.0) {
        "tapered mill"
    } else if tool.corner_radius > 0.0 {
        "bull nose end mill"
    } else if tool.core_radius() > 0.0 {
        "face mill"
    } else {
        "flat end mill"
    };
    let flute = more.flute_length.unwrap_or(tool.overhang);
    let mut geometry = Map::new();
    let mut put = |key: &str, value: Value| {
        geometry.insert(key.to_owned(), value);
    };
    put("DC", json!(tool.diameter));
    put("RE", json!(tool.corner_radius));
    put("LCF", json!(flute));
    put("LB", json!(tool.overhang));
    put("OAL", json!(tool.overhang));
    put("shoulder-length", json!(flute));
    put("SFDM", json!(more.shank.last().map_or(tool.diameter, |[diameter, _]| *diameter)));
    put("CSP", json!(false));
    put("HAND", json!(true));
    if let Some(teeth) = more.teeth {
        put("NOF", json!(teeth));
    }
    if let Some(taper) = more.taper_rad {
        put("TA", json!(taper.to_degrees()));
    }
    let mut entry = json!({
        "guid": guid_of(&format!("{tool:?}")),
        "type": kind,
        "unit": "millimeters",
        "description": description,
        "BMC": "unspecified",
        "geometry": geometry,
        "post-process": {
            "number": tool.number,
            "length-offset": more.length_offset.unwrap_or(tool.number),
            "diameter-offset": more.diameter_offset.unwrap_or(tool.number),
        },
        "start-values": {"presets": [{
            "guid": guid_of(&format!("preset {tool:?}")),
            "name": "Vanecut",
            "n": tool.spindle,
            "v_f_plunge": tool.plunge_feed,
            "f_z": more.feed_per_tooth,
            "v_c": more.cutting_speed,
        }]},
    });
    let row = |[lower, upper, length]: [f64; 3]| -> Value {
        json!({"height": length, "lower-diameter": lower, "upper-diameter": upper})
    };
    if !more.shank.is_empty() {
        let rows: Vec<Value> = more.shank.iter().map(|&[d, length]| row([d, d, length])).collect();
        entry["shaft"] = json!({"type": "shaft", "segments": rows});
    }
    if !more.holder.is_empty() {
        let gauge: f64 = more.holder.iter().map(|[_, _, length]| length).sum();
        let rows: Vec<Value> = more.holder.iter().copied().map(row).collect();
        entry["holder"] = json!({
            "guid": guid_of(&format!("holder {:?}", more.holder)),
            "type": "holder",
            "unit": "millimeters",
            "description": format!("holder of {description}"),
            "gaugeLength": gauge,
            "segments": rows,
        });
    }
    entry
}
