//! The solid that the views show of the plans.

use std::sync::Arc;

use super::AppState;
use crate::app::model::planned::Side;
use crate::app::model::solid::{SolidRequest, SolidSource};
use crate::job::flank::FlankOutcome;

impl AppState {
    /// The solid that the layer shows on a side now; `None` while it is hidden or there is no plan.
    pub fn wanted_solid(&self, side: Side) -> Option<SolidRequest> {
        if !(self.look.layers.stock && self.shows(side)) {
            return None;
        }
        let source = self.solid_source(side)?;
        // The flank passes follow the whole plunge plan.
        let cut = self.look.cut_count.filter(|_| source.flank.is_none());
        Some(SolidRequest { source, cut, colours: self.look.solid_colours })
    }

    /// The plans whose stock a side shows: its plunge plan, and after it the flank plan while its passes are
    /// shown.
    pub fn solid_source(&self, side: Side) -> Option<SolidSource> {
        let shown = self.last_whole_plan(side)?;
        let same_part = |flank: &&Arc<FlankOutcome>| {
            Arc::ptr_eq(&flank.workpiece.part, &shown.planned.outcome.workpiece.part)
        };
        let flank = self.shown_flank().map(|(outcome, _)| outcome).filter(same_part).cloned();
        Some(SolidSource { planned: Arc::clone(shown.planned), policy: shown.policy, flank })
    }
}
