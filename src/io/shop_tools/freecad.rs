//! FreeCAD tool bits (`.fctb`) and libraries (`.fctl`). They know neither holder nor feeds; the numbers of
//! the tools are in the library.

use std::sync::Arc;

use serde_json::Value;

use super::json::{elements, json_text, tool_tree};
use super::left_out::LeftOutTools;
use super::length::{angle_deg, length_mm};
use super::library::{
    AssumedInsert, LibraryTool, OVERHANG_DIAMETERS, ToolLibrary, UNKNOWN_HOLDER, check_tool,
    note_missing_rates, number_tools, rated, round_lengths, short_name, too_many,
};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{MAX_COORDINATE, Source, quote_for_message};
use crate::io::tool_file::{MAX_NUMBER, MAX_TEETH, MAX_TOOLS};
use crate::setup::{MissingRates, Tool, ToolAssembly};

/// Shapes that are mills, in lower case and without blanks.
const MILLS: [&str; 6] = ["endmill", "ballend", "bullnose", "torus", "facemill", "taperedballnose"];

/// Reads the file of a tool that a library names: its name in messages and its bytes.
type ReadBeside<'a> = dyn Fn(&str) -> Result<(String, Vec<u8>), InputError> + 'a;

/// What a tool bit is.
pub(super) enum ToolBit {
    Mill(Box<LibraryTool>),
    /// Not a mill: its name in messages, and the reason.
    Other(String, String),
}

/// Reads one tool bit; with a `number` from the library that names it.
///
/// # Errors
/// When the bytes are not a tool bit, or its sizes are impossible.
pub(super) fn read_bit(name: &str, bytes: &[u8], number: Option<u32>) -> Result<ToolBit, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let tree =
        tool_tree(json_text(name, bytes)?).map_err(|what| fault(what, "give a tool bit of FreeCAD"))?;
    let parameters = tree.get("parameter").filter(|p| p.is_object());
    let parameters = parameters
        .ok_or_else(|| fault("has no object `parameter`".to_owned(), "give a tool bit of FreeCAD"))?;
    let shape = ["shape-type", "shape"].iter().find_map(|key| tree.get(*key).and_then(Value::as_str));
    let shape = shape.unwrap_or_default().to_lowercase().replace([' ', '_', '-'], "");
    let title = tree.get("name").and_then(Value::as_str).unwrap_or_default();
    let shown = quote_for_message(title);
    if !MILLS.iter().any(|mill| shape.starts_with(mill)) {
        return Ok(ToolBit::Other(shown, format!("{} is not a mill", quote_for_message(&shape))));
    }
    let length = |key: &str| -> Result<Option<f64>, InputError> {
        let Some(value) = parameters.get(key) else { return Ok(None) };
        let found = match value {
            Value::Number(number) => number.as_f64(),
            Value::String(text) => length_mm(text),
            _ => None,
        };
        match found.filter(|x| (0.0..=MAX_COORDINATE).contains(x)) {
            Some(x) => Ok(Some(x).filter(|x| *x > 0.0)),
            None => {
                let what = format!("{shown}: `{key}` is not a length");
                Err(fault(what, "give a number with mm or in, such as 6.35 mm or 1/4 in"))
            }
        }
    };
    let missing =
        || fault(format!("{shown} has no `Diameter`"), "add it in FreeCAD").with_code(ErrorCode::MissingKey);
    let diameter = length("Diameter")?.ok_or_else(missing)?;
    let mut notes = Vec::new();
    let flute = length("CuttingEdgeHeight")?;
    let total = length("Length")?;
    let overhang = total.unwrap_or_else(|| {
        notes.push("stick-out assumed: 4 diameters".to_owned());
        OVERHANG_DIAMETERS * diameter
    });
    if total.is_some() {
        notes.push("stick-out assumed: the whole length of the tool".to_owned());
    }
    if let Some(long) = flute.filter(|flute| *flute > overhang) {
        notes.push(format!("the edges, {long} mm, are longer than the tool, {overhang} mm: cut to it"));
    }
    let flute = flute.map(|flute| flute.min(overhang));
    let shank = match (length("ShankDiameter")?, flute) {
        (Some(shank), Some(flute)) if flute < overhang => vec![[shank, overhang - flute]],
        _ => Vec::new(),
    };
    let radius = 0.5 * diameter;
    let given = match length("CornerRadius")? {
        None => length("TorusRadius")?,
        given => given,
    };
    let is_bull_nose = shape.starts_with("bullnose") || shape.starts_with("torus");
    // Bull noses of older versions of FreeCAD have the radius of their flat bottom instead.
    let given = match (given, is_bull_nose) {
        (None, true) => length("FlatRadius")?.map(|flat| (radius - flat).max(0.0)),
        _ => given,
    };
    let corner = match given {
        _ if shape.starts_with("ball") || shape.starts_with("taperedball") => radius,
        Some(corner) => corner.min(radius),
        None => 0.0,
    };
    if given.is_some_and(|given| given > corner) {
        notes.push("corner radius larger than the radius: that taken".to_owned());
    } else if given.is_none() && is_bull_nose {
        notes.push("corner radius assumed: a sharp corner, as the tool bit has none".to_owned());
    }
    let taper = match parameters.get("TaperAngle") {
        Some(Value::Number(angle)) => angle.as_f64(),
        Some(Value::String(text)) => angle_deg(text),
        _ => None,
    };
    let taper = taper.filter(|angle| *angle > 0.0).map(f64::to_radians);
    if taper.is_some() || shape.starts_with("tapered") {
        notes.push("tapered: plans leave it out, they know cylindrical cutters only".to_owned());
    }
    let has_core = shape.starts_with("face") || is_bull_nose;
    let insert = if has_core { AssumedInsert::WithCore } else { AssumedInsert::ToCentre };
    let insert_width = insert.width(radius);
    notes.push(insert.note().to_owned());
    notes.push(UNKNOWN_HOLDER.to_owned());
    let attributes = tree.get("attribute");
    // Older tool bits have it among the attributes.
    let flutes = parameters.get("Flutes").or_else(|| attributes.and_then(|all| all.get("Flutes")));
    let teeth = flutes.and_then(|flutes| match flutes {
        Value::Number(number) => number.as_u64(),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    });
    let attribute =
        |key: &str| attributes.and_then(|all| all.get(key)).and_then(Value::as_str).and_then(short_name);
    let tool = Tool {
        number: number.unwrap_or(1),
        diameter,
        corner_radius: corner,
        insert_width,
        overhang,
        plunge_feed: 0.0,
        spindle: 0.0,
        assembly: ToolAssembly {
            name: short_name(title),
            description: attribute("Description"),
            material: parameters.get("Material").and_then(Value::as_str).and_then(short_name),
            flute_length: flute,
            teeth: teeth.and_then(|n| u32::try_from(n).ok()).filter(|n| (1..=MAX_TEETH).contains(n)),
            taper_rad: taper,
            shank,
            missing_rates: MissingRates::ALL,
            ..ToolAssembly::default()
        },
    };
    note_missing_rates(&tool, &mut notes);
    let tool = rated(LibraryTool { tool, notes });
    check_tool(&tool).map_err(|what| fault(format!("{shown}: {what}"), "correct it in FreeCAD"))?;
    Ok(ToolBit::Mill(Box::new(tool)))
}

