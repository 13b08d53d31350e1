//! The stock as a solid that the views show: of which plans, after how many plunges, in which colours.

use std::sync::Arc;

use crate::app::model::planned::{DisplayPlan, Side};
use crate::app::model::state::AppState;
use crate::job::flank::FlankOutcome;
use crate::setup::AxisPolicy;

/// What the colours of the solid show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SolidColours {
    /// Distance of the cut surface to the finished part.
    #[default]
    Distance,
    /// The tool that cut it.
    Tool,
    /// The section of the plan that cut it.
    Section,
    /// Whether the plunge that cut it is sound, blocked, or meets stock with its core.
    Fault,
}

impl SolidColours {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Distance, Self::Tool, Self::Section, Self::Fault];

    /// Label in the list.
    pub fn label(self) -> &'static str {
        match self {
            Self::Distance => "Distance to part",
            Self::Tool => "Tool",
            Self::Section => "Section",
            Self::Fault => "Fault",
        }
    }
}

/// What is simulated: a plunge plan, and after it a flank plan.
#[derive(Clone, Debug)]
pub struct SolidSource {
    /// The set of plans.
    pub planned: Arc<DisplayPlan>,
    /// Policy of the plunge plan.
    pub policy: AxisPolicy,
    /// The flank plan that follows it.
    pub flank: Option<Arc<FlankOutcome>>,
}

impl PartialEq for SolidSource {
    /// Plans are immutable, so pointer equality suffices.
    fn eq(&self, other: &Self) -> bool {
        let flank = match (&self.flank, &other.flank) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        flank && self.policy == other.policy && Arc::ptr_eq(&self.planned, &other.planned)
    }
}

/// A state of the stock, with its colours.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidRequest {
    /// The plans.
    pub source: SolidSource,
    /// Number of plunges made; `None`: all, and the flank plan.
    pub cut: Option<usize>,
    /// Colours.
    pub colours: SolidColours,
}

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
