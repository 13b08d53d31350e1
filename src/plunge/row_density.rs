//! How closely `minimal` places its rows and the plunges in them.

use super::spacing::{max_shroud_spacing, step_limit, stepover};
use crate::setup::{PlungeSetup, Tool};

/// How closely `minimal` places its rows and the plunges in them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowDensity {
    /// As close as the least stock asks for: a row more beside each wall that leans over the channel, and
    /// steps with a reserve to the insert width.
    #[default]
    Dense,
    /// For a plan in less time: no such rows, those there are as far apart as cut without stock between them,
    /// and steps up to the whole insert width.
    Sparse,
}

impl RowDensity {
    /// Whether a row is inserted beside walls that lean over the channel.
    pub(super) fn has_rows_beside_walls(self) -> bool {
        self == Self::Dense
    }

    /// Maximum distance of rows on the hub, mm; see [`stepover`]. A stepover of the setup always holds.
    pub(super) fn stepover(self, plunge: &PlungeSetup, tool: &Tool) -> f64 {
        if self == Self::Dense || plunge.stepover.is_some() {
            stepover(plunge, tool)
        } else {
            max_shroud_spacing(tool)
        }
    }

    /// Upper limit of the step along a row, mm; see [`step_limit`]. A step of the setup always holds.
    pub(super) fn step_limit(self, plunge: &PlungeSetup, tool: &Tool, wall_row: bool) -> f64 {
        if self == Self::Dense || plunge.step.is_some() {
            return step_limit(plunge, tool, wall_row);
        }
        step_limit(&PlungeSetup { step: Some(tool.insert_width), ..plunge.clone() }, tool, wall_row)
    }
}
