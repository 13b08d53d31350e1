//! Faults of a setup: what is wrong, what to do, and the key where it is.

use super::Tool;
use crate::error::{ErrorCode, UserError};

/// Location of a fault in a setup, from which the reader of the file finds the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetupPlace {
    /// No particular key.
    Whole,
    /// The key `part`.
    Part,
    /// A key of `[stock]`.
    Stock(&'static str),
    /// A key of `[plunge]`.
    Plunge(&'static str),
    /// A key of `[flank]`.
    Flank(&'static str),
    /// The tool of this number.
    Tool(u32),
    /// A section by its index, or its tool where the sections are chosen automatically.
    Section {
        /// Index in the list of sections.
        index: usize,
        /// Number of its tool.
        tool: u32,
    },
}

/// Mismatch of a setup and a part.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}; {help}")]
pub struct SetupFault {
    /// Its kind.
    pub code: ErrorCode,
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: String,
    /// Where in the setup it is.
    pub place: SetupPlace,
}

impl SetupFault {
    /// A fault of the setup as a whole: its kind, what is wrong and how to fix it.
    pub fn new(code: ErrorCode, message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { code, message: message.into(), help: help.into(), place: SetupPlace::Whole }
    }

    /// The fault at `place`.
    pub fn at(self, place: SetupPlace) -> Self {
        Self { place, ..self }
    }
}

impl From<SetupFault> for UserError {
    fn from(fault: SetupFault) -> Self {
        Self::new(fault.code, fault.message, fault.help)
    }
}

/// The greatest number of `decimals` decimals that is not above `x`, for a limit in a message: a user who
/// enters what the message says stays within it.
pub fn round_down(x: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    (x * scale).floor() / scale
}

/// The least number of `decimals` decimals that is not below `x`; see [`round_down`].
pub fn round_up(x: f64, decimals: i32) -> f64 {
    -round_down(-x, decimals)
}

/// Checks that a tool is a cylinder: planners do not know the upper part of a tapered one.
///
/// # Errors
/// When it is tapered.
pub fn check_taper(tool: &Tool) -> Result<(), SetupFault> {
    if !tool.is_tapered() {
        return Ok(());
    }
    let degrees = tool.assembly.taper_rad.unwrap_or_default().to_degrees();
    let upper = tool.taper_cone().map_or(tool.diameter, |(_, _, radii)| 2.0 * radii[1]);
    Err(SetupFault::new(
        ErrorCode::UndefinedTool,
        format!(
            "tool {} widens by {degrees:.1}° above its tip, from D {} to D {upper:.1}; plans know \
             cylindrical cutters only",
            tool.number, tool.diameter
        ),
        "give a cylindrical tool; `verify` judges programs made for the tapered one elsewhere",
    )
    .at(SetupPlace::Tool(tool.number)))
}
