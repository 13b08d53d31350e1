//! The keys of the tables of a setup, each with the unit of its value.

use crate::io::table::RenamedKeys;
use crate::io::tool_file::TOOL_KEYS;

/// Keys of a table, each with its unit, which is empty where it has none.
pub(super) type KeyUnits<const N: usize> = [(&'static str, &'static str); N];

/// `[stock]`.
pub(super) const STOCK_KEYS: KeyUnits<7> = [
    ("hub_allowance", "mm"),
    ("blade_allowance", "mm"),
    ("safety_distance", "mm"),
    ("inlet_extension", "mm"),
    ("blank", ""),
    ("blank_outline", "mm"),
    ("material", ""),
];
/// `[clearance]`.
pub(super) const CLEARANCE_KEYS: KeyUnits<2> = [("shank", "mm"), ("holder", "mm")];
/// `[plunge]`.
pub(super) const PLUNGE_KEYS: KeyUnits<19> = [
    ("axis", ""),
    ("step", "mm"),
    ("stepover", "mm"),
    ("wall_scallop", "mm"),
    ("max_axis_change", "°"),
    ("max_tilt", "°"),
    ("lead_out", "mm"),
    ("peck", "mm"),
    ("adapt_feed", ""),
    ("rapid_approach", ""),
    ("rest", ""),
    ("section", ""),
    ("edit", ""),
    ("goal", ""),
    ("max_time", "min"),
    ("max_stock", "mm"),
    ("finish_rate", "mm³/min"),
    ("finish_depth", "mm"),
    ("finish_pass_time", "min"),
];
/// `[[plunge.section]]`.
pub(super) const SECTION_KEYS: KeyUnits<6> =
    [("tool", ""), ("from", ""), ("to", ""), ("cutting_direction", ""), ("rest", ""), ("opening", "")];
/// `[flank]`.
pub(super) const FLANK_KEYS: KeyUnits<10> = [
    ("tool", ""),
    ("scheme", ""),
    ("layer_depth", "mm"),
    ("scallop_height", "mm"),
    ("extension", "mm"),
    ("feed", "mm/min"),
    ("slot_feed", "mm/min"),
    ("wall_feed", "mm/min"),
    ("ramp_feed", "mm/min"),
    ("approach_feed", "mm/min"),
];
/// `[machine]`.
pub(super) const MACHINE_KEYS: KeyUnits<2> = [("file", ""), ("max_axis_tilt", "°")];

/// `[plunge]`: keys that were renamed in version 2.
pub(super) const RENAMED_IN_PLUNGE: RenamedKeys = &[("stepover", "row_spacing"), ("lead_out", "lift")];
/// `[[plunge.section]]`: keys that were renamed in version 2.
pub(super) const RENAMED_IN_SECTION: RenamedKeys = &[("cutting_direction", "feed")];
/// `[flank]`: keys that were renamed in version 2.
pub(super) const RENAMED_IN_FLANK: RenamedKeys = &[("scallop_height", "allowed_error")];

/// The unit of the value at a dotted path in a setup, such as `tool.1.diameter`; empty for a value
/// without a unit and for an unknown key. A renamed key has the same unit under both names.
pub fn unit_of_key(path: &str) -> &'static str {
    let (table, _) = path.split_once('.').unwrap_or_default();
    let name = path.rsplit('.').next().unwrap_or_default();
    let (keys, renamed): (&[(&str, &'static str)], RenamedKeys) = match table {
        "stock" => (&STOCK_KEYS, &[]),
        "clearance" => (&CLEARANCE_KEYS, &[]),
        "tool" => (&TOOL_KEYS, &[]),
        "plunge" if path.starts_with("plunge.section.") => (&SECTION_KEYS, RENAMED_IN_SECTION),
        "plunge" => (&PLUNGE_KEYS, RENAMED_IN_PLUNGE),
        "flank" => (&FLANK_KEYS, RENAMED_IN_FLANK),
        "machine" => (&MACHINE_KEYS, &[]),
        _ => (&[], &[]),
    };
    let present = renamed.iter().find(|(_, former)| *former == name).map_or(name, |(present, _)| present);
    keys.iter().find(|(key, _)| *key == present).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::unit_of_key;

    #[test]
    fn units_are_found_by_table_and_key_and_by_former_names() {
        for (path, unit) in [
            ("plunge.step", "mm"),
            ("plunge.row_spacing", "mm"),
            ("plunge.max_tilt", "°"),
            ("plunge.finish_rate", "mm³/min"),
            ("plunge.section.1.from", ""),
            ("tool.1.diameter", "mm"),
            ("tool.2.cutting_speed", "m/min"),
            ("machine.max_axis_tilt", "°"),
            ("flank.allowed_error", "mm"),
            ("flank.step", ""),
            ("part", ""),
        ] {
            assert_eq!(unit_of_key(path), unit, "{path}");
        }
    }
}
