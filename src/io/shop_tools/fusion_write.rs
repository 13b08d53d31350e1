//! Writing Fusion tool libraries.

use serde_json::{Map, Value, json};

use super::{LibraryTool, ToolLibrary};
use crate::io::hash::{FNV_START, fnv1a};

/// What must be known of a Fusion library before it is written, as lines for the user: what it does not hold
/// where it is `new`, or what becomes of one that is there. The last only where a tool has an insert width.
pub fn fusion_remarks(library: &ToolLibrary, new: bool) -> Vec<String> {
    let mut lines = match new {
        true => vec![
            "Vendor, product and coolant of the tools".to_owned(),
            "Feed rates other than that of a plunge: cutting, lead-in and ramp".to_owned(),
            "Identifiers: Fusion takes every tool and holder for a new one".to_owned(),
            "Names of holders, and inches: all lengths are in mm".to_owned(),
        ],
        false => vec![
            "Tools that are new in it have no vendor, product and coolant; the others keep theirs".to_owned(),
            "A tool that is new in it gets a free number where another one, a drill too, has its own"
                .to_owned(),
            "Tools that were removed from the list stay in the file".to_owned(),
        ],
    };
    if library.tools.iter().any(|entry| entry.tool.core_radius() > 0.0) {
        lines.push("Insert widths are not in it: Fusion does not know them".to_owned());
    }
    lines
}

/// Writes a library in mm. Tools without a name are called by number and diameter; Fusion has no insert
/// width.
pub fn write_fusion(library: &ToolLibrary) -> String {
    let data: Vec<Value> = library.tools.iter().map(|entry| entry_of(entry)).collect();
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

/// The entry of a tool, in mm.
pub(super) fn entry_of(LibraryTool { tool, .. }: &LibraryTool) -> Value {
    let more = &tool.assembly;
    let rate = |is_missing: bool, rate: f64| (!is_missing).then_some(rate);
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
    let flute = more.flutes_end(tool.overhang);
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
        "BMC": more.material.as_deref().unwrap_or("unspecified"),
        "geometry": geometry,
        "post-process": {
            "number": tool.number,
            "comment": more.description.as_deref().unwrap_or_default(),
            "length-offset": tool.length_offset_number(),
            "diameter-offset": more.diameter_offset.unwrap_or(tool.number),
        },
        "start-values": {"presets": [{
            "guid": guid_of(&format!("preset {tool:?}")),
            "name": "Vanecut",
            "n": rate(more.missing_rates.spindle, tool.spindle),
            "v_f_plunge": rate(more.missing_rates.plunge_feed, tool.plunge_feed),
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
