//! The solid that the views show of the plans, or of a checked program.

use std::sync::Arc;

use super::AppState;
use crate::app::model::flank_run::FlankRun;
use crate::app::model::look::Operation;
use crate::app::model::planned::Side;
use crate::app::model::shown_channels::ShownChannels;
use crate::app::model::solid::{PlannedSolid, SolidRequest, SolidSource, StockMoment};

impl AppState {
    /// The solid to show on a side; `None` if the layer is hidden or there is nothing
    /// that cuts it.
    pub fn wanted_solid(&self, side: Side) -> Option<SolidRequest> {
        if !(self.look.layers.stock && self.shows(side)) {
            return None;
        }
        let source = self.solid_source(side)?;
        Some(SolidRequest { moment: self.stock_moment(&source), source, colours: self.look.solid_colours })
    }

    /// The stock at the position of the timeline: flank passes follow the whole plunge plan.
    pub fn stock_moment(&self, source: &SolidSource) -> StockMoment {
        let plans = match source {
            SolidSource::Plans(plans) => plans,
            SolidSource::Program(_) => {
                return self.look.program_cut.map_or(StockMoment::End, StockMoment::Moves);
            }
        };
        match (&plans.flank, self.look.flank.cut, self.look.cut_count) {
            (Some(_), Some(moves), _) => StockMoment::FlankMoves(moves),
            (None, ..) if plans.channels > 1 => {
                self.look.channels_cut.map_or(StockMoment::End, StockMoment::Plunges)
            }
            (None, _, Some(plunges)) => StockMoment::Plunges(plunges),
            _ => StockMoment::End,
        }
    }

    /// What the stock of a side is left by: its plunge plan, and after it the flank plan while its passes are
    /// shown; the checked program where that is selected.
    pub fn solid_source(&self, side: Side) -> Option<SolidSource> {
        if self.look.operation == Operation::Program {
            return self.results.checked.clone().map(SolidSource::Program);
        }
        let shown = self.last_whole_plan(side)?;
        let same_part = |flank: &&Arc<FlankRun>| {
            Arc::ptr_eq(&flank.outcome.workpiece.part, &shown.planned.outcome.workpiece.part)
        };
        let flank = self.shown_flank_run().filter(same_part).cloned();
        let channels = match &flank {
            Some(flank) => flank.count(),
            None => self.shown_channels().map_or(1, ShownChannels::count),
        };
        let planned = Arc::clone(shown.planned);
        Some(SolidSource::Plans(PlannedSolid { planned, policy: shown.policy, channels, flank }))
    }
}
