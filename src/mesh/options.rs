//! Options for reading a mesh file: roles, unit, axis, number of blades, sense of rotation.

use std::str::FromStr;

use super::axis::Axis;
use super::{Role, TriangleMesh};
use crate::error::{ErrorCode, UserError};
use crate::geometry::Point;
use crate::part::{PartError, Rotation};

/// Plausible diameters of impellers, mm.
const DIAMETERS: std::ops::RangeInclusive<f64> = 3.0..=5000.0;

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

/// The likely unit of a wheel with a largest extent of `across` units: `own` (that of the format) where the
/// size is plausible, else the most common unit with which it is.
pub fn likely_unit(across: f64, own: LengthUnit) -> Option<LengthUnit> {
    let possible = |unit: &LengthUnit| DIAMETERS.contains(&(across * unit.mm()));
    Some(own).filter(possible).or_else(|| LengthUnit::ALL.into_iter().find(possible))
}

/// Checks that a wheel has a plausible size: `meshes` in the unit `given`, or else in `own`.
///
/// # Errors
/// Fails when the largest extent is not in [`DIAMETERS`]; the help text proposes a unit.
pub(super) fn check_size<'a>(
    meshes: impl Iterator<Item = &'a TriangleMesh>,
    own: LengthUnit,
    given: Option<LengthUnit>,
) -> Result<(), PartError> {
    let (mut low, mut high) = (Point::from([f64::INFINITY; 3]), Point::from([f64::NEG_INFINITY; 3]));
    for p in meshes.flat_map(|m| &m.points) {
        low = low.inf(p);
        high = high.sup(p);
    }
    let across = (high - low).amax();
    let size = across * given.unwrap_or(own).mm();
    if DIAMETERS.contains(&size) {
        return Ok(());
    }
    let shown = if size >= 1e4 { format!("{:.4} m", size / 1e3) } else { format!("{size:.4} mm") };
    let help = match likely_unit(across, own) {
        Some(LengthUnit::Millimetre) => {
            format!("give --unit mm (it would be {across:.4} mm), or cm or in, whichever the file uses")
        }
        Some(unit) => format!(
            "give --unit {} (it would be {:.4} mm), if the file uses that unit",
            unit.name(),
            across * unit.mm()
        ),
        None => "scale the file to its true size".to_owned(),
    };
    Err(PartError::new(
        ErrorCode::MeshUnit,
        0,
        format!("the wheel would be {shown} across, which is not a plausible size of an impeller"),
        help,
    ))
}
