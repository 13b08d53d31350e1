//! The solid that the views show of the plans.

use std::sync::Arc;

use super::AppState;
use crate::app::model::flank_run::FlankRun;
use crate::app::model::planned::Side;
use crate::app::model::shown_channels::ShownChannels;
use crate::app::model::solid::{SolidRequest, SolidSource, StockMoment};

impl AppState {
    /// The solid to show on a side; `None` if the layer is hidden or there is no plan.
    pub fn wanted_solid(&self, side: Side) -> Option<SolidRequest> {
        if !(self.look.layers.stock && self.shows(side)) {
            return None;
        }
        let source = self.solid_source(side)?;
        Some(SolidRequest { moment: self.stock_moment(&source), source, colours: self.look.solid_colours })
    }

    /// The stock at the position of the timeline: flank passes follow the whole plunge plan.
    pub fn stock_moment(&self, source: &SolidSource) -> StockMoment {
        match (&source.flank, self.look.flank.cut, self.look.cut_count) {
            (Some(_), Some(moves), _) => StockMoment::FlankMoves(moves),
            (None, ..) if source.channels > 1 => {
                self.look.channels_cut.map_or(StockMoment::End, StockMoment::Plunges)
            }
            (None, _, Some(plunges)) => StockMoment::Plunges(plunges),
            _ => StockMoment::End,
        }
    }

    /// The plans whose stock a side shows: its plunge plan, and after it the flank plan while its passes are
    /// shown.
    pub fn solid_source(&self, side: Side) -> Option<SolidSource> {
        let shown = self.last_whole_plan(side)?;
        let same_part = |flank: &&Arc<FlankRun>| {
            Arc::ptr_eq(&flank.outcome.workpiece.part, &shown.planned.outcome.workpiece.part)
        };
        let flank = self.shown_flank_run().filter(same_part).cloned();
        let channels = match &flank {
            Some(flank) => flank.count(),
            None => self.shown_channels().map_or(1, ShownChannels::count),
        };
        Some(SolidSource { planned: Arc::clone(shown.planned), policy: shown.policy, channels, flank })
    }
}