/// Reads a library and the tool bits it names.
///
/// # Errors
/// When the bytes are not a library, or none of its tool bits can be taken over. One that cannot be read
/// beside others is left out, with a note.
pub(super) fn read_list(name: &str, bytes: &[u8], beside: &ReadBeside) -> Result<ToolLibrary, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let list = elements(json_text(name, bytes)?, "tools", MAX_TOOLS + 1);
    let list =
        list.ok_or_else(|| fault("has no list `tools`".to_owned(), "give a tool library of FreeCAD"))?;
    too_many(name, list.len())?;
    let mut library = ToolLibrary::default();
    let mut left_out = LeftOutTools::default();
    // The first error of a tool bit. It becomes the error of the library if no bit can be read.
    let mut refused = None;
    for (index, text) in list.iter().enumerate() {
        let entry = tool_tree(text).unwrap_or_default();
        let number = entry.get("nr").and_then(Value::as_u64).and_then(|n| u32::try_from(n).ok());
        let number = number.filter(|n| (1..=MAX_NUMBER).contains(n));
        let file = entry.get("path").and_then(Value::as_str);
        let shown = match (number, file) {
            (Some(number), _) => format!("tool {number}"),
            (None, Some(file)) => format!("tool {}", quote_for_message(file)),
            (None, None) => format!("the tool at place {} of the list", index + 1),
        };
        let read = || {
            let file = file.ok_or_else(|| {
                fault(format!("{shown} has no `path`"), "correct it in FreeCAD")
                    .with_code(ErrorCode::MissingKey)
            })?;
            // Only files beside the library: no folder above it, no absolute path.
            if file.contains(['/', '\\', ':']) || !file.to_lowercase().ends_with(".fctb") {
                let what = format!("{shown} is in {}, not a .fctb file beside it", quote_for_message(file));
                return Err(fault(what, "copy the tool bits into the folder of the library"));
            }
            beside(file).and_then(|(bit, bytes)| read_bit(&bit, &bytes, Some(number.unwrap_or(0))))
        };
        match read() {
            Ok(ToolBit::Mill(tool)) => library.tools.push(Arc::new(*tool)),
            Ok(ToolBit::Other(shown, why)) => {
                library.other_numbers.extend(number);
                left_out.add(shown, why);
            }
            Err(error) => {
                let of_file = file.filter(|_| number.is_some());
                let of_file =
                    of_file.map_or_else(String::new, |file| format!(", {},", quote_for_message(file)));
                library.other_numbers.extend(number);
                left_out.add(shown + &of_file, error.message.clone());
                refused.get_or_insert(error);
            }
        }
    }
    library.notes.extend(left_out.notes());
    if library.tools.is_empty() {
        let none = || fault("contains no end mill".to_owned(), "give a library with end mills");
        return Err(refused.unwrap_or_else(none));
    }
    number_tools(&mut library);
    round_lengths(&mut library);
    Ok(library)
}
