//! FreeCAD tool bits (`.fctb`) and libraries (`.fctl`). They know neither holder nor feeds; the numbers of
//! the tools are in the library.

use serde_json::Value;

use super::{
    LibraryTool, OVERHANG_DIAMETERS, ToolLibrary, check_tool, number_tools, parse_json, round_lengths,
    short_name, too_many,
};
use crate::error::ErrorCode;
use crate::io::InputError;
use crate::io::source::{MAX_COORDINATE, Source, quote_for_message};
use crate::io::tool_file::{MAX_NUMBER, MAX_TEETH, MAX_TOOLS};
use crate::setup::{Tool, ToolAssembly};

/// Shapes that are mills, in lower case and without blanks.
const MILLS: [&str; 6] = ["endmill", "ballend", "bullnose", "torus", "facemill", "taperedballnose"];

/// Reads the file of a tool that a library names: its name in messages and its bytes.
type ReadBeside<'a> = dyn Fn(&str) -> Result<(String, Vec<u8>), InputError> + 'a;

/// Reads one tool bit; with a `number` from the library that names it.
///
/// # Errors
/// When the bytes are not a tool bit, or its sizes are impossible.
pub(super) fn read_bit(name: &str, bytes: &[u8], number: Option<u32>) -> Result<ToolLibrary, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let tree = parse_json(name, bytes)?;
    let parameters = tree.get("parameter").filter(|p| p.is_object());
    let parameters = parameters
        .ok_or_else(|| fault("has no object `parameter`".to_owned(), "give a tool bit of FreeCAD"))?;
    let shape = ["shape-type", "shape"].iter().find_map(|key| tree.get(*key).and_then(Value::as_str));
    let shape = shape.unwrap_or_default().to_lowercase().replace([' ', '_', '-'], "");
    let title = tree.get("name").and_then(Value::as_str).unwrap_or_default();
    let shown = quote_for_message(title);
    let mut library = ToolLibrary::default();
    if !MILLS.iter().any(|mill| shape.starts_with(mill)) {
        library.leave_out(&shown, &format!("{} is not a mill", quote_for_message(&shape)));
        return Ok(library);
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
            None => Err(fault(format!("{shown}: `{key}` is not a length"), "give a number with mm or in")),
        }
    };
    let missing =
        || fault(format!("{shown} has no `Diameter`"), "add it in FreeCAD").with_code(ErrorCode::MissingKey);
    let diameter = length("Diameter")?.ok_or_else(missing)?;
    let mut notes = Vec::new();
    let flute = length("CuttingEdgeHeight")?;
    let total = length("Length")?;
    let overhang = total.unwrap_or_else(|| {
        notes.push("overhang assumed: 4 diameters".to_owned());
        OVERHANG_DIAMETERS * diameter
    });
    if total.is_some() {
        notes.push("overhang assumed: the whole length of the tool".to_owned());
    }
    let flute = flute.map(|flute| flute.min(overhang));
    let shank = match (length("ShankDiameter")?, flute) {
        (Some(shank), Some(flute)) if flute < overhang => vec![[shank, overhang - flute]],
        _ => Vec::new(),
    };
    let corner = match shape.starts_with("ball") {
        true => 0.5 * diameter,
        false => length("CornerRadius")?.or(length("TorusRadius")?).unwrap_or(0.0),
    };
    let face = shape.starts_with("face");
    let insert_width = if face { 0.45 * diameter } else { 0.5 * diameter };
    notes.push(match face {
        true => format!("insert width assumed: {insert_width} mm, 0.45 of the diameter"),
        false => "insert width assumed: the cutter cuts to its centre".to_owned(),
    });
    notes.push("feed and spindle speed assumed: 300 mm/min, 1200 rev/min; the holder is unknown".to_owned());
    let teeth = parameters.get("Flutes").and_then(|flutes| match flutes {
        Value::Number(number) => number.as_u64(),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    });
    let tool = Tool {
        number: number.unwrap_or(1),
        diameter,
        corner_radius: corner.min(0.5 * diameter),
        insert_width,
        overhang,
        plunge_feed: 300.0,
        spindle: 1200.0,
        assembly: ToolAssembly {
            name: short_name(title),
            flute_length: flute,
            teeth: teeth.and_then(|n| u32::try_from(n).ok()).filter(|n| (1..=MAX_TEETH).contains(n)),
            shank,
            ..ToolAssembly::default()
        },
    };
    check_tool(&tool).map_err(|what| fault(format!("{shown}: {what}"), "correct it in FreeCAD"))?;
    library.tools.push(LibraryTool { tool, notes });
    Ok(library)
}

/// Reads a library and the tool bits it names.
///
/// # Errors
/// When the bytes are not a library, or none of its tool bits can be taken over. One that cannot be read beside
/// others is left out, with a note.
pub(super) fn read_list(name: &str, bytes: &[u8], beside: &ReadBeside) -> Result<ToolLibrary, InputError> {
    let fault = |what: String, help: &str| Source::new(name, ErrorCode::ToolFile).fault(0, what, help);
    let tree = parse_json(name, bytes)?;
    let list = tree.get("tools").and_then(Value::as_array);
    let list =
        list.ok_or_else(|| fault("has no list `tools`".to_owned(), "give a tool library of FreeCAD"))?;
    too_many(name, list.len().min(MAX_TOOLS + 1))?;
    let mut library = ToolLibrary::default();
    // The first error of a tool bit. It becomes the error of the library if no bit can be read.
    let mut refused = None;
    for (index, entry) in list.iter().enumerate() {
        let file = entry.get("path").and_then(Value::as_str).ok_or_else(|| {
            fault(format!("tool {} has no `path`", index + 1), "correct it in FreeCAD")
                .with_code(ErrorCode::MissingKey)
        })?;
        // Only files beside the library: no folder above it, no absolute path.
        if file.contains(['/', '\\', ':']) || !file.to_lowercase().ends_with(".fctb") {
            let what =
                format!("tool {} is in {}, not a .fctb file beside it", index + 1, quote_for_message(file));
            return Err(fault(what, "copy the tool bits into the folder of the library"));
        }
        let number = entry.get("nr").and_then(Value::as_u64).and_then(|n| u32::try_from(n).ok());
        let number = number.filter(|n| (1..=MAX_NUMBER).contains(n)).unwrap_or(0);
        match beside(file).and_then(|(bit, bytes)| read_bit(&bit, &bytes, Some(number))) {
            Ok(read) => {
                library.tools.extend(read.tools);
                library.notes.extend(read.notes);
            }
            Err(error) => {
                library.leave_out(&quote_for_message(file), &error.message);
                refused.get_or_insert(error);
            }
        }
    }
    if library.tools.is_empty() {
        let none = || fault("contains no end mill".to_owned(), "give a library with end mills");
        return Err(refused.unwrap_or_else(none));
    }
    number_tools(&mut library);
    round_lengths(&mut library);
    Ok(library)
}

/// A length with its unit, mm; without unit it is in mm.
fn length_mm(text: &str) -> Option<f64> {
    let text = text.trim();
    let end =
        text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+'))).unwrap_or(text.len());
    let value: f64 = text.get(..end)?.parse().ok()?;
    let factor = match text.get(end..)?.trim() {
        "" | "mm" => 1.0,
        "cm" => 10.0,
        "m" => 1000.0,
        "in" | "\"" => 25.4,
        "ft" | "'" => 304.8,
        "µm" | "um" => 1e-3,
        _ => return None,
    };
    Some(value * factor)
}
