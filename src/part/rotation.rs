//! The sense in which a wheel turns.
//!
//! Impellers press on the fluid with the leading side of their blades: the pressure side. Along the flow,
//! blades run back against the sense of rotation: at the inlet to meet the incoming flow, at the outlet as
//! backsweep. So the wrap of a blade determines the sense of rotation, and that determines the sides, where a
//! file names neither.

use crate::error::{ErrorCode, UserError};
use std::fmt;
use std::str::FromStr;

/// Sense of rotation, seen from the inlet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
pub enum Rotation {
    /// Clockwise, seen from the inlet.
    #[serde(rename = "cw")]
    Clockwise,
    /// Counter-clockwise, seen from the inlet.
    #[serde(rename = "ccw")]
    Counterclockwise,
}

impl Rotation {
    /// Both senses.
    pub const ALL: [Self; 2] = [Self::Clockwise, Self::Counterclockwise];

    /// Sense of rotation of a wheel that turns about Z by `turn` (only its sign counts) and whose inlet is
    /// towards +Z if `inlet_up`.
    pub fn about_z(turn: f64, inlet_up: bool) -> Self {
        if (turn > 0.0) == inlet_up { Self::Counterclockwise } else { Self::Clockwise }
    }

    /// Sign of the turn about Z of a wheel whose inlet is towards +Z if `inlet_up`.
    pub fn sign_about_z(self, inlet_up: bool) -> f64 {
        if (self == Self::Counterclockwise) == inlet_up { 1.0 } else { -1.0 }
    }

    /// The opposite sense.
    #[must_use]
    pub fn reversed(self) -> Self {
        match self {
            Self::Clockwise => Self::Counterclockwise,
            Self::Counterclockwise => Self::Clockwise,
        }
    }

    /// Its keyword in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clockwise => "cw",
            Self::Counterclockwise => "ccw",
        }
    }
}

impl fmt::Display for Rotation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Clockwise => "clockwise",
            Self::Counterclockwise => "counter-clockwise",
        })
    }
}

impl FromStr for Rotation {
    type Err = UserError;

    fn from_str(text: &str) -> Result<Self, UserError> {
        let text = text.to_lowercase();
        let known = Self::ALL.into_iter().find(|rotation| rotation.name() == text);
        known.ok_or_else(|| {
            UserError::new(
                ErrorCode::UnknownName,
                format!("`{text}` is not a sense of rotation"),
                "give cw or ccw, as seen from the inlet",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Rotation;

    #[test]
    fn a_sense_is_that_of_its_own_sign() {
        for rotation in Rotation::ALL {
            for inlet_up in [false, true] {
                assert_eq!(Rotation::about_z(rotation.sign_about_z(inlet_up), inlet_up), rotation);
            }
            assert_eq!(rotation.name().parse(), Ok(rotation));
            assert_ne!(rotation.reversed(), rotation);
        }
        assert_eq!(Rotation::about_z(0.2, true), Rotation::Counterclockwise, "seen from +z, as angles grow");
        assert!("left".parse::<Rotation>().is_err());
    }
}
