//! Options for reading a mesh file: roles, unit, axis, number of blades, sense of rotation.

use std::str::FromStr;

use super::Role;
use super::axis::Axis;
use crate::error::{ErrorCode, UserError};
use crate::part::{PartError, Rotation};

/// Plausible diameters of impellers, mm.
const DIAMETERS: std::ops::RangeInclusive<f64> = 3.0..=5000.0;
/// Usual diameters of impellers, mm.
const USUAL_DIAMETERS: std::ops::RangeInclusive<f64> = 15.0..=1500.0;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum LengthUnit {
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
    /// Centimetres.
    #[serde(rename = "cm")]
    Centimetre,
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Inches.
    #[serde(rename = "in")]
    Inch,
}

impl LengthUnit {
    /// All units, the most common in files first.
    pub const ALL: [Self; 4] = [Self::Millimetre, Self::Inch, Self::Centimetre, Self::Metre];

    /// Its symbol.
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
        }
    }

    /// Its length in millimetres.
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
        }
    }
}

/// What the format of a file says of the unit of its coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileUnit {
    /// The file states it, and is read in mm.
    Stated,
    /// The specification of the format names this unit, which not all programs keep to.
    Specified(LengthUnit),
    /// The format has none; this one is assumed.
    Assumed(LengthUnit),
}

impl FileUnit {
    /// The unit in which coordinates are read where no other is given.
    pub fn own(self) -> LengthUnit {
        match self {
            Self::Stated => LengthUnit::Millimetre,
            Self::Specified(unit) | Self::Assumed(unit) => unit,
        }
    }
}

impl FromStr for LengthUnit {
    type Err = UserError;

    fn from_str(text: &str) -> Result<Self, UserError> {
        let lower = text.to_lowercase();
        let known = Self::ALL.into_iter().find(|unit| unit.name() == lower);
        known.ok_or_else(|| {
            UserError::new(ErrorCode::UnknownName, format!("`{text}` is not a unit"), "give mm, cm, m or in")
        })
    }
}

/// Options for reading a mesh file. All are optional: what is not given is derived from the file.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshOptions {
    /// Roles by the name of a node, or by `#` and its number; they take precedence over roles derived from
    /// names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub roles: Vec<(String, Role)>,
    /// Unit of the file's coordinates, if it is not the default of the format.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<LengthUnit>,
    /// Axis of rotation in the file's frame; by default found from the hub.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Number of main blades; by default found from the angles between the blades.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blades: Option<usize>,
    /// Sense of rotation, which decides which sides of the blades are the pressure sides; by default that of
    /// the file or, if it has none, derived from the wrap of the blades.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
}

/// Whether a wheel of this diameter, mm, is plausible.
pub fn is_plausible_size(across_mm: f64) -> bool {
    DIAMETERS.contains(&across_mm)
}

/// The units with which a wheel with a largest extent of `across` units has a plausible size: those with a
/// usual one first, else in the order of [`LengthUnit::ALL`].
fn possible_units(across: f64) -> Vec<LengthUnit> {
    let size = |unit: &LengthUnit| across * unit.mm();
    let mut units: Vec<LengthUnit> =
        LengthUnit::ALL.into_iter().filter(|unit| is_plausible_size(size(unit))).collect();
    units.sort_by_key(|unit| !USUAL_DIAMETERS.contains(&size(unit)));
    units
}

/// The likely unit of a wheel with a largest extent of `across` units: `own` (that of the format) where the
/// size is plausible, else the most plausible one.
pub fn likely_unit(across: f64, own: LengthUnit) -> Option<LengthUnit> {
    let possible = possible_units(across);
    if possible.contains(&own) { Some(own) } else { possible.first().copied() }
}

/// The fault of a wheel that is `across` units across, one of which is `unit_mm` long, where that is not
/// plausible; its help names the units that are possible.
pub fn size_fault(across: f64, unit_mm: f64) -> Option<PartError> {
    let size = across * unit_mm;
    if is_plausible_size(size) {
        return None;
    }
    let shown = if size >= 1e4 { format!("{:.4} m", size / 1e3) } else { format!("{size:.4} mm") };
    let possible: Vec<String> = possible_units(across)
        .iter()
        .map(|unit| format!("{} ({:.4} mm)", unit.name(), across * unit.mm()))
        .collect();
    let help = match possible.as_slice() {
        [] => "scale the file to its true size".to_owned(),
        [one] => format!("give --unit {one}, if the file uses that unit"),
        [most @ .., last] => {
            format!("give --unit {} or {last}, whichever the file uses", most.join(", "))
        }
    };
    let what = format!("the wheel would be {shown} across, which is not a plausible size of an impeller");
    Some(PartError::new(ErrorCode::MeshUnit, 0, what, help))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_plausible_unit_comes_first_and_all_are_named() {
        for (across, own, likely) in [
            (0.16, LengthUnit::Millimetre, LengthUnit::Metre),
            (160.0, LengthUnit::Metre, LengthUnit::Millimetre),
            (6.3, LengthUnit::Metre, LengthUnit::Inch),
            (6.3, LengthUnit::Millimetre, LengthUnit::Millimetre),
            (0.02, LengthUnit::Millimetre, LengthUnit::Metre),
        ] {
            assert_eq!(likely_unit(across, own), Some(likely), "{across}");
        }
        assert_eq!(likely_unit(1e-6, LengthUnit::Millimetre), None);
        let fault = size_fault(0.16, 1.0).expect("0.16 mm");
        assert!(fault.help.contains("--unit m (160.0000 mm) or in (4.0640 mm)"), "{fault}");
        assert!(size_fault(0.16, 1000.0).is_none());
    }
}
