//! How closely `minimal` places its rows and the plunges in them.

use super::spacing::step_limit;
use crate::setup::{PlungeSetup, Tool};

/// How closely `minimal` places its rows and the plunges in them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowDensity {
    /// As close as the least stock asks for: a row more beside each wall that leans over the channel, and
    /// steps with a reserve to the insert width.
    #[default]
    Dense,
    /// For a plan in less time: no such rows, and steps up to the whole insert width.
    Sparse,
}

impl RowDensity {
    /// Whether a row is inserted beside walls that lean over the channel.
    pub(super) fn has_rows_beside_walls(self) -> bool {
        self == Self::Dense
    }

    /// Upper limit of the step along a row, mm; see [`step_limit`]. A step of the setup always holds.
    pub(super) fn step_limit(self, plunge: &PlungeSetup, tool: &Tool, wall_row: bool) -> f64 {
        if self == Self::Dense || plunge.step.is_some() {
            return step_limit(plunge, tool, wall_row);
        }
        step_limit(&PlungeSetup { step: Some(tool.insert_width), ..plunge.clone() }, tool, wall_row)
    }
}
