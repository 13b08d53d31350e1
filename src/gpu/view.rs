//! Standard views and the spheres they are fitted to.

use std::str::FromStr;

use crate::error::{ErrorCode, UserError};
use glam::Vec3;

/// Standard views.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The whole wheel from obliquely above the inlet, the active channel to the front.
    #[default]
    Iso,
    /// The whole wheel from the side, axis vertical.
    Front,
    /// The whole wheel along its axis, inlet towards the viewer.
    Top,
    /// The active channel, looking onto its floor.
    Channel,
    /// The n-th section of the plan, counted from 1.
    Section(usize),
}

impl FromStr for View {
    type Err = UserError;

    fn from_str(word: &str) -> Result<Self, UserError> {
        let unknown = || {
            let help = "use iso, front, top, channel or section:K with K counted from 1";
            UserError::new(ErrorCode::UnknownName, format!("unknown view \"{word}\""), help)
        };
        Ok(match word {
            "iso" => Self::Iso,
            "front" => Self::Front,
            "top" => Self::Top,
            "channel" => Self::Channel,
            _ => {
                let number = word.strip_prefix("section:").ok_or_else(unknown)?;
                match number.parse() {
                    Ok(k) if k >= 1 => Self::Section(k),
                    _ => return Err(unknown()),
                }
            }
        })
    }
}

/// Target of a view: a bounding sphere and the direction to look from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewTarget {
    /// Centre of the sphere, mm.
    pub center: Vec3,
    /// Radius of the sphere, mm.
    pub radius: f32,
    /// Unit vector from the centre towards the viewer.
    pub from: Vec3,
}

/// Targets of the standard views of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewTargets {
    /// The whole wheel; `from` is the iso direction.
    pub wheel: ViewTarget,
    /// The active channel.
    pub channel: ViewTarget,
    /// Sections of the plan, in cutting order.
    pub sections: Vec<ViewTarget>,
    /// Points on the wheel that the whole-wheel views are fitted to.
    pub wheel_outline: Vec<Vec3>,
    /// Points on the active channel that the channel view is fitted to.
    pub channel_outline: Vec<Vec3>,
    /// +1 when the inlet is at the upper end of Z, −1 when it is at the lower end.
    pub up_sign: f32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_parse_from_the_command_lines_words() {
        assert_eq!("iso".parse(), Ok(View::Iso));
        assert_eq!("section:3".parse(), Ok(View::Section(3)));
        for word in ["section:0", "section:", "section:x", "Iso", ""] {
            let error = word.parse::<View>().expect_err(word);
            assert_eq!(error.code, ErrorCode::UnknownName, "{error}");
        }
    }
}
