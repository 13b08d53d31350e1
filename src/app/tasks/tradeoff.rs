//! Time against stock of the shown plan, as `vanecut plan --pareto` has it, in the background.

use std::sync::Arc;

use super::Repaint;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::state::AppState;
use crate::app::tasks::latest::Latest;
use crate::monitor::Monitor;
use crate::setup::{AxisPolicy, Goal, Setup};
use crate::tradeoff::TradeoffPoint;

/// Number of points of the curve.
const POINTS: usize = 40;

/// A finished plan of `minimal`, whose plunges may be left out.
#[derive(Clone)]
struct TradeoffRequest {
    planned: Arc<DisplayPlan>,
    /// Its setup without the goal, on which the curve does not depend.
    setup: Setup,
}

impl TradeoffRequest {
    fn of(planned: &Arc<DisplayPlan>) -> Self {
        let mut setup = planned.setup.clone();
        setup.plunge.goal = Goal::default();
        // The curve is without edits by hand.
        setup.plunge.edits.clear();
        Self { planned: Arc::clone(planned), setup }
    }
}

impl PartialEq for TradeoffRequest {
    /// Parts are immutable, so pointer equality suffices for them.
    fn eq(&self, other: &Self) -> bool {
        let [part, same] = [self, other].map(|request| &request.planned.outcome.workpiece.part);
        Arc::ptr_eq(part, same) && self.setup == other.setup
    }
}

/// Finds the curve in the background, while it is shown.
pub(in crate::app) struct TradeoffWork {
    latest: Latest<TradeoffRequest, Arc<[TradeoffPoint]>>,
    /// The last request.
    asked: Option<TradeoffRequest>,
}

impl TradeoffWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let find = |TradeoffRequest { planned, .. }: &TradeoffRequest| {
            // Nothing cancels it; a newer request supersedes it.
            planned.outcome.time_stock_points(POINTS, &Monitor::default()).unwrap_or_default().into()
        };
        Self { latest: Latest::new("tradeoff", repaint, find), asked: None }
    }

    /// Requests the curve of the last finished plan, if it is `wanted`. While another is being planned the
    /// request stays: its drafts are not worth a curve.
    pub(in crate::app) fn follow(&mut self, state: &AppState, wanted: bool, is_planning: bool) {
        if !wanted {
            self.asked = None;
        } else if !is_planning {
            let planned = state.results.planned.as_ref();
            let planned =
                planned.filter(|p| p.setup.plunge.axis == AxisPolicy::Minimal && !p.is_unfinished());
            self.asked = planned.map(TradeoffRequest::of);
        }
        self.latest.request(self.asked.clone());
    }

    /// The curve, by falling time; `None` until it is known.
    pub(in crate::app) fn points(&self) -> Option<&Arc<[TradeoffPoint]>> {
        let (of, points) = self.latest.answer()?;
        self.asked.as_ref().filter(|asked| *asked == of).map(|_| points)
    }

    /// Whether a curve is being found.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.latest.is_busy()
    }
}
