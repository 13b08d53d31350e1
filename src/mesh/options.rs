//! What a user may say about a mesh file: roles, unit, axis, number of blades, sense of rotation.

use std::str::FromStr;

use super::axis::Axis;
use super::{Role, TriangleMesh};
use crate::geometry::Point;
use crate::part::{PartError, Rotation};

/// Diameters of impellers, mm.
const DIAMETERS: std::ops::RangeInclusive<f64> = 3.0..=5000.0;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Unit {
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

impl Unit {
    /// All of them, those that files are in most often first.
    pub const ALL: [Self; 4] = [Self::Millimetre, Self::Inch, Self::Centimetre, Self::Metre];

    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
        }
    }

    /// Millimetres in it.
    pub fn mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
        }
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.to_lowercase();
        let known = Self::ALL.into_iter().find(|unit| unit.name() == lower);
        known.ok_or_else(|| format!("`{text}` is no unit; give mm, cm, m or in"))
    }
}

/// What a user says about a mesh file.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshOptions {
    /// Roles by the name of a node, or by `#` and its number; they come before what names tell.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub roles: Vec<(String, Role)>,
    /// Unit of the file's numbers, if it is not the format's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<Unit>,
    /// Axis of rotation in the file's frame; otherwise found from the hub.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<Axis>,
    /// Number of main blades, if the meshes do not tell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blades: Option<usize>,
    /// Sense of rotation, and with it which sides of the blades lead; otherwise what the file says, else told from the
    /// blades' wrap.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<Rotation>,
}

/// The unit that numbers are in whose wheel is `across` of them wide: `own` (that of the format) where it gives a wheel
/// of a possible size, else the first that does.
pub fn likely_unit(across: f64, own: Unit) -> Option<Unit> {
    let possible = |unit: &Unit| DIAMETERS.contains(&(across * unit.mm()));
    Some(own).filter(possible).or_else(|| Unit::ALL.into_iter().find(possible))
}

/// A wheel has a size that is possible: `meshes` in the unit `given`, or else in `own`.
pub(super) fn check_size<'a>(
    meshes: impl Iterator<Item = &'a TriangleMesh>,
    own: Unit,
    given: Option<Unit>,
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
    let cure = match likely_unit(across, own) {
        Some(Unit::Millimetre) => {
            format!("give --unit mm (it would be {across:.4} mm), or cm or in, whichever its numbers are")
        }
        Some(unit) => format!(
            "give --unit {} (it would be {:.4} mm), if that is what its numbers are",
            unit.name(),
            across * unit.mm()
        ),
        None => "scale the file to its true size".to_owned(),
    };
    Err(PartError::new(
        0,
        format!("the wheel would be {shown} across, which is no size of an impeller"),
        cure,
    ))
}
