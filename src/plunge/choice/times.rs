//! How long the moves of a plunge take, in the estimates of a choice: by feed rate and rapid, or on a
//! machine.

use crate::machine::MachineTool;
use crate::setup::Tool;
use crate::toolpath::{RAPID_MM_PER_MIN, TOOL_CHANGE_S};

/// A plunge with the moves to the next one, mm and rad.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlungeMoves {
    /// Length of the plunge, and of its retract.
    pub length: f64,
    /// Length of the link to the next plunge.
    pub link: f64,
    /// Turn of the tool axis in that link.
    pub turn_rad: f64,
}

/// Tells how long moves take. The default knows no machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct MoveTimes<'a> {
    machine: Option<&'a MachineTool>,
}

impl<'a> MoveTimes<'a> {
    /// Times on `machine`: each move begins and ends at rest, as plunges do, and the slower of its axes
    /// counts.
    pub fn on(machine: Option<&'a MachineTool>) -> Self {
        Self { machine }
    }

    /// Time of a tool change, s.
    pub fn tool_change_s(self) -> f64 {
        self.machine.map_or(TOOL_CHANGE_S, |machine| machine.tool_change_s)
    }

    /// Time of a plunge of `tool` with its retract and its link, s.
    pub fn plunge_s(self, tool: &Tool, moves: &PlungeMoves) -> f64 {
        let PlungeMoves { length, link, turn_rad } = *moves;
        let Some(machine) = self.machine else {
            return 60.0 * (length / tool.plunge_feed + (length + link) / RAPID_MM_PER_MIN);
        };
        let rate = machine.links.rate;
        machine.straight_s(length, tool.plunge_feed)
            + machine.straight_s(length, rate)
            + machine.straight_s(link, rate).max(machine.turn_s(turn_rad))
    }
}
