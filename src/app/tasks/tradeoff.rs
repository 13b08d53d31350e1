//! Time against stock of the shown plan, as `vanecut plan --pareto` has it: a task in the background with
//! progress, which can be cancelled.

use std::sync::Arc;

use super::Repaint;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::state::AppState;
use crate::job::worker::{Outcome, Worker};
use crate::monitor::{Cancelled, Monitor, Precedence};
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
    fn from_planned(planned: &Arc<DisplayPlan>) -> Self {
        let mut setup = planned.setup.clone();
        setup.plunge.goal = Goal::default();
        // The curve is without edits by hand, but around what is locked where the plan is.
        setup.plunge.edits.clone_from(&planned.outcome.kept_locked);
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

/// A curve, with the request that it answers.
type TradeoffCurve = (TradeoffRequest, Arc<[TradeoffPoint]>);

/// Finds the curve in the background, while it is shown. The last one is kept.
pub(in crate::app) struct TradeoffWork {
    worker: Worker<TradeoffRequest, TradeoffCurve, Cancelled>,
    /// The curve that is wanted.
    asked: Option<TradeoffRequest>,
    answer: Option<TradeoffCurve>,
    /// Whether the user cancelled the wanted one.
    was_cancelled: bool,
}

impl TradeoffWork {
    /// Starts the thread.
    pub(in crate::app) fn new(repaint: &Repaint, precedence: Precedence) -> Self {
        let find = |request: &TradeoffRequest, monitor: &Monitor| {
            let points = request.planned.outcome.time_stock_points(POINTS, monitor)?;
            Ok((request.clone(), points.into()))
        };
        let repaint = Arc::clone(repaint);
        let worker = Worker::ranked("tradeoff", precedence, find, move || repaint());
        Self { worker, asked: None, answer: None, was_cancelled: false }
    }

    /// Requests the curve of the last finished plan, if it is `wanted`. While another is being planned the
    /// request stays: its drafts are not worth a curve.
    pub(in crate::app) fn follow(&mut self, state: &AppState, wanted: bool, is_planning: bool) {
        if let Some((_, Outcome::Done(answer))) = self.worker.take_outcome() {
            self.answer = Some(answer);
        }
        if wanted && is_planning {
            return;
        }
        let planned = state.results.planned.as_ref().filter(|_| wanted);
        let planned = planned.filter(|p| p.setup.plunge.axis == AxisPolicy::Minimal && !p.is_unfinished());
        let asked = planned.map(TradeoffRequest::from_planned);
        if asked == self.asked {
            return;
        }
        self.asked = asked;
        self.start();
    }

    /// Finds the wanted curve, unless it is known.
    fn start(&mut self) {
        self.was_cancelled = false;
        self.worker.cancel();
        let _ = self.worker.take_outcome();
        if let Some(asked) = self.asked.as_ref().filter(|_| self.points().is_none()) {
            self.worker.submit(asked.clone());
        }
    }

    /// Cancels the search for the curve, until another is wanted or [`Self::restart`].
    pub(in crate::app) fn cancel(&mut self) {
        if self.worker.is_busy() {
            self.worker.cancel();
            self.was_cancelled = true;
        }
    }

    /// Finds the curve that was cancelled.
    pub(in crate::app) fn restart(&mut self) {
        self.start();
    }

    /// Whether the wanted curve was cancelled.
    pub(in crate::app) fn was_cancelled(&self) -> bool {
        self.was_cancelled
    }

    /// The curve, by falling time; `None` until it is known.
    pub(in crate::app) fn points(&self) -> Option<&Arc<[TradeoffPoint]>> {
        let (of, points) = self.answer.as_ref()?;
        self.asked.as_ref().filter(|asked| *asked == of).map(|_| points)
    }

    /// Progress of the search, 0…1; `None` while there is none.
    pub(in crate::app) fn progress(&self) -> Option<f64> {
        self.worker.progress()
    }

    /// Whether the search waits for what goes ahead of it.
    pub(in crate::app) fn is_held(&self) -> bool {
        self.worker.is_held()
    }

    /// Whether a curve is being found, or is not collected yet.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.worker.is_busy() || self.worker.has_outcome()
    }
}
