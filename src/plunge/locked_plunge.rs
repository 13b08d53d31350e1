//! A plunge that the user locked, as it is cut.

use super::placed_cutter::PlacedCutter;
use super::row::Station;
use crate::cutting::contact::{BlankTop, PlungeColumn};
use crate::setup::Tool;

/// A locked plunge of a section.
#[derive(Clone, Debug)]
pub(super) struct LockedPlunge {
    pub(super) station: Station,
    pub(super) cutter: PlacedCutter,
    /// λ in the channel.
    pub(super) lambda: f64,
}

impl LockedPlunge {
    pub(super) fn column(&self, tool: &Tool, top: &BlankTop) -> PlungeColumn {
        PlungeColumn::new(self.cutter.cutter, tool.core_radius(), top)
    }
}
