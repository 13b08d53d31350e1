//! Units of the tools and holders of Fusion libraries.

use serde_json::Value;

use crate::io::source::quote_for_message;

/// Share by which the length of an assembly may differ from that of its parts, where that tells a unit.
const GAUGE_SHARE: f64 = 0.02;

/// Size of a unit in mm.
pub(super) fn unit_mm(value: &Value, whose: &str) -> Result<f64, String> {
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

/// Size of the unit of the holder of a tool with this `geometry` in units of `mm`, and what was assumed where
/// the holder has none: the unit in which the assembly is as long as the library says, else that of the tool.
pub(super) fn holder_unit_mm(
    holder: &Value,
    geometry: &Value,
    mm: f64,
) -> Result<(f64, Option<String>), String> {
    if holder.get("unit").is_some() {
        return Ok((unit_mm(holder, "its holder")?, None));
    }
    let of_tool = |key: &str| Some(geometry.get(key)?.as_f64()? * mm);
    let said = || Some(of_tool("assemblyGaugeLength")? - of_tool("LB")?);
    let gauge = holder.get("gaugeLength").and_then(Value::as_f64);
    let by_length = said().zip(gauge).and_then(|(said, gauge)| {
        let fits = |unit: &f64| gauge > 0.0 && (gauge * unit - said).abs() < GAUGE_SHARE * said;
        [mm, 1.0, 25.4].into_iter().find(fits)
    });
    let unit = by_length.unwrap_or(mm);
    let name = if unit == 1.0 { "mm" } else { "inches" };
    let why = match by_length {
        Some(_) => "by the length of the assembly",
        None => "as the tool",
    };
    Ok((unit, Some(format!("holder without unit: {name} assumed, {why}"))))
}
